# SPDX-License-Identifier: Apache-2.0
"""`pharos check` on a light of another make, written from the guide without sight of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from checking import failing
from other_light import OtherLight
from pharos import Light, MavlinkConnection, load_dialect
from pharos.check import Level, Report, check, find
from pharos.link import Link


class Desk(Link):
    """The link to it, and the clock of both."""

    def __init__(self, light: OtherLight) -> None:
        super().__init__()
        self.light = light
        self.time_us = 0

    def fileno(self) -> int:
        return -1

    def close(self) -> None:
        pass

    def _read(self) -> bytes:
        return b""

    def _write(self, data: bytes) -> None:
        self._take(self.light.receive(data))

    def _take(self, frames: list[bytes]) -> None:
        for frame in frames:
            self.inbox.append(frame)
            self.received += len(frame)

    def poll(self, timeout_s: float) -> bool:
        del timeout_s
        return bool(self.inbox)

    def now_us(self) -> int:
        return self.time_us

    def pump(self, us: int) -> None:
        end = self.time_us + us
        while True:
            self._take(self.light.step(self.time_us))
            if self.time_us >= end:
                return
            self.time_us = min(end, max(self.light.next_us(), self.time_us + 1))

    def __str__(self) -> str:
        return "desk"


def report_of(light: OtherLight) -> Report:
    desk = Desk(light)
    connection = MavlinkConnection(desk, desk, light.d)
    connection.target = find(connection, None)
    return check(connection)


def test_it_passes_every_must() -> None:
    light = OtherLight(load_dialect())
    report = report_of(light)
    assert failing(report, Level.MUST) == []
    # Its hardware is "B", which is no number; pymavlink's parser drops what follows garbage.
    assert failing(report, Level.SHOULD) == ["INF-4", "WR-16"]
    assert not light.is_on
    passed = sum(r.outcome == "passed" for r in report.results)
    assert passed > 80, "the rest is of what it does not offer"


class Clamps(OtherLight):
    def configure(self, params: list[float]) -> int:
        mode, brightness, *rest = params
        if brightness == brightness:
            brightness = min(max(brightness, 0), 100)
        return super().configure([mode, brightness, *rest])


class TakesAnyNumber(OtherLight):
    def on_off(self, params: list[float]) -> int:
        return super().on_off([float(params[0] != 0)])


class HearsEverybodys(OtherLight):
    def command(self, message: Any, source: tuple[int, int]) -> list[Any]:
        message.target_component = self.component
        return super().command(message, source)


class Forgets(OtherLight):
    def set_interval(self, params: list[float]) -> int:
        return (
            super().set_interval([params[0], 0.0])
            if params[1] == -1
            else (super().set_interval(params))
        )


class CountsSeconds(OtherLight):
    def status(self) -> Any:
        message = super().status()
        message.uptime_ms //= 1000
        return message


class AnswersTwice(OtherLight):
    def command(self, message: Any, source: tuple[int, int]) -> list[Any]:
        answers = super().command(message, source)
        return [*answers[:1], *answers]


@pytest.mark.parametrize(
    ("kind", "must"),
    [
        (Clamps, "CF-5"),
        (TakesAnyNumber, "SW-3"),
        (HearsEverybodys, "CM-8"),
        (Forgets, "IV-3"),
        (CountsSeconds, "ST-3"),
        (AnswersTwice, "CM-1"),
    ],
)
def test_its_faults_are_found(kind: Callable[[Any], OtherLight], must: str) -> None:
    assert must in failing(report_of(kind(load_dialect())), Level.MUST)


def test_it_is_commanded_as_any_light() -> None:
    light = OtherLight(load_dialect(), system=9, component=100)
    desk = Desk(light)
    client = Light(MavlinkConnection(desk, desk, light.d))
    client.find()
    client.on()
    client.set_strobe(0.5, 10)
    assert str(client.fetch_status()) == "on, 0 %, strobe 0.5 s at 10 %, ? °C"
    assert client.fetch_information().vendor_name == "Lumen"
