"""Every number that a user reads and everything that is drawn is what the run, the file or the profile says.

One test goes over the rows of each table. A number that no row and no label accounts for is a fault, and so is a row whose number
could be another one.
"""
from __future__ import annotations

from pathlib import Path

import pytest

from commands import COMMANDS
from ldbench.plots.style import ldbench_style
from pictures import PICTURES, Picture
from reading import differing
from specimen import World
from texts import TEXTS, Row
from walk import walk


@pytest.mark.parametrize("row", [*TEXTS, *COMMANDS], ids=lambda row: row.what)
def test_words(row: Row, world: World, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, undrawn: None):
    monkeypatch.chdir(world.folder)
    texts = row.texts(world, tmp_path)
    assert texts
    for title, text in texts.items():
        wrong = differing(text, row.lines(world, title, text), world, row.labels)
        assert not wrong, "\n".join([title, *wrong])


@pytest.mark.parametrize("row", PICTURES, ids=lambda row: row.what)
def test_pictures(row: Picture, world: World, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(world.folder)
    with ldbench_style():
        for title, figure in row.figures(world):
            count = walk(figure, row.compared(world), row.source(world, title), row.others(world), row.says, cut=row.cut)
            assert count >= row.count, title
            row.check(world, title, figure)
