# SPDX-License-Identifier: Apache-2.0
"""IMC's codec where the golden packets of tests/vectors do not reach, and `pharos imc`."""

from __future__ import annotations

import pytest

from pharos.cli.imc import parse_message
from pharos.errors import UsageError
from pharos.imc import ImcError, Packet, Stream, decode, encode, message

LAMP = encode(Packet(message("SetLedBrightness", name="lamp", value=128)))
BEAT = encode(Packet(message("Heartbeat")), big_endian=True)


@pytest.mark.parametrize("chunk", [1, 2, 3, 19, 1000])
def test_stream_finds_packets_in_any_chunks_and_behind_noise(chunk: int) -> None:
    data = (
        b"\x54\x54\xfe\x00noise" + LAMP + b"\xfe" + BEAT + LAMP[:-1] + b"\x00" + LAMP
    )  # and a wrong checksum
    stream = Stream()
    found = [
        packet
        for start in range(0, len(data), chunk)
        for packet in stream.feed(data[start : start + chunk])
    ]
    assert [packet.name for packet in found] == [
        "SetLedBrightness", "Heartbeat", "SetLedBrightness",
    ]  # fmt: skip


def test_fields_not_given_are_empty() -> None:
    packet = decode(encode(Packet(message("EntityParameters", name="Lämp"))))
    assert packet["name"] == "Lämp".encode()
    assert packet["params"] == []


@pytest.mark.parametrize(
    ("name", "fields"),
    [
        ("SetLedBrightness", {"value": 256}),
        ("SetLedBrightness", {"value": -1}),
        ("SetPWM", {"period": 1 << 32}),
        ("SetServoPosition", {"value": 1e39}),
        ("LcdControl", {"text": b"x" * 65536}),
        ("LcdControl", {"text": b"x" * 65534}),
        ("SetServoPosition", {"value": "much"}),
    ],
)
def test_values_that_no_packet_holds_are_refused(name: str, fields: dict[str, object]) -> None:
    with pytest.raises(ImcError):
        encode(Packet(message(name, **fields)))


def test_headers_that_no_packet_has_are_refused() -> None:
    with pytest.raises(ImcError):
        encode(Packet(message("Heartbeat"), dst_ent=256))


def test_messages_and_fields_that_do_not_exist_are_refused() -> None:
    with pytest.raises(ImcError):
        message("SetLedBrightnes")
    with pytest.raises(ImcError):
        message("SetLedBrightness", level=1)


def test_messages_from_the_command_line() -> None:
    made = parse_message("setledbrightness", ["name=lamp", "value=0x80"])
    assert made == message("SetLedBrightness", name="lamp", value=128)
    made = parse_message("SetEntityParameters", ["name=Lamp", "params=A=1,B=-2"])
    assert [(p["name"], p["value"]) for p in made["params"]] == [(b"A", b"1"), (b"B", b"-2")]
    assert parse_message("SetThrusterActuation", ["value=-0.5"])["value"] == -0.5


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["SetLed"], "is no message"),
        (["SetLedBrightness", "value"], "is no FIELD=VALUE"),
        (["SetLedBrightness", "level=1"], "its fields: name, value"),
        (["Heartbeat", "x=1"], "its fields: none"),
        (["SetLedBrightness", "value=much"], "is no number"),
    ],
)
def test_what_is_not_understood_is_said_in_one_line(words: list[str], said: str) -> None:
    with pytest.raises(UsageError, match=said) as error:
        parse_message(words[0], words[1:])
    assert "\n" not in str(error.value)
