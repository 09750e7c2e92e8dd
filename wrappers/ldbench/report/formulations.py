"""Elastic contact or constraint equations: effect of the choice on every result of the benchmark.

All exercises run with elastic contact, with both wheels held on their rails (bilateral), and with rigid contacts that only push
(unilateral), for several restitutions. In a report the elastic runs are those of the submitted column files.
"""
from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from tqdm import tqdm

from .._core.calls import Progress
from .._core.files import make_results_folder, write_frame
from .._core.kept import kept_in, kept_json
from .._core.pools import in_threads
from ..case import Case
from ..constants import KN, MM, SIDES
from ..number_text import percent_text, two_digits
from ..plots.document import save_document
from ..plots.frame import legend_of_page, new_page
from ..plots.named import decoration, shows
from ..plots.series import draw_curves
from ..plots.style import BLUE, DASH_DOT, DASHED, DOTTED, GREEN, GREY, ORANGE, PURPLE, RED, Line
from ..plots.tables import draw_table
from ..results.answers import answers
from ..results.contact_intervals import is_closed
from ..results.derived import cumulative
from ..results.quantities import OUTCOME, Quantity, si_unit
from ..results.run_data import RunData
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

# The answers that are compared, by their names in `quantities.OUTCOME`.
RESULTS = ("t_first_LF", "farthest_left", "farthest_up", "turn_impulse_LF", "peak_N_LF", "peak_P_LF", "t_first_RF", "t_return",
           "lift_offs", "lost", "t_derailment", "F_derailment", "F_pulls")
BEFORE_THE_FALL = "farthest_left", "farthest_up", "turn_impulse_LF"     # of runs without a ramp that do not derail
EXACTNESS = "drift_relative",
SHORT = {key: OUTCOME[key].short or OUTCOME[key].words for key in (*RESULTS, *EXACTNESS)}
# Compared one by one, or as a matter of what a formulation can say at all.
JUDGED = tuple(name for name in RESULTS if name not in ("peak_N_LF", "peak_P_LF", "lost", "F_pulls"))
AGREE, DIFFER, DECIDES = "#BFE5D6", "#FCE3B4", "#F6C9B0"        # green, orange, red
TITLE = "Elastic contact or constraint equations"


@dataclass(frozen=True)
class Outcome:
    """The results of one run, and thinned curves."""
    case: str
    formulation: str
    results: Mapping[str, float]
    ending: str
    curves: Mapping[str, list[float]]     # by the names in ROWS, and their times t
    profiles: str                         # in words, by the names of their files

    @property
    def exercise(self) -> int:
        """The number of the exercise."""
        return int(self.case[2])

    @property
    def pair(self) -> str:
        """The pair of profiles, 'aw' or 'sw'."""
        return self.case[-2:]


def outcomes(inputs: Path, jobs: int, told: Callable[[], object] = lambda: None,
             submitted: Sequence[RunData] = ()) -> list[Outcome]:
    """Run every exercise in every formulation; `told` is called after each run. An elastic run whose column file is
    submitted is not done again: its steps end at its rows, and with other rows exercise 5 derails at another load."""
    cases = find_cases(inputs)
    known = {one.name: one for one in submitted}
    several = {table_key(case): case for case in cases if case.case_name not in known}
    tables = {key: ContactTable(case) for key, case in several.items()}

    def work(task: tuple[Case, str], tell: Progress) -> Outcome:
        case, name = task
        if name == "elastic":
            return outcome(known.get(case.case_name) or compute(case, tell, tables[table_key(case)]), name)
        if case.stop_at == "derailment":
            case = case.replace(interval=LONG_INTERVAL, dt=LONG_STEP)
        return outcome(compute(case.replace(FORMULATIONS[name]), tell), name)

    todo = [(case, name) for case in cases for name in FORMULATIONS]
    results: dict[tuple[Case, str], Outcome] = {}
    for task, found in in_threads(work, sorted(todo, key=lambda task: -task[0].t_end), jobs):       # the longest first
        results[task] = found
        told()
    return [results[task] for task in todo]


def table_key(case: Case) -> str:
    """What cases share that can share a contact table."""
    return f"{case.profile_files()} {case.model}"


def outcome(done: RunData, name: str) -> Outcome:
    """The results of a run and what its pages show."""
    c, t, known = done.data, done.time, answers(done)
    ramp = done.case.lateral_ramp != 0
    pulls = done.first("rail pulls")
    known["lift_offs"] = known["n_left_wheel_lift_off"] + known["n_right_wheel_lift_off"]
    known["F_pulls"] = pulls.force if pulls and ramp else None
    if ramp or known["derailed"]:
        known |= dict.fromkeys(BEFORE_THE_FALL)
    pushed = cumulative(t, c.N_LF.to_numpy()) + (c.P_LF.to_numpy() if "P_LF" in c else 0.0)
    keep = np.unique(np.linspace(0, len(t) - 1, 2500).astype(int))
    curves = {"t": t, "Y": c.Y.to_numpy(), "Z": c.Z.to_numpy(), "pushed": pushed,
              "kinetic": (c.KE_lat + c.KE_vert + c.KE_roll).to_numpy()}
    results = {key: np.nan if known[key] is None else float(known[key]) for key in SHORT}
    return Outcome(done.name, name, results, why(done, known), {key: x[keep].tolist() for key, x in curves.items()}, done.pair)


def why(done: RunData, known: Mapping[str, Any]) -> str:
    """How the run ended, by its answers; of a derailment, whether over the flange or overturning."""
    if not known["derailed"]:
        if done.case.stop_at == "derailment":
            return "does not derail"
        return "does not return" if known["t_return"] is None else "returns"
    # How the flange came over the rail says it; on the crown both wheels may stand on their rails again.
    over = [event.t for event in done.events if event.kind.endswith("over rail") and event.t <= known["t_derailment"]]
    c = done.data
    end = c.iloc[min(c.time.searchsorted(max(over, default=known["t_derailment"])), len(c) - 1)]
    side, other = ("left", "right") if end.Y > 0 else ("right", "left")
    if np.sign(end.Y)*end.roll < -TURNED:
        how = "overturns"
    elif done.formulation == "bilateral" or any(is_closed(end[f"N_{contact}"]) for contact in SIDES[other]):
        how = "rolls over the flange"
    else:
        how = "jumps"
    return f"derails over the {side} rail: {how}"


def cases_of(found: Sequence[Outcome]) -> list[str]:
    """The names of the cases, in their order."""
    return list(dict.fromkeys(o.case for o in found))


def values_of(found: Sequence[Outcome], case: str, key: str) -> dict[str, float]:
    """A result of a case by formulation, SI."""
    return {o.formulation: o.results[key] for o in found if o.case == case}


def endings_of(found: Sequence[Outcome], case: str) -> dict[str, list[str]]:
    """The formulations of a case by how the run ends."""
    groups: dict[str, list[str]] = {}
    for o in found:
        if o.case == case:
            groups.setdefault(o.ending, []).append(in_short(o.formulation))
    return groups


def in_short(formulation: str) -> str:
    """'e = 1' for 'unilateral, e = 1'."""
    return formulation.removeprefix("unilateral, ")


def table(found: Sequence[Outcome]) -> pd.DataFrame:
    """One row per case and result, one column per formulation, SI; and the spread about the elastic value."""
    rows = []
    for case in cases_of(found):
        own = [o for o in found if o.case == case]
        for key in (*RESULTS, *EXACTNESS):
            values = values_of(own, case, key)
            if np.isfinite(list(values.values())).any():
                rows.append({"case": case, "result": SHORT[key], "unit": si_unit(key), **values,
                             "spread": spread(values) if key in RESULTS else ""})
        rows.append({"case": case, "result": "ending", "unit": "", **{o.formulation: o.ending for o in own},
                     "spread": "differs" if len(endings_of(own, case)) > 1 else ""})
    return pd.DataFrame(rows)


def spread(values: Mapping[str, float]) -> float:
    """Largest difference from the elastic value over that; nan where only one formulation has the result, or if it is zero."""
    elastic = values["elastic"]
    others = [x for name, x in values.items() if name != "elastic" and np.isfinite(x)]
    return float(max(abs(x - elastic) for x in others)/abs(elastic)) if elastic and others else np.nan


def verdict(values: Mapping[str, float], key: str) -> tuple[str, str]:
    """How much a result depends on the formulation, in words, and the colour behind them."""
    known, share = [x for x in values.values() if np.isfinite(x)], spread(values)
    if not any(known):
        return "–", ""
    if key == "lift_offs":
        return f"{min(known):.0f} to {max(known):.0f}", DECIDES
    if not np.isfinite(share):
        return f"{len(known)} of {len(values)}", DECIDES
    return (percent_text(share) + ("" if len(known) == len(values) else " *"),
            AGREE if share < 0.03 else DIFFER if share < 0.3 else DECIDES)


def in_table(key: str) -> Quantity:
    """A result in four digits, times of contacts in ms."""
    known = OUTCOME[key]._replace(digits=None)
    return known._replace(unit="ms", scale=1e3) if known.unit == "s" and key != "t_derailment" else known


def farthest(values: Mapping[str, float], key: str) -> str:
    """The elastic value, and that of a constraint formulation which is farthest from it."""
    elastic, short = values["elastic"], in_table(key)
    others = [x for name, x in values.items() if name != "elastic" and np.isfinite(x)]
    if not any(x for x in (elastic, *others) if np.isfinite(x)):
        return ""
    far = max(others, key=lambda x: abs(x - elastic) if np.isfinite(elastic) else x, default=np.nan)
    return f"{short.text(elastic)} / {short.text(far)}"


def told_endings(endings: Mapping[str, Mapping[str, Sequence[str]]]) -> list[list[str]]:
    """How the runs of each formulation end, a line for each ending; cases that end alike share their lines."""
    alike: dict[tuple[str, ...], list[str]] = {}
    for case, own in endings.items():
        lines = tuple(f"{ending.replace(': ', ', ')}: {', '.join(names)}" if len(own) > 1 else f"{ending} in all formulations"
                      for ending, names in own.items())
        alike.setdefault(lines, []).append(case)
    return [[", ".join(cases) if k == 0 else "", line] for lines, cases in alike.items() for k, line in enumerate(lines)]


def verdict_page(found: Sequence[Outcome], inputs: Path) -> Figure:
    """How much each result depends on the formulation; how runs end, and what it takes to go over the flange."""
    cases = cases_of(found)
    figure = new_page(
        "Which results depend on the formulation?",
        "largest difference of a constraint formulation from elastic contact, over the elastic value; below it both values",
        "constraint formulations: bilateral, both wheels held on the rails; unilateral, rigid contacts with restitution 1, "
        "0.5 and 0. *: of the formulations that have the result.\ngreen: below 3 %, any code may be compared; orange: up to "
        "30 %; red: the formulation decides. impulse: of forces and impacts, until the wheelset moves back. lift-offs: "
        "fewest to most. Over the flange: dashed, the energy of the lateral motion at the start of each exercise.")
    endings = {case: endings_of(found, case) for case in cases}
    cells: list[tuple[str, list[tuple[str, str]]]] = []
    for key in JUDGED:
        cells.append((SHORT[key], [verdict(values_of(found, case, key), key) for case in cases]))
        if key != "lift_offs":
            cells.append((f"    elastic / farthest [{in_table(key).unit}]",
                          [(farthest(values_of(found, case, key), key), "") for case in cases]))
    cells.append(("ending", [("differs", DECIDES) if len(endings[case]) > 1 else ("the same", AGREE) for case in cases]))
    colours = [[""]*len(cases), *([colour for _, colour in line] for _, line in cells)]
    body = figure.add_gridspec(2, 1, height_ratios=(1.6, 1))
    draw_table(figure.add_subplot(body[0]), [["", *cases], *([name, *(text for text, _ in line)] for name, line in cells)],
               [0, *np.linspace(0.25, 1, len(cases) + 1)], size=6.2, look=lambda i, j: {
                   "weight": "bold" if not i or (not j and not cells[i - 1][0].startswith(" ")) else "normal"},
               band=lambda i: "", shade=lambda i, j: colours[i][j - 1] if j else "")
    below = body[1].subgridspec(1, 2, width_ratios=(1.7, 1))
    draw_table(figure.add_subplot(below[0]), told_endings(endings), (0, 0.46, 1), 1/11, left=(0, 1), size=7.5,
               look=lambda i, j: {"weight": "normal" if j else "bold"}, band=lambda i: "")
    draw_climb(below[1], inputs)
    return figure


def draw_climb(place: SubplotSpec, inputs: Path) -> None:
    """Draw the work that lifts the wheelset over the flange with both wheels on the rails, beside the endings, and the kinetic
    energy of the lateral motion with which each exercise of the pair begins."""
    cases = find_cases(inputs)
    pairs = {case.case_name[-2:]: case for case in cases}
    axes = place.subgridspec(1, len(pairs)).subplots(sharey=True, squeeze=False)[0]
    for ax, (pair, last) in zip(axes, pairs.items(), strict=True):
        made = climb(last)
        c = made.data
        curve, = ax.plot(MM*c.Y, c.PE_grav + c.PE_load, color=BLUE, linewidth=1.4)
        shows(curve, "PE_grav+PE_load [J]", "Y [mm]", of=f"over the flange, {pair}")
        for case in cases:
            if case.case_name.endswith(pair) and case.vY:
                energy = 0.5*case.mass*case.vY**2
                level = ax.axhline(energy, color=GREY, linewidth=0.8, linestyle=DASHED)
                shows(level, "first KE_lat [J]", how="level", of=case.case_name)
                ax.text(0.99, energy, f"exercise {case.case_name[2]}", transform=ax.get_yaxis_transform(), ha="right", va="bottom",
                        fontsize=6)
        ax.set_title(f"over the flange, {made.pair}", loc="left", fontsize=7, pad=3)
        ax.set_xlabel("lateral Y [mm]")
    axes[0].set_ylabel("work of weight and load [J]")


def climb(case: Case) -> RunData:
    """The run of a wheelset that is fast enough to go over the left flange with both wheels on the rails."""
    return compute(case.replace(formulation="bilateral", vY=2.5, lateral_force=0.0, lateral_ramp=0.0, interval=2e-5,
                            dt=2e-5, t_end=0.1, stop_at="derailment"))


def values_page(found: Sequence[Outcome]) -> Figure:
    """All values, the pairs of profiles beside each other."""
    pairs = {o.pair: o.profiles for o in found}
    figure = new_page("Results by formulation", "", "e: unilateral, with this restitution; –: did not happen or does not exist")
    rows = [["", *(words if name == list(FORMULATIONS)[-1] else "" for words in pairs.values() for name in FORMULATIONS)]]
    exercises = []          # rows that begin an exercise
    for exercise in sorted({o.exercise for o in found}):
        own = [next((o for o in found if (o.exercise, o.pair, o.formulation) == (exercise, pair, name)), None)
               for pair in pairs for name in FORMULATIONS]
        exercises.append(len(rows))
        rows.append([f"Exercise {exercise}", *(in_short(name) for _ in pairs for name in FORMULATIONS)])
        for key in RESULTS:
            known, values = OUTCOME[key], [o.results[key] if o else np.nan for o in own]
            if any(x for x in values if np.isfinite(x)):
                rows.append([known.brief, *map(known.text, values)])
        rows.append(["ending", *(o.ending.rpartition(": ")[2].removesuffix(" the flange") if o else "–" for o in own)])
    ax = figure.add_subplot()
    draw_table(ax, rows, [0, *(np.linspace(0.26, 1, len(pairs)*len(FORMULATIONS) + 1) - 0.005)], size=6.2,
               look=lambda i, j: {"weight": "bold" if i in (0, *exercises) else "normal"},
               band=lambda i: "#E6E6E6" if i in exercises else "")
    for k in range(1, len(pairs)):
        decoration(ax.axvline(0.26 + 0.74/len(pairs)*k, color=GREY, linewidth=0.4))
    return figure


# The curves of a run: key, label of the axis, factor from SI, and the name of what is shown.
ROWS = (("Y", "lateral Y [mm]", MM, "Y [mm]"), ("Z", "vertical Z [mm]", MM, "Z [mm]"),
        ("pushed", "left flange: impulse [kN·s]", KN, "impulse_LF [kN·s]"),
        ("kinetic", "kinetic energy [J]", 1.0, "KE_lat+KE_vert+KE_roll [J]"))
RAMP_LIMITS = {"Y": (-1, 25), "Z": (-2, 25), "kinetic": (-5, 300)}      # what follows is the fall
TOGETHER = (1, 2), (3, 4), (5,)                                         # exercises on a page


def exercises_page(found: Sequence[Outcome], exercises: Sequence[int], title: str) -> Figure:
    """Some exercises in all formulations, a column for each pair of profiles."""
    shown = list(dict.fromkeys((o.exercise, o.pair) for k in exercises for o in found if o.exercise == k))
    figure = new_page(f"{title}: elastic contact or constraint equations", "", (
        "impulse: of forces and, with rigid contacts, of impacts, in the direction of the contact normal; "
        "bilateral: both wheels held on the rails; unilateral: rigid contacts that only push, e: restitution"))
    axes = figure.subplots(len(ROWS), len(shown), sharex="col", squeeze=False)
    for column, (exercise, pair) in zip(axes.T, shown, strict=True):
        own = [o for o in found if (o.exercise, o.pair) == (exercise, pair)]
        for ax, (key, label, scale, what) in zip(column, ROWS, strict=True):
            draw_curves(ax, [(np.array(o.curves["t"]), scale*np.array(o.curves[key]), o.formulation, LINES[o.formulation],
                              {"y": what, "x": "time [s]", "of": f"{o.case} {o.formulation}"}) for o in own])
            if exercise == 5 and key in RAMP_LIMITS:
                ax.set_ylim(*RAMP_LIMITS[key])
            if ax in axes[:, 0]:
                ax.set_ylabel(label)
        column[0].set_title((f"Exercise {exercise}, " if len(exercises) > 1 else "") + own[0].profiles, loc="left")
        column[-1].set_xlabel("time [s]")
    figure.align_ylabels(axes)
    legend_of_page(figure, axes[0, 0].get_lines())
    return figure


def figures(found: Sequence[Outcome], inputs: Path) -> Iterator[tuple[str, Figure]]:
    """The table, two exercises to a page, the values."""
    yield "which results depend on the formulation", verdict_page(found, inputs)
    there = {o.exercise for o in found}
    for exercises in (shown for some in TOGETHER if (shown := [k for k in some if k in there])):
        title = f"Exercise{'s' if len(exercises) > 1 else ''} {' and '.join(map(str, exercises))}"
        yield title.lower(), exercises_page(found, exercises, title)
    yield "values", values_page(found)


def words(found: Sequence[Outcome]) -> dict[str, Any]:
    """Collect the facts for the abstract: ending and time by case and formulation, and the force at which a rail pulls."""
    cases = cases_of(found)
    rows = [[case, *(ending_in_short(o) for o in found if o.case == case)] for case in cases]
    shares = {key: [spread(values_of(found, case, key)) for case in cases] for key in ("t_first_LF", "turn_impulse_LF")}
    pulls = [f"{KN*o.results['F_pulls']:.0f} kN ({o.case})" for o in found if np.isfinite(o.results["F_pulls"])]
    rolled = [o.case for o in found if o.formulation == "bilateral" and o.ending.endswith("rolls over the flange")]
    return {"names": list(FORMULATIONS), "rows": rows, "pulls": pulls, "rolled": rolled,
            **{key: two_digits(100*np.nanmax(x)) if np.isfinite(x).any() else "" for key, x in shares.items()}}


def ending_in_short(o: Outcome) -> str:
    """How a run ended, in few words."""
    t, F = o.results["t_return"], o.results["F_derailment"]
    if np.isfinite(t):
        return f"{t:.3f} s"
    how = o.ending.partition(": ")[2] or o.ending
    return f"{how}, {KN*F:.1f} kN" if np.isfinite(F) else how


def kept_file(outputs: Path) -> Path:
    """The file that keeps the outcomes."""
    return kept_in(outputs)/"formulations.json"


def kept_outcomes(inputs: Path, outputs: Path, jobs: int, force: bool = False,
                  submitted: Callable[[], Sequence[RunData]] = tuple) -> list[Outcome]:
    """All outcomes, run anew where what they depend on has changed; `submitted` reads the column files of elastic runs."""
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
    save_document([(TITLE, figures(found, inputs))], target, f"ldbench: {TITLE.lower()}")
    write_frame(table(found), target.with_suffix(".csv"))
    return [target, target.with_suffix(".csv")]
