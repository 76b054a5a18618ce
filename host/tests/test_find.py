# SPDX-License-Identifier: Apache-2.0
"""`pharos find`, in real time and on loopback only."""

from __future__ import annotations

import json
import socket
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from pharos.cli import main
from pharos.errors import PharosError
from pharos.find import Found, _warned, announced_places, find_lights, usual_places
from pharos.imc import EVERYONE, Packet, encode, message
from pharos.light import Information
from real_light import RealLight

START = Callable[..., RealLight]
SECONDS = 2.0
pytestmark = pytest.mark.realtime


def information(serial: str) -> Information:
    return Information("Maker", "Model", "1.0.0", "", serial, 0, 0)


def test_lights_are_found_on_every_kind_of_place(real_light: START, tmp_path: Path) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as kept:
        kept.bind(("127.0.0.1", 0))
        bus = f"127.255.255.255:{kept.getsockname()[1]}"
        light = real_light(
            *("--uart0", "udpin:127.0.0.1:0", "--uart1", "tcpin:127.0.0.1:0"),
            *("--can0", f"udp:{bus}"),
        )
        places = [light.url("uart0"), light.url("uart1"), f"can:pharos-udp/{bus}"]
        found = find_lights(places, SECONDS)
    urls = [*places[:2], f"dronecan:pharos-udp/{bus}?node=68"]
    assert [light.url for light in found] == urls
    for one in found:
        assert (one.system, one.component, one.name) == (1, 243, "Pharos Illuminator")
        assert one.serial


def test_a_serial_line_is_a_place(real_light: START, tmp_path: Path) -> None:
    light = real_light("--uart0", f"pty:{tmp_path}/uart0")
    (found,) = find_lights([light.url()], SECONDS)
    assert found.component == 243


def test_everybody_at_an_address_is_called(real_light: START) -> None:
    """A light that listens on all addresses hears what is sent to all."""
    light = real_light("--uart0", "udpin:0.0.0.0:0")
    port = light.url().rpartition(":")[2]
    (found,) = find_lights([f"udp:127.255.255.255:{port}"], SECONDS)
    assert found.url.endswith(f":{port}")


def test_an_announced_sensor_is_found_and_a_vehicle_is_not() -> None:
    def announced(kind: int, name: str) -> bytes:
        what = message(
            "Announce", sys_name=name, sys_type=kind,
            services="imc+info://0.0.0.0/version/5;imc+udp://127.0.0.1:6009/;",
        )  # fmt: skip
        return encode(Packet(what, 0x8442, 0, EVERYONE, 255, 0.0))

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as peer:

        def announce() -> None:
            for datagram in (announced(6, "lamp"), announced(4, "drone"), b"noise"):
                for port in range(30100, 30105):
                    peer.sendto(datagram, ("127.0.0.1", port))

        timer = threading.Timer(0.3, announce)
        timer.start()
        found = find_lights(["imc:"], 1.5)
        timer.join()
    assert [(light.url, light.name) for light in found if "lamp" in light.name] == [
        ("udp:127.0.0.1:6009", "IMC 0x8442 lamp")
    ]
    assert not any("drone" in light.name for light in found)


def test_different_lights_of_the_same_ids_are_told_of() -> None:
    one = Found("udp:a", 1, 243, information("A"))
    twin = Found("udp:b", 1, 243, information("B"))
    other = Found("udp:c", 1, 244, information("C"))
    way = Found("tcp:a", 1, 243, information("A"))
    notes = {light.url: light.note for light in _warned([one, twin, other, way])}
    assert "udp:b" in notes["udp:a"]
    assert "udp:a" in notes["udp:b"]
    assert notes["udp:c"] == ""
    assert "udp:a" not in notes["tcp:a"]


def test_a_place_that_is_not_there_is_told_of() -> None:
    skipped: list[tuple[str, PharosError]] = []
    bad = ["/nonexistent/tty", "nonsense", "udp:127.0.0.1:0", "can:tin-cans/1"]
    assert find_lights(bad, 0.1, lambda place, error: skipped.append((place, error))) == []
    assert [place for place, _ in skipped] == bad


def test_the_command_has_a_line_a_light(
    real_light: START, capsys: pytest.CaptureFixture[str]
) -> None:
    url = real_light("--uart0", "udpin:127.0.0.1:0").url()
    assert main(["find", url, "--seconds", "1.5"]) == 0
    assert capsys.readouterr().out.startswith(url)
    assert main(["find", url, "--seconds", "1.5", "--json"]) == 0
    fields = json.loads(capsys.readouterr().out)
    assert (fields["url"], fields["component"]) == (url, 243)
    assert main(["find", "udp:127.0.0.1:9", "--seconds", "0.2"]) == 3
    assert "no light" in capsys.readouterr().err


def test_usual_places_are_places() -> None:
    places = usual_places()
    assert len(set(places)) == len(places)
    assert "tcp:127.0.0.1:5770" in places
    assert "can:pharos-udp" in places


AVAHI = """#!/bin/sh
echo "$@" > {asked}
cat <<'END'
+;lo;IPv4;Pharos 1;_mavlink._udp;local
=;lo;IPv4;Pharos 1;_mavlink._udp;local;a.local;{host};{port};"serial=1"
=;lo;IPv6;Pharos 1;_mavlink._udp;local;a.local;fe80::1;{port};"serial=1"
=;lo;IPv4;Printer;_ipp._tcp;local;b.local;10.0.0.9;631;
=;lo;IPv4;Wrong;_mavlink._udp;local;c.local;10.0.0.9;99999;
=;lo;IPv4
END
"""


def test_what_mdns_announces_is_a_place(
    real_light: START, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    url = real_light("--uart0", "udpin:127.0.0.1:0").url()
    _, host, port = url.split(":")
    script, asked = tmp_path / "avahi-browse", tmp_path / "asked"
    script.write_text(AVAHI.format(asked=asked, host=host, port=port))
    script.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    assert announced_places() == [url]
    assert "_mavlink._udp" in asked.read_text()
    (found,) = find_lights(announced_places(), SECONDS)
    assert found.url == url


def test_without_avahi_nothing_is_announced(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "/nonexistent")
    assert announced_places() == []
