"""The command line: python -m ldbench COMMAND, or ldbench-py COMMAND."""
from __future__ import annotations

import argparse
import sys
from importlib import import_module

from ._core import Error, version

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


def parse(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
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
    args = parse(sys.argv[1:] if arguments is None else arguments)
    try:
        return import_module(f".{args.command}", __package__).main(args)
    except Error as error:
        print(f"ldbench: error: {error}", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"ldbench: error: {error.filename}: {error.strerror}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("ldbench: stopped", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
