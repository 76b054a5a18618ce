# SPDX-License-Identifier: Apache-2.0
"""Every verb of the command over UDP, a terminal and CAN's tunnel, signed and not, for people and
for scripts: the command itself, from its words to its exit code, on a light in simulated time."""

from __future__ import annotations

import hashlib
import json
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from pharos import Light, Parameters, Simulator, cli, session
from pharos.cli import key as cli_key
from pharos.cli import main
from pharos.link import Link, RealPacer

WIRES = {"udp": "uart0", "pty": "uart1", "can": "can0"}
KEY = bytes(range(32))
STAMP = 36_000_000 * 1_000_000  # of 10 us since 2015: in 2026


def image() -> bytes:
    header = struct.pack("<IIHHIIBBHI", 0x96F3B83D, 0, 512, 0, 300, 0, 1, 2, 3, 4).ljust(512, b"\0")
    whole = header + bytes(range(250)) + bytes(50)
    return whole + struct.pack("<HHHH", 0x6907, 40, 0x10, 32) + hashlib.sha256(whole).digest()


class Shared(Link):
    """A link that outlives the command that opened it."""

    def __init__(self, link: Link) -> None:
        super().__init__()
        self.link = link
        self.is_datagram = link.is_datagram

    def fileno(self) -> int:
        return self.link.fileno()

    def can_send(self) -> bool:
        return self.link.can_send()

    def send(self, data: bytes) -> None:
        self.link.send(data)

    def take(self) -> list[bytes]:
        return self.link.take()

    def close(self) -> None:
        pass

    def _write(self, data: bytes) -> None:
        raise NotImplementedError

    def _read(self) -> bytes:
        raise NotImplementedError

    def __str__(self) -> str:
        return str(self.link)


class Bench:
    """A light whose wires the command opens by their names, and whose time it spends."""

    def __init__(self, sim: Simulator, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self.sim = sim
        self.folder = folder
        self.links: dict[str, Link] = {}
        for module in (session, cli_key):
            monkeypatch.setattr(module, "open_link", self.open)
            monkeypatch.setattr(module, "RealPacer", lambda _ports: sim)
            monkeypatch.setattr(module, "signing_time", self.signing_time)

    def signing_time(self) -> int:
        return STAMP + self.sim.now_us() // 10

    def open(self, url: str) -> Link:
        """The same each time: a wire has one other end."""
        if url not in self.links:
            wire = WIRES[url]
            link = self.sim.connect(wire).link if wire == "can0" else self.sim.open(wire)
            self.links[url] = link
        self.links[url].take()
        return Shared(self.links[url])

    def lock(self) -> None:
        """From now on it obeys only who signs."""
        path = self.folder / "key"
        path.write_text(KEY.hex())
        with session.connect("udp") as light:
            Parameters(light).set("MAV_SECURE", 255)
        assert main(["signing", "setup", "udp", "--key-file", str(path)]) == 0


@pytest.fixture
def bench(binary: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    wires = {
        "uart0": "udpin:127.0.0.1:0",
        "uart1": "pty:{folder}/tty",
        "can0": "udp:127.255.255.255:{port}",
    }
    with Simulator(binary, wires) as sim:
        sim.advance(s=2)
        yield Bench(sim, tmp_path, monkeypatch)


# What is typed between `pharos` and the options; URL and FOLDER are put in.
VERBS = [
    "on URL",
    "brightness URL 40",
    "strobe URL 0.5 10",
    "strobe URL off",
    "sync URL on",
    "sync URL off",
    "status URL",
    "watch URL 1",
    "info URL",
    "gimbal URL 10 5",
    "files list URL",
    "files get URL general.json FOLDER/general.json",
    "selftest URL 10",
    "param list URL LGT_*",
    "param get URL LGT_FALLBACK",
    "param set URL LGT_FALLBACK 1",
    "param save URL FOLDER/light.parm",
    "param load URL FOLDER/light.parm",
    "param diff URL FOLDER/light.parm",
    "off URL",
    "reboot URL",
    "shell URL -c on;off",
    "update FOLDER/new.bin URL",
]


def words_of(verb: str, url: str, folder: Path, *options: str) -> list[str]:
    words = [url if word == "URL" else word for word in verb.split()]
    return [word.replace("FOLDER", str(folder)) for word in words] + list(options)


@pytest.mark.parametrize("is_signed", [False, True], ids=["open", "signed"])
@pytest.mark.parametrize("url", WIRES)
def test_every_verb(
    bench: Bench, url: str, is_signed: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    (bench.folder / "new.bin").write_bytes(image())
    options: list[str] = []
    if is_signed:
        bench.lock()
        options = ["--key-file", str(bench.folder / "key")]
    for verb in VERBS:
        capsys.readouterr()
        assert main(words_of(verb, url, bench.folder, *options)) == 0, (verb, capsys.readouterr())
        out, err = capsys.readouterr()
        assert (out != "", err) == ("diff" not in verb, ""), verb
        assert main(words_of(verb, url, bench.folder, *options, "--json")) == 0, verb
        out, err = capsys.readouterr()
        assert err == "", verb
        for line in out.splitlines():
            fields = json.loads(line)
            name = verb.split()[0]
            told = fields.get("command", "event")
            assert told == name or name == "shell" or fields.get("event") == "text", (verb, fields)
            assert fields.get("ok", True), verb


@pytest.mark.parametrize("url", WIRES)
def test_a_light_with_a_key_says_so_to_who_has_none(
    bench: Bench, url: str, capsys: pytest.CaptureFixture[str]
) -> None:
    bench.lock()
    for verb in VERBS:
        if verb == "watch URL 1":
            continue  # everybody hears what it says by itself
        (bench.folder / "new.bin").write_bytes(image())
        (bench.folder / "light.parm").write_text("LGT_FALLBACK 1\n")
        capsys.readouterr()
        assert main(words_of(verb, url, bench.folder)) == 3, verb
        err = capsys.readouterr().err
        assert "--key-file FILE" in err, verb
        assert err.count("\n") == 1
    key = ["--key-file", str(bench.folder / "key")]
    assert main(["signing", "off", url, *key]) == 0
    assert main(["on", url]) == 0


@pytest.mark.parametrize("url", WIRES)
def test_refusals_have_their_code(
    bench: Bench, url: str, capsys: pytest.CaptureFixture[str]
) -> None:
    for words, code, reason in (
        (["brightness", url, "140"], 1, "denied"),
        (["param", "set", url, "NO_SUCH", "1"], 1, "NO_SUCH"),
        (["files", "get", url, "none"], 1, "no such file"),
        (["gimbal", url, "nan", "0"], 2, "no number"),
        (["strobe", url, "often"], 2, "no period"),
    ):
        capsys.readouterr()
        assert main(words) == code, words
        assert reason in capsys.readouterr().err
        assert main([*words, "--json"]) == code
        fields = json.loads(capsys.readouterr().out)
        assert fields["ok"] is False
        assert reason in fields["error"]


@pytest.mark.parametrize("url", ["udp", "pty"])
def test_a_light_that_is_lost_is_one_line_in_time(
    bench: Bench, url: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (bench.folder / "light.parm").write_text("LGT_FALLBACK 1\n")
    (bench.folder / "new.bin").write_bytes(image())
    bench.sim.fault(WIRES[url], "lost", rate_ppm=1_000_000)
    for verb in VERBS:
        start = bench.sim.now_us()
        capsys.readouterr()
        assert main(words_of(verb, url, bench.folder, "--timeout", "2")) == 3, verb
        assert bench.sim.now_us() - start < 3_000_000, verb
        err = capsys.readouterr().err
        assert "no illuminator answered within 2 s" in err, verb
        assert err.count("\n") == 1


def test_a_light_that_is_lost_on_the_way_is_one_line_too(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    found = Light.find

    def find(light: Light, *args: Any) -> Any:
        target = found(light, *args)
        bench.sim.fault("uart0", "lost", rate_ppm=1_000_000)
        return target

    monkeypatch.setattr(Light, "find", find)
    (bench.folder / "light.parm").write_text("LGT_FALLBACK 1\n")
    (bench.folder / "new.bin").write_bytes(image())
    for verb in VERBS:
        bench.sim.fault("uart0", "none")
        start = bench.sim.now_us()
        capsys.readouterr()
        assert main(words_of(verb, "udp", bench.folder)) == 3, verb
        assert bench.sim.now_us() - start < 10_000_000, verb
        err = capsys.readouterr().err
        assert err.startswith("pharos: "), verb
        assert err.count("\n") == 1, verb


def test_every_verb_is_in_the_table() -> None:
    """But those of which other tests are."""
    parser = cli.make_parser()
    (commands,) = (a for a in parser._actions if a.__class__.__name__ == "_SubParsersAction")
    others = {"signing", "find", "check", "can", "imc", "completion"}
    assert set(commands.choices or ()) - others == {verb.split()[0] for verb in VERBS}


# --- Ctrl-C and noise -----------------------------------------------------------------------------
def test_ctrl_c_ends_every_verb_without_a_word(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (bench.folder / "light.parm").write_text("LGT_FALLBACK 1\n")
    (bench.folder / "new.bin").write_bytes(image())
    left = 0
    pump = bench.sim.pump

    def interrupted(us: int) -> None:
        nonlocal left
        left -= 1
        if left < 0:
            raise KeyboardInterrupt
        pump(us)

    monkeypatch.setattr(bench.sim, "pump", interrupted)
    for verb in VERBS:
        left = 3
        capsys.readouterr()
        assert main(words_of(verb, "udp", bench.folder)) == 130, verb
        assert capsys.readouterr().err == "", verb


@pytest.mark.parametrize(
    "words",
    [
        ["find", "udp:127.0.0.1:9"],
        ["check", "udp:127.0.0.1:9"],
        ["check", "udp:127.0.0.1:9", "--profile", "imc"],
        ["check", "dronecan:virtual/x?node=9", "--profile", "dronecan"],
        ["can", "nodes", "virtual/x"],
        ["can", "monitor", "virtual/x"],
        ["can", "light", "on", "--bus", "virtual/x"],
        ["imc", "monitor", "udp:127.0.0.1:9"],
        ["imc", "send", "udp:127.0.0.1:9", "Heartbeat"],
    ],
    ids=" ".join,
)
def test_ctrl_c_ends_the_others_too(
    words: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(_pacer: RealPacer, _us: int) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(RealPacer, "pump", interrupted)
    assert main(words) == 130
    assert capsys.readouterr() == ("", "")


def test_noise_is_told_from_silence(bench: Bench, capsys: pytest.CaptureFixture[str]) -> None:
    class Noise(Shared):
        def take(self) -> list[bytes]:
            self.link.take()
            return [bytes([0x80, 0xE0, 0x9C, 0x00])]

    link = Noise(bench.sim.open("uart1"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(session, "open_link", lambda _url: link)
        assert main(["on", "pty", "--timeout", "1"]) == 3
    err = capsys.readouterr().err
    assert err.endswith("within 1 s; what came is no MAVLink: is the baud rate right?\n")
    assert err.count("\n") == 1
