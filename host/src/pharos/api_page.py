# SPDX-License-Identifier: Apache-2.0
"""Makes docs/api.md from the docstrings: `python -m pharos.api_page > docs/api.md`."""

from __future__ import annotations

import inspect
import re
from typing import Any

import pharos

HEAD = """\
# The Python API

Made from the docstrings by `python -m pharos.api_page`. Errors are `PharosError`s, whose text is
one clear line. Nothing sleeps: waiting lets time pass through a `Pacer`, the host's clock
(`RealPacer`) or a simulator's.

```python
import pharos

with pharos.connect("udp:127.0.0.1:14550") as light:
    light.on()
    light.set_strobe(0.5, duty=10)
    print(light.fetch_status())
    pharos.Parameters(light).set("LGT_FALLBACK", 1)
    light.off()
```

```python
import pharos

for found in pharos.find_lights(["udp:127.0.0.1:14550"], seconds=2):
    print(found.url, found.serial)
```

```python
import pharos
import pharos.check

with pharos.connect("udp:127.0.0.1:14550") as light:
    report = pharos.check.check(light.connection, pharos.check.selected(["SW"]))
    print(report.passed, report.summary())
```
"""
# By what they are for.
GROUPS = {
    "A light": ("connect", "Light", "Status", "Information"),
    "Its parameters and files": ("Parameters", "Parameter", "FileClient"),
    "New firmware": ("update_light", "UpdateProgress", "UpdatePhase"),
    "Finding": ("find_lights", "Found"),
    "Links and time": (
        "open_link", "Link", "Port", "Pacer", "RealPacer", "MavlinkConnection", "Source", "Target",
    ),
    "The simulator": ("Simulator", "Wire", "Edge", "Tunnel", "Signal", "read_vcd"),
    "The dialect": ("load_dialect", "find_dialect"),
    "Errors": (
        "PharosError", "CommandError", "DialectError", "FileError", "LinkError", "ParameterError",
        "RefusedError", "SilentError", "SimulatorError", "UrlError", "UsageError",
    ),
}  # fmt: skip


def page() -> str:
    lines = [HEAD]
    for title, names in GROUPS.items():
        lines += [f"## {title}", ""]
        for name in names:
            lines += _entry(name, getattr(pharos, name))
    return "\n".join(lines).rstrip() + "\n"


def _entry(name: str, thing: Any) -> list[str]:
    lines = [f"### `{_head(name, thing)}`", "", _doc(thing), ""]
    if not inspect.isclass(thing) or issubclass(thing, Exception):
        return lines
    members = [
        (member, value)
        for member, value in vars(thing).items()
        if not member.startswith("_") and (inspect.isfunction(value) or isinstance(value, property))
    ]
    rows = [f"| `{_head(member, value)}` | {_doc(value)} |" for member, value in members]
    if rows:
        lines += ["| | |", "|---|---|", *rows, ""]
    return lines


def _head(name: str, thing: Any) -> str:
    if isinstance(thing, property) or (inspect.isclass(thing) and issubclass(thing, Exception)):
        return name
    if getattr(thing, "_is_protocol", False):
        return name
    try:
        signature = str(inspect.signature(thing))
    except (TypeError, ValueError):
        return name
    arguments = signature.removeprefix("(self, ").removeprefix("(self").rpartition(" -> ")[0]
    arguments = (arguments or signature.rpartition(" -> ")[0]).strip()
    text = arguments.replace("'", "").replace("|", "or")
    text = re.sub(r"<function [^>]*<lambda>[^>]*>", "…", text)
    return f"{name}({text.removeprefix('(').removesuffix(')')})"


def _doc(thing: Any) -> str:
    text = inspect.getdoc(thing) or ""
    return " ".join(text.split()).replace("|", "\\|")


if __name__ == "__main__":
    print(page(), end="")
