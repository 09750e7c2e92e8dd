"""Packages that only some commands need."""
from __future__ import annotations

from importlib import import_module
from types import ModuleType

from .errors import Error


def needed(module: str, extra: str, package: str = "") -> ModuleType:
    """Import a module of an optional package. Raise an Error that says how to install the package if it is missing.

    extra: ours that has the package; package: its name, where that is not the module's.
    """
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        if error.name != module:        # it is there and lacks something itself
            raise
        raise Error(f"needs {package or module}, which is not installed: pip install 'ldbench[{extra}]'") from None
