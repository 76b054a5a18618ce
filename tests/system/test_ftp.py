# SPDX-License-Identifier: Apache-2.0
"""MAVLink FTP over the wire: every operation, every error, repeats, bursts and their pace."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from ftp_client import (
    ACK,
    BURST,
    CRC32,
    DATA_MAX,
    EOF,
    FILE_NOT_FOUND,
    FILE_PROTECTED,
    INVALID_DATA_SIZE,
    INVALID_SESSION,
    LIST,
    NAK,
    NO_SESSIONS,
    NONE,
    OPEN,
    READ,
    RESET,
    TERMINATE,
    UNKNOWN_COMMAND,
    WRITES,
    FtpClient,
    crc32,
)
from harness import ACCEPTED, COMPONENTS, Light, light_on
from pharos import Simulator, Source, Target

GENERAL = "general.json"
PARAMETERS = "parameters.json.xz"
# Sessions that may be open at once, and after how long an idle one gives way.
SESSIONS = 4
IDLE_S = 10
# AUTOPILOT_VERSION, MAV_PROTOCOL_CAPABILITY_FTP
VERSION = 148
CAPABILITY_FTP = 32


@pytest.fixture
def ftp(light: Light) -> FtpClient:
    return FtpClient(light.mav)


@pytest.fixture
def udp_ftp(udp_light: Light) -> FtpClient:
    return FtpClient(udp_light.mav)


def test_lists_both_files(ftp: FtpClient) -> None:
    listing = ftp.listing()
    assert list(listing) == [GENERAL, PARAMETERS]
    assert all(size > 100 for size in listing.values())


@pytest.mark.parametrize("path", ["", "/", ".", "/."])
def test_the_folder_has_several_names(udp_ftp: FtpClient, path: str) -> None:
    assert list(udp_ftp.listing(path)) == [GENERAL, PARAMETERS]


def test_lists_from_an_index(udp_ftp: FtpClient) -> None:
    reply = udp_ftp.ask(LIST, b"/", offset=1)
    assert reply.data.startswith(b"F" + PARAMETERS.encode() + b"\t")
    assert reply.data.count(b"\0") == 1
    assert udp_ftp.ask(LIST, b"/", offset=2).error == EOF
    assert udp_ftp.ask(LIST, b"/", offset=0xFFFFFFFF).error == EOF


@pytest.mark.parametrize("path", [b"/etc", b"general.json", b"..", b"//..", b"@MAV_LOG", b"/\xff"])
def test_other_folders_are_not_found(udp_ftp: FtpClient, path: bytes) -> None:
    assert udp_ftp.ask(LIST, path).error == FILE_NOT_FOUND


def test_reads_a_file_part_by_part(ftp: FtpClient) -> None:
    listing = ftp.listing()
    for name, size in listing.items():
        whole = ftp.read(name)
        assert len(whole) == size
        assert ftp.ask(CRC32, name.encode()).number == crc32(whole)


def test_parts_of_any_size_make_the_same_file(udp_ftp: FtpClient) -> None:
    whole = udp_ftp.read(PARAMETERS)
    for part in (80, 238):
        assert udp_ftp.read(PARAMETERS, part) == whole


def test_a_path_may_be_absolute_and_may_end_with_a_zero(udp_ftp: FtpClient) -> None:
    for path in (b"general.json", b"/general.json", b"/general.json\0", b"general.json\0\0x"):
        reply = udp_ftp.ask(OPEN, path)
        assert reply.error == 0
        assert udp_ftp.ask(TERMINATE, session=reply.session).error == 0


@pytest.mark.parametrize(
    "path", [b"", b"/", b"general", b"general.json.xz", b"GENERAL.JSON", b"x" * DATA_MAX]
)
def test_other_files_are_not_found(udp_ftp: FtpClient, path: bytes) -> None:
    assert udp_ftp.ask(OPEN, path).error == FILE_NOT_FOUND
    assert udp_ftp.ask(CRC32, path).error == FILE_NOT_FOUND


@pytest.mark.parametrize("opcode", WRITES.values(), ids=WRITES.keys())
def test_writing_is_refused(udp_ftp: FtpClient, opcode: int) -> None:
    before = udp_ftp.read(GENERAL)
    # WriteFile names no file, but a session: there is none
    error = INVALID_SESSION if opcode == WRITES["write"] else FILE_PROTECTED
    assert udp_ftp.ask(opcode, GENERAL.encode()).error == error
    assert udp_ftp.read(GENERAL) == before


def test_a_session_that_reads_is_not_written_to(udp_ftp: FtpClient) -> None:
    session, _ = udp_ftp.open(GENERAL)
    assert udp_ftp.ask(WRITES["write"], b"{}", session=session).error == INVALID_SESSION


@pytest.mark.parametrize("opcode", [16, 42, 127, 130, 255])
def test_unknown_operations_are_refused(udp_ftp: FtpClient, opcode: int) -> None:
    assert udp_ftp.ask(opcode).error == UNKNOWN_COMMAND


def test_nothing_is_acknowledged(udp_ftp: FtpClient) -> None:
    assert udp_ftp.ask(NONE).error == 0


@pytest.mark.parametrize("opcode", [ACK, NAK])
def test_answers_are_not_answered(udp_ftp: FtpClient, opcode: int) -> None:
    udp_ftp.send(opcode, b"\x06")
    assert udp_ftp.silent()


@pytest.mark.parametrize("opcode", [LIST, OPEN, READ, CRC32, BURST])
def test_a_size_beyond_the_payload_is_refused(udp_ftp: FtpClient, opcode: int) -> None:
    assert udp_ftp.ask(opcode, size=240).error == INVALID_DATA_SIZE
    assert udp_ftp.ask(opcode, size=255).error == INVALID_DATA_SIZE


def test_reading_nothing_is_refused(udp_ftp: FtpClient) -> None:
    session, _ = udp_ftp.open(GENERAL)
    assert udp_ftp.ask(READ, session=session, size=0).error == INVALID_DATA_SIZE


def test_the_end_of_the_file_is_error_6(udp_ftp: FtpClient) -> None:
    session, length = udp_ftp.open(PARAMETERS)
    last = udp_ftp.ask(READ, session=session, size=DATA_MAX, offset=length - 1)
    assert last.size == 1
    for offset in (length, length + 1, 0xFFFFFFFF):
        assert udp_ftp.ask(READ, session=session, size=1, offset=offset).error == 6
        assert udp_ftp.ask(BURST, session=session, size=1, offset=offset).error == 6


@pytest.mark.parametrize("opcode", [TERMINATE, READ, BURST])
@pytest.mark.parametrize("session", [0, SESSIONS, 200, 255])
def test_a_session_that_is_not_open_is_invalid(
    udp_ftp: FtpClient, opcode: int, session: int
) -> None:
    assert udp_ftp.ask(opcode, session=session, size=10).error == INVALID_SESSION


def test_a_session_is_invalid_once_it_is_terminated(udp_ftp: FtpClient) -> None:
    session, _ = udp_ftp.open(GENERAL)
    assert udp_ftp.ask(TERMINATE, session=session).error == 0
    assert udp_ftp.ask(READ, session=session, size=10).error == INVALID_SESSION
    assert udp_ftp.ask(TERMINATE, session=session).error == INVALID_SESSION


# --- the same again -------------------------------------------------------------------------------


def test_a_repeated_request_gets_the_same_answer(ftp: FtpClient) -> None:
    requests = [
        (OPEN, GENERAL.encode(), 0),
        (READ, b"", 20),
        (LIST, b"/", 0),
        (CRC32, GENERAL.encode(), 0),
        (TERMINATE, b"", 0),
        (OPEN, b"nothing", 0),
        (RESET, b"", 0),
    ]
    for number, (opcode, data, offset) in enumerate(requests):
        size = len(data) or 50
        sequence = 100 + 2 * number
        first, second, third = (
            ftp.ask(opcode, data, size=size, offset=offset, sequence=sequence) for _ in range(3)
        )
        assert first == second == third


def test_a_repeated_open_opens_once(udp_ftp: FtpClient) -> None:
    for _ in range(3 * SESSIONS):
        assert udp_ftp.ask(OPEN, GENERAL.encode(), sequence=7).session == 0
    others = [udp_ftp.open(GENERAL)[0] for _ in range(SESSIONS - 1)]
    assert sorted(others) == [1, 2, 3]


def test_an_answer_continues_the_numbers_beyond_65535(udp_ftp: FtpClient) -> None:
    assert udp_ftp.ask(NONE, sequence=65535).sequence == 0


# --- sessions -------------------------------------------------------------------------------------


def test_sessions_are_bounded_and_given_back(udp_ftp: FtpClient) -> None:
    sessions = [udp_ftp.open(GENERAL)[0] for _ in range(SESSIONS)]
    assert len(set(sessions)) == SESSIONS
    assert udp_ftp.ask(OPEN, GENERAL.encode()).error == NO_SESSIONS
    assert udp_ftp.ask(TERMINATE, session=sessions[2]).error == 0
    assert udp_ftp.open(PARAMETERS)[0] == sessions[2]
    assert udp_ftp.ask(OPEN, GENERAL.encode()).error == NO_SESSIONS
    assert udp_ftp.ask(RESET).error == 0
    assert [udp_ftp.open(GENERAL)[0] for _ in range(SESSIONS)] == sessions


def test_the_session_idle_for_longest_gives_way(udp_light: Light, udp_ftp: FtpClient) -> None:
    sessions = [udp_ftp.open(GENERAL)[0] for _ in range(SESSIONS)]
    udp_light.sim.advance(s=IDLE_S - 2)
    assert udp_ftp.ask(READ, session=sessions[0], size=10).error == 0
    assert udp_ftp.ask(OPEN, GENERAL.encode()).error == NO_SESSIONS
    udp_light.sim.advance(s=3)
    assert udp_ftp.open(PARAMETERS)[0] == sessions[1]
    assert udp_ftp.ask(READ, session=sessions[0], size=10).error == 0


def test_clients_do_not_touch_each_others_sessions(
    start: Callable[..., Simulator],
) -> None:
    sim = start({"uart0": "udpin:127.0.0.1:0", "uart1": "tcpin:127.0.0.1:0"})
    ours = FtpClient(light_on(sim).mav)
    theirs = FtpClient(sim.connect("uart1", Source(254, 191)))
    session, _ = ours.open(PARAMETERS)
    assert theirs.ask(READ, session=session, size=10).error == INVALID_SESSION
    assert theirs.ask(TERMINATE, session=session).error == INVALID_SESSION
    assert theirs.ask(RESET).error == 0
    assert ours.ask(READ, session=session, size=10).error == 0
    whole = ours.read(PARAMETERS)
    assert theirs.read(PARAMETERS) == whole


# --- bursts ---------------------------------------------------------------------------------------


def test_a_burst_brings_the_file(ftp: FtpClient) -> None:
    whole = ftp.read(PARAMETERS)
    session, length = ftp.open(PARAMETERS)
    parts = ftp.burst(session)
    first = ftp.sequence + 1
    assert b"".join(part.data for part in parts) == whole
    assert [part.sequence for part in parts] == list(range(first, first + len(parts)))
    assert [part.offset for part in parts] == list(range(0, length, DATA_MAX))
    assert {(part.session, part.opcode, part.request) for part in parts} == {(session, ACK, BURST)}
    assert [part.burst_complete for part in parts] == [0] * (len(parts) - 1) + [1]
    assert ftp.silent()
    assert ftp.ask(BURST, session=session, size=DATA_MAX, offset=length).error == EOF


def test_a_burst_starts_anywhere_and_has_parts_of_the_size_asked_for(udp_ftp: FtpClient) -> None:
    whole = udp_ftp.read(PARAMETERS)
    session, length = udp_ftp.open(PARAMETERS)
    parts = udp_ftp.burst(session, offset=300, size=100)
    assert b"".join(part.data for part in parts) == whole[300:]
    assert {part.size for part in parts[:-1]} == {100}
    assert parts[-1].offset + parts[-1].size == length
    assert udp_ftp.burst(session, size=0)[0].size == DATA_MAX


def test_other_requests_are_answered_during_a_burst(udp_ftp: FtpClient) -> None:
    session, length = udp_ftp.open(PARAMETERS)
    udp_ftp.send(BURST, session=session, size=40)
    udp_ftp.send(CRC32, GENERAL.encode())
    replies = [udp_ftp.reply() for _ in range(-(-length // 40) + 1)]
    assert [reply.request for reply in replies].count(CRC32) == 1
    bursts = [reply for reply in replies if reply.request == BURST]
    assert [reply.offset for reply in bursts] == list(range(0, length, 40))


def test_a_new_burst_takes_the_place_of_the_old_one(udp_ftp: FtpClient) -> None:
    session, _ = udp_ftp.open(PARAMETERS)
    udp_ftp.send(BURST, session=session, size=10)
    assert udp_ftp.reply().offset == 0
    udp_ftp.send(BURST, session=session, size=DATA_MAX, offset=500)
    parts = [udp_ftp.reply()]
    while not parts[-1].burst_complete:
        parts.append(udp_ftp.reply())
    resumed = next(i for i, part in enumerate(parts) if part.offset == 500)
    assert all(part.size == 10 for part in parts[:resumed])
    assert all(part.sequence > udp_ftp.sequence for part in parts[resumed:])
    assert udp_ftp.silent()


@pytest.mark.parametrize("opcode", [TERMINATE, RESET])
def test_ending_the_session_ends_its_burst(udp_ftp: FtpClient, opcode: int) -> None:
    session, _ = udp_ftp.open(PARAMETERS)
    udp_ftp.send(BURST, session=session, size=10)
    udp_ftp.send(opcode, session=session)
    while udp_ftp.reply().request != opcode:
        pass
    assert udp_ftp.silent()


def test_a_burst_leaves_room_on_a_slow_wire(start: Callable[..., Simulator]) -> None:
    """57600 baud carry 5760 bytes a second; bulk takes 30 to 50 % of them, so that a command is
    answered meanwhile as fast as it would be otherwise."""
    sim = start({"uart0": "pty:{folder}/uart0,baud=57600,paced"})
    light = light_on(sim)
    ftp = FtpClient(light.mav)
    session, length = ftp.open(PARAMETERS)
    begin = sim.now_us()
    ftp.send(BURST, session=session, size=DATA_MAX)
    received = len(ftp.reply().data)
    asked = sim.now_us()
    assert light.on() == ACCEPTED
    assert sim.now_us() - asked < 100_000
    while received < length:
        received += len(ftp.reply().data)
    bytes_per_s = received / ((sim.now_us() - begin) / 1e6)
    assert 0.25 * 5760 < bytes_per_s < 0.5 * 5760


# --- addressing and capability --------------------------------------------------------------------


@pytest.mark.parametrize("target", [Target(0, 0), Target(1, 0), Target(0, 243)])
def test_is_found_by_broadcast(udp_light: Light, target: Target) -> None:
    assert FtpClient(udp_light.mav, target).ask(NONE).error == 0


@pytest.mark.parametrize("target", [Target(1, 1), Target(2, 243)])
def test_is_silent_when_others_are_asked(udp_light: Light, target: Target) -> None:
    client = FtpClient(udp_light.mav, target)
    client.send(LIST, b"/")
    assert client.silent()


def test_says_that_it_can(light: Light) -> None:
    for message, kind in ((396, "COMPONENT_INFORMATION_BASIC"), (VERSION, "AUTOPILOT_VERSION")):
        assert light.mav.command_long(512, message).result == ACCEPTED
        assert light.mav.recv(kind).capabilities & CAPABILITY_FTP


@pytest.mark.skipif(154 not in COMPONENTS, reason="this board has no gimbal")
@pytest.mark.parametrize("opcode", [NONE, LIST, OPEN, READ, BURST, CRC32, TERMINATE, RESET])
def test_the_gimbal_has_no_files_and_says_so_at_once(udp_light: Light, opcode: int) -> None:
    """MAVProxy asks for packed parameters, and for a list once it is refused."""
    gimbal = FtpClient(udp_light.mav, Target(1, 154))
    gimbal.send(opcode, b"@PARAM/param.pck", session=3)
    answer = udp_light.mav.recv("FILE_TRANSFER_PROTOCOL", timeout_us=0)
    assert answer.get_srcComponent() == 154
    nak = (NAK, 1, opcode)  # opcode, size, opcode of the request
    assert (answer.payload[3], answer.payload[4], answer.payload[5]) == nak
    assert (answer.payload[2], answer.payload[12]) == (3, UNKNOWN_COMMAND)
    gimbal.send(ACK, session=3)  # an answer of somebody's
    assert gimbal.silent()
