# SPDX-License-Identifier: Apache-2.0
"""A Zephyr image in QEMU in place of the native light, over its UARTs: one for mps2_an385, or for
olimex_stm32_h405 (an STM32F405).

Time is the guest's, in lock-step: instructions are counted, an idle processor jumps to its next
event, and a breakpoint where it goes idle stops it there. So nothing depends on the host's speed.

QEMU takes a processor that a breakpoint has stopped for an idle one, and its clock jumps to the
next timer of any device before the stop is complete. So a timer that the image does not use ticks
while code runs, which bounds that jump; and set to an instant, it is how an idle guest's clock
gets there. The STM32's image polls its UARTs: its own timer for that, of 1 ms, bounds the jump, and
is how fine time is.

Of a Simulator this has the wires `uart0` (MAVLink) and `console`, and time; a test that asks for
more is skipped, and says what for.
"""

from __future__ import annotations

import fcntl
import re
import select
import socket
import struct
import subprocess
import termios
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

import pytest
from elftools.common.exceptions import ELFError
from elftools.elf.elffile import ELFFile

from pharos import Link, Simulator
from pharos.errors import LinkError, SimulatorError
from pharos.sim import Wire

QEMU = "qemu-system-arm"
# An instruction takes 2^3 = 8 ns, about what it does on a microcontroller of 170 MHz.
TIME = ["-icount", "shift=3,align=off,sleep=off", "-rtc", "clock=vm"]
HOST_TIMEOUT_S = 20.0
BARRIER = bytes.fromhex("bff36f8f")  # isb

# SysTick counts down to the next event; its driver counts the cycles until it began to.
SYST_CVR = 0xE000E018
ICSR, ICSR_PENDSTSET = 0xE000ED04, 1 << 26
INSTRUCTIONS_PER_CYCLE = 5  # of mps2_an385's cycles, of 40 ns
CYCLES_WRAP = 1 << 32
CYCLES_SLEEP_MAX = 1 << 25  # SysTick has 24 bits; more than this at once is a reset
RAM_START = 0x20000000
MEMORY_CHUNK = 1024


@dataclass(frozen=True)
class Machine:
    """What differs between the boards."""

    name: str
    cycles_per_us: int
    # QEMU's serial ports, in its order.
    serials: tuple[str, ...]
    uarts: Mapping[str, int]
    # Of a UART: offset and bit of "a byte waits for the guest", and of "the guest receives".
    rx_full: tuple[int, int]
    rx_enable: tuple[int, int]
    # Control, value and reload of a timer whose interrupt stays disabled, at the processor's clock.
    timer: tuple[int, int, int] | None = None


MACHINES = {
    # The UARTs and the timer are Arm's CMSDK ones.
    "mps2_an385": Machine(
        name="mps2-an385",
        cycles_per_us=25,
        serials=("console", "uart0"),
        uarts={"console": 0x40004000, "uart0": 0x40005000},
        rx_full=(4, 2),
        rx_enable=(8, 2),
        timer=(0x40000000, 0x40000004, 0x40000008),
    ),
    "olimex_stm32_h405": Machine(
        name="netduinoplus2",
        cycles_per_us=168,
        serials=("uart0", "console"),
        uarts={"uart0": 0x40011000, "console": 0x40004400},
        rx_full=(0, 1 << 5),
        rx_enable=(12, 1 << 2),
    ),
}


def machine_of(image: Path) -> Machine:
    """By the board that the image was built for, which its folder says."""
    configuration = image.with_name(".config")
    board = re.search(r'^CONFIG_BOARD="(\w+)"$', configuration.read_text(), re.MULTILINE)
    if board is None:
        raise SimulatorError(f"{configuration}: no CONFIG_BOARD")
    # from Zephyr 3.7 on a board's name is without its chip's
    names = [name for name in MACHINES if name.startswith(board[1])]
    if not names:
        raise SimulatorError(f"{image} is for {board[1]}, not for one of {', '.join(MACHINES)}")
    return MACHINES[names[0]]


def symbols(image: Path) -> dict[str, tuple[int, int]]:
    """Address and size of an image's symbols; the first of each name."""
    found: dict[str, tuple[int, int]] = {}
    try:
        with image.open("rb") as file:
            for symbol in ELFFile(file).get_section_by_name(".symtab").iter_symbols():
                address, extent = symbol["st_value"], symbol["st_size"]
                found.setdefault(symbol.name, (address & ~1 if extent else address, extent))
    except ELFError as error:
        raise SimulatorError(f"{image}: {error}") from error
    return found


def _connect(path: Path, process: subprocess.Popen[bytes]) -> socket.socket:
    deadline = time.monotonic() + HOST_TIMEOUT_S
    while True:
        stream = socket.socket(socket.AF_UNIX)
        try:
            stream.connect(str(path))
            return stream
        except OSError as error:
            stream.close()
            if process.poll() is not None or time.monotonic() > deadline:
                raise SimulatorError(f"{QEMU}: no {path.name}: {error}") from error
            time.sleep(0.005)


class Debugger:
    """As much of GDB's remote protocol as it takes to run from one stop to the next."""

    def __init__(self, stream: socket.socket) -> None:
        self._stream = stream
        self._buffer = b""
        # Read while the guest runs: QEMU waits once some hundred bytes lie in a socket.
        self.links: list[Link] = []
        self.ask("qXfer:features:read:target.xml:0,ffb")  # else QEMU writes no registers

    def ask(self, *requests: str) -> list[str]:
        """The replies to requests that are sent together. QEMU takes the next request for the
        acknowledgement of a reply; a "+" would stop a guest that runs already."""
        packets = (f"${text}#{sum(text.encode()) & 0xFF:02x}" for text in requests)
        self._stream.sendall("".join(packets).encode())
        return [self._reply() for _ in requests]

    def _reply(self) -> str:
        while True:
            start = self._buffer.find(b"$")
            end = self._buffer.find(b"#", start)
            if start >= 0 and 0 <= end <= len(self._buffer) - 3:
                reply = self._buffer[start + 1 : end].decode()
                self._buffer = self._buffer[end + 3 :]
                return reply
            filenos = {link.fileno(): link for link in self.links}
            mine = self._stream.fileno()
            ready = select.select([mine, *filenos], [], [], HOST_TIMEOUT_S)[0]
            if not ready:
                raise SimulatorError("the guest is never idle")
            for fileno in set(ready) - {mine}:
                filenos[fileno].poll(0.0)
            if mine not in ready:
                continue
            more = self._stream.recv(4096)
            if not more:
                raise SimulatorError("QEMU has ended")
            self._buffer += more

    def words(self, *addresses: int) -> list[int]:
        replies = self.ask(*(f"m{address:x},4" for address in addresses))
        return [int(struct.unpack("<I", bytes.fromhex(reply))[0]) for reply in replies]

    def go(self, program_counter: int | None = None, *registers: tuple[int, int]) -> None:
        """Writes those registers of devices (address, value), and goes on from there to the next
        breakpoint; without a place, to the one that it stands at."""
        requests = ["Qqemu.PhyMemMode:1"] if registers else []
        requests += [f"M{at:x},4:{struct.pack('<I', value).hex()}" for at, value in registers]
        requests += ["Qqemu.PhyMemMode:0"] if registers else []
        if program_counter is not None:
            requests.append(f"Pf={struct.pack('<I', program_counter).hex()}")
        *written, stopped = self.ask(*requests, "c")
        if set(written) - {"OK"} or not stopped.startswith("T05"):
            raise SimulatorError(f"the guest stopped with {written} {stopped}")

    def close(self) -> None:
        self._stream.close()


class UartLink(Link):
    """The other end of a guest's UART."""

    def __init__(self, name: str, stream: socket.socket) -> None:
        super().__init__()
        self.name = name
        self._outgoing = b""
        self.taken = 0  # of what was sent, as far as the guest is known to have it
        self._stream = stream
        self._stream.settimeout(HOST_TIMEOUT_S)

    def fileno(self) -> int:
        return self._stream.fileno()

    def _write(self, data: bytes) -> None:
        self._outgoing += data

    def _read(self) -> bytes:
        data = self._stream.recv(65536)
        if not data:
            raise LinkError(f"{self}: QEMU has ended")
        return data

    def unread(self) -> int:
        """How much of what was handed to QEMU it has not taken yet."""
        (count,) = struct.unpack("i", fcntl.ioctl(self.fileno(), termios.TIOCOUTQ, b"\0" * 4))
        return int(count)

    def hand_over(self, *, all_at_once: bool) -> bool:
        """Hands the next byte to QEMU, if there is one. One by one: it would give the guest the
        next at once, wherever the guest is by then; to a guest that polls that makes no odds."""
        count = len(self._outgoing) if all_at_once else 1
        handed, self._outgoing = self._outgoing[:count], self._outgoing[count:]
        self._stream.sendall(handed)
        return bool(handed)

    def close(self) -> None:
        self._stream.close()

    def __str__(self) -> str:
        return f"{self.name} of the guest"


class QemuSimulator(Simulator):
    """The image as a subprocess; what of a Simulator it has not is a skipped test."""

    def __init__(
        self,
        image: Path,
        wires: Mapping[str, str] | None = None,
        *,
        seed: int = 1,
        options: Sequence[str] = (),
        dialect: Any = None,
    ) -> None:
        self._machine = machine_of(image)
        for name, address in (wires or {}).items():
            if name not in self._machine.uarts:
                pytest.skip(f"needs the native port: the image has no {name}")
            if name == "uart0" and not address.startswith(("qemu", "udpin:127.0.0.1:0")):
                pytest.skip(f"needs the native port: a UART that is {address.partition(':')[0]}")
        if options:
            pytest.skip("needs the native port: options on its command line")
        super().__init__(image, seed=seed, dialect=dialect)
        chardevs = {name: self.folder / name for name in ["gdb", *self._machine.uarts]}
        self.command = [QEMU, "-M", self._machine.name, *TIME]
        self.command += ["-display", "none", "-monitor", "none", "-S"]
        self.command += ["-d", "unimp", "-D", str(self.folder / "devices.log")]
        for name, path in chardevs.items():
            self.command += ["-chardev", f"socket,id={name},path={path},server=on,wait=off"]
        for name in self._machine.serials:
            self.command += ["-serial", f"chardev:{name}"]
        self.command += ["-gdb", "chardev:gdb", "-kernel", str(image)]
        self._symbols = symbols(image)
        self._links: dict[str, UartLink] = {}
        self._debugger: Debugger | None = None
        self._idle = 0
        self._guest_now = 0
        self._guest_cycles = 0
        self._cycles_seen = 0
        # Cycles by which a stop may be late; fewer take the host longer.
        self.tick = 10 * self._machine.cycles_per_us
        # When the guest woke and when it was idle again, each time, in cycles.
        self.busy: list[tuple[int, int]] = []

    def start(self) -> Simulator:
        with (self.folder / "qemu.log").open("wb") as log:
            try:
                self._process = subprocess.Popen(
                    self.command, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT
                )
            except OSError as error:
                raise SimulatorError(f"{QEMU}: {error.strerror}: `apt install {QEMU}`?") from error
        self._debugger = Debugger(_connect(self.folder / "gdb", self._process))
        for name in self._machine.uarts:
            self._links[name] = UartLink(name, _connect(self.folder / name, self._process))
        self._debugger.links = list(self._links.values())
        self._break_when_idle(self.address("arch_cpu_idle"))
        return self

    def stop(self) -> None:
        super().stop()
        if self._debugger is not None:
            self._debugger.close()
        for link in self._links.values():
            link.close()

    # --- time ---------------------------------------------------------------------------------
    def _break_when_idle(self, idle: int) -> None:
        """Stops at an instruction of that function that does nothing here, and goes on after it."""
        assert self._debugger is not None
        code = bytes.fromhex(self._debugger.ask(f"m{idle:x},40")[0])
        at = idle + code.find(BARRIER)
        if at < idle or self._debugger.ask(f"Z0,{at:x},2") != ["OK"]:
            raise SimulatorError(f"{QEMU}: no breakpoint where {self.binary} is idle")
        self._idle = at + len(BARRIER)
        self._debugger.go(None)

    def _advance_once(self, us: int, *also: tuple[str, dict[str, Any]]) -> list[dict[str, Any]]:
        assert self._debugger is not None
        self._now_us += us
        until = self._now_us * self._machine.cycles_per_us
        received = {name: a.port.received for name, a in self._attached.items()}
        while (wakes := self._wakes_at()) <= until:
            wakes = max(wakes, self._guest_now)
            left = max(wakes - self._guest_now, self.tick)
            self._debugger.go(self._idle, *self._timer(left))
            self._wakes_at()
            self.busy.append((wakes, self._guest_now))
        if until > self._guest_now and self._machine.timer:
            self._debugger.go(None, *self._timer(until - self._guest_now))
            self._wakes_at()
        self._now_us = self._guest_now // self._machine.cycles_per_us  # code takes time
        for attached in self._attached.values():
            while attached.port.poll(0.0):
                pass
        came = [a.port.received - received[name] for name, a in self._attached.items()]
        self._pace(us, max(came, default=0))
        return [{}, *(self.request(op, **fields) for op, fields in also)]

    def _timer(self, first: int) -> list[tuple[int, int]]:
        """Sets the timer, which a reset stops: in that many cycles, and at each tick from then."""
        if self._machine.timer is None:
            return []
        control, value, reload = self._machine.timer
        return [(control, 1), (reload, self.tick), (value, first)]

    def _byte_for_guest(self) -> bool:
        """Whether a byte for the guest lies in a UART; waits for QEMU to put it there."""
        assert self._debugger is not None
        deadline = time.monotonic() + HOST_TIMEOUT_S
        for name, link in self._links.items():
            if link.sent == link.taken:
                continue
            while True:
                left = link.unread()
                uart = self._machine.uarts[name]
                full_at, full = self._machine.rx_full
                enable_at, enable = self._machine.rx_enable
                state, control = self._debugger.words(uart + full_at, uart + enable_at)
                if state & full:
                    return True
                if left == 0 and not link.hand_over(all_at_once=self._machine.timer is None):
                    link.taken = link.sent
                    break
                if not control & enable:
                    break
                if time.monotonic() > deadline:
                    raise SimulatorError(f"{link}: QEMU takes nothing")
        return False

    def reset(self) -> None:
        """Resets processor and devices, as the line would. What was in RAM is lost, so are bytes
        that the guest has not read."""
        assert self._debugger is not None
        self._debugger.go(self.address("sys_arch_reboot"))
        self._wakes_at()

    def _wakes_at(self) -> int:
        """Board time in cycles at which the idle guest wakes; 0 if there is a byte for it."""
        assert self._debugger is not None
        byte_waits = self._byte_for_guest()
        load, count, left, state = self._debugger.words(
            self.address("last_load"), self.address("cycle_count"), SYST_CVR, ICSR
        )
        passed = (count - self._cycles_seen) % CYCLES_WRAP
        if passed > CYCLES_SLEEP_MAX:
            self._guest_cycles = self._guest_now + count
        else:
            self._guest_cycles += passed
        self._cycles_seen = count
        event = self._guest_cycles + load
        self._guest_now = event - (left or load)
        if state & ICSR_PENDSTSET:  # it has wrapped already
            self._guest_now += load
        return 0 if byte_waits else event

    # --- wires --------------------------------------------------------------------------------
    def wires(self) -> dict[str, Wire]:
        return {
            name: Wire(name, str(link), link.sent, link.received)
            for name, link in self._links.items()
        }

    def open(self, name: str) -> Link:
        if name not in self._links:
            pytest.skip(f"needs the native port: the image has no {name}")
        return self.attach(name, self._links[name])

    def console(self) -> str:
        link = self._links["console"]
        if "console" not in self._attached:
            while link.poll(0.0):
                pass
        return b"".join(link.inbox).decode(errors="replace")

    # --- the guest from the inside, while it is idle ------------------------------------------
    def address(self, symbol: str) -> int:
        return self._symbols[symbol][0]

    def objects(self) -> dict[str, tuple[int, int]]:
        """Address and size of everything in RAM that has a name."""
        return {n: at for n, at in self._symbols.items() if at[1] and at[0] >= RAM_START}

    def memory(self, address: int, size: int) -> bytes:
        assert self._debugger is not None
        chunks = range(address, address + size, MEMORY_CHUNK)
        ends = (min(at + MEMORY_CHUNK, address + size) for at in chunks)
        asked = [f"m{at:x},{end - at:x}" for at, end in zip(chunks, ends, strict=True)]
        return b"".join(bytes.fromhex(reply) for reply in self._debugger.ask(*asked))

    def write(self, address: int, data: bytes) -> None:
        assert self._debugger is not None
        assert self._debugger.ask(f"M{address:x},{len(data):x}:{data.hex()}") == ["OK"]

    def step(self) -> int:
        """Gives it the next byte and lets it run until it is idle, instruction by instruction; how
        many there were."""
        assert self._debugger is not None
        assert self._wakes_at() == 0, "no byte"
        here = self._idle
        written = self._debugger.ask("Qqemu.sstep=1", f"Pf={struct.pack('<I', here).hex()}")
        assert written == ["OK"] * 2
        steps = 0
        while here != self._idle - len(BARRIER):
            assert self._debugger.ask("s")[0].startswith("T05")
            here = self._program_counter()
            steps += 1
        return steps

    def _program_counter(self) -> int:
        assert self._debugger is not None
        (register,) = self._debugger.ask("pf")
        return int(struct.unpack("<I", bytes.fromhex(register))[0])

    def derail(self, inside: str, program_counter: int, until: str) -> bool:
        """Goes on somewhere else at the next call of one function, with an argument of 0; whether
        it gets to another one."""
        assert self._debugger is not None
        for name, start in ((inside, self._idle), (until, program_counter)):
            assert self._debugger.ask(f"Z0,{self.address(name):x},2", "P0=00000000") == ["OK"] * 2
            self._debugger.go(start)
        return self._program_counter() == self.address(until)

    def log(self) -> str:
        """What QEMU said of devices that it does not have."""
        path = self.folder / "devices.log"
        return path.read_text(errors="replace") if path.exists() else ""

    # --- what only the native port has ----------------------------------------------------------
    def request(self, op: str, **fields: Any) -> NoReturn:
        del fields
        pytest.skip(f"needs the native port's control socket: {op}")

    def bus(self, name: str = "can0") -> NoReturn:
        pytest.skip(f"needs the native port: the image has no {name}")

    def quit(self, timeout_s: float = 10.0) -> NoReturn:
        del timeout_s
        pytest.skip("needs the native port: to end the program")
