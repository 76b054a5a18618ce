# SPDX-License-Identifier: Apache-2.0
"""A sensor of light: samples of time and level, from a command or from the kernel's IIO."""

from __future__ import annotations

import glob
import shlex
import subprocess
import threading
import time
from collections import deque
from pathlib import Path
from typing import IO, Protocol

from .errors import LinkError, UsageError

SAMPLES_MAX = 1_000_000
IIO = ("/sys/bus/iio/devices/*/in_intensity*_raw", "/sys/bus/iio/devices/*/in_illuminance*_raw")
# A command that has printed nothing for so long prints nothing [s].
PATIENCE_S = 5.0

Sample = tuple[float, float]


class Photodiode(Protocol):
    """Measures all the time, in its own clock [s] and its own unit."""

    def take(self) -> list[Sample]:
        """The samples since the last take, oldest first. LinkError: it has ended."""

    def close(self) -> None: ...


class _Sampled:
    """Samples come from a thread."""

    def __init__(self) -> None:
        self._samples: deque[Sample] = deque(maxlen=SAMPLES_MAX)
        self._ended = ""
        self._is_closed = False

    def take(self) -> list[Sample]:
        ended, taken = self._ended, list(self._samples)
        if ended and not taken:
            raise LinkError(ended)
        for _ in taken:
            self._samples.popleft()
        return taken

    def _start(self) -> None:
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        raise NotImplementedError


class CommandPhotodiode(_Sampled):
    """A program that prints a line "SECONDS LEVEL" for each sample."""

    def __init__(self, command: str) -> None:
        super().__init__()
        self.command = command
        try:
            words = shlex.split(command)
            self._process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
        except (OSError, ValueError, IndexError) as error:
            raise UsageError(f"--photodiode '{command}': {error}") from error
        self._start()

    def _run(self) -> None:
        output: IO[str] | None = self._process.stdout
        assert output is not None
        for line in output:
            try:
                seconds, level = map(float, line.split())
            except ValueError:
                self._ended = f"'{self.command}' printed '{line.strip()}', no SECONDS LEVEL"
                return
            self._samples.append((seconds, level))
        if not self._is_closed:
            self._ended = f"'{self.command}' has ended"

    def close(self) -> None:
        self._is_closed = True
        self._process.kill()
        self._process.wait()
        self._thread.join(PATIENCE_S)


class IioPhotodiode(_Sampled):
    """A light sensor of the kernel's, read as fast as it answers. path: its …_raw file."""

    def __init__(self, path: str = "") -> None:
        super().__init__()
        found = [path] if path else sorted(p for pattern in IIO for p in glob.glob(pattern))
        if not found:
            raise LinkError(f"no light sensor below {Path(IIO[0]).parents[1]}")
        self.path = found[0]
        try:
            self._file = open(self.path)  # noqa: SIM115
        except OSError as error:
            raise LinkError(f"{self.path}: {error.strerror}") from error
        self._start()

    def _run(self) -> None:
        while not self._is_closed:
            try:
                self._file.seek(0)
                self._samples.append((time.monotonic(), float(self._file.read())))
            except (OSError, ValueError) as error:
                self._ended = f"{self.path}: {error}"
                return

    def close(self) -> None:
        self._is_closed = True
        self._thread.join(PATIENCE_S)
        self._file.close()


def open_photodiode(text: str) -> Photodiode:
    """`iio`, `iio:FILE`, or a command."""
    kind, _, path = text.partition(":")
    return IioPhotodiode(path) if kind == "iio" else CommandPhotodiode(text)
