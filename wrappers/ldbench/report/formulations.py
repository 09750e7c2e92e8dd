"""Elastic contact or constraint equations: effect of the choice on every result of the benchmark.

All exercises run with elastic contact, with both wheels held on their rails (bilateral), and with rigid contacts
that only push (unilateral), for several restitutions. In a report the elastic runs are those of the submitted column
files.
"""
from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from tqdm import tqdm

from .._core.calls import Progress
from .._core.files import make_results_folder, write_frame
from .._core.kept import kept_in, kept_json
from .._core.pools import in_threads
from ..case import Case
from ..plots.document import Chapter, save_document
from ..plots.frame import legend_of_page, new_page
from ..plots.style import BLUE, DASH_DOT, DASHED, DOTTED, GREEN, GREY, ORANGE, PURPLE, RED, Line
from ..plots.tables import draw_table
from ..plots.times import draw_curves
from ..results.contact_intervals import is_closed
from ..results.derived import cumulative
from ..results.quantities import KN, MM, OUTCOME, PAIRS, si_unit, significant
from ..results.run_data import RETURNED, RunData
from ..results.summary import drift_reference
from ..runs import compute
from ..table import ContactTable
from .jobs import find_cases, sources

FORMULATIONS: dict[str, dict[str, Any]] = {
    "elastic": {},
    "bilateral": {"formulation": "bilateral"},
    "unilateral, e = 1": {"formulation": "unilateral", "restitution": 1.0},
    "unilateral, e = 0.5": {"formulation": "unilateral", "restitution": 0.5},
    "unilateral, e = 0": {"formulation": "unilateral", "restitution": 0.0},
}
LINES = dict(zip(FORMULATIONS, (
    Line(BLUE, width=1.4), Line(RED, DASHED, 1.2), Line(GREEN, DASH_DOT), Line(ORANGE, DOTTED, 1.3), Line(PURPLE, width=0.8)),
    strict=True))
LONG_INTERVAL = 5e-3        # between rows of rigid contacts in exercise 5 [s]
LONG_STEP = 1e-3            # of rigid contacts there [s]: six digits are those of a quarter of it, where impacts lose energy
TURNED = 0.02               # roll that lifts the other wheel [rad]

# The results that are compared, by their names in `quantities.OUTCOME`.
RESULTS = ("t_first_LF", "Y_max", "climb", "first_impulse", "peak_N", "peak_P", "t_first_RF", "t_return", "lift_offs", "lost",
           "t_derailment", "F_derailment", "F_pulls")


@dataclass(frozen=True)
class Outcome:
    """The results of one run, and thinned curves."""
    case: str
    formulation: str
    results: Mapping[str, float]
    ending: str
    drift: float                          # relative to the kinetic energy at the start or the work of the force
    curves: Mapping[str, list[float]] = field(default_factory=dict)
    profiles: str = ""                    # in words, by the names of their files

    @property
    def exercise(self) -> int:
        """The number of the exercise."""
        return int(self.case[2])

    @property
    def pair(self) -> str:
        """The pair of profiles, 'aw' or 'sw'."""
        return self.case[-2:]


# Runs -------------------------------------------------------------------------------------

def outcomes(inputs: Path, jobs: int, told: Callable[[], object] = lambda: None,
             submitted: Sequence[RunData] = ()) -> list[Outcome]:
    """Run every exercise in every formulation; `told` is called after each run. An elastic run whose column file is
    submitted is not done again: its steps end at its rows, and with other rows exercise 5 derails at another load."""
    cases = find_cases(inputs)
    known = {one.name: one for one in submitted}
    tables: dict[str, ContactTable] = {}

    def tabled(case: Case) -> ContactTable:
        key = f"{case.profile_files()} {case.model}"
        if key not in tables:
            tables[key] = ContactTable.quiet(case)
        return tables[key]

    def work(task: tuple[Case, str], tell: Progress) -> Outcome:
        case, name = task
        if name == "elastic":
            return outcome(known[case.case_name] if case.case_name in known else compute(case, tell, tabled(case)), name)
        if case.stop_at == "derailment":
            case = case.replace(interval=LONG_INTERVAL, dt=LONG_STEP)
        return outcome(compute(case.replace(FORMULATIONS[name]), tell), name)

    todo = [(case, name) for case in cases for name in FORMULATIONS]
    results: dict[tuple[Case, str], Outcome] = {}
    for case in cases:
        if case.case_name not in known:
            tabled(case)
    for task, found in in_threads(work, sorted(todo, key=lambda task: -task[0].t_end), jobs):       # the longest first
        results[task] = found
        told()
    return [results[task] for task in todo]


def outcome(done: RunData, name: str) -> Outcome:
    """The results of a run and what its pages show."""
    c = done.data
    def first(kind: str, of: str = "t") -> float:
        return float(getattr(done.first(kind), of, np.nan))

    derailed = done.first("derailment") is not None
    rigid = "P_LF" in c
    t = c.time.to_numpy()
    pushed = cumulative(np.asarray(t), c.N_LF.to_numpy())
    blows = c.P_LF.to_numpy() if rigid else np.zeros(len(t))
    ramp = done.number("loading", "lateral_ramp") != 0
    left = ~(t > first("right flange contact"))
    results = {
        "t_first_LF": first("left flange contact"),
        "Y_max": done.header.results.get("farthest_left", float(c.Y.max())) if not (ramp or derailed) else np.nan,
        "climb": float(c.Z[left].max()) if not (ramp or derailed) else np.nan,
        "first_impulse": np.nan if ramp else first_impulse(done, pushed + blows),
        "peak_N": (done.peak("LF") or (np.nan,))[0],
        "peak_P": done.result("peak_P_LF") or np.nan,
        "t_first_RF": first("right flange contact"),
        "t_return": t[-1] if done.ending == RETURNED else np.nan,
        "lift_offs": sum(done.count(f"{side} wheel lift-off") or 0 for side in ("left", "right")),
        "lost": round(float(c.E_lost.iloc[-1]), 6) + 0.0 if rigid else 0.0,
        "t_derailment": first("derailment"),
        "F_derailment": first("derailment", "force") if ramp else np.nan,
        "F_pulls": first("rail pulls", "force") if ramp else np.nan,
    }
    keep = np.unique(np.linspace(0, len(t) - 1, 2500).astype(int))
    kinetic = (c.KE_lat + c.KE_vert + c.KE_roll).to_numpy()
    curves = {"t": t, "Y": c.Y.to_numpy(), "Z": c.Z.to_numpy(), "pushed": pushed + blows, "kinetic": kinetic,
              "roll": c.roll.to_numpy(), "F": c.F_ext.to_numpy()}
    return Outcome(done.name, name, {key: float(x) for key, x in results.items()}, why(done),
                   done.result("drift")/(drift_reference(done) or np.nan), {key: x[keep].tolist() for key, x in curves.items()},
                   done.pair)


def first_impulse(done: RunData, total: np.ndarray) -> float:
    """Impulse of the left flange until the wheelset moves to the right [N s]."""
    hit = done.first("left flange contact")
    back = np.flatnonzero((done.time > hit.t) & (done.values("vY") < 0)) if hit else np.empty(0, int)
    return float(total[back[0]]) if back.size else np.nan


def why(done: RunData) -> str:
    """How the run ended; of a derailment, whether over the flange or overturning."""
    derailment = done.first("derailment")
    if not derailment:
        awaited = "derail" if done.setting("integrator", "stop_at") == "derailment" else "return"
        return "returns" if done.ending == RETURNED else f"does not {awaited}"
    # How the flange came over the rail says it; on the crown both wheels may stand on their rails again.
    over = [event.t for event in done.events if event.kind.endswith("over rail") and event.t <= derailment.t]
    c = done.data
    end = c.iloc[min(c.time.searchsorted(max(over, default=derailment.t)), len(c) - 1)]
    side = np.sign(end.Y)
    words = f"derails over the {'left' if side > 0 else 'right'} rail: "
    if side*end.roll < -TURNED:
        return words + "overturns"
    other = ("N_RT", "N_RF") if side > 0 else ("N_LT", "N_LF")
    if done.formulation == "bilateral" or any(is_closed(end[name]) for name in other):
        return words + "rolls over the flange"
    return words + "jumps"


# Tables -----------------------------------------------------------------------------------

def table(found: Sequence[Outcome]) -> pd.DataFrame:
    """One row per case and result, one column per formulation, SI; and the spread about the elastic value."""
    rows = []
    for case in dict.fromkeys(o.case for o in found):
        own = {o.formulation: o for o in found if o.case == case}
        for key in RESULTS:
            values = {name: o.results[key] for name, o in own.items()}
            if not np.isfinite(list(values.values())).any():
                continue
            rows.append({"case": case, "result": in_short(key), "unit": si_unit(key), **values, "spread": spread(values)})
        rows.append({"case": case, "result": "ending", "unit": "", **{name: o.ending for name, o in own.items()},
                     "spread": "" if len({o.ending for o in own.values()}) == 1 else "differs"})
        rows.append({"case": case, "result": "energy drift, relative", "unit": "1",
                     **{name: o.drift for name, o in own.items()}, "spread": ""})
    return pd.DataFrame(rows)


def in_short(key: str) -> str:
    """A result in few words."""
    return OUTCOME[key].short or OUTCOME[key].words


def spread(values: Mapping[str, float]) -> float:
    """Largest difference from the elastic value over that, of the formulations that have the result; nan without
    two of them or if it is zero."""
    elastic = values["elastic"]
    others = [x for name, x in values.items() if name != "elastic" and np.isfinite(x)]
    return float(max(abs(x - elastic) for x in others)/abs(elastic)) if elastic and others else np.nan


# Compared one by one, or as a matter of what a formulation can say at all.
JUDGED = ("t_first_LF", "Y_max", "climb", "first_impulse", "t_first_RF", "t_return", "lift_offs", "t_derailment", "F_derailment")


def verdict_page(found: Sequence[Outcome], inputs: Path) -> Figure:
    """Draw the table of results: how much each of them depends on the formulation; how runs end, and what it takes to go over
    the flange."""
    cases = list(dict.fromkeys(o.case for o in found))
    figure = new_page(
        "Which results depend on the formulation?",
        "largest difference of a constraint formulation from elastic contact, over the elastic value",
        "constraint formulations: bilateral, both wheels held on the rails; unilateral, rigid contacts with restitution 1, "
        "0.5 and 0. *: of the formulations that have the result.\ngreen: below 3 %, any code may be compared; orange: up to "
        "30 %; red: the formulation decides. impulse: of forces and impacts, until the wheelset moves back. lift-offs: "
        "fewest to most. Over the flange: dashed, the kinetic energy at the start of exercises 1 to 4.")
    rows = [["", *cases]]
    rows += [[in_short(key), *(cell(found, case, key) for case in cases)] for key in JUDGED]
    rows.append(["ending", *("differs" if len({o.ending for o in found if o.case == case}) > 1 else "the same"
                             for case in cases)])
    body = figure.add_gridspec(2, 1, height_ratios=(1.2, 1))
    draw_table(figure.add_subplot(body[0]), rows, [0, *np.linspace(0.28, 1, len(cases) + 1)], size=7.5,
               look=lambda i, j: {"weight": "normal" if i and j else "bold"}, band=lambda i: "",
               shade=lambda i, j: colour(rows[i][j]) if i and j else "")
    below = body[1].subgridspec(1, 2, width_ratios=(1.7, 1))
    draw_endings(figure.add_subplot(below[0]), found, cases)
    draw_climb(below[1], inputs)
    return figure


def draw_endings(ax: Axes, found: Sequence[Outcome], cases: Sequence[str]) -> None:
    """How the runs of each case end."""
    rows = []
    for case in cases:
        groups: dict[str, list[str]] = {}
        for o in found:
            if o.case == case:
                groups.setdefault(o.ending, []).append(o.formulation.replace("unilateral, ", ""))
        rows.append([case, "; ".join(f"{ending} ({', '.join(names) if len(groups) > 1 else 'all'})"
                                     for ending, names in groups.items())])
    draw_table(ax, rows, (0, 0.1, 1), 1/11, left=(0, 1), size=7.5, look=lambda i, j: {"weight": "normal" if j else "bold"},
               band=lambda i: "")


def cell(found: Sequence[Outcome], case: str, key: str) -> str:
    """How much a result depends on the formulation, in words."""
    values = {o.formulation: o.results[key] for o in found if o.case == case}
    known = [x for x in values.values() if np.isfinite(x)]
    if not any(known):
        return "–"
    if key == "lift_offs":
        return f"{min(known):.0f} to {max(known):.0f}"
    share = spread(values)
    mark = "" if len(known) == len(values) else " *"
    return f"{significant(100*share)} %{mark}" if np.isfinite(share) else f"{len(known)} of {len(values)}"


def colour(word: str) -> str:
    """The background of a cell: green, orange or red."""
    if word in ("–", ""):
        return ""
    if word == "the same":
        return "#BFE5D6"
    found = re.match(r"(\S+) %", word)
    share = float(found[1]) if found else np.inf
    return "#BFE5D6" if share < 3 else "#FCE3B4" if share < 30 else "#F6C9B0"


def pair_words(found: Sequence[Outcome], pair: str) -> str:
    """The profiles of a pair, 'aw' or 'sw', in words."""
    return next((o.profiles for o in found if o.pair == pair and o.profiles), PAIRS[pair])


def values_page(found: Sequence[Outcome]) -> Figure:
    """All values, the pairs of profiles beside each other."""
    pairs = list(dict.fromkeys(o.pair for o in found))
    figure = new_page("Results by formulation", "", "e: unilateral, with this restitution; –: did not happen or does not exist")
    lines: list[list[str]] = []
    bold: set[int] = set()
    for exercise in sorted({o.exercise for o in found}):
        own = [next((o for o in found if (o.exercise, o.pair, o.formulation) == (exercise, pair, name)), None)
               for pair in pairs for name in FORMULATIONS]
        bold.add(len(lines))
        lines.append([f"Exercise {exercise}", *(name.removeprefix("unilateral, ") for _ in pairs for name in FORMULATIONS)])
        for key in RESULTS:
            known, values = OUTCOME[key], [o.results[key] if o else np.nan for o in own]
            if any(x for x in values if np.isfinite(x)):
                lines.append([known.brief, *map(known.text, values)])
        lines.append(["ending", *(o.ending.rpartition(": ")[2].removesuffix(" the flange") if o else "–" for o in own)])
    pair_heads = [pair_words(found, pair) if name == list(FORMULATIONS)[-1] else "" for pair in pairs for name in FORMULATIONS]
    rows = [["", *pair_heads], *lines]
    heads = {0, *(i + 1 for i in bold)}
    ax = figure.add_subplot()
    draw_table(ax, rows, [0, *(np.linspace(0.26, 1, len(pairs)*len(FORMULATIONS) + 1) - 0.005)], size=6.2,
               look=lambda i, j: {"weight": "bold" if i in heads else "normal"},
               band=lambda i: "#E6E6E6" if i - 1 in bold else "")
    for k in range(1, len(pairs)):
        ax.axvline(0.26 + 0.74/len(pairs)*k, color=GREY, linewidth=0.4)
    return figure


# Pages ------------------------------------------------------------------------------------

ROWS = (("Y", "lateral Y [mm]", MM), ("Z", "vertical Z [mm]", MM), ("pushed", "left flange: impulse [kN·s]", 1e-3),
        ("kinetic", "kinetic energy [J]", 1.0))
RAMP_LIMITS = {"Y": (-1, 25), "Z": (-2, 25), "kinetic": (-5, 300)}      # what follows is the fall


TOGETHER = (1, 2), (3, 4), (5,)                                         # exercises on a page


def exercises_page(found: Sequence[Outcome], exercises: Sequence[int]) -> Figure:
    """Some exercises in all formulations, a column for each pair of profiles."""
    shown = list(dict.fromkeys((o.exercise, o.pair) for k in exercises for o in found if o.exercise == k))
    figure = new_page(f"{together(exercises)}: elastic contact or constraint equations", "", (
        "impulse: of forces and, with rigid contacts, of impacts, in the direction of the contact normal; "
        "bilateral: both wheels held on the rails; unilateral: rigid contacts that only push, e: restitution"))
    axes = figure.subplots(len(ROWS), len(shown), sharex="col", squeeze=False)
    for column, (exercise, pair) in zip(axes.T, shown, strict=True):
        own = [o for o in found if (o.exercise, o.pair) == (exercise, pair)]
        for ax, (key, label, scale) in zip(column, ROWS, strict=True):
            draw_curves(ax, [(np.array(o.curves["t"]), scale*np.array(o.curves[key]), o.formulation, LINES[o.formulation])
                             for o in own], exercise == 5)
            if exercise == 5 and key in RAMP_LIMITS:
                ax.set_ylim(*RAMP_LIMITS[key])
            if ax in axes[:, 0]:
                ax.set_ylabel(label)
        words = pair_words(own, pair)
        column[0].set_title(f"Exercise {exercise}, {words}" if len(exercises) > 1 else words, loc="left")
        column[-1].set_xlabel("time [s]")
    figure.align_ylabels(axes)
    legend_of_page(figure, axes[0, 0].get_lines())
    return figure


def together(exercises: Sequence[int]) -> str:
    """'Exercise 5', 'Exercises 1 and 2'."""
    return f"Exercise{'s' if len(exercises) > 1 else ''} {' and '.join(map(str, exercises))}"


def draw_climb(place: SubplotSpec, inputs: Path) -> None:
    """Draw the work that lifts the wheelset over the flange with both wheels on the rails, beside the endings."""
    cases = {case.case_name[-2:]: case for case in find_cases(inputs)}.values()
    axes = place.subgridspec(1, len(cases)).subplots(sharey=True, squeeze=False)[0]
    for ax, case in zip(axes, cases, strict=True):
        made = climb(case)
        c = made.data
        ax.plot(MM*c.Y, c.PE_grav + c.PE_load, color=BLUE, linewidth=1.4)
        for exercise, v in enumerate((0.1, 0.5, 1.0, 2.0), 1):
            energy = 0.5*case.mass*v**2
            ax.axhline(energy, color=GREY, linewidth=0.8, linestyle=DASHED)
            ax.text(0.99, energy, f"exercise {exercise}", transform=ax.get_yaxis_transform(), ha="right", va="bottom", fontsize=6)
        ax.set_title(f"over the flange, {made.pair}", loc="left", fontsize=7, pad=3)
        ax.set_xlabel("lateral Y [mm]")
    axes[0].set_ylabel("work of weight and load [J]")


def climb(case: Case) -> RunData:
    """The run of a wheelset that is fast enough to go over the left flange with both wheels on the rails."""
    return compute(case.replace(formulation="bilateral", vY=2.5, lateral_force=0.0, lateral_ramp=0.0, interval=2e-5,
                            dt=2e-5, t_end=0.1, stop_at="derailment"))


def words(found: Sequence[Outcome]) -> dict[str, Any]:
    """Collect the facts for the abstract: ending and time by case and formulation, and the force at which a rail pulls."""
    cases = list(dict.fromkeys(o.case for o in found))
    rows = [[case, *(ending_in_short(o) for o in found if o.case == case)] for case in cases]
    shares = {key: [spread({o.formulation: o.results[key] for o in found if o.case == case}) for case in cases]
              for key in ("t_first_LF", "first_impulse")}
    pulls = [f"{KN*o.results['F_pulls']:.0f} kN ({o.case})" for o in found if np.isfinite(o.results["F_pulls"])]
    rolled = [o.case for o in found if o.formulation == "bilateral" and o.ending.endswith("rolls over the flange")]
    return {"names": list(FORMULATIONS), "rows": rows, "pulls": pulls, "rolled": rolled,
            **{key: f"{100*np.nanmax(x):.2g}" if np.isfinite(x).any() else "" for key, x in shares.items()}}


def ending_in_short(o: Outcome) -> str:
    """How a run ended, in few words."""
    t, F = o.results["t_return"], o.results["F_derailment"]
    if np.isfinite(t):
        return f"{t:.3f} s"
    how = o.ending.partition(": ")[2] or o.ending
    return f"{how}, {KN*F:.1f} kN" if np.isfinite(F) else how


def figures(found: Sequence[Outcome], inputs: Path) -> Iterator[tuple[str, Figure]]:
    """The table, two exercises to a page, the values."""
    yield "which results depend on the formulation", verdict_page(found, inputs)
    there = {o.exercise for o in found}
    for exercises in (shown for some in TOGETHER if (shown := [k for k in some if k in there])):
        yield together(exercises).lower(), exercises_page(found, exercises)
    yield "values", values_page(found)


# Files ------------------------------------------------------------------------------------

def kept_file(outputs: Path) -> Path:
    """The file that keeps the outcomes."""
    return kept_in(outputs)/"formulations.json"


def kept_outcomes(inputs: Path, outputs: Path, jobs: int, force: bool = False,
                  submitted: Callable[[], Sequence[RunData]] = tuple) -> list[Outcome]:
    """All outcomes, run anew if something they depend on has changed since they were kept in `outputs`; `submitted` reads
    the column files of elastic runs."""
    def make() -> list[dict[str, Any]]:
        make_results_folder(outputs)
        with tqdm(total=len(FORMULATIONS)*len(cases), desc="formulations", disable=None) as bar:
            return [vars(o) for o in outcomes(inputs, jobs, bar.update, submitted())]

    cases = find_cases(inputs)
    depends = {name: x for case in cases for name, x in sources(case).items()}
    return [Outcome(**o) for o in kept_json(kept_file(outputs), depends, force, make)]


def make_comparison(inputs: Path, outputs: Path, jobs: int) -> list[Path]:
    """Write the PDF and the CSV file of the comparison of formulations."""
    found = kept_outcomes(inputs, outputs, jobs)
    target = outputs/"ldbench_formulations.pdf"
    save_document([chapter(found, inputs)], target, "ldbench: elastic contact or constraint equations")
    write_frame(table(found), target.with_suffix(".csv"))
    return [target, target.with_suffix(".csv")]


def chapter(found: Sequence[Outcome], inputs: Path) -> Chapter:
    """The pages of a document, which are drawn when they are asked for."""
    return "Elastic contact or constraint equations", figures(found, inputs)
