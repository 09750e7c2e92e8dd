"""What Python sources import."""
from __future__ import annotations

import ast
import functools
from collections.abc import Iterator
from importlib.util import resolve_name
from pathlib import Path


def statements(nodes: list[ast.stmt]) -> Iterator[ast.stmt]:
    """All statements, those inside functions, classes and branches too."""
    for node in nodes:
        yield node
        for field in "body", "orelse", "finalbody", "handlers", "cases":
            yield from statements(getattr(node, field, []))


@functools.cache
def imported(path: Path, package: str = "") -> list[tuple[str, str]]:
    """The modules that a source imports, at the top or inside functions, and the names that it takes from them. Where no package is
    given, to which relative imports belong, these are left out."""
    found = []
    for node in statements(ast.parse(path.read_text(encoding="utf-8")).body):
        if isinstance(node, ast.Import):
            found += [(alias.name, "") for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and (package or not node.level):
            module = resolve_name("."*node.level + (node.module or ""), package) if node.level else node.module or ""
            found += [(module, alias.name) for alias in node.names]
    return found
