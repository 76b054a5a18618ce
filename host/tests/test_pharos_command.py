# SPDX-License-Identifier: Apache-2.0
"""The `pharos` command as users run it, on a light in real time: exit codes, pipes, a terminal."""

from __future__ import annotations

import fcntl
import json
import os
import pty
import re
import select
import signal
import socket
import struct
import subprocess
import termios
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from prompt_toolkit.completion import CompleteEvent
from prompt_toolkit.document import Document

from pharos.cli import main, man
from pharos.cli.prompt import CommandCompleter
from pharos.dialect import MODULE, generated_dialect, load_dialect
from real_light import PATIENCE_S, PHAROS, RealLight, environment, run

START = Callable[..., RealLight]


@pytest.fixture
def light(real_light: START) -> RealLight:
    return real_light("--uart0", "udpin:127.0.0.1:0")


def _code(*args: str) -> int:
    """main() in this process: as `pharos ARGS…`, without the time that Python takes to start."""
    try:
        return main(args)
    except SystemExit as end:  # argparse
        return int(end.code or 0)


# --- exit codes and errors ------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("args", "code", "hint"),
    [
        (["shell", "nonsense", "-c", "on"], 2, "expected udp:"),
        (["shell", "dronecan:tin-cans/1?node=5", "-c", "on"], 2, "'tin-cans'"),
        (["shell", "udp:127.0.0.1:9", "-c", "dance"], 2, "'dance' is no command"),
        (["shell", "udp:127.0.0.1:9", "-c", "on 1"], 2, "usage: on"),
        (["shell", "pty:/nonexistent/tty", "-c", "on"], 3, "No such file"),
        (["shell", "tcp:127.0.0.1:1", "-c", "on"], 3, "refused"),
        (
            ["shell", "udp:127.0.0.1:9", "--timeout", "0.1", "-c", "on"],
            3,
            "no illuminator answered",
        ),
        (["shell", "udpin:127.0.0.1:0", "--timeout", "0.1", "-c", "on"], 3, "no illuminator"),
        (["shell", "udp:" + "a" * 300 + ":1", "-c", "on"], 2, "no host name"),
        (["shell", "pty:/dev/\0", "-c", "on"], 2, "no path"),
        (["shell", "\x1b[2J\n", "-c", "on"], 2, "'\\x1b[2J\\n' is no link"),
        (["can", "nodes", "pharos-udp/" + "a" * 300 + ":1"], 2, "no channel"),
        (["imc", "monitor", "udp:" + "a" * 300 + ":1"], 2, "no host name"),
        (["can", "nodes", "socketcan/nonexistent0"], 3, "nonexistent0"),
        (["can", "nodes", "tin-cans/1"], 2, "'tin-cans'"),
        (["can", "nodes", "pharos-udp/127.0.0.1"], 2, "'127.0.0.1'"),
        (["can", "light", "brightness"], 2, "PERCENT"),
        (["can", "light", "on", "40"], 2, "PERCENT"),
        (["can", "light", "brightness", "140"], 2, "0 … 100"),
        (["can", "light", "brightness", "40", "--via", "hardpoint"], 2, "on or off"),
        (["can", "light", "on", "--via", "tunnel"], 2, "--node"),
    ],
)
def test_each_kind_of_error_has_its_code_and_one_line(
    args: list[str], code: int, hint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert _code(*args) == code
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("pharos: ")
    assert hint in err
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("args", "hint"),
    [
        (["udpate", "x"], "'udpate' is no COMMAND; did you mean update?"),
        (["param", "foo", "udp:1"], "'foo' is no ACTION; one of list, get"),
        (["on"], "are required: URL\n"),
        (["brightness", "udp:127.0.0.1:9"], "usage: pharos brightness URL PERCENT"),
        (["files", "get", "udp:127.0.0.1:9"], "get PATH [FILE], with the URL after the first"),
        (["status", "127.0.0.1:14550"], "udp:127.0.0.1:14550? Expected udp:"),
        (["find", "nowhere"], "'nowhere' is no link"),
    ],
)
def test_wrong_words_are_told_what_would_be_right(
    args: list[str], hint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert _code(*args) == 2
    assert hint in capsys.readouterr().err


def test_commands_of_the_command_line(light: RealLight, capsys: pytest.CaptureFixture[str]) -> None:
    assert _code("shell", light.url(), "-c", "on; brightness 40; status") == 0
    out, err = capsys.readouterr()
    assert out.splitlines()[:2] == ["ok", "ok"]
    assert out.splitlines()[2].startswith("on, 40 %")
    assert err == ""
    assert light.control.request("outputs")["brightness_ppm"] == 400_000
    assert _code("shell", light.url(), "-c", "brightness 140; off") == 1
    assert light.control.request("outputs")["enable"] == 1
    assert _code("shell", light.url(), "--target", "1/243", "-c", "off; quit; on") == 0
    assert light.control.request("outputs")["enable"] == 0


def test_plain_commands_do_one_thing(
    light: RealLight, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    url, path = light.url(), str(tmp_path / "light.parm")
    assert _code("on", url) == 0
    assert _code("strobe", url, "2Hz", "10%") == 0
    assert _code("brightness", url, "40") == 0
    capsys.readouterr()
    assert _code("status", url) == 0
    assert capsys.readouterr().out.startswith("on, 40 %, strobe 0.5 s at 10 %")
    assert _code("off", url, "--json") == 0
    assert json.loads(capsys.readouterr().out) == {"command": "off", "ok": True}
    assert light.control.request("outputs")["enable"] == 0
    assert _code("param", "save", url, path) == 0
    assert _code("param", "set", url, "LGT_FALLBACK", "1") == 0
    capsys.readouterr()
    assert _code("param", "diff", url, path) == 1
    assert "LGT_FALLBACK" in capsys.readouterr().out
    assert _code("param", "load", url, path) == 0
    assert _code("param", "get", url, "NO_SUCH") == 1
    assert _code("brightness", url, "much") == 2
    assert _code("param", "dance", url) == 2
    assert _code("watch", url, "1") == 0


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("pharos che", {"check"}),
        ("pharos check --ju", {"--junit"}),
        ("pharos param sa", {"save"}),
        ("pharos on tcp", {"tcp:", "tcpin:", "tcp:127.0.0.1:5770"}),
    ],
)
def test_shells_complete_it(tmp_path: Path, line: str, words: set[str]) -> None:
    answer = tmp_path / "answer"
    asked = {
        "_ARGCOMPLETE": "1", "_ARGCOMPLETE_STDOUT_FILENAME": str(answer), "COMP_LINE": line,
        "COMP_POINT": str(len(line)), "_ARGCOMPLETE_COMP_WORDBREAKS": "", "COMP_TYPE": "9",
    }  # fmt: skip
    subprocess.run(PHAROS, env=environment() | asked, check=True, timeout=PATIENCE_S)
    assert {word.strip() for word in answer.read_text().split("\x0b")} == words


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_what_shells_need_is_printed(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert _code("completion", shell) == 0
    assert "pharos" in capsys.readouterr().out


def test_the_man_page_has_every_command() -> None:
    page = man.page()
    assert page.startswith(".TH PHAROS")
    for name in ("shell", "check", "find", "param", "strobe", "signing", "can", "imc"):
        assert f"pharos {name}" in page
    assert "exit codes:" in page
    assert "%%" not in page


def test_pharos_alone_shows_what_there_is(capsys: pytest.CaptureFixture[str]) -> None:
    assert _code() == 2
    out = capsys.readouterr().out
    assert "examples:" in out
    assert "pharos check" in out


def test_error_before_anything_is_json_too(capsys: pytest.CaptureFixture[str]) -> None:
    assert _code("shell", "nonsense", "--json", "-c", "on") == 2
    out, err = capsys.readouterr()
    assert json.loads(out)["ok"] is False
    assert err.startswith("pharos: 'nonsense'")


@pytest.mark.parametrize("wire", ["tcpin:127.0.0.1:0", "pty:{folder}/uart0"])
def test_every_transport_takes_commands(real_light: START, tmp_path: Path, wire: str) -> None:
    light = real_light("--uart0", wire.replace("{folder}", str(tmp_path)))
    assert _code("shell", light.url(), "-c", "on") == 0
    assert light.control.request("outputs")["enable"] == 1


def test_lights_that_call_are_waited_for(real_light: START) -> None:
    """udpin: and tcpin: on this side. The port is one that is free now."""
    for kind, family in (("udp", socket.SOCK_DGRAM), ("tcp", socket.SOCK_STREAM)):
        with socket.socket(socket.AF_INET, family) as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        wire = f"{'udpout' if kind == 'udp' else 'tcp'}:127.0.0.1:{port}"
        light = real_light("--uart0", wire)
        assert _code("shell", f"{kind}in:127.0.0.1:{port}", "--timeout", "10", "-c", "on") == 0
        assert light.control.request("outputs")["enable"] == 1
        light.close()


# --- CAN ------------------------------------------------------------------------------------------
def test_commands_over_can(can_light: tuple[RealLight, str]) -> None:
    light, bus = can_light
    assert _code("shell", f"dronecan:{bus}?node=68", "-c", "on; brightness 40; status") == 0
    outputs = light.control.request("outputs")
    assert (outputs["enable"], outputs["brightness_ppm"]) == (1, 400_000)


def test_monitor_shows_decoded_transfers(
    can_light: tuple[RealLight, str], capsys: pytest.CaptureFixture[str]
) -> None:
    only = ("--only", "NodeStatus", "--count", "2")
    assert _code("can", "monitor", can_light[1], *only, "--json") == 0
    one, two = (json.loads(line) for line in capsys.readouterr().out.splitlines())
    assert (one["type"], one["source"]) == ("uavcan.protocol.NodeStatus", 68)
    assert two["fields"]["uptime_sec"] - one["fields"]["uptime_sec"] == 1
    assert _code("can", "monitor", can_light[1], "--frames", *only) == 0
    assert "68 → all  protocol.NodeStatus" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("args", "brightness_ppm", "enable"),
    [
        (["brightness", "100"], 1_000_000, 1),
        (["on", "--via", "hardpoint"], None, 1),
        (["brightness", "60", "--via", "tunnel", "--node", "68"], 600_000, None),
        (["off"], None, 0),
    ],
)
def test_light_without_a_shell(
    can_light: tuple[RealLight, str],
    args: list[str],
    brightness_ppm: int | None,
    enable: int | None,
) -> None:
    light, bus = can_light
    assert _code("can", "light", *args, "--bus", bus) == 0
    outputs = light.control.request("outputs")
    if brightness_ppm is not None:
        assert outputs["brightness_ppm"] == brightness_ppm
    if enable is not None:
        assert outputs["enable"] == enable


def test_light_that_does_not_follow_is_a_failure(
    can_light: tuple[RealLight, str], capsys: pytest.CaptureFixture[str]
) -> None:
    """No actuator is the light's brightness unless CAN_ACT_BRT says so."""
    via = ("--via", "actuator", "--bus", can_light[1])
    assert _code("can", "light", "brightness", "75", *via) == 1
    assert capsys.readouterr().err == "pharos: node 68 stays off\n"


def test_light_that_is_not_on_the_bus_is_silent(
    can_light: tuple[RealLight, str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert _code("can", "light", "on", "--node", "99", "--bus", can_light[1]) == 3
    assert "no light says hardpoint.Status" in capsys.readouterr().err


# --- pipes ----------------------------------------------------------------------------------------
def test_commands_from_a_pipe(light: RealLight) -> None:
    done = run("shell", light.url(), stdin="# a comment\non\n\nbrightness 40; strobe 2Hz 10\n")
    assert (done.returncode, done.stdout, done.stderr) == (0, "ok\nok\nok\n", "")
    outputs = light.control.request("outputs")
    assert (outputs["enable"], outputs["strobe_period_us"]) == (1, 500_000)


def test_pipe_ends_at_the_first_failure_and_names_the_line(light: RealLight) -> None:
    done = run("shell", light.url(), stdin="on\ndance\noff\n")
    assert (done.returncode, done.stdout) == (2, "ok\n")
    assert done.stderr == "pharos: line 2: 'dance' is no command; `help` lists them\n"
    assert light.control.request("outputs")["enable"] == 1
    done = run("shell", light.url(), "--json", stdin="brightness 140\noff\n")
    assert done.returncode == 1
    (line,) = done.stdout.splitlines()
    assert json.loads(line)["result"] == 2
    assert light.control.request("outputs")["enable"] == 1


def test_reader_that_has_had_enough_is_no_error(light: RealLight) -> None:
    process = subprocess.Popen(
        [*PHAROS, "shell", light.url(), "-c", "status; watch 2; watch 3"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment(),
    )
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.readline()
    process.stdout.close()
    assert process.wait(PATIENCE_S) == 0
    assert process.stderr.read() == ""
    process.stderr.close()


# --- help -----------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    "command", [[], ["shell"], ["can"], ["can", "monitor"], ["can", "nodes"], ["can", "light"]]
)
def test_help_has_an_example_that_fits_a_terminal(
    command: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert _code(*command, "--help") == 0
    text = capsys.readouterr().out
    assert re.search(rf"examples?:\n  pharos {' '.join(command)}", text)
    assert max(len(line) for line in text.splitlines()) <= 100


def test_usage_error_of_the_command_line_exits_2(capsys: pytest.CaptureFixture[str]) -> None:
    for args in ([], ["dance"], ["shell"], ["shell", "udp:1:1", "--timeout", "soon"]):
        assert _code(*args) == 2
    assert "number of seconds" in capsys.readouterr().err


# --- a terminal -----------------------------------------------------------------------------------
def _take_terminal() -> None:
    """Ctrl-C is a signal, as it is for people, and one that a background job may not ignore."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    fcntl.ioctl(0, termios.TIOCSCTTY, 0)


class Terminal:
    """`pharos shell` on a pty of 100 columns: what it shows, without colours and movements."""

    def __init__(self, url: str, home: Path) -> None:
        self._master, slave = pty.openpty()
        fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 100, 0, 0))
        self.process = subprocess.Popen(
            [*PHAROS, "shell", url],
            stdin=slave,
            stdout=slave,
            stderr=slave,
            start_new_session=True,
            preexec_fn=_take_terminal,
            env={**environment(), "XDG_STATE_HOME": str(home)},
        )
        os.close(slave)
        self._shown = ""

    def keys(self, keys: str) -> None:
        os.write(self._master, keys.encode())

    def enter(self, line: str, pattern: str) -> None:
        """Types a line; waits for what it brings, then for the next prompt."""
        self.keys(line + "\r")
        self.until(pattern)
        self.until("pharos>")

    def _read(self, deadline: float, what: str) -> bytes:
        """b"": the program has closed its end."""
        left = max(0.0, deadline - time.monotonic())
        assert select.select([self._master], [], [], left)[0], what
        try:
            data = os.read(self._master, 65536)
        except OSError:
            return b""
        # Where is the cursor? Below which there is room for all that follows.
        for _ in range(data.count(b"\x1b[6n")):
            self.keys("\x1b[1;1R")
        return data

    def until(self, pattern: str) -> None:
        """Waits until that is shown, and forgets all up to its end."""
        deadline = time.monotonic() + PATIENCE_S
        while True:
            text = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]|\x1b[=>]", "", self._shown)
            found = re.search(pattern, text)
            if found:
                self._shown = text[found.end() :]
                return
            data = self._read(deadline, f"never came: {pattern!r}; shown: {text!r}")
            assert data, f"it ended before {pattern!r}; shown: {text!r}"
            self._shown += data.decode(errors="replace")

    def end(self) -> int:
        """Reads what is left; the exit code."""
        deadline = time.monotonic() + PATIENCE_S
        while self._read(deadline, "it did not end"):
            pass
        return self.process.wait(PATIENCE_S)

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        os.close(self._master)


@pytest.fixture
def terminal(light: RealLight, tmp_path: Path) -> Iterator[Callable[[], Terminal]]:
    opened: list[Terminal] = []

    def begin() -> Terminal:
        opened.append(Terminal(light.url(), tmp_path / "state"))
        opened[-1].until("pharos>")
        return opened[-1]

    yield begin
    for terminal in opened:
        terminal.close()


def test_prompt_runs_commands_and_shows_the_status_below(
    light: RealLight, terminal: Callable[[], Terminal]
) -> None:
    screen = terminal()
    screen.until("1/243 at udp 127.0.0.1:")
    screen.enter("on", "ok")
    screen.enter("brightness 40", "ok")
    # The toolbar follows the light by itself; of 100 % only what changes is drawn again.
    screen.until("40? %")
    screen.enter("brightness 140", "denied: ")
    screen.enter("dance", "'dance' is no command")
    assert light.control.request("outputs")["brightness_ppm"] == 400_000
    screen.keys("quit\r")
    assert screen.end() == 0


def test_tab_completes_commands(light: RealLight, terminal: Callable[[], Terminal]) -> None:
    screen = terminal()
    screen.keys("bri")
    screen.until("brightness")  # the menu
    screen.keys("\t")
    screen.until("ghtness")  # the rest of the word
    screen.enter(" 30", "ok")
    assert light.control.request("outputs")["brightness_ppm"] == 300_000
    screen.keys("\x04")
    assert screen.end() == 0


@pytest.mark.parametrize(
    ("typed", "completions"),
    [
        ("bri", ["brightness"]),
        ("strobe o", ["off"]),
        ("on; strobe o", ["off"]),
        ("strobe x", []),
        ("dance ", []),
    ],
)
def test_completions_of_a_line(typed: str, completions: list[str]) -> None:
    found = CommandCompleter().get_completions(Document(typed), CompleteEvent())
    assert [completion.text for completion in found] == completions


def test_history_is_kept_between_sessions(
    light: RealLight, terminal: Callable[[], Terminal]
) -> None:
    first = terminal()
    first.enter("brightness 35", "ok")
    first.keys("\x04")
    assert first.end() == 0
    assert _code("shell", light.url(), "-c", "brightness 90") == 0
    second = terminal()
    second.keys("\x1b[A")  # up
    second.until("35")
    second.enter("", "ok")
    assert light.control.request("outputs")["brightness_ppm"] == 350_000


def test_ctrl_c_ends_watch_but_not_the_shell(
    light: RealLight, terminal: Callable[[], Terminal]
) -> None:
    screen = terminal()
    screen.keys("watch\r")
    screen.until(r"watch[^°]*off, [^°]*°C")
    screen.keys("\x03")
    screen.until("pharos>")
    screen.enter("brightness 45", "ok")
    assert light.control.request("outputs")["brightness_ppm"] == 450_000
    screen.keys("\x04")
    assert screen.end() == 0


def test_light_that_dies_shows_as_silent(
    light: RealLight, terminal: Callable[[], Terminal]
) -> None:
    screen = terminal()
    light.close()
    screen.until("SILENT for 3 s")
    screen.enter("on", "stopped answering")
    screen.keys("\x04")
    assert screen.end() == 3


# --- the dialect ----------------------------------------------------------------------------------
def test_dialect_is_generated_once_into_the_cache(tmp_path: Path) -> None:
    path = generated_dialect(tmp_path)
    assert path.name == f"{MODULE}.py"
    before = path.stat().st_mtime_ns
    assert generated_dialect(tmp_path) == path
    assert path.stat().st_mtime_ns == before
    module = load_dialect(path)
    # Check values of common.xml: CRC_EXTRA of 440 and 396.
    assert module.MAVLink_illuminator_status_message.crc_extra == 66
    assert module.MAVLink_component_information_basic_message.crc_extra == 50


# --- IMC ------------------------------------------------------------------------------------------
def test_imc_messages_are_sent_and_their_answers_shown(
    real_light: START, capsys: pytest.CaptureFixture[str]
) -> None:
    light = real_light("--uart0", "tcpin:127.0.0.1:0", "--protocol", "imc")
    send = ("imc", "send", light.url(), "--seconds", "0.3")
    assert _code(*send, "--json", "SetLedBrightness", "name=lamp", "value=255") == 0
    answer = json.loads(capsys.readouterr().out)
    assert (answer["name"], answer["src"], answer["dst"]) == ("LedBrightness", 0x8442, 0x4001)
    assert answer["fields"] == {"name": "lamp", "value": 255}
    assert light.control.request("outputs")["brightness_ppm"] == 1_000_000
    assert _code(*send, "EntityList", "op=1") == 0
    assert "8442/0 > 4001/7  EntityList op=0 list='System=0;" in capsys.readouterr().out


def test_imc_monitor_shows_what_comes(
    real_light: START, capsys: pytest.CaptureFixture[str]
) -> None:
    light = real_light("--uart0", "tcpin:127.0.0.1:0", "--protocol", "imc")
    assert _code("imc", "monitor", light.url(), "--count", "1") == 0
    assert "Heartbeat" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "said"),
    [(["SetLedBrightnes"], "is no message"), (["SetLedBrightness", "value=x"], "is no number")],
)
def test_imc_usage_errors_are_one_line(
    capsys: pytest.CaptureFixture[str], words: list[str], said: str
) -> None:
    assert _code("imc", "send", "tcp:127.0.0.1:1", *words) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1
