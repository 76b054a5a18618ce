# SPDX-License-Identifier: Apache-2.0
"""The component's metadata: where it says it is, what it holds, and that it agrees with the light.

The schemas' rules are written out here from mavlink/mavlink's component_metadata/*.schema.json."""

from __future__ import annotations

import json
import lzma
import re
from collections.abc import Mapping
from typing import Any

import pytest

from ftp_client import CRC32, FtpClient, crc32
from harness import ACCEPTED, REQUEST_MESSAGE, Light
from parameters import value_of

METADATA = 397
PARAMETER = 1  # COMP_METADATA_TYPE_PARAMETER
SCHEME = "mftp://"

# Keys of the schemas, and the type of each. Nothing else may be there.
GENERAL = {
    "version": int,
    "vendorName": str,
    "modelName": str,
    "firmwareVersion": str,
    "hardwareVersion": str,
    "metadataTypes": list,
}
METADATA_TYPE = {
    "type": int,
    "uri": str,
    "fileCrc": int,
    "uriFallback": str,
    "fileCrcFallback": int,
    "translationUri": str,
    "translationUriFallback": str,
}
NUMBER = (int, float)
Schema = Mapping[str, type | tuple[type, ...]]
ROW: Schema = {
    "name": str,
    "type": str,
    "shortDesc": str,
    "longDesc": str,
    "units": str,
    "default": NUMBER,
    "decimalPlaces": int,
    "min": NUMBER,
    "max": NUMBER,
    "increment": NUMBER,
    "rebootRequired": bool,
    "group": str,
    "category": str,
    "volatile": bool,
    "values": list,
    "bitmask": list,
    "readOnly": bool,
}
VERSION = r"\d+\.\d+\.\d+(\.\d+)?"


def _conforms(found: dict[str, Any], schema: Schema, required: set[str]) -> None:
    assert required <= found.keys()
    assert found.keys() <= schema.keys()
    for key, value in found.items():
        kinds = schema[key]
        assert type(value) in (kinds if isinstance(kinds, tuple) else (kinds,)), key


def _request(light: Light) -> Any:
    assert light.mav.command_long(REQUEST_MESSAGE, METADATA).result == ACCEPTED
    return light.mav.recv("COMPONENT_METADATA")


def _fetch(light: Light, uri: str) -> bytes:
    assert uri.startswith(SCHEME)
    return FtpClient(light.mav).read(uri.removeprefix(SCHEME))


def _load(data: bytes, uri: str) -> Any:
    return json.loads(lzma.decompress(data) if uri.endswith(".xz") else data)


def _general(light: Light) -> dict[str, Any]:
    uri = _request(light).uri
    general: dict[str, Any] = _load(_fetch(light, uri), uri)
    return general


def _rows(light: Light) -> list[dict[str, Any]]:
    (entry,) = _general(light)["metadataTypes"]
    rows: list[dict[str, Any]] = _load(_fetch(light, entry["uri"]), entry["uri"])["parameters"]
    return rows


def test_the_message_says_where_and_which(light: Light) -> None:
    message = _request(light)
    assert message.time_boot_ms >= 1000
    assert message.file_crc == crc32(_fetch(light, message.uri))


def test_it_comes_only_when_asked(udp_light: Light) -> None:
    kinds = {message.get_type() for message in udp_light.collect(5)}
    assert "COMPONENT_METADATA" not in kinds


def test_general_file_follows_the_schema(udp_light: Light) -> None:
    general = _general(udp_light)
    _conforms(general, GENERAL, {"version", "metadataTypes"})
    assert general["version"] >= 1
    assert re.fullmatch(VERSION, general["firmwareVersion"])
    assert re.fullmatch(VERSION, general["hardwareVersion"])
    for entry in general["metadataTypes"]:
        _conforms(entry, METADATA_TYPE, {"type", "uri"})


def test_general_file_says_who_it_is(udp_light: Light) -> None:
    general = _general(udp_light)
    assert udp_light.mav.command_long(REQUEST_MESSAGE, 396).result == ACCEPTED
    basic = udp_light.mav.recv("COMPONENT_INFORMATION_BASIC")
    assert general["vendorName"] == basic.vendor_name
    assert general["modelName"] == basic.model_name
    assert general["firmwareVersion"] == basic.software_version


def test_parameter_file_is_the_one_with_that_checksum(light: Light) -> None:
    (entry,) = _general(light)["metadataTypes"]
    assert entry["type"] == PARAMETER
    data = _fetch(light, entry["uri"])
    assert entry["fileCrc"] == crc32(data)
    name = entry["uri"].removeprefix(SCHEME).encode()
    assert FtpClient(light.mav).ask(CRC32, name).number == entry["fileCrc"]


def test_parameter_file_is_smaller_for_being_compressed(udp_light: Light) -> None:
    (entry,) = _general(udp_light)["metadataTypes"]
    data = _fetch(udp_light, entry["uri"])
    assert len(data) < len(lzma.decompress(data)) / 3


def test_parameter_file_follows_the_schema(udp_light: Light) -> None:
    (entry,) = _general(udp_light)["metadataTypes"]
    content = _load(_fetch(udp_light, entry["uri"]), entry["uri"])
    _conforms(content, {"version": int, "parameters": list}, {"version", "parameters"})
    assert content["version"] >= 3
    for row in content["parameters"]:
        _conforms(row, ROW, {"name"})
        assert re.fullmatch(r"[.\-a-zA-Z0-9_{}]{1,16}", row["name"])
        assert row["type"] == "Float"
        assert row["min"] <= row["default"] <= row["max"]
        for choice in row.get("values", []):
            _conforms(choice, {"value": int, "description": str}, {"value", "description"})
        for bit in row.get("bitmask", []):
            _conforms(bit, {"index": int, "description": str}, {"index", "description"})


def test_every_parameter_has_a_row_and_its_default(udp_light: Light) -> None:
    """A light that has never been set up: what it answers are its defaults."""
    mav = udp_light.mav
    mav.send(mav.dialect.MAVLink_param_request_list_message(1, 243))
    values: dict[str, float] = {}
    while True:
        message = mav.recv("PARAM_VALUE")
        values[message.param_id] = value_of(message)
        if message.param_index == message.param_count - 1:
            break
    rows = {row["name"]: row for row in _rows(udp_light)}
    assert list(rows) == list(values)
    settable = [name for name, row in rows.items() if not row.get("readOnly")]
    assert {name: rows[name]["default"] for name in settable} == {
        name: values[name] for name in settable
    }


def test_rows_say_what_the_table_says(udp_light: Light) -> None:
    """Three rows of core/params_table.h, one of each kind."""
    rows = {row["name"]: row for row in _rows(udp_light)}
    assert rows["LGT_RESTORE"] == {
        "name": "LGT_RESTORE",
        "type": "Float",
        "group": "LIGHT",
        "shortDesc": "After a reset",
        "decimalPlaces": 0,
        "increment": 1,
        "default": 0,
        "min": 0,
        "max": 1,
        "values": [
            {"value": 0, "description": "off"},
            {"value": 1, "description": "as it was last commanded"},
        ],
        "rebootRequired": True,
    }
    assert rows["THR_SHUTDOWN"] == {
        "name": "THR_SHUTDOWN",
        "type": "Float",
        "group": "THERMAL",
        "shortDesc": "The lamp goes off here",
        "units": "degC",
        "decimalPlaces": 3,
        "increment": 0.001,
        "default": 100,
        "min": -40,
        "max": 150,
    }
    assert rows["LGT_SRC_EXCL"]["bitmask"] == [
        {"index": 0, "description": "MAVLink"},
        {"index": 1, "description": "DroneCAN"},
        {"index": 2, "description": "IMC"},
        {"index": 3, "description": "shell"},
    ]
    assert rows["LGT_SRC_NOW"]["readOnly"] is True
    assert rows["LGT_SRC_NOW"]["volatile"] is True


@pytest.mark.parametrize("param2", [0.0, 1.0])
def test_the_second_parameter_of_the_request_does_not_matter(
    udp_light: Light, param2: float
) -> None:
    assert udp_light.mav.command_long(REQUEST_MESSAGE, METADATA, param2).result == ACCEPTED
    assert udp_light.mav.recv("COMPONENT_METADATA").uri == "mftp://general.json"
