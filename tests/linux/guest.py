# SPDX-License-Identifier: Apache-2.0
"""A Linux guest with CAN and GPIO, whatever the host's kernel has: user-mode Linux, no KVM.

    guest.py build              the kernel, from Debian's source package, into build/guest
    guest.py run -- COMMAND…    COMMAND as root in the guest; its output and exit status
    guest.py test [PYTEST…]     the tests of this folder in the guest
    guest.py system [PYTEST…]   those of tests/system that go over a CAN bus, over the guest's vcan0

The guest runs the host's own programs on the host's root, which it cannot change: what it writes
is gone when it ends. Its packages are those of boards/native/setup.sh test.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import importlib.metadata
import mmap
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
CACHE = ROOT / "build" / "guest"
CONFIG = HERE / "guest.config"
SOURCE = Path("/usr/src/linux-source-6.12.tar.xz")
MEMORY = "512M"
# Where i2c-stub keeps registers: a PCA9685, two LM75 and a spare.
I2C_CHIPS = "0x40,0x48,0x49,0x41"
# Only for what hangs: each takes a minute or two on a quiet machine.
TEST_S = 600.0
SYSTEM_S = 1800.0
SKIP = "PHAROS_SKIP_GUEST"
PYTEST = (sys.executable, "-m", "pytest", "-q", "--color=no", "-p", "no:cacheprovider")
ON_VCAN0 = {"PHAROS_BUS": "socketcan:vcan0"}


class GuestError(Exception):
    """Why there is no guest, in one line."""


@dataclass
class Result:
    """What the `linux` stage found. note: for the summary; empty: nothing to say."""

    passed: int = 0
    failed: int = 0
    replay: str = ""
    note: str = ""


# --- the host's part ---------------------------------------------------------------------------


def failures(output: str) -> str:
    """The first of pytest's lines about tests that failed, each with its reason."""
    return "\n  ".join(re.findall(r"^(?:FAILED|ERROR) .*$", output, re.MULTILINE)[:10])


def _run(
    *command: str | Path, cwd: Path | None = None, env: Mapping[str, str] | None = None
) -> str:
    words = [str(word) for word in command]
    done = subprocess.run(
        words, cwd=cwd, env={**os.environ, **(env or {})}, stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace",
    )  # fmt: skip
    if done.returncode != 0:
        print(done.stdout, end="")
        last = (done.stdout.strip().splitlines() or ["no output"])[-1]
        raise GuestError(f"{shlex.join(words[:6])}: exit {done.returncode}: {last}")
    return done.stdout


def _installed(package: str) -> str:
    """Its version; empty: it is not installed."""
    done = subprocess.run(
        ["dpkg-query", "-W", "-f", "${db:Status-Status} ${Version}", package],
        capture_output=True, text=True,
    )  # fmt: skip
    status, _, version = done.stdout.partition(" ")
    return version if status == "installed" else ""


def _options(config: Path) -> set[str]:
    return set(re.findall(r"^CONFIG_\w+=.*$", config.read_text(), re.MULTILINE))


def build_kernel() -> Path:
    """The kernel, from the cache or newly built (a few minutes)."""
    version = _installed(SOURCE.name.removesuffix(".tar.xz"))
    key = hashlib.sha256(CONFIG.read_bytes() + version.encode()).hexdigest()[:16]
    kernel = CACHE / f"linux-{key}"
    if kernel.exists():
        return kernel
    if not version:
        raise GuestError(f"{SOURCE} is missing: run boards/native/setup.sh test")
    print(f"guest: building its kernel, {version}, once; this takes minutes", flush=True)
    start = time.monotonic()
    CACHE.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=CACHE, prefix="linux-source-") as folder:
        source, out = Path(folder, "source"), Path(folder, "out")
        source.mkdir()
        out.mkdir()
        # What is left out is never opened in a build for user-mode Linux.
        _run("tar", "-xJf", SOURCE, "-C", source, "--strip-components=1",
             "--exclude=*/Documentation/*/*", "--exclude=*/drivers/gpu/drm/amd/include",
             "--exclude=*/arch/arm*/boot/dts", "--exclude=*/tools/testing")  # fmt: skip
        # It is only offered as a module, and the guest has none.
        _run("sed", "-i", "/^config I2C_STUB$/,/help/s/depends on m$/depends on I2C/",
             source / "drivers/i2c/Kconfig")  # fmt: skip
        make = ("make", "-s", "-C", source, "ARCH=um", f"O={out}")
        _run(*make, f"KCONFIG_ALLCONFIG={CONFIG}", "allnoconfig")
        dropped = _options(CONFIG) - _options(out / ".config")
        if dropped:
            raise GuestError(f"the kernel does not take {', '.join(sorted(dropped))}")
        _run(*make, f"-j{len(os.sched_getaffinity(0))}", "linux")
        _run("strip", out / "linux")
        shutil.move(out / "linux", kernel)
    print(f"guest: built in {time.monotonic() - start:.0f} s", flush=True)
    return kernel


def _memory_folder() -> Path:
    """Where the guest's memory can be mapped executable; best in the host's own memory."""
    for folder in (Path("/dev/shm"), Path(tempfile.gettempdir()), CACHE):
        try:
            with tempfile.TemporaryFile(dir=folder) as file:
                file.truncate(mmap.PAGESIZE)
                prot = mmap.PROT_READ | mmap.PROT_WRITE | mmap.PROT_EXEC
                mmap.mmap(file.fileno(), mmap.PAGESIZE, prot=prot).close()
        except OSError:
            continue
        return folder
    raise GuestError("no folder whose files may be mapped executable")


def _status_of(share: Path) -> int | None:
    try:
        return int((share / "status").read_text())
    except (OSError, ValueError):
        return None


def _end(process: subprocess.Popen[str]) -> None:
    """The whole guest: each of its processes is one of the host's, in the same group."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def _follow(process: subprocess.Popen[str], timeout_s: float) -> str:
    """Shows its output as it comes, to its end or the time-out."""
    lines = []
    late = threading.Event()

    def end() -> None:
        late.set()
        _end(process)

    timer = threading.Timer(timeout_s, end)
    timer.start()
    try:
        assert process.stdout is not None
        for line in process.stdout:
            print(line, end="", flush=True)
            lines.append(line)
    finally:
        timer.cancel()
        _end(process)
    if late.is_set():
        raise GuestError(f"the guest took longer than {timeout_s:.0f} s")
    return "".join(lines)


def run(
    command: Sequence[str], *, env: Mapping[str, str] | None = None, timeout_s: float = TEST_S
) -> tuple[int, str]:
    """Runs command in a new guest, at the root of the tree. Its exit status and its output, which
    is also shown as it comes. GuestError: it did not get that far, or took too long."""
    kernel = build_kernel()
    with tempfile.TemporaryDirectory(prefix="guest-") as folder:
        share = Path(folder)
        words = " ".join(f"{k}={shlex.quote(v)}" for k, v in (env or {}).items())
        (share / "command").write_text(
            f"cd {shlex.quote(str(ROOT))}\n"
            f"exec env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 "
            f"PHAROS_GUEST=1 PYTHONDONTWRITEBYTECODE=1 {words} {shlex.join(command)} 2>&1\n"
        )
        # One CPU: what the guest's processes tell each other then never crosses two caches.
        arguments = [
            "taskset", "-c", str(max(os.sched_getaffinity(0))),
            str(kernel), f"mem={MEMORY}", "root=/dev/root", "rootfstype=hostfs", "ro", "loglevel=0",
            f"init={HERE / 'init.sh'}", "con=null", "con0=null,fd:1", f"uml_dir={share}",
            f"SHARE={share}", f"i2c_stub.chip_addr={I2C_CHIPS}",
        ]  # fmt: skip
        with (share / "kernel.log").open("w") as log:
            process = subprocess.Popen(
                arguments, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=log, text=True,
                errors="replace", start_new_session=True,
                env={**os.environ, "TMPDIR": str(_memory_folder()), "HOME": folder},
            )  # fmt: skip
            output = _follow(process, timeout_s)
        status = _status_of(share)
        if status is None:
            text = (share / "kernel.log").read_text(errors="replace").strip()
            print(text)
            last = (text or output.strip() or "no reason").splitlines()[-1]
            raise GuestError(f"the guest ended early: {last}")
        return status, output


# --- the light with libgpiod 2, which Debian 12 does not have ------------------------------------


def _build_libgpiod2(version: str) -> Path:
    """A static libgpiod 2 from the sources that the PyPI package carries; its pkg-config folder."""
    prefix = CACHE / f"libgpiod-{version}"
    if (prefix / "libgpiod.pc").exists():
        return prefix
    shutil.rmtree(prefix, ignore_errors=True)
    prefix.mkdir(parents=True)
    _run(sys.executable, "-m", "pip", "download", "-q", "--disable-pip-version-check", "--no-deps",
         "--no-binary", "gpiod", "-d", prefix, f"gpiod=={version}")  # fmt: skip
    _run("tar", "-xzf", next(prefix.glob("gpiod-*.tar.gz")), "-C", prefix)
    source = prefix / f"gpiod-{version}"
    release = (source / "libgpiod-version.txt").read_text().strip()
    includes = ("-I", source / "include", "-I", source / "lib")
    objects = []
    for file in sorted((source / "lib").glob("*.c")):
        objects.append(prefix / f"{file.stem}.o")
        _run("gcc", "-O2", "-D_GNU_SOURCE", f'-DGPIOD_API_VERSION_STR="{release}"',
             *includes, "-c", file, "-o", objects[-1])  # fmt: skip
    _run("ar", "rcs", prefix / "libgpiod.a", *objects)
    (prefix / "libgpiod.pc").write_text(
        f"Name: libgpiod\nDescription: GPIO character device library\nVersion: {release}\n"
        f"Cflags: -I{source / 'include'}\nLibs: -L{prefix} -lgpiod\n"
    )
    return prefix


def build_light2() -> Path:
    """build/guest/light2/pharos: the light over libgpiod 2, with the sanitizer that can run there:
    a process of user-mode Linux has 512 GB of addresses, and ASan's shadow takes 16 TB."""
    folder = CACHE / "light2"
    env = {"PKG_CONFIG_PATH": str(_build_libgpiod2(importlib.metadata.version("gpiod")))}
    _run("cmake", "-G", "Ninja", "-S", ROOT, "-B", folder, "--log-level=NOTICE",
         "-DPHAROS_SANITIZE=undefined", f"-DPython3_EXECUTABLE={sys.executable}",
         env=env)  # fmt: skip
    _run("ninja", "-C", folder, "--quiet", "pharos", env=env)
    return folder / "pharos"


# --- the tests -------------------------------------------------------------------------------


def _pytest(
    action: str,
    build: Path,
    command: Sequence[str],
    timeout_s: float,
    environment: Callable[[], Mapping[str, str]],
) -> Result:
    """A command that ends in pytest, in a guest, on the light in `build`."""
    replay = f"PHAROS_BUILD={build} {sys.executable} tests/linux/guest.py {action}"
    try:
        build_kernel()
        env = {"PHAROS_BUILD": str(build), **environment()}
        status, text = run(command, env=env, timeout_s=timeout_s)
    except GuestError as error:
        print(f"guest: {error}")
        return Result(failed=1, replay=replay, note=f"no guest: {error}")
    last = (text.strip().splitlines() or [""])[-1]
    passed = re.search(r"(\d+) passed", last)
    failed = sum(int(n) for n in re.findall(r"(\d+) (?:failed|error)", last))
    if passed is None or status != 0:
        failed = max(failed, 1)
    replay = replay if failed else ""
    return Result(int(passed[1]) if passed else 0, failed, replay, failures(text))


def run_tests(build: Path, arguments: Sequence[str]) -> Result:
    """The tests of this folder, on the light in `build` and on one with libgpiod 2."""
    command = [*PYTEST, *arguments, "tests/linux"]
    return _pytest("test", build, command, TEST_S, lambda: {"PHAROS_LIGHT2": str(build_light2())})


def run_system(build: Path, arguments: Sequence[str]) -> Result:
    """The system tests that go over a CAN bus, over vcan0."""
    on_vcan0 = (sys.executable, str(HERE / "guest_can.py"), *PYTEST, "-m", "bus")
    command = [*on_vcan0, *arguments, "tests/system"]
    return _pytest("system", build, command, SYSTEM_S, lambda: ON_VCAN0)


def stage(preset: str) -> Result:
    """The `linux` stage of tests/run.py, on the light in build/<preset>."""
    if os.environ.get(SKIP, "0") not in ("", "0"):
        return Result(note=f"skipped: {SKIP} is set")
    build = ROOT / "build" / preset
    here, system = run_tests(build, []), run_system(build, [])
    return Result(
        here.passed + system.passed,
        here.failed + system.failed,
        here.replay or system.replay,
        here.note or system.note or f"{system.passed} of them: tests/system over vcan0",
    )


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    actions = parser.add_subparsers(dest="action", required=True)
    actions.add_parser("build", help="make the kernel, unless it is there")
    in_guest = actions.add_parser("run", help="run a command in the guest")
    in_guest.add_argument("--timeout", type=float, default=TEST_S, metavar="SECONDS")
    in_guest.add_argument("command", nargs="+")
    tests = actions.add_parser("test", help="run the tests of this folder in the guest")
    system = actions.add_parser("system", help="run the system tests over the guest's vcan0")
    for parser_of_tests in (tests, system):
        parser_of_tests.add_argument("pytest", nargs="*", help="options for pytest, after --")
    args = parser.parse_args()
    try:
        if args.action == "build":
            print(build_kernel())
            return 0
        if args.action == "run":
            return run(args.command, timeout_s=args.timeout)[0]
    except GuestError as error:
        print(f"guest: {error}", file=sys.stderr)
        return 1
    build = Path(os.environ.get("PHAROS_BUILD", ROOT / "build" / "native")).resolve()
    run_them = run_system if args.action == "system" else run_tests
    return int(run_them(build, args.pytest).failed > 0)


if __name__ == "__main__":
    sys.exit(main())
