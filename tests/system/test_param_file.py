# SPDX-License-Identifier: Apache-2.0
"""@PARAM/param.pck, which ground stations read instead of a list; MAVProxy's decoder judges it."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from MAVProxy.modules.lib import param_ftp

from ftp_client import OPEN, TERMINATE, FtpClient
from harness import Light, light_on, of
from parameters import ask_list, get_param, set_param, shortest, value_of
from pharos import Simulator

PACK = "@PARAM/param.pck"
WITH_DEFAULTS = PACK + "?withdefaults=1"

Values = dict[str, float]


VALUE_BYTES = 37  # PARAM_VALUE on the wire


@pytest.fixture
def ftp(udp_light: Light) -> FtpClient:
    return FtpClient(udp_light.mav)


def decode(content: bytes) -> tuple[Values, Values | None]:
    """Values and, if the file has them, defaults."""
    data = param_ftp.ftp_param_decode(content)
    assert data is not None
    defaults = data.defaults and {n.decode(): shortest(value) for n, value, _ in data.defaults}
    return {n.decode(): shortest(value) for n, value, _ in data.params}, defaults


def listed(light: Light) -> Values:
    """What PARAM_REQUEST_LIST brings."""
    light.collect(0)
    ask_list(light.mav)
    values = of("PARAM_VALUE", light.mav.pass_time(10_000_000))
    assert len(values) == values[0].param_count
    return {message.param_id: value_of(message) for message in values}


@pytest.mark.parametrize("path", [PACK, "/" + PACK, WITH_DEFAULTS])
def test_the_file_has_what_the_list_has(udp_light: Light, ftp: FtpClient, path: str) -> None:
    defaults = listed(udp_light)
    set_param(udp_light, "LGT_RESTORE", 1)
    set_param(udp_light, "THR_SHUTDOWN", 95.5)
    values, told = decode(ftp.read(path))
    assert values == listed(udp_light)
    assert list(values) == list(defaults)
    assert told == (defaults if path == WITH_DEFAULTS else None)


@pytest.mark.parametrize("path", ["@PARAM", "@PARAM/", PACK + "?", PACK + "?start=5", "param.pck"])
def test_other_names_are_not_found(ftp: FtpClient, path: str) -> None:
    assert ftp.ask(OPEN, path.encode()).error == 10


def test_parameters_that_change_while_it_is_read(udp_light: Light, ftp: FtpClient) -> None:
    """The file is of the moment of opening, whole in any parts, and what it has wrong by the time
    that it is closed is told then: the client may have believed it."""
    before = listed(udp_light)
    session, length = ftp.open(WITH_DEFAULTS)
    content = b""
    while len(content) < length:
        part = ftp.ask(5, session=session, size=30, offset=len(content))
        content += part.data
        set_param(udp_light, "LGT_RESTORE", 1)
        set_param(udp_light, "THR_SHUTDOWN", 90 + len(content) / 1000)
    assert decode(content) == (before, before)
    udp_light.collect(0)
    assert ftp.ask(TERMINATE, session=session).error == 0
    told = of("PARAM_VALUE", udp_light.mav.pass_time(2_000_000))
    assert {m.param_id: value_of(m) for m in told} == {
        "LGT_RESTORE": 1,
        "THR_SHUTDOWN": shortest(90 + length / 1000),
    }
    assert get_param(udp_light, "THR_SHUTDOWN") == shortest(90 + length / 1000)
    assert decode(ftp.read(PACK))[0] == listed(udp_light)


def test_the_file_comes_in_half_the_time_of_the_list(start: Callable[..., Simulator]) -> None:
    light = light_on(start({"uart0": "pty:{folder}/uart0,baud=57600,paced"}))
    begin = light.sim.now_us()
    ask_list(light.mav)
    count = light.mav.recv("PARAM_VALUE", timeout_us=2_000_000).param_count
    for _ in range(count - 1):
        light.mav.recv("PARAM_VALUE", timeout_us=2_000_000)
    list_us = light.sim.now_us() - begin
    bytes_us = count * VALUE_BYTES * 10 * 1_000_000 / 57600
    assert list_us <= 2.2 * bytes_us, f"{list_us / 1e6:.3f} s, its bytes {bytes_us / 1e6:.3f} s"

    begin = light.sim.now_us()
    ftp = FtpClient(light.mav)
    session, length = ftp.open(WITH_DEFAULTS)
    content = b"".join(part.data for part in ftp.burst(session))
    assert len(content) == length
    file_us = light.sim.now_us() - begin
    print(
        f"list {list_us / 1e6:.3f} s, its bytes {bytes_us / 1e6:.3f} s, file {file_us / 1e6:.3f} s"
    )
    assert file_us <= 0.5 * list_us, f"{file_us / 1e6:.2f} s, the list {list_us / 1e6:.2f} s"
