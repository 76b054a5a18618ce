# SPDX-License-Identifier: Apache-2.0
"""The dialect's generator: what a newer wheel brings, and what goes wrong, is said."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[3]
DIALECT = ROOT / "app/proto/mavlink/dialect/pharos.xml"


def load() -> ModuleType:
    path = ROOT / "app/proto/mavlink/generate.py"
    spec = importlib.util.spec_from_file_location("generate_mavlink", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


generate = load()


def wheel_with(folder: Path, messages: str) -> Path:
    text = f"<mavlink><version>3</version><messages>{messages}</messages></mavlink>"
    (folder / "common.xml").write_text(text, encoding="utf-8")
    return folder


def message_440(name: str = "ILLUMINATOR_STATUS") -> str:
    return f'<message id="440" name="{name}"><field type="uint8_t" name="x">.</field></message>'


def test_a_wheel_without_our_messages_keeps_all_of_them(tmp_path: Path) -> None:
    wheel = wheel_with(tmp_path, "")
    staged, dropped = generate.stage(DIALECT, wheel, tmp_path / "out")
    assert dropped == []
    assert set(generate.parse_messages([staged])) == {80, 300, 396, 397, 440}


def test_what_a_newer_wheel_includes_is_dropped_and_named(tmp_path: Path) -> None:
    wheel = wheel_with(tmp_path, message_440())
    staged, dropped = generate.stage(DIALECT, wheel, tmp_path / "out")
    assert dropped == ["ILLUMINATOR_STATUS"]
    assert set(generate.parse_messages([staged])) == {80, 300, 396, 397}


def test_another_message_under_our_id_is_an_error(tmp_path: Path) -> None:
    wheel = wheel_with(tmp_path, message_440("SOMETHING_ELSE"))
    with pytest.raises(generate.GenerateError, match="440 is ILLUMINATOR_STATUS here"):
        generate.stage(DIALECT, wheel, tmp_path / "out")


def test_a_definition_with_another_crc_extra_is_an_error(tmp_path: Path) -> None:
    wheel = wheel_with(tmp_path, message_440())
    staged, _ = generate.stage(DIALECT, wheel, tmp_path / "out")
    messages = generate.parse_messages([staged, wheel / "common.xml"])
    messages[345] = generate.EXPECTED[345]  # a real wheel has it
    with pytest.raises(generate.GenerateError, match=r"message 440: expected .*66, 35"):
        generate.check(messages)


def test_a_missing_wheel_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pymavlink", None)
    with pytest.raises(generate.GenerateError, match="pip install pymavlink"):
        generate.wheel_definitions()


def test_a_missing_dialect_ends_with_one_clear_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    missing = tmp_path / "no.xml"
    arguments = ["generate.py", "--dialect", str(missing), "--out", str(tmp_path)]
    monkeypatch.setattr(sys, "argv", arguments)
    assert generate.main() == 1
    assert capsys.readouterr().err == f"generate.py: no dialect file {missing}\n"
