# SPDX-License-Identifier: Apache-2.0
"""The control socket: lock-step, faults, reset, bad input."""

from __future__ import annotations

import json
import re
import socket
import subprocess
import threading
from pathlib import Path
from typing import Any

import pytest

from echo_light import PATIENCE_S, Peer, Start

CONTROL_MD = Path(__file__).parents[2] / "boards" / "native" / "CONTROL.md"


def test_every_op_is_documented_and_every_documented_op_exists(start: Start) -> None:
    light = start()
    ops = {entry["op"] for entry in light.do("ops")["ops"]}
    documented = set(re.findall(r"^### `(\w+)`$", CONTROL_MD.read_text(), re.MULTILINE))
    assert documented == ops
    assert all(entry["help"] for entry in light.do("ops")["ops"])


def test_documented_exchanges_are_real(start: Start) -> None:
    light = start("--uart0", "udpin:127.0.0.1:0")
    Peer(light, "uart0").send(b"hello, light")
    exchanges = re.findall(r"^> (.*)\n< (.*)$", CONTROL_MD.read_text(), re.MULTILINE)
    assert len(exchanges) == len(light.do("ops")["ops"])
    for request, documented in exchanges:
        light.send_line(request.encode())
        reply, expected = light.read_line(), json.loads(documented)
        assert reply["ok"] is True, reply
        assert list(reply) == list(expected), request
        if "wires" in expected:
            assert list(reply["wires"]["uart0"]) == list(expected["wires"]["uart0"])
    assert light.process.wait(PATIENCE_S) == 0


def test_hello_tells_who_is_there(start: Start) -> None:
    reply = start("--seed", "7").do("hello", id="a")
    assert reply["id"] == "a"
    assert (reply["name"], reply["time"], reply["seed"], reply["now_us"]) == (
        "pharos", "virtual", 7, 0,
    )  # fmt: skip
    assert reply["reset_cause"] == "power-on"


def test_time_stands_still_until_told(start: Start) -> None:
    light = start("--uart3", "udpout:127.0.0.1:9")
    assert light.advance(0)["now_us"] == 0
    assert light.advance(999_999)["now_us"] == 999_999
    before = light.wire("uart3")["tx_datagrams"] + light.wire("uart3")["tx_drops"]
    assert light.advance(1)["now_us"] == 1_000_000
    after = light.wire("uart3")["tx_datagrams"] + light.wire("uart3")["tx_drops"]
    assert after > before


def test_an_advance_waits_for_the_bytes_it_awaits(start: Start) -> None:
    light = start("--uart0", "udpin:127.0.0.1:0")
    peer = Peer(light, "uart0")
    timer = threading.Timer(0.05, peer.send, [b"late"])
    timer.start()
    reply = light.advance(10, uart0=4)
    timer.join()
    assert reply["wires"]["uart0"] == {"rx_bytes": 4, "tx_bytes": 4, "tx_datagrams": 1}


def test_bytes_beyond_the_awaited_stay_for_the_next_advance(start: Start) -> None:
    light = start("--uart0", "udpin:127.0.0.1:0")
    peer = Peer(light, "uart0")
    peer.send(b"abcdef")
    assert light.advance(10, uart0=2)["wires"]["uart0"]["tx_bytes"] == 2
    assert light.advance(10, uart0=5)["wires"]["uart0"]["tx_bytes"] == 5
    assert light.advance(10)["wires"]["uart0"]["tx_bytes"] == 6
    assert peer.read(6) == b"abcdef"


def test_bytes_that_never_come_are_an_error_and_time_has_not_moved(start: Start) -> None:
    light = start("--uart0", "udpin:127.0.0.1:0")
    reply = light.ask("advance", us=10, await_ms=20, **{"await": {"uart0": 3}})
    assert reply == {
        "ok": False,
        "error": "await: uart0 has received 0 of 3 bytes after 20 ms",
    }
    assert light.do("hello")["now_us"] == 0


def test_requests_may_be_sent_ahead(start: Start) -> None:
    light = start()
    lines = [b'{"op":"advance","us":5,"id":%d}' % i for i in range(50)]
    light.control.sendall(b"\n".join(lines) + b"\n")
    replies = [light.read_line() for _ in lines]
    assert [reply["id"] for reply in replies] == list(range(50))
    assert replies[-1]["now_us"] == 250


def test_several_clients(start: Start) -> None:
    light = start()
    first, second = light.control, light.connect()
    light.advance(7)
    light.control = second
    assert light.do("hello")["now_us"] == 7
    second.close()
    light.control = first
    assert light.do("hello")["now_us"] == 7


def test_a_client_that_goes_stops_its_advance(start: Start) -> None:
    light = start()
    first = light.control
    light.control = light.connect()
    first.sendall(b'{"op":"advance","us":31536000000000000}\n')
    first.close()
    # A thousand years would take hours; it stopped somewhere on the way.
    assert light.do("hello")["now_us"] < 31536000000000000


BAD = [
    (b"nonsense", "not JSON"),
    (b"[1,2]", 'say {"op":"hello"}'),
    (b'{"op":7}', 'say {"op":"hello"}'),
    (b'{"op":"fly"}', 'unknown op "fly"'),
    (b'{"op":"advance"}', '"us" is missing'),
    (b'{"op":"advance","us":-1}', '"us" must be a whole number'),
    (b'{"op":"advance","us":1.5}', '"us" must be a whole number'),
    (b'{"op":"advance","us":1,"await":{"uart9":1}}', 'no wire "uart9"'),
    (b'{"op":"advance","us":1,"await":[1]}', '"await" must be an object'),
    (b'{"op":"fault","device":"nose","kind":"cold"}', 'no device "nose"'),
    (b'{"op":"fault","device":"uart0","kind":"cold"}', '"kind" must be lost'),
    (b'{"op":"fault","device":"uart0","kind":"lost"}', '"rate_ppm" is missing'),
    (b'{"op":"reset","cause":"boredom"}', '"cause" must be'),
    (b"[" * 3000, "nested deeper"),
    (b'{"op":"hello","op":"quit"}', "not JSON: duplicate"),
    (b'{"op":"\xff\xfe"}', "not JSON"),
    (b"x" * 100_000, "longer than 65536 bytes"),
]


@pytest.mark.parametrize(("line", "error"), BAD)
def test_bad_input_is_one_clear_line_and_the_connection_stays(
    start: Start, line: bytes, error: str
) -> None:
    light = start()
    light.send_line(line)
    reply = light.read_line()
    assert reply["ok"] is False
    assert error in reply["error"]
    assert "\n" not in reply["error"]
    assert light.do("hello")["name"] == "pharos"


def test_real_time_is_not_advanced(start: Start) -> None:
    reply = start(virtual=False).ask("advance", us=1)
    assert reply["error"] == "real time moves by itself; start with --time virtual"


def echo_with_faults(start: Start, seed: int, **fault: Any) -> bytes:
    light = start("--seed", str(seed), "--uart0", "udpin:127.0.0.1:0")
    light.do("fault", device="uart0", **fault)
    peer = Peer(light, "uart0")
    for i in range(1, 101):
        peer.send(bytes(range(100)))
        tx_bytes = light.advance(10, uart0=100 * i)["wires"]["uart0"]["tx_bytes"]
    data = peer.read(tx_bytes)
    assert peer.is_silent()
    peer.close()
    return data


# 10 000 bytes at 1 %: 100 faults, give or take five standard deviations (of 10).
def test_lost_bytes(start: Start) -> None:
    data = echo_with_faults(start, 1, kind="lost", rate_ppm=10_000, direction="rx")
    assert 9_850 <= len(data) <= 9_950


def test_doubled_bytes(start: Start) -> None:
    data = echo_with_faults(start, 1, kind="doubled", rate_ppm=10_000, direction="tx")
    assert 10_050 <= len(data) <= 10_150


def test_flipped_bits(start: Start) -> None:
    data = echo_with_faults(start, 1, kind="flipped", rate_ppm=10_000, direction="rx")
    changed = [(a, b) for a, b in zip(data, bytes(range(100)) * 100, strict=True) if a != b]
    assert 50 <= len(changed) <= 150
    assert all((a ^ b).bit_count() == 1 for a, b in changed)


def test_faults_are_those_of_the_seed(start: Start) -> None:
    fault = {"kind": "lost", "rate_ppm": 50_000}
    first = echo_with_faults(start, 1, **fault)
    assert first == echo_with_faults(start, 1, **fault)
    assert first != echo_with_faults(start, 2, **fault)


def test_a_fault_ends(start: Start) -> None:
    light = start("--uart0", "udpin:127.0.0.1:0")
    peer = Peer(light, "uart0")
    light.do("fault", device="uart0", kind="lost", rate_ppm=1_000_000)
    peer.send(b"gone")
    assert light.advance(0, uart0=4)["wires"]["uart0"]["tx_bytes"] == 0
    light.do("fault", device="uart0", kind="none")
    peer.send(b"here")
    light.advance(0, uart0=8)
    assert peer.read(4) == b"here"


@pytest.mark.parametrize("url", ["udpin:127.0.0.1:0", "tcpin:127.0.0.1:0", "pty:{folder}/tty"])
def test_a_reset_keeps_the_world_and_forgets_the_device(start: Start, url: str) -> None:
    station = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    station.bind(("127.0.0.1", 0))
    station.settimeout(PATIENCE_S)
    light = start("--uart0", url, "--uart3", f"udpout:127.0.0.1:{station.getsockname()[1]}")
    peer = Peer(light, "uart0")
    peer.send(b"before")
    light.advance(1_500_000, uart0=6)
    address = light.wire("uart0")["address"]
    reply = light.do("reset", id=5)
    assert (reply["id"], reply["now_us"], reply["reset_cause"]) == (5, 1_500_000, "pin")
    hello = light.do("hello")
    assert (hello["now_us"], hello["boot_us"]) == (1_500_000, 1_500_000)
    peer.send(b"after")
    reply = light.advance(1_000_000, uart0=11)
    assert reply["now_us"] == 2_500_000
    assert light.wire("uart0")["address"] == address
    assert peer.read(11) == b"beforeafter"
    # Causes of Zephyr's hwinfo: power-on is 8, the pin 1. Uptime began anew: again "tick 1".
    lines = [station.recv(100) for _ in range(4)]
    assert lines == [b"boot 8\n", b"tick 1\n", b"boot 1\n", b"tick 1\n"]
    assert light.quit() == 0
    peer.close()
    station.close()


def test_requests_sent_behind_a_reset_are_answered_after_it(start: Start) -> None:
    light = start()
    light.control.sendall(
        b'{"op":"reset","id":1}\n{"op":"hello","id":2}\n{"op":"reset","cause":"watchdog","id":3}\n{"op":"hello","id":4}\n'
    )
    replies = [light.read_line() for _ in range(4)]
    assert [reply["id"] for reply in replies] == [1, 2, 3, 4]
    assert [reply["reset_cause"] for reply in replies] == ["pin", "pin", "watchdog", "watchdog"]


def test_a_hundred_resets_leave_no_descriptor_behind(start: Start) -> None:
    light = start(
        "--uart0", "udpin:127.0.0.1:0", "--uart1", "tcpin:127.0.0.1:0", "--uart2", "pty:{folder}/t"
    )
    peers = [Peer(light, name) for name in ("uart0", "uart1", "uart2")]
    folder = Path(f"/proc/{light.process.pid}/fd")
    for peer in peers:
        peer.send(b"x")
    light.advance(1, uart0=1, uart1=1, uart2=1)
    before = len(list(folder.iterdir()))
    for _ in range(100):
        light.advance(1)
        light.do("reset")
    assert len(list(folder.iterdir())) == before


def run_trace(start: Start, seed: int) -> bytes:
    wires = ("--uart0", "udpin:127.0.0.1:0", "--uart1", "tcpin:127.0.0.1:0")
    light = start("--seed", str(seed), "--trace", "{folder}/trace", *wires)
    light.do("fault", device="uart0", kind="doubled", rate_ppm=100_000)
    udp, tcp = Peer(light, "uart0"), Peer(light, "uart1")
    sent = 0
    for i in range(200):
        udp.send(bytes([i]) * 10)
        tcp.send(bytes([i]) * 10)
        sent += 10
        light.advance(12_345, uart0=sent, uart1=sent)
        if i == 100:
            light.do("reset")
    assert light.quit() == 0
    udp.close()
    tcp.close()
    trace: bytes = (light.folder / "trace").read_bytes()
    return trace


def test_same_seed_and_inputs_same_trace_to_the_byte(start: Start) -> None:
    first = run_trace(start, 1)
    assert first.count(b"\n") > 500
    assert first == run_trace(start, 1)
    assert first != run_trace(start, 2)


def test_free_running_virtual_time_ends_at_until(binary: Path) -> None:
    result = subprocess.run(
        [binary, "--time", "virtual", "--console", "none", "--uart3", "stdio", "--until", "1h"],
        stdin=subprocess.DEVNULL, capture_output=True, timeout=PATIENCE_S, check=True,
    )  # fmt: skip
    lines = result.stdout.decode().split("\n")
    # A tick each second; the one at 3600 s is not reached: the end comes first.
    assert lines[0] == "boot 8"
    assert lines[-2] == "tick 3599"


@pytest.mark.parametrize(
    ("options", "error"),
    [
        (["--fly"], 'unknown option "--fly"; --help lists all'),
        (["--uart0"], "--uart0 needs a value: --uart0 WIRE"),
        (["--uart0", "carrier:pigeon"], '"carrier:pigeon" is no wire'),
        (["--uart0", "udpin:127.0.0.1"], "is not HOST:PORT"),
        (["--uart0", "udpin:127.0.0.1:70000"], "whole number from 0 to 65535"),
        (["--uart0", "udpin:::1:5"], "goes in brackets"),
        (["--uart0", "udppair:127.0.0.1:1"], "say udppair:BIND_HOST:PORT,SEND_HOST:PORT"),
        (["--uart0", "serial:/dev/ttyUSB0"], "say serial:DEV,BAUD"),
        (["--uart0", "serial:/dev/ttyUSB0,12345"], "no standard baud rate"),
        (["--time", "lunch"], '"lunch" is neither real nor virtual'),
        (["--until", "5"], "not a duration such as 500ms"),
        (["--seed", "-1"], "whole number"),
    ],
)
def test_a_wrong_option_is_one_line_and_status_2(
    binary: Path, options: list[str], error: str
) -> None:
    result = subprocess.run(
        [binary, *options], capture_output=True, timeout=PATIENCE_S, check=False
    )
    assert result.returncode == 2
    text = result.stderr.decode()
    assert error in text
    assert text.count("\n") == 1


def test_help_names_every_option(binary: Path) -> None:
    text = subprocess.run([binary, "--help"], capture_output=True, check=True).stdout.decode()
    for option in ("time", "until", "seed", "trace", "uart0", "uart3", "console", "control"):
        assert f"--{option} " in text
    assert max(len(line) for line in text.split("\n")) <= 100
