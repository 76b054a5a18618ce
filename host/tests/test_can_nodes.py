# SPDX-License-Identifier: Apache-2.0
"""`pharos can nodes`: who is on a bus, and who has whose id."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest
from dronecan import uavcan

from pharos.can_node import DronecanNode
from pharos.can_transfer import Header, Transfer
from pharos.cli import main
from pharos.cli.can import Census, Seen
from real_light import RealLight


def test_nodes_lists_the_light(
    can_light: tuple[RealLight, str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(("can", "nodes", can_light[1], "--json")) == 0
    node = json.loads(capsys.readouterr().out)
    assert (node["node"], node["name"], node["health"]) == (68, "org.pharos.light", "ok")
    assert len(node["unique_id"]) == 32


def test_nodes_with_one_id_are_both_listed(
    can_light: tuple[RealLight, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Two lights started alike: their unique ids differ."""
    folder = tmp_path / "second"
    folder.mkdir()
    bus = can_light[1]
    second = RealLight(folder, "--can0", f"udp:{bus.partition('/')[2]}")
    try:
        assert main(("can", "nodes", bus, "--json", "--seconds", "6")) == 0
        nodes = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
        assert main(("can", "nodes", bus, "--seconds", "6")) == 0
        lines = capsys.readouterr().out.splitlines()
    finally:
        second.close()
    assert [(node["node"], node["clash"]) for node in nodes] == [(68, True), (68, True)]
    unique_ids = {node["unique_id"] for node in nodes}
    assert len(unique_ids) == 2
    assert all("node id 68 is used twice, here by " in line for line in lines)
    assert {line.rpartition(" ")[2] for line in lines} == unique_ids


def _info(unique_id: int, uptime_s: int) -> Transfer:
    info = uavcan.protocol.GetNodeInfo.Response()
    info.status.uptime_sec = uptime_s
    info.hardware_version.unique_id[0] = unique_id
    return Transfer(Header(1, 5, 20, 10, False), 0, info, False)


def _status(uptime_s: int) -> Transfer:
    return Transfer(Header(341, 5), 0, uavcan.protocol.NodeStatus(uptime_sec=uptime_s), False)


@pytest.mark.parametrize(
    ("heard", "expected"),
    [
        ([_status(1), _info(7, 1), _info(7, 2), _status(2)], [(7, False)]),
        # two of one age are told apart by what they answer, or by their ages
        ([_status(1), _info(7, 1), _info(8, 1)], [(7, True), (8, True)]),
        ([_status(1), _status(90)], [(None, True), (None, True)]),
        ([_status(1), _status(90), _info(8, 90)], [(None, True), (8, True)]),
        # one that was reset is one
        ([_status(90), _info(7, 90), _status(0), _info(7, 0)], [(7, False)]),
    ],
)
def test_who_has_one_node_id(
    heard: list[Transfer], expected: list[tuple[int | None, bool]]
) -> None:
    node = SimpleNamespace(monitors=[], clock=lambda: 0, node_id=0)
    census = Census(cast(DronecanNode, node))
    for transfer in heard:
        node.monitors[0](transfer)
    found = [((entry.unique_id() or [None])[0], entry.is_clash) for entry in census.found()]
    assert found == expected


@pytest.mark.parametrize(
    ("flags", "told"), [(0, "software 1.2, "), (1, "software 1.2 (0badcafe), ")]
)
def test_commit_of_a_node_is_shown_if_it_tells_one(flags: int, told: str) -> None:
    info = uavcan.protocol.GetNodeInfo.Response()
    info.software_version.major, info.software_version.minor = 1, 2
    info.software_version.optional_field_flags = flags
    info.software_version.vcs_commit = 0x0BADCAFE
    assert told in str(Seen(5, uavcan.protocol.NodeStatus(), info))
