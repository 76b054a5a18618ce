# SPDX-License-Identifier: Apache-2.0
"""The parameter protocol, where a light has parameters. Nothing is set to another value than it
has."""

from __future__ import annotations

from typing import Any

from ..connection import Target
from .bench import Bench
from .spec import Level, NotOffered, expect, group, requirement

PAGE = "services/parameter.html"
PROTOCOL = "Parameter Protocol"
LIST_US = 30_000_000
# A list is over when nothing of it came for this long [µs].
QUIET_US = 2_000_000
REAL32 = 9
BYTEWISE, C_CAST = 16, 131_072

group("PM", "Parameters")


def id_of(message: Any) -> str:
    text = message.param_id
    if isinstance(text, bytes):
        text = text.decode("ascii", "backslashreplace")
    return str(text).rstrip("\0")


def request_list(bench: Bench, component: int | None = None) -> list[Any]:
    """The PARAM_VALUEs that come for a PARAM_REQUEST_LIST, until all are there or no more come."""
    target = bench.target
    to = target.component if component is None else component
    bench.send(bench.d.MAVLink_param_request_list_message(target.system, to))
    came: list[Any] = []
    end = bench.now() + LIST_US

    def is_value(message: Any) -> bool:
        return bool(message.get_type() == "PARAM_VALUE")

    while bench.now() < end:
        fresh = [h.message for h in bench.listen(QUIET_US, is_value) if is_value(h.message)]
        if not fresh:
            break
        came += fresh
        if len({m.param_index for m in came}) >= came[0].param_count:
            break
    bench.note(f"← {len(came)} PARAM_VALUE")
    return came


def listed(bench: Bench) -> list[Any]:
    if bench.facts.parameters is None:
        bench.facts.listed = request_list(bench)
        bench.facts.parameters = {id_of(m): m for m in bench.facts.listed}
    if not bench.facts.listed:
        raise NotOffered("the light has no parameters")
    return bench.facts.listed


def read(bench: Bench, name: str, index: int, target: Target | None = None) -> Any:
    to = target or bench.target
    bench.listen(0)
    bench.send(
        bench.d.MAVLink_param_request_read_message(to.system, to.component, name.encode(), index)
    )
    return bench.wait_for("PARAM_VALUE", 1_000_000)


def sample(bench: Bench) -> list[Any]:
    """The first, the last, and some between."""
    values = sorted(listed(bench), key=lambda m: m.param_index)
    step = max(1, len(values) // 4)
    return [*values[::step][:4], values[-1]]


def same(a: Any, b: Any) -> bool:
    return value_bits(a) == value_bits(b) and a.param_type == b.param_type


def value_bits(message: Any) -> bytes:
    """The four bytes of the value as they came."""
    payload = bytes(message.get_msgbuf())
    start = 10 if payload[0] == 0xFD else 6
    return payload[start : start + 25].ljust(25, b"\0")[:4] if payload else b""


@requirement("PM-1", Level.MAY, "has parameters", PROTOCOL, PAGE)
def has_parameters(bench: Bench) -> None:
    """PARAM_REQUEST_LIST brings PARAM_VALUEs. A light that has none ignores it."""
    listed(bench)


@requirement("PM-2", Level.MUST, "lists all its parameters", f"{PROTOCOL}, Read All", PAGE)
def complete(bench: Bench) -> None:
    """param_count is the same in each PARAM_VALUE, and each index below it comes."""
    values = listed(bench)
    counts = {m.param_count for m in values}
    expect(len(counts) == 1, f"param_count is {sorted(counts)}")
    count = counts.pop()
    missing = sorted(set(range(count)) - {m.param_index for m in values})
    beyond = sorted({m.param_index for m in values} - set(range(count)))
    expect(not beyond, f"param_count {count}, but indices {beyond[:5]}")
    expect(not missing, f"param_count {count}, but these never came: {missing[:10]}")


@requirement("PM-3", Level.MUST, "gives each parameter a name of its own", "PARAM_VALUE.param_id",
             "messages/common.html#PARAM_VALUE")  # fmt: skip
def names(bench: Bench) -> None:
    """No name is empty, and no two indices have the same one."""
    by_name: dict[str, int] = {}
    for message in listed(bench):
        name = id_of(message)
        expect(bool(name), f"index {message.param_index} has no name")
        first = by_name.setdefault(name, message.param_index)
        expect(first == message.param_index, f"{name} is both {first} and {message.param_index}")


@requirement(
    "PM-4", Level.MUST, "tells one parameter by its name", f"{PROTOCOL}, Read Single", PAGE
)
def by_name(bench: Bench) -> None:
    """PARAM_REQUEST_READ with the name, index −1: name, value, type and index of the list."""
    for known in sample(bench):
        _agrees(bench, known, read(bench, id_of(known), -1), "by name")


@requirement(
    "PM-5", Level.MUST, "tells one parameter by its index", f"{PROTOCOL}, Read Single", PAGE
)
def by_index(bench: Bench) -> None:
    """PARAM_REQUEST_READ with the index: name, value and type of the list."""
    for known in sample(bench):
        _agrees(bench, known, read(bench, "", known.param_index), "by index")


def _agrees(bench: Bench, known: Any, answer: Any, how: str) -> None:
    del bench
    expect(answer is not None, f"no PARAM_VALUE of {id_of(known)} {how} within 1 s")
    expect(id_of(answer) == id_of(known), f"{id_of(known)} asked for {how}: {id_of(answer)} came")
    expect(same(answer, known), f"{id_of(known)} {how} has another value or type than in the list")


@requirement("PM-6", Level.MUST, "answers everybody who asks for parameters",
             f"{PROTOCOL}, Multi-System and Multi-Component Support", PAGE)  # fmt: skip
def broadcast(bench: Bench) -> None:
    """PARAM_REQUEST_READ to component 0 (all) of its system: answered, as to its own id."""
    known = listed(bench)[0]
    answer = read(bench, id_of(known), -1, Target(bench.target.system, 0))
    expect(answer is not None, "no PARAM_VALUE within 1 s")


@requirement("PM-7", Level.MUST, "leaves others' parameters alone", "Routing, Routing Detail",
             "guide/routing.html")  # fmt: skip
def others(bench: Bench) -> None:
    """PARAM_REQUEST_READ to another component of its system, and to another system: no answer."""
    known, us = listed(bench)[0], bench.target
    for other in (Target(us.system, 77), Target(us.system % 250 + 3, us.component)):
        answer = read(bench, id_of(known), -1, other)
        expect(answer is None, f"it answered for {other.system}/{other.component}")


@requirement("PM-8", Level.MUST, "acknowledges what is set", f"{PROTOCOL}, Write Parameters", PAGE)
def set_is_answered(bench: Bench) -> None:
    """PARAM_SET of a parameter to the very value that it has: a PARAM_VALUE with that value."""
    known = listed(bench)[0]
    target = bench.target
    bench.listen(0)
    bench.send(
        bench.d.MAVLink_param_set_message(
            target.system, target.component, id_of(known).encode(), known.param_value,
            known.param_type,
        )
    )  # fmt: skip
    answer = bench.wait_for("PARAM_VALUE", 1_000_000, lambda m: id_of(m) == id_of(known))
    expect(answer is not None, f"no PARAM_VALUE of {id_of(known)} within 1 s")
    expect(same(answer, known), f"{id_of(known)} was set to its value and has another one now")


@requirement("PM-9", Level.MUST, "is not confused by names that it does not know",
             f"{PROTOCOL}, Read Single", PAGE)  # fmt: skip
def unknown_name(bench: Bench) -> None:
    """Read and set of NO_SUCH_PARAM_: no PARAM_VALUE of that name, and the light goes on."""
    listed(bench)
    target, name = bench.target, "NO_SUCH_PARAM_"
    answer = read(bench, name, -1)
    expect(answer is None or id_of(answer) != name, f"a PARAM_VALUE of {name} came")
    bench.send(
        bench.d.MAVLink_param_set_message(
            target.system, target.component, name.encode(), 1.0, REAL32
        )
    )
    answer = bench.wait_for("PARAM_VALUE", 1_000_000, lambda m: id_of(m) == name)
    expect(answer is None, f"{name} could be set")
    bench.alive("after an unknown parameter")


@requirement("PM-10", Level.SHOULD, "says how it encodes parameters",
             f"{PROTOCOL}, Parameter Encoding", PAGE)  # fmt: skip
def encoding(bench: Bench) -> None:
    """One of the capabilities PARAM_ENCODE_BYTEWISE (16) and PARAM_ENCODE_C_CAST (131072)."""
    listed(bench)
    flags = bench.capabilities() & (BYTEWISE | C_CAST)
    expect(flags in (BYTEWISE, C_CAST), f"of both bits it has {flags:#x}")


@requirement("PM-11", Level.MUST, "has the same parameters all the time",
             f"{PROTOCOL}, Parameters Table is Invariant", PAGE)  # fmt: skip
def invariant(bench: Bench) -> None:
    """A second list has the names and indices of the first."""
    first = {(id_of(m), m.param_index) for m in listed(bench)}
    second = {(id_of(m), m.param_index) for m in request_list(bench)}
    changed = sorted(first ^ second)
    expect(not changed, f"only in one of two lists: {changed[:5]}")
