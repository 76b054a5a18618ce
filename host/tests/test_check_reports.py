# SPDX-License-Identifier: Apache-2.0
"""`pharos check`: its reports, its page and its command."""

from __future__ import annotations

import json
import signal
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from checking import checked
from model_light import ModelLight
from pharos.check import REQUIREMENTS, Report, as_html, as_junit, as_object, as_page
from pharos.cli import main
from real_light import PATIENCE_S, PHAROS, environment, wait_for

# --- reports --------------------------------------------------------------------------------------
HOSTILE = "\x1b[2J</pre><script>"


class Hostile(ModelLight):
    def say_information(self) -> None:
        text = HOSTILE.encode()
        self.say(
            self.d.MAVLink_component_information_basic_message(
                0, 8192, 0, text, b"", text, b"", b""
            )
        )


@pytest.fixture(scope="module")
def report() -> Report:
    return checked(Hostile({"takes 2 for on"}), "INF", "SW", "GB-1")


def test_json_has_every_result(report: Report) -> None:
    fields = as_object(report)
    assert fields["passed"] is False
    by_id = {result["id"]: result for result in fields["results"]}
    assert by_id["SW-3"]["outcome"] == "failed"
    assert by_id["SW-3"]["level"] == "must"
    assert "405 (2)" in by_id["SW-3"]["seen"]
    assert any("→ COMMAND_LONG 405" in line for line in by_id["SW-3"]["log"])
    assert by_id["GB-1"]["outcome"] == "not offered"
    assert by_id["SW-1"]["url"].startswith("https://mavlink.io/en/services/illuminator.html")


def test_junit_has_musts_as_failures(report: Report) -> None:
    text = as_junit(report)
    suite = ElementTree.fromstring(text)
    failures = [c.get("name") for c in suite.iter("testcase") if c.find("failure") is not None]
    assert suite.get("tests") == str(len(report.results))
    assert suite.get("failures") == str(len(failures)) == str(len(report.broken()))
    assert any(name and name.startswith("SW-3 must") for name in failures)
    assert "\x1b" not in text


def test_html_is_one_safe_page(report: Report) -> None:
    page = as_html(report)
    assert "<script>" not in page
    assert "\x1b" not in page
    assert "\\x1b[2J&lt;/pre&gt;" in page
    assert "src=" not in page
    assert "SW-3" in page


# --- the page and the command ---------------------------------------------------------------------
def test_the_page_is_what_the_code_says() -> None:
    page = Path(__file__).resolve().parents[2] / "docs" / "check.md"
    assert page.read_text() == as_page(), "pharos check --list --markdown > docs/check.md"


def test_every_requirement_says_why_and_where() -> None:
    for requirement in REQUIREMENTS:
        assert len(requirement.explanation) > 20, requirement.id
        assert requirement.page.partition("#")[0].endswith(".html")


def test_explain_and_list_need_no_light(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "--explain", "cf-12"]) == 0
    assert capsys.readouterr().out.startswith("CF-12 (must): the light changes nothing")
    assert main(["check", "--list", "--only", "SW"]) == 0
    assert "SW-7" in capsys.readouterr().out
    assert main(["check", "--list", "--json", "--only", "SW-1"]) == 0
    assert json.loads(capsys.readouterr().out)["id"] == "SW-1"
    assert main(["check"]) == 2
    assert main(["check", "--explain", "none"]) == 2


@pytest.mark.realtime
def test_the_command_checks_a_light(
    real_light: Callable[..., Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    light = real_light("--uart0", "udpin:127.0.0.1:0")
    reports = ["--html", str(tmp_path / "c.html"), "--junit", str(tmp_path / "c.xml")]
    assert main(["check", light.url(), "--only", "SW", *reports]) == 0
    out = capsys.readouterr().out
    assert "SW-1   must    passed" in out
    assert "must: 6 passed" in out
    assert (tmp_path / "c.html").read_text().startswith("<!doctype html>")
    assert ElementTree.parse(tmp_path / "c.xml").getroot().get("failures") == "0"
    assert main(["check", light.url(), "--only", "SW-1", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["passed"] is True


@pytest.mark.realtime
def test_an_interrupted_command_leaves_the_light_off(real_light: Callable[..., Any]) -> None:
    light = real_light("--uart0", "udpin:127.0.0.1:0")
    words = [*PHAROS, "check", light.url(), "--only", "SW", "--only", "CF"]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, env=environment())
    assert process.stdout is not None
    wait_for(lambda: light.control.request("outputs")["enable"] == 1, "a light that is on")
    process.send_signal(signal.SIGINT)
    process.stdout.read()
    assert process.wait(PATIENCE_S) == 130
    assert light.control.request("outputs")["enable"] == 0


def test_a_light_that_is_not_there_ends_with_3(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "udp:127.0.0.1:9", "--timeout", "0.2"]) == 3
    assert "no illuminator" in capsys.readouterr().err
