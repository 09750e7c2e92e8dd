"""The types of the core's procedures, _flat.pyi, are those that f2py tells of the compiled module."""
from __future__ import annotations

import ast
import re
from pathlib import Path
from typing import NamedTuple

import pytest

import ldbench
from ldbench._core import _flat

STUB = Path(ldbench.__file__).parent/"_core/_flat.pyi"


class Signature(NamedTuple):
    """Arguments by name, those that may be left out, and what is returned, each as the stub's type."""

    arguments: dict[str, str]
    optional: set[str]
    returned: list[str]


def type_of(words: str) -> str:
    """The stub's type of what f2py describes."""
    words = re.sub(r"^(in/output|input) |, optional$", "", words)
    if array := re.match(r"rank-\d array\('(.)'\)", words):
        return {"d": "Floats", "i": "Ints"}[array[1]]
    return "bytes" if words.startswith("string") else {"int": "int", "long": "SupportsInt", "float": "float"}[words]


def compiled() -> dict[str, Signature]:
    """By f2py's docstrings. A long that goes in is a handle; one that comes out is its address."""
    found = {}
    for name in dir(_flat):
        told = getattr(_flat, name).__doc__ or ""
        call = re.match(rf"(?:([\w,]+) = )?{name}\(([\w,]*)(?:,?\[([\w,]+)\])?\)\n", told)
        if not call:
            continue
        returned, needed, optional = (words.strip(",").split(",") if words else [] for words in call.groups())
        before, _, after = told.partition("\nReturns\n")
        given, got = (dict(re.findall(r"^(\w+) : (.*)$", part, re.MULTILINE)) for part in (before, after))
        found[name] = Signature({word: type_of(given[word]) for word in [*needed, *optional]}, set(optional),
                                [type_of(got[word]).replace("SupportsInt", "int") for word in returned])
    return found


def stated() -> dict[str, Signature]:
    """By the stub."""
    found = {}
    for node in ast.parse(STUB.read_text()).body:
        if isinstance(node, ast.FunctionDef):
            arguments = {argument.arg: ast.unparse(argument.annotation) for argument in node.args.args if argument.annotation}
            assert len(arguments) == len(node.args.args), f"{node.name}: an argument without a type"
            optional = set(list(arguments)[len(arguments) - len(node.args.defaults):])
            returned = ast.unparse(node.returns) if node.returns else ""
            several = re.fullmatch(r"tuple\[(.*)\]", returned)
            found[node.name] = Signature(arguments, optional, several[1].split(", ") if several else
                                         [] if returned == "None" else [returned])
    return found


COMPILED = compiled()


def test_the_stub_has_the_procedures_of_the_compiled_module():
    assert len(COMPILED) > 30
    assert stated().keys() == COMPILED.keys()


@pytest.mark.parametrize("name", COMPILED)
def test_arguments_and_results_have_their_names_and_types(name: str):
    found = stated()[name]
    assert list(found.arguments) == list(COMPILED[name].arguments)
    assert found == COMPILED[name]
