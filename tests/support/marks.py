"""Marks of what runs: bytes of a file that all processes of a test see. The core sets them, and Python where this is imported."""
from __future__ import annotations

import ast
import builtins
import json
import mmap
import os
from importlib.machinery import SourceFileLoader
from typing import Any

import faults

SIZE = 1 << 16


class Marks:
    """The marks of this process and of those that it starts."""

    def __init__(self) -> None:
        with open(os.environ["LDBENCH_MARKS"], "r+b") as file:
            self.bytes = mmap.mmap(file.fileno(), SIZE)
        with open(os.environ["LDBENCH_MARKS"] + ".json", encoding="utf-8") as file:
            firsts = json.load(file)        # the first mark of each module
        plain = SourceFileLoader.source_to_code

        def marked(loader: Any, data: Any, path: Any, *more: Any, **options: Any) -> Any:
            first = firsts.get(str(path).rpartition("/wrappers/")[2])
            if first is None or not isinstance(data, bytes):
                return plain(loader, data, path, *more, **options)
            tree = ast.parse(data)
            for k, body in enumerate(faults.blocks(tree)):
                call = ast.Expr(ast.Call(ast.Name("__mark__", ast.Load()), [ast.Constant(first + k), ast.Constant(1)], []))
                text = isinstance(body[0], ast.Expr) and isinstance(body[0].value, ast.Constant)
                body.insert(int(text), ast.copy_location(call, body[0]))
            return compile(ast.fix_missing_locations(tree), path, "exec", dont_inherit=True)

        builtins.__mark__ = self.bytes.__setitem__
        SourceFileLoader.source_to_code = marked

    def take(self) -> set[int]:
        """The marks since the last call."""
        found = self.bytes[:]
        self.bytes[:] = bytes(SIZE)
        return {k for k, byte in enumerate(found) if byte}

    def put(self, found: set[int]) -> None:
        for k in found:
            self.bytes[k] = 1


if "LDBENCH_MARKS" in os.environ:
    Marks()
