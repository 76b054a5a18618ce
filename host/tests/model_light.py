# SPDX-License-Identifier: Apache-2.0
"""An illuminator written from the MAVLink guide, in time of its own, for `pharos check` to find
fault with. It shares no code with the firmware. `faults` are the names that the code below asks
for."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Iterable
from typing import Any

from pymavlink.generator.mavcrc import x25crc

from model_files import PARAMETERS, ModelFiles, crc32
from pharos import Link, load_dialect

SYSTEM, COMPONENT, GIMBAL = 1, 243, 154
SHORTEST, LONGEST = 0.05, 20.0
ON_OFF, CONFIGURE, REQUEST, SET_INTERVAL = 405, 406, 512, 511
STATUS, INFORMATION, METADATA, INTERVAL = 440, 396, 397, 244
ACCEPTED, REJECTED, DENIED, UNSUPPORTED = 0, 1, 2, 3
SECOND = 1_000_000
# More commands than anybody sends again, and so many as the next requirement is spared.
DEAF = 10


class ModelLight(Link):
    """The light, and the other end of its wire: send() is what it hears, `inbox` what it says.
    It is a Pacer too: its time passes when it is asked to."""

    def __init__(self, faults: Iterable[str] = (), *, modes: int = 3, gimbal: bool = False) -> None:
        super().__init__()
        self.faults = frozenset(faults)
        self.asked: set[str] = set()
        self.d: Any = load_dialect()
        self.codec = self.d.MAVLink(None, SYSTEM, COMPONENT)
        self.codec.robust_parsing = True
        self.now = 0
        self.modes = modes
        self.gimbal = self.d.MAVLink(None, SYSTEM, GIMBAL) if gimbal else None
        self.attitude_due = SECOND // 10
        self.enable, self.mode = 0, 1
        self.brightness, self.period, self.duty = 100.0, 0.0, 0.0
        self.interval: int = SECOND
        self.heartbeat_due, self.status_due = SECOND, SECOND
        self.later: list[tuple[int, Callable[[], None]]] = []
        self.buffer = b""
        self.deaf = 0
        self.beats = 0
        self.requests = 0
        self.lists = 0
        self.first_client: tuple[int, int] | None = None
        self.files = ModelFiles(self.faults, self.has)

    def has(self, fault: str) -> bool:
        self.asked.add(fault)
        return fault in self.faults

    # --- as a link and a pacer ----------------------------------------------------------------
    def fileno(self) -> int:
        return -1

    def poll(self, timeout_s: float) -> bool:
        del timeout_s
        return False

    def _read(self) -> bytes:
        return b""

    def close(self) -> None:
        pass

    def __str__(self) -> str:
        return "model"

    def now_us(self) -> int:
        return self.now

    def pump(self, us: int) -> None:
        end = self.now + us
        while True:
            own = (self.heartbeat_due, self.status_due, self.attitude_due)
            due = min([*own, *(at for at, _ in self.later)])
            if due > end:
                break
            self.now = max(self.now, due)
            self.act()
        self.now = end

    def act(self) -> None:
        for entry in [entry for entry in self.later if entry[0] <= self.now]:
            self.later.remove(entry)
            entry[1]()
        if self.now >= self.heartbeat_due:
            self.heartbeat_due += 4 * SECOND if self.has("heartbeat every 4 s") else SECOND
            self.beat()
        if self.now >= self.attitude_due:
            self.attitude_due += SECOND // 10
            self.say_attitude()
        if self.now >= self.status_due:
            self.status_due += self.interval if self.interval > 0 else SECOND
            if self.interval > 0:
                self.say_status(streamed=True)

    # --- what comes out of the lamp -----------------------------------------------------------
    def level(self, time_us: int) -> float:
        """Of full, with the settings of now."""
        if self.has("stays lit when it is off") and not self.enable:
            return self.brightness / 100
        if not self.enable or self.has("is dark for good"):
            return 0.0
        level = self.brightness / 100
        if self.has("is all the same to brightness"):
            level = 0.05
        period, duty = self.period, self.duty / 100
        if self.has("flashes where it should be steady") and duty == 1:
            duty = 0.9
        if period <= 0 or not 0 < duty < 1:
            return level
        if self.has("strobes 10 % too slowly"):
            period *= 1.1
        if self.has("takes lit for dark") and duty < 0.5:
            duty = 1 - duty
        return level if time_us % (period * 1e6) < duty * period * 1e6 else 0.0

    # --- saying -------------------------------------------------------------------------------
    def say_of_gimbal(self, message: Any) -> None:
        light, self.codec = self.codec, self.gimbal
        try:
            self.say(copy.copy(message))
        finally:
            self.codec = light

    def say_attitude(self) -> None:
        if self.gimbal is None or self.has("gimbal is still"):
            return
        q = [2.0, 0.0, 0.0, 0.0] if self.has("quaternion too long") else [1.0, 0.0, 0.0, 0.0]
        self.say_of_gimbal(
            self.d.MAVLink_gimbal_device_attitude_status_message(
                0, 0, self.now // 1000, 12, q, 0, 0, 0, 0
            )
        )

    def say_gimbal_information(self) -> None:
        limits = [-math.pi / 2, math.pi / 2]
        if self.has("gimbal's limits in degrees"):
            limits = [-90.0, 90.0]
        if self.has("gimbal's limits upside down"):
            limits.reverse()
        self.say_of_gimbal(
            self.d.MAVLink_gimbal_device_information_message(
                self.now // 1000, b"Model", b"Gimbal", b"", 1, 1, 0, 0, 0, *limits, *limits, *limits
            )
        )

    def on_gimbal_command(self, message: Any) -> None:
        known = message.param1 == 283 and not self.has("gimbal does not know itself")
        to = (message.get_srcSystem(), message.get_srcComponent())
        ack = self.d.MAVLink_command_ack_message(
            message.command, ACCEPTED if known else DENIED, 0, 0, *to
        )
        if self.has("light answers for its gimbal"):
            self.say(ack)
        else:
            self.say_of_gimbal(ack)
        if known:
            self.say_gimbal_information()

    def say(self, message: Any) -> None:
        old = self.has("answers in MAVLink 1") and message.get_msgId() < 256
        frame = bytes(message.pack(self.codec, force_mavlink1=old))
        if not self.has("sequence number stays"):
            self.codec.seq = (self.codec.seq + 1) % 256
        if self.has("zeros are not cut off") and frame[0] == 0xFD:
            frame = self.reframe(frame, frame[10 : 10 + frame[1]] + bytes(2), message.crc_extra)
        if message.get_type() == "HEARTBEAT" and self.has("every third heartbeat is damaged"):
            self.beats += 1
            if self.beats % 3 == 0:
                frame = frame[:-1] + bytes([frame[-1] ^ 0x55])
        self.received += len(frame)
        self.inbox.append(frame)

    @staticmethod
    def reframe(frame: bytes, payload: bytes, crc_extra: int) -> bytes:
        body = bytes([frame[0], len(payload)]) + frame[2:10] + payload
        crc = x25crc(body[1:])
        crc.accumulate(bytes([crc_extra]))
        return body + int(crc.crc).to_bytes(2, "little")

    def beat(self) -> None:
        kind = 18 if self.has("says it is a computer") else 44
        if self.has("changes its type") and self.now // SECOND % 2:
            kind = 0
        version = 0 if self.has("says version 0") else 3
        self.say(self.d.MAVLink_heartbeat_message(kind, 8, 0, 0, 4, version))
        if self.gimbal is not None:
            self.say_of_gimbal(self.d.MAVLink_heartbeat_message(26, 8, 0, 0, 4, 3))

    def say_status(self, streamed: bool = False) -> None:
        uptime = self.now // (SECOND if self.has("uptime in seconds") else 1000)
        enable = self.enable * (255 if self.has("on is 255") else 1)
        mode = 4 if self.has("reports a mode that it lacks") else self.mode
        modes = self.modes | (4 if self.has("bitmask with a fourth bit") else 0)
        errors = 8 if self.has("an undefined error") else 0
        brightness = self.brightness
        if streamed and self.has("stream is of old settings"):
            brightness = 100.0
        if self.has("brightness as a fraction"):
            brightness /= 100
        period = self.period * (1000 if self.has("period in ms") else 1)
        temperature = 298.15 if self.has("temperature in kelvin") else 25.0
        low, high = SHORTEST, LONGEST
        if self.has("range of periods upside down"):
            low, high = high, low
        self.say(
            self.d.MAVLink_illuminator_status_message(
                uptime, enable, modes, errors, mode, brightness, period, self.duty, temperature,
                low, high,
            )
        )  # fmt: skip

    def say_information(self) -> None:
        serial = b"7" * 32 if self.has("serial number fills its field") else b"0042"
        uptime = 0 if self.has("boot time stays 0") else self.now // 1000
        flags = 8192 | 32 | 16 | 8
        message = self.d.MAVLink_component_information_basic_message(
            uptime, flags, 0, b"Model", b"Light", b"1.2.3", b"1.0.0", serial
        )
        for _ in range(2 if self.has("information comes twice") else 1):
            self.say(message)

    def say_metadata(self) -> None:
        uri = (
            b"mftp:///gone.json" if self.has("general file is missing") else b"mftp:///general.json"
        )
        crc = 1 if self.has("wrong CRC of the general file") else crc32(self.files["/general.json"])
        self.say(self.d.MAVLink_component_metadata_message(self.now // 1000, crc, uri))

    def acknowledge(self, command: int, result: int, to: tuple[int, int]) -> None:
        if self.has("acknowledges to 1/1"):
            to = (1, 1)
        self.first_client = self.first_client or to
        if self.has("acknowledges to its first client"):
            to = self.first_client
        message = self.d.MAVLink_command_ack_message(command, result, 0, 0, *to)
        for _ in range(2 if self.has("acknowledges twice") else 1):
            self.say(message)

    # --- hearing ------------------------------------------------------------------------------
    def _write(self, data: bytes) -> None:
        size = 12 + data[1] if len(data) >= 12 and data[0] == 0xFD else 0
        if self.has("takes whole frames only") and len(data) < max(size, 8):
            return
        if self.has("takes one frame at a time") and size:
            data = data[:size]
        if self.has("is deaf after half a frame") and len(data) < size < 60:
            self.deaf = DEAF
        if self.has("is deaf after garbage") and len(data) < size and size > 60:
            self.deaf = DEAF
        self.buffer += data
        while (frame := self.next_frame()) is not None:
            if self.deaf and frame[0] == 0xFD and frame[7:10] == b"\x4c\0\0":
                self.deaf -= 1
            elif not self.deaf:
                self.hear(frame)

    def next_frame(self) -> bytes | None:
        while self.buffer:
            if self.buffer[0] not in (0xFD, 0xFE):
                self.buffer = self.buffer[1:]
                continue
            new = self.buffer[0] == 0xFD
            size = (12 if new else 8) + (self.buffer[1] if len(self.buffer) > 1 else 0)
            if new and len(self.buffer) > 2 and self.buffer[2] & 1:
                size += 13
            if len(self.buffer) < size or len(self.buffer) < 3:
                # A start that never ends must not keep what comes after it waiting.
                rest = self.buffer[1:]
                if (later := self.whole_frame_in(rest)) is None:
                    return None
                self.buffer = rest[later:]
                continue
            frame = self.buffer[:size]
            if not self.is_sound(frame):
                self.buffer = self.buffer[1:]
                continue
            self.buffer = self.buffer[size:]
            return frame
        return None

    def whole_frame_in(self, data: bytes) -> int | None:
        """Where in it a sound frame begins."""
        for at, byte in enumerate(data):
            if byte == 0xFD and len(data) > at + 2:
                size = 12 + data[at + 1]
                if len(data) >= at + size and self.is_sound(data[at : at + size], strictly=True):
                    return at
        return None

    def crc_extra(self, number: int) -> int:
        kind = self.d.mavlink_map.get(number)
        return int(kind.crc_extra) if kind else 0

    def is_sound(self, frame: bytes, strictly: bool = False) -> bool:
        new = frame[0] == 0xFD
        body = (10 if new else 6) + frame[1]
        number = int.from_bytes(frame[7:10], "little") if new else frame[5]
        crc = x25crc(frame[1:body])
        crc.accumulate(bytes([self.crc_extra(number)]))
        if int(crc.crc) != int.from_bytes(frame[body : body + 2], "little"):
            known = number == 76 and not strictly
            return bool(known and self.has("does not look at checksums"))
        if new and frame[2] and not self.has("ignores unknown flags"):
            return False
        if new and frame[3] and self.has("refuses compatibility flags"):
            return False
        return not (self.has("refuses payloads with zeros") and new and frame[body - 1] == 0)

    def hear(self, frame: bytes) -> None:
        new = frame[0] == 0xFD
        number = int.from_bytes(frame[7:10], "little") if new else frame[5]
        if number not in self.d.mavlink_map:
            if self.has("is deaf after an unknown message"):
                self.deaf = DEAF
            return
        if new:  # the library looks at checksum and flags again
            frame = self.reframe(
                frame[:2] + b"\0\0" + frame[4:], frame[10 : 10 + frame[1]], self.crc_extra(number)
            )
        message = self.codec.decode(bytearray(frame))
        handler = getattr(self, f"on_{message.get_type().lower()}", None)
        if handler is not None:
            handler(message)

    def is_for_us(self, message: Any, faults: tuple[str, str, str]) -> bool:
        """faults: what lets it take others' components, others' systems, or leave out
        broadcasts."""
        system, component = message.target_system, message.target_component
        if (system == 0 or component == 0) and self.has(faults[2]):
            return False
        right_system = system in (0, SYSTEM) or self.has(faults[1])
        return right_system and (component in (0, COMPONENT) or self.has(faults[0]))

    # --- commands -----------------------------------------------------------------------------
    WHOSE = ("takes others' components", "takes others' systems", "does not hear broadcasts")

    def on_command_long(self, message: Any) -> None:
        p = [getattr(message, f"param{n}") for n in range(1, 8)]
        if message.confirmation and self.has("takes no confirmation"):
            return
        self.on_command(message, p)

    def on_command_int(self, message: Any) -> None:
        if self.has("ignores COMMAND_INT"):
            return
        p = [getattr(message, f"param{n}") for n in range(1, 5)]
        self.on_command(message, [*p, float(message.x), float(message.y), message.z], True)

    def on_command(self, message: Any, p: list[float], as_int: bool = False) -> None:
        if (message.target_system, message.target_component) == (SYSTEM, GIMBAL) and self.gimbal:
            self.on_gimbal_command(message)
            return
        if not self.is_for_us(message, self.WHOSE):
            return
        command = int(message.command)
        to = (message.get_srcSystem(), message.get_srcComponent())
        if command == REQUEST:
            self.on_request(p, to)
            return
        self.requests = 0
        if as_int and self.has("does nothing for COMMAND_INT"):
            self.acknowledge(command, ACCEPTED, to)
            return
        before = (self.enable, self.brightness, self.mode, self.period, self.duty)
        result = self.carry_out(command, p)
        if result == UNSUPPORTED and (self.has("is silent about unknown commands")):
            return
        if result == UNSUPPORTED and 0 in (message.target_system, message.target_component):
            return
        after = (self.enable, self.brightness, self.mode, self.period, self.duty)
        if command == ON_OFF and self.has("acknowledges before it switches") and after != before:
            self.enable = before[0]
            self.later.append((self.now + 150_000, lambda: setattr(self, "enable", after[0])))
        self.acknowledge(command, result, to)

    def carry_out(self, command: int, p: list[float]) -> int:
        if command == ON_OFF:
            return self.on_off(p[0])
        if command == CONFIGURE:
            return self.configure(p)
        if command == SET_INTERVAL:
            return self.set_interval(p)
        return ACCEPTED if self.has("accepts unknown commands") else UNSUPPORTED

    def on_off(self, value: float) -> int:
        if value == 2 and self.has("takes 2 for on") or value != value and self.has("NaN is on"):
            value = 1
        if value not in (0, 1):
            if self.has("switches though it denies"):
                self.enable = 1 - self.enable
            return DENIED
        if value == 0 and self.has("cannot be switched off"):
            return REJECTED
        if value == 1 and self.enable and self.has("on switches off"):
            value = 0
        if value == 1 and self.has("on means full brightness"):
            self.brightness = 100.0
        self.enable = int(value)
        return ACCEPTED

    def configure(self, p: list[float]) -> int:
        mode, brightness, period, duty = p[:4]
        if self.has("takes half of it") and 0 <= brightness <= 100:
            self.brightness = brightness
        same = (mode, brightness, period, duty) == (
            self.mode, self.brightness, self.period, self.duty,
        )  # fmt: skip
        if same and self.enable and self.has("rejects the same again"):
            return REJECTED
        if mode not in (1, 2) or not int(mode) & self.modes:
            if not (mode == 3 and self.has("takes mode 3")):
                return DENIED
            mode = 1
        if mode == 2 and self.has("lacks a mode of its bitmask"):
            return DENIED
        if math.isnan(brightness) and self.has("takes over NaN"):
            self.brightness = brightness
            return ACCEPTED
        if brightness > 100 and self.has("clamps brightness"):
            brightness = 100.0
        if brightness == 100 and self.has("denies 100 %"):
            return DENIED
        if not 0 <= brightness <= 100:
            return DENIED
        if period > LONGEST and self.has("clamps periods"):
            period = LONGEST
        if period == LONGEST and self.has("denies its longest period"):
            return DENIED
        # As floats of 32 bits, the shortest period is a little below what it was written as.
        if not (period == 0 or SHORTEST * 0.999999 <= period <= LONGEST * 1.000001):
            return DENIED
        if duty > 100 and self.has("clamps the duty cycle"):
            duty = 100.0
        if duty == 100 and self.has("denies a duty cycle of 100 %"):
            return DENIED
        if not 0 <= duty <= 100:
            return DENIED
        if self.has("rounds brightness to tens"):
            brightness = round(brightness, -1)
        self.mode, self.brightness, self.period, self.duty = int(mode), brightness, period, duty
        if self.has("settings switch it on"):
            self.enable = 1
        return ACCEPTED

    def on_request(self, p: list[float], to: tuple[int, int]) -> None:
        number = p[0]
        self.requests += 1
        senders: dict[float, Callable[[], None]] = {
            STATUS: self.say_status,
            INFORMATION: self.say_information,
            METADATA: self.say_metadata,
            INTERVAL: lambda: self.say_interval(p[1]),
        }
        if number == INFORMATION and self.has("lacks its information"):
            del senders[INFORMATION]
        if number not in senders:
            accepted = self.has("accepts requests for what it lacks")
            self.acknowledge(REQUEST, ACCEPTED if accepted else DENIED, to)
            return
        if number == STATUS and self.has("accepts, and sends no status"):
            self.acknowledge(REQUEST, ACCEPTED, to)
            return
        if self.has("sends before it acknowledges"):
            senders[number]()
            self.acknowledge(REQUEST, ACCEPTED, to)
            return

        def answer() -> None:
            self.acknowledge(REQUEST, ACCEPTED, to)
            senders[number]()

        if self.requests % 8 == 0 and self.has("is slow now and then"):
            self.later.append((self.now + 1_500_000, answer))
        else:
            answer()

    def set_interval(self, p: list[float]) -> int:
        number, interval = p[0], p[1]
        if number != STATUS:
            return ACCEPTED if self.has("takes intervals for what it lacks") else DENIED
        if interval < -1 and not self.has("takes any negative interval"):
            return DENIED
        if interval > 0 and self.has("ignores intervals"):
            return ACCEPTED
        if interval == -1 and self.has("does not stop"):
            return ACCEPTED
        if interval == 0 and self.has("has no default rate") and self.interval < 0:
            return ACCEPTED
        self.interval = SECOND if interval == 0 else int(interval)
        self.status_due = self.now + max(self.interval, 0)
        return ACCEPTED

    def say_interval(self, number: float) -> None:
        value = self.interval if number == STATUS else 0
        if self.has("intervals in ms") and value > 0:
            value //= 1000
        self.say(self.d.MAVLink_message_interval_message(int(number), value))

    # --- parameters ---------------------------------------------------------------------------
    PARAMETERS_WHOSE = (
        "tells others' parameters", "tells other systems' parameters",
        "tells parameters only when named",
    )  # fmt: skip

    def say_parameter(self, index: int, name: str | None = None) -> None:
        names = list(PARAMETERS)
        value = list(PARAMETERS.values())[index]
        shown = name or names[index]
        if index == 2 and name is None and self.has("two parameters of one name"):
            shown = names[1]
        self.say(self.d.MAVLink_param_value_message(shown.encode(), value, 9, len(names), index))

    def on_param_request_list(self, message: Any) -> None:
        if not self.is_for_us(message, self.PARAMETERS_WHOSE):
            return
        self.lists += 1
        for index in range(len(PARAMETERS)):
            if index == 3 and self.has("leaves one parameter out"):
                continue
            grown = index == 0 and self.lists > 1 and self.has("renames a parameter")
            self.say_parameter(index, "BRIGHTNESS" if grown else None)

    def on_param_request_read(self, message: Any) -> None:
        if not self.is_for_us(message, self.PARAMETERS_WHOSE):
            return
        names = list(PARAMETERS)
        index = int(message.param_index)
        if index >= 0:
            if self.has("counts parameters from 1"):
                index = max(index - 1, 0)
            if index < len(names):
                self.say_parameter(index)
            return
        name = str(message.param_id).rstrip("\0")
        if name in names:
            at = names.index(name)
            self.say_parameter((at + 1) % 4 if self.has("mixes names up") else at)
        elif self.has("knows any name"):
            self.say_parameter(0, name)

    def on_param_set(self, message: Any) -> None:
        name = str(message.param_id).rstrip("\0")
        if not self.is_for_us(message, self.PARAMETERS_WHOSE):
            return
        if name in PARAMETERS and not self.has("sets without a word"):
            self.say_parameter(list(PARAMETERS).index(name))

    # --- files --------------------------------------------------------------------------------
    def on_file_transfer_protocol(self, message: Any) -> None:
        if (message.target_system, message.target_component) != (SYSTEM, COMPONENT):
            return
        if self.has("has no FTP"):
            return
        reply = self.files.answer(bytes(message.payload), self.now)
        to = (message.get_srcSystem(), message.get_srcComponent())
        self.say(self.d.MAVLink_file_transfer_protocol_message(0, *to, reply.ljust(251, b"\0")))
