# SPDX-License-Identifier: Apache-2.0
"""Fixtures. `light` runs a test over every transport; `udp_light` where the transport is beside
the point. A failing test prints how to replay each light it started."""

from __future__ import annotations

import sys
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "host" / "src"))

import harness
from harness import TRANSPORTS, WIRES, Light, Transport, light_on, simulator
from imc_light import ENCODERS, IMC_WIRES, ImcLight, join
from pharos import Simulator

_running = pytest.StashKey[list[Simulator]]()


def pytest_configure(config: pytest.Config) -> None:
    if harness.QEMU_IMAGE:
        config.option.reportchars += "s"


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, Any, None]:
    outcome = yield
    report = outcome.get_result()
    if report.failed:
        for sim in item.stash.get(_running, []):
            report.sections.append(("light", sim.replay()))


@pytest.fixture(scope="session", autouse=True)
def _binary() -> None:
    if not harness.BINARY.is_file():
        pytest.exit(f"{harness.BINARY}: no such file; run `make build` first", returncode=2)


@pytest.fixture(autouse=True)
def _wire_only(request: pytest.FixtureRequest) -> None:
    if harness.QEMU_IMAGE and "start" not in request.fixturenames:
        pytest.skip("needs the native port: runs its program or command itself")
    if harness.QEMU_IMAGE and "gimbal" in request.node.nodeid:
        pytest.skip("needs servos, which the board has not")
    callspec = getattr(request.node, "callspec", None)
    for value in callspec.params.values() if harness.QEMU_IMAGE and callspec else ():
        if isinstance(value, str) and value in (*WIRES, "can", "canfd"):
            pytest.skip(f"needs the native port: over {value}")


@pytest.fixture
def start(request: pytest.FixtureRequest) -> Iterator[Callable[..., Simulator]]:
    """Starts simulators that end with the test: start({"uart0": …}, seed=…, options=…)."""
    sims = request.node.stash.setdefault(_running, [])
    with ExitStack() as stack:

        def begin(wires: dict[str, str] | None = None, **kwargs: Any) -> Simulator:
            sim = simulator(wires, **kwargs)
            sims.append(sim)
            stack.enter_context(sim)
            return sim

        yield begin


def _params(names: Iterable[str]) -> list[Any]:
    marks = {name: [pytest.mark.bus] if TRANSPORTS[name].is_can else [] for name in names}
    return [pytest.param(name, marks=marks[name]) for name in sorted(names)]


@pytest.fixture(params=_params(TRANSPORTS))
def transport(request: pytest.FixtureRequest) -> Transport:
    return TRANSPORTS[request.param]


@pytest.fixture
def light(start: Callable[..., Simulator], transport: Transport) -> Light:
    """A light under virtual time with a client, over each transport in turn."""
    return light_on(start({transport.wire: transport.address}), transport=transport)


@pytest.fixture
def udp_light(start: Callable[..., Simulator]) -> Light:
    """As `light`, over UDP only."""
    return light_on(start({"uart0": WIRES["udp"]}))


@pytest.fixture(params=[f"{wire}-{order}" for wire in IMC_WIRES for order in ENCODERS])
def imc(start: Callable[..., Simulator], request: pytest.FixtureRequest) -> ImcLight:
    """A light under virtual time with an IMC peer: over each transport, in each byte order."""
    transport, _, order = request.param.partition("-")
    wire, address, options = IMC_WIRES[transport]
    sim = start({wire: address}, options=options)
    return ImcLight(sim, join(sim, wire, order), wire)
