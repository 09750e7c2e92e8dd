"""The faults that `make mutants` draws are those of its rules, and a module with all of them behind numbers compiles."""
from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from faults import constant, faults, marks, part, statements, switched
from running import REPO


@pytest.mark.parametrize(("suffix", "line", "expected"), [
    (".py", "x = a - b*c", {"x = a + b*c", "x = b*c - a", "x = a", "x = a - b", "x = a - c"}),
    (".py", "x: int = -a/20", {"x: int = a/20", "x: int = -20 / a", "x: int = -a", "x: int = -a/21", "x: int = -a/19"}),
    (".py", "x = f(a, b) if a < b and c is None else 0.5", {
        "x = f(b, a) if a < b and c is None else 0.5", "x = f(a, b) if a > b and c is None else 0.5",
        "x = f(a, b) if a < b or c is None else 0.5", "x = f(a, b) if a < b and c is not None else 0.5",
        "x = f(a, b) if not a < b and c is None else 0.5", "x = f(a, b) if a < b and c is None else 0.55"}),
    (".py", "x = load['N_LF'], *left, y(left, strict=True)  # right + 1", {
        "x = load['N_RF'], *left, y(left, strict=True)  # right + 1", "x = load['N_LF'], *right, y(left, strict=True)  # right + 1",
        "x = load['N_LF'], *left, y(right, strict=True)  # right + 1"}),
    (".py", "x[i] += 'a' in b", {"x[i] += 'a' not in b", "pass"}),
    (".f90", "x = a%y - b(2)*c ! + d", {"x = a%y + b(2)*c ! + d", "x = b(2)*c - a%y ! + d", "x = a%y ! + d", "x = a%y - c ! + d",
                                       "x = a%y - b(2) ! + d", "x = a%y - b(3)*c ! + d", "x = a%y - b(1)*c ! + d"}),
    (".f90", "if (a >= 0.5_dp .and. l) return", {
        "if (a <= 0.5_dp .and. l) return", "if (a >= 0.55_dp .and. l) return", "if (a >= 0.5_dp .or. l) return",
        "if (.not. (a >= 0.5_dp .and. l)) return", "continue"}),
    (".f90", "call f(left, right)", {"call f(right, left)", "call f(left, left)", "call f(right, right)", "continue"}),
])
def test_rules(suffix: str, line: str, expected: set[str]) -> None:
    source = f"{line}\n".encode()
    one, = statements(source, suffix)
    assert {change.of(source).decode().strip() for change in faults(source, one, suffix)} == expected


def test_a_module_compiles_with_all_its_faults(tmp_path: Path) -> None:
    source = (REPO/"fortran/support/root_bracket.f90").read_bytes()
    changes = [change for one in statements(source, ".f90") for change in faults(source, one, ".f90") if (
        constant(one, source, change) if one.kind == "parameter" else one.kind == "simple" or part(one, change))]
    assert len(changes) > 50
    module = b"\nmodule ldbench_fault\n  integer :: fault_number\nend module\n"
    (tmp_path/"all.f90").write_bytes((REPO/"fortran/support/kinds.f90").read_bytes() + module + switched(source, dict(enumerate(changes))))
    done = subprocess.run(["gfortran", "-fsyntax-only", "-ffree-line-length-none", "all.f90"], cwd=tmp_path, capture_output=True, text=True)
    assert not done.returncode, done.stderr


def test_marks() -> None:
    source = b"def f():\n    if a:\n        b\n    c\ng = 1\n"
    assert marks(source, ".py", statements(source, ".py")) == [None, 0, 1, 0, None]
    source = b"a = 1\nb = 2\nif (c) d = 3\nif (e) then\nf = 4\nelse if (g) then\nh = 5\nend if\n"
    assert marks(source, ".f90", statements(source, ".f90")) == [0, 0, 0, 3, 4, 3, 6, None]
