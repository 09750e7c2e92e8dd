"""What charts and scene draw, against the rows of the file as tests/support/raw.py reads them.

Every part of a saved picture says what it shows; a part without a name fails. The legend tells by its words, colour and dashes
which column a curve must be, the numbers and the unit at the axes tell where it must run.
"""
from __future__ import annotations

import io
import json
import re
import unicodedata
from itertools import groupby
from pathlib import Path

import numpy as np
import pytest
from pypdf import PdfReader

from browser import Browser, go
from ldbench.__main__ import main
from ldbench.geometry.pressures import run_patches
from ldbench.results.run_data import read_data
from probes import left_rail, left_wheel, turned
from raw import PAIR, Raw
from specimen import World
from svg_picture import Part, axes, chart_picture, parts, saved, scene_picture
from table import COLUMNS, CONTACTS, KN, MM

SMALL = {"nJ": 1e9, "µJ": 1e6}      # units of charts whose energies are small
CHART = {"paper", "axes", "events", "column", "difference", "legend", "nothing to show"}
SCENE = {"paper", "top of rails and centreline", "rails", "wheelset", "normal", "force", "contact", "force in words", "scales",
         "gap", "approach", "badge"}
PIXEL = 1.6                         # that a curve may be off its values: the grid stands at whole pixels
BEYOND = 0.5                        # pixels by which a band is drawn beyond its values, so that it is never without height


Look = tuple[str, str, float]       # colour, dashes and width


def look_of(part: Part) -> Look:
    return part.colour, part.dashes, part.width


def legend_of(found: list[Part]) -> dict[str, Look]:
    """The looks by the words of the legend: a stretch of line stands before its words."""
    own = [part for part in found if part.what == "legend"]
    assert all(line.name == words.name for line, words in zip(own[::2], own[1::2], strict=True))
    return {words.text: look_of(line) for line, words in zip(own[::2], own[1::2], strict=True)}


def check_curve(found: list[Part], look: Look, t: np.ndarray, x: np.ndarray, what: str) -> None:
    """The curve of this look runs through all values, over times or over another column, and nowhere else."""
    scales = axes(found)
    curves = [part for part in found if part.what in ("column", "difference") and look_of(part) == look]
    assert len(curves) == np.isfinite(x).any(), (what, look)
    nothing = any(part.what == "nothing to show" for part in found)
    assert nothing <= np.isnan(x).all()
    if not curves:
        return
    px = curves[0].points[~np.isnan(curves[0].points[:, 0])]
    expected = np.column_stack([(t - scales.x[1])/scales.x[0], (x - scales.y[1])/scales.y[0]])[np.isfinite(x + t)]
    if len(px) == len(expected):
        assert np.abs(px - expected).max() < PIXEL, (what, np.abs(px - expected).max())
        return
    # Bins of some rows: each drawn point is within what the rows nearby span, and the largest and smallest values are drawn.
    drawn = np.vstack([part.points for part in found if part.name == curves[0].name])
    assert {part.colour for part in found if part.name == curves[0].name} == {look[0]}
    drawn = drawn[~np.isnan(drawn[:, 0])]
    assert len(drawn) > 8
    order = np.searchsorted(expected[:, 0], [drawn[:, 0] - 2*PIXEL, drawn[:, 0] + 2*PIXEL])
    for (_, y), a, b in zip(drawn, *order, strict=True):
        near = expected[max(a - 1, 0):b + 1, 1]
        assert near.min() - PIXEL - BEYOND <= y <= near.max() + PIXEL + BEYOND, what
    for end in np.min, np.max:
        assert end(drawn[:, 1]) == pytest.approx(end(expected[:, 1]), abs=2*PIXEL), what


def check_events(found: list[Part], raws: dict[str, Raw]) -> None:
    """A line stands at each event that a file lists, and no line elsewhere but where rows show that a contact closes or opens, and
    where its force, or the pressure, is largest."""
    scales = axes(found)
    drawn = np.sort([scales.x[0]*np.nanmean(part.points[:, 0]) + scales.x[1] for part in found if part.what == "events"])
    listed = [t for raw in raws.values() for t, *_ in raw.events]
    in_rows = [raw.t[1:][np.diff(raw.c[f"N_{contact}"] > 0)] for raw in raws.values() for contact in CONTACTS.values()]
    largest = [raw.peak(contact)[1] for raw in raws.values() for contact in CONTACTS.values()]
    largest += [raw.result("t_pmax") for raw in raws.values()]
    allowed, off = np.concatenate([listed, largest, *in_rows]), PIXEL*scales.x[0]

    def apart(times: np.ndarray, places: np.ndarray) -> np.ndarray:
        return np.abs(np.subtract.outer(times, places)).min(axis=1)

    assert len(drawn) and apart(np.array(listed), drawn).max() < off and apart(drawn, allowed).max() < off


def check_chart(browser: Browser, k: int, raws: dict[str, Raw], difference: bool = False) -> set[str]:
    """Compare a chart over time with the rows; the columns that it shows. Its legend on the screen has the same looks."""
    found = parts(chart_picture(browser, k))
    assert {part.what for part in found} <= CHART and all(part.name for part in found)
    scales, legend, seen = axes(found), legend_of(found), set()
    assert scales.unit_x == "s"
    first = next(iter(raws.values()))
    for words, look in legend.items():
        run = next(name for name in raws if len(raws) == 1 or words.endswith(f", {name}"))
        plain = words.removesuffix(f", {run}").removeprefix("Δ ")
        column, unit, scale = COLUMNS[plain]
        shown = re.search(r"\[(.*)\]$", scales.label)[1] if "[" in scales.label else scales.label
        scale = SMALL.get(shown, scale)
        assert shown == unit or (unit == "J" and shown in SMALL), (words, scales.label)
        named = {(part.name["run"], part.name["column"], part.name["unit"], float(f"{float(part.name['factor']):.12g}"),
                  part.name.get("contact", ""), part.name.get("side", "")) for part in found
                 if part.what in ("column", "difference", "legend") and look_of(part) == look}
        contact = column.rpartition("_")[2] if column[-2:] in CONTACTS.values() else ""
        side = contact[:1] or (column[-1] if column[-2:] in ("_L", "_R") else "")
        assert named == {(run, column, shown, float(f"{scale:.12g}"), contact, side)}, words
        raw = raws[run]
        x = raw.c[column] if not difference else np.interp(first.t, raw.t, raw.c[column], right=np.nan) - first.c[column]
        check_curve(found, look, (first if difference else raw).t, scale*x, words)
        seen.add(column)
    check_events(found, raws)
    looks = set(legend.values())
    assert {look_of(part) for part in found if part.what in ("column", "difference") and part.width} <= looks
    assert len(looks) == len(legend) or len(legend) > 8
    shown = browser.run("""return [...ldbench.charts[arguments[0]].card.querySelectorAll('.legend li')].flatMap(item =>
      [...item.querySelectorAll('path')].map(path => [
        [...item.childNodes].filter(node => node.nodeType === Node.TEXT_NODE).map(node => node.textContent).join(''),
        path.getAttribute('stroke'), path.getAttribute('stroke-dasharray'), path.getAttribute('stroke-width')]))""", k)
    assert sorted((words, colour, dashes, round(float(width) - 0.6, 6)) for words, colour, dashes, width in shown) == sorted(
        (words if len(raws) == 1 else words.rpartition(", ")[0], *look) for words, look in legend.items())
    return seen


def pages_of_charts() -> list[list[str]]:
    """All columns, some of one unit to a chart."""
    charts = []
    for _, some in groupby(COLUMNS.values(), key=lambda known: known[1:]):
        names = [column for column, *_ in some]
        charts += [names[k:k + 4] for k in range(0, len(names), 4)]
    return charts


@pytest.mark.parametrize(("name", "width"), [("ex2_aw", 1366), ("ex2_aw", 240), ("ex5_aw", 1366)])
def test_every_column_is_drawn_as_it_is(name: str, width: int, browser: Browser, report: Path, world: World):
    """Each column of the file, of a run that is kept whole, with more rows than a narrow window has pixels, and of a long one."""
    raw = world.raw(name)
    charts = pages_of_charts()
    browser.size(width, 860)
    browser.open(report, f"#run={name}&t=0.001" + "".join(f"&c={','.join(names)}" for names in charts))
    seen = set()
    for k in range(len(charts)):
        seen |= check_chart(browser, k, {name: raw})
    assert seen == {column for column, *_ in COLUMNS.values()} == set(raw.c) - {"time"}


def test_charts_of_two_runs_and_their_difference(browser: Browser, two: Path, world: World):
    browser.open(two, "#c=Y&c=Y;d&c=N_LF,N_RF&c=roll_rate;d")
    for k in range(4):
        check_chart(browser, k, {"ex2_aw": world.thrown, "ex3_aw": world.faster}, difference=k in (1, 3))


@pytest.mark.parametrize(("largest", "unit"), [(0.2, "J"), (5e-5, "µJ"), (2e-8, "nJ")])
def test_units_of_small_energies(largest: float, unit: str, browser: Browser, report: Path, world: World):
    """The numbers at the axis are in the unit that stands there."""
    browser.open(report, f"#c=E_drift;y:{-largest}:{largest}")
    found = parts(chart_picture(browser, 0))
    scales, (look,) = axes(found), legend_of(found).values()
    assert scales.label == f"energy drift [{unit}]"
    check_curve(found, look, world.thrown.t, SMALL.get(unit, 1)*world.thrown.c["E_drift"], unit)


def test_chart_over_another_column(browser: Browser, report: Path, world: World):
    """Both axes have words and units."""
    raw = world.thrown
    browser.open(report, "#c=N_LF;x:Y")
    found = parts(chart_picture(browser, 0))
    scales, (look,) = axes(found), legend_of(found).values()
    assert (scales.label, scales.unit_x) == ("normal force, left flange [kN]", "mm")
    assert "lateral displacement Y [mm]" in [part.text for part in found if part.what == "axes"]
    check_curve(found, look, MM*raw.c["Y"], KN*raw.c["N_LF"], "N_LF over Y")


@pytest.mark.parametrize("view", ["whole", "left", "right"])
def test_every_part_of_the_scene(view: str, browser: Browser, report: Path, world: World):
    """Points, arrows, numbers and the wheelset at the peaks of both flanges and of a tread, by the scales that the picture has."""
    raw = world.thrown
    browser.open(report, f"#view={view}&c=N_LT,N_LF,N_RT,N_RF")
    colours = {COLUMNS[words][0][2:]: look[0] for words, look in legend_of(parts(chart_picture(browser, 0))).items()}
    assert len(set(colours.values())) == 4
    tread = int(np.argmax(raw.c["N_RT"]))
    drawn = set()
    for k in (raw.first_peak("LF"), raw.first_peak("RF"), tread, 3):
        go(browser, raw.t[k])
        found = parts(scene_picture(browser))
        assert {part.what for part in found} <= SCENE and all(part.what for part in found)
        drawn |= check_scene(found, raw, k, colours)
        left, right = (next(part.points[0, 0] for part in found if words in part.text) for words in ("left, Y", "right"))
        assert left < right
    assert drawn == set(colours)


def check_scene(found: list[Part], raw: Raw, k: int, colours: dict[str, str]) -> set[str]:
    """The contacts that are in the picture. Places are told by the bar, the top of the rails and the centreline."""
    bar, shaft = (part.points for part in found if part.what == "scales" and part.width == 2)
    size, unit = next(part.text.split() for part in found if part.what == "scales" and part.text.endswith("m"))
    force = next(float(part.text.split()[0]) for part in found if part.what == "scales" and part.text.endswith("kN"))
    head = next(part.points for part in found if part.what == "scales" and not part.width and not part.text)
    scale = np.ptp(bar[1:, 0])/(float(size)*{"mm": 1e-3, "µm": 1e-6}[unit])            # [px/m]
    arrow = np.abs(head[1, 0] - shaft[1, 0])/(1e3*force)                               # [px/N]
    grid = next(part.points for part in found if part.what == "top of rails and centreline")
    origin = np.array([grid[4, 0], grid[1, 1]])

    def place(px: np.ndarray) -> np.ndarray:
        """Y to the left and Z upwards [m]."""
        return (origin - px)/scale

    off = 0.6/scale             # the place of a pixel, and the width of the bar
    closed = {c for c in colours if raw.c[f"N_{c}"][k] > 1}
    dots = [part for part in found if part.what == "contact" and part.radius and not part.width]
    assert {part.name["contact"] for part in dots} == closed
    for dot in dots:
        c = dot.name["contact"]
        named = {"run": raw.file.stem, "contact": c, "side": c[0], "unit": "kN", "factor": "0.001"}
        assert dot.colour == colours[c] and dot.name == named | {"what": "contact"}
        where = place(dot.points[0])
        assert where == pytest.approx([raw.c[f"y_{c}"][k], raw.c[f"z_{c}"][k]], abs=off + 1e-4), c
        line, tip = [part for part in found if part.what == "force" and part.name["contact"] == c] or (None, None)
        along = np.array([raw.c[f"Fy_{c}"][k], raw.c[f"Fz_{c}"][k]])
        if line:
            assert (line.colour, tip.colour, tip.name) == (colours[c], colours[c], named | {"what": "force"})
            shown = dot.points[0] - tip.points[1]
            assert np.hypot(*shown) == pytest.approx(arrow*raw.c[f"N_{c}"][k], rel=0.02, abs=0.5), c
            assert np.arctan2(*shown) == pytest.approx(np.arctan2(*along), abs=0.02 + 0.5/np.hypot(*shown)), c
        else:
            assert arrow*raw.c[f"N_{c}"][k] < 1.5
        normal = next(part.points for part in found if part.what == "normal" and part.name["contact"] == c)
        assert np.arctan2(*(normal[1] - normal[2])) == pytest.approx(np.arctan2(*along), abs=0.01), c
        words = {part.text for part in found if part.what == "force in words" and part.name["contact"] == c}
        assert words <= {f"{c} {number_of(KN*raw.c[f'N_{c}'][k])} kN"}, words
    # The wheelset: its centre, its roll, and the outlines of its sides, which differ.
    bodies = [part.points[1:] for part in found if part.what == "wheelset" and not part.width]
    cross = [part.points for part in found if part.what == "wheelset" and part.width][-1]
    pose = np.array([raw.c["Y"][k], raw.setting("axle_height") + raw.c["Z"][k]])
    roll = raw.setting("axle_roll") + raw.c["roll"][k]
    assert place(np.nanmean(cross, axis=0)) == pytest.approx(pose, abs=off)
    axle = place(bodies[0])
    assert np.arctan2(*(axle[1] - axle[0])[::-1]) == pytest.approx(roll, abs=off)
    rails = [place(part.points[1:]) for part in found if part.what == "rails" and not part.width]
    for side, mirror, wheel, rail in zip("LR", (1, -1), bodies[1:], rails, strict=True):
        expected = turned(left_wheel(PAIR[side]), mirror*roll)*[mirror, 1] + pose
        assert apart(place(wheel), expected) < off + 2e-4 and apart(rail, left_rail(PAIR[side])*[mirror, 1]) < off + 2e-4, side
        pressed = [part for part in found if part.what == "approach" and part.name["side"] == side and part.text]
        for part in pressed:
            assert float(part.text.split()[1]) == pytest.approx(MM*raw.overlap(f"{side}F", k), rel=4e-3)
    return closed


def number_of(x: float) -> str:
    """Three digits, at most one decimal."""
    return f"{x:.{min(max(2 - int(np.floor(np.log10(x))), 0), 1)}f}"


def apart(drawn: np.ndarray, outline: np.ndarray) -> float:
    """How far the points of an outline are from what is drawn, at most [m]."""
    a, b = drawn[:-1, None], drawn[1:, None]
    share = np.clip(((outline - a)*(b - a)).sum(-1)/np.maximum(((b - a)**2).sum(-1), 1e-30), 0, 1)
    return float(np.hypot(*np.moveaxis(a + share[..., None]*(b - a) - outline, -1, 0)).min(axis=0).max())


def test_a_picture_for_a_paper(browser: Browser, report: Path, world: World):
    """PDF has the words of SVG, in the colours of paper in a dark window too; one page of the same size."""
    browser.size(1366, 860, dark=True)
    browser.open(report, "#view=left")
    seen = 0
    for picture in lambda kind: chart_picture(browser, 1, kind), lambda kind: scene_picture(browser, kind):
        found, (page,) = parts(picture("SVG")), PdfReader(io.BytesIO(picture("PDF").encode("latin-1"))).pages
        paper = found[0]
        assert paper.what == "paper" and paper.colour == "#ffffff"
        assert [0.75*x for x in paper.points[3]] == pytest.approx([float(x) for x in page.mediabox[2:]], abs=0.01)
        # Signs that letters of Windows lack are in the font of symbols.
        signs = sum(bool(set("−←→Δ≈Φ") & set(part.text)) for part in found)
        assert page.get_contents().get_data().count(b"/S ") >= signs
        seen += signs
        drawn = page.extract_text()
        words = [part.text for part in found if re.fullmatch(r"[\w ,.\[\]−]+", part.text)]
        assert len(words) > 4 and all(text.replace("−", "-") in drawn.replace("−", "-") for text in words)
        assert browser.run("return document.documentElement.dataset.theme") == "dark" and browser.log() == []
    assert seen
    browser.open(report, "#c=roll&c=pitch")
    for chart, words in enumerate(("roll Φ [mrad]", "pitch Ω [rad]")):
        page, = PdfReader(io.BytesIO(chart_picture(browser, chart, "PDF").encode("latin-1"))).pages
        assert words in unicodedata.normalize("NFKC", page.extract_text())


def test_patches_lie_as_they_are(browser: Browser, report: Path, world: World, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    """Length in rolling direction upwards, along the profile across, by the scale below; pressure and colour of the contact."""
    raw = world.thrown
    browser.open(report, "#c=N_LT,N_LF,N_RT,N_RF")
    colours = {COLUMNS[words][0][2:]: look[0] for words, look in legend_of(parts(chart_picture(browser, 0))).items()}
    for contact in "LF", "RF":
        t = raw.t[raw.first_peak(contact)]
        go(browser, t)
        found = parts(saved(browser, "document.querySelector('#patches-save button').click()"))
        assert {part.what for part in found} == {"paper", "patch in words", "patch", "pressure", "scale"}
        asked = "--at", repr(float(t)), "--contact", contact, "-o", str(tmp_path/"p.png"), "--json"
        assert main(["pressure", str(raw.file), *asked]) == 0
        (told,) = json.loads(capsys.readouterr().out)["patches"]
        own = [part for part in found if part.name.get("contact") == contact]
        outline = next(part for part in own if part.what == "patch" and part.width)
        bar = next(part.points for part in own if part.what == "scale" and not part.text)
        size = next(float(part.text.split()[0]) for part in own if part.what == "scale" and part.text)
        across, along = np.nanmax(outline.points, axis=0) - np.nanmin(outline.points, axis=0)
        scale = np.ptp(bar[1:, 0])/(1e-3*size)
        assert (along/scale, across/scale) == pytest.approx((2*told["half_x"], 2*told["half_s"]), rel=0.06)
        assert along > 2*across         # a flange's patch is long in rolling direction: its profile curves there most
        assert outline.colour == colours[contact]
        words = next(part.text for part in own if part.what == "patch in words")
        assert words == f"{contact} {1e-6*told['largest']:.0f} MPa, {1e6*told['area']:.0f} mm²"
        curve = next(part.points for part in own if part.what == "pressure" and part.width)[1:]
        # The curve is that of the pressure through the middle: it rises from the base line to the full height once.
        assert np.ptp(curve[:, 1]) == pytest.approx(24, abs=0.5) and abs(np.ptp(curve[:, 0]) - across) < 3
        # It is no mirror image: the middle of the patch, from the flange's back on, which is on the left.
        assert (np.diff(curve[:, 0]) >= 0).all()
        patch, = run_patches(read_data(raw.file), raw.first_peak(contact), [contact])
        middle = patch.p[len(patch.x)//2]
        assert np.abs(middle - middle[::-1]).max() > 0.2*middle.max()
        assert (108 - curve[1:-1, 1])/24 == pytest.approx(middle/middle.max(), abs=0.03)
