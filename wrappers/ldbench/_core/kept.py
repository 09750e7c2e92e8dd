"""Results that are kept to save time: whether they are what this program would make again."""
from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from .files import LOG, complete, digest

KEPT = ".ldbench"         # the folder, beside results, of what saves time
PACKAGE = Path(__file__).resolve().parents[1]


@cache
def program_digest(package: Path = PACKAGE) -> str:
    """The digest of all that makes a result: each file of ldbench, its compiled core included, and of a package on top of it."""
    told = (f"{file.relative_to(folder)} {digest(file.read_bytes())}\n"
            for folder in dict.fromkeys((PACKAGE, package)) for file in files_of(folder))
    return digest("".join(told).encode())


def files_of(package: Path) -> list[Path]:
    """The files of a package, without what Python keeps of its own."""
    return sorted(file for file in package.rglob("*") if file.is_file() and "__pycache__" not in file.parts)


def hashes(files: Sequence[Path], root: Path) -> dict[str, str]:
    """Hash of each file, '' of one that is missing."""
    return {inside(file, root): digest(file.read_bytes()) if file.is_file() else "" for file in files}


def inside(path: Path, root: Path) -> str:
    """A path as a namelist in `root` would say it."""
    try:
        return str(path.resolve().relative_to(root.resolve()))
    except ValueError:
        return str(path.resolve())


def kept_in(folder: Path) -> Path:
    """The folder of what is kept beside the results in a folder; it may be that folder itself."""
    return folder if folder.name == KEPT else folder/KEPT


def stamp_of(product: Path) -> Path:
    """The path of the stamp of a product: the digests of the program, of the files that it was made from, and of the product."""
    return kept_in(product.parent)/f"{product.name}.stamp"


def is_up_to_date(product: Path, sources: Mapping[str, str]) -> bool:
    """Whether a product is there, untouched, and made by this program from just these sources."""
    try:
        before, now = dict(json.loads(stamp_of(product).read_text())), stamp(product, sources)
    except (OSError, ValueError, TypeError):
        LOG.info("%s: is missing, or was not kept", product)
        return False
    if changed := [what for what in now if before.get(what) != now[what]]:
        LOG.info("%s: has another %s than before", product, " and other ".join(changed))
    return not changed


def stamped(product: Path, root: Path) -> dict[str, str]:
    """What `hashes` would say of a product that is up to date, by its stamp."""
    return {inside(product, root): json.loads(stamp_of(product).read_text())["product"]}


def write_stamp(product: Path, sources: Mapping[str, str]) -> None:
    """Write the stamp of a product that was made from these sources."""
    stamp_of(product).parent.mkdir(exist_ok=True)
    with complete(stamp_of(product)) as scratch:
        scratch.write_text(json.dumps(stamp(product, sources), indent=1) + "\n")


def kept_json(product: Path, sources: Mapping[str, str], force: bool, make: Callable[[], Any]) -> Any:
    """What a JSON file keeps, made anew where it is not up to date."""
    if not force and is_up_to_date(product, sources):
        return json.loads(product.read_text())
    found = make()
    product.parent.mkdir(parents=True, exist_ok=True)
    with complete(product) as scratch:
        scratch.write_text(json.dumps(found))
    write_stamp(product, sources)
    return found


def stamp(product: Path, sources: Mapping[str, str]) -> dict[str, object]:
    """What the stamp of a product says."""
    return {"program": program_digest(), "sources": dict(sources), "product": digest(product.read_bytes())}
