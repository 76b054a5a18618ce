# SPDX-License-Identifier: Apache-2.0
"""Faults of the CAN bus, injected by the control socket, and how the controller takes them."""

from __future__ import annotations

from typing import Any

import pytest

from can_node import (
    ACTIVE,
    BUS_OFF,
    EAGAIN,
    ENETUNREACH,
    IDE,
    MANUAL,
    PASSIVE,
    WARNING,
    NewNode,
    Node,
    message,
    only,
)


def receive_with_fault(node: NewNode, seed: int, **fault: Any) -> tuple[list[int], Node]:
    light = node("--seed", str(seed))
    light.start()
    light.light.do("fault", device="can0", **fault)
    heard = []
    for at in range(0, 10_000, 100):
        light.send(*(message(at + k) for k in range(100)))
        heard += [int(line[0], 16) for line in only(light.advance(1)[0], "rx")]
    return heard, light


# 10 000 frames at 1 %: 100 faults, give or take five standard deviations (of 10).
def test_lost_frames(node: NewNode) -> None:
    heard, light = receive_with_fault(node, 1, kind="lost", rate_ppm=10_000, direction="rx")
    assert 9_850 <= len(heard) <= 9_950
    assert light.count("faults") == 10_000 - len(heard)
    assert heard == sorted(set(heard))


def test_doubled_frames(node: NewNode) -> None:
    heard, _ = receive_with_fault(node, 1, kind="doubled", rate_ppm=10_000)
    assert 10_050 <= len(heard) <= 10_150
    assert sorted(set(heard)) == list(range(10_000))


def test_reordered_frames(node: NewNode) -> None:
    heard, _ = receive_with_fault(node, 1, kind="reordered", rate_ppm=10_000)
    swapped = [a for a, b in zip(heard, heard[1:], strict=False) if b < a]
    assert 50 <= len(swapped) <= 150
    assert all(heard[heard.index(a) + 1] == a - 1 for a in swapped)
    # One may still be held back at the end.
    assert set(range(10_000)) - set(heard) <= {9_999}


def test_faults_are_those_of_the_seed(node: NewNode) -> None:
    fault = {"kind": "lost", "rate_ppm": 50_000}
    first, _ = receive_with_fault(node, 1, **fault)
    assert first == receive_with_fault(node, 1, **fault)[0]
    assert first != receive_with_fault(node, 2, **fault)[0]


def test_destroyed_frames_are_not_heard_and_make_a_receiver_passive(node: NewNode) -> None:
    light = node()
    light.start()
    light.light.do("fault", device="can0", kind="flipped", rate_ppm=1_000_000, direction="rx")
    light.send(*(message(k) for k in range(128)))
    said, _ = light.advance()
    assert only(said, "rx") == []
    assert only(said, "state") == [[str(WARNING), "0", "96"], [str(PASSIVE), "0", "128"]]


def test_destroyed_frames_are_sent_again_until_bus_off(node: NewNode) -> None:
    light = node()
    light.start()
    light.light.do("fault", device="can0", kind="flipped", rate_ppm=1_000_000, direction="tx")
    light.command("send 7 0 0 1")
    said, frames = light.advance()
    assert frames == []
    assert [line[0] for line in only(said, "state")] == [
        str(s) for s in (WARNING, PASSIVE, BUS_OFF)
    ]
    assert only(said, "sent") == [["7", str(-ENETUNREACH)]]
    light.light.do("fault", device="can0", kind="none")
    # 128 times 11 bits at 1 Mbit/s
    assert only(light.advance(1407)[0], "state") == []
    assert only(light.advance(1)[0], "state") == [[str(ACTIVE), "0", "0"]]
    light.command("send 8 0 0 1")
    assert [frame.arbitration_id for frame in light.advance()[1]] == [8]


def test_half_of_them_destroyed_all_arrive(node: NewNode) -> None:
    light = node()
    light.start()
    light.light.do("fault", device="can0", kind="flipped", rate_ppm=50_000, direction="tx")
    light.command("send 100 0 1 200")
    said, frames = light.advance(1_000_000)
    assert [frame.arbitration_id for frame in frames] == list(range(0x100, 0x100 + 200))
    assert all(line[1] == "0" for line in only(said, "sent"))
    assert light.count("faults") > 0


def test_bus_off_in_manual_mode(node: NewNode) -> None:
    light = node()
    light.start(MANUAL)
    light.light.do("fault", device="can0", kind="bus-off")
    assert only(light.advance(10_000_000)[0], "state") == [[str(BUS_OFF), "255", "0"]]
    light.command("send 1 0 0 1")
    assert only(light.advance()[0], "done") == [[str(-ENETUNREACH)]]
    light.command("recover 5")
    said, _ = light.advance(5_000)
    assert only(said, "state") == [[str(ACTIVE), "0", "0"]]
    assert only(said, "done") == [["0"]]


def test_bus_off_held(node: NewNode) -> None:
    light = node()
    light.start()
    light.light.do("fault", device="can0", kind="bus-off", hold_us=1_000_000)
    light.send(message(1))
    said, _ = light.advance(1_000_000)
    assert [line[0] for line in only(said, "state")] == [str(BUS_OFF)]
    assert only(said, "rx") == []
    assert only(light.advance(1407)[0], "state") == []
    assert only(light.advance(1)[0], "state") == [[str(ACTIVE), "0", "0"]]


@pytest.mark.parametrize("bus", ["udp:CHANNEL", "udp:CHANNEL,paced"])
def test_an_interface_that_goes_and_comes_back(node: NewNode, bus: str) -> None:
    light = node(bus=bus)
    light.start()
    light.light.do("fault", device="can0", kind="gone")
    light.command("send 20 0 0 4")
    light.send(message(1))
    said, frames = light.advance(1_500_000)
    assert frames == []
    assert only(said, "rx") == []
    assert only(said, "state") == [[str(PASSIVE), "128", "0"]]
    # Three wait in the mailboxes; there was no room for a fourth within a second.
    assert only(said, "done") == [[str(-EAGAIN)]]
    light.light.do("fault", device="can0", kind="none")
    light.send(message(2))
    said, frames = light.advance(10_000)
    assert [frame.arbitration_id for frame in frames] == [0x20, 0x21, 0x22]
    assert only(said, "rx") == [["2", str(IDE), "0"]]
    assert only(said, "state") == [[str(WARNING), "127", "0"]]


def test_unknown_faults(node: NewNode) -> None:
    light = node().light
    kinds = '"kind" must be lost, flipped, doubled, reordered, gone, bus-off or none'
    assert light.ask("fault", device="can0", kind="smelly")["error"] == kinds
    assert "rate_ppm" in light.ask("fault", device="can0", kind="lost")["error"]
    reply = light.ask("fault", device="can0", kind="lost", rate_ppm=1, direction="up")
    assert reply["error"] == '"direction" must be rx, tx or both'
