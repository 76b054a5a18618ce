# SPDX-License-Identifier: Apache-2.0
"""The shell on a real pseudo-terminal: editing, history, completion."""

from __future__ import annotations

import fcntl
import json
import os
import select
import socket
import subprocess
import termios
import time
import tty
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from vt100 import Terminal

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("PHAROS_BUILD", ROOT / "build" / "native")).resolve()
APP = BUILD / "tests" / "subsys" / "shell_app"
PROMPT = "pharos:~$ "
DEADLINE_S = 20.0

UP, DOWN, RIGHT, LEFT = "\x1b[A", "\x1b[B", "\x1b[C", "\x1b[D"
HOME, END, DELETE = "\x1b[H", "\x1b[F", "\x1b[3~"
WORD_LEFT, WORD_RIGHT = "\x1b[1;5D", "\x1b[1;5C"
BACKSPACE = "\x7f"
CTRL = {letter: chr(ord(letter) & 0x1F) for letter in "ABCDEFKLNPUW"}


class Session:
    """The app with its console on a pty, and a terminal at the other end."""

    def __init__(self, folder: Path, columns: int = 80, *options: str) -> None:
        self.screen = Terminal(columns)
        self.raw = b""
        self.answered = 0
        link = folder / "console"
        self.process = subprocess.Popen(
            [APP, "--console", f"pty:{link}", *options],
            stderr=subprocess.PIPE,
            stdin=subprocess.DEVNULL,
        )
        limit = time.monotonic() + DEADLINE_S
        while not link.exists():
            assert self.process.poll() is None, self.process.communicate()[1]
            assert time.monotonic() < limit, "no pty"
            select.select([], [], [], 0.01)
        self._fd = os.open(link, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self._fd)
        # What was sent before the terminal was there is lost, as on any UART.
        self.keys("\r", lambda s: s.screen.line == PROMPT.rstrip())
        # Clearing the screen makes the shell ask for the width.
        self.keys(CTRL["L"], lambda s: s.answered > 0)
        self._settle()

    def close(self) -> None:
        self.process.kill()
        self.process.communicate()
        os.close(self._fd)

    def _settle(self, bells: int = 0) -> None:
        """Waits until the shell has taken all keys, which ring so many bells: it answers a marker
        that leaves no trace."""
        before = self.screen.bells + bells
        # Down is refused with a bell where there is nothing newer.
        os.write(self._fd, b"\x1b[B")
        self._until(lambda s: s.screen.bells > before)

    def _until(self, done: Callable[[Session], bool]) -> None:
        limit = time.monotonic() + DEADLINE_S
        while not done(self):
            left = limit - time.monotonic()
            ready = select.select([self._fd], [], [], max(left, 0))[0]
            assert ready, f"the screen stayed\n{self.screen.text}\nraw {self.raw[-300:]!r}"
            data = os.read(self._fd, 4096)
            assert data, f"the light has gone: {self.process.communicate()[1]!r}"
            self.raw += data
            self.screen.feed(data)
            for answer in self.screen.answers:
                os.write(self._fd, answer)
                self.answered += 1
            self.screen.answers.clear()

    def keys(self, keys: str, done: Callable[[Session], bool]) -> None:
        os.write(self._fd, keys.encode())
        self._until(done)

    def type(self, keys: str, bells: int = 0) -> str:
        """Types keys that ring so many bells, and gives the line being edited, without its
        prompt."""
        os.write(self._fd, keys.encode())
        self._settle(bells)
        return self.edited

    @property
    def edited(self) -> str:
        return "".join(self.screen.text[self._prompt_row() :])[len(PROMPT) :]

    def _prompt_row(self) -> int:
        rows = self.screen.text
        return max(i for i, row in enumerate(rows) if row.startswith(PROMPT.rstrip()))

    @property
    def cursor(self) -> int:
        """Characters of the line before the cursor."""
        row = self._prompt_row()
        return (self.screen.row - row) * self.screen.columns + self.screen.column - len(PROMPT)

    def run(self, line: str) -> list[str]:
        """Types a line, and gives what it printed."""
        self._settle()
        start = self._prompt_row()
        os.write(self._fd, f"{line}\r".encode())
        self._until(lambda s: s.screen.line == PROMPT.rstrip() and s._prompt_row() > start)
        return self.screen.text[start + 1 : self._prompt_row()]


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Callable[..., Session]]:
    sessions = []

    def begin(columns: int = 80, *options: str) -> Session:
        sessions.append(Session(tmp_path, columns, *options))
        return sessions[-1]

    yield begin
    for session in sessions:
        session.close()


@pytest.fixture
def shell(start: Callable[..., Session]) -> Session:
    return start()


def test_a_line_is_echoed_and_run(shell: Session) -> None:
    assert shell.run("say hello world") == ["<hello>", "<world>"]


def test_an_empty_line_gives_a_new_prompt(shell: Session) -> None:
    assert shell.run("") == []


def test_unknown_command(shell: Session) -> None:
    assert shell.run("sya hello") == ["sya: command not found"]


def test_backspace_and_delete(shell: Session) -> None:
    assert shell.type("sayx" + BACKSPACE) == "say"
    assert shell.type("\x08") == "sa"
    assert shell.type(LEFT + DELETE) == "s"
    assert shell.cursor == 1
    assert shell.type(BACKSPACE + BACKSPACE) == ""


def test_insert_in_the_middle(shell: Session) -> None:
    assert shell.type("say ac" + LEFT + "b") == "say abc"
    assert shell.cursor == 6
    assert shell.run("") == ["<abc>"]


def test_home_and_end(shell: Session) -> None:
    for home, end in (
        (HOME, END),
        ("\x1b[1~", "\x1b[4~"),
        ("\x1bOH", "\x1bOF"),
        (CTRL["A"], CTRL["E"]),
    ):
        shell.type("middle" + home)
        assert shell.cursor == 0
        shell.type(end)
        assert shell.cursor == len("middle")
        assert shell.type(CTRL["U"]) == ""


def test_cursor_stops_at_both_ends(shell: Session) -> None:
    shell.type("ab" + RIGHT * 3)
    assert shell.cursor == 2
    shell.type(LEFT * 5)
    assert shell.cursor == 0


def test_control_b_and_f_move_too(shell: Session) -> None:
    shell.type("abc" + CTRL["B"] * 2)
    assert shell.cursor == 1
    shell.type(CTRL["F"])
    assert shell.cursor == 2


def test_control_k_and_u_cut_to_the_ends(shell: Session) -> None:
    assert shell.type("abcdef" + LEFT * 2 + CTRL["K"]) == "abcd"
    assert shell.type(LEFT + CTRL["U"]) == "d"
    assert shell.cursor == 0


def test_control_w_cuts_a_word(shell: Session) -> None:
    assert shell.type("say one  two" + CTRL["W"]) == "say one"
    assert shell.cursor == len("say one  ")
    assert shell.type(CTRL["W"]) == "say"


def test_words_are_stepped_over(shell: Session) -> None:
    shell.type("say one two" + WORD_LEFT)
    assert shell.cursor == len("say one ")
    shell.type("\x1bb")
    assert shell.cursor == len("say ")
    shell.type(WORD_RIGHT)
    assert shell.cursor == len("say one")
    shell.type("\x1bf")
    assert shell.cursor == len("say one two")


def test_control_d_deletes_under_the_cursor(shell: Session) -> None:
    assert shell.type("abc" + HOME + CTRL["D"]) == "bc"
    assert shell.type(END + CTRL["D"]) == "bc"


def test_control_c_abandons_the_line(shell: Session) -> None:
    shell.type("say no")
    shell.keys(CTRL["C"], lambda s: s.screen.line == PROMPT.rstrip())
    assert f"{PROMPT}say no^C" in shell.screen.text
    assert shell.run("") == []


def test_control_d_leaves_no_terminal_but_the_programs_own(shell: Session) -> None:
    assert shell.type(CTRL["D"]) == ""
    shell.keys(CTRL["C"], lambda s: f"{PROMPT}^C" in s.screen.text)
    assert shell.run("say yes") == ["<yes>"]
    assert "Ctrl-D" not in "".join(shell.screen.text + shell.run("help"))


def test_control_l_clears_the_screen_and_keeps_the_line(shell: Session) -> None:
    shell.run("say something")
    shell.type("say ab" + LEFT)
    assert shell.type(CTRL["L"]) == "say ab"
    assert shell.screen.text[0] == PROMPT + "say ab"
    assert shell.cursor == len("say a")


def test_history_up_and_down(shell: Session) -> None:
    shell.run("say one")
    shell.run("say two")
    assert shell.type("half") == "half"
    os.write(shell._fd, UP.encode())
    shell._until(lambda s: s.edited == "say two")
    os.write(shell._fd, UP.encode())
    shell._until(lambda s: s.edited == "say one")
    os.write(shell._fd, CTRL["P"].encode())
    shell._until(lambda s: s.screen.bells > 0)
    assert shell.edited == "say one"
    os.write(shell._fd, DOWN.encode())
    shell._until(lambda s: s.edited == "say two")
    os.write(shell._fd, CTRL["N"].encode())
    shell._until(lambda s: s.edited == "half")
    assert shell.cursor == len("half")


def test_a_line_from_history_is_edited_and_run(shell: Session) -> None:
    shell.run("say one")
    shell.keys(UP, lambda s: s.edited == "say one")
    os.write(shell._fd, (BACKSPACE * 3 + "two\r").encode())
    shell._until(lambda s: "<two>" in s.screen.text)


def test_history_holds_a_line_once_in_a_row(shell: Session) -> None:
    shell.run("say one")
    shell.run("say two")
    shell.run("say two")
    assert shell.run("history") == ["[  0] history", "[  1] say two", "[  2] say one"]


def test_history_forgets_the_oldest(shell: Session) -> None:
    for number in range(60):
        shell.run(f"say {number:02} 23456789")
    lines = [row for row in shell.run("history") if row.startswith("[")]
    # 512 bytes of history hold 31 lines of 16 bytes with their terminators; "history" takes 8.
    assert len(lines) == 1 + (512 - 8) // 16
    assert lines[1].endswith("say 59 23456789")


def test_tab_completes_the_only_match_and_adds_a_blank(shell: Session) -> None:
    shell.type("tr\t")
    assert shell.edited.rstrip() == "tree"
    assert shell.cursor == len("tree ")
    shell.type("l\t")
    assert shell.edited.rstrip() == "tree leaf"
    assert shell.run("x") == ["<x>"]


def test_tab_lists_several_matches_in_columns(shell: Session) -> None:
    assert shell.type("tree b\t") == "tree br"
    row = shell.screen.text[shell._prompt_row() - 1]
    assert row == "branch  brook"
    assert shell.screen.text[shell._prompt_row() - 2] == PROMPT + "tree b"
    assert shell.cursor == len("tree br")


def test_tab_on_nothing_lists_all_in_order(shell: Session) -> None:
    shell.type("tree \t")
    assert shell.screen.text[shell._prompt_row() - 1] == "branch  brook   leaf"


def test_tab_without_a_match_rings(shell: Session) -> None:
    before = shell.screen.bells
    assert shell.type("say xy\t", bells=1) == "say xy"
    assert shell.type("\x15nothing\t", bells=1) == "nothing"
    shell._settle()
    # two of them, two of type(), one of the last line
    assert shell.screen.bells - before == 5


def test_tab_in_the_middle_keeps_the_rest(shell: Session) -> None:
    assert shell.type("tr x" + LEFT * 2 + "\t") == "tree x"


def test_a_line_longer_than_the_terminal_is_wide(start: Callable[..., Session]) -> None:
    shell = start(columns=30)
    words = "say abcdefghij klmnopqrst uvwxyz0123456789"
    assert shell.type(words) == words
    assert shell.screen.row - shell._prompt_row() == 1
    shell.type(HOME)
    assert shell.cursor == 0
    assert shell.type(RIGHT * 4 + "X") == "say X" + words[4:]
    assert shell.type(BACKSPACE) == words
    shell.type(END)
    assert shell.cursor == len(words)
    assert shell.type(CTRL["U"]) == ""


def test_a_line_exactly_as_long_as_a_row(start: Callable[..., Session]) -> None:
    shell = start(columns=30)
    line = "say 3456789012345678"
    assert len(PROMPT + line) == 30
    assert shell.type(line) == line
    assert shell.cursor == len(line)
    assert shell.type("x" + BACKSPACE) == line
    assert shell.run("") == ["<3456789012345678>"]


def test_the_width_is_asked_for(start: Callable[..., Session]) -> None:
    # 50 columns: a list that fits 80 columns in one row needs more here
    shell = start(columns=50)
    shell.type("\t")
    assert max(len(row) for row in shell.screen.text) <= 50


def test_a_log_line_does_not_tear_the_line_being_typed(shell: Session) -> None:
    shell.run("later 50")
    shell.type("say abc" + LEFT)
    shell._until(lambda s: any("<wrn> shell_app: from a timer" in row for row in s.screen.text))
    shell._settle()
    assert shell.edited == "say abc"
    assert shell.cursor == len("say ab")
    rows = shell.screen.text
    log = next(i for i, row in enumerate(rows) if "from a timer" in row)
    assert rows[log].startswith("[00:00:")
    assert rows[log + 1] == PROMPT + "say abc"
    assert rows.count(PROMPT + "say abc") == 1
    os.write(shell._fd, b"\r")
    shell._until(lambda s: "<abc>" in s.screen.text)


def test_errors_are_red_on_a_terminal(shell: Session) -> None:
    shell.run("fail")
    assert b"\x1b[1;31min red\x1b[0m\r\n" in shell.raw


def test_colours_can_be_turned_off(shell: Session) -> None:
    shell.run("shell colors off")
    shell.screen.colours.clear()
    shell.run("fail")
    assert not shell.screen.colours


def test_strange_bytes_do_not_harm(shell: Session) -> None:
    noise = bytes(b for b in range(128, 256)) + b"\x1b[999;999;999Z\x1b[?25h\x1bOQ\x00\x1c\x1d"
    os.write(shell._fd, noise)
    assert shell.type("") == ""
    assert shell.run("say on") == ["<on>"]


def test_a_line_that_does_not_fit_is_not_run(shell: Session) -> None:
    os.write(shell._fd, b"say " + b"x" * 300)
    shell._until(lambda s: s.screen.bells > 0)
    os.write(shell._fd, b"\r")
    shell._until(lambda s: any("not executed" in row for row in s.screen.text))
    assert shell.run("say on") == ["<on>"]


def test_kernel_threads(shell: Session) -> None:
    rows = shell.run("kernel threads")
    assert rows[0].startswith("name")
    names = [row.split()[0] for row in rows[1:]]
    assert "shell_uart" in names
    assert "logging" in names


def reboot(shell: Session) -> None:
    shell.type("kernel reboot cold")
    row = shell.screen.row
    os.write(shell._fd, b"\r")
    shell._until(lambda s: s.screen.row > row and s.screen.line == PROMPT.rstrip())


def test_reboot_brings_a_new_prompt(shell: Session) -> None:
    shell.run("say before")
    reboot(shell)
    assert shell.process.poll() is None
    # Nothing of the device's memory survives, history least of all.
    assert shell.run("history") == ["[  0] history"]


def test_settings_in_memory_survive_a_reset_only(shell: Session) -> None:
    assert shell.run("save light/level 42") == ["saved: 0"]
    reboot(shell)
    assert shell.run("settings list") == ["light/level  2 bytes"]
    assert shell.run("settings status")[0] == "in memory: lost when the process ends"


def test_torn_write_by_control_keeps_the_old_value(
    start: Callable[..., Session], tmp_path: Path
) -> None:
    control = tmp_path / "control"
    shell = start(80, "--control", str(control), "--settings", str(tmp_path / "settings"))
    assert shell.run("save light/level old") == ["saved: 0"]
    request = {"op": "fault", "device": "storage", "kind": "torn", "byte": 20}
    with socket.socket(socket.AF_UNIX) as client:
        client.connect(str(control))
        client.sendall(json.dumps(request).encode() + b"\n")
        assert json.loads(client.makefile().readline())["ok"] is True
    # -5: EIO
    assert shell.run("save light/level new") == ["saved: -5"]
    reboot(shell)
    # The log tells of it when it comes to it, above the line being typed.
    told = "<wrn> settings: 1 broken records left out"
    shell._until(
        lambda s: any(told in row for row in s.screen.text) and s.screen.line == PROMPT.rstrip()
    )
    assert shell.run("settings read light/level")[0].endswith("|old             |")
    assert shell.run("save light/level new") == ["saved: 0"]
    assert shell.run("settings read light/level")[0].endswith("|new             |")


class OwnTerminal:
    """The application on the terminal that it was started in, whose Ctrl-C is its process's."""

    def __init__(self) -> None:
        self.master, slave = os.openpty()
        self.screen = Terminal()
        self._limit = time.monotonic() + DEADLINE_S
        self.process = subprocess.Popen(
            [APP, "--console", "stdio"],
            stdin=slave, stdout=slave, stderr=slave, start_new_session=True,
            preexec_fn=lambda: fcntl.ioctl(slave, termios.TIOCSCTTY, 0),
        )  # fmt: skip
        os.close(slave)
        self.until(PROMPT.rstrip())

    def until(self, line: str) -> None:
        while self.screen.line != line:
            self._feed()

    def end(self) -> int:
        while self.process.poll() is None or select.select([self.master], [], [], 0)[0]:
            try:
                self._feed()
            except OSError:
                break  # EIO: the last one at the other end has closed it
        os.close(self.master)
        return self.process.wait()

    def type(self, keys: str) -> None:
        os.write(self.master, keys.encode())

    def _feed(self) -> None:
        assert time.monotonic() < self._limit, self.screen.text
        if select.select([self.master], [], [], 0.01)[0]:
            self.screen.feed(os.read(self.master, 4096))


def test_stdio_on_a_terminal_is_a_terminal() -> None:
    terminal = OwnTerminal()
    terminal.type("say a\rexit\r")
    assert terminal.end() == 0
    assert f"{PROMPT}say a" in terminal.screen.text
    assert "<a>" in terminal.screen.text


def test_control_c_in_ones_own_terminal_gives_a_new_line_and_says_how_to_leave() -> None:
    terminal = OwnTerminal()
    terminal.type("say no")
    terminal.until(f"{PROMPT}say no")
    terminal.type(CTRL["C"])
    terminal.until(PROMPT.rstrip())
    terminal.type(CTRL["C"])
    terminal.type("say yes\r")
    terminal.until(PROMPT.rstrip())
    terminal.type("ab" + CTRL["D"] + CTRL["U"] + CTRL["D"])
    assert terminal.end() == 0
    assert f"{PROMPT}say no^C" in terminal.screen.text
    assert f"{PROMPT}^C (Ctrl-D leaves)" in terminal.screen.text
    assert "<yes>" in terminal.screen.text
    assert "<no>" not in terminal.screen.text
