"""The rooms of the Python package: each uses itself and those before it alone, as `make lint` holds it for the core."""
from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import ldbench
from imports import imported
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


PACKAGE = Path(ldbench.__file__).parent
ROOMS = ("_core", "constants", "number_text", "tools", "case", "conicity", "pressure", "profiles", "bodies", "run_curve", "table",
         "results", "geometry", "plots", "profile", "viewer", "runs", "fmu", "ensembles", "trust", "report", "commands", "__main__")


def dotted(path: Path) -> str:
    """The name of a module; of a folder, the folder's."""
    return ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(".__init__")


PYTHON = [path for path in sorted(PACKAGE.rglob("*.py")) if path != PACKAGE/"__init__.py"]
MODULES = {*map(dotted, PYTHON), "ldbench._core._flat"}


def imports(path: Path) -> list[tuple[str, str]]:
    """The modules that a module imports, and the names that it takes from them."""
    return imported(path, dotted(path) if path.name == "__init__.py" else dotted(path.parent))


def test_rooms_use_each_other_in_one_order():
    """Imports inside functions count as well, and so do those that only types need."""
    used = {(dotted(path), whole if (whole := f"{module}.{name}") in MODULES else module)
            for path in PYTHON for module, name in imports(path) if module.partition(".")[0] == "ldbench"}
    assert [one for one, other in used if other == "ldbench"] == [], "a module that imports the package itself"
    between = {tuple(module.split(".")[1] for module in pair) for pair in used}
    assert {room for pair in between for room in pair} <= set(ROOMS)
    assert len([one for one, other in between if one != other]) > 25
    assert sorted((one, other) for one, other in between if ROOMS.index(other) > ROOMS.index(one)) == []


ROUND = PACKAGE.with_name("ldbench_round")
ON_TOP = (REPO/"docs/python.md").read_text(encoding="utf-8").partition("## Packages on top of ldbench")[2]
PUBLIC = {"ldbench", *re.findall(r"`(ldbench\.[a-z_.]+)`", ON_TOP)}


def test_a_round_uses_public_names_alone():
    """A round imports what docs/python.md lists, and that page lists nothing else."""
    used = {pair for path in ROUND.rglob("*.py") for pair in imports(path) if pair[0].partition(".")[0] == "ldbench"}
    private = {(module, name) for module, name in used if f"{module}.{name}" not in PUBLIC and not (module in PUBLIC and (
        name in (*ldbench.__all__, "__version__") if module == "ldbench" else name and not name.startswith("_")))}
    assert private == set()
    assert {name for module, name_ in used for name in (module, f"{module}.{name_}")} >= PUBLIC, "a public module that nothing uses"


def test_the_package_does_not_know_a_round():
    """Neither by an import nor by a name in a text, besides the dispatch of commands; comments may."""
    knowing = {path for path in PACKAGE.rglob("*.py") if "ldbench_round" in re.sub(r"#.*", "", path.read_text(encoding="utf-8"))}
    assert knowing == {PACKAGE/"commands/__init__.py"}


def test_the_package_is_imported_without_what_only_some_need():
    """matplotlib, pandas and the like take longer than a short run."""
    script = "import sys, ldbench; print(*sorted({name.partition('.')[0] for name in sys.modules}))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert not {"matplotlib", "pandas", "xarray", "distributed", "typst", "scipy", "imageio_ffmpeg"} & set(done.stdout.split())
