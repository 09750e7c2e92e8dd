"""The golden world keeps what is whole, makes the rest anew, and removes nothing that somebody uses."""
from __future__ import annotations

import os
from pathlib import Path

import pytest

import golden


def test_a_part_is_made_once_and_anew_where_it_is_not_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(golden, "FOLDER", tmp_path)
    monkeypatch.setattr(golden, "HELD", [])
    made: list[Path] = []

    def make(folder: Path) -> None:
        made.append(folder/"file")
        made[-1].write_text("whole")

    def interrupted(folder: Path) -> None:
        (folder/"file").write_text("half")
        raise KeyboardInterrupt

    first = golden.kept("part", "earlier", make)
    assert golden.kept("part", "earlier", make) == first and len(made) == 1
    later = golden.kept("part", "later", make)
    assert len(made) == 2 and first.exists(), "it is still used"
    (later/"file").write_text("changed by a test")
    assert golden.kept("part", "later", make) == later and len(made) == 3 and made[-1].read_text() == "whole"
    while golden.HELD:
        os.close(golden.HELD.pop())
    with pytest.raises(KeyboardInterrupt):
        golden.kept("part", "last", interrupted)
    assert not first.exists() and not later.exists(), "nobody uses them"
    assert (golden.kept("part", "last", make)/"file").read_text() == "whole" and len(made) == 4
    os.close(golden.HELD.pop())
