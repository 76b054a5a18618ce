# SPDX-License-Identifier: Apache-2.0
"""What the image does with its memory, and when it finds itself broken."""

from __future__ import annotations

import pytest

from harness import ACCEPTED, REQUEST_MESSAGE, STATUS, Shell, light_on
from qemu import QemuSimulator

pytestmark = pytest.mark.only_on("CONFIG_BOARD_MPS2_AN385")

REBOOT = 246  # MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN
THREAD_LISTS = ("kernel threads", "kernel thread list")
# CONFIG_INIT_STACKS fills them with this.
UNTOUCHED = 0xAA
# At the bottom of each, for the MPU.
GUARD = 64
RESERVE_PERCENT = 30
# The reference target has an FPU, and four stacks of another size than this image's
# (boards/nucleo_g474re.conf, and Zephyr's default). With an FPU an exception's frame has s0 to
# s15, FPSCR and a word more (Armv7-M, B1.5.7), and Zephyr's guard takes 64 bytes more of a
# thread's stack.
FPU_FRAME = 18 * 4
FPU_GUARD = 64
REFERENCE_SIZES = {"idle": 320, "sys_work_q": 640, "interrupt": 896, "logging": 640}
# Thumb's udf #0, which no processor carries out.
UNDEFINED = b"\x00\xde"
# The board's enable output for the lamp's driver: bit 0 of the first GPIO port, active high.
# QEMU has no such port; it logs what is written there.
GPIO_DATA_OUT = "cmsdk-ahb-gpio: unimplemented device write (size 4, offset 0x004, value 0x"


def stacks(sim: QemuSimulator) -> dict[str, tuple[int, int]]:
    """Of each thread's stack and the interrupts': bytes used so far, and its size."""
    found = {}
    for name, (address, size) in sim.objects().items():
        if not name.endswith(("_stack", "_stacks")) or size < 128:
            continue
        memory = sim.memory(address + GUARD, size - GUARD)
        most = len(memory.lstrip(bytes([UNTOUCHED])))
        short = name.removeprefix("z_").removesuffix("s").removesuffix("_stack")
        found[short] = most, len(memory)
    return found


def has_shell(sim: QemuSimulator) -> bool:
    """minimal.conf leaves it out."""
    return "shell_uart_stack" in sim.objects()


def tour(sim: QemuSimulator) -> None:
    """A bit of everything that the light does."""
    light = light_on(sim)
    assert light.configure(brightness=80, period_s=0.1, duty=30) == ACCEPTED
    assert light.on() == ACCEPTED
    for message in (0, 148, STATUS, 396, 397):
        light.mav.command_long(REQUEST_MESSAGE, message)
    if has_shell(sim):
        shell = Shell(sim)
        # the last two are one command, before Zephyr 4.0 and since
        for line in ("help", "light status", "thermal", "param list", *THREAD_LISTS):
            shell(line)
        shell("param set STRB_MIN 0.02")
    d = light.mav.dialect
    light.mav.send(d.MAVLink_param_request_list_message(1, 243))
    light.mav.send(d.MAVLink_param_set_message(1, 243, b"THR_FLOOR", 25.0, 9))
    light.mav.send(d.MAVLink_ping_message(1, 7, 0, 0))
    light.mav.send(d.MAVLink_timesync_message(0, 5))
    sim.advance(s=5)
    light.off()
    sim.advance(s=3)


def test_stacks_have_a_reserve(sim: QemuSimulator) -> None:
    tour(sim)
    used = stacks(sim)
    print("\n".join(f"{name:<16}{most:>6} of {size}" for name, (most, size) in used.items()))
    assert {"supervisor", "thermal", "command", "uart_link0", "storage", "main"} <= set(used)
    tight = {n: u for n, u in used.items() if u[0] > u[1] * (100 - RESERVE_PERCENT) // 100}
    assert not tight
    for name, (most, size) in used.items():
        room = REFERENCE_SIZES.get(name, size) - (FPU_GUARD if name != "interrupt" else 0)
        assert most + FPU_FRAME <= room * (100 - RESERVE_PERCENT) // 100, name


def _enable_writes(sim: QemuSimulator) -> list[int]:
    return [
        int(line.rpartition("0x")[2].rstrip(")"), 16) & 1
        for line in sim.log().splitlines()
        if GPIO_DATA_OUT in line
    ]


def test_clock_goes_on_over_a_reboot(sim: QemuSimulator) -> None:
    light = light_on(sim)
    sim.advance(s=10)
    assert light.mav.command_long(REBOOT, 0, 0, 1).result == ACCEPTED
    before = sim.now_us()
    sim.advance(s=2)
    assert sim.now_us() == before + 2_000_000
    light.greet()
    took = (sim.now_us() - before) // 1000
    assert took - 1000 < light.status().uptime_ms <= took + 1, "it reboots within a second"


@pytest.mark.parametrize("kind", ["fault", "assertion"])
def test_lamp_is_off_before_the_reset(sim: QemuSimulator, kind: str) -> None:
    light = light_on(sim)
    assert light.on() == ACCEPTED
    assert _enable_writes(sim)[-1] == 1
    where = sim.address("endpoint" if kind == "fault" else "pharos_assert_failed")
    if kind == "fault":
        sim.write(where, UNDEFINED)
    assert sim.derail("thermal_step", where, until="sys_reboot")
    assert _enable_writes(sim)[-1] == 0
