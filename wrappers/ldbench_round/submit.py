"""What a participant sends: ten column files, the PDF of plots, the abstract and `submission.toml`, in a folder or a zip.

The list of checksums in it tells what `submit` has written: a folder or a zip without one, or with other contents than it lists, is
somebody's own and is never replaced.
"""
from __future__ import annotations

import io
import re
import shutil
import tempfile
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pypdf import PdfReader

from ldbench import Error
from ldbench.constants import DESCRIPTION
from ldbench.tools import complete, digest

from .check import check_file
from .findings import FAILED
from .submissions import (
    MAP,
    complaint,
    find_files,
    is_file,
    read_small_toml,
    told_facts,
    told_map,
    told_seconds,
    without,
)
from .tasks import TASKS

SUMS = "SHA256SUMS"         # as sha256sum reads it
ZIP = ".zip"
LONGEST_ABSTRACT = 4        # pages, by the call
OLDEST = (1980, 1, 1, 0, 0, 0)      # the time of all files in a zip, so that equal contents have equal bytes

#: The keys of `submission.toml` that a participant has to give, with an example.
REQUIRED = {"code": '"Contura"', "version": '"3.2"', "authors": '["A. Author", "B. Author"]', "organisation": '"Institute, Town"',
            "email": '"a.author@institute.org"', "formulation": '"elastic"'}
EMAIL = re.compile(r"[^@\s,;<>]+@[^@\s,;<>]+\.[A-Za-z]{2,}")
#: The PDFs of the call: the key that names one, what a name without that key has in it, and what it is.
PDFS = {"plots": ("plot", "the PDF of plots"), "abstract": ("abstract", "the abstract")}


@dataclass(frozen=True)
class Parcel:
    """What is sent."""

    files: Mapping[str, Path] = field(default_factory=dict)     # by the name in the parcel
    missing: tuple[str, ...] = ()                               # a line each: what is missing or refused


def write_template(folder: Path) -> Path:
    """Write `submission.toml` with all keys that are needed, each a comment that is to be filled in; Error where it is there."""
    target = folder/DESCRIPTION
    if target.exists():
        raise Error(file=target, expected="no such file", found="one", advice="it is not replaced")
    with complete(target) as scratch:
        scratch.write_text("# What a participant tells of the code. Take the # away and fill in what is yours.\n"
                           + "".join(f"# {key} = {example}\n" for key, example in REQUIRED.items()))
    return target


def gather(folder: Path) -> Parcel:
    """What a folder has of a submission, and what it lacks."""
    if not folder.is_dir():
        raise Error(file=folder, expected="a folder with the files of a submission", found="a file" if folder.exists() else "none")
    missing: list[str] = []
    told = described(folder, missing)
    files = {DESCRIPTION: folder/DESCRIPTION} if told is not None else {}
    known = told or {}
    map = told_map(known, folder, missing)
    if isinstance(known.get(MAP), str) and map is not None:
        files[known[MAP]] = folder/known[MAP]
    remarks: list[str] = []
    found = find_files(folder, remarks)
    missing += [line for line in remarks if "expected one file" in line]
    for task in TASKS:
        if task not in found:
            missing.append(f"{task.name}: expected the column file of {task.words}, such as {task.name}.txt, found none")
            continue
        file = found[task]
        files[f"{task.name}{file.suffix.lower()}"] = file
        try:
            findings = check_file(file, task, map).findings
        except Exception as error:      # whatever a file holds, the others are judged, too
            missing.append(complaint(error, file))
            continue
        missing += [f"{file.name}: `check` refuses it: {one.what}{f': {one.hint}' if one.hint else ''}"
                    for one in findings if one.verdict == FAILED]
    for key, (part, words) in PDFS.items():
        pdf = pdf_of(folder, known.get(key), key, part, words, missing)
        if pdf:
            files[f"{key}.pdf"] = pdf
    return Parcel(files, tuple(missing))


def described(folder: Path, missing: list[str]) -> dict[str, Any] | None:
    """What `submission.toml` says; None without the file. Every key that is missing or wrong is a line."""
    wanted = ", ".join(REQUIRED)
    if not (folder/DESCRIPTION).exists():
        missing.append(f"{DESCRIPTION}: expected a file with the keys {wanted}, found none")
        return None
    try:
        told = read_small_toml(folder/DESCRIPTION)
        missing += [f"{DESCRIPTION}: expected {key} = {example}, found none" for key, example in REQUIRED.items()
                    if not told.get(key)]
        list(told_facts(told, missing))
        list(told_seconds(told, missing))
        if (given := told.get("email")) and not (isinstance(given, str) and EMAIL.fullmatch(given)):
            missing.append(f"{DESCRIPTION}: email: expected one address as {REQUIRED['email']}, found {given!r}")
        if (given := told.get("organisation")) and not isinstance(given, str):
            missing.append(f"{DESCRIPTION}: organisation: expected a text as {REQUIRED['organisation']}, found {given!r}")
    except (Error, ValueError) as error:
        missing.append(without(f"{DESCRIPTION}: {error}" if not isinstance(error, Error) else str(error), folder))
        return None
    return told


def pdf_of(folder: Path, named: object, key: str, part: str, words: str, missing: list[str]) -> Path | None:
    """The PDF that a key of the description names, or the one whose name has a word in it."""
    if named is not None:
        path = folder/str(named)
        if not (isinstance(named, str) and is_file(path) and path.resolve().is_relative_to(folder.resolve())):
            missing.append(f"{DESCRIPTION}: {key}: expected {words}, a file of the folder, found {named!r}")
            return None
    else:
        found = sorted(path for path in folder.glob("*") if path.suffix.lower() == ".pdf" and part in path.name.lower())
        if len(found) != 1:
            names = ", ".join(path.name for path in found) or "none"
            missing.append(f"expected {words}, one file *{part}*.pdf, or {key} = \"FILE.pdf\" in {DESCRIPTION}, found {names}")
            return None
        path = found[0]
    try:
        pages = len(PdfReader(path).pages)
    except Exception:           # pypdf raises what it likes of a file that is no PDF
        missing.append(f"{path.name}: expected a PDF, found a file that cannot be read as one")
        return None
    if not pages or (key == "abstract" and pages > LONGEST_ABSTRACT):
        most = f"at most {LONGEST_ABSTRACT} pages" if pages else "pages"
        missing.append(f"{path.name}: expected {most}, found {pages}")
    return path


def send(parcel: Parcel, target: Path) -> list[str]:
    """Write a parcel that lacks nothing, and the list of its checksums; the names of its files. Error where something is at the
    target that `submit` has not written."""
    contents = {name: file.read_bytes() for name, file in sorted(parcel.files.items())}
    contents[SUMS] = "".join(f"{digest(data)}  {name}\n" for name, data in contents.items()).encode()
    check_own(target)
    if target.suffix.lower() == ZIP:
        with complete(target) as scratch, zipfile.ZipFile(scratch, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, data in contents.items():
                archive.writestr(zipfile.ZipInfo(f"{target.stem}/{name}", OLDEST), data, zipfile.ZIP_DEFLATED)
        return list(contents)
    target.parent.mkdir(parents=True, exist_ok=True)
    scratch = Path(tempfile.mkdtemp(prefix=f".{target.name}.ldbench-part", dir=target.parent))
    try:
        for name, data in contents.items():
            (scratch/name).parent.mkdir(parents=True, exist_ok=True)
            (scratch/name).write_bytes(data)
        scratch.chmod(0o755)
        if target.exists():
            shutil.rmtree(target)
        scratch.rename(target)
    except OSError as error:
        raise Error(f"cannot be written completely: {error.strerror or error}", file=target) from None
    finally:
        shutil.rmtree(scratch, ignore_errors=True)      # is gone where all went well
    return list(contents)


def check_own(target: Path) -> None:
    """Error where a folder or a zip is there that `submit` has not written just so."""
    if target.suffix.lower() == ZIP:
        if not target.exists():
            return
        found = contents_of_zip(target) if target.is_file() else {}
    else:
        if not target.exists() or (target.is_dir() and not any(target.iterdir())):
            return
        found = {str(path.relative_to(target)): path.read_bytes() for path in target.rglob("*")
                 if not path.is_dir()} if target.is_dir() else {}
    sums = found.pop(SUMS, b"").decode(errors="replace")
    if not sums or sums != "".join(f"{digest(data)}  {name}\n" for name, data in sorted(found.items())):
        raise Error(file=target, expected="no file or folder, or what `ldbench submit` has written", found="something else",
                    advice="name another one after -o")


def contents_of_zip(file: Path) -> dict[str, bytes]:
    """The files of a zip without their folder; none where it is no zip."""
    try:
        with zipfile.ZipFile(io.BytesIO(file.read_bytes())) as archive:
            return {name.partition("/")[2]: archive.read(name) for name in archive.namelist()}
    except zipfile.BadZipFile:
        return {}
