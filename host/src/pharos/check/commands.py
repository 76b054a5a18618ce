# SPDX-License-Identifier: Apache-2.0
"""The command protocol: acknowledgements, targets, unknown commands, COMMAND_INT."""

from __future__ import annotations

from ..connection import Target
from ..light import (
    ACCEPTED,
    COMMAND_CONFIGURE,
    COMMAND_ON_OFF,
    COMMAND_REQUEST_MESSAGE,
    MESSAGE_STATUS,
    MODE_INTERNAL,
)
from .bench import ANSWER_US, DENIED, DIM, IN_PROGRESS, UNSUPPORTED, Bench, result_name
from .information import STATUS
from .spec import COMMON, Level, NotOffered, expect, group, requirement

PAGE = "services/command.html"
ROUTING = "guide/routing.html"
# No MAV_CMD has this number, nor is it in a range that anybody may use for their own.
NO_COMMAND = 65_000
# A message that no light has: GPS_RAW_INT.
NO_MESSAGE = 24
SILENCE_US = 1_000_000
PROMPT_US = 300_000

group("CM", "Command protocol")


def acks(bench: Bench, command: int, us: int) -> list[int]:
    """Results of the acknowledgements of `command` that come within `us`."""
    return [
        int(h.message.result)
        for h in bench.listen(us)
        if h.message.get_type() == "COMMAND_ACK" and h.message.command == command
    ]


@requirement("CM-1", Level.MUST, "acknowledges each command once", "Command Protocol", PAGE)
def one_ack(bench: Bench) -> None:
    """On/off, configure, and a request: exactly one final COMMAND_ACK to each within 1.5 s."""
    bench.dim()
    for command, params in (
        (COMMAND_ON_OFF, (0,)),
        (COMMAND_CONFIGURE, (MODE_INTERNAL, DIM, 0, 0)),
        (COMMAND_REQUEST_MESSAGE, (MESSAGE_STATUS,)),
    ):
        bench.listen(0)
        bench.send(bench.command_message(command, *params))
        final = [r for r in acks(bench, command, 1_500_000) if r != IN_PROGRESS]
        expect(len(final) == 1, f"{len(final)} acknowledgements of command {command}")


@requirement(
    "CM-2", Level.MUST, "answers within a second", "Command Protocol: responds quickly", PAGE
)
def in_time(bench: Bench) -> None:
    """Clients send again after half a second to three. Ten requests, each answered within 1 s."""
    for _ in range(10):
        bench.listen(0)
        start = bench.now()
        bench.send(bench.command_message(COMMAND_REQUEST_MESSAGE, MESSAGE_STATUS))
        answer = bench.acknowledgement_within(COMMAND_REQUEST_MESSAGE, 4 * ANSWER_US)
        took = (bench.now() - start) / 1e6
        expect(answer is not None, "no COMMAND_ACK within 4 s")
        expect(took <= 1.05, f"the answer took {took:.2f} s")


@requirement("CM-3", Level.SHOULD, "answers within 0.3 s", "Command Protocol", PAGE)
def promptly(bench: Bench) -> None:
    """Ten requests, each answered within 0.3 s: shorter than any client's patience."""
    for _ in range(10):
        bench.listen(0)
        start = bench.now()
        bench.send(bench.command_message(COMMAND_REQUEST_MESSAGE, MESSAGE_STATUS))
        answer = bench.acknowledgement_within(COMMAND_REQUEST_MESSAGE, ANSWER_US)
        took = bench.now() - start
        expect(answer is not None, "no COMMAND_ACK within 1 s")
        expect(took <= PROMPT_US, f"the answer took {took / 1e6:.2f} s")


@requirement(
    "CM-4",
    Level.MUST,
    "addresses acknowledgements to who asked",
    "COMMAND_ACK.target_system, target_component",
    COMMON + "COMMAND_ACK",
)
def addressed(bench: Bench) -> None:
    """Whoever is named as the target of a COMMAND_ACK is who sent the command. Nobody (0) is not
    wrong, only CM-5's."""
    bench.listen(0)
    bench.send(bench.command_message(COMMAND_REQUEST_MESSAGE, MESSAGE_STATUS))
    came = bench.listen(ANSWER_US, lambda m: m.get_type() == "COMMAND_ACK")
    found = [h.message for h in came if h.message.get_type() == "COMMAND_ACK"]
    expect(bool(found), "no COMMAND_ACK within 1 s")
    ack, source = found[0], bench.connection.source
    expect(
        ack.target_system in (0, source.system) and ack.target_component in (0, source.component),
        f"to {ack.target_system}/{ack.target_component}, "
        f"asked by {source.system}/{source.component}",
    )


@requirement(
    "CM-5",
    Level.SHOULD,
    "names who asked in acknowledgements",
    "COMMAND_ACK.target_system, target_component",
    COMMON + "COMMAND_ACK",
)
def named(bench: Bench) -> None:
    """Several stations may command one light; each must know its own answers."""
    answer = bench.command(COMMAND_REQUEST_MESSAGE, MESSAGE_STATUS)
    expect(answer is not None, "no COMMAND_ACK within 1 s")
    source = bench.connection.source
    expect(
        (answer.target_system, answer.target_component) == (source.system, source.component),
        f"to {answer.target_system}/{answer.target_component}",
    )


@requirement(
    "CM-6",
    Level.MUST,
    "says that it does not know a command",
    "MAV_RESULT_UNSUPPORTED",
    COMMON + "MAV_RESULT",
)
def unknown_command(bench: Bench) -> None:
    """Command 65000, which does not exist, addressed to it: UNSUPPORTED, once."""
    answer = bench.command(NO_COMMAND, 1)
    expect(answer is not None, "no COMMAND_ACK within 1 s")
    expect(answer.result == UNSUPPORTED, f"{result_name(answer)}, expected UNSUPPORTED")


@requirement(
    "CM-7",
    Level.MUST,
    "acknowledges before it sends what was asked for",
    "Illuminator Protocol, Illuminator Connection: sequence",
    "services/illuminator.html",
)
def order(bench: Bench) -> None:
    """REQUEST_MESSAGE(396): COMMAND_ACK, then the message. A client that waits for the one drops
    the other."""
    bench.listen(0)
    bench.send(bench.command_message(COMMAND_REQUEST_MESSAGE, 396))
    came = [h.message.get_type() for h in bench.listen(SILENCE_US)]
    if "COMPONENT_INFORMATION_BASIC" not in came or "COMMAND_ACK" not in came:
        raise NotOffered("it does not send COMPONENT_INFORMATION_BASIC")
    expect(
        came.index("COMMAND_ACK") < came.index("COMPONENT_INFORMATION_BASIC"),
        "the message came before its acknowledgement",
    )


@requirement(
    "CM-8",
    Level.MUST,
    "leaves alone what is for other components",
    "Routing, Routing Detail",
    ROUTING,
)
def other_components(bench: Bench) -> None:
    """'On' to another component of its system: no answer, and it stays off."""
    other = Target(bench.target.system, 77 if bench.target.component != 77 else 78)
    _others_command(bench, other)


@requirement(
    "CM-9", Level.MUST, "leaves alone what is for other systems", "Routing, Routing Detail", ROUTING
)
def other_systems(bench: Bench) -> None:
    """'On' to its own component id in another system: no answer, and it stays off."""
    other = Target(bench.target.system % 250 + 3, bench.target.component)
    _others_command(bench, other)


def _others_command(bench: Bench, other: Target) -> None:
    bench.dim()
    bench.listen(0)
    bench.send(bench.command_message(COMMAND_ON_OFF, 1, target=other))
    answers = acks(bench, COMMAND_ON_OFF, SILENCE_US)
    enable = bench.status().enable
    bench.switch(0)
    where = f"{other.system}/{other.component}"
    expect(not answers, f"it acknowledged a command to {where}")
    expect(enable == 0, f"it carried out a command to {where}")


@requirement(
    "CM-10",
    Level.MUST,
    "does what everybody is told to",
    "Routing: broadcast messages are processed",
    ROUTING,
)
def broadcast(bench: Bench) -> None:
    """A client that does not know its ids yet addresses 0/0, or its system and component 0: a
    request for its status, and 'off', are done and acknowledged."""
    for target in (Target(0, 0), Target(bench.target.system, 0)):
        where = f"{target.system}/{target.component}"
        bench.lit()
        for command, value in ((COMMAND_REQUEST_MESSAGE, MESSAGE_STATUS), (COMMAND_ON_OFF, 0)):
            answer = bench.command(command, value, target=target)
            expect(answer is not None, f"no COMMAND_ACK to command {command} to {where}")
            expect(answer.result == ACCEPTED, f"to {where}: {result_name(answer)}")
        expect(bench.status().enable == 0, f'"off" to {where} was not carried out')


@requirement(
    "CM-11",
    Level.SHOULD,
    "leaves unknown commands to everybody to others",
    "Routing; Command Protocol",
    PAGE,
)
def unknown_broadcast(bench: Bench) -> None:
    """Command 65000 to component 0 of its system: silence. Some clients take the first
    acknowledgement for the vehicle's, so a refusal by one hides the acceptance by another."""
    bench.listen(0)
    target = Target(bench.target.system, 0)
    bench.send(bench.command_message(NO_COMMAND, 1, target=target))
    answers = acks(bench, NO_COMMAND, SILENCE_US)
    expect(not answers, "it answered")


@requirement(
    "CM-12",
    Level.MUST,
    "does and acknowledges a command that is sent again",
    "Command Protocol: the confirmation field",
    PAGE,
)
def confirmation(bench: Bench) -> None:
    """When the command, or its acknowledgement, was lost, it comes again with confirmation 1, 2 …:
    "on" as such is done and acknowledged, each time."""
    bench.dim()
    for number in (1, 2):
        bench.accepted(COMMAND_ON_OFF, 1, confirmation=number)
    enable = bench.status().enable
    bench.switch(0)
    expect(enable != 0, "it was acknowledged, but not done")


@requirement("CM-13", Level.MUST, "answers COMMAND_INT", "Command Protocol: COMMAND_INT", PAGE)
def command_int(bench: Bench) -> None:
    """'On' as COMMAND_INT: ACCEPTED and done; or refused (COMMAND_LONG_ONLY says why), and not."""
    bench.dim()
    answer = bench.command(COMMAND_ON_OFF, 1, as_int=True)
    enable = bench.status().enable
    bench.switch(0)
    expect(answer is not None, "no COMMAND_ACK within 1 s")
    expect(
        bool(enable) == (answer.result == ACCEPTED),
        f"{result_name(answer)}, but then enable {enable}",
    )


@requirement("CM-14", Level.SHOULD, "takes COMMAND_INT", "Command Protocol: either message", PAGE)
def command_int_taken(bench: Bench) -> None:
    """A command without a position can be sent in either message: 'off' is ACCEPTED."""
    bench.accepted(COMMAND_ON_OFF, 0, as_int=True)


@requirement(
    "CM-15",
    Level.MUST,
    "refuses to send what it does not have",
    "MAV_CMD_REQUEST_MESSAGE",
    COMMON + "MAV_CMD_REQUEST_MESSAGE",
)
def no_message(bench: Bench) -> None:
    """A request for GPS_RAW_INT (24), and for a number that is no message: any answer but
    ACCEPTED."""
    for number in (NO_MESSAGE, 16_000_001):
        bench.refused(COMMAND_REQUEST_MESSAGE, number)


@requirement(
    "CM-16",
    Level.SHOULD,
    "says DENIED of a message that it does not have",
    "MAV_RESULT_DENIED",
    COMMON + "MAV_RESULT",
)
def no_message_denied(bench: Bench) -> None:
    """The command is known; its parameter is what is wrong."""
    answer = bench.refused(COMMAND_REQUEST_MESSAGE, NO_MESSAGE)
    expect(answer.result == DENIED, f"{result_name(answer)}, expected DENIED")


@requirement(
    "CM-17", Level.MUST, "tells its state to each that asks", "Routing; Command Protocol", PAGE
)
def another_asks(bench: Bench) -> None:
    """A request with another source (254/191) gets an acknowledgement that names nobody else, and
    leaves the first one's alone."""
    connection = bench.connection
    first, codec = connection.source, connection.encoder
    other = (254, 191)
    try:
        codec.srcSystem, codec.srcComponent = other
        bench.listen(0)
        bench.send(bench.command_message(COMMAND_REQUEST_MESSAGE, MESSAGE_STATUS))
    finally:
        codec.srcSystem, codec.srcComponent = first.system, first.component
    came = [h.message for h in bench.listen(SILENCE_US)]
    found = [m for m in came if m.get_type() == "COMMAND_ACK"]
    expect(bool(found), "no COMMAND_ACK to 254/191 within 1 s")
    names = (found[0].target_system, found[0].target_component)
    expect(
        names[0] in (0, other[0]) and names[1] in (0, other[1]),
        f"asked by 254/191, acknowledged to {names[0]}/{names[1]}",
    )
    expect(any(m.get_type() == STATUS for m in came), f"no {STATUS} came")
