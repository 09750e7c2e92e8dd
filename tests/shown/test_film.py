"""Pictures and frames of films: what they show of one run and of several, at which scale, and where they look."""
from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex
from matplotlib.lines import Line2D
from matplotlib.patches import FancyArrow, Polygon
from matplotlib.text import Text
from PIL import Image
from pypdf import PdfReader

import ldbench
from invented import altered
from ldbench.__main__ import main
from ldbench.plots.named import Shown
from ldbench.plots.style import SERIES, ldbench_style
from ldbench.results.run_data import RunData
from ldbench.viewer import film
from ldbench.viewer.film import Picture
from named_artists import artists, shown
from of_runs import COMPARED
from probes import gaps, left_rail, left_wheel, turned
from raw import PAIR, Raw
from reading import Line, differing, words_of
from specimen import World
from table import COLUMNS, DEG, KN, MM, WORDS
from walk import Compare, label_of, walk


def drawn(*runs: RunData, end: float = 0.1) -> Picture:
    with ldbench_style():
        return Picture(runs, 0.0, end, 1e-3, None)


def words(picture: Picture, t: float) -> list[str]:
    """The texts of a picture at time t."""
    still = [text.get_text() for text in picture.figure.findobj(Text) if text.get_text()]
    return still + [words for _, words, _, _ in picture.words(t)]


def at(raw: Raw, t: float, *names: str) -> np.ndarray:
    """Columns at a moment, between rows."""
    return np.array([np.interp(t, raw.t, raw.c[name]) for name in names])


def comparisons(picture: Picture, t: float) -> dict[str, Compare]:
    """What a picture shows at a moment."""
    def compare_force(raw: Raw, ax: Axes, arrow: FancyArrow) -> None:
        """By the scale beside it; its point is the tail."""
        contact, scene = shown(arrow).y[-2:], next(one for one in picture.scenes if one.ax is ax)
        assert (shown(arrow).y, shown(arrow).x) == (f"Fz_{contact}", f"Fy_{contact}")
        force = at(raw, t, f"Fy_{contact}", f"Fz_{contact}")
        assert arrow.get_visible() == (np.hypot(*force) > 1)
        if arrow.get_visible():
            corners, unit = arrow.get_xy(), np.ptp(scene.scale_arrow.get_xy()[:, 0])/scene.scale_force
            assert corners[0] - (corners[3] + corners[4])/2 == pytest.approx(unit*force, abs=1e-9)
        same_colour(contact, arrow.get_facecolor())

    def compare_place(raw: Raw, ax: Axes, point: Line2D) -> None:
        """In the frame of the track."""
        contact = shown(point).y[2:4]
        assert point.get_visible() == (at(raw, t, f"N_{contact}")[0] > 1)
        if point.get_visible():
            assert point.get_xydata()[0] == pytest.approx(at(raw, t, f"y_{contact}", f"z_{contact}"), rel=1e-9)
        same_colour(contact, point.get_color())

    def same_colour(contact: str, colour: Any) -> None:
        """A contact of a single run has the colour of its curve."""
        if not picture.several:
            curve = next(line for line in picture.charts[f"N_{contact}"].lines if shown(line).y.startswith(f"N_{contact} "))
            assert to_hex(colour) == to_hex(curve.get_color()), contact

    def compare_body(raw: Raw, ax: Axes, body: Polygon) -> None:
        """Wheels are where the columns have them, rails where the profile is."""
        what, _, side = shown(body).y.partition(" ")
        sign, letter = {"left": 1, "right": -1}.get(side, 0), side[:1].upper()
        if what == "wheel":
            pose = at(raw, t, "Y", "Z") + [0, raw.setting("axle_height")]
            expected = turned(left_wheel(PAIR[letter]), sign*(raw.setting("axle_roll") + at(raw, t, "roll")[0]))*[sign, 1] + pose
            assert np.abs(gaps(expected, body.get_xy())).max() < 1e-4
        elif what == "rail":
            assert np.abs(gaps(left_rail(PAIR[letter])*[sign, 1], body.get_xy())).max() < 1e-4
        else:
            assert what == "axle"

    def compare_moment(raw: Raw, ax: Axes, line: Line2D) -> None:
        """The moment of the picture in all charts."""
        assert shown(line).x == "time [ms]" and line.get_xdata() == pytest.approx([1e3*t]*2)

    return {**COMPARED, "force": compare_force, "place": compare_place, "body": compare_body, "moment": compare_moment,
            "scale": lambda *_: None}


def words_at(raw: Raw, name: str, k: int) -> list[Line]:
    """Clock, pose and, below the close-up of its wheel, force and angle of a flange at its peak."""
    contact = name[-2:]
    return [Line(r"^ *(\S+) ms   1:1,000$", "time [ms], at the speed asked for", lambda w: 1e3*raw.t[k]),
            Line(r"^Y (\S+) mm,  Z (\S+) mm,  Φ (\S+) mrad", "pose [mm, mm, mrad]",
                 lambda w: [1e3*raw.c[column][k] for column in ("Y", "Z", "roll")]),
            Line(r"flange (\S+) kN at (\S+)°", "force [kN], angle [deg]",
                 lambda w: (KN*raw.c[f"N_{contact}"][k], DEG*raw.c[f"angle_{contact}"][k]))]


@pytest.mark.parametrize(("names", "moment"), [(["ex2_aw"], "LF"), (["ex2_aw"], "RF"), (["ex2_aw", "ex3_aw"], "RF")], ids=str)
def test_what_is_drawn(names: list[str], moment: str, world: World):
    """Curves of charts with their legends and units; points, arrows by the scale beside them, wheels and rails of their sides;
    words of the moment, below the close-up of their wheel; a file of lines and letters has the words of the frame."""
    raws, k = {name: world.raw(name) for name in names}, world.thrown.first_peak(moment)
    runs, t = [world.run(name) for name in names], world.thrown.t[k]
    moving, picture = drawn(*runs), drawn(*runs)
    frame = words(moving, t)
    below = {("left" if min(scene.ax.get_xlim()) > 0 else "right"): text for (x, _), text, *_ in [*picture.words(t)][2:]
             for scene in picture.scenes[1:] if scene.ax.get_position().x0 < x < scene.ax.get_position().x1}
    figure = picture.still_figure(t)
    assert sorted(text.get_text() for text in figure.findobj(Text) if text.get_text()) == sorted(frame)
    assert not [artist for artist in figure.findobj() if artist.get_animated() and artist.get_visible()]
    for scene in picture.scenes:
        assert {f"{KN*scene.scale_force:g} kN", f"{MM*scene.scale_length:g} mm"} <= set(frame)
    if len(names) == 1:
        text = "\n".join([*(words for _, words, *_ in moving.words(t)), words_of(moving.figure)])
        assert differing(text, words_at(world.thrown, moment, k), world, [r"^Exercise \d", r"^\d+ (?:mm|kN)$"]) == []
        side, other = ("left", "right") if moment == "LF" else ("right", "left")
        assert "flange" in below[side] and "flange" not in below[other]

    def words_of_run(one: Artist) -> str:
        """A picture of several runs has the words of each in its title."""
        if len(names) == 1:
            return label_of(one)
        titles = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
        return next((words for words in titles if words.startswith(f"{shown(one).of}: ") and shown(one).how == "rows"), "")

    def says(label: str, names: Shown, raw: Raw) -> bool:
        return (label in COLUMNS and names.y == f"{COLUMNS[label][0]} [{COLUMNS[label][1]}]") or label.startswith(f"{names.of}: ")

    for ax in figure.axes:
        for legend in [ax.get_legend()] if ax.get_legend() else []:
            assert {text.get_text() for text in legend.get_texts()} == {line.get_label() for line in ax.lines if label_of(line)}
        for line in (line for line in ax.lines if shown(line).how == "rows"):
            column, label = shown(line).y.partition(" [")[0], ax.get_ylabel() or ax.get_title(loc="left")
            assert COLUMNS[line.get_label()][0] == column and line.get_label().startswith(label.partition(" [")[0])
    assert walk(figure, comparisons(picture, t), None, raws, says, words_of_run, ["outlines"]) > 40
    assert {shown(one).y[-2:] for _, one in artists(figure) if shown(one).how == "force"} == set(WORDS)
    assert [scene.ax.get_title() for scene in picture.scenes] == ["", "left wheel", "right wheel"]
    assert all(np.sign(np.mean(scene.ax.get_xlim())) == side for scene, side in zip(picture.scenes[1:], (1, -1), strict=True))


def test_forces_after_the_film_do_not_count_for_the_scale(world: World):
    run = world.run("ex2_aw")
    assert drawn(run, end=0.01).scenes[1].scale_force < 0.2*drawn(run, end=world.thrown.t[-1]).scenes[1].scale_force


def test_two_runs(world: World):
    """Both have name, values, colours and rail; the one that has ended says so."""
    runs, raws = (world.run("ex2_aw"), world.run("ex3_aw")), (world.thrown, world.faster)
    picture, t = drawn(*runs), world.thrown.peak("LF")[1]
    said = words(picture, t)
    for run, raw in zip(runs, raws, strict=True):
        assert any(text.startswith(f"{run.name}: {run.heading[:20]}") for text in said)
        assert any(f"Y {1e3*np.interp(t, raw.t, raw.c['Y']):.2f} mm" in text for text in said)
    colours = [line.color for line in SERIES[:2]]
    assert [[line.color for line in scene.rails] for scene in picture.scenes] == [colours[:1]]*3       # both have the same rails
    assert all([line.get_color() for line in chart.get_lines()[:2]] == colours for chart in picture.charts.values())
    shorter, longer = sorted(zip(runs, raws, strict=True), key=lambda both: both[1].t[-1])
    assert t < shorter[1].t[-1] < longer[1].t[-1] and not any("ended" in text for text in said)
    assert any(shorter[0].name in text and f"ended at {1e3*shorter[1].t[-1]:.1f} ms" in text
               for text in words(picture, longer[1].t[-1]))


def test_close_ups_are_where_the_rails_are():
    """The rail of a side is in the middle of the picture of this side, whatever the gauge."""
    case = ldbench.Case.exercise(3).replace(formulation="unilateral", gauge=1.668, back_to_back=1.58504, t_end=1e-3,
                                             table_folder="")
    picture = drawn(ldbench.run(case), end=1e-3)
    outlines = picture.actors[0].outlines
    for scene in picture.scenes[1:]:
        left, right = sorted(scene.ax.get_xlim())
        rail = outlines.left.rail[:, 0]*scene.side
        assert left < rail.min() - 0.02 and rail.max() + 0.02 < right and abs((left + right)/2 - rail.mean()) < 0.02
    assert np.abs(picture.scenes[0].ax.get_xlim()).min() > outlines.left.wheel[:, 0].max() + 0.05


def test_a_rail_that_pulls_is_drawn(world: World):
    """Contacts of bilateral constraints have negative forces, which point away from the wheel."""
    run = world.run("ex2_aw")
    picture = drawn(altered(run, data=run.data.assign(**{c: -run.data[c].abs() for c in ("N_LT", "Fy_LT", "Fz_LT")})))
    [*picture.scenes[1].move(0.005)]
    corners = picture.scenes[1].arrows[0, "LT"].get_xy()
    assert picture.scenes[1].arrows[0, "LT"].get_visible() and corners[0, 1] < corners[3, 1]
    assert any(text.startswith("tread −") for text in words(picture, 0.005))


@pytest.mark.parametrize("ending", ["gif", "mp4"])
def test_file(ending: str, world: World, tmp_path: Path):
    """All frames are in the file, and the wheelset moves."""
    target, rate = tmp_path/f"film.{ending}", film.RATES[f".{ending}"]
    assert main(["view", str(world.thrown.file), "-o", str(target), "--from", "0.02", "--to", "0.024",
                 "--speed", str(0.0041/3*rate)]) == 0
    if ending == "gif":
        from PIL import Image, ImageSequence

        with Image.open(target) as pictures:
            frames = [np.array(frame.convert("RGB")) for frame in ImageSequence.Iterator(pictures)]
    else:
        import imageio_ffmpeg

        reader = imageio_ffmpeg.read_frames(str(target))
        about = next(reader)
        assert about["codec"] == "h264" and about["fps"] == rate
        frames = [np.frombuffer(frame, np.uint8) for frame in reader]
    assert len(frames) == 4 and all(np.any(a != b) for a, b in pairwise(frames))


@pytest.mark.parametrize(("width", "runs"), [("84mm", 1), ("170mm", 1), ("170mm", 2), ("800px", 2), ("300mm", 1)])
def test_letters_of_a_picture(width: str, runs: int, world: World):
    """No letters are small, lie on each other or beyond the edge."""
    inches = float(width[:-2])/{"mm": 25.4, "px": 96}[width[-2:]]
    with ldbench_style():
        figure = Picture([world.run(name) for name in ("ex2_aw", "ex3_aw")[:runs]], 0.0, 0.1, None, None, inches).still_figure(0.02)
        renderer = FigureCanvasAgg(figure).get_renderer()
        figure.draw(renderer)
    legends = [ax.get_legend() for ax in figure.axes if ax.get_legend()] + figure.legends
    own = [text for text in (*figure.texts, *(text for legend in legends for text in legend.get_texts()),
                             *(text for ax in figure.axes for text in (*ax.texts, ax.title, ax._left_title, ax.yaxis.label)))
           if text.get_text() and text.get_visible()]
    assert min(text.get_fontsize() for text in own) >= 7 and len(own) > 10
    boxes = [text.get_window_extent(renderer) for text in own]
    for one, box in zip(own, boxes, strict=True):
        assert -1 <= box.x0 and box.x1 <= figure.bbox.width + 1 and 0 <= box.y0 and box.y1 <= figure.bbox.height, one
        assert not [other for other, far in zip(own, boxes, strict=True) if other is not one and box.overlaps(far)], one


@pytest.mark.parametrize(("width", "ending", "begins"), [
    ("300mm", "pdf", b"%PDF"), ("84mm", "svg", b"<?xml"), ("300mm", "png", b"\x89PNG"), ("800px", "png", b"\x89PNG")])
def test_picture(width: str, ending: str, begins: bytes, world: World, tmp_path: Path):
    """As wide as asked for, as the ending of the name says, with the same bytes again."""
    made = []
    for name in ("one", "two") if ending != "png" else ("one",):
        target = tmp_path/f"{name}.{ending}"
        assert main(["view", str(world.thrown.file), "-o", str(target), "--from", "0.02", "--width", width]) == 0
        made.append(target.read_bytes())
    assert made[0] == made[-1] and made[0].startswith(begins)
    number, unit = float(width[:-2]), width[-2:]
    if ending == "pdf":
        found = float(PdfReader(target).pages[0].mediabox.width)/72
    elif ending == "svg":
        found = float(re.search(r'width="([\d.]+)pt"', target.read_text())[1])/72
    else:
        with Image.open(target) as picture:
            found = picture.width/(300 if unit == "mm" else 96)
    assert found == pytest.approx(number/{"mm": 25.4, "px": 96}[unit], abs=0.01)


@pytest.mark.parametrize("words", ["170", "170cm", "9mm", "mm", "-170mm", "1e9px"])
def test_a_width_that_makes_no_sense(words: str, world: World, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    assert main(["view", str(world.thrown.file), "-o", str(tmp_path/"picture.svg"), f"--width={words}"]) == 2
    assert f"such as 170mm or 1280px, found {words}" in capsys.readouterr().err
    assert main(["view", str(world.thrown.file), "-o", str(tmp_path/"page.html"), "--width", "170mm"]) == 2
