# SPDX-License-Identifier: Apache-2.0
"""The commit that a build tells of itself (app/threads/vcs_commit.cmake)."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

SCRIPT = Path(__file__).resolve().parents[2] / "app" / "threads" / "vcs_commit.cmake"
# Nothing of the user's or the machine's, nor of a repository around the folder.
ENVIRONMENT = {"HOME": "/nonexistent", "GIT_CONFIG_NOSYSTEM": "1"} | {
    f"GIT_{who}_{what}": "test" for who in ("AUTHOR", "COMMITTER") for what in ("NAME", "EMAIL")
}


def run(folder: Path, *command: str | Path) -> str:
    environment = {**os.environ, **ENVIRONMENT, "GIT_CEILING_DIRECTORIES": str(folder.parent)}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def header_of(folder: Path) -> str:
    out = folder / "generated" / "vcs_commit.h"
    run(folder, "cmake", "-D", f"SOURCE={folder}", "-D", f"OUT={out}", "-P", SCRIPT)
    return out.read_text().splitlines()[1]


def test_commit_of_a_tree_follows_its_commits(tmp_path: Path) -> None:
    run(tmp_path, "git", "init", "-q")
    for message in ("one", "two"):
        run(tmp_path, "git", "commit", "-q", "--allow-empty", "-m", message)
        whole = run(tmp_path, "git", "rev-parse", "HEAD")
        assert header_of(tmp_path) == f"#define PHAROS_VCS_COMMIT 0x{whole[:8]}u"


def test_without_git_it_is_not_known(tmp_path: Path) -> None:
    assert header_of(tmp_path) == "#define PHAROS_VCS_COMMIT 0x0u"


def test_header_is_left_alone_while_nothing_changes(tmp_path: Path) -> None:
    header_of(tmp_path)
    out = tmp_path / "generated" / "vcs_commit.h"
    os.utime(out, (1, 1))
    header_of(tmp_path)
    assert out.stat().st_mtime == 1
