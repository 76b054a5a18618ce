# SPDX-License-Identifier: Apache-2.0
"""The value change dump reader, on dumps written by hand after IEEE 1364-2005, clause 18."""

from __future__ import annotations

from pathlib import Path

import pytest

from pharos import PharosError, read_vcd

HEAD = """$date today $end
$timescale 10 us $end
$scope module light $end
$var wire 1 ! gate $end
$var reg 20 " level_ppm [19:0] $end
$var real 64 # temp $end
$upscope $end
$enddefinitions $end
"""


def _read(tmp_path: Path, body: str, head: str = HEAD) -> dict[str, object]:
    path = tmp_path / "x.vcd"
    path.write_text(head + body)
    return dict(read_vcd(path))


def test_values_of_every_kind_are_read(tmp_path: Path) -> None:
    path = tmp_path / "x.vcd"
    path.write_text(HEAD + '$dumpvars\n0!\nb0 "\nr25.5 #\n$end\n#5\n1!\nb1010 "\n#7\nx!\n')
    signals = read_vcd(path)
    assert signals["gate"].times_us == [0, 50, 70]
    assert signals["gate"].values == [0, 1, None]
    assert signals["level_ppm"].values == [0, 10]
    assert signals["temp"].values == [25.5]


def test_value_at_a_time_is_the_last_before_it(tmp_path: Path) -> None:
    path = tmp_path / "x.vcd"
    path.write_text(HEAD + "#1\n0!\n#3\n1!\n0!\n1!\n#9\n0!\n")
    gate = read_vcd(path)["gate"]
    assert [gate.at(t) for t in (9, 10, 29, 30, 89, 90)] == [None, 0, 0, 1, 1, 0]


def test_time_that_runs_backwards_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(PharosError, match="backwards"):
        _read(tmp_path, "#5\n1!\n#4\n0!\n")


def test_undeclared_signal_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(PharosError, match="declared"):
        _read(tmp_path, "#5\n1?\n")


def test_file_without_definitions_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(PharosError, match="enddefinitions"):
        _read(tmp_path, "", head="$timescale 1 us $end\n")
