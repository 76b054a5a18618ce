# SPDX-License-Identifier: Apache-2.0
"""The committed vectors are those of the JSON files, and the host's codec agrees with them."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[3]
VECTORS = ROOT / "tests" / "vectors"
sys.path.insert(0, str(ROOT / "host" / "src"))

from pharos import imc  # noqa: E402

GOOD = json.loads((VECTORS / "imc.json").read_text())
MALFORMED = json.loads((VECTORS / "imc_malformed.json").read_text())


def _name(vector: dict[str, Any]) -> str:
    return f"{vector.get('name', '')}-{vector['case']}-{vector['endian']}"


def test_committed_vectors_are_those_of_the_script() -> None:
    made = subprocess.run(
        [sys.executable, VECTORS / "make_imc.py"], check=True, capture_output=True
    ).stdout
    assert made == (VECTORS / "imc_vectors.h").read_bytes()


@pytest.mark.parametrize("vector", GOOD, ids=_name)
def test_the_hosts_codec_reads_and_writes_every_vector(vector: dict[str, Any]) -> None:
    data = bytes.fromhex(vector["hex"])
    packet = imc.decode(data)
    assert packet.name == vector["name"]
    header = vector["header"]
    assert (packet.src, packet.src_ent) == (header["src"], header["src_ent"])
    assert (packet.dst, packet.dst_ent) == (header["dst"], header["dst_ent"])
    for name, value in vector["fields"].items():
        if isinstance(value, int):
            assert packet[name] == value
        elif isinstance(value, str) and not vector["raw"].get(name, "").startswith("0x"):
            raw = vector["raw"].get(name)
            assert packet[name] == (bytes.fromhex(raw) if raw else value.encode())
    assert imc.encode(packet, big_endian=vector["endian"] == "big") == data


@pytest.mark.parametrize("vector", MALFORMED, ids=_name)
def test_the_hosts_codec_refuses_what_a_mature_receiver_does(vector: dict[str, Any]) -> None:
    data = bytes.fromhex(vector["hex"])
    if vector["peer_verdict"].startswith("accept"):
        imc.decode(data)
    else:
        with pytest.raises(imc.ImcError):
            imc.decode(data)
