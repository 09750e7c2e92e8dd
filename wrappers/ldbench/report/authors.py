"""Authors of the abstract, from a small TOML file."""
from __future__ import annotations

from pathlib import Path
from typing import Any

from .._core.errors import Error
from ..results.columns import read_toml

FILE = "authors.toml"
KEYS = "name", "affiliation"


def read_authors(file: Path) -> list[dict[str, str]]:
    """Name and affiliation of every author; none where the file does not exist.

        [[author]]
        name = "A. Author"
        affiliation = "Institute, Town"     # may be left out
    """
    if not file.exists():
        return []
    told = read_toml(file)
    authors = told.get("author", [])
    if strange := [key for key in told if key != "author"]:
        raise Error(f"{file}, {strange[0]}: expected tables [[author]] alone, found another name. Remove it")
    if not isinstance(authors, list) or not all(isinstance(author, dict) for author in authors):
        kind = type(authors).__name__
        raise Error(f"{file}, author: expected tables [[author]], found {kind}. Write the name in double brackets")
    return [checked(file, author) for author in authors]


def checked(file: Path, author: dict[str, Any]) -> dict[str, str]:
    """An author with all keys; Error where one is unknown, of another type, or the name is missing."""
    for key, value in author.items():
        if key not in KEYS or not isinstance(value, str) or not value.strip():
            raise Error(f"{file}, author, {key}: expected a text for {' or '.join(KEYS)}, found {value!r}. Correct the file")
    if "name" not in author:
        raise Error(f"{file}, author: expected a name, found none. Add name = \"...\"")
    return {key: str(author.get(key, "")).strip() for key in KEYS}
