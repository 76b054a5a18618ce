# SPDX-License-Identifier: Apache-2.0
"""Message signing over the wire. The other side signs and checks with pymavlink, which shares no
code with the light."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from harness import (
    ACCEPTED,
    CONSOLE,
    ON_OFF,
    ROOT,
    TRANSPORTS,
    WIRES,
    Light,
    Shell,
    Transport,
    light_on,
    of,
    texts,
)
from pharos import SilentError, Simulator
from signing_attacks import ATTACKS, KEY, OTHER_KEY, SECOND, Attack, Forge

UNIX = 1_720_000_000
STAMP = (UNIX - 1_420_070_400) * SECOND  # 2015-01-01 as Unix time: message_signing.html
MINUTE = 60 * SECOND

# MAV_SECURE's bit of each wire: the UARTs, then the tunnels.
SECURE = {"uart0": 1, "can0": 16}


@pytest.fixture
def boot(start: Callable[..., Simulator], tmp_path: Path) -> Callable[..., tuple[Light, Shell]]:
    """Starts a light with a console, whose settings lie in one file."""

    def begin(transport: Transport = TRANSPORTS["udp"]) -> tuple[Light, Shell]:
        sim = start(
            {transport.wire: transport.address, "console": CONSOLE},
            options=["--settings", str(tmp_path / "settings")],
        )
        return light_on(sim, transport=transport), Shell(sim)

    return begin


def set_key(shell: Shell, key: bytes = KEY, unix: int = UNIX) -> str:
    return shell(f"signing key {unix}") + shell(key.hex())


def counters(shell: Shell) -> dict[str, int]:
    found = re.findall(r"^([a-z][a-z ]+?)\s{2,}(\d+)$", shell("signing status"), re.MULTILINE)
    return {name: int(value) for name, value in found}


def setup(light: Light, key: bytes, system: int = 1, component: int = 243) -> None:
    light.mav.send(light.mav.dialect.MAVLink_setup_signing_message(system, component, key, STAMP))
    light.sim.advance(s=1)


def answered(light: Light) -> bool:
    """Whether a command is carried out."""
    try:
        return light.on() == ACCEPTED
    except SilentError:
        return False


# --- attacks --------------------------------------------------------------------------------------
@pytest.mark.parametrize("wire", ["udp", "pty", "can"])
@pytest.mark.parametrize("attack", ATTACKS, ids=[attack.name for attack in ATTACKS])
def test_attack_gets_what_the_table_says(
    boot: Callable[..., tuple[Light, Shell]], attack: Attack, wire: str
) -> None:
    light, shell = boot(TRANSPORTS[wire])
    set_key(shell)
    forge = Forge(light.mav.dialect, STAMP + 20 * SECOND)
    light.mav.link.send(forge.recorded)
    light.sim.advance(s=1)
    assert len(of("COMMAND_ACK", light.mav.drain())) == 1
    light.mav.inbox.clear()
    before = counters(shell)
    light.mav.drain()
    light.mav.inbox.clear()
    light.mav.link.send(attack.make(forge))
    light.sim.advance(s=1)
    assert len(of("COMMAND_ACK", light.mav.drain())) == attack.acted
    after = counters(shell)
    rose = {name for name in after if after[name] > before[name]} - {"sent signed"}
    assert rose == ({attack.counter} if attack.counter else set())


def test_document_shows_the_table() -> None:
    rows = re.findall(r"^\| ([^|]+) \| ([^|]+) \| ([^|]+) \|$", (
        ROOT / "docs" / "signing.md").read_text(), re.MULTILINE)  # fmt: skip
    shown = [tuple(cell.strip() for cell in row) for row in rows]
    outcome = {True: "carried out", False: "refused"}
    for attack in ATTACKS:
        row = (attack.name, outcome[attack.acted], attack.counter or "no whole frame")
        assert row in shown, f"docs/signing.md lacks {row}"
    assert len([row for row in shown if not row[0].startswith("-")]) == len(ATTACKS) + 1


# --- a session ------------------------------------------------------------------------------------
def test_a_signing_station_and_the_light_understand_each_other(
    boot: Callable[..., tuple[Light, Shell]], transport: Transport
) -> None:
    light, shell = boot(transport)
    assert "signing is on" in set_key(shell)
    assert not answered(light)
    light.mav.sign(KEY, STAMP + SECOND)
    assert answered(light)
    assert light.configure(30, 0.5, 10) == ACCEPTED
    # The client's decoder accepts nothing that is not rightly signed with a rising timestamp.
    came = light.collect(60)
    mine = [m for m in of("HEARTBEAT", came) if m.get_srcComponent() == 243]
    assert len(mine) == len(of("ILLUMINATOR_STATUS", came)) == 60
    light.mav.sign(OTHER_KEY, STAMP + 2 * MINUTE)
    assert light.collect(5) == []


@pytest.mark.parametrize("signs", [True, False])
def test_only_who_has_the_key_is_a_sign_of_life(
    boot: Callable[..., tuple[Light, Shell]], signs: bool
) -> None:
    light, shell = boot()
    shell("param set LGT_LOSS 3")
    shell("param set LGT_FALLBACK 1")
    set_key(shell)
    light.mav.sign(KEY, STAMP + SECOND)
    assert light.on() == ACCEPTED
    if not signs:
        light.mav.sign(b"", 0)
    for _ in range(10):
        light.mav.heartbeat()
        light.sim.advance(s=1)
    assert (light.level_ppm() > 0) == signs
    light.sim.advance(s=4)
    assert light.level_ppm() == 0


def test_a_stranger_lights_no_beacon(boot: Callable[..., tuple[Light, Shell]]) -> None:
    """LGT_FALLBACK 2 is a beacon once commanders are silent: only those with the key are any."""
    light, shell = boot()
    shell("param set LGT_LOSS 5")
    shell("param set LGT_FALLBACK 2")
    set_key(shell)
    light.sim.advance(s=3)
    light.sim.reset()
    light.mav.heartbeat()
    light.sim.skip_edges()
    light.sim.advance(s=20)
    assert light.sim.edges() == []
    light.mav.sign(KEY, STAMP + MINUTE)
    light.mav.heartbeat()
    light.sim.advance(s=20)
    assert len(light.sim.edges()) > 10


def autopilot(light: Light, system: int, signed_at: int | None) -> None:
    """An ArduPilot's HEARTBEAT from system/1."""
    codec = light.mav.dialect.MAVLink(None, system, 1)
    if signed_at is not None:
        codec.signing.secret_key = KEY
        codec.signing.timestamp = signed_at
        codec.signing.sign_outgoing = True
    light.mav.link.send(
        bytes(light.mav.dialect.MAVLink_heartbeat_message(2, 3, 0, 0, 4, 3).pack(codec))
    )


def test_an_unsigned_autopilot_gives_no_system_id(
    boot: Callable[..., tuple[Light, Shell]],
) -> None:
    light, shell = boot()
    shell("param set MAV_SYSID 0")
    set_key(shell)
    light.sim.advance(s=3)
    light.sim.reset()
    autopilot(light, 77, None)
    light.sim.advance(s=5)
    light.mav.sign(KEY, STAMP + MINUTE)
    assert light.on() == ACCEPTED  # to 1/243, as before
    assert light.level_ppm() > 0


def test_an_unsigned_autopilot_does_not_stand_beside_the_vehicle(
    boot: Callable[..., tuple[Light, Shell]],
) -> None:
    light, shell = boot()
    shell("param set MAV_SYSID 0")
    set_key(shell)
    light.sim.advance(s=3)
    light.sim.reset()
    light.sim.advance(s=1)
    autopilot(light, 7, STAMP + MINUTE)
    light.sim.advance(s=1)
    autopilot(light, 50, None)
    autopilot(light, 7, STAMP + MINUTE + SECOND)
    light.mav.inbox.clear()
    light.sim.advance(s=5)
    assert "System id is now the vehicle's: 7" in texts(light.mav.drain())


def test_everything_is_heard_again_once_the_key_is_gone(
    boot: Callable[..., tuple[Light, Shell]],
) -> None:
    light, shell = boot()
    set_key(shell)
    assert not answered(light)
    assert "signing is off" in shell("signing off")
    assert answered(light)


# --- keys over the shell --------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("typed", "said"),
    [
        (KEY.hex() + "\r", "signing is on"),
        (KEY.hex().upper() + "\n", "signing is on"),
        ("x\x7f" + KEY.hex() + "\r", "signing is on"),
        (KEY.hex()[:-1] + "\r", "not 64 hex digits; nothing changed"),
        (KEY.hex() + "0\r", "not 64 hex digits; nothing changed"),
        ("z" * 64 + "\r", "not 64 hex digits; nothing changed"),
        ("0" * 64 + "\r", "that would be no key"),
        ("00\x03", "nothing changed"),
    ],
)
def test_key_is_typed_unseen(
    boot: Callable[..., tuple[Light, Shell]], typed: str, said: str
) -> None:
    light, shell = boot()
    shell("signing key")
    shown = shell.keys(typed)
    assert said in shown
    assert "0001020304" not in shown
    assert "zzzz" not in shown
    assert answered(light) != (said == "signing is on")
    # It is not among the lines typed before, and the shell takes lines again.
    history = "".join(shell.keys("\x1b[A") for _ in range(6)) + shell("\x03")
    assert "0001020304" not in history
    assert "Pharos" in shell("version")


def test_key_is_shown_nowhere(boot: Callable[..., tuple[Light, Shell]]) -> None:
    light, shell = boot()
    shell("param set MAV_SECURE 1")
    setup(light, KEY)
    light.mav.sign(KEY, STAMP + SECOND)
    light.mav.send_command_long(ON_OFF, 1)
    shown = "".join(
        shell(line)
        for line in ("signing status", "param list", "link stats", "route", "settings list",
                     "settings read pharos/signing", "help")
    )  # fmt: skip
    assert "key             set" in shown
    for form in (KEY.hex(), KEY.hex(" "), "00 01 02 03", "00010203"):
        assert form not in shown
        assert form.upper() not in shown


@pytest.mark.parametrize("time", ["0", "1400000000", "5000000000", "now", "-1", "1.5"])
def test_time_of_a_key_must_be_one(boot: Callable[..., tuple[Light, Shell]], time: str) -> None:
    _, shell = boot()
    assert "is not a Unix time between 2015 and 2104" in shell(f"signing key {time}")


# --- SETUP_SIGNING --------------------------------------------------------------------------------
def test_setup_on_a_secure_link_turns_signing_on_and_off(
    boot: Callable[..., tuple[Light, Shell]], transport: Transport
) -> None:
    light, shell = boot(transport)
    shell(f"param set MAV_SECURE {SECURE[transport.wire]}")
    light.mav.inbox.clear()
    setup(light, KEY)
    assert "MAVLink signing: a key is set" in texts(light.mav.drain())
    assert not answered(light)
    light.mav.sign(KEY, STAMP + SECOND)
    assert answered(light)
    setup(light, bytes(32))
    light.mav.sign(b"", 0)
    assert answered(light)


@pytest.mark.parametrize("key", [bytes(32), OTHER_KEY], ids=["none", "another"])
def test_who_lacks_the_key_can_neither_end_nor_change_it(
    boot: Callable[..., tuple[Light, Shell]], transport: Transport, key: bytes
) -> None:
    light, shell = boot(transport)
    shell(f"param set MAV_SECURE {SECURE[transport.wire]}")
    set_key(shell)
    setup(light, key)
    assert "0 obeyed, 1 refused" in shell("signing status")
    assert not answered(light)
    light.mav.sign(KEY, STAMP + SECOND)
    assert answered(light)


def test_setup_is_refused_on_other_links(
    boot: Callable[..., tuple[Light, Shell]], transport: Transport
) -> None:
    light, shell = boot(transport)
    setup(light, KEY)  # by default no link is secure
    shell(f"param set MAV_SECURE {255 & ~SECURE[transport.wire]}")
    setup(light, KEY)
    assert answered(light)
    assert "0 obeyed, 2 refused" in shell("signing status")


@pytest.mark.parametrize(("system", "component"), [(0, 0), (1, 0), (0, 243), (2, 243), (1, 1)])
def test_setup_is_refused_unless_addressed_to_the_light(
    boot: Callable[..., tuple[Light, Shell]], system: int, component: int
) -> None:
    light, shell = boot()
    shell("param set MAV_SECURE 255")
    setup(light, KEY, system, component)
    assert answered(light)
    assert "0 obeyed, 1 refused" in shell("signing status")


# --- what survives --------------------------------------------------------------------------------
def test_key_and_timestamp_survive_a_reset_and_no_recording_comes_good(
    boot: Callable[..., tuple[Light, Shell]],
) -> None:
    light, shell = boot()
    set_key(shell)
    forge = Forge(light.mav.dialect, STAMP + 20 * SECOND)
    light.mav.link.send(forge.recorded)
    light.sim.advance(s=180)
    light.sim.request("reset", cause="brownout")
    light.sim.advance(s=1)
    light.mav.pass_time(0)
    # What was sent three minutes ago is more than one behind what was stored since.
    light.mav.link.send(forge.recorded)
    light.sim.advance(s=1)
    assert of("COMMAND_ACK", light.mav.drain()) == []
    assert counters(Shell(light.sim))["old"] == 1
    light.mav.sign(KEY, STAMP + 3 * MINUTE + 30 * SECOND)
    assert answered(light)


def test_stored_timestamp_is_never_more_than_a_minute_behind(
    boot: Callable[..., tuple[Light, Shell]],
) -> None:
    light, shell = boot()
    set_key(shell)

    def stamp() -> float:
        found = re.search(r"^timestamp\s+([\d.]+) s", shell("signing status"), re.MULTILINE)
        assert found is not None
        return float(found[1])

    for _ in range(5):
        light.sim.advance(s=73)
        before = stamp()
        light.sim.request("reset", cause="brownout")
        light.sim.advance(s=1)
        shell("")
        assert before - 60 <= stamp() <= before + 2


def test_a_leap_of_the_timestamp_is_stored_at_once(
    boot: Callable[..., tuple[Light, Shell]],
) -> None:
    light, shell = boot()
    set_key(shell)
    light.mav.sign(KEY, STAMP + 3600 * SECOND)
    assert answered(light)
    light.sim.advance(s=1)
    light.sim.request("reset", cause="brownout")
    light.sim.advance(s=1)
    light.mav.sign(KEY, STAMP + 3500 * SECOND)
    assert not answered(light), "an hour is not forgotten"


@pytest.mark.parametrize("byte", range(72))
def test_power_cut_at_any_byte_leaves_the_old_key_or_the_new(
    boot: Callable[..., tuple[Light, Shell]], byte: int
) -> None:
    light, shell = boot()
    set_key(shell)
    light.sim.advance(s=2)
    light.sim.fault("storage", "torn", byte=byte)
    set_key(shell, OTHER_KEY, UNIX + 5)
    light.sim.advance(s=2)
    light.sim.request("reset", cause="brownout")
    light.sim.advance(s=1)
    good = []
    for key in (KEY, OTHER_KEY):
        light.mav.sign(key, STAMP + 30 * SECOND)
        if answered(light):
            good.append(key)
    light.mav.sign(b"", 0)
    assert not answered(light), "without a key anyone could command"
    assert len(good) == 1, "a mix of two keys is neither"
    # The store works again.
    shell("")
    set_key(shell, KEY[::-1], UNIX + 60)
    light.sim.advance(s=2)
    light.sim.request("reset", cause="brownout")
    light.sim.advance(s=1)
    light.mav.sign(KEY[::-1], STAMP + 70 * SECOND)
    assert answered(light)


def test_a_link_that_spoke_mavlink_1_is_spoken_to_in_2_and_signed(
    start: Callable[..., Simulator],
) -> None:
    sim = start({"uart0": WIRES["udp"], "console": CONSOLE})
    mav = sim.connect()
    mav.version = 1
    mav.heartbeat()
    mav.pass_time(1_000_000)
    assert {bytes(m.get_msgbuf())[0] for m in mav.pass_time(3_000_000)} == {0xFE}
    set_key(Shell(sim))
    mav.pass_time(0)
    came = mav.pass_time(3_000_000)
    assert {bytes(m.get_msgbuf())[0] for m in came} == {0xFD}
    assert {bytes(m.get_msgbuf())[2] for m in came} == {1}, "the flag: signed"
