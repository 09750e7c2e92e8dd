"""Faults that `make mutants` puts into sources are those that its rules say, and leave sources that compile."""
from __future__ import annotations

import ast
import subprocess
from pathlib import Path

import pytest

from faults import Change, blocks, constant, fortran_faults, python_faults, statements, switched
from running import REPO


def changed(source: str, change: Change) -> str:
    text = source.encode()
    return (text[:change.start] + change.new.encode() + text[change.end:]).decode()


@pytest.mark.parametrize(("line", "expected"), [
    ("x = a - b*c", {"x = a + b*c", "x = b*c - a", "x = a", "x = a - b", "x = a - c"}),
    ("x = -a/2", {"x = a/2", "x = 2/-a", "x = -a", "x = -a/3", "x = -a/1"}),
    ("x = f(a, b) if a < b and c is None else 0.5", {
        "x = f(b, a) if a < b and c is None else 0.5", "x = f(a, b) if a > b and c is None else 0.5",
        "x = f(a, b) if a < b or c is None else 0.5", "x = f(a, b) if a < b and c is not None else 0.5",
        "x = f(a, b) if not (a < b and c is None) else 0.5", "x = f(a, b) if a < b and c is None else 0.55"}),
    ("x = load['N_LF']", {"x = load['N_RF']"}),
    ("x.left = right, left", {"x.left = left, left", "x.left = right, right", "pass"}),
])
def test_rules_of_python(line: str, expected: set[str]) -> None:
    assert {changed(line, change) for change in python_faults(line.encode())} == expected


@pytest.mark.parametrize(("line", "expected"), [
    ("x = a%y - b(2)*c", {"x = a%y + b(2)*c", "x = b(2) - a%y*c", "x = a%y*c", "x = a%y - c", "x = a%y - b(2)", "x = a%y - b(3)*c",
                          "x = a%y - b(1)*c"}),
    ("if (a >= 0.5_dp .and. l) return", {
        "if (a <= 0.5_dp .and. l) return", "if (a >= 0.55_dp .and. l) return", "if (a >= 0.5_dp .or. l) return",
        "if (.not. (a >= 0.5_dp .and. l)) return", "continue"}),
    ("call f(left, right)", {"call f(right, left)", "call f(left, left)", "call f(right, right)", "continue"}),
])
def test_rules_of_fortran(line: str, expected: set[str]) -> None:
    source = f"{line}\n".encode()
    found, = statements(source)
    assert {changed(line, change) for change in fortran_faults(source, found, {"left", "right"})} == expected


def test_every_fault_of_a_module_compiles_behind_its_number(tmp_path: Path) -> None:
    source = (REPO/"fortran/support/root_bracket.f90").read_bytes()
    faults, constants = dict[int, Change](), dict[str, str]()
    for one in statements(source):
        for change in fortran_faults(source, one, set()):
            if one.kind == "parameter":
                constants |= [constant(one, source, change)] if constant(one, source, change) else []
            else:
                faults[len(faults)] = change
    assert len(faults) > 50
    (tmp_path/"all.f90").write_bytes((REPO/"fortran/support/kinds.f90").read_bytes() + b"""
module ldbench_fault
  integer :: fault_number
end module
""" + switched(source, faults, constants))
    done = subprocess.run(["gfortran", "-fsyntax-only", "-ffree-line-length-none", "all.f90"], cwd=tmp_path, capture_output=True, text=True)
    assert not done.returncode, done.stderr


def test_blocks_are_sequences_of_statements() -> None:
    tree = ast.parse("def f():\n  if a:\n    b\n  else:\n    c\n  for d in e:\n    g\n")
    assert [ast.unparse(body[0]) for _, body in blocks(tree)] == ["if a:\n    b\nelse:\n    c", "b", "c", "g"]
