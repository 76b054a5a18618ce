# SPDX-License-Identifier: Apache-2.0
"""The architecture's rules, checked from the sources and from the core's objects."""

from __future__ import annotations

import os
import re
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("PHAROS_BUILD", ROOT / "build" / "native")).resolve()
FILE_LINES_MAX = 600
FUNCTION_LINES_MAX = 70

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.MULTILINE)
FREESTANDING = {
    "float.h", "iso646.h", "limits.h", "stdalign.h", "stdarg.h", "stdbool.h", "stddef.h",
    "stdint.h", "stdnoreturn.h",
}  # fmt: skip
# C11 library headers that need no operating system; what Zephyr's minimal C library has as well.
PORTABLE = FREESTANDING | {
    "assert.h", "ctype.h", "errno.h", "inttypes.h", "math.h", "stdio.h", "stdlib.h", "string.h",
    "time.h",
}  # fmt: skip


@dataclass(frozen=True)
class Include:
    file: Path
    line: int
    name: str
    quoted: bool

    def __str__(self) -> str:
        return f"{self.file.relative_to(ROOT)}:{self.line} includes {self.name}"

    @property
    def target(self) -> Path | None:
        """The file of the tree that a quoted include names, relative to the file or to app/."""
        for base in (self.file.parent, ROOT / "app", ROOT / "drivers" / "include"):
            candidate = (base / self.name).resolve()
            if candidate.is_file() and candidate.is_relative_to(ROOT):
                return candidate.relative_to(ROOT)
        return None


def _sources(*folders: str) -> list[Path]:
    return sorted(
        path
        for folder in folders
        for path in (ROOT / folder).rglob("*")
        if path.suffix in (".c", ".h")
    )


def _includes(*folders: str) -> list[Include]:
    return [
        Include(path, text.count("\n", 0, match.start()) + 1, match[2], match[1] == '"')
        for path in _sources(*folders)
        for text in (path.read_text(),)
        for match in INCLUDE.finditer(text)
    ]


def _name(path: Path) -> str:
    return str(path.relative_to(ROOT))


def _report(wrong: list[Include], rule: str) -> None:
    assert not wrong, rule + ":\n" + "\n".join(f"  {include}" for include in wrong)


def test_core_includes_only_core_and_freestanding_headers() -> None:
    wrong = [
        i
        for i in _includes("app/core")
        if not (
            i.name in FREESTANDING | {"string.h"}
            or (i.target is not None and i.target.is_relative_to("app/core"))
        )
    ]
    _report(wrong, "core includes core, freestanding C11 headers and string.h, and nothing else")


@pytest.mark.parametrize("protocol", ["mavlink", "imc", "dronecan"])
def test_protocol_includes_core_and_itself_and_never_another_protocol(protocol: str) -> None:
    own = f"app/proto/{protocol}"
    wrong = []
    for include in _includes(own):
        target = include.target
        if target is not None:
            allowed = target.is_relative_to("app/core") or target.is_relative_to(own)
        else:
            others = {"mavlink", "imc", "dronecan"} - {protocol}
            allowed = include.name in PORTABLE or (
                not include.name.startswith(("zephyr/", "pharos/drivers/", "sys/", "host/"))
                and not any(other in include.name for other in others)
                and include.name.startswith((f"proto/{protocol}/", protocol, "pharos", "common"))
            )
        if not allowed:
            wrong.append(include)
    _report(wrong, f"proto/{protocol} includes core, itself and its generated headers")


def test_threads_and_main_include_core_proto_zephyr_and_drivers_api() -> None:
    wrong = []
    for include in _includes("app"):
        if include.file.is_relative_to(ROOT / "app/core") or include.file.is_relative_to(
            ROOT / "app/proto"
        ):
            continue
        target = include.target
        if target is not None:
            allowed = target.is_relative_to("app") or target.is_relative_to("drivers/include")
        else:
            allowed = include.name in PORTABLE or include.name.startswith(
                ("core/", "proto/", "threads/", "zephyr/", "pharos/drivers/", "app_version")
            )
        if not allowed:
            wrong.append(include)
    _report(wrong, "threads and main include core, proto, zephyr/* and pharos/drivers/*")


DOOR = {ROOT / "app/core/device.c", ROOT / "app/core/device_params.c"}
OUTPUTS = {"power.c", "shutdown.c", "thruster.c", "focus.c", "display.c"}

# What changes the machines that stand behind the device's door, by the file that has them.
BEHIND_THE_DOOR = {
    "illuminator.c": "illuminator_step",
    "gimbal.c": "gimbal_(step|advance)",
    "arbiter.c": "arbiter_(commit|heard|configure|advance)",
    "params.c": "params_(set|reset|tell)",
    "self_test.c": "self_test_(begin|step|cancel|driver)",
    "actuators.c": "actuators_(step|advance|set_[a-z]+)",
    "power.c": "power_(command|advance)",
    "shutdown.c": "shutdown_(command|lapse|advance)",
    "thruster.c": "thruster_(set|configure|restart|advance)",
    "focus.c": "focus_(command|move|advance)",
    "display.c": "display_command",
}


def test_only_the_device_changes_what_is_behind_its_door() -> None:
    wrong = []
    for path in _sources("app"):
        if path.suffix != ".c" or path in DOOR:
            continue
        text = _strip(path.read_text())
        for owner, verbs in BEHIND_THE_DOOR.items():
            # the outputs' own parts are stepped by them
            inner = path.name == "actuators.c" and owner in OUTPUTS
            if path == ROOT / "app/core" / owner or inner:
                continue
            wrong += [
                f"  {_name(path)}:{text.count(chr(10), 0, match.start()) + 1}: {match[0]}"
                for match in re.finditer(rf"\b{verbs}(?=\s*\()", text)
            ]
    assert not wrong, "only core/device*.c change what the device owns:\n" + "\n".join(wrong)


def test_every_verb_behind_the_door_exists() -> None:
    """A verb that is renamed must not slip out of the rule."""
    for owner, verbs in BEHIND_THE_DOOR.items():
        text = (ROOT / "app/core" / owner).read_text()
        prefix, _, choice = verbs.partition("(")
        for verb in choice.rstrip(")").split("|") if choice else [""]:
            assert re.search(rf"^[a-z].*\b{prefix}{verb}\(", text, re.MULTILINE), f"{prefix}{verb}"


def test_drivers_never_include_the_app() -> None:
    wrong = [
        i
        for i in _includes("drivers", "boards/native/drivers")
        if i.name.startswith(("core/", "proto/", "threads/", "app/"))
        or (i.target is not None and i.target.is_relative_to("app"))
    ]
    _report(wrong, "drivers include zephyr/*, never the app")


def test_drivers_for_every_board_include_nothing_of_a_host() -> None:
    # A chip's own headers, which Zephyr has on its path.
    chips = {"soc.h", "stm32_ll_usart.h"}
    wrong = [
        i
        for i in _includes("drivers")
        if not (
            i.name in PORTABLE | chips
            or i.name.startswith(("zephyr/", "pharos/"))
            or (i.target is not None and i.target.is_relative_to("drivers"))
        )
    ]
    _report(wrong, "drivers/ is for any Zephyr application; a host's are in boards/native/drivers")


def test_host_never_includes_zephyr() -> None:
    wrong = [i for i in _includes("boards/native/host") if i.name.startswith("zephyr/")]
    # A driver may be a pair: its host half is the one that includes the host's headers.
    drivers = _includes("boards/native/drivers")
    halves = {i.file for i in drivers if i.name.startswith("host/")}
    halves |= {path for path in _sources("boards/native/drivers") if _is_host_half(path)}
    wrong += [i for i in drivers if i.file in halves and i.name.startswith("zephyr/")]
    _report(wrong, "the host's side includes POSIX, never zephyr/*")


def _is_host_half(path: Path) -> bool:
    return path.stem.endswith("_host") and path.with_stem(path.stem[: -len("_host")]).exists()


def test_kernel_never_includes_host_headers() -> None:
    wrong = [
        i
        for i in _includes("boards/native/kernel")
        if not i.quoted
        and i.name not in PORTABLE
        and not i.name.startswith(("zephyr/", "native/", "sanitizer/"))
    ]
    _report(wrong, "the kernel includes its own zephyr/* headers and no host header")


def test_nothing_includes_tests() -> None:
    wrong = [
        i
        for i in _includes("app", "drivers", "boards")
        if "tests/" in i.name or (i.target is not None and i.target.is_relative_to("tests"))
    ]
    _report(wrong, "nothing includes tests")


def test_python_package_imports_nothing_else_of_the_tree() -> None:
    wrong = [
        f"  {_name(path)}:{number}: {line.strip()}"
        for path in sorted((ROOT / "host/src").rglob("*.py"))
        for number, line in enumerate(path.read_text().splitlines(), start=1)
        if re.match(r"\s*(from|import)\s+(tests|app|boards|drivers|harness)\b", line)
    ]
    assert not wrong, "host uses the wire, and nothing else of the tree:\n" + "\n".join(wrong)


def test_app_never_asks_which_kernel_is_below() -> None:
    pattern = re.compile(
        r"^\s*#\s*(?:if|ifdef|ifndef|elif)\b.*"
        r"(CONFIG_BOARD|CONFIG_ARCH|CONFIG_SOC|PHAROS_NATIVE|__ZEPHYR__|CONFIG_NATIVE|__linux__"
        r"|__unix__|BOARD_NATIVE)",
        re.MULTILINE,
    )
    wrong = [
        f"  {_name(path)}:{text.count(chr(10), 0, match.start()) + 1}: {match[0].strip()}"
        for path in _sources("app")
        for text in (path.read_text(),)
        for match in pattern.finditer(text)
    ]
    assert not wrong, "app has no conditional on the kernel or board:\n" + "\n".join(wrong)


def _endless_waits(path: Path) -> list[str]:
    """Waits without end without a comment, on the line or in the three above, of why they may."""
    lines = path.read_text().splitlines()
    code = _strip(path.read_text()).splitlines()
    return [
        f"  {_name(path)}:{number}: {lines[number - 1].strip()}"
        for number, line in enumerate(code, start=1)
        if re.search(r"\bK_FOREVER\b|\badc_read\s*\(|\bk_thread_join\s*\(", line)
        and "/*" not in lines[number - 1]
        and not any(above.rstrip().endswith("*/") for above in lines[number - 4 : number - 1])
    ]


def test_each_wait_without_end_says_why_it_may() -> None:
    """A peripheral may never answer; adc_read() has no limit, adc_read_async() can be given one."""
    wrong = [wait for path in _sources("app", "drivers") for wait in _endless_waits(path)]
    assert not wrong, "waits without end, and without a comment that says why:\n" + "\n".join(wrong)


def test_the_finder_of_endless_waits_sees_one() -> None:
    path = ROOT / "boards" / "native" / "kernel" / "work.c"
    assert any("K_FOREVER" in wait for wait in _endless_waits(path))


def test_devicetree_names_stand_in_one_file_of_the_app() -> None:
    files = {
        _name(path)
        for path in _sources("app")
        if re.search(r"\b(DT_NODELABEL|DT_ALIAS|DT_CHOSEN|DT_PATH)\s*\(", path.read_text())
    }
    assert len(files) <= 1, f"devicetree names stand in several files: {sorted(files)}"


def _strip(text: str) -> str:
    """The text with comments, strings and characters blanked out; lines stay where they are."""

    def blank(match: re.Match[str]) -> str:
        return re.sub(r"[^\n]", " ", match[0])

    return re.sub(
        r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'',
        blank,
        text,
        flags=re.DOTALL,
    )


def _functions(path: Path) -> Iterator[tuple[str, int, int]]:
    """(name, first line, lines) of each function: from its name's line to its closing brace."""
    lines = _strip(path.read_text()).splitlines()
    start = None
    name = ""
    for number, line in enumerate(lines, start=1):
        head = re.match(r"[A-Za-z_][\w\s*]*?\b(\w+)\s*\(", line)
        if head and not line.rstrip().endswith(";"):
            start, name = number, head[1]
        elif line.startswith("}") and start is not None:
            yield name, start, number - start + 1
            start = None
        elif line.rstrip().endswith(";") and line[:1] not in (" ", "\t", "{", "}"):
            start = None


FILES = _sources("app", "drivers", "boards", "tests")
PYTHON = sorted(
    path
    for folder in ("app", "boards", "host", "tests")
    for path in (ROOT / folder).rglob("*.py")
    if "egg-info" not in str(path) and "/build/" not in str(path)
)


def _is_data(path: Path) -> bool:
    """Written by a program, and says so at its head: no one reads it from end to end."""
    return "do not edit" in path.read_text()[:300].lower()


@pytest.mark.parametrize("path", [p for p in FILES + PYTHON if not _is_data(p)], ids=_name)
def test_file_has_at_most_600_lines(path: Path) -> None:
    count = len(path.read_text().splitlines())
    assert count <= FILE_LINES_MAX, f"{_name(path)} has {count} lines"


@pytest.mark.parametrize("path", [p for p in FILES if p.suffix == ".c"], ids=_name)
def test_function_has_at_most_70_lines(path: Path) -> None:
    long = [
        f"  {_name(path)}:{first} {name}(): {count} lines"
        for name, first, count in _functions(path)
        if count > FUNCTION_LINES_MAX
    ]
    assert not long, "functions have at most 70 lines:\n" + "\n".join(long)


@pytest.mark.parametrize("path", FILES, ids=_name)
def test_c_file_begins_with_its_licence(path: Path) -> None:
    first = path.read_text().split("\n", 1)[0]
    assert first == "/* SPDX-License-Identifier: Apache-2.0 */", f"{_name(path)}: {first!r}"


def test_the_function_counter_sees_a_function_that_is_too_long(tmp_path: Path) -> None:
    path = tmp_path / "long.c"
    path.write_text(
        "static int f(int a,\n\t     int b)\n{\n" + "\ta++;\n" * 70 + "\treturn a;\n}\n"
    )
    assert list(_functions(path)) == [("f", 1, 75)]


def _core_objects() -> list[Path]:
    return sorted(
        path
        for path in BUILD.rglob("*.o")
        if "/app/core/" in str(path) and "pharos_core" in str(path) and "/tests/" not in str(path)
    )


# What the compiler itself calls on a 32- or 64-bit machine, sanitizers' and coverage's included.
# What a compiler adds of its own; clang makes bcmp of a memcmp that only asks for equality.
COMPILER = re.compile(
    r"^(bcmp$|__asan_|__(?:start|stop)_asan_|__ubsan_|__stack_chk_|__gcov|__sanitizer"
    r"|_GLOBAL_OFFSET_TABLE_)"
)


def test_core_objects_need_only_memory_string_and_assert() -> None:
    objects = _core_objects()
    assert objects, f"no objects of the core below {BUILD}: run `make build`"
    names = [str(path) for path in objects]
    output = subprocess.run(["nm", "-u", *names], capture_output=True, text=True, check=True)
    defined_output = subprocess.run(
        ["nm", "--defined-only", *names], capture_output=True, text=True, check=True
    )
    undefined = set(re.findall(r"^\s+[Uw] (\S+)$", output.stdout, re.MULTILINE))
    defined = set(re.findall(r"^[0-9a-f]+ [A-Z] (\S+)$", defined_output.stdout, re.MULTILINE))
    wrong = sorted(
        symbol
        for symbol in undefined - defined
        if not re.match(r"^(mem|str)[a-z]+$", symbol)
        and not COMPILER.match(symbol)
        and symbol != "pharos_assert_failed"
    )
    assert not wrong, f"the core's objects need {wrong}"
