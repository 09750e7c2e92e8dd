"""Numbers of the pages that stand beside the runs: geometry, side by side, comparison, study, formulations, profiles."""
from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from pypdf import PdfReader

import ldbench
from ldbench.__main__ import main
from ldbench.conicity import FINE_PITCH
from ldbench.plots.figures import overview_figures
from ldbench.plots.geometry import geometry_page
from ldbench.plots.style import ldbench_style
from ldbench.report import formulations
from ldbench.report.compare import comparison_figures, impact_pages
from ldbench.report.differences import compare
from ldbench.report.study import make_study
from probes import profile
from raw import Raw
from reading import Line, agree, differing, words_of
from specimen import World
from table import CRC, DEG, KN, MM, WORDS
from test_page import COLUMNS

RUN = r"\bex\d_aw\b"


@pytest.fixture(scope="module")
def faster(world: World, tmp_path_factory: pytest.TempPathFactory) -> tuple[ldbench.Run, Raw]:
    """The thrown wheelset with another velocity: it rises higher after the right flange than before."""
    case = world.run("ex2_aw").case.replace(vY=1.2, name="ex3_aw", table_file=world.outputs/"aw.table")
    run = ldbench.run(case)
    return run, Raw(Path(run.write(tmp_path_factory.mktemp("faster")/"ex3_aw.txt")))


def curve(ax: object, k: int = 0) -> np.ndarray:
    return np.asarray(ax.get_lines()[k].get_ydata(), float)


def test_geometry_page(world: World, tmp_path: Path):
    """Clearances in words and as lines, and every curve from the columns of the file, left and right."""
    run = world.run("ex2_aw")
    file = tmp_path/"geometry.txt"
    ldbench.ContactTable.quiet(run.case).write_geometry(file)
    names, *lines = file.read_text().splitlines()
    column = dict(zip(names.split(), np.array([line.split() for line in lines if line[0] != "#"], float).T, strict=True))
    with ldbench_style():
        figure = geometry_page(run, ldbench.read_columns(file))
    clearance = Line(r"left (\S+), right (\S+) mm", "clearances [mm]", lambda w: (10.18, 16.945), 1e-3)
    assert differing(words_of(figure), [clearance], world, [CRC]) == []
    axes = {ax.get_ylabel(): ax for ax in figure.axes}
    for label, scale, *drawn in (
            ("contact angle [°]", DEG, "angle_L", "angle_R"), ("rolling radius [mm]", MM, "radius_L", "radius_R"),
            ("contact position, outward |y| [mm]", MM, "y_L", "-y_R"), ("contact position z [mm]", MM, "z_L", "z_R"),
            ("Δr = left − right [mm]", MM, "delta_r"), ("equivalent conicity", 1, "conicity"), ("roll Φ [mrad]", 1e3, "roll"),
            ("height Z [mm]", MM, "Z")):
        for k, name in enumerate(drawn):
            x = scale*column[name.lstrip("-")]*(-1 if name[0] == "-" else 1)
            np.testing.assert_allclose(curve(axes[label], k), x, rtol=1e-12, err_msg=label)
        if len(drawn) == 2:
            assert [line.get_label() for line in axes[label].get_lines()[:2]] == ["left", "right"]
        ends = [line.get_xdata()[0] for line in axes[label].get_lines()[-2:]]
        assert ends == pytest.approx([-16.945, 10.175], abs=1e-3)
    np.testing.assert_allclose(column["delta_r"], column["radius_L"] - column["radius_R"], atol=1e-8)


def test_side_by_side(world: World, faster: tuple[ldbench.Run, Raw]):
    """Y, forces of both flanges, first contact and kinetic energy of each run; shares, peak, duration, impulse of the contact."""
    runs, raws = [world.run("ex2_aw"), faster[0]], [world.thrown, faster[1]]
    with ldbench_style():
        (_, beside), (_, contacts) = overview_figures(runs)
    assert differing(words_of(beside), [], world, [r"^Exercises? \d(?: to \d)?"]) == []
    for row, raw in zip(np.reshape(beside.axes, (2, 4)), raws, strict=True):
        kinetic = sum(raw.c[f"KE_{part}"] for part in ("lat", "vert", "roll"))
        for drawn, x in ((curve(row[0]), MM*raw.c["Y"]), (curve(row[1]), KN*raw.c["N_LF"]), (curve(row[1], 1), -KN*raw.c["N_RF"]),
                         (curve(row[3]), kinetic), (curve(row[2]), KN*raw.c["N_LF"][raw.first("LF")])):
            assert (drawn.max(), drawn.min()) == pytest.approx((x.max(), x.min()), rel=1e-7)
        t = row[2].get_lines()[0].get_xdata()
        assert t[curve(row[2]).argmax()] == pytest.approx(1e3*(raw.t[raw.first_peak("LF")] - raw.start("LF")), abs=1e-6)
    ones = [raw.impact("LF") for raw in raws]
    shares = [[100*one[f"{part}_after"]/sum(one[f"{other}_before"] for other in ("lat", "vert", "roll"))
               for part in ("lat", "vert", "roll")] for one in ones]
    assert [len([x for x in own if x > 6]) for own in shares] == [2, 3], "the lines differ in length"
    lines = [Line(r"(?<!%) (\d+) % (\d+) %$", "shares of lateral and vertical motion, exercise 2 [%]", lambda w: shares[0][:2]),
             Line(r"^(\d+) % (\d+) % (\d+) %$", "shares of lateral, vertical and roll motion, exercise 3 [%]", lambda w: shares[1])]
    assert differing(words_of(contacts), lines, world, [r"exercises 1 to 4", r"powers 6/5, -1/5 and 1 of"]) == []
    axes = {ax.get_ylabel(): ax for ax in contacts.axes}
    for label, key, scale in (
            ("peak N [kN]", "peak", KN), ("duration [ms]", "duration", 1e3), ("impulse ∫N dt [kN·s]", "impulse", KN)):
        assert curve(axes[label]) == pytest.approx([scale*one[key] for one in ones], rel=1e-6), label
    speeds = [[raw.c["vY"][k] for raw in raws for k in ks(raw)] for ks in (
        lambda raw: [0], lambda raw: [raw.first("LF").stop - 1])]
    assert curve(axes["lateral velocity after / before, reversed"]) == pytest.approx(-np.divide(speeds[1], speeds[0]), rel=1e-6)


def test_highest_to_the_left_is_before_the_right_flange(faster: tuple[ldbench.Run, Raw]):
    """The page of formulations tells the right moment, in a run that rises higher later."""
    run, raw = faster
    left = raw.t <= raw.start("RF")
    assert raw.c["Z"].max() > 1.2*raw.c["Z"][left].max()
    assert formulations.outcome(run, "elastic").results["climb"] == pytest.approx(raw.c["Z"][left].max(), rel=1e-9)


# Comparison --------------------------------------------------------------------------------

def difference(a: Raw, b: Raw, column: str) -> np.ndarray:
    """At the rows of the first file, along straight lines between those of the second; where a contact is closed in both."""
    d = np.interp(a.t, b.t, b.c[column]) - a.c[column]
    if column.partition("_")[0] in ("angle", "y", "z", "radius"):
        k = np.clip(np.searchsorted(b.t, a.t), 1, len(b.t) - 1)
        closed = np.isfinite(b.c[column])
        d[~(np.isfinite(a.c[column]) & (closed[k] & closed[k - 1]))] = np.nan
    return d


def test_comparison_pages(world: World):
    """Every table: rows and times of the files, events, peaks, impacts by number, differences of every column."""
    a, b = world.thrown, world.pushed

    def events(_: object, match: re.Match[str]) -> list[float | None]:
        """First events of a kind [ms], ends [ms] or largest forces [kN]: of both files, and the difference."""
        kind = match[0].partition(" ")[2].removeprefix("first ").partition(" [")[0]
        contact = next((c for c, words in WORDS.items() if kind == f"largest normal force, {words}"), None)
        found = [KN*raw.peak(contact)[0] or None if contact else 1e3*raw.t[-1] if kind == "end" else
                 next((1e3*t for t, what, _ in raw.events if what == kind), None) for raw in (a, b)]
        return [*found, None if None in found else found[1] - found[0]]

    def impacts(_: object, match: re.Match[str]) -> list[float | None]:
        """The first impacts by all their numbers; later ones of the ramp open between its rows."""
        words, number = match[0].rsplit(" ", 10)[0].rsplit(" ", 1)
        contact, k = next(c for c, name in WORDS.items() if name == words), int(number) - 1
        found = []
        for raw in a, b:
            rows = [rows for rows in raw.episodes(contact) if rows.start > 0]
            found.append(raw.exchange(contact, rows[k]) if k < len(rows) else None)
        return [None if one is None else scale*one[key] for key, scale in (
            ("start", 1e3), ("duration", 1e3), ("peak", KN), ("impulse", KN), ("angle", DEG)) for one in found]

    def differences(_: object, match: re.Match[str]) -> list[float | None]:
        column, _, scale = COLUMNS[match[0].strip().partition(" [")[0]]
        d = difference(a, b, column)
        known = np.isfinite(d)
        if not known.any():
            return [None, None, None, 0.0]
        k = int(np.nanargmax(np.abs(d)))
        return [None, scale*d[k], 1e3*a.t[k], 100*known.mean()]

    n = r" (\S+)"
    lines = [Line(rf"^ex{k}_aw .* ldbench \S+ halfspace{n} 0 to{n} ", "rows; last time [s]",
                  lambda w, raw=raw: (len(raw.t), raw.t[-1]), 1e-4) for k, raw in ((2, a), (5, b))]
    lines.append(Line(rf"^ex5_aw [a-z -]+(?:, [a-z ]+)? \[\S+\]{n}{n}{n}$", "events and forces", events, often=True))
    row = rf"^(?:left|right) (?:flange|tread) \d+{n*10}$"
    table = rf"^ +(?:.* )?\[\S+\]{n}{n}{n}{n}$"
    seen: list[str] = []
    with ldbench_style():
        compared = compare([world.run("ex2_aw"), world.run("ex5_aw")])
        pages = [(title, words_of(figure)) for title, figure in comparison_figures(compared)]
        for title, text in pages:
            own, labels = [], [RUN]
            if "files" in title:
                own = lines
            elif "differences" in title:
                for match in re.finditer(table, text, re.MULTILINE):
                    truth = differences(None, match)
                    for k in range(1, 4):
                        assert agree(match[k + 1].replace("−", "-"), truth[k], 2e-4), (match[0], truth)
                    column, _, scale = COLUMNS[match[0].strip().partition(" [")[0]]
                    d = difference(a, b, column)
                    if np.isfinite(d).all():
                        mean = np.sum(np.diff(a.t)*(d[1:]**2 + d[:-1]**2)/2)/a.t[-1]
                        assert agree(match[1], scale*np.sqrt(mean), 0.02), (match[0], mean)
                labels = [RUN, table]
            elif title.startswith("impacts of"):
                for match in re.finditer(row, text, re.MULTILINE):
                    for k, truth in enumerate(impacts(None, match), 1):
                        # The ramp has a row each millisecond, in which its later contacts open.
                        slack = 2e-4 if k % 2 else 0.05 if k not in (4, 8) or " 1 " in match[0] else 9.0
                        assert agree(match[k], truth, slack), (match[0], k, truth)
                labels = [RUN, row, r"\d+ more impacts"]
            elif "laid on each other" in title:
                own = [Line(r"^(?:left|right) (?:flange|tread) \d+: (\S+) ms$", "begin of an impact [ms]",
                            lambda w, m: impacts(w, re.match(".*", m[0].partition(":")[0] + 10*" –"))[0], often=True)]
            seen.append(title)
            assert differing(text.replace("−", "-"), own, world, labels) == [], title
    assert len(seen) > 15


def test_impacts_of_few_rows_are_counted(world: World, tmp_path: Path):
    """In a file with every third row of the thrown wheelset; contacts that are closed in the first or last row are no impacts."""
    names, *lines = world.thrown.text.splitlines()
    rows = [k for k, line in enumerate(lines) if line[0] != "#"]
    left_out = set(rows) - set(rows[::3])
    file = tmp_path/"thin.txt"
    file.write_text("\n".join([names, *(line for k, line in enumerate(lines) if k not in left_out)]) + "\n")
    thin = Raw(file)
    closed = [episode.stop - episode.start - 2 for contact in WORDS for episode in thin.episodes(contact)
              if episode.start > 0 and episode.stop < len(thin.t)]
    few = sum(n < 6 for n in closed)
    assert 0 < few < len(closed) and {5, 6} <= set(closed), closed
    with ldbench_style():
        title, figure = next(impact_pages(compare([world.run("ex2_aw"), ldbench.read_run(file)])))
    assert title == "impacts of ex2_aw thin.txt"
    assert f"\nex2_aw thin.txt: {few} impacts have fewer than 6 rows, so their numbers are rough" in words_of(figure)


def test_study(world: World, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """The differences of every variant, from its files: rms of Y and of the left flange, first peak, end; the bars beside them."""
    monkeypatch.chdir(world.folder)
    target, _ = make_study(Path("inputs"), tmp_path, 2, ramp_end=0.3)
    first, *others = (page.extract_text() for page in PdfReader(target).pages)

    def row(name: str) -> list[float]:
        fine, *variants = (Raw(tmp_path/f"study/{name}_{which}.txt") for which in ("fine", "law", "step"))
        found = []
        for column, early, scale in ("Y", True, 1e6), ("Y", False, MM), ("N_LF", True, KN), ("N_LF", False, KN):
            for one in variants:
                rows = fine.t <= min(fine.t[fine.first("LF").stop - 1] if early else np.inf, one.t[-1])
                d, t = difference(fine, one, column)[rows]**2, fine.t[rows]
                found.append(scale*np.sqrt(np.sum(np.diff(t)*(d[1:] + d[:-1])/2)/t[-1]))
        found += [100*(one.impact("LF")["peak"]/fine.impact("LF")["peak"] - 1) for one in variants]
        return found + [1e3*(one.t[-1] - fine.t[-1]) for one in variants]

    lines = [Line(f"^{name}" + 12*r" (\S+)" + "$", "differences, of law and step in turn", lambda w, name=name: row(name), 0.01)
             for name in ("ex2_aw", "ex5_aw")]
    labels = [r"steps? (?:of )?0\.1 ms", r"exercise 5 cut short", r"\d / \d+$", r"^10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+$"]
    assert differing(first, lines, world, labels) == []
    assert not any(re.search(r"\d (?:mm|kN|ms|µm|%)", text.replace("step 0.1 ms", "")) for text in others)


def test_formulations(world: World):
    """How much results depend on the formulation, from the values beside; exercise 5 with elastic contact from its rows."""
    kept = json.loads((world.outputs/".ldbench/formulations.json").read_text())
    found = [formulations.Outcome(**one) for one in kept]
    with ldbench_style():
        pages = {title: words_of(figure) for title, figure in formulations.figures(found, world.folder/"inputs")}
    values = pages.pop("values").split("\nExercise 5 ")

    def row(words: str, exercise: int) -> list[float]:
        match = re.search(rf"^{re.escape(words)}(?: \[.*\])? ([-\d.–]+(?: [-\d.–]+){{4}})$", values[exercise == 5], re.MULTILINE)
        return [float("nan" if cell == "–" else cell) for cell in match[1].split(" ")] if match else [np.nan]*5

    lines = []
    for words in ("first left flange contact", "largest Y", "highest, to the left", "impulse of the first left flange contact",
                  "first right flange contact", "return to the centre", "derailment", "lateral force at derailment"):
        shown = [np.array(row(words, exercise)) for exercise in (2, 5)]
        known = [np.isfinite(one[0]) and np.isfinite(one[1:]).any() for one in shown]
        shares = [100*np.nanmax(np.abs(one[1:]/one[0] - 1)) for one, there in zip(shown, known, strict=True) if there]
        cells = [(r"(\S+) %" + ("" if np.isfinite(one).all() else r" \*")) if there else "–"
                 for one, there in zip(shown, known, strict=True)]
        # The values beside have four digits, which is up to 0.1 % of their ratio.
        slack = max(2e-3, *(0.1/share for share in shares if share > 0))
        lines.append(Line(rf"^{words} {' '.join(cells)}$", f"{words} [%]", lambda w, shares=shares: shares, slack))
    hops = [row("lift-offs of both wheels", exercise) for exercise in (2, 5)]
    lines.append(Line(r"^lift-offs of both wheels (\d+) to (\d+) (\d+) to (\d+)$", "fewest and most lift-offs",
                      lambda w: [end(x) for x in hops for end in (min, max)]))
    labels = [RUN, r"e = (?:1|0\.5|0)\b", r"^exercise [1-4]$", r"restitution 1, 0\.5 and 0\.", r"below 3 %|to\s+30 %",
              r"exercises 1 to 4|^Exercise \d"]
    for title, text in pages.items():
        assert differing(text, lines if title.startswith("which") else [], world, labels) == [], title
    raw = world.pushed
    for words, truth, slack in (
            ("first left flange contact", raw.start("LF"), 5e-4), ("largest force of a left flange", KN*raw.peak("LF")[0], 5e-4),
            ("derailment", raw.t[-1], 5e-4), ("lateral force at derailment", KN*raw.c["F_ext"][-1], 5e-4)):
        assert row(words, 5)[0] == pytest.approx(truth, rel=slack), words


# Profiles ----------------------------------------------------------------------------------

def test_profile(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, world: World):
    """What the command prints of a wheel and a rail: from the points of the files and the radii that they were made with."""
    monkeypatch.setattr("ldbench.geometry.pair.FINE_PITCH", 5*FINE_PITCH)       # rows of the geometry, five times as far apart
    folder = Path(__file__).parents[2]/"profiles"
    wheel, right = folder/"awprof.yz", folder/"swprof.yz"
    assert main(["profile", str(wheel), str(folder/"arprof.yz"), "--set", f"wheel_profile_right={right}", "-o",
                 str(tmp_path/"page.pdf")]) == 0
    text = capsys.readouterr().out.replace(str(tmp_path), "")
    y, z = 1e3*profile("awprof").T
    tape = np.interp(70.0, y, z)
    face = (y > y[z.argmin()]) & (y < 60)
    below = np.interp(tape - 10, z[face], y[face])
    tip = np.interp(z.min() + 2, z[face], y[face])
    lines = [
        Line(r"^wheel awprof.yz: (\d+) points", "points", lambda w: len(y)),
        Line(r"^rail arprof.yz: (\d+) points", "points", lambda w: len(profile("arprof"))),
        Line(r"height Sh (\S+) mm", "flange height [mm]", lambda w: tape - z.min(), 1e-3),
        Line(r"thickness Sd (\S+) mm", "flange thickness [mm]", lambda w: below - y.min(), 1e-3),
        Line(r"qR (\S+) mm", "qR [mm]", lambda w: below - tip, 5e-3),
        Line(r"flange angle (\S+) °", "steepest angle [deg]", lambda w: 75.0),
        Line(r"tread slope (\S+) \(1:(\S+)\)", "tread slope", lambda w: (1/40, 40)),
        Line(r"hollow of the tread (\S+) mm", "hollow [mm]", lambda w: 0.0),
        Line(r"crown radius (\S+) mm", "10 inches [mm]", lambda w: 254.0),
        Line(r"shoulder radius (\S+) mm", "1 1/4 inches [mm]", lambda w: 31.75, 2e-3),
        Line(r"corner radius (\S+) mm", "9/16 inch [mm]", lambda w: 14.2875),
        Line(r"gauge point at y (\S+) mm", "the origin [mm]", lambda w: 0.0),
        Line(r"inclination (\S+) \(1:(\S+)\)", "cant", lambda w: (1/40, 40)),
        Line(r"clearance left (\S+), right", "left clearance, of the call [mm]", lambda w: 10.18),
        Line(r"equivalent conicity at [234] mm: level (\S+),", "taper of the tread", lambda w, m: 1/40, 0.03, often=True)]
    # test_profile_page and test_en15302 have these.
    labels = [CRC, r"below \S+ mm", r"top of rail at y .*$", r"right \S+ mm$", r"\bwith roll.*$", r"nonlinearity .*$",
              r"(?:rolling radii coefficient|parameter at) .*$", r"zone of the .*$"]
    assert differing(text, lines, world, labels) == []
