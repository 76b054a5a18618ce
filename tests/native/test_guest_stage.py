# SPDX-License-Identifier: Apache-2.0
"""The `linux` stage where there is no guest: it fails and says why, unless it is told to skip."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "linux"))

import guest

Kernel = Callable[[str], None]


@pytest.fixture
def kernel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Kernel:
    """kernel(SCRIPT): what runs as the guest's kernel."""

    def use(script: str) -> None:
        path = tmp_path / "linux"
        path.write_text(f"#!/bin/sh\n{script}\n")
        path.chmod(0o755)
        monkeypatch.setattr(guest, "build_kernel", lambda: path)
        monkeypatch.setattr(guest, "build_light2", lambda: path)
        monkeypatch.delenv(guest.SKIP, raising=False)

    return use


def test_kernel_that_does_not_boot_fails_the_stage_with_its_last_words(kernel: Kernel) -> None:
    kernel("echo 'checking ptrace' >&2; echo 'ptrace is not permitted' >&2; exit 1")
    result = guest.stage("native")
    assert (result.passed, result.failed) == (0, 2)
    assert result.note == "no guest: the guest ended early: ptrace is not permitted"
    assert "guest.py test" in result.replay


def test_guest_that_hangs_is_ended_and_fails_the_stage(
    kernel: Kernel, monkeypatch: pytest.MonkeyPatch
) -> None:
    kernel("exec tail -f /dev/null")
    monkeypatch.setattr(guest, "TEST_S", 0.2)
    result = guest.run_tests(Path("build"), [])
    assert result.failed == 1
    assert result.note == "no guest: the guest took longer than 0 s"


def test_variable_skips_the_stage_and_the_summary_says_so(
    kernel: Kernel, monkeypatch: pytest.MonkeyPatch
) -> None:
    kernel("exit 1")
    monkeypatch.setenv("PHAROS_SKIP_GUEST", "1")
    result = guest.stage("native")
    assert (result.passed, result.failed) == (0, 0)
    assert result.note == "skipped: PHAROS_SKIP_GUEST is set"


@pytest.mark.parametrize(
    ("script", "passed", "failed"),
    [
        ("echo '3 passed, 1 skipped in 0.1s'; echo 0", 3, 0),
        ("echo '1 failed, 2 passed, 1 error in 0.1s'; echo 1", 2, 2),
        ("echo 'no tests ran in 0.1s'; echo 5", 0, 1),
        ("echo '3 passed in 0.1s'; echo 139", 3, 1),
    ],
)
def test_counts_are_those_of_pytests_last_line_and_its_status_counts(
    kernel: Kernel, script: str, passed: int, failed: int
) -> None:
    """The last line of the script is the status, which the guest leaves in its share."""
    said, _, status = script.rpartition("; ")
    share = 'for word; do case "$word" in SHARE=*) share="${word#SHARE=}";; esac; done'
    kernel(f'{share}\n{said}\n{status} >"$share/status"')
    result = guest.run_tests(Path("build"), [])
    assert (result.passed, result.failed) == (passed, failed)
