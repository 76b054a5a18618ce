# SPDX-License-Identifier: Apache-2.0
"""`pharos check` on right lights and on lights with one fault each, in simulated time."""

from __future__ import annotations

import re
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from checking import OPTICAL_FAULTS, checked, failing, on_simulator
from model_light import ModelLight
from pharos import (
    Light,
    LinkError,
    MavlinkConnection,
    SilentError,
    Simulator,
    Target,
    UsageError,
    find_dialect,
    load_dialect,
)
from pharos.check import (
    REQUIREMENTS,
    Level,
    Report,
    find,
    selected,
)
from pharos.connection import signing_time
from pharos.parameters import Parameters
from real_light import BINARY, ROOT

# What each fault breaks: the must that names it, and those that cannot hold with it either.
FAULTS: dict[str, tuple[str, ...]] = {
    "heartbeat every 4 s": ("HB-1",),
    "says it is a computer": ("HB-3",),
    "says version 0": ("HB-7",),
    "changes its type": ("HB-9", "HB-3"),
    "lacks its information": ("INF-1", "INF-2", "INF-3", "INF-6"),
    "serial number fills its field": ("INF-2",),
    "boot time stays 0": ("INF-3",),
    "information comes twice": ("INF-6",),
    "accepts, and sends no status": ("ST-1",),
    "uptime in seconds": ("ST-3",),
    "on is 255": ("ST-4",),
    "bitmask with a fourth bit": ("ST-5",),
    "reports a mode that it lacks": ("ST-6", "CF-1"),
    "an undefined error": ("ST-7",),
    "brightness as a fraction": ("ST-8", "CF-4", "CF-14"),
    "rounds brightness to tens": ("ST-8", "CF-4", "CF-14"),
    "range of periods upside down": ("ST-9",),
    "period in ms": ("ST-9", "CF-6", "CF-14"),
    "temperature in kelvin": ("ST-10",),
    "stream is of old settings": ("ST-11",),
    "acknowledges before it switches": (
        "SW-1", "SW-2", "SW-4", "SW-5", "CF-13", "CM-10", "CM-12", "CM-13", "WR-14",
    ),
    "cannot be switched off": (
        "SW-2", "SW-5", "CM-8", "CM-9", "CM-10", "WR-8", "WR-9", "WR-12", "WR-14",
    ),
    "takes 2 for on": ("SW-3",),
    "NaN is on": ("SW-3",),
    "switches though it denies": ("SW-4",),
    "on switches off": ("SW-5", "CM-12"),
    "on means full brightness": ("SW-6", "CF-14"),
    "lacks a mode of its bitmask": ("CF-1",),
    "takes mode 3": ("CF-2",),
    "denies 100 %": ("CF-4",),
    "clamps brightness": ("CF-5",),
    "denies its longest period": ("CF-6",),
    "clamps periods": ("CF-7",),
    "denies a duty cycle of 100 %": ("CF-8",),
    "clamps the duty cycle": ("CF-9",),
    "takes over NaN": ("CF-10",),
    "takes half of it": ("CF-12",),
    "settings switch it on": ("CF-13",),
    "rejects the same again": ("CF-15",),
    "acknowledges twice": ("CM-1",),
    "is slow now and then": ("CM-2",),
    "acknowledges to 1/1": ("CM-4", "CM-17"),
    "accepts unknown commands": ("CM-6",),
    "is silent about unknown commands": ("CM-6",),
    "sends before it acknowledges": ("CM-7",),
    "takes others' components": ("CM-8",),
    "takes others' systems": ("CM-9",),
    "does not hear broadcasts": ("CM-10",),
    "takes no confirmation": ("CM-12",),
    "ignores COMMAND_INT": ("CM-13",),
    "does nothing for COMMAND_INT": ("CM-13",),
    "accepts requests for what it lacks": ("CM-15",),
    "acknowledges to its first client": ("CM-17",),
    "ignores intervals": ("IV-2", "IV-8"),
    "does not stop": ("IV-3", "IV-8"),
    "has no default rate": ("IV-4",),
    "takes any negative interval": ("IV-5",),
    "takes intervals for what it lacks": ("IV-6",),
    "intervals in ms": ("IV-8",),
    "answers in MAVLink 1": ("WR-1",),
    "zeros are not cut off": ("WR-4",),
    "refuses payloads with zeros": ("WR-5",),
    "sequence number stays": ("WR-6",),
    "every third heartbeat is damaged": ("WR-7",),
    "does not look at checksums": ("WR-8",),
    "ignores unknown flags": ("WR-9",),
    "refuses compatibility flags": ("WR-10",),
    "is deaf after garbage": ("WR-11",),
    "is deaf after half a frame": ("WR-12",),
    "takes whole frames only": ("WR-13",),
    "takes one frame at a time": ("WR-14",),
    "is deaf after an unknown message": ("WR-15",),
    "leaves one parameter out": ("PM-2",),
    "two parameters of one name": ("PM-3", "PM-4"),
    "mixes names up": ("PM-4",),
    "counts parameters from 1": ("PM-5",),
    "tells parameters only when named": ("PM-6",),
    "tells others' parameters": ("PM-7",),
    "tells other systems' parameters": ("PM-7",),
    "sets without a word": ("PM-8",),
    "knows any name": ("PM-9",),
    "renames a parameter": ("PM-11",),
    "has no FTP": (
        "FT-1", "FT-2", "FT-3", "FT-4", "FT-5", "FT-6", "MD-1", "MD-2", "MD-3", "MD-4",
    ),
    "answers with the same number": ("FT-2",),
    "fails without a reason": ("FT-3",),
    "fails at unknown opcodes": ("FT-4",),
    "forgets its answers": ("FT-5",),
    "has no end of file": ("FT-6",),
    "keeps sessions open": ("FT-6",),
    "general file is missing": ("MD-1", "MD-2", "MD-3", "MD-4"),
    "wrong CRC of the general file": ("MD-2",),
    "metadata is no JSON": ("MD-3", "MD-4"),
    "metadata names no file": ("MD-4",),
    "gimbal does not know itself": ("GB-1", "GB-2"),
    "gimbal's limits in degrees": ("GB-2",),
    "gimbal's limits upside down": ("GB-2",),
    "gimbal is still": ("GB-3",),
    "quaternion too long": ("GB-4",),
    "light answers for its gimbal": ("GB-5", "GB-1", "GB-2"),
}  # fmt: skip


# --- right lights ---------------------------------------------------------------------------------
def test_a_right_light_passes_all_that_it_offers() -> None:
    light = ModelLight()
    report = checked(light)
    assert (report.broken(), failing(report, Level.SHOULD), report.left) == ([], [], "")
    assert report.passed
    skipped = {r.requirement.group for r in report.results if r.outcome == "not offered"}
    assert skipped == {"GB", "SG", "OP"}
    assert not light.enable


def test_a_light_with_a_gimbal_is_right_too() -> None:
    report = checked(ModelLight(gimbal=True))
    assert report.broken() == []
    assert all(r.outcome == "passed" for r in report.results if r.requirement.group == "GB")


def test_a_light_with_one_mode_is_right_too() -> None:
    assert checked(ModelLight(modes=1)).broken() == []


@pytest.mark.parametrize(
    "wire", ["udpin:127.0.0.1:0", "tcpin:127.0.0.1:0", "pty:{folder}/uart0"], ids=lambda w: w[:3]
)
def test_our_light_passes(binary: Path, wire: str) -> None:
    with Simulator(binary, {"uart0": wire}) as sim:
        connection = sim.connect("uart0")
        report = on_simulator(sim, connection)
    _is_ours(report)


def test_our_light_passes_through_the_can_tunnel(binary: Path) -> None:
    with Simulator(binary, {"can0": "udp:127.255.255.255:{port}"}) as sim:
        report = on_simulator(sim, sim.connect("can0"))
    _is_ours(report)


def _is_ours(report: Report) -> None:
    assert (report.broken(), report.left) == ([], "")
    # The native board has no hardware whose version there could be.
    assert failing(report, Level.SHOULD) == ["INF-4"]
    groups = {r.requirement.group for r in report.results if r.outcome == "passed"}
    assert {"PM", "FT", "MD", "GB"} <= groups


# --- wrong ones -----------------------------------------------------------------------------------
@pytest.mark.parametrize("fault", FAULTS)
def test_each_fault_is_found_by_the_must_that_it_breaks(fault: str) -> None:
    light = ModelLight({fault}, gimbal=True)
    report = checked(light)
    assert sorted(report.broken()) == sorted(FAULTS[fault])
    assert fault in light.asked or fault.startswith("metadata")
    assert light.enable == (fault == "cannot be switched off")


def test_each_must_that_a_light_can_break_has_a_fault() -> None:
    found = {must for broken in FAULTS.values() for must in broken}
    found |= {must for broken in OPTICAL_FAULTS.values() for must in broken}
    found |= {must for build in SIGNING_BUILDS.values() for must in build.breaks}
    musts = {r.id for r in REQUIREMENTS if r.level == Level.MUST}
    # HB-6 has a test of its own; a light that breaks these cannot be talked to.
    assert musts - found == {"HB-6", "SG-1", "SG-3"}


def test_a_light_that_has_no_id_is_found_out() -> None:
    """HB-6: it is called 0, so it can only be addressed as everybody."""
    light = ModelLight()
    light.codec.srcSystem = 0
    assert checked(light, "HB").broken() == ["HB-6"]


@dataclass(frozen=True)
class Build:
    """Our firmware with one line changed; `more` where another layer would make up for it."""

    source: str
    line: str
    instead: str
    breaks: tuple[str, ...]
    more: tuple[Build, ...] = ()


SERVICE = "app/proto/mavlink/illuminator_service.c"
BUILDS = {
    "on/off takes 2": Build(
        SERVICE,
        "mavlink_whole(command->param[0], 1, &enable)",
        "mavlink_whole(command->param[0], 2, &enable)",
        ("SW-3",),
    ),
    "periods of any length": Build(
        SERVICE, "wire >= min_s && wire <= max_s", "wire >= min_s && wire <= 9 * max_s", ("CF-7",)
    ),
    "acknowledges to system 1": Build(
        "app/proto/mavlink/command.c",
        "ack.target_system = context->source_system;",
        "ack.target_system = 1;",
        ("CM-4", "CM-17"),
    ),
    "any negative interval": Build(
        "app/proto/mavlink/command.c", "if (wire == -1.0f) {", "if (wire < 0.0f) {", ("IV-5",)
    ),
    "zeros are sent": Build(
        "app/proto/mavlink/frame.c", "while (length > 1 &&", "while (length > 250 &&", ("WR-4",)
    ),
}


def _built(build: Build, folder: Path) -> Path:
    """Compiles the changed files as the build did, and links them before everything else."""
    words = ["ninja", "-C", str(BINARY.parent), "-t", "commands", "pharos"]
    commands = subprocess.run(words, check=True, capture_output=True, text=True).stdout.splitlines()
    link = commands[-1]
    for number, change in enumerate((build, *build.more)):
        original = ROOT / change.source
        text = original.read_text()
        assert text.count(change.line) == 1, f"{original} has no such line any more: {change.line}"
        changed = folder / original.name
        changed.write_text(text.replace(change.line, change.instead))
        (compile_it,) = [c for c in commands if c.endswith(f" -c {original}")]
        target = re.search(r" -o (\S+) ", compile_it)
        assert target is not None
        made = folder / f"changed{number}.o"
        compile_it = re.sub(r" -M[DTF]( \S+\.o(\.d)?)?", "", compile_it)
        compile_it = compile_it.replace(f" -o {target[1]}", f" -o {made}")
        compile_it = compile_it.removesuffix(f" -c {original}")
        _run(f"{compile_it} -iquote {original.parent} -Wno-error -c {changed}")
        link = link.replace(" -o pharos ", f" {made} -o pharos ", 1).replace(f" {target[1]} ", " ")
    _run(link.replace(" -o pharos ", f" -o {folder / 'pharos'} ", 1))
    return folder / "pharos"


def _run(command: str) -> None:
    done = subprocess.run(command, shell=True, cwd=BINARY.parent, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("name", BUILDS)
def test_each_wrong_build_of_ours_is_found(binary: Path, tmp_path: Path, name: str) -> None:
    build = BUILDS[name]
    dialect = load_dialect(find_dialect(binary.parent))
    with Simulator(_built(build, tmp_path), {"uart0": "udpin:127.0.0.1:0"}, dialect=dialect) as sim:
        report = on_simulator(sim, sim.connect("uart0"))
    assert sorted(report.broken()) == sorted(build.breaks)


# --- with a key -----------------------------------------------------------------------------------
KEY = bytes(range(32))
SIGNING = "app/proto/mavlink/signing.c"
SIGNING_BUILDS = {
    "obeys who does not sign": Build(
        SIGNING,
        "return MAVLINK_SIGNING_UNSIGNED;",
        "return MAVLINK_SIGNING_ACCEPTED;",
        ("SG-4",),
        (
            Build(
                "app/proto/mavlink/endpoint.c",
                ".is_signed = frame.has_signature && mavlink_is_signing(self),",
                ".is_signed = mavlink_is_signing(self),",
                (),
            ),
        ),
    ),
    "obeys any key": Build(
        SIGNING, "return differs == 0;", "return differs <= 255;", ("SG-5",)
    ),
    "obeys recordings": Build(
        SIGNING, "timestamp <= stream->timestamp", "timestamp + 1 == 0", ("SG-6",)
    ),
    "obeys what is old": Build(
        SIGNING,
        "return timestamp + MAVLINK_TIMESTAMP_MINUTE < now;",
        "return timestamp + 100 * MAVLINK_TIMESTAMP_MINUTE < now;",
        ("SG-7",),
    ),
    "does not count timestamps on": Build(
        SIGNING, "mavlink_signing_timestamp(self, now_us) + 1);",
        "mavlink_signing_timestamp(self, now_us));", ("SG-2",),
    ),
}  # fmt: skip


def _with_key(sim: Simulator) -> MavlinkConnection:
    """A client that has given the light a key, on a wire that may."""
    connection = sim.connect("uart0")
    light = Light(connection)
    light.find()
    Parameters(light).set("MAV_SECURE", 1)
    now = signing_time()
    connection.send(connection.dialect.MAVLink_setup_signing_message(1, 243, KEY, now))
    sim.advance(s=1)
    connection.sign(KEY, now + 200_000)
    connection.drain()
    connection.inbox.clear()
    return connection


def test_our_light_passes_with_a_key(binary: Path) -> None:
    with Simulator(binary, {"uart0": "udpin:127.0.0.1:0"}) as sim:
        report = on_simulator(sim, _with_key(sim), key=KEY)
    assert (report.broken(), report.left) == ([], "")
    assert all(r.outcome == "passed" for r in report.results if r.requirement.group == "SG")


@pytest.mark.parametrize("name", SIGNING_BUILDS)
def test_each_wrong_way_to_sign_is_found(binary: Path, tmp_path: Path, name: str) -> None:
    build = SIGNING_BUILDS[name]
    dialect = load_dialect(find_dialect(binary.parent))
    with Simulator(_built(build, tmp_path), {"uart0": "udpin:127.0.0.1:0"}, dialect=dialect) as sim:
        report = on_simulator(sim, _with_key(sim), requirements=selected(["SG", "HB"]), key=KEY)
    assert report.broken() == list(build.breaks)


def test_a_light_that_signs_says_so_to_who_has_no_key(binary: Path) -> None:
    with Simulator(binary, {"uart0": "udpin:127.0.0.1:0"}) as sim:
        connection = _with_key(sim)
        connection.sign(b"", 0)
        sim.advance(s=2)
        with pytest.raises(SilentError, match="--key-file"):
            on_simulator(sim, connection)
        with pytest.raises(SilentError, match="--key-file"):
            Light(connection).on()
        connection.sign(bytes(32 * [7]), signing_time())
        with pytest.raises(SilentError, match="not signed with this key"):
            Light(connection).find()


# --- what it leaves behind ------------------------------------------------------------------------
def test_the_light_has_its_settings_back_and_is_off() -> None:
    light = ModelLight()
    light.enable, light.mode = 1, 2
    light.brightness, light.period, light.duty = 80.0, 0.5, 25.0
    checked(light)
    assert (light.enable, light.mode) == (0, 2)
    assert (light.brightness, light.period, light.duty) == (80.0, 0.5, 25.0)


def test_a_light_that_stays_on_is_told_of() -> None:
    report = checked(ModelLight({"cannot be switched off"}), "SW-1")
    assert "could not be switched off" in report.left
    assert not report.passed


class Interrupted(ModelLight):
    """Ctrl-C while the lamp is on."""

    def configure(self, p: list[float]) -> int:
        if self.enable and not self.asked & {"interrupted"}:
            self.asked.add("interrupted")
            raise KeyboardInterrupt
        return super().configure(p)


def test_an_interrupt_leaves_it_off() -> None:
    light = Interrupted()
    with pytest.raises(KeyboardInterrupt):
        checked(light)
    assert "interrupted" in light.asked
    assert not light.enable


class Brief(ModelLight):
    """Falls silent for good once it has been switched on."""

    silent = False

    def say(self, message: Any) -> None:
        if not self.silent:
            super().say(message)

    def on_off(self, value: float) -> int:
        self.silent = self.silent or value == 1
        return super().on_off(value)


def test_a_light_that_falls_silent_ends_it_soon() -> None:
    light = Brief()
    report = checked(light)
    assert report.left
    first = next(i for i, r in enumerate(report.results) if r.outcome == "not run")
    assert all(r.outcome == "not run" for r in report.results[first:])
    assert light.now < 60_000_000


def test_the_lamp_is_dim_whenever_it_is_on() -> None:
    brightest = 0.0

    class Watched(ModelLight):
        def acknowledge(self, *args: Any) -> None:
            nonlocal brightest
            if self.enable:
                brightest = max(brightest, self.brightness)
            super().acknowledge(*args)

    # Each alone as well, since each may leave it on for the end to deal with.
    checked(Watched())
    for requirement in REQUIREMENTS:
        checked(Watched(), requirement.id)
    assert 0 < brightest <= 5


# --- choosing -------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("only", "skip", "ids"),
    [
        (["sw-1"], [], ["SW-1"]),
        (["HB-1", "SW-2"], [], ["HB-1", "SW-2"]),
        (["CF-1?"], ["CF-11", "CF-13"], ["CF-10", "CF-12", "CF-14", "CF-15", "CF-16", "CF-17"]),
        (["GB"], ["*-1", "*-2"], ["GB-3", "GB-4", "GB-5"]),
    ],
)
def test_requirements_are_chosen(only: list[str], skip: list[str], ids: list[str]) -> None:
    assert [r.id for r in selected(only, skip)] == ids


def test_what_is_no_requirement_is_said() -> None:
    with pytest.raises(UsageError, match="'XY-1'"):
        selected(["XY-1"])


def test_each_alone_finds_what_it_finds_among_all() -> None:
    """No requirement leans on another's traces."""
    for requirement in REQUIREMENTS:
        assert checked(ModelLight(), requirement.id).broken() == []
    for fault, broken in FAULTS.items():
        assert broken[0] in checked(ModelLight({fault}, gimbal=True), broken[0]).broken()


def test_who_is_not_there_is_said() -> None:
    light = ModelLight()
    light.heartbeat_due = light.status_due = 1 << 60
    connection = MavlinkConnection(light, light, light.d)
    with pytest.raises(SilentError, match="no illuminator"):
        find(connection, None)
    with pytest.raises(SilentError, match="no component 1/7"):
        find(connection, Target(1, 7))


def test_a_link_that_breaks_is_an_error() -> None:
    class Broken(ModelLight):
        def _write(self, data: bytes) -> None:
            if self.enable:
                raise LinkError("gone")
            super()._write(data)

    light = Broken()
    with pytest.raises(LinkError, match="gone"):
        checked(light)
