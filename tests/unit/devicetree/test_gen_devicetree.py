# SPDX-License-Identifier: Apache-2.0
"""The devicetree generator: what it says of wrong input, and what it makes of right input."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
GENERATOR = ROOT / "boards" / "native" / "scripts" / "gen_devicetree.py"

BINDING = """
description: a thing
compatible: "test,thing"
properties:
  compatible:
    type: string-array
  size:
    type: int
    required: true
  words:
    type: string-array
  active:
    type: boolean
"""


def _generate(tmp_path: Path, body: str) -> subprocess.CompletedProcess[str]:
    dts = tmp_path / "board.dts"
    dts.write_text("/dts-v1/;\n/ {\n" + body + "\n};\n")
    bindings = tmp_path / "bindings"
    bindings.mkdir(exist_ok=True)
    (bindings / "test,thing.yaml").write_text(BINDING)
    return subprocess.run(
        [
            *(sys.executable, str(GENERATOR), "--dts", str(dts)),
            *("--bindings", str(bindings), "--out", str(tmp_path / "out.h")),
        ],
        capture_output=True,
        text=True,
        check=False,
    )


def _value(tmp_path: Path, name: str) -> str:
    for line in (tmp_path / "out.h").read_text().splitlines():
        if line.startswith(f"#define {name} "):
            return line.split(" ", 2)[2]
    raise AssertionError(f"{name} is not defined")


def test_properties_become_macros(tmp_path: Path) -> None:
    done = _generate(
        tmp_path,
        "aliases { a-thing = &t; };\n"
        't: thing { compatible = "test,thing"; size = <0x10>; words = "x", "a\\"b"; };',
    )
    assert done.returncode == 0, done.stderr
    node = _value(tmp_path, "DT_ALIAS_a_thing")
    assert _value(tmp_path, "DT_NODELABEL_t") == node
    assert _value(tmp_path, f"{node}_P_size") == "16"
    assert _value(tmp_path, f"{node}_P_active") == "0"
    assert _value(tmp_path, f"{node}_P_words") == '{"x", "a\\"b"}'
    assert _value(tmp_path, f"{node}_STATUS_okay") == "1"
    assert _value(tmp_path, "DT_COMPAT_test_thing_NUM_OKAY") == "1"


def test_disabled_node_is_no_instance_to_build(tmp_path: Path) -> None:
    done = _generate(tmp_path, 'thing { compatible = "test,thing"; size = <1>; };')
    assert done.returncode == 0, done.stderr
    assert "DT_COMPAT_test_thing_HAS_OKAY 1" in (tmp_path / "out.h").read_text()
    binding_with_status = BINDING + "  status:\n    type: string\n"
    (tmp_path / "bindings" / "test,thing.yaml").write_text(binding_with_status)
    dts = tmp_path / "board.dts"
    dts.write_text(dts.read_text().replace("size = <1>;", 'size = <1>; status = "disabled";'))
    done = subprocess.run(
        [
            *(sys.executable, str(GENERATOR), "--dts", str(dts)),
            *("--bindings", str(tmp_path / "bindings"), "--out", str(tmp_path / "out.h")),
        ],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "HAS_OKAY" not in (tmp_path / "out.h").read_text()


@pytest.mark.parametrize(
    ("body", "says"),
    [
        ('thing { compatible = "test,thing"; };', "size"),
        ('thing { compatible = "test,thing"; size = "three"; };', "size"),
        ('thing { compatible = "test,thing"; size = <1>; colour = <2>; };', "colour"),
        ('thing { compatible = "test,unknown"; };', "no binding for compatible 'test,unknown'"),
        ("thing { size = <1> };", "board.dts"),
        ("aliases { x = &nowhere; };", "nowhere"),
        ('#include "no_such_file.h"', "no_such_file.h"),
    ],
)
def test_wrong_devicetree_is_an_error_that_names_it(tmp_path: Path, body: str, says: str) -> None:
    done = _generate(tmp_path, body)
    assert done.returncode == 1
    assert says in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out.h").exists()


def test_missing_file_is_an_error(tmp_path: Path) -> None:
    done = subprocess.run(
        [
            *(sys.executable, str(GENERATOR), "--dts", str(tmp_path / "none.dts")),
            *("--bindings", str(tmp_path), "--out", str(tmp_path / "out.h")),
        ],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert done.stderr.strip() == f"devicetree: {tmp_path}/none.dts: no such file or folder"
