"""The boundary to the Fortran core: calls, errors, files that are written whole, threads and processes."""
import os
import signal
import sys
from contextlib import suppress


def leave(number: int, frame: object) -> None:
    """End `python -m ldbench` at once by Ctrl-C while it imports its modules; `main` catches Ctrl-C from then on."""
    with suppress(OSError):
        os.write(2, b"ldbench: stopped\n")
    os._exit(128 + number)


if sys.argv[:1] == ["-m"] and "ldbench" in sys.orig_argv and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
    signal.signal(signal.SIGINT, leave)

from ._flat import flat as flat  # noqa: E402  # the handler of Ctrl-C comes first
