# SPDX-License-Identifier: Apache-2.0
"""IMC packets in and out of bytes: the light's codec, beside PyPI's imcpy (compiled C++), on the
same packets, round after round in turn."""

from __future__ import annotations

import json
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

try:
    import imcpy
except ImportError:
    imcpy = None

VECTORS = Path(__file__).resolve().parents[1] / "vectors" / "imc.json"
ACTUATION = {*range(300, 317), 2000, 2001, 2002}
ROUNDS = 5
PACKETS = 20_000  # of a round
TIMES = 20
LIMIT_RATIO = 5.0

Figure = tuple[str, float, str]


def actuation_packets() -> list[bytes]:
    """One of each message of the actuation group, as peers send them, little endian."""
    chosen: dict[int, bytes] = {}
    for vector in json.loads(VECTORS.read_text()):
        if vector["id"] in ACTUATION and vector["endian"] == "little" and vector["case"] != "max":
            chosen.setdefault(vector["id"], bytes.fromhex(vector["hex"]))
    assert len(chosen) == len(ACTUATION)
    return [chosen[number] for number in sorted(chosen)]


def ours_ns(tools: Path, packets: list[bytes]) -> tuple[float, float]:
    """Nanoseconds per packet: found in a stream and decoded; encoded."""
    with tempfile.NamedTemporaryFile(prefix="pharos-imc-") as file:
        file.write(b"".join(packets))
        file.flush()
        output = subprocess.run(
            [tools / "imc_codec", file.name, str(TIMES)], check=True, capture_output=True, text=True
        ).stdout.split()
    if int(output[0]) != len(packets):
        raise SystemExit(f"bench: {output[0]} of {len(packets)} IMC packets were decoded")
    return float(output[1]), float(output[2])


def imcpy_ns(packets: list[bytes]) -> tuple[float, float]:
    deserialize = imcpy.Packet.deserialize
    begin = time.perf_counter()
    for data in packets:
        message = deserialize(data)
    middle = time.perf_counter()
    messages = [deserialize(data) for data in packets[:200]]
    start = time.perf_counter()
    for _ in range(len(packets) // len(messages)):
        for message in messages:
            message.serialize()
    end = time.perf_counter()
    each = 1e9 / len(packets)
    return (middle - begin) * each, (end - start) * each


def measure(tools: Path) -> tuple[list[Figure], float | None]:
    """Figures, and imcpy's cost of decoding over ours; None where imcpy does not install."""
    kinds = actuation_packets()
    packets = [kinds[i % len(kinds)] for i in range(PACKETS)]
    ours = []
    theirs = []
    for _ in range(ROUNDS):
        ours.append(ours_ns(tools, packets))
        if imcpy is not None:
            theirs.append(imcpy_ns(packets))
    decode, encode = (statistics.median(times) for times in zip(*ours, strict=True))
    figures: list[Figure] = [
        ("IMC: packets per second in", 1e9 / decode, "/s"),
        ("IMC: packets per second out", 1e9 / encode, "/s"),
        ("IMC: cost of a packet in", decode / 1e3, "µs"),
        ("IMC: cost of a packet out", encode / 1e3, "µs"),
    ]
    if not theirs:
        return figures, None
    their_decode, their_encode = (statistics.median(times) for times in zip(*theirs, strict=True))
    figures += [
        ("imcpy: cost of a packet in", their_decode / 1e3, "µs"),
        ("imcpy: cost of a packet out", their_encode / 1e3, "µs"),
    ]
    ratios = [t[0] / o[0] for o, t in zip(ours, theirs, strict=True)]
    return figures, statistics.median(ratios)
