# SPDX-License-Identifier: Apache-2.0
"""Devicetree bindings say what each of their nodes and properties is, as Zephyr asks."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("drivers/dts/bindings", "boards/native/dts/bindings", "tests/line/dts/bindings")
BINDINGS = sorted(path for folder in FOLDERS for path in (ROOT / folder).glob("**/*.yaml"))


def _undescribed(binding: dict[str, Any], where: str) -> Iterator[str]:
    if not binding.get("description"):
        yield where
    for name, of_property in binding.get("properties", {}).items():
        # another value for one that an included binding describes
        narrowed = set(of_property) <= {"const", "required", "default", "enum"}
        if not narrowed and not of_property.get("description"):
            yield f"{where}: {name}"
    if "child-binding" in binding:
        yield from _undescribed(binding["child-binding"], f"{where}: child")


@pytest.mark.parametrize("path", BINDINGS, ids=lambda path: path.stem)
def test_binding_describes_all(path: Path) -> None:
    binding = yaml.safe_load(path.read_text(encoding="utf-8"))
    if "compatible" not in binding:
        return  # a base to include, such as Zephyr's own has
    assert not list(_undescribed(binding, path.stem))


def test_hardware_bindings_know_no_simulation() -> None:
    hardware = [path for path in BINDINGS if ROOT / "drivers" in path.parents]
    assert hardware
    for path in hardware:
        assert "simulat" not in path.read_text(encoding="utf-8"), path.name
