"""The faults that `make mutants` draws are those of its rules, and a module with all of them behind numbers compiles."""
from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from faults import constant, faults, marks, part, statements, switched
from running import REPO


@pytest.mark.parametrize(("suffix", "line", "expected"), [
    (".py", "x = a - b*2", {"x = a + b*2", "x = b*2 - a", "x = a", "x = a - b", "x = a - 2", "x = a - b*3",
                                "x = a - b*1", "x = b - b*2",
                            "x = a - a*2"}),
    (".py", "x: int = -a/20", {"x: int = a/20", "x: int = -20 / a", "x: int = -a", "x: int = -a/21", "x: int = -a/19"}),
    (".py", "x = 1 if a < a.b and a is None else 0.5", {
        "x = 0 if a < a.b and a is None else 0.5", "x = 2 if a < a.b and a is None else 0.5",
        "x = 1 if a > a.b and a is None else 0.5", "x = 1 if a < a.b or a is None else 0.5",
        "x = 1 if a < a.b and a is not None else 0.5",
        "x = 1 if not a < a.b and a is None else 0.5", "x = 1 if a < a.b and a is None else 0.55"}),
    (".py", "x = load['N_LF'], *y(strict=True)  # right + 1", {"x = load['N_RF'], *y(strict=True)  # right + 1"}),
    (".py", "f(f'{2*a:.3f} {b}', c.d + e.d, c.g)", {
        "f(f'{3*a:.3f} {b}', c.d + e.d, c.g)", "f(f'{1*a:.3f} {b}', c.d + e.d, c.g)", "f(f'{b:.3f} {2*a}', c.d + e.d, c.g)",
        "f(f'{2*a:.3f} {b}', c.d - e.d, c.g)", "f(f'{2*a:.3f} {b}', c.d, c.g)", "f(f'{2*a:.3f} {b}', e.d, c.g)",
        "f(f'{2*a:.3f} {b}', c.g + e.d, c.g)", "f(f'{2*a:.3f} {b}', c.d + e.g, c.g)", "f(f'{2*a:.3f} {b}', c.d + e.d, c.d)",

        "pass"}),
    (".py", "x[2] += 'a' in i", {"x[2] += 'a' not in i", "pass", "x[1] += 'a' in i", "x[3] += 'a' in i"}),
    (".f90", "x = a%y - a(2)*a ! + d", {"x = a%y + a(2)*a ! + d", "x = a(2)*a - a%y ! + d", "x = a%y ! + d", "x = a%y - a ! + d",
                                       "x = a%y - a(2) ! + d", "x = a%y - a(3)*a ! + d", "x = a%y - a(1)*a ! + d"}),
    (".f90", "if (a >= 0.5_dp .and. a) return", {
        "if (a <= 0.5_dp .and. a) return", "if (a >= 0.55_dp .and. a) return", "if (a >= 0.5_dp .or. a) return",
        "if (.not. (a >= 0.5_dp .and. a)) return", "continue"}),
    (".f90", "call f(left, right)", {"call f(right, left)", "call f(left, left)", "call f(right, right)", "continue"}),
])
def test_rules(suffix: str, line: str, expected: set[str]) -> None:
    source = f"{line}\n".encode()
    one, = statements(source, suffix)
    assert {change.of(source).decode().strip() for change in faults(source, one, suffix)} == expected


def test_a_module_compiles_with_all_its_faults(tmp_path: Path) -> None:
    source = (REPO/"fortran/support/root_bracket.f90").read_bytes()
    changes = [change for one in statements(source, ".f90") for change in faults(source, one, ".f90") if change.rule not in (
        "name", "side", "operands") and (
            constant(one, source, change) if one.kind == "parameter" else one.kind == "simple" or part(one, change))]
    assert len(changes) > 50
    module = b"\nmodule ldbench_fault\n  integer :: fault_number\nend module\n"
    kinds = (REPO/"fortran/support/kinds.f90").read_bytes()
    (tmp_path/"all.f90").write_bytes(kinds + module + switched(source, dict(enumerate(changes))))
    words = ["gfortran", "-fsyntax-only", "-ffree-line-length-none", "all.f90"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True)
    assert not done.returncode, done.stderr


def test_marks() -> None:
    source = b"def f():\n    if a:\n        b\n    c\ng = 1\n"
    assert marks(source, ".py", statements(source, ".py")) == [None, 0, 1, 0, None]
    source = b"a = 1\nb = 2\nif (c) d = 3\nif (e) then\nf = 4\nelse if (g) then\nh = 5\nend if\n"
    assert marks(source, ".f90", statements(source, ".f90")) == [0, 0, 0, 3, 4, 3, 6, None]
