# SPDX-License-Identifier: Apache-2.0
"""What MAVSDK sees of a light: a program of its own, since MAVSDK brings threads and a C++ library.

    python mavsdk_client.py HOST:PORT FOLDER [broadcast]

writes what it saw to FOLDER/seen.json. It waits for events, never for time;
each wait ends after LIMIT_S."""

from __future__ import annotations

import contextlib
import json
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from mavsdk.component_type import ComponentType
from mavsdk.mavsdk import Configuration, Mavsdk
from mavsdk.plugins.component_metadata.component_metadata import (
    ComponentMetadata,
    MetadataType,
)
from mavsdk.plugins.ftp.ftp import Ftp, FtpError, FtpResult
from mavsdk.plugins.mavlink_direct.mavlink_direct import MavlinkDirect, MavlinkMessage
from mavsdk.plugins.param.param import Param, ParamError, ProtocolVersion

LIGHT = 243
LIMIT_S = 50.0


def wait(event: threading.Event, what: str) -> None:
    if not event.wait(LIMIT_S):
        raise TimeoutError(f"no {what} within {LIMIT_S:g} s")


def discover(sdk: Any) -> Any:
    """The system that the light's heartbeats make."""
    found = threading.Event()
    sdk.subscribe_on_new_system(lambda _: found.set())
    if not sdk.get_systems():
        wait(found, "system")
    return sdk.get_systems()[0]


class Direct:
    """Messages as they are."""

    def __init__(self, system: Any) -> None:
        self.plugin = MavlinkDirect(system)

    def until(self, kind: str, where: Callable[[dict[str, Any]], bool], component: int) -> Any:
        """The next message of that kind and component for which it holds."""
        seen = threading.Event()
        kept: list[dict[str, Any]] = []

        def take(message: Any, _: Any) -> None:
            fields = json.loads(message.fields_json)
            if message.component_id == component and not seen.is_set() and where(fields):
                kept.append(fields)
                seen.set()

        handle = self.plugin.subscribe_message(kind, take)
        wait(seen, kind)
        self.plugin.unsubscribe_message(handle)
        return kept[0]

    def command(self, number: int, *params: float, component: int = LIGHT) -> dict[str, Any]:
        """The final acknowledgement of a COMMAND_LONG."""
        seven = (list(params) + [0.0] * 7)[:7]
        fields: dict[str, float] = {
            "target_system": 1, "target_component": component, "command": number, "confirmation": 0,
        }  # fmt: skip
        fields |= {f"param{i + 1}": value for i, value in enumerate(seven)}
        message = MavlinkMessage("COMMAND_LONG", 0, 0, 1, component, json.dumps(fields))
        ack: dict[str, Any] = json.loads(self.plugin.send_command(message).fields_json)
        return ack


def parameters(system: Any) -> dict[str, Any]:
    param = Param(system)
    with contextlib.suppress(ParamError):  # 4.1.0 says UNKNOWN, and selects
        param.select_component(LIGHT, ProtocolVersion.V1)
    listed = param.get_all_params()
    param.set_param_float("STRB_MIN", 0.02)
    refusals = {}
    for name, value in (("STRB_MIN", 20), ("LGT_SRC_NOW", 1), ("NOT_THERE", 1)):
        try:
            param.set_param_float(name, value)
        except ParamError as error:
            refusals[name] = error.result.name
    return {
        "floats": {p.name: p.value for p in listed.float_params},
        "others": len(listed.int_params) + len(listed.custom_params),
        "after_set": param.get_param_float("STRB_MIN"),
        "refusals": refusals,
    }


def download(ftp: Any, name: str, folder: Path, burst: bool) -> str:
    """Fetches a file; the result's name."""
    ended = threading.Event()
    results = []

    def take(result: Any, _progress: Any, _: Any) -> None:
        if result != FtpResult.NEXT:
            results.append(result.name)
            ended.set()

    ftp.download_async(name, str(folder), burst, take)
    wait(ended, f"end of the download of {name}")
    return str(results[0])


def files(system: Any, folder: Path) -> dict[str, Any]:
    ftp = Ftp(system)
    ftp.set_target_compid(LIGHT)
    entries = ftp.list_directory("/").entries
    names = [entry.name for entry in entries]
    results, same = {}, {}
    for name in names:
        for burst in (True, False):
            results[f"{name} burst={burst}"] = download(ftp, name, folder, burst)
            local = str(folder / name)
            same[f"{name} burst={burst}"] = bool(ftp.are_files_identical(local, name))
            (folder / name).unlink()
    try:
        ftp.remove_file(names[0])
        refusal = "none"
    except FtpError as error:
        refusal = error.result.name
    return {"names": names, "results": results, "same": same, "remove": refusal}


def metadata(system: Any) -> Any:
    plugin = ComponentMetadata(system)
    complete = threading.Event()

    def take(update: Any, _: Any) -> None:
        if update.compid == LIGHT and update.type == MetadataType.ALL_COMPLETED:
            complete.set()

    plugin.subscribe_metadata_available(take)
    plugin.request_component(LIGHT)
    wait(complete, "metadata")
    return json.loads(plugin.get_metadata(LIGHT, MetadataType.PARAMETER).json_metadata)


def look(address: str, folder: Path) -> dict[str, Any]:
    configuration = Configuration.create_with_component_type(ComponentType.GROUND_STATION)
    with Mavsdk(configuration) as sdk:
        sdk.add_any_connection(f"udpout://{address}")
        system = discover(sdk)
        direct = Direct(system)
        heartbeat = direct.until("HEARTBEAT", lambda _: True, LIGHT)
        seen: dict[str, Any] = {
            "system": system.get_system_id(),
            "has_autopilot": system.has_autopilot(),
            "heartbeat": heartbeat,
            "components": system.component_ids(),
        }
        seen["acks"] = {
            "on": direct.command(405, 1),
            "configure": direct.command(406, 1, 40, 0.5, 10),
            "too_bright": direct.command(406, 1, 400, 0.5, 10),
            "unknown": direct.command(12345),
        }
        seen["status"] = direct.until(
            "ILLUMINATOR_STATUS", lambda status: status["brightness"] == 40, LIGHT
        )
        seen["acks"]["self_test"] = direct.command(31010, 1, 5)
        seen["parameters"] = parameters(system)
        seen["files"] = files(system, folder)
        seen["metadata"] = metadata(system)
        return seen


def broadcast(address: str, _: Path) -> dict[str, Any]:
    """Commands to all components, beside an autopilot: the acknowledgement that ends each."""
    configuration = Configuration.create_with_component_type(ComponentType.GROUND_STATION)
    with Mavsdk(configuration) as sdk:
        sdk.add_any_connection(f"udpout://{address}")
        direct = Direct(discover(sdk))
        for component in (1, LIGHT):
            direct.until("HEARTBEAT", lambda _: True, component)
        # COMPONENT_ARM_DISARM, REQUEST_MESSAGE of ATTITUDE_QUATERNION, which only the vehicle has
        return {
            "arm": direct.command(400, 1, component=0),
            "request": direct.command(512, 31, component=0),
            "named": direct.command(400, 1),
        }


if __name__ == "__main__":
    does = broadcast if sys.argv[3:] == ["broadcast"] else look
    result = does(sys.argv[1], Path(sys.argv[2]))
    Path(sys.argv[2], "seen.json").write_text(json.dumps(result), encoding="utf-8")
