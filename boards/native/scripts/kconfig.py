# SPDX-License-Identifier: Apache-2.0
"""Merge configuration fragments over the Kconfig tree into .config and autoconf.h.

What Zephyr's own build does with Kconfig and prj.conf, for the native board. An assignment that
does not take effect (unknown symbol, unmet dependency, value out of range) is an error.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

import kconfiglib  # type: ignore[import-not-found, import-untyped]


def check_assignments(kconf: kconfiglib.Kconfig) -> list[str]:
    """One line for each assigned symbol whose value is not the one that was asked for."""
    errors = []
    for sym in kconf.unique_defined_syms:
        if sym.user_value is None:
            continue
        wanted = sym.user_value
        if sym.type in (kconfiglib.BOOL, kconfiglib.TRISTATE):
            wanted = kconfiglib.TRI_TO_STR[wanted]
        if sym.str_value != wanted:
            needs = kconfiglib.expr_str(sym.direct_dep)
            errors.append(
                f"CONFIG_{sym.name} was set to {wanted} but is {sym.str_value or 'absent'}; "
                f"it depends on: {needs}"
            )
    return errors


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kconfig", type=Path, required=True, help="top-level Kconfig file")
    parser.add_argument("--srctree", type=Path, required=True, help="where Kconfig.zephyr lies")
    parser.add_argument("--out", type=Path, required=True, help="folder for .config, autoconf.h")
    parser.add_argument("--sources", type=Path, required=True, help="list of files that were read")
    parser.add_argument("fragments", nargs="+", type=Path, help=".conf files, later ones win")
    args = parser.parse_args()

    os.environ["srctree"] = str(args.srctree)  # noqa: SIM112, kconfiglib reads it so
    try:
        kconf = kconfiglib.Kconfig(str(args.kconfig), warn_to_stderr=False)
        kconf.warn_assign_override = False
        kconf.warn_assign_redun = False
        for index, fragment in enumerate(args.fragments):
            kconf.load_config(str(fragment), replace=index == 0)
    except (kconfiglib.KconfigError, OSError) as error:
        print(f"kconfig: {error}", file=sys.stderr)
        return 1

    errors = list(kconf.warnings) + check_assignments(kconf)
    for error in errors:
        print(f"kconfig: {error}", file=sys.stderr)
    if errors:
        return 1

    args.out.mkdir(parents=True, exist_ok=True)
    kconf.write_config(str(args.out / ".config"))
    kconf.write_autoconf(str(args.out / "autoconf.h"))
    read = [
        args.srctree / name if not os.path.isabs(name) else Path(name)
        for name in kconf.kconfig_filenames
    ]
    args.sources.write_text("\n".join(str(path) for path in [*read, *args.fragments]) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
