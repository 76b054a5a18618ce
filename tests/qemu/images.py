# SPDX-License-Identifier: Apache-2.0
"""Build the firmware's images with the Zephyr of ZEPHYR_BASE, and print what they take.

    .venv/bin/python tests/qemu/images.py [IMAGE...]

ZEPHYR_MODULES names the modules, as paths with semicolons between, unless Zephyr is in a west
workspace. The images go to build/zephyr-VERSION/IMAGE; the table is that of docs/boards.md. Fails
where one does not build, or takes more than its budget.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "budget"))

import image  # noqa: E402

NEW_NAMES = (3, 6, 99)  # of boards


@dataclass(frozen=True)
class Target:
    board: str
    options: tuple[str, ...] = ()
    flash_kib: int | None = None
    ram_kib: int | None = None


BOOT = ("-DEXTRA_CONF_FILE=mcuboot.conf",)
SMALL = ("-DEXTRA_CONF_FILE=minimal.conf",)
STAND_IN = ("-DEXTRA_DTC_OVERLAY_FILE=boards/adc_fixed.overlay",)

TARGETS = {
    "g474": Target("nucleo_g474re", flash_kib=192, ram_kib=64),
    "g474-mcuboot": Target("nucleo_g474re", BOOT, flash_kib=192, ram_kib=64),
    "g474-minimal": Target("nucleo_g474re", SMALL, flash_kib=96, ram_kib=32),
    "lamp": Target("pharos_lamp"),
    "lamp-mcuboot": Target("pharos_lamp", BOOT),
    "lamp-minimal": Target("pharos_lamp", SMALL),
    "h743": Target("nucleo_h743zi"),
    "h743-mcuboot": Target("nucleo_h743zi", BOOT),
    "mps2": Target("mps2_an385"),
    "mps2-minimal": Target("mps2_an385", SMALL),
    "f405": Target("olimex_stm32_h405"),
    "f405-stand-in": Target("olimex_stm32_h405", STAND_IN),
    "native": Target("native_posix_64"),
}

# The images that are run, and by which tests.
IN_QEMU = {
    "mps2": ("tests/system", "tests/qemu"),
    "mps2-minimal": ("tests/qemu",),
    "f405": ("tests/qemu",),
    "f405-stand-in": ("tests/qemu",),
}


def zephyr_version(base: Path) -> tuple[int, int, int]:
    """Of a tree: 4.1.99 is on its way to 4.2."""
    fields = dict(re.findall(r"^(\w+) *= *(\d+)", (base / "VERSION").read_text(), re.MULTILINE))
    return int(fields["VERSION_MAJOR"]), int(fields["VERSION_MINOR"]), int(fields["PATCHLEVEL"])


def board_name(board: str, version: tuple[int, int, int]) -> str:
    """As that version calls it."""
    renamed = {"mps2_an385": "mps2/an385", "native_posix_64": "native_sim/native/64"}
    return renamed.get(board, board) if version >= NEW_NAMES else board


def environment(board: str) -> dict[str, str]:
    """Debian's compilers, unless the environment names others."""
    found = dict(os.environ)
    # With it the files that assertions tell have other, longer names.
    found.pop("CCACHE_BASEDIR", None)
    if board.startswith("native"):
        found["ZEPHYR_TOOLCHAIN_VARIANT"] = "host"
    elif "ZEPHYR_TOOLCHAIN_VARIANT" not in found:
        # Zephyr looks for the compiler by its path alone, not along PATH.
        compiler = shutil.which("arm-none-eabi-gcc")
        if compiler is None:
            raise SystemExit("images: no arm-none-eabi-gcc; install gcc-arm-none-eabi")
        found |= {
            "ZEPHYR_TOOLCHAIN_VARIANT": "cross-compile",
            "CROSS_COMPILE": compiler.removesuffix("gcc"),
        }
    return found


def folder(name: str) -> Path:
    version = zephyr_version(Path(os.environ["ZEPHYR_BASE"]))
    return ROOT / "build" / "zephyr-{}.{}.{}".format(*version) / name


def build(name: str) -> bool:
    target, out = TARGETS[name], folder(name)
    version = zephyr_version(Path(os.environ["ZEPHYR_BASE"]))
    command = ["cmake", "-G", "Ninja", "-B", str(out), "-S", str(ROOT)]
    command += [f"-DBOARD={board_name(target.board, version)}", *target.options]
    if "ZEPHYR_MODULES" in os.environ:
        command.append(f"-DZEPHYR_MODULES={os.environ['ZEPHYR_MODULES']}")
    env = environment(target.board)
    for step in (command, ["cmake", "--build", str(out), "--", "--quiet"]):
        done = subprocess.run(
            step, env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False
        )
        if done.returncode:
            print(done.stdout[-4000:], file=sys.stderr)
            return False
    return True


def measured(name: str) -> tuple[str, list[str]]:
    """Its row, and what is wrong with it."""
    target = TARGETS[name]
    if target.board.startswith("native"):
        return f"| {name} | built | | | |", []
    found = image.measure(folder(name))
    ours = [found.use[group] for group in image.OURS if group in found.use]
    row = [found.total.flash, sum(use.flash for use in ours)]
    row += [found.total.ram, sum(use.ram for use in ours)]
    wrong = [f"{name}: {forbidden} is in it" for forbidden in found.forbidden]
    for kind, used, most in (
        ("flash", found.total.flash, target.flash_kib),
        ("RAM", found.total.ram, target.ram_kib),
    ):
        if most is not None and used > most * 1024:
            wrong.append(f"{name}: {used} bytes of {kind}, budget {most * 1024}")
    return f"| {name} | " + " | ".join(
        f"{number:,}".replace(",", " ") for number in row
    ) + " |", wrong


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("images", nargs="*", help=f"of: {', '.join(TARGETS)}; default: all")
    args = parser.parse_args()
    if "ZEPHYR_BASE" not in os.environ:
        parser.error("ZEPHYR_BASE names no Zephyr tree")
    rows, wrong = [], []
    for name in args.images or TARGETS:
        if not build(name):
            wrong.append(f"{name}: not built")
            continue
        row, faults = measured(name)
        rows.append(row)
        wrong += faults
    print("| image | flash | of it Pharos | RAM | of it Pharos |\n|---|---|---|---|---|")
    print("\n".join(rows))
    for line in wrong:
        print(f"images: {line}", file=sys.stderr)
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
