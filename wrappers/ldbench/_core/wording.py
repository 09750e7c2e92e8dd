"""Numbers of things in words."""
from __future__ import annotations


def counted(n: int, noun: str) -> str:
    """Name a number of things by a noun in the singular: '1 run', '2 runs'."""
    return f"{n} {noun}" if n == 1 else f"{n} {noun}s"
