# SPDX-License-Identifier: Apache-2.0
"""The `pharos` command. Errors are one line on stderr, and the exit code tells their kind."""

from __future__ import annotations

import argparse
import difflib
import io
import logging
import os
import re
import sys
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from importlib.metadata import PackageNotFoundError, version
from typing import NoReturn

from ..connection import Target
from ..errors import PharosError, UsageError
from ..light import Light
from ..session import connect
from .key import read_key, run_signing
from .shell import (
    COMMANDS,
    OK,
    USAGE,
    Printer,
    Shell,
    exit_code,
    parse,
    parse_words,
)
from .texts import CHECK, CODES, COMPLETION, FIND, MAIN, PARAM, SHELL, UPDATE

INTERRUPTED = 130

# Commands whose first word says which of several they are: it stands before the URL.
WITH_ACTION = ("param", "files")
BUS_HELP = "python-can's INTERFACE/CHANNEL; default: pharos-udp, the user-space bus"


class Parser(argparse.ArgumentParser):
    """argparse, with what is meant instead of a list of all that could be."""

    def error(self, message: str) -> NoReturn:
        # The words of a command of the shell, which has its own say on them.
        message = message.replace(", …", "")
        wrong = re.fullmatch(
            r"argument (\w+): invalid choice: '(.*)' \(choose from (.*)\)", message
        )
        if wrong is not None:
            known = re.findall(r"[\w-]+", wrong[3])
            near = difflib.get_close_matches(wrong[2], known, 1)
            hint = f"did you mean {near[0]}?" if near else f"one of {', '.join(known)}"
            message = f"'{wrong[2]}' is no {wrong[1]}; {hint}"
        super().error(message)


def main(argv: Sequence[str] | None = None) -> int:
    parser = make_parser()
    if "_ARGCOMPLETE" in os.environ:
        from .completion import complete

        complete(parser)
    if not (sys.argv[1:] if argv is None else argv):
        parser.print_help()
        return USAGE
    args = parser.parse_args(argv)
    # python-can and dronecan log what they then raise.
    logging.disable(logging.CRITICAL)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # What the terminal's character set lacks is shown as its escape.
            stream.reconfigure(errors="backslashreplace")
    printer = Printer(sys.stdout, sys.stderr, args.json)
    try:
        return int(args.run(args, printer))
    except PharosError as error:
        printer.error(error)
        return exit_code(error)
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        # Whoever read the output has had enough (head); nothing is left to flush at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return OK


def make_parser() -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = Parser(
        prog="pharos",
        description=(
            "Talks to a Pharos light: MAVLink (shell), plain DroneCAN (can), IMC (imc);\n"
            "and checks any maker's (check)."
        ),
        epilog=MAIN,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"pharos {pharos_version()}")
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    _add_shell(commands)
    _add_plain(commands)
    _add_signing(commands)
    _add_find(commands)
    _add_check(commands)
    _add_update(commands)
    can = commands.add_parser(
        "can",
        help="look at a CAN bus, or command a light without MAVLink",
        description="DroneCAN on any python-can bus.",
        epilog="example:\n  pharos can nodes socketcan/can0\n\n" + CODES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    kinds = can.add_subparsers(metavar="COMMAND", required=True)
    _add_monitor(kinds)
    _add_nodes(kinds)
    _add_light(kinds)
    _add_imc(commands)
    completion = commands.add_parser(
        "completion",
        help="complete commands and options in a shell",
        description="Prints what a shell needs to complete `pharos` with the Tab key.",
        epilog=COMPLETION,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    completion.add_argument("shell", choices=("bash", "zsh", "fish"))
    completion.set_defaults(run=_run_completion, json=False)
    return parser


def _add_shell(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    shell = commands.add_parser(
        "shell",
        help="switch, dim, strobe and watch a light over MAVLink",
        description="Commands for a light, over any link.",
        epilog=SHELL,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    shell.add_argument("url", metavar="URL", help="where the light is")
    shell.add_argument("-c", dest="commands", metavar="COMMANDS", help="run these, ; between them")
    _add_light_options(shell)
    shell.set_defaults(run=_run_shell)


def _add_light_options(parser: argparse.ArgumentParser, timeout_s: float = 3.0) -> None:
    parser.add_argument("--json", action="store_true", help="one JSON object per line")
    parser.add_argument("--key-file", metavar="FILE", help="the light's key: 32 bytes, or in hex")
    parser.add_argument(
        "--target", type=_target, metavar="SYS/COMP", help="which component, if there are several"
    )
    parser.add_argument(
        "--timeout",
        type=_seconds,
        default=timeout_s,
        metavar="S",
        help=f"how long to wait for the light (default: {timeout_s:g})",
    )


def _add_plain(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """A command of the shell as one of the command line's."""
    for command in COMMANDS.values():
        if command.name in ("help", "quit"):
            continue
        has_action = command.name in WITH_ACTION
        arguments = command.usage.partition(" ")[2]
        form = f"ACTION URL {'…' if has_action else arguments}".rstrip()
        if not has_action:
            form = form.removeprefix("ACTION ")
        parser = commands.add_parser(
            command.name,
            help=command.help.replace("%", "%%"),
            usage=f"pharos {command.name} {form} [OPTIONS]",
            description=command.help,
            epilog=PARAM if command.name == "param" else CODES,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        if has_action:
            parser.add_argument("action", metavar="ACTION", choices=command.words)
        parser.add_argument("url", metavar="URL", help="as for `pharos shell`")
        parser.add_argument("words", nargs="*", metavar="…", help=argparse.SUPPRESS)
        _add_light_options(parser)
        parser.set_defaults(run=_run_plain, command=command, form=form)


def _add_signing(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    signing = commands.add_parser(
        "signing",
        help="give the light a key, so that it obeys only who signs",
        description=(
            "setup: gives the light the key of --key-file, which is made if there is none;\n"
            "off: takes it away. The link must be marked secure in the light (MAV_SECURE)."
        ),
        epilog="example:\n  pharos signing setup serial:/dev/ttyUSB0 --key-file light.key\n\n"
        + CODES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    signing.add_argument("action", metavar="ACTION", choices=("setup", "off"))
    signing.add_argument("url", metavar="URL", help="as for `pharos shell`")
    _add_light_options(signing)
    signing.set_defaults(run=_run_signing)


def _add_find(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    find = commands.add_parser(
        "find",
        help="lights within reach",
        description="Looks for lights and shows each with the URL that reaches it.",
        epilog=FIND,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    find.add_argument("places", metavar="PLACE", nargs="*", help="where to look")
    find.add_argument("--json", action="store_true", help="one JSON object per line")
    find.add_argument(
        "--seconds", type=_seconds, default=3.0, metavar="S", help="listen so long (default: 3)"
    )
    find.add_argument(
        "--baud", type=_positive, default=57600, metavar="B", help="of serial lines (57600)"
    )
    find.add_argument("-v", "--verbose", action="store_true", help="say which place is not there")
    find.set_defaults(run=_run_find)


def _add_check(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    check = commands.add_parser(
        "check",
        help="look whether a light of any maker keeps to the illuminator protocol",
        description=(
            "Runs the illuminator protocol's requirements on a light, or what DroneCAN or IMC\n"
            "says of a node. The lamp is switched on, at 5 % at most where there is dimming, and\n"
            "is off in the end, over MAVLink with its settings as they were."
        ),
        epilog=CHECK,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    check.add_argument("url", metavar="URL", nargs="?", help="as for `pharos shell`")
    check.add_argument(
        "--profile",
        choices=("mavlink", "dronecan", "imc"),
        default="mavlink",
        help="which protocol's requirements (default: mavlink)",
    )
    check.add_argument(
        "--led", default="lamp", metavar="NAME", help="of --profile imc: its LED (default: lamp)"
    )
    check.add_argument(
        "--only", action="append", default=[], metavar="ID", help="also CF or 'CF-1*'"
    )
    check.add_argument(
        "--skip", action="append", default=[], metavar="ID", help="the same, left out"
    )
    check.add_argument("--explain", metavar="ID", help="why, and what is sent and looked at")
    check.add_argument("--list", action="store_true", help="the requirements")
    check.add_argument("--markdown", action="store_true", help="--list as a page")
    check.add_argument("--junit", metavar="FILE", help="write a report for CI")
    check.add_argument("--html", metavar="FILE", help="write a report for people, one page")
    check.add_argument(
        "--photodiode",
        metavar="CMD",
        help="a program that prints SECONDS LEVEL for each sample, or iio[:FILE]",
    )
    check.add_argument("-v", "--verbose", action="store_true", help="all that was sent and seen")
    _add_light_options(check, 5.0)
    check.set_defaults(run=_run_check)


def _add_update(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    update = commands.add_parser(
        "update",
        help="give lights new firmware, over DroneCAN or MAVLink",
        description="New firmware, verified by the light before it starts it.",
        epilog=UPDATE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    update.add_argument("file", metavar="FILE", help="the image")
    update.add_argument("url", metavar="URL", help="as for `pharos shell`; or several nodes")
    update.add_argument(
        "--via", choices=("dronecan", "mavlink"), help="for dronecan: URLs (default: dronecan)"
    )
    update.add_argument(
        "--force", action="store_true", help="restart even if the lamp is on (mavlink)"
    )
    update.add_argument(
        "--patience",
        type=_seconds,
        default=30.0,
        metavar="S",
        help="how long to wait for what was lost (default: 30)",
    )
    _add_light_options(update)
    update.set_defaults(run=_run_update)


def _add_bus(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("bus", metavar="BUS", nargs="?", default="pharos-udp", help=BUS_HELP)
    parser.add_argument("--fd", action="store_true", default=None, help="CAN FD")
    parser.add_argument("--json", action="store_true", help="one JSON object per line")


def _add_monitor(kinds: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    monitor = kinds.add_parser(
        "monitor",
        help="show what goes over the bus, decoded",
        description="Shows every transfer on the bus, decoded, until Ctrl-C. Sends nothing.",
        epilog="example:\n  pharos can monitor socketcan/can0 --only NodeStatus",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    _add_bus(monitor)
    monitor.add_argument("--frames", action="store_true", help="show each frame as well")
    monitor.add_argument("--only", default="", metavar="TEXT", help="types that contain TEXT")
    monitor.add_argument("--count", type=_positive, metavar="N", help="end after N transfers")
    monitor.add_argument("--seconds", type=_seconds, metavar="S", help="end after S seconds")
    monitor.set_defaults(run=_run_can("run_monitor"))


def _add_nodes(kinds: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    nodes = kinds.add_parser(
        "nodes",
        help="list the nodes on the bus",
        description="Lists every node that is heard, with its health, mode and versions.",
        epilog="example:\n  pharos can nodes pharos-udp --seconds 5\n\n" + CODES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    _add_bus(nodes)
    nodes.add_argument(
        "--seconds", type=_seconds, default=2.5, metavar="S", help="listen so long (default: 2.5)"
    )
    _add_own(nodes)
    nodes.set_defaults(run=_run_can("run_nodes"))


def _add_light(kinds: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    light = kinds.add_parser(
        "light",
        help="command a light as a vehicle without MAVLink does",
        description=(
            "Sends LightsCommand, hardpoint.Command or actuator.ArrayCommand and waits for the\n"
            "light's hardpoint.Status; or MAVLink through the tunnel. The light's parameters\n"
            "CAN_LIGHT_ID, CAN_HARDPT_ID and CAN_ACT_BRT say which ids it follows."
        ),
        epilog="example:\n  pharos can light brightness 40 --bus socketcan/can0\n\n" + CODES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    light.add_argument("action", choices=("on", "off", "brightness"))
    light.add_argument("percent", type=float, nargs="?", metavar="PERCENT")
    light.add_argument("--bus", default="pharos-udp", metavar="BUS", help=BUS_HELP)
    light.add_argument(
        "--via",
        choices=("lights", "hardpoint", "actuator", "tunnel"),
        default="lights",
        help="which message (default: lights)",
    )
    light.add_argument(
        "--id",
        type=int,
        metavar="N",
        help="light, hardpoint or actuator id (default: 254, 0, 9)",
    )
    light.add_argument("--node", type=int, metavar="N", help="the light's node")
    light.add_argument("--fd", action="store_true", help="CAN FD")
    light.add_argument("--json", action="store_true", help="one JSON object per line")
    _add_own(light)
    light.set_defaults(run=_run_can("run_light"))


def _add_own(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--own", type=int, default=126, metavar="N", help="our own node id (default: 126)"
    )


def _add_imc(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    imc = commands.add_parser(
        "imc",
        help="look at an IMC node, or send a message to it",
        description="IMC over any link (see `pharos shell --help`).",
        epilog=(
            "examples:\n"
            "  pharos imc monitor tcp:127.0.0.1:6443 --seconds 5\n"
            "  pharos imc send udp:127.0.0.1:6442 EntityList op=1\n\n" + CODES
        ),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    kinds = imc.add_subparsers(metavar="COMMAND", required=True)
    monitor = kinds.add_parser("monitor", help="show each packet, decoded, until Ctrl-C")
    monitor.add_argument("--count", type=_positive, metavar="N", help="end after N packets")
    monitor.add_argument("--seconds", type=_seconds, metavar="S", help="end after S seconds")
    send = kinds.add_parser("send", help="send one message and show the answers")
    for parser in (monitor, send):
        parser.add_argument("url", metavar="URL", help="where the light is")
        parser.add_argument("--json", action="store_true", help="one JSON object per line")
        parser.add_argument(
            "--own", type=_number, default=0x4001, metavar="ID", help="our id (default: 0x4001)"
        )
    send.add_argument("name", metavar="MESSAGE", help="its name, such as SetLedBrightness")
    send.add_argument("fields", nargs="*", metavar="FIELD=VALUE", help="others are zero or empty")
    send.add_argument(
        "--dst", type=_number, default=0xFFFF, metavar="ID", help="to whom (default: everyone)"
    )
    send.add_argument(
        "--dst-ent", type=_number, default=255, metavar="N", help="entity (default: all)"
    )
    send.add_argument(
        "--seconds", type=_seconds, default=1.0, metavar="S", help="wait so long (default: 1)"
    )
    monitor.set_defaults(run=_run_imc("run_monitor"))
    send.set_defaults(run=_run_imc("run_send"))


# --- arguments ------------------------------------------------------------------------------------
def _seconds(text: str) -> float:
    value = float(text)
    if not 0 < value < 1e6:
        raise ValueError(text)
    return value


_seconds.__name__ = "number of seconds"  # argparse: "invalid number of seconds value: 'x'"


def _positive(text: str) -> int:
    value = int(text)
    if value < 1:
        raise ValueError(text)
    return value


_positive.__name__ = "positive number"


def _number(text: str) -> int:
    value = int(text, 0)
    if not 0 <= value <= 0xFFFF:
        raise ValueError(text)
    return value


_number.__name__ = "number"


def _target(text: str) -> Target:
    system, _, component = text.partition("/")
    target = Target(int(system), int(component))
    if not (1 <= target.system <= 255 and 1 <= target.component <= 255):
        raise ValueError(text)
    return target


_target.__name__ = "SYS/COMP"


# --- running --------------------------------------------------------------------------------------
def _run_can(name: str) -> Callable[[argparse.Namespace, Printer], int]:
    def run(args: argparse.Namespace, printer: Printer) -> int:
        from . import can  # loads all DSDL definitions: only when asked for

        getattr(can, name)(args, printer)
        return OK

    return run


def _run_imc(name: str) -> Callable[[argparse.Namespace, Printer], int]:
    def run(args: argparse.Namespace, printer: Printer) -> int:
        from . import imc

        getattr(imc, name)(args, printer)
        return OK

    return run


def _run_completion(args: argparse.Namespace, printer: Printer) -> int:
    from .completion import shell_code

    print(shell_code(args.shell))
    return OK


def _run_signing(args: argparse.Namespace, printer: Printer) -> int:
    if args.key_file is None:
        raise UsageError("signing: which key? --key-file FILE")
    return run_signing(args, printer)


def _run_find(args: argparse.Namespace, printer: Printer) -> int:
    from .find import run_find

    return run_find(args, printer)


def _run_check(args: argparse.Namespace, printer: Printer) -> int:
    from .check import run_check

    return run_check(args, printer)


def _run_update(args: argparse.Namespace, printer: Printer) -> int:
    from .update import run_update

    return run_update(args, printer)


def _light(args: argparse.Namespace) -> AbstractContextManager[Light]:
    """The light that URL, --target, --timeout and --key-file name."""
    key = read_key(args.key_file)
    return connect(args.url, target=args.target, key=key, timeout_s=args.timeout)


def _run_plain(args: argparse.Namespace, printer: Printer) -> int:
    words = [args.action, *args.words] if args.command.name in WITH_ACTION else args.words
    try:
        line = parse_words(args.command.name, words)
    except UsageError as error:
        # As it is typed here, with a URL.
        if args.command.name in WITH_ACTION:
            raise UsageError(f"{error}, with the URL after the first of these words") from None
        form = f"usage: pharos {args.command.name} {args.form}"
        text = str(error).replace(f"usage: {args.command.usage}", form)
        raise UsageError(text) from None
    with _light(args) as light:
        return Shell(light, printer).run(line)


def _run_shell(args: argparse.Namespace, printer: Printer) -> int:
    lines = None if args.commands is None else parse(args.commands)
    with _light(args) as light:
        shell = Shell(light, printer)
        if lines is not None:
            for line in lines:
                code = shell.run(line)
                if code != OK or shell.is_done:
                    return code
            return OK
        if sys.stdin.isatty() and sys.stdout.isatty():
            from .prompt import Prompt

            return Prompt(shell).run()
        return run_piped(shell)


def run_piped(shell: Shell) -> int:
    """Lines from stdin, each as soon as it is there, up to the first that fails."""
    for number, text in enumerate(sys.stdin, start=1):
        try:
            lines = parse(text)
        except UsageError as error:
            raise UsageError(f"line {number}: {error}") from None
        for line in lines:
            code = shell.run(line)
            if code != OK or shell.is_done:
                return code
    return OK


def pharos_version() -> str:
    try:
        return version("pharos")
    except PackageNotFoundError:
        return "(not installed)"


__all__ = ["USAGE", "main"]


if __name__ == "__main__":
    sys.exit(main())
