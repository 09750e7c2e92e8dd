"""The pages of the documentation: their blocks that are marked as run, the links in them.

A block is marked by a comment in the line before its fence:

    <!-- run -->                    commands after `$ ` with what they print, or a Python program
    <!-- output -->                 what the Python program before it prints
    <!-- file: other_code.toml -->  a file that the blocks after it read

The blocks of a page run in order, in one folder with the shipped inputs and profiles. In the output that a page shows,
`...` stands for anything, also for any number of lines.

    python tests/support/documents.py docs/input.md       writes into the pages what their commands print today
"""
from __future__ import annotations

import io
import math
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import traceback
from collections.abc import Callable, Mapping
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import NamedTuple

import pytest

from golden import shipped_run
from ldbench.__main__ import main
from running import HANG, LDBENCH, REPO, kept_tables

PAGES = [REPO/"README.md", *sorted((REPO/"docs").glob("*.md")), REPO/"profiles/README.md"]
BLOCK = re.compile(r"<!-- (?P<kind>run|output|file: \S+) -->\n+```(?P<language>\w+)\n(?P<text>.*?)^```$", re.DOTALL | re.MULTILINE)
COMMAND = re.compile(r"^\$ ((?:.*\\\n)*.*\n)((?:(?!\$ ).*\n)*)", re.MULTILINE)        # with what is shown after it
NUMBER = re.compile(r"[-+]?(?:\d+\.\d*|\.\d+|\d+)(?:[eE][-+]?\d+)?")
LINK = re.compile(r"(?<!`)\]\(<?([^)\s>]+)>?\)")
CLOSE = 1e-4            # relative difference of numbers that another processor may make, besides one of the last digit shown
ROUNDING = 1e-6         # below it numbers are rounding errors, which depend on the compiler


class Shown(NamedTuple):
    """What a page says that a command prints, and what it prints."""

    command: str
    expected: str
    found: str
    status: int
    span: tuple[int, int] = (0, 0)      # of the expected text in the page

    @property
    def fits(self) -> bool:
        return self.status == 0 and alike(self.expected, self.found)


def blocks(page: Path) -> list[re.Match[str]]:
    """The marked blocks of a page."""
    return list(BLOCK.finditer(page.read_text()))


def prepare(folder: Path) -> None:
    """Put the files there that pages begin with: two runs. Contact tables are the kept ones."""
    for name in "inputs", "profiles":
        shutil.copytree(REPO/name, folder/name)
    (folder/"outputs").mkdir()
    (folder/"outputs/tables").symlink_to(kept_tables())
    for case in "ex1_aw", "ex2_aw":
        shutil.copy(shipped_run(case).file, folder/"outputs")


def run_page(page: Path, prepared: Path, folder: Path, shorter: Mapping[str, str] | None = None) -> list[Shown]:
    """Run the blocks of a page in a folder with copies of the prepared files. Python programs, each of which goes on where the one
    before ended, and commands of the package run in this process. `shorter` has words of commands and what replaces them."""
    shutil.copytree(prepared, folder, symlinks=True)
    (folder/"ldbench").symlink_to(LDBENCH)
    found, names, last = [], {"__name__": "__main__"}, ""
    path = f"{Path(sys.executable).parent}:/usr/local/bin:/usr/bin:/bin"
    with pytest.MonkeyPatch.context() as place:
        place.chdir(folder)
        for name, value in ("PATH", path), ("MPLBACKEND", "agg"), ("COLUMNS", "100"):
            place.setenv(name, value)
        for block in blocks(page):
            text, start = block["text"], block.start("text")
            if block["kind"].startswith("file: "):
                Path(block["kind"].removeprefix("file: ")).write_text(text)
            elif block["language"] == "python":
                status, last = here(lambda text=text: exec(compile(text, page.name, "exec"), names))
                found.append(Shown(text, "...", last, status))
            elif block["kind"] == "output":
                found.append(Shown("output of the program before", text, last, 0, block.span("text")))
            else:
                for one in COMMAND.finditer(text):
                    command = one[1]
                    for known, less in (shorter or {}).items():
                        command = command.replace(known, less)
                    status, said = run_command(command)
                    found.append(Shown(one[1], one[2] or "...", said, status, (start + one.start(2), start + one.end(2))))
    return found


def run_command(command: str) -> tuple[int, str]:
    """Status and output of a command of the shell."""
    words = shlex.split(command.replace("\\\n", " "))
    if words[:3] == ["python", "-m", "ldbench"] and not set(command) & set("|<>;&*"):
        return here(lambda: main(words[3:]))
    done = subprocess.run(["bash", "-c", command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=HANG)
    return done.returncode, done.stdout


def here(call: Callable[[], object]) -> tuple[int, str]:
    """Status and output of a call in this process."""
    said = io.StringIO()
    with redirect_stdout(said), redirect_stderr(said):
        try:
            status = call() or 0
        except SystemExit as end:
            status = end.code or 0
        except Exception:
            traceback.print_exc()
            status = 1
    return status, said.getvalue()


def alike(expected: str, found: str) -> bool:
    """Whether a program prints what a page shows: words exactly, numbers nearly."""
    pattern, shown = "", []
    for part in re.split(f"({NUMBER.pattern}|\\.\\.\\.|\\s+)", expected.strip()):
        if part == "...":
            pattern += r"(?:.|\n)*?"
        elif NUMBER.fullmatch(part):
            pattern += f"({NUMBER.pattern})"
            shown.append(part)
        else:
            pattern += r"\s+" if part.isspace() else re.escape(part)
    match = re.fullmatch(pattern, found.strip())
    return match is not None and all(map(near, shown, match.groups()))


def near(shown: str, found: str) -> bool:
    """Whether a number differs by no more than another processor makes it differ."""
    x, y = float(shown), float(found)
    mantissa, _, exponent = shown.lower().partition("e")
    digit = 10.0**(int(exponent or 0) - len(mantissa.partition(".")[2]))
    return math.isclose(x, y, rel_tol=CLOSE, abs_tol=1.01*digit) or max(abs(x), abs(y)) < ROUNDING


def links(page: Path) -> list[str]:
    """The links of a page to files of the repository, without those in code."""
    text = re.sub(r"^```.*?^```$|`[^`\n]*`", "", page.read_text(), flags=re.DOTALL | re.MULTILINE)
    return [link for link in LINK.findall(text) if not re.match(r"[a-z]+:|#", link)]


def update(page: Path) -> None:
    """Write into a page what its commands print where it shows something else, and say which fail."""
    text = page.read_text()
    with tempfile.TemporaryDirectory() as temporary:
        prepare(Path(temporary)/"prepared")
        for shown in reversed(run_page(page, Path(temporary)/"prepared", Path(temporary)/"page")):
            if shown.status:
                print(f"status {shown.status}: {shown.command}\n{shown.found}", file=sys.stderr)
            if shown.expected != "..." and not shown.fits:
                text = text[:shown.span[0]] + shown.found.strip() + "\n" + text[shown.span[1]:]
    page.write_text(text)


if __name__ == "__main__":
    for name in sys.argv[1:] or PAGES:
        update(Path(name).resolve())
