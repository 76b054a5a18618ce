# SPDX-License-Identifier: Apache-2.0
"""The simulator's lock-step, against a stand-in for the light (fake_light.py)."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from pharos import RefusedError, Simulator, SimulatorError, UrlError, link, open_link


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Callable[..., Simulator]]:
    """start(*options): a Simulator around the stand-in, with uart0 on UDP."""
    program = tmp_path / "fake"
    script = Path(__file__).with_name("fake_light.py")
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" "{script}" "$@"\n')
    program.chmod(0o755)
    with ExitStack() as stack:
        yield lambda *options: stack.enter_context(
            Simulator(program, {"uart0": "udpin:127.0.0.1:0"}, seed=42, options=options)
        )


def test_bytes_that_were_sent_are_awaited_and_the_answer_is_there_afterwards(
    start: Callable[..., Simulator],
) -> None:
    sim = start()
    uart = sim.open("uart0")
    for number in range(200):
        uart.send(b"%d" % number)
        sim.advance(0)
        assert uart.take() == [b"%d" % number]


def test_time_moves_by_exactly_what_was_asked(start: Callable[..., Simulator]) -> None:
    sim = start()
    assert sim.advance(1) == 1
    assert sim.advance(s=3600) == 3_600_000_001
    assert sim.now_us() == 3_600_000_001


def test_long_advance_overflows_no_buffer(start: Callable[..., Simulator]) -> None:
    sim = start()
    uart = sim.open("uart0")
    uart.send(b"hello")
    sim.advance(s=20_000)
    assert len(uart.take()) == 20_001


def test_bytes_that_do_not_come_are_an_error_with_the_replay(
    start: Callable[..., Simulator], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(link, "FETCH_TIMEOUT_S", 0.01)
    sim = start("--misbehave", "silent")
    uart = sim.open("uart0")
    uart.send(b"hello")
    with pytest.raises(SimulatorError, match="5 of 5 bytes did not arrive") as caught:
        sim.advance(0)
    assert "--seed 42" in str(caught.value)
    assert '"op":"advance"' in str(caught.value)


def test_light_that_ends_at_start_is_an_error_that_shows_what_it_said(
    start: Callable[..., Simulator],
) -> None:
    with pytest.raises(SimulatorError, match="ended with 3") as caught:
        start("--misbehave", "exit")
    assert "fake: no such wire" in str(caught.value)


def test_absent_program_is_one_clear_line(tmp_path: Path) -> None:
    with pytest.raises(SimulatorError, match="No such file") as caught, Simulator(tmp_path / "no"):
        pass
    assert "\n" not in str(caught.value)


def test_refusal_carries_the_reason(start: Callable[..., Simulator]) -> None:
    sim = start()
    with pytest.raises(RefusedError) as caught:
        sim.request("dance")
    assert caught.value.reason == "no operation 'dance'"
    assert sim.advance(5) == 5


def test_quit_returns_the_exit_status(start: Callable[..., Simulator]) -> None:
    assert start().quit() == 0


@pytest.mark.parametrize(
    "url",
    [
        "",
        "udp",
        "udp:",
        "udp:nowhere",
        "tcp:host:port",
        "tcp:127.0.0.1:70000",
        "smoke:signals",
        "serial:/dev/null,fast",
    ],
)
def test_bad_url_is_one_clear_line(url: str) -> None:
    with pytest.raises(UrlError) as caught:
        open_link(url)
    assert "\n" not in str(caught.value)
