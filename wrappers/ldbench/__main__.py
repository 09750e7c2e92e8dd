"""The command line: python -m ldbench COMMAND, or ldbench-py COMMAND."""
from __future__ import annotations

import argparse
import errno
import io
import os
import signal
import sys
import threading
from importlib import import_module
from typing import TYPE_CHECKING, NoReturn

from ._core import Error, version

if TYPE_CHECKING:
    from _typeshed import SupportsWrite

# Each command is a module here with add_arguments(parser) and main(args), which returns the exit status.
COMMANDS = {
    "run": "run a case and write its column file",
    "ensemble": "run a case over many values of its variables, in threads or on a Dask cluster",
    "table": "build or load a contact table, write geometry functions",
    "profile": "look at a wheel or rail profile, or at a pair, before a run",
    "report": "run the ten cases, write columns, plots, abstract and summary",
    "plot": "plot column files",
    "compare": "overlay column files, differences as PDF and CSV",
    "view": "column files as an interactive page, or as a film",
}

UNWRITABLE = errno.EPIPE, errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EBADF

EXAMPLES = """\
examples:
  python -m ldbench run inputs/ex1_aw.nml
  python -m ldbench run --help
"""


class Parser(argparse.ArgumentParser):
    """argparse says nothing where --help or --version cannot be written, and how to use it where words are wrong."""

    def error(self, message: str) -> NoReturn:
        raise Error(f"{message} [{self.prog} --help says more]")

    def _print_message(self, message: str, file: SupportsWrite[str] | None = None) -> None:
        if file is sys.stdout:
            print(message, end="", flush=True)
        else:
            super()._print_message(message, file)


def parse(arguments: list[str]) -> argparse.Namespace:
    parser = Parser(
        prog="ldbench-py", description="A railway wheelset without friction between its flanges.",
        epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--version", action="version", version=f"ldbench {version()}")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name, purpose in COMMANDS.items():
        command = commands.add_parser(name, help=purpose, formatter_class=argparse.RawDescriptionHelpFormatter)
        if name in arguments[:1]:            # the others need not be imported
            module = import_module(f".{name}", __package__)
            command.description, _, command.epilog = (module.__doc__ or "").partition("\n\nexamples:")
            command.epilog = command.epilog and "examples:" + command.epilog
            module.add_arguments(command)
    return parser.parse_args(arguments)


def stop(number: int, frame: object) -> NoReturn:
    """SIGTERM stops a command as Ctrl-C does: workers, executables and scratch files end with it."""
    raise KeyboardInterrupt(number)


def main(arguments: list[str] | None = None) -> int:
    if threading.current_thread() is not threading.main_thread():
        return run_command(arguments)           # the only thread that signals come to is another one
    before = signal.signal(signal.SIGTERM, stop)
    try:
        return run_command(arguments)
    finally:
        signal.signal(signal.SIGTERM, before)


def run_command(arguments: list[str] | None) -> int:
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")       # for what its encoding has no letters
    try:
        if sys.stdout is None:
            raise Error("standard output: expected one that can be written, found it closed")
        args = parse(sys.argv[1:] if arguments is None else arguments)
        command = import_module(f".{args.command}", __package__)
        status = command.main(args)
        sys.stdout.flush()
        return status
    except Error as error:
        reason = str(error)
    except OSError as error:
        words = error.strerror or str(error)
        reason = f"{error.filename}: {words}" if error.filename else words
        if error.errno in UNWRITABLE and not error.filename:
            reason = f"standard output: {words}"
            os.dup2(os.open(os.devnull, os.O_WRONLY), 1)    # what it still holds cannot be written at the end either
    except MemoryError:
        reason = "expected more memory, found none left"
    except KeyboardInterrupt as stopped:
        tell("ldbench: stopped")
        return 128 + int(*stopped.args or (signal.SIGINT,))
    tell(f"ldbench: error: {' '.join(reason.split())}")
    return 1


def tell(words: str) -> None:
    """On standard error, if it is open."""
    if sys.stderr is not None:
        print(words, file=sys.stderr)


if __name__ == "__main__":
    sys.exit(main())
