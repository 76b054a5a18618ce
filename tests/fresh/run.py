#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""README's two commands on bare Debians, before a release: each in a fresh debootstrap of the
variant minbase that has git besides, as root, on two processors.

    tests/fresh/run.py                          Debian 12 and 13, all of both commands
    tests/fresh/run.py trixie --stages lint     one of them, one stage of ./make test
    tests/fresh/run.py --stages none            only ./make run

What is tested is the commit that is checked out. `./make run` is driven to its prompt, told `light
on`, and ended; then once more. `./make test` follows. The summary names what missed a target, and
how much CPU time a run took: on a machine with nothing else to do, half of that is the least it can
take. Everything is in CACHE (--cache): the packages, which the next run finds there, a log of each
command, and the root while it is in use. Root is needed, and the package debootstrap. A proxy in
http_proxy and its like, and a certificate in PIP_CERT, are taken along.

The roots are mounted into in a name space of their own, so that nothing stays mounted, whichever
way this ends.
"""

from __future__ import annotations

import argparse
import os
import pty
import re
import select
import shutil
import signal
import stat
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SUITES = {"bookworm": "Debian 12", "trixie": "Debian 13"}
CACHE = Path("/var/cache/pharos-fresh")
PROCESSORS = 2
INSIDE = "PHAROS_FRESH_INSIDE"
PROXIES = ("http_proxy", "https_proxy", "ftp_proxy", "no_proxy")
DEVICES = {"null": 3, "zero": 5, "full": 7, "random": 8, "urandom": 9}

PROMPT = b"pharos:~$ "
PROMPT_S = 1800.0  # only for what hangs
ANSWER_S = 10.0
RUN_S, AGAIN_S, DOWNLOAD_MB = 35.0, 1.0, 120.0  # targets


class FreshError(Exception):
    """Why a Debian was not tested to the end, in one line."""


@dataclass
class Start:
    """A `./make run` up to its prompt."""

    seconds: float
    cpu_s: float
    download_s: float = 0.0
    download_mb: float = 0.0

    @property
    def own_s(self) -> float:
        """All but the downloads."""
        return self.seconds - self.download_s


@dataclass
class Report:
    suite: str
    versions: str = ""
    first: Start | None = None
    again: Start | None = None
    tests: str = "not run"
    tests_s: float = 0.0
    missed: list[str] = field(default_factory=list)


# --- a root ------------------------------------------------------------------------------------


def run(*command: str | Path) -> str:
    done = subprocess.run(
        [str(word) for word in command], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT, text=True, errors="replace",
    )  # fmt: skip
    if done.returncode != 0:
        print(done.stdout, end="")
        raise FreshError(f"{' '.join(map(str, command[:3]))}: exit {done.returncode}")
    return done.stdout


def mount(kind: str, where: Path, options: str = "") -> None:
    where.mkdir(parents=True, exist_ok=True)
    run("mount", "-t", kind, *(["-o", options] if options else []), kind, where)


def bind(what: Path, where: Path) -> None:
    what.mkdir(parents=True, exist_ok=True)
    where.mkdir(parents=True, exist_ok=True)
    run("mount", "--bind", what, where)


def mount_all(root: Path, cache: Path, suite: str) -> None:
    mount("proc", root / "proc")
    mount("sysfs", root / "sys", "ro")
    mount("tmpfs", root / "tmp", "mode=1777")
    dev = root / "dev"
    mount("tmpfs", dev, "mode=755")
    for name, minor in DEVICES.items():
        os.mknod(dev / name, stat.S_IFCHR, os.makedev(1, minor))
        (dev / name).chmod(0o666)
    os.mknod(dev / "tty", stat.S_IFCHR, os.makedev(5, 0))
    (dev / "tty").chmod(0o666)
    mount("devpts", dev / "pts", "newinstance,ptmxmode=0666,mode=620,gid=5")
    mount("tmpfs", dev / "shm", "mode=1777")
    for name, target in {"ptmx": "pts/ptmx", "fd": "/proc/self/fd", "stdin": "fd/0",
                         "stdout": "fd/1", "stderr": "fd/2"}.items():  # fmt: skip
        (dev / name).symlink_to(target)
    bind(cache / f"debs-{suite}", root / "var/cache/apt/archives")
    bind(cache / "pip", root / "root/.cache/pip")


@contextmanager
def fresh_root(cache: Path, suite: str, mirror: str) -> Iterator[Path]:
    """A bare Debian with the tree in /root/pharos; it is gone afterwards."""
    root = cache / f"root-{suite}"
    debs = cache / f"debs-{suite}"
    shutil.rmtree(root, ignore_errors=True)
    debs.mkdir(parents=True, exist_ok=True)
    try:
        run("debootstrap", "--variant=minbase", "--include=git", f"--cache-dir={debs}", suite,
            root, mirror)  # fmt: skip
        shutil.copy("/etc/resolv.conf", root / "etc/resolv.conf")
        if "PIP_CERT" in os.environ:
            shutil.copy(os.environ["PIP_CERT"], root / "root/pip-cert.pem")
        run("git", "clone", "--quiet", "--no-local", ROOT, root / "root/pharos")
        mount_all(root, cache, suite)
        yield root
    finally:
        unmount_below(root)
        shutil.rmtree(root)


def unmount_below(root: Path) -> None:
    mounts = [line.split()[1] for line in Path("/proc/self/mounts").read_text().splitlines()]
    for where in reversed(mounts):
        if Path(where).is_relative_to(root):
            run("umount", "--lazy", where)


def environment(root: Path) -> dict[str, str]:
    """What a login gives, and what a proxy needs."""
    path = "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin"
    env = {"HOME": "/root", "PATH": path, "TERM": "xterm"}
    env |= {name: os.environ[name] for name in PROXIES if name in os.environ}
    if (root / "root/pip-cert.pem").exists():
        env["PIP_CERT"] = "/root/pip-cert.pem"
    return env


def within(root: Path, *command: str) -> list[str]:
    return ["chroot", str(root), "/bin/sh", "-c", 'cd /root/pharos && exec "$@"', "sh", *command]


# --- the two commands --------------------------------------------------------------------------


class Terminal:
    """A command on a terminal of its own, its output kept in a log."""

    def __init__(self, command: list[str], env: dict[str, str], log: Path) -> None:
        self.output = b""
        self._log = log.open("wb")
        self._pid, self._fd = pty.fork()
        if self._pid == 0:
            os.execvpe(command[0], command, env)

    def read(self, timeout_s: float) -> bool:
        """Takes what came; false: nothing more will."""
        if not select.select([self._fd], [], [], timeout_s)[0]:
            return True
        try:
            data = os.read(self._fd, 65536)
        except OSError:
            data = b""
        self.output += data
        self._log.write(data)
        self._log.flush()
        return bool(data)

    def expect(self, text: bytes, timeout_s: float) -> None:
        end = time.monotonic() + timeout_s
        while text not in self.output:
            if not self.read(1.0) or time.monotonic() > end:
                last = self.output.decode(errors="replace").strip().splitlines()[-1:]
                raise FreshError(f"no {text.decode()!r}; the last line is {last}")

    def send(self, keys: bytes) -> None:
        self.output = b""
        os.write(self._fd, keys)

    def close(self) -> float:
        """Ends it, if need be by a signal, and returns the CPU seconds it took."""
        end = time.monotonic() + ANSWER_S
        while self.read(0.1):
            if time.monotonic() > end:
                os.killpg(self._pid, signal.SIGTERM)
                end += ANSWER_S
        os.close(self._fd)
        self._log.close()
        usage = os.wait4(self._pid, 0)[2]
        return usage.ru_utime + usage.ru_stime


def downloads(text: str) -> tuple[float, float]:
    """Megabytes and seconds, as boards/native/setup.sh tells of them."""
    units = {"B": 1e-6, "kB": 1e-3, "MB": 1.0, "GB": 1e3}
    sizes = re.findall(r"^setup: fetching.*[ /]([\d.,]+) ([kMG]?B)\b", text, re.MULTILINE)
    megabytes = sum(float(amount.replace(",", "")) * units[unit] for amount, unit in sizes)
    seconds = sum(map(float, re.findall(r"^setup: fetching.* ([\d.]+) s$", text, re.MULTILINE)))
    return megabytes, seconds


def make_run(root: Path, log: Path) -> Start:
    """`./make run` to its prompt, `light on`, and out again."""
    begin = time.monotonic()
    terminal = Terminal(within(root, "./make", "run"), environment(root), log)
    try:
        terminal.expect(PROMPT, PROMPT_S)
        seconds = time.monotonic() - begin
        text = terminal.output.decode(errors="replace").replace("\r\n", "\n")
        terminal.send(b"light on\r")
        terminal.expect(b"\nok\r", ANSWER_S)
        terminal.send(b"\x04")
    finally:
        cpu_s = terminal.close()
    megabytes, download_s = downloads(text)
    return Start(seconds, cpu_s, download_s, megabytes)


def make_test(root: Path, log: Path, stages: str, report: Report) -> None:
    begin = time.monotonic()
    with log.open("wb") as out:
        code = subprocess.call(
            within(root, "./make", "test", *([f"STAGES={stages}"] if stages else [])),
            stdin=subprocess.DEVNULL, stdout=out, stderr=subprocess.STDOUT, env=environment(root),
        )  # fmt: skip
    report.tests_s = time.monotonic() - begin
    lines = log.read_text(errors="replace").strip().splitlines() or ["no output"]
    table = max((n for n, line in enumerate(lines) if line.startswith("stage ")), default=-1)
    print("\n".join(lines[table:]), flush=True)
    report.tests = lines[-1] if code == 0 or table >= 0 else f"exit {code}: {lines[-1]}"
    if code != 0:
        report.missed.append("./make test")


def versions(root: Path) -> str:
    found = []
    for program, pattern in {"python3": r"[\d.]+", "gcc": r"[\d.]+$", "clang": r"[\d.]+"}.items():
        done = subprocess.run(
            ["chroot", str(root), program, "--version"], capture_output=True, text=True, check=False
        )
        number = re.search(pattern, done.stdout.partition("\n")[0]) if not done.returncode else None
        found.append(f"{program} {number[0] if number else '-'}")
    return ", ".join(found)


def examine(cache: Path, suite: str, mirror: str, stages: str) -> Report:
    report = Report(suite)
    print(f"\n=== {SUITES[suite]}: debootstrap", flush=True)
    try:
        with fresh_root(cache, suite, mirror) as root:
            for name in ("first", "again"):
                print(f"=== {SUITES[suite]}: ./make run ({name})", flush=True)
                setattr(report, name, make_run(root, cache / f"{suite}-run-{name}.log"))
            if stages != "none":
                print(f"=== {SUITES[suite]}: ./make test", flush=True)
                make_test(root, cache / f"{suite}-test.log", stages, report)
            report.versions = versions(root)
    except FreshError as error:
        report.missed.append(str(error))
    return report


# --- the summary -------------------------------------------------------------------------------


def judge(report: Report) -> None:
    if report.first is not None and report.first.own_s > RUN_S:
        report.missed.append(f"./make run in {RUN_S:.0f} s")
    if report.first is not None and report.first.download_mb > DOWNLOAD_MB:
        report.missed.append(f"{DOWNLOAD_MB:.0f} MB of downloads")
    if report.again is not None and report.again.own_s > AGAIN_S:
        report.missed.append(f"the second ./make run in {AGAIN_S:.0f} s")


def tell(report: Report) -> None:
    print(f"\n{SUITES[report.suite]} ({report.versions})")
    rows = []
    if report.first is not None:
        first = report.first
        rows.append(
            ("./make run: downloads", f"{first.download_mb:.1f} MB", f"≤ {DOWNLOAD_MB:.0f}")
        )
        rows.append(("to the prompt without them", f"{first.own_s:.1f} s", f"≤ {RUN_S:.0f}"))
        rows.append(("  CPU time of it", f"{first.cpu_s:.1f} s", ""))
    if report.again is not None:
        rows.append(("./make run again", f"{report.again.own_s:.2f} s", f"≤ {AGAIN_S:.0f}"))
    rows.append(("./make test", f"{report.tests_s:.0f} s", ""))
    for what, value, target in rows:
        print(f"  {what:<28}{value:>12}  {target}")
    print(f"  {report.tests}")
    print(f"  missed: {'; '.join(report.missed) or 'nothing'}")


def _own_mirror() -> str:
    """The archive of Debian that this machine takes its packages from."""
    sites = subprocess.run(
        ["apt-get", "indextargets", "--format", "$(SITE)"],
        capture_output=True,
        text=True,
        check=True,
    ).stdout.split()
    return next((site for site in sites if "security" not in site), "")


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("suites", nargs="*", help=f"of {', '.join(SUITES)}; default: all")
    parser.add_argument("--stages", default="", help="stages of ./make test; none: leave it out")
    parser.add_argument("--cache", type=Path, default=CACHE, help=f"default: {CACHE}")
    parser.add_argument("--mirror", default=_own_mirror(), help="default: this machine's own")
    args = parser.parse_args()
    unknown = [suite for suite in args.suites if suite not in SUITES]
    if unknown:
        parser.error(f"no Debian {', '.join(unknown)}; there are: {', '.join(SUITES)}")
    if os.geteuid() != 0:
        parser.error("run this as root: it makes roots and mounts into them")
    if shutil.which("debootstrap") is None:
        parser.error("debootstrap is missing: apt-get install debootstrap")
    if INSIDE not in os.environ:
        space = ["unshare", "--mount", "--pid", "--fork", "--kill-child"]
        os.execvpe(space[0], [*space, sys.executable, *sys.argv], {**os.environ, INSIDE: "1"})

    os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:PROCESSORS])
    head = run("git", "-C", ROOT, "log", "-1", "--format=%h %s").strip()
    print(f"{head}; load {os.getloadavg()[0]:.1f}, {len(os.sched_getaffinity(0))} processors")
    reports = [
        examine(args.cache.resolve(), suite, args.mirror, args.stages)
        for suite in args.suites or SUITES
    ]
    for report in reports:
        judge(report)
        tell(report)
    return int(any(report.missed for report in reports))


if __name__ == "__main__":
    sys.exit(main())
