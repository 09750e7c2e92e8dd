"""What the pages of a collation show of codes, held against the rows of the runs that their files were written from."""
from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from ldbench.plots.named import Shown
from named_artists import artists, shown
from probes import E_STAR, MASS, ROLL_INERTIA, WEIGHT as LOADED
from reading import agree, value
from table import DEG, KN, MM
from walk import look, walk

LABELS = {"lateral Y [mm]": "Y [mm]", "roll Φ [mrad]": "roll [mrad]", "energy − start [J]": "energy [J]", "N [kN]": "N_"}
FACTORS = {"mm": MM, "mrad": 1e3, "J": 1.0, "kN": KN}
PASSED, DOUBTFUL, FAILED, UNUSABLE, EMPTY, BEST = "#d9f0df", "#fdf0c4", "#f9d6cf", "#c9c9c9", "#f4f4f4", "#a9d8b8"
GRADES = {1e-3: BEST, 1e-2: PASSED, 0.1: DOUBTFUL, np.inf: FAILED}
# The heads of the table of numbers with their units: the number of collation.csv and the factor from SI.
NUMBERS = {"left flange [ms]": ("t_first_LF", 1e3), "right flange [ms]": ("t_first_RF", 1e3), "peak [kN]": ("first_peak_N_LF", KN),
           "impulse [kN·s]": ("first_impulse_LF", KN), "duration [ms]": ("first_duration_LF", 1e3), "rebound": ("rebound", 1.0),
           "return [ms]": ("t_return", 1e3), "energy error [%]": ("energy_error", 100.0)}
CHECKS = "checks_passed", "checks_doubtful", "checks_failed"
RADIUS = np.sqrt(0.457*0.254)      # of the circular contact that stands for the one of wheel and crown [m]


class File(NamedTuple):
    """The rows of a code's file in our columns, in SI."""

    rows: pd.DataFrame
    elastic: bool = True

    def energy(self) -> np.ndarray:
        """Kinetic energy, that of weight and load, and what treads store, less their sum at the start [J]."""
        c = self.rows
        found = (0.5*MASS*(c.vY**2 + c.vZ**2) + 0.5*ROLL_INERTIA*c.roll_rate**2 + LOADED*c.Z).to_numpy() + self.stored()
        return found - found[0]

    def stored(self) -> np.ndarray:
        """What elastic treads store by the theory of Hertz for a circular contact [J]."""
        forces = self.rows[["N_LT", "N_RT"]].clip(0).to_numpy()*self.elastic
        return (0.4*(9*forces**5/(16*E_STAR**2*RADIUS))**(1/3)).sum(axis=1)

    def start(self, contact: str) -> float:
        """The last row before the flange presses at its angle for the first time."""
        pressed = (self.rows[f"N_{contact}"] > 1) & (self.rows[f"angle_{contact}"].abs()*DEG > 25)
        return float(self.rows.time[max(int(np.argmax(pressed)) - 1, 0)])


def compare_code(file: File, ax: Axes, line: Line2D) -> None:
    """Every point lies on the straight lines between the rows; what treads store is known roughly."""
    name, _, unit = shown(line).y.removesuffix("]").partition(" [")
    t, x = line.get_data()
    rows = file.rows.time.to_numpy()
    if shown(line).x != "time [s]":
        contact = shown(line).x.split()[2]
        assert name == f"N_{contact}" and ax.get_title(loc="left") == f"normal force, {'left' if contact == 'LF' else 'right'} " \
            "flange, first contact"
        rows = 1e3*(rows - file.start(contact))
        early = (rows > t.min()) & (rows < t.max())
        shift = rows[early][int(np.argmax(file.rows[name][early]))] - t[int(np.argmax(x))]
        assert not x.any() or abs(shift) < 1.5*np.diff(rows).max(), "the touch lies between two rows"
        t = t + shift
    truth = FACTORS[unit]*(file.energy() if name == "energy" else file.rows[name].to_numpy())
    inside = (t >= rows[0]) & (t <= rows[-1]*(1 + 1e-6))
    slack = 10 + 0.15*np.interp(t, rows, file.stored()) if name == "energy" else 2e-5*np.ptp(truth)
    assert inside.mean() > 0.99 and np.all((np.abs(x - np.interp(t, rows, truth)) <= slack)[inside]), shown(line)


def compare_shade(source: Any, ax: Axes, box: Rectangle) -> None:
    """A cell of verdicts has the shade of the worst one, a difference that of its grade."""
    words = shown(box).y
    if counts := re.match(r"(\d+) / (\d+) / (\d+)\n", words):
        _, doubtful, failed = map(int, counts.groups())
        expected = {FAILED if failed else DOUBTFUL if doubtful else PASSED}
    elif words in ("–", "cannot\nbe used"):
        expected = {EMPTY if words == "–" else UNUSABLE}
    else:
        number, half = value(words.strip("()"))
        expected = {next(shade for limit, shade in GRADES.items() if x <= limit) for x in (number - half, number, number + half)}
    assert to_hex(box.get_facecolor()) in expected, shown(box)


def says(label: str, names: Shown, file: Any) -> bool:
    return label == names.of


def walk_codes(figures: Sequence[Figure], files: Mapping[str, File]) -> int:
    """Walk the curves of all codes and the matrices; a code looks alike in all of them."""
    looks: dict[str, set[Any]] = {}

    def compare_look(source: Any, ax: Axes, line: Line2D) -> None:
        """Beside the name of its code."""
        looks.setdefault(shown(line).of, set()).add(look(line)[:2])
        names = [text.get_text() for text in ax.texts if abs(text.get_position()[1] - line.get_ydata()[0]) < 1e-6]
        assert shown(line).of in names

    compared = {"rows": compare_code, "shade": compare_shade, "legend": compare_look}
    count = 0
    for figure in figures:
        for ax, one in artists(figure):
            if "shown" in vars(one) and shown(one).how == "rows":
                looks.setdefault(shown(one).of, set()).add(look(one)[:2])
                assert shown(one).y.startswith(LABELS[ax.get_ylabel()])
        count += walk(figure, compared, None, files, says)
    assert all(len(own) == 1 for own in looks.values()) and len(set.union(*looks.values())) == len(looks), looks
    return count


def check_numbers(rows: list[list[str]], heads: list[str], csv: pd.DataFrame) -> int:
    """Each number of a table against collation.csv: of each code, its distance from the median, the median, the ends; how many."""
    known = csv.pivot_table(index="code", columns="number", values="value", aggfunc="first")
    columns = [(NUMBERS[head], known[NUMBERS[head][0]]*NUMBERS[head][1]) for head in heads[1:-1]]
    code, count = "", 0
    for row in rows:
        for ((name, _), own), words in zip(columns, row[1:], strict=False):
            count += 1
            middle = float(own.median())
            if row[0] == "smallest to largest":
                assert all(agree(part, x) for part, x in zip(words.split("…"), (own.min(), own.max()), strict=True)), (name, words)
            elif row[0].startswith("    "):
                if words:
                    far = own[code] - middle if name == "rebound" else 100*(own[code]/middle - 1)
                    assert agree(words.removesuffix(" %").lstrip("+"), far), (code, name, words, far)
                assert bool(words) == (name != "energy_error" and np.isfinite(own[code]))
            else:
                code = row[0]
                assert agree(words, middle if code == "median" else own[code]), (code, name, words)
        if row[0] in known.index and row[-1] != "cannot be used":
            assert row[-1] == " / ".join(f"{known[name][code]:.0f}" for name in CHECKS)
    return count
