# SPDX-License-Identifier: Apache-2.0
"""The screen of a terminal, as far as the shell's escape sequences go."""

from __future__ import annotations

import re

_SEQUENCE = re.compile(r"\x1b\[([0-9;]*)([A-Za-z])")


class Terminal:
    """What the escape sequences that the shell sends do to a screen of some columns. Its rows grow
    downwards without end. Like a VT100, it wraps when the next character comes, not when a row is
    full, and it answers when asked where its cursor is."""

    def __init__(self, columns: int = 80) -> None:
        self.columns = columns
        self.rows: list[list[str]] = [[]]
        self.row = 0
        self.column = 0
        self.bells = 0
        self.answers: list[bytes] = []
        self.colours: set[str] = set()
        self._saved = (0, 0)
        self._rest = ""

    @property
    def text(self) -> list[str]:
        """The rows, without blanks at their ends."""
        return ["".join(row).rstrip() for row in self.rows]

    @property
    def line(self) -> str:
        """The last row that has anything on it."""
        return next((row for row in reversed(self.text) if row), "")

    def feed(self, data: bytes) -> None:
        text = self._rest + data.decode("ascii", errors="replace")
        self._rest = ""
        at = 0
        while at < len(text):
            if text[at] != "\x1b":
                self._character(text[at])
                at += 1
                continue
            match = _SEQUENCE.match(text, at)
            if match is None:
                self._rest = text[at:]
                break
            self._control(match[1], match[2])
            at = match.end()

    def _character(self, character: str) -> None:
        if character == "\r":
            self.column = 0
        elif character == "\n":
            self._down()
        elif character == "\b":
            self.column = max(self.column - 1, 0)
        elif character == "\a":
            self.bells += 1
        else:
            assert character.isprintable(), f"the shell sent {character!r}"
            if self.column == self.columns:
                self.column = 0
                self._down()
            row = self.rows[self.row]
            row.extend(" " * (self.column + 1 - len(row)))
            row[self.column] = character
            self.column += 1

    def _down(self) -> None:
        self.row += 1
        if self.row == len(self.rows):
            self.rows.append([])

    def _control(self, arguments: str, final: str) -> None:
        count = int(arguments.split(";")[0] or 1) if arguments else 1
        if final == "A":
            self.row = max(self.row - count, 0)
        elif final == "C":
            self.column = min(self.column + count, self.columns - 1)
        elif final == "H":
            self.row = self.column = 0
        elif final == "J" and arguments in ("", "0"):
            del self.rows[self.row][self.column :]
            del self.rows[self.row + 1 :]
        elif final == "J" and arguments == "2":
            self.rows = [[] for _ in self.rows]
        elif final == "m":
            self.colours.add(arguments)
        elif final == "n" and arguments == "6":
            answer = f"\x1b[{self.row + 1};{min(self.column, self.columns - 1) + 1}R"
            self.answers.append(answer.encode())
        elif final == "s":
            self._saved = (self.row, self.column)
        elif final == "u":
            self.row, self.column = self._saved
        else:
            raise AssertionError(f"the shell sent ESC [ {arguments} {final}")
