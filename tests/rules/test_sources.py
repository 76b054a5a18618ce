# SPDX-License-Identifier: Apache-2.0
"""Each source of the tree is compiled by some build, and each driver is on some board."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("PHAROS_BUILD", ROOT / "build" / "native")).resolve()

# Lists that other builds than the native one read: Zephyr's boards, the preset fuzz, and the
# ground's end of the line, an application of its own.
OTHER_LISTS = ("drivers/CMakeLists.txt", "tests/fuzz/CMakeLists.txt", "tests/line/CMakeLists.txt")

# What no list of ours names as it is.
EXCEPTIONS = {
    # One of the three, as is the libgpiod that the machine has; tests/linux builds both versions.
    "boards/native/drivers/gpio_libgpiod/gpio_libgpiod_none_host.c",
    "boards/native/drivers/gpio_libgpiod/gpio_libgpiod_v1_host.c",
    "boards/native/drivers/gpio_libgpiod/gpio_libgpiod_v2_host.c",
    # A shared library that test_peer.py makes.
    "tests/proto/dronecan/shared_device.c",
}


def _tree() -> set[str]:
    return {
        str(path.relative_to(ROOT))
        for folder in ("app", "boards", "drivers", "host", "tests")
        for path in (ROOT / folder).rglob("*.[cS]")
    }


def _compiled() -> set[str]:
    commands = json.loads((BUILD / "compile_commands.json").read_text())
    files = {Path(entry["directory"], entry["file"]).resolve() for entry in commands}
    return {str(file.relative_to(ROOT)) for file in files if file.is_relative_to(ROOT)}


def _listed(name: str) -> dict[str, str]:
    """The sources in a CMakeLists.txt, and the option that each of them needs ("": none)."""
    folder = (ROOT / name).parent
    found = {}
    for words in re.findall(r"\w+\(([^()]*)\)", (ROOT / name).read_text()):
        option = re.match(r"CONFIG_(\w+)", words)
        for word in re.findall(r"[^\s()]+\.[cS]\b", words):
            path = word.replace("${PHAROS_DIR}", str(ROOT))
            path = path.replace("${NATIVE_DIR}", str(ROOT / "boards/native"))
            found[os.path.relpath(folder / path, ROOT)] = option[1] if option else ""
    return found


def test_every_source_is_compiled_by_some_build() -> None:
    listed = {source for name in OTHER_LISTS for source in _listed(name)}
    assert listed, "no lists were read"
    forgotten = _tree() - _compiled() - listed - EXCEPTIONS
    assert not forgotten, f"no CMakeLists.txt has {sorted(forgotten)} (or {BUILD} is old)"


def test_every_exception_is_there() -> None:
    assert EXCEPTIONS - _tree() == set()


def test_every_option_of_a_driver_is_in_the_drivers_kconfig() -> None:
    options = set(re.findall(r"^config (\w+)$", (ROOT / "drivers/Kconfig").read_text(), re.M))
    needed = {option for option in _listed("drivers/CMakeLists.txt").values() if option}
    assert needed
    assert needed <= options, f"drivers/Kconfig lacks {sorted(needed - options)}"


def test_every_driver_has_a_binding_and_a_board() -> None:
    boards = "".join(
        path.read_text()
        for folder in ("boards", "tests")
        for pattern in ("*.overlay", "*.dts")
        for path in sorted((ROOT / folder).rglob(pattern))
    )
    compatibles = {
        name: match[1]
        for name in _tree()
        if name.startswith(("drivers/", "boards/native/drivers/", "boards/native/devices/"))
        for match in re.finditer(r"#define DT_DRV_COMPAT (\w+)", (ROOT / name).read_text())
    }
    assert compatibles
    bindings = {
        re.sub(r"\W", "_", path.stem): path.stem
        for folder in ("drivers/dts/bindings", "boards/native/dts/bindings")
        for path in (ROOT / folder).rglob("*.yaml")
    }
    for name, compatible in compatibles.items():
        assert compatible in bindings, f"{name}: no binding"
        assert f'"{bindings[compatible]}"' in boards, f"{name}: no board has one"
