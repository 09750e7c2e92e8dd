"""The command line: `ldbench COMMAND` or `python -m ldbench COMMAND`. Status 0: done; 1: refused or not all done; 2: usage."""
from __future__ import annotations

import argparse
import difflib
import errno
import io
import json
import os
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from ._core import leave
from ._core.calls import version
from ._core.errors import Error, Usage
from ._core.optional import needed
from .commands import COMMANDS, module_of
from .commands.options import add_loudness, spoken, tell_next

if TYPE_CHECKING:
    from _typeshed import SupportsWrite

PROGRAM = "ldbench" if Path(sys.argv[0]).name == "ldbench" else "python -m ldbench"      # as it was called
NAMELIST = ".nml"       # ending of files that are cases, whether they are there or not
SHELLS = "bash", "zsh", "tcsh"
UNWRITABLE = errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EBADF

EXAMPLES = """\
examples:
  python -m ldbench run inputs/ex1_aw.nml
  python -m ldbench run --help
"""


def as_called(words: str) -> str:
    """Words of help and messages, in which commands are named as this one was called."""
    return re.sub(r"python -m ldbench(?= [a-z-])|(?<=`)ldbench(?= [a-z-])", PROGRAM, words)


class Parser(argparse.ArgumentParser):
    """argparse with errors in one line, which name what is nearest to a word that is wrong."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.known: tuple[str, ...] = ()        # words that the command line may hold
        self.commands: dict[str, Parser] = {}   # that are made in full

    def error(self, message: str) -> NoReturn:
        """Raise Usage with the message of argparse."""
        wrong = re.search(r"unrecognized arguments: (--?\w+)|invalid choice: '(\w+)'", message)
        near = difflib.get_close_matches(wrong[1] or wrong[2], self.known, 1) if wrong else []
        meant = f"; {near[0]} is the nearest" if near else ""
        raise Usage(f"{message}{meant} [{self.prog} --help says more]")

    def _print_message(self, message: str, file: SupportsWrite[str] | None = None) -> None:
        if file is sys.stdout:
            print(message, end="", flush=True)
        else:
            super()._print_message(message, file)


class Completion(argparse.Action):
    """Print what a shell needs to complete commands, options and names of files, by the package shtab."""

    def __call__(self, parser: argparse.ArgumentParser, *arguments: Any) -> NoReturn:
        """Print the script of a shell for the whole command line."""
        shtab = needed("shtab", "completion")
        whole = make_parser(COMMANDS, "ldbench")
        for command in whole.commands.values():
            for action in command._actions:
                if re.search("FILE|FOLDER|NAMELIST|PROFILE|TOML|DIR", str(action.metavar)):
                    action.complete = shtab.FILE        # type: ignore[attr-defined]
        print(shtab.complete(whole, shell=arguments[1]), flush=True)
        parser.exit()


def make_parser(chosen: Iterable[str], program: str = "") -> Parser:
    """The parser of the command line, with all arguments of the chosen commands; the modules of the others are not imported."""
    parser = Parser(
        prog=program or PROGRAM, description="Simulates a frictionless railway wheelset on two rails.",
        epilog=as_called(EXAMPLES), formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--version", action="version", version=f"ldbench {version()}")
    parser.add_argument("--completion", action=Completion, choices=SHELLS, metavar="SHELL",
                        help=f"print the completion of commands and options for {', '.join(SHELLS)}")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name, purpose in COMMANDS.items():
        command = commands.add_parser(name, help=purpose, formatter_class=argparse.RawDescriptionHelpFormatter)
        if name in chosen:
            module = module_of(name)
            command.description, _, command.epilog = (module.__doc__ or "").partition("\n\nexamples:")
            command.epilog = command.epilog and as_called("examples:" + command.epilog)
            module.add_arguments(command)
            add_loudness(command)
            parser.commands[name] = command
            parser.known += tuple(word for action in command._actions for word in action.option_strings)
    parser.known = parser.known or tuple(COMMANDS)
    return parser


def stop(number: int, frame: object) -> NoReturn:
    """SIGTERM stops a command as Ctrl-C does: workers and scratch files end with it."""
    raise KeyboardInterrupt(number)


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return the exit status; SIGTERM stops it as Ctrl-C does."""
    if threading.current_thread() is not threading.main_thread():
        return run_command(arguments)           # the only thread that signals come to is another one
    before = signal.signal(signal.SIGTERM, stop)
    if signal.getsignal(signal.SIGINT) is leave:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        return run_command(arguments)
    finally:
        signal.signal(signal.SIGTERM, before)


def run_command(arguments: list[str] | None) -> int:
    """Run the command line and return the exit status; report every failure in one line."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")       # for what its encoding has no letters
    given = sys.argv[1:] if arguments is None else arguments
    status = 1
    try:
        if sys.stderr is None:          # closed; no file that is opened later shall get its number
            sys.stderr = open(os.devnull, "w")      # noqa: SIM115
        if sys.stdout is None:
            raise Error(place="standard output", expected="one that can be written", found="it closed")
        if given and given[0] not in COMMANDS and (given[0].lower().endswith(NAMELIST) or Path(given[0]).is_file()):
            given = ["run", *given]
        args = make_parser(given[:1]).parse_args(given)
        with spoken(args):
            ended = module_of(args.command).main(args)
            if not ended:
                tell_next(args, as_called)
            sys.stdout.flush()
        return ended
    except Error as error:
        reason, status = as_called(str(error)), 2 if isinstance(error, Usage) else 1
    except BrokenPipeError:
        discard_output()
        return 128 + 13     # as the shell says of SIGPIPE
    except OSError as error:
        words = error.strerror or str(error)
        reason = str(Error(words, file=error.filename))
        if error.errno in UNWRITABLE and not error.filename:
            reason = f"standard output: {words}"
            discard_output()
    except MemoryError:
        reason = "the memory is used up; give fewer files or runs at once"
    except KeyboardInterrupt as stopped:
        print("ldbench: stopped", file=sys.stderr)
        return 128 + int(*stopped.args or (signal.SIGINT,))
    if asks_for_json(given) and sys.stdout:
        with suppress(OSError):     # the reader has gone, or the disk is full
            print(json.dumps({"error": reason}, ensure_ascii=False), flush=True)
    print(f"ldbench: error: {reason}", file=sys.stderr)
    return status


def asks_for_json(given: list[str]) -> bool:
    """Whether a command line asks for JSON on standard output; of some commands, --json has the name of a file."""
    if "--json" not in given or given[0] not in COMMANDS:
        return False
    option = make_parser(given[:1]).commands[given[0]]._option_string_actions.get("--json")
    return option is not None and option.nargs == 0


def program() -> int:
    """The command `ldbench` that pip installs. What has words is for this module. A namelist on standard input is for the
    executable beside the extension."""
    if sys.argv[1:]:
        return main()
    command = [str(Path(__file__).parent/"_core/ldbench")]
    if os.name != "nt":         # there os.execv would not wait for what it starts
        os.execv(command[0], command)
    return subprocess.call(command)


def discard_output() -> None:
    """Discard the buffer of standard output, which cannot be written at the end of the process either."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)


if __name__ == "__main__":
    sys.exit(main())
