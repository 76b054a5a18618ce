# SPDX-License-Identifier: Apache-2.0
"""What an image for a microcontroller takes of flash and RAM, the light's share apart.

    .venv/bin/python tests/budget/image.py BUILD_FOLDER [--flash KIB] [--ram KIB]

Reads zephyr/zephyr.map, zephyr.elf and .config of a Zephyr build folder, of any board. Fails where
the image takes more than --flash or --ram, and where it has arithmetic in double precision,
printf's floats or a heap in it.
"""

from __future__ import annotations

import argparse
import re
import sys
from dataclasses import dataclass, field
from pathlib import Path

from elftools.common.exceptions import ELFError
from elftools.elf.elffile import ELFFile

# The first that matches the archive or object that a section came from.
GROUPS = (
    ("core", r"^app/core/"),
    ("MAVLink", r"^app/proto/mavlink/"),
    ("DroneCAN", r"^app/proto/dronecan/"),
    ("IMC", r"^app/proto/imc/"),
    ("threads", r"^app/"),
    ("drivers", r"^modules/pharos/"),
    ("Zephyr", r"^(zephyr/|CMakeFiles/|linker stubs)"),
    ("other modules", r"^modules/"),
    ("compiler's library", r"^/"),
)
OURS = ("core", "MAVLink", "DroneCAN", "IMC", "threads", "drivers")
PADDING = "gaps, less merged texts"

# In the linker's map: a region, an output section, a piece of one with the file that it came from.
REGION = re.compile(r"^(FLASH|RAM) +0x(\w+) +0x(\w+)", re.MULTILINE)
SECTION = re.compile(r"^([\w.]\S*)\s+0x(\w+)\s+0x(\w+)( load address 0x\w+)?$", re.MULTILINE)
PIECE = re.compile(r"^ (\S+)\s+0x(\w+)\s+0x(\w+) (\S.*)$", re.MULTILINE)

DEBUG = re.compile(r"\.(debug|comment|stab|ARM\.attributes)")
# What is further from a region's origin is another region.
REGION_MAX = 0x08000000

# Double precision's helpers, the C library's printing of floats and all that takes memory at run
# time. Zephyr's heap is k_heap over a static buffer.
FORBIDDEN = re.compile(
    r"^(__aeabi_(d\w+|cd\w+|[a-z]+2d)|__\w+df[23]|_dtoa_r|_printf_float|"
    r"malloc|calloc|realloc|_malloc_r|k_malloc|k_calloc|_sbrk)$"
)
# Zephyr's own printing of floats has no symbol: the compiler makes it part of its caller.
PRINTS_FLOATS = "CONFIG_CBPRINTF_FP_SUPPORT"


class ImageError(Exception):
    """The folder has no image that can be measured."""


@dataclass
class Use:
    flash: int = 0
    ram: int = 0


@dataclass
class Image:
    use: dict[str, Use] = field(default_factory=dict)
    total: Use = field(default_factory=Use)
    forbidden: list[str] = field(default_factory=list)


def group_of(origin: str) -> str:
    return next((name for name, form in GROUPS if re.search(form, origin)), PADDING)


def read_map(text: str, image: Image) -> None:
    regions = {name: int(origin, 16) for name, origin, _ in REGION.findall(text)}
    if "RAM" not in regions:
        raise ImageError("zephyr.map names no RAM: is this an image for a microcontroller?")
    body = text[text.index("Linker script and memory map") :]
    # A long name has its numbers on the next line.
    body = re.sub(r"^( ?[\w.]\S*)\n\s+(0x)", r"\1 \2", body, flags=re.MULTILINE)
    sections = [m for m in SECTION.finditer(body) if int(m[3], 16) and not DEBUG.match(m[1])]
    for index, match in enumerate(sections):
        first, size = int(match[2], 16), int(match[3], 16)
        load = int(match[4].split()[-1], 16) if match[4] else None
        in_ram = regions["RAM"] <= first < regions["RAM"] + REGION_MAX
        if not in_ram and not regions["FLASH"] <= first < regions["FLASH"] + REGION_MAX:
            continue
        flash_end = load + size if load is not None else 0 if in_ram else first + size
        image.total.flash = max(image.total.flash, flash_end - regions["FLASH"])
        image.total.ram = max(image.total.ram, first + size - regions["RAM"] if in_ram else 0)
        end = sections[index + 1].start() if index + 1 < len(sections) else len(body)
        for _, at, length, origin in PIECE.findall(body, match.end(), end):
            if first <= int(at, 16) < first + size:
                use = image.use.setdefault(group_of(origin), Use())
                use.flash += int(length, 16) if flash_end else 0
                use.ram += int(length, 16) if in_ram else 0
    image.use[PADDING] = Use(
        image.total.flash - sum(use.flash for use in image.use.values()),
        image.total.ram - sum(use.ram for use in image.use.values()),
    )


def functions(path: Path) -> list[str]:
    """Names of the functions in an ELF file."""
    with path.open("rb") as file:
        symbols = ELFFile(file).get_section_by_name(".symtab").iter_symbols()
        return [symbol.name for symbol in symbols if symbol["st_info"]["type"] == "STT_FUNC"]


def measure(folder: Path) -> Image:
    image = Image()
    try:
        read_map((folder / "zephyr" / "zephyr.map").read_text(), image)
        names = functions(folder / "zephyr" / "zephyr.elf")
        config = (folder / "zephyr" / ".config").read_text()
    except OSError as error:
        raise ImageError(f"{error.filename}: {error.strerror}") from error
    except ELFError as error:
        raise ImageError(f"zephyr.elf: {error}") from error
    image.forbidden = sorted(name for name in names if FORBIDDEN.match(name))
    if f"{PRINTS_FLOATS}=y\n" in config:
        image.forbidden.append(PRINTS_FLOATS)
    return image


def report(image: Image) -> None:
    ours = Use(
        sum(image.use[name].flash for name in OURS if name in image.use),
        sum(image.use[name].ram for name in OURS if name in image.use),
    )
    rows = [(name, image.use[name]) for name in OURS if name in image.use]
    rows.append(("Pharos", ours))
    rows += [(name, use) for name, use in sorted(image.use.items()) if name not in OURS]
    rows.append(("image", image.total))
    print(f"{'':<24}{'flash':>9}{'RAM':>9}")
    for name, use in rows:
        print(f"{name:<24}{use.flash:>9}{use.ram:>9}")


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, help="Zephyr's build folder")
    parser.add_argument("--flash", type=int, metavar="KIB", help="the most it may take of flash")
    parser.add_argument("--ram", type=int, metavar="KIB", help="the most it may take of RAM")
    args = parser.parse_args()
    try:
        image = measure(args.folder)
    except ImageError as error:
        print(f"image: {error}", file=sys.stderr)
        return 1
    report(image)
    wrong = [f"{name} is in it" for name in image.forbidden]
    for name, used, most in (
        ("flash", image.total.flash, args.flash),
        ("RAM", image.total.ram, args.ram),
    ):
        if most is not None and used > most * 1024:
            wrong.append(f"{name}: {used} bytes, budget {most} KiB = {most * 1024}")
    for line in wrong:
        print(f"image: {line}", file=sys.stderr)
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
