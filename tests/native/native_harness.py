# SPDX-License-Identifier: Apache-2.0
"""Fixtures: the echo_app executable, and how to start it. conftest.py names them for pytest; it has
nothing else in it, because type checkers take two modules of the same name for one."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from can_node import NewNode, Node
from echo_light import Light, Start

ROOT = Path(__file__).parents[2]
BUILD = Path(os.environ.get("PHAROS_BUILD", ROOT / "build" / "native")).resolve()


@pytest.fixture
def binary() -> Path:
    return BUILD / "tests" / "native" / "echo_app"


@pytest.fixture
def start(binary: Path, tmp_path: Path) -> Iterator[Start]:
    lights: list[Light] = []

    def start_one(*options: str, virtual: bool = True, app: str = "echo_app") -> Light:
        folder = tmp_path / str(len(lights))
        folder.mkdir()
        options = tuple(option.replace("{folder}", str(folder)) for option in options)
        lights.append(Light(binary.with_name(app), folder, *options, virtual=virtual))
        return lights[-1]

    yield start_one
    for light in lights:
        light.close()
        # A sanitizer's report must not go unnoticed.
        text = light.stderr.read_text()
        assert "ERROR: " not in text, text
        assert "runtime error" not in text, text


@pytest.fixture
def node(start: Start) -> Iterator[NewNode]:
    """can_app on a CAN bus of its own; see can_node.Node for what it takes."""
    with contextlib.ExitStack() as stack:

        def new(*options: str, **how: Any) -> Node:
            made = Node(start, *options, **how)
            stack.callback(made.close)
            return made

        yield new
