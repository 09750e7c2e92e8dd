"""Numbers of the pages that compare runs: any files, and the study of contact law and time step."""
from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

import ldbench
from ldbench.plots.style import ldbench_style
from ldbench.report.compare import comparison_figures, impact_pages
from ldbench.report.differences import compare
from ldbench.report.study import make_study
from named_artists import shown
from of_runs import COMPARED, FACTORS, UNITS
from raw import Raw, mean_square
from reading import Line, differing, words_of
from specimen import World
from table import COLUMNS, CONTACTS, DEG, KN, MM, WORDS
from walk import Compare, walk

WORDS_OF = {"Y": "lateral displacement Y", "N_LF": "normal force, left flange"}
RUN, ROUGH = r"\bex\d_aw\b", r"\d+ impacts have fewer than 6 rows"       # test_impacts_of_few_rows_are_counted


def between_rows(a: Raw, b: Raw, column: str) -> np.ndarray:
    """A column of the second file at the rows of the first, along straight lines; where a contact is closed on either side."""
    x = np.interp(a.t, b.t, b.c[column])
    x[a.t > b.t[-1]] = np.nan
    if column.partition("_")[0] in ("angle", "y", "z", "radius"):
        k = np.clip(np.searchsorted(b.t, a.t), 1, len(b.t) - 1)
        closed = np.isfinite(b.c[column])
        x[~(closed[k] & (closed[k - 1] | (a.t == b.t[k])))] = np.nan
    return x


def difference(a: Raw, b: Raw, column: str) -> np.ndarray:
    """Second file less first at the rows of the first."""
    return between_rows(a, b, column) - a.c[column]


def compared_with(reference: Raw, *others: Raw) -> dict[str, Compare]:
    """Curves of files that are compared as long as all have rows: overlays between rows, and differences from the reference."""
    until = min(raw.t[-1] for raw in (reference, *others))

    def compare(of: Callable[[Raw, Raw, str], np.ndarray]) -> Compare:
        def compared(raw: Raw, ax: Axes, line: Line2D) -> None:
            column, _, unit = shown(line).y.removesuffix("]").partition(" [")
            assert UNITS[column] == unit and shown(line).x == "time [s]"
            t, x = line.get_data()
            k = np.searchsorted(reference.t, t*(1 - 1e-9))
            np.testing.assert_allclose(t, reference.t[k], rtol=1e-8, atol=1e-12)
            truth = FACTORS[unit]*of(reference, raw, column)[reference.t <= until*(1 + 1e-9)]
            size = 1e-8*FACTORS[unit]*np.nanmax(np.abs(reference.c[column]), initial=1e-300)
            np.testing.assert_allclose(x, truth[k], rtol=1e-6, atol=size, err_msg=str(shown(line)))
            assert not np.isfinite(truth).any() or (np.nanmin(x), np.nanmax(x)) == pytest.approx(
                (np.nanmin(truth), np.nanmax(truth)), rel=1e-6, abs=size)
        return compared

    return {**COMPARED, "between rows": compare(between_rows), "difference": compare(difference)}


def check_titles(figure: Figure) -> None:
    """Panels on the left lie under the words of their column, those on the right under a difference."""
    for ax in figure.axes:
        for line in ax.lines:
            words = ax.get_title(loc="left").partition(" [")[0]
            if shown(line).how == "between rows":
                assert COLUMNS[words][0] == shown(line).y.partition(" [")[0]
            elif shown(line).how == "difference":
                assert words == "difference from the reference"
            else:
                contact, number = shown(line).x.split()[2:4]
                assert ax.get_title(loc="left").startswith(f"{WORDS[contact]} {number}: ") and shown(line).y == f"N_{contact} [kN]"


def test_comparison_pages(world: World):
    """Every table: rows and times of the files, events, peaks, impacts by number, differences of every column."""
    a, b = world.thrown, world.faster

    def back(raw: Raw) -> float | None:
        """The passage of the centre after turning back on both sides [ms]."""
        return next((1e3*t for t in raw.passages() if t > raw.start("LF") and t > raw.start("RF")), None)

    def events(_: object, match: re.Match[str]) -> list[float | None]:
        """First events of a kind [ms], returns and ends [ms] or largest forces [kN]: of both files, and the difference."""
        kind = match[0].partition(" ")[2].removeprefix("first ").partition(" [")[0]
        contact = CONTACTS.get(kind.removeprefix("largest normal force, "))
        found = [KN*raw.peak(contact)[0] or None if contact else 1e3*raw.t[-1] if kind == "end" else
                 back(raw) if kind == "return to the centre" else
                 next((1e3*t for t, what, _ in raw.events if what == kind), None) for raw in (a, b)]
        return [*found, None if None in found else found[1] - found[0]]

    def impacts(_: object, match: re.Match[str]) -> list[float | None]:
        """Begins, durations, peaks, impulses and angles of the contacts with a number that begin in the run, of both files."""
        words = match[0].partition(":")[0].split()
        contact, k, found = CONTACTS[" ".join(words[:2])], int(words[2]) - 1, []
        for raw in a, b:
            rows = [rows for rows in raw.episodes(contact) if rows.start > 0]
            found.append(raw.exchange(contact, rows[k]) if k < len(rows) else None)
        return [None if one is None else scale*one[key] for key, scale in (
            ("start", 1e3), ("duration", 1e3), ("peak", KN), ("impulse", KN), ("angle", DEG)) for one in found]

    def differences(_: object, match: re.Match[str]) -> list[float | None]:
        """Root of the mean square where the column is known all the time, the largest difference and its time, the share."""
        column, _, scale = COLUMNS[match[0].strip().partition(" [")[0]]
        d = difference(a, b, column)
        known = np.isfinite(d)
        if not known.any():
            return [None, None, None, 0.0]
        k = int(np.nanargmax(np.abs(d)))
        whole = known | (a.t > b.t[-1])
        return [scale*np.sqrt(mean_square(a.t[known], d[known])) if whole.all() else float(match[1]), scale*d[k], 1e3*a.t[k],
                100*known[a.t <= b.t[-1]].mean()]

    n = r" (\S+)"
    lines = {
        "files": [*(Line(rf"^{raw.file.stem} .* ldbench \S+ halfspace{n} 0 to{n} ", "rows; last time [s]",
                         lambda w, raw=raw: (len(raw.t), raw.t[-1]), 1e-4) for raw in (a, b)),
                  Line(rf"^ex3_aw [a-z -]+(?:, [a-z ]+)? \[\S+\]{n}{n}{n}$", "events and forces", events, often=True)],
        "differences": [Line(rf"^ +(?:.* )?\[\S+\]{n}{n}{n}{n}$", "differences", differences, 2e-4, often=True)],
        "impacts of": [Line(rf"^(?:left|right) (?:flange|tread) \d+{n*10}$", "impacts", impacts, 2e-4, often=True)],
        "laid on each other": [Line(r"^(?:left|right) (?:flange|tread) \d+: (\S+) ms$", "begin of an impact [ms]",
                                    lambda w, m: impacts(w, m)[0], often=True)]}
    with ldbench_style():
        found = comparison_figures(compare([world.run("ex2_aw"), world.run("ex3_aw")]))
        pages: dict[str, str] = {}
        for title, figure in found:
            pages[title] = words_of(figure)
            walk(figure, compared_with(a, b), a, {"ex2_aw": a, "ex3_aw": b}, lambda label, names, raw: label == names.of)
            check_titles(figure)
    for title, text in pages.items():
        own = [line for words, some in lines.items() if words in title for line in some]
        assert differing(text.replace("−", "-"), own, world, [RUN, r"\d+ more impacts", ROUGH]) == [], title
    assert len(pages) > 12 and all(any(words in title for title in pages) for words in lines)


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
        _, figure = next(impact_pages(compare([world.run("ex2_aw"), ldbench.read_run(file)])))
    assert f"\nex2_aw thin.txt: {few} impacts have fewer than 6 rows, so their numbers are rough" in words_of(figure)


def test_study(world: World, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """The differences of every variant, from its files: rms of Y and of the left flange, first peak, end; the bars beside them."""
    monkeypatch.chdir(world.folder)
    (tmp_path/"inputs").mkdir()
    shutil.copy("inputs/ex2_aw.nml", tmp_path/"inputs")
    drawn: list[Figure] = []
    monkeypatch.setattr("ldbench.report.study.save_document", lambda chapters, *_: drawn.extend(
        figure for _, pages in chapters for _, figure in pages))
    make_study(tmp_path/"inputs", tmp_path, 2)
    fine, *variants = (Raw(tmp_path/f"study/ex2_aw_{which}.txt") for which in ("fine", "law", "step"))
    row = []
    for column, early, scale in ("Y", True, 1e6), ("Y", False, MM), ("N_LF", True, KN), ("N_LF", False, KN):
        for one in variants:
            rows = fine.t <= min(fine.t[fine.first("LF").stop - 1] if early else np.inf, one.t[-1])
            row.append(scale*np.sqrt(mean_square(fine.t[rows], difference(fine, one, column)[rows])))
    row += [100*(one.impact("LF")["peak"]/fine.impact("LF")["peak"] - 1) for one in variants]
    row += [1e3*(one.t[-1] - fine.t[-1]) for one in variants]
    line = Line("^ex2_aw" + 12*r" (\S+)" + "$", "differences, of law and step in turn", lambda w: row, 0.01)
    labels = [r"steps? (?:of )?0\.1 ms", r"exercise 5 cut short", RUN, r"^Exercise \d"]
    summary, curves = drawn
    for figure, lines in (summary, [line]), (curves, []):
        assert differing(words_of(figure), lines, world, labels) == []

    def compare_bar(source: object, ax: Axes, bar: Rectangle) -> None:
        """The root mean square of a difference over that of the reference, above the name of the case."""
        column, words = re.fullmatch(r"rms of (\w+), (.*)", shown(bar).y).groups()
        case, which = shown(bar).of.split()
        one, early = variants[["law", "step"].index(which)], "first" in words
        assert ax.get_title(loc="left") == f"{WORDS_OF[column]}, {words}"
        rows = fine.t <= min(fine.t[fine.first("LF").stop - 1] if early else np.inf, one.t[-1])
        found = mean_square(fine.t[rows], difference(fine, one, column)[rows])
        until = fine.t <= one.t[-1]
        assert bar.get_height() == pytest.approx(np.sqrt(found/mean_square(fine.t[until], fine.c[column][until])), rel=0.01)
        below = ax.get_figure().axes[-1].get_xticklabels()
        assert [label.get_text() for label in below if label.get_position()[0] == round(bar.get_x() + bar.get_width()/2)] == [case]

    bars = {"bar": compare_bar}
    says = {"law": "law: one Hertz spring per zone", "step": "step: average acceleration, step 0.1 ms"}
    assert walk(summary, bars, None, says=lambda label, names, _: says[names.of.split()[1]] == label) > 8
    files = dict(zip(("half-spaces, cut steps", *(words.partition(": ")[2] for words in says.values())), (fine, *variants),
                     strict=True))
    assert walk(curves, compared_with(fine, *variants), fine, files, lambda label, names, raw: label == names.of) == 3*5
    check_titles(curves)
    times = {file: file.stat().st_mtime_ns for file in (tmp_path/"study").glob("*.txt")}
    make_study(tmp_path/"inputs", tmp_path, 2)
    assert times == {file: file.stat().st_mtime_ns for file in (tmp_path/"study").glob("*.txt")}, "runs that are there stay"
