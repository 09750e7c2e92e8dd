"""The rooms of the Python package: each uses itself and those before it alone, as `make lint` holds it for the core."""
from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import ldbench
from running import REPO

SOURCES = {path.stem: path for path in (REPO/"fortran").rglob("*.f90")}


def test_modules_and_procedures_are_of_a_size_to_hold_in_the_head():
    """No module above 500 lines, no procedure above 120, those within it included."""
    start = re.compile(r"^ *(?!end)(?:\w+(?:\([^)]*\))? +)*(?:subroutine|function) +(\w+)")
    for path in SOURCES.values():
        lines = path.read_text().splitlines()
        assert len(lines) <= 500, path
        stack = []
        for k, line in enumerate(lines):
            if found := start.match(line):
                stack.append((found[1], k))
            elif re.match(r"^ *end (?:subroutine|function)", line):
                name, first = stack.pop()
                assert k - first < 120, (path, name)


TOP = set(".ci .github .gitignore CHANGELOG.md CITATION.cff LICENSE Makefile README.md bootstrap docs fortran inputs meson.build "
          "meson.options outputs profiles pyproject.toml requirements.txt tests wrappers".split())


def test_the_repository_holds_what_belongs_there():
    """No log of a build, no scratch file: a new file in the top folder has to be put into this list, too."""
    if not (REPO/".git").exists():
        pytest.skip("this is no clone of the repository")
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=REPO, capture_output=True, text=True, check=True).stdout.split("\0")
    assert {name.partition("/")[0] for name in listed if name} <= TOP
    assert [name for name in listed if name.endswith((".log", ".orig", ".rej", ".pyc", ".o", ".mod"))] == []


PACKAGE = Path(ldbench.__file__).parent
ROOMS = ("_core", "tools", "case", "conicity", "pressure", "profiles", "table", "results", "geometry", "plots", "profile", "viewer",
         "runs", "ensembles", "report", "commands", "__main__")
# Whatever stands for the whole package, to which no room belongs.
PYTHON = {path: ".".join(path.relative_to(PACKAGE).with_suffix("").parts) for path in sorted(PACKAGE.rglob("*.py"))
          if path != PACKAGE/"__init__.py"}


def module_of(path: Path) -> str:
    """The dotted name of a module inside the package; of a folder, the folder's."""
    return PYTHON[path].removesuffix(".__init__")


MODULES = {module_of(path) for path in PYTHON} | {"_core._flat"}


def is_for_types(node: ast.AST) -> bool:
    return isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"


def imports(path: Path, for_types: bool) -> set[str]:
    """The modules of the package that a module imports, at the top or inside functions; with those that only types need."""
    found: set[str] = set()

    def walk(node: ast.AST) -> None:
        if is_for_types(node) and not for_types:
            for other in node.orelse:
                walk(other)
            return
        if isinstance(node, ast.ImportFrom):
            place = list(path.relative_to(PACKAGE).parent.parts)
            if node.level:
                base = ["ldbench", *place[:len(place) - node.level + 1]]
                assert len(place) >= node.level - 1, (path, node.lineno)
            else:
                base = []
            base += node.module.split(".") if node.module else []
            if base[:1] == ["ldbench"]:
                take(base[1:], [alias.name for alias in node.names])
        elif isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name.partition(".")[0] == "ldbench":
                    take(alias.name.split(".")[1:], [])
        for child in ast.iter_child_nodes(node):
            walk(child)

    def take(base: list[str], names: list[str]) -> None:
        """What `from base import names` reads: modules among the names, else the module of that name."""
        for name in names or [""]:
            inner = ".".join([*base, name]) if name else ".".join(base)
            found.add(inner if inner in MODULES else ".".join(base))

    walk(ast.parse(path.read_text(encoding="utf-8")))
    return found


def room(module: str) -> str:
    return module.partition(".")[0]


@pytest.mark.parametrize("for_types", [False, True], ids=["at run time", "types too"])
def test_rooms_use_each_other_in_one_order(for_types: bool):
    """Imports inside functions count as well, and so do those that only types need."""
    used = {(module_of(path), other) for path in PYTHON for other in imports(path, for_types)}
    whole = [(module, other) for module, other in used if not other]
    assert whole == [], "a module that imports the package itself"
    assert {room(other) for _, other in used} <= set(ROOMS)
    between = {(room(module), room(other)) for module, other in used if room(module) != room(other)}
    assert len(between) > 25
    wrong = sorted((module, other) for module, other in used if ROOMS.index(room(other)) > ROOMS.index(room(module)))
    assert wrong == []


ROUND = PACKAGE.with_name("ldbench_round")
DISPATCH = PACKAGE/"commands/__init__.py"
ON_TOP = (REPO/"docs/python.md").read_text(encoding="utf-8").partition("## Packages on top of ldbench")[2]
PUBLIC = {"ldbench", *re.findall(r"`(ldbench\.[a-z_.]+)`", ON_TOP)}


def names_imported(tree: ast.AST) -> Iterator[tuple[str, str]]:
    """The modules that are imported by their whole names, and the names that are taken from them."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and not node.level:
            yield from ((node.module or "", alias.name) for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from ((alias.name, "") for alias in node.names)


def private(tree: ast.AST) -> list[tuple[str, str]]:
    """The imports of ldbench that docs/python.md does not list."""
    return [(module, name) for module, name in names_imported(tree) if module.partition(".")[0] == "ldbench" and not (
        f"{module}.{name}" in PUBLIC or (module in PUBLIC and (
            name in (*ldbench.__all__, "__version__") if module == "ldbench" else name and not name.startswith("_"))))]


def test_a_round_uses_public_names_alone():
    trees = {path: ast.parse(path.read_text(encoding="utf-8")) for path in ROUND.rglob("*.py")}
    assert {path.relative_to(ROUND): wrong for path, tree in trees.items() if (wrong := private(tree))} == {}
    used = {module for tree in trees.values() for module, _ in names_imported(tree)} | {
        f"{module}.{name}" for tree in trees.values() for module, name in names_imported(tree)}
    assert used >= PUBLIC, "a public module that nothing on top uses"


def test_the_package_does_not_know_a_round():
    """Neither by an import nor by a name in a text, besides the dispatch of commands."""
    knowing = {path for path in PACKAGE.rglob("*.py") if any(
        (isinstance(node, ast.Constant) and isinstance(node.value, str) and "ldbench_round" in node.value)
        or (isinstance(node, ast.Import | ast.ImportFrom) and "ldbench_round" in ast.unparse(node))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))))}
    assert knowing == {DISPATCH}


def test_the_package_is_imported_without_what_only_some_need():
    """matplotlib, pandas and the like take longer than a short run."""
    script = "import sys, ldbench; print(*sorted({name.partition('.')[0] for name in sys.modules}))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert not {"matplotlib", "pandas", "xarray", "distributed", "typst", "scipy", "imageio_ffmpeg"} & set(done.stdout.split())
