"""The command line: python -m ldbench COMMAND, or ldbench-py COMMAND."""
from __future__ import annotations

import argparse
import os
import sys
from importlib import import_module
from typing import TYPE_CHECKING

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

EXAMPLES = """\
examples:
  python -m ldbench run inputs/ex1_aw.nml
  python -m ldbench run --help
"""


class Parser(argparse.ArgumentParser):
    """argparse says nothing where --help or --version cannot be written."""

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


def main(arguments: list[str] | None = None) -> int:
    try:
        args = parse(sys.argv[1:] if arguments is None else arguments)
        status = import_module(f".{args.command}", __package__).main(args)
        sys.stdout.flush()
        return status
    except Error as error:
        reason = str(error)
    except OSError as error:
        reason = f"{error.filename or 'standard output'}: {error.strerror or error}"
        if error.filename is None:      # what it still holds cannot be written at the end either
            os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    except MemoryError:
        reason = "expected more memory, found none left"
    except KeyboardInterrupt:
        print("ldbench: stopped", file=sys.stderr)
        return 130
    print(f"ldbench: error: {' '.join(reason.split())}", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
