# SPDX-License-Identifier: Apache-2.0
"""New firmware for devices: over DroneCAN, any number of nodes at once, or over MAVLink FTP.

Over DroneCAN a node is told where the file is and reads it at its own pace; whoever restarts or
gives up on the way is told again. Over MAVLink FTP the light's file `firmware.bin` is written; a
link that was lost goes on where it was. Either way the device verifies the image before it starts
it, and then has to run for a while: a bootloader takes back what does not.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import Any, Protocol

from .errors import CommandError, PharosError, SilentError, UsageError
from .ftp import FileClient, FileError, crc32
from .light import Light

FIRMWARE = "firmware.bin"
REASON = "Update: "  # what a light's STATUSTEXT about one begins with
IMAGE_MAX = 64 << 20
# What an image of MCUboot's begins with: magic, …, version.
MCUBOOT_HEADER = struct.Struct("<I16xBBHI")
MCUBOOT_MAGIC = 0x96F3B83D
# New firmware confirms itself after 10 s; one that resets before is taken back [µs].
TRIAL_US = 12_000_000
PATIENCE_US = 30_000_000
# How far the start of a device may seem to move: answers take their time [µs].
CLOCKS_US = 2_000_000
STEP_US = 50_000


class UpdatePhase(Enum):
    """What is being done with a device, in words for people."""

    ASKING = "asks"
    WRITING = "writes"
    CHECKING = "checks"
    RESTARTING = "restarts"
    TRIAL = "is on trial"
    DONE = "done"
    FAILED = "failed"


@dataclass
class UpdateProgress:
    """One device's update. `percent`: of the image that is there. `text`: why it failed, or what
    runs now. `is_silent`: it failed because the device said nothing."""

    device: str
    phase: UpdatePhase = UpdatePhase.ASKING
    percent: int = 0
    text: str = ""
    is_silent: bool = False

    def __str__(self) -> str:
        done = f" {self.percent} %" if self.phase is UpdatePhase.WRITING else ""
        return f"{self.device}: {self.phase.value}{done}" + (f", {self.text}" if self.text else "")

    def as_fields(self) -> dict[str, Any]:
        return {
            "device": self.device,
            "phase": self.phase.name.lower(),
            "percent": self.percent,
            "text": self.text,
        }


def read_image(path: str) -> bytes:
    """The file. UsageError: it is not there, empty, or too large for any device."""
    try:
        with Path(path).open("rb") as file:
            content = file.read(IMAGE_MAX + 1)
    except (OSError, ValueError) as error:
        raise UsageError(f"{path}: {getattr(error, 'strerror', None) or error}") from error
    if not content or len(content) > IMAGE_MAX:
        raise UsageError(f"{path}: {'is empty' if not content else 'is no firmware: too large'}")
    return content


def version_of(content: bytes) -> str:
    """Of an image of MCUboot's; "" for any other file."""
    if len(content) < MCUBOOT_HEADER.size:
        return ""
    magic, major, minor, revision, build = MCUBOOT_HEADER.unpack_from(content)
    return f"{major}.{minor}.{revision}+{build}" if magic == MCUBOOT_MAGIC else ""


# --- MAVLink FTP ----------------------------------------------------------------------------------
def update_light(
    light: Light,
    content: bytes,
    on_progress: Callable[[UpdateProgress], None] = lambda _: None,
    *,
    force: bool = False,
    patience_us: int = PATIENCE_US,
) -> UpdateProgress:
    """Writes the image, lets the light verify it, restarts it and waits until it has run for a
    while. force: also while the lamp is on, which goes dark. SilentError: it was lost for longer
    than patience_us; CommandError, FileError: it refuses; PharosError: the image does not do."""
    target = light.connection.target
    progress = UpdateProgress(f"{target.system}/{target.component}")
    if not version_of(content):
        raise UsageError("that file is not an image of MCUboot's, which this way needs")
    before = light.fetch_information().software_version
    _refuse_while_lit(light, force)

    def tell(phase: UpdatePhase, percent: int = progress.percent, text: str = "") -> None:
        if (progress.phase, progress.percent) != (phase, percent) or text:
            progress.phase, progress.percent, progress.text = phase, percent, text
            on_progress(progress)

    on_progress(progress)
    light.texts.clear()
    try:
        FileClient(light, patience_us).write(
            FIRMWARE, content, lambda at, of: tell(UpdatePhase.WRITING, at * 100 // of),
            lambda: tell(UpdatePhase.CHECKING, 100),
        )  # fmt: skip
    except FileError as error:
        reason = _reason_of(light) or str(error)
        raise PharosError(f"the light refuses the image: {reason}") from error
    light.texts.clear()
    tell(UpdatePhase.RESTARTING, 100)
    booted_us = _restart(light, force, patience_us)
    tell(UpdatePhase.TRIAL, 100)
    _watch_trial(light, booted_us, patience_us)
    now = light.fetch_information().software_version
    tell(UpdatePhase.DONE, 100, f"version {before} before, {now} now")
    return progress


def _reason_of(light: Light) -> str:
    """What the light says to people about an update that failed."""
    light.poll(300_000)
    reasons = [text for text in light.texts if text.startswith(REASON)]
    light.texts.clear()
    return reasons[-1].removeprefix(REASON) if reasons else ""


def _refuse_while_lit(light: Light, force: bool) -> None:
    if not force and light.fetch_status().enable:
        raise CommandError(
            "the lamp is on, and a restart makes it dark: `off` first, or --force", 1
        )


def _booted_us(light: Light) -> int | None:
    """When it started, by our clock; None: it is away."""
    try:
        uptime_us = 1000 * light.fetch_status().uptime_ms
    except (SilentError, CommandError):
        return None
    return light.connection.pacer.now_us() - uptime_us


def _restart(light: Light, force: bool, patience_us: int) -> int:
    """When it started again."""
    pacer = light.connection.pacer
    light.reboot(force)
    begun = pacer.now_us()
    while pacer.now_us() - begun < patience_us:
        light.poll(200_000)
        booted = _booted_us(light)
        if booted is not None and booted > begun:
            return booted
    raise light.connection.silence(
        f"the light did not come back within {patience_us / 1e6:g} s; the image is installed"
    )


def _watch_trial(light: Light, booted_us: int, patience_us: int) -> None:
    """PharosError: it reset meanwhile; the bootloader has taken the new firmware back."""
    pacer = light.connection.pacer
    heard = pacer.now_us()
    while pacer.now_us() - booted_us < TRIAL_US:
        light.poll(1_000_000)
        booted = _booted_us(light)
        if booted is None:
            if pacer.now_us() - heard > patience_us:
                raise light.connection.silence("the light was lost while on trial")
            continue
        if booted > booted_us + CLOCKS_US:
            raise PharosError("the new firmware reset itself: the old one runs again")
        heard = pacer.now_us()


# --- DroneCAN -------------------------------------------------------------------------------------
class Transfer(Protocol):
    """A request or a broadcast as can_node hands it out."""

    header: Any
    message: Any


@dataclass
class _Node:
    """A node that is updated."""

    progress: UpdateProgress
    heard_us: int
    asked_us: int = -1_000_000_000
    read_us: int = -1_000_000_000
    best: int = 0  # bytes read, at the most
    tries: int = 0  # beginnings since `best` last grew
    status: Any = None
    status_us: int = -1
    booted_us: int = 0
    done_us: int = 0  # the end of the file was read
    trial_us: int = 0  # the new firmware started
    asks: int = 0  # without an answer
    version: str = ""
    version_before: str = ""
    reasons: list[str] = field(default_factory=list)


class NodeUpdater:
    """Serves the image to DroneCAN nodes and follows each. Whoever owns the time calls step()."""

    # How long a node is left alone after an answer or a read before it is asked again [µs].
    ASK_US = 1_000_000
    STALL_US = 4_000_000
    # Beginnings without any progress after which it is given up.
    TRIES = 3
    ASKS = 5
    PATH_MAX = 256

    def __init__(
        self,
        node: Any,
        content: bytes,
        numbers: Sequence[int],
        on_progress: Callable[[UpdateProgress], None] = lambda _: None,
        *,
        patience_us: int = PATIENCE_US,
        absent_us: int = 3_000_000,
    ) -> None:
        """node: a DronecanNode. absent_us: how long a node may take to say anything at all."""
        from dronecan import uavcan

        self._uavcan = uavcan
        self._node = node
        self._content = content
        self._path = f"{crc32(content):08x}.bin"
        self._on_progress = on_progress
        self._patience_us = patience_us
        self._absent_us = absent_us
        now = node.clock()
        self._begun_us = now
        self.nodes = {number: _Node(UpdateProgress(f"node {number}"), now) for number in numbers}
        node.serve(uavcan.protocol.file.Read, self._read)
        node.serve(uavcan.protocol.file.GetInfo, self._get_info)
        node.subscribe(uavcan.protocol.NodeStatus, self._on_status)
        node.subscribe(uavcan.protocol.debug.LogMessage, self._on_log)

    @property
    def is_done(self) -> bool:
        return all(
            entry.progress.phase in (UpdatePhase.DONE, UpdatePhase.FAILED)
            for entry in self.nodes.values()
        )

    @property
    def progress(self) -> list[UpdateProgress]:
        return [entry.progress for entry in self.nodes.values()]

    # --- what the nodes say -------------------------------------------------------------------
    def _on_status(self, transfer: Transfer) -> None:
        entry = self.nodes.get(transfer.header.source)
        if entry is None:
            return
        now = self._node.clock()
        # whole seconds: at most one too late
        entry.booted_us = now - transfer.message.uptime_sec * 1_000_000
        entry.status, entry.status_us, entry.heard_us = transfer.message, now, now
        if not entry.version:
            self._ask_version(transfer.header.source, entry)

    def _ask_version(self, number: int, entry: _Node) -> None:
        def on_info(info: Any) -> None:
            software = info.software_version
            entry.version = f"{software.major}.{software.minor}"
            if software.optional_field_flags & software.OPTIONAL_FIELD_FLAG_VCS_COMMIT:
                entry.version += f" ({software.vcs_commit:08x})"

        self._node.request(self._uavcan.protocol.GetNodeInfo.Request(), number, on_info)

    def _on_log(self, transfer: Transfer) -> None:
        entry = self.nodes.get(transfer.header.source)
        if entry is not None and transfer.message.level.value >= transfer.message.level.WARNING:
            entry.reasons.append(str(transfer.message.text))

    def _get_info(self, request: Transfer) -> Any:
        answer = self._uavcan.protocol.file.GetInfo.Response()
        if str(request.message.path.path) == self._path:
            answer.size = len(self._content)
            answer.entry_type.flags = answer.entry_type.FLAG_FILE | answer.entry_type.FLAG_READABLE
        else:
            answer.error.value = answer.error.NOT_FOUND
        return answer

    def _read(self, request: Transfer) -> Any:
        answer = self._uavcan.protocol.file.Read.Response()
        if str(request.message.path.path) != self._path:
            answer.error.value = answer.error.NOT_FOUND
            return answer
        at = int(request.message.offset)
        part = self._content[at : at + self.PATH_MAX]
        answer.data = part
        entry = self.nodes.get(request.header.source)
        if entry is not None and entry.progress.phase is not UpdatePhase.FAILED:
            self._note_read(entry, at, len(part))
        return answer

    def _note_read(self, entry: _Node, at: int, size: int) -> None:
        now = self._node.clock()
        entry.read_us = entry.heard_us = now
        if at + size > entry.best:
            entry.best, entry.tries = at + size, 0
        if size < self.PATH_MAX:
            if entry.progress.phase is not UpdatePhase.CHECKING:
                entry.done_us, entry.reasons = now, []
            self._tell(entry, UpdatePhase.CHECKING, 100)
        else:
            self._tell(entry, UpdatePhase.WRITING, (at + size) * 100 // len(self._content))

    # --- what is due --------------------------------------------------------------------------
    def _tell(self, entry: _Node, phase: UpdatePhase, percent: int, text: str = "") -> None:
        progress = entry.progress
        if (progress.phase, progress.percent, progress.text) != (phase, percent, text):
            progress.phase, progress.percent, progress.text = phase, percent, text
            self._on_progress(progress)

    def _fail(self, entry: _Node, text: str, is_silent: bool = False) -> None:
        entry.progress.is_silent = is_silent
        self._tell(entry, UpdatePhase.FAILED, entry.progress.percent, text)

    def step(self) -> None:
        for number, entry in self.nodes.items():
            self._step_node(number, entry, self._node.clock())

    def _step_node(self, number: int, entry: _Node, now: int) -> None:
        phase = entry.progress.phase
        if phase in (UpdatePhase.DONE, UpdatePhase.FAILED):
            return
        patience = self._patience_us if entry.status else self._absent_us
        if now - entry.heard_us > patience:
            what = "was lost" if entry.status else "is silent"
            self._fail(entry, f"{what}: nothing heard for {patience / 1e6:g} s", is_silent=True)
        elif phase is UpdatePhase.ASKING:
            if entry.status is not None and now - entry.asked_us >= self.ASK_US:
                self._begin(number, entry, now)
        elif phase is UpdatePhase.WRITING:
            if self._is_idle(entry, now):
                self._ask_again(entry)
        elif phase is UpdatePhase.CHECKING:
            self._step_checking(entry, now)
        elif phase is UpdatePhase.TRIAL:
            self._step_trial(entry, now)

    def _is_idle(self, entry: _Node, now: int) -> bool:
        """It goes about its business and reads nothing: it restarted, or has given up."""
        return (
            now - max(entry.read_us, entry.asked_us) > self.STALL_US
            and entry.status_us > max(entry.read_us, entry.asked_us)
            and entry.status.mode == entry.status.MODE_OPERATIONAL
        )

    def _ask_again(self, entry: _Node) -> None:
        entry.tries += 1
        if entry.tries >= self.TRIES:
            why = entry.reasons[-1] if entry.reasons else "it stops reading"
            self._fail(entry, f"the node gives up: {why}")
        else:
            self._tell(entry, UpdatePhase.ASKING, entry.progress.percent, "again")

    def _begin(self, number: int, entry: _Node, now: int) -> None:
        entry.asked_us = now
        entry.asks += 1
        if entry.asks > self.ASKS:
            self._fail(entry, "it does not answer BeginFirmwareUpdate")
            return
        request = self._uavcan.protocol.file.BeginFirmwareUpdate.Request(
            source_node_id=self._node.node_id
        )
        request.image_file_remote_path.path.encode(self._path)

        def on_answer(answer: Any) -> None:
            entry.heard_us = self._node.clock()
            entry.asks = 0
            if entry.progress.phase is not UpdatePhase.ASKING:
                return
            if answer.error in (answer.ERROR_OK, answer.ERROR_IN_PROGRESS):
                entry.asked_us = entry.heard_us
                self._tell(entry, UpdatePhase.WRITING, 0)
            else:
                why = str(answer.optional_error_message) or f"error {answer.error}"
                self._fail(entry, f"refused: {why}")

        self._node.request(request, number, on_answer)

    def _step_checking(self, entry: _Node, now: int) -> None:
        if entry.status_us <= entry.done_us or entry.status.mode != entry.status.MODE_OPERATIONAL:
            return
        if entry.booted_us >= entry.done_us:
            entry.trial_us = entry.booted_us
            entry.version_before, entry.version = entry.version, ""
            self._tell(entry, UpdatePhase.TRIAL, 100)
        elif now - entry.done_us > self.STALL_US:
            why = entry.reasons[-1] if entry.reasons else "it did not restart"
            self._fail(entry, f"the node refuses the image: {why}")

    def _step_trial(self, entry: _Node, now: int) -> None:
        if entry.booted_us > entry.trial_us + CLOCKS_US:
            self._fail(entry, "the new firmware reset itself: the old one runs again")
        elif now - entry.trial_us > TRIAL_US and entry.status_us > entry.trial_us + TRIAL_US:
            before, version = entry.version_before or "?", entry.version or "?"
            self._tell(entry, UpdatePhase.DONE, 100, f"version {before} before, {version} now")


def update_nodes(updater: NodeUpdater, pacer: Any) -> list[UpdateProgress]:
    """Until each node is done or has failed; what became of each."""
    while not updater.is_done:
        updater.step()
        pacer.pump(STEP_US)
    return updater.progress
