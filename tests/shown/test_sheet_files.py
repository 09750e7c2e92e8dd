"""Pages as files: a document, or a picture with all pages one below the other."""
from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
from matplotlib.figure import Figure
from PIL import Image
from pypdf import PdfReader

from ldbench import Error
from ldbench.__main__ import main
from ldbench.plots.sheets import DPI, MOST, save_sheets
from specimen import World

SVG = "{http://www.w3.org/2000/svg}"


def pages(count: int) -> list[Figure]:
    """Pages of 4 in by 2 in, with a curve and a word."""
    found = []
    for k in range(count):
        figure = Figure(figsize=(4, 2))
        figure.add_subplot().plot([0, 1, k])
        figure.text(0.1, 0.9, f"page {k}")
        found.append(figure)
    return found


def test_pages_stand_one_below_the_other(tmp_path: Path):
    """Nothing of a page refers to another one, and the same pages give the same bytes."""
    made = {}
    for ending in "pdf", "svg", "png":
        target = tmp_path/f"sheets.{ending}"
        save_sheets(pages(3), target)
        before = target.read_bytes()
        save_sheets(pages(3), target)
        assert target.read_bytes() == before
        made[ending] = target
    assert len(PdfReader(made["pdf"]).pages) == 3
    with Image.open(made["png"]) as picture:
        assert picture.size == (4*DPI, 3*2*DPI)
    whole = ElementTree.parse(made["svg"]).getroot()
    assert (whole.get("width"), whole.get("height")) == ("288pt", "432pt")
    inner = whole.findall(f"{SVG}svg")
    assert [float(one.get("y", "nan")) for one in inner] == [0, 144, 288]
    names = [one.get("id") for one in whole.iter() if one.get("id")]
    assert len(set(names)) == len(names)
    for one in inner:
        text = ElementTree.tostring(one, encoding="unicode")
        assert set(re.findall(r'href="#([^"]+)"|url\(#([^)]+)\)', text)) and {
            a or b for a, b in re.findall(r'href="#([^"]+)"|url\(#([^)]+)\)', text)} <= set(re.findall(r'\bid="([^"]+)"', text))


def test_a_picture_of_too_many_pages_is_refused(tmp_path: Path):
    with pytest.raises(Error, match=f"expected at most {MOST} pages for a picture, found {MOST + 1}; a document .pdf holds more"):
        save_sheets(pages(MOST + 1), tmp_path/"long.png")
    assert not (tmp_path/"long.png").exists()


@pytest.mark.parametrize("command", ["plot", "compare"])
def test_commands_write_the_pages_of_the_document(command: str, world: World, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    """As many in a picture as in the document, whose contents page lists what follows."""
    counts = {}
    for ending in "pdf", "svg":
        target = tmp_path/f"{command}.{ending}"
        files = [str(world.thrown.file)]*(1 + (command == "compare"))
        assert main([command, *files, "-o", str(target)]) == 0
        counts[ending] = (len(ElementTree.parse(target).getroot().findall(f"{SVG}svg")) if ending == "svg"
                          else len(PdfReader(target).pages))
    assert counts["pdf"] == counts["svg"] > 2
