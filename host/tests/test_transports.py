# SPDX-License-Identifier: Apache-2.0
"""`pharos` over each kind of link in real time, with a key and without. Every verb of it, in
simulated time: test_every_verb.py."""

from __future__ import annotations

import json
import socket
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from pharos.cli import main
from real_light import RealLight

START = Callable[..., RealLight]
pytestmark = pytest.mark.realtime
# A busy machine is slow, not silent.
PATIENCE = ["--timeout", "15"]
VERBS = [
    ["on", "URL"],
    ["status", "URL"],
    ["files", "get", "URL", "general.json", "FILE"],
    ["param", "get", "URL", "LGT_RESTORE"],
    ["off", "URL"],
    ["check", "URL", "--only", "SW-2"],
]


@pytest.fixture(params=["udp", "pty", "tunnel"])
def reached(
    request: pytest.FixtureRequest, real_light: START, tmp_path: Path
) -> Iterator[tuple[RealLight, str]]:
    """A light, and the URL that reaches it."""
    if request.param == "tunnel":
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as kept:
            kept.bind(("127.0.0.1", 0))
            bus = f"127.255.255.255:{kept.getsockname()[1]}"
            light = real_light("--can0", f"udp:{bus}", "--uart0", "udpin:127.0.0.1:0")
            yield light, f"dronecan:pharos-udp/{bus}?node=68"
        return
    wire = {"udp": "udpin:127.0.0.1:0", "pty": f"pty:{tmp_path}/uart0"}[request.param]
    light = real_light("--uart0", wire)
    yield light, light.url()


@pytest.mark.parametrize("signed", [False, True], ids=["open", "signed"])
def test_verbs_work(
    reached: tuple[RealLight, str],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    signed: bool,
) -> None:
    light, url = reached
    key: list[str] = []
    if signed:
        # Each wire, and the tunnels, may set the key.
        assert main(["param", "set", url, "MAV_SECURE", "255", *PATIENCE]) == 0
        key = ["--key-file", str(tmp_path / "key")]
        assert main(["signing", "setup", url, *key, *PATIENCE]) == 0
    for number, verb in enumerate(VERBS):
        words = [{"URL": url, "FILE": str(tmp_path / "file")}.get(word, word) for word in verb]
        as_json = ["--json"] if number % 2 else []
        capsys.readouterr()
        assert main([*words, *key, *as_json, *PATIENCE]) == 0, verb
        out, err = capsys.readouterr()
        assert err == ""
        if as_json:
            assert all(isinstance(json.loads(line), dict) for line in out.splitlines())
        else:
            assert out
    assert light.control.request("outputs")["enable"] == 0
    if signed:
        assert main(["on", url, *PATIENCE]) == 3
        assert "--key-file" in capsys.readouterr().err
