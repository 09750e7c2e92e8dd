"""What a picture that a page saved shows: its parts with their names, lines, letters, and the scales of its axes."""
from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import pairwise
from xml.etree import ElementTree

import numpy as np

from browser import Browser
from reading import value

SAVED = """window.saved = []; URL.createObjectURL = blob => { window.saved.push(blob); return 'blob:none'; };
  HTMLAnchorElement.prototype.click = function () { window.savedName = this.download; }"""


@dataclass(frozen=True)
class Part:
    """A path or a text; `points` are the corners of the path or the place of the text [px], with gaps of NaN between lines."""

    name: dict[str, str]        # what the picture says that it shows
    points: np.ndarray
    text: str                   # '' of a path
    colour: str                 # of the line, or of the area or the letters
    dashes: str
    width: float                # of the line; 0 of an area
    radius: float = 0.0         # of a circle, whose centre is the only point
    anchor: str = ""
    turned: bool = False        # whether letters do not run from left to right

    @property
    def what(self) -> str:
        return self.name.get("what", "")


def saved(browser: Browser, act: str, *values: object) -> str:
    """The text of the file that a script saves."""
    browser.run(SAVED)
    browser.run(act, *values)
    browser.wait(lambda: browser.run("return window.saved.length"))
    browser.run("""window.text = null; const reader = new FileReader();
      reader.onload = () => { window.text = reader.result; }; reader.readAsBinaryString(window.saved[0])""")
    browser.wait(lambda: browser.run("return window.text !== null"))
    return browser.run("return window.text")


def chart_picture(browser: Browser, k: int, kind: str = "SVG") -> str:
    """A chart as its menu saves it."""
    return saved(browser, """const chart = ldbench.charts[arguments[0]];
      if (chart.menu.hidden) chart.card.querySelector('[title^=axes]').click();
      [...chart.menu.querySelectorAll('button')].find(one => one.textContent === arguments[1]).click()""", k, kind)


def scene_picture(browser: Browser, kind: str = "SVG") -> str:
    """The scene as it is saved."""
    return saved(browser, """[...document.querySelectorAll('#scene-save button')]
      .find(one => one.textContent === arguments[0]).click()""", kind)


def parts(svg: str) -> list[Part]:
    """The parts in the order in which they are drawn."""
    found = []
    for element in ElementTree.fromstring(svg.encode("latin-1").decode("utf-8")):
        tag, get = element.tag.rpartition("}")[2], element.get
        if tag == "clipPath":
            continue
        matrix = np.array([float(x) for x in re.findall(r"-?[\d.]+", get("transform") or "1 0 0 1 0 0")])
        name = {key.removeprefix("data-"): text for key, text in element.items() if key.startswith("data-")}
        radius, area = 0.0, get("stroke") is None
        if tag == "text":
            points = np.array([[float(get("x")), float(get("y"))]])
        elif arc := re.fullmatch(r"M(\S+) (\S+)a(\S+) .*", get("d")):
            radius = float(arc[3])
            points = np.array([[float(arc[1]) + radius, float(arc[2])]])
        else:
            pieces = re.findall(r"([ML])(-?[\d.]+) (-?[\d.]+)", get("d"))
            points = np.array([one for kind, x, y in pieces
                               for one in ([[np.nan]*2] if kind == "M" else []) + [[float(x), float(y)]]])
        found.append(Part(name, points @ matrix[:4].reshape(2, 2) + matrix[4:], element.text or "" if tag == "text" else "",
                          get("fill") if area else get("stroke"), get("stroke-dasharray") or "",
                          0.0 if area else float(get("stroke-width")), radius, get("text-anchor") or "", matrix[1] != 0))
    return found


@dataclass(frozen=True)
class Axes:
    """The scales of a chart, from its grid and the numbers at it, and its words."""

    x: np.ndarray       # slope and offset: value = x[0] px + x[1]
    y: np.ndarray
    unit_x: str
    label: str          # of the vertical axis, with its unit in brackets

    def values(self, px: np.ndarray) -> np.ndarray:
        return px @ np.diag([self.x[0], self.y[0]]) + [self.x[1], self.y[1]]


def axes(found: list[Part]) -> Axes:
    """Each number stands behind its line of the grid; the last number of the horizontal axis is drawn first and has the unit."""
    own = [part for part in found if part.what == "axes"]
    scales: dict[bool, list[tuple[float, float]]] = {True: [], False: []}
    unit, label = "", ""
    for line, text in pairwise(own):
        if text.text and not line.text and not text.turned:
            number, _, more = text.text.partition(" ")
            unit = unit or more
            upright = text.anchor == "end"
            scales[upright].append((np.nanmean(line.points[:, 1 if upright else 0]), value(number)[0]))
    label = next((part.text for part in own if part.turned), "")
    x, y = (np.polyfit(*np.array(scales[upright]).T, 1) for upright in (False, True))
    return Axes(x, y, unit, label)
