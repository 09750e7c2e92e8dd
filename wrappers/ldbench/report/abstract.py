"""The abstract: figures and numbers come from the runs, the text from template/."""
from __future__ import annotations

import json
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .._core.errors import Error
from .._core.files import complete
from .._core.optional import needed
from ..constants import CONTACT_NAMES
from ..number_text import UNKNOWN, clearance_words, percent_text, scientific
from ..plots.figures import by_pair, contact_figure, derailment_figure, first_shown, free, impact_figure, motion_figure
from ..plots.sheets import save_pages
from ..plots.style import ldbench_style
from ..results.columns import read_toml
from ..results.quantities import OUTCOME
from ..results.run_data import RETURNED, RunData
from ..results.summary import CHAOTIC_NOTE, shown, summary_row
from ..results.twins import Chaotic
from ..trust import Trust
from . import formulations

TEMPLATE = Path(__file__).resolve().parent/"template"/"abstract.typ"
SPREAD = TEMPLATE.parent/"spread.json"       # how far the answers move with the unknown profiles [%], as `make validate` has it

# Answers that are told with wheel and rail as bodies, by their names in `quantities.OUTCOME`.
BODIES = "first_peak_N_LF", "first_duration_LF", "first_impulse_LF", "t_first_RF", "t_return", "F_limit_left"
TIMES = {1: "once", 2: "twice"}

FIGURES = {"motion": motion_figure, "impact": impact_figure, "derailment": derailment_figure, "contact": contact_figure}

# Rows of the table of results, by their names in `quantities.OUTCOME`, and decimals where they are other ones.
TABLE: dict[str, int | None] = {
    "t_first_LF": 5, "t_first_RF": 5, "t_return": 4, "t_derailment": 2, "F_derailment": 1, "farthest_left": 2,
    "farthest_up": 2, "peak_N_LF": 0, "peak_N_RF": 0, "pmax_LF": 0, "pmax": 0,
    "n_left_wheel_lift_off": 0, "n_right_wheel_lift_off": 0,
    "drift_relative": None}
GPA = OUTCOME["pmax"]._replace(unit="GPa", scale=1e-9, digits=1)

# Where the error of a contact force is measured, by the names in the results of a column file.
PLACES = {"tread": "tread alone", "flange": "flange alone", "both": "tread and flange", "going over": "rolling over the rail"}


def worst_errors(runs: Sequence[RunData], place: str) -> str:
    """The largest rms and, in brackets, the largest error of the contact force that the runs state at a place."""
    found = [run.header.table_errors[place] for run in runs if place in run.header.table_errors]
    return f"{percent_text(max(rms for rms, _ in found), 3)} ({percent_text(max(most for _, most in found), 3)})" if found else ""


def make_abstract(runs: Sequence[RunData], target: Path, outcomes: Sequence[formulations.Outcome] = (),
                  chaotic: Chaotic | None = None, authors: Sequence[Mapping[str, str]] = (),
                  trusted: Sequence[Trust] = ()) -> None:
    """Typeset the abstract of the ten runs, with a comparison of formulations if `outcomes` are given.
    `chaotic`: the results of each run that have a range; `authors`: name and affiliation of each;
    `trusted`: how far the answers are to be trusted, for what the elasticity of the bodies changes."""
    typst = needed("typst", "report")
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        for file in TEMPLATE.parent.iterdir():
            shutil.copyfile(file, folder/file.name)     # without the mode: an installation may be read-only
        data = facts(runs, chaotic or {})
        data["authors"] = list(authors)
        data["bodies"] = bodies_facts(trusted)
        data["formulations"] = formulations.words(outcomes) if outcomes else None
        with ldbench_style():
            drawn = [(name, figure) for name, draw in FIGURES.items() if (figure := draw(runs)) is not None]
            titles = save_pages(folder/"figures.pdf", drawn)
            data["figures"] = {name: titles.index(name) + 1 if name in titles else 0 for name in FIGURES}
        (folder/"data.json").write_text(json.dumps(data))
        typst.compile(folder/TEMPLATE.name, output=folder/"abstract.pdf", root=folder)
        with complete(target) as scratch:
            shutil.copy(folder/"abstract.pdf", scratch)


def facts(runs: Sequence[RunData], chaotic: Chaotic) -> dict[str, Any]:
    """Collect the numbers of the text, ready to print."""
    rows = {run: summary_row(run) for run in runs}
    first, loose = runs[0], free(runs)
    ramps = [run for run in runs if run.exercise == 5 and rows[run]["t_derailment"] is not None]
    spans = [1e3*x for run in loose if (x := rows[run]["first_duration_LF"]) is not None] or [0.0]
    lifts: dict[float, list[bool]] = {}         # by initial velocity [m/s], whether a wheel lifts off, with each pair of profiles
    for run in loose:
        lifts.setdefault(float(run.values("vY")[0]), []).append(
            bool(rows[run]["n_left_wheel_lift_off"] or rows[run]["n_right_wheel_lift_off"]))
    groups = {"free": loose, "ramp": ramps}
    return {
        "version": first.header.version,
        "names": [run.name for run in runs],
        "table": [[OUTCOME[key].brief, *(shown(row, key, chaotic, digits)._asdict() for row in rows.values())]
                  for key, digits in TABLE.items()],
        "chaotic": CHAOTIC_NOTE if any(key in TABLE for found in chaotic.values() for key in found) else "",
        "costs": costs(runs),
        "first": {"name": drawn.name} if (drawn := first_shown(runs)) else None,
        "pairs": [pair_facts(own) for own in by_pair(runs).values()],
        "reconstruction": any(run.header.reconstruction for run in runs),
        "models": sorted({run.law for run in runs}),
        "places": list(PLACES.values()),
        "errors": [[own[0].pair, *(worst_errors(own, place) for place in PLACES)]
                   for own in by_pair(runs).values() if any(run.header.table_errors for run in own)],
        "others": [{"name": run.name, "ending": run.ending} for run in loose if run.ending != RETURNED],
        "corners": [{"name": run.name, "times": TIMES.get(n, f"{n} times")} for run in loose if (
            n := sum(run.results[f"n_{side}_flange_over_rail"] for side in ("left", "right")))],
        "exponents": exponents(rows),
        **{f"drift_{group}": scientific(max([rows[run]["drift_relative"] for run in own], default=0.0))
           for group, own in groups.items()},
        **{f"steps_{group}": sorted({f"{1e6*rows[run]['step']:.3g}" for run in own}, key=float) for group, own in groups.items()},
        **{f"{name}_{group}": listed(own, name) for group, own in groups.items() for name in (
            "order", "error_tolerance", "energy_tolerance")},
        # Whether the runs have the integrator that the text describes.
        "explicit": all(run.case.order == 4 and run.case.energy_tolerance > 0 for run in runs),
        "calm": [f"{speed:g}" for speed, lifted in sorted(lifts.items()) if not any(lifted)],
        "thrown": [f"{speed:g}" for speed, lifted in sorted(lifts.items()) if all(lifted)],
        "duration": [f"{min(spans):.1f}", f"{max(spans):.1f}"],
        "depth": f"{1e3*max(run.case.depth for run in runs):.1f}",
        "threshold": f"{np.degrees(first.case.flange_angle):.0f}",
        "young": f"{1e-9*first.case.youngs_modulus:.0f}",
        "poisson": f"{first.case.poisson:.2f}",
        "ramps": [ramp_facts(run, rows[run], chaotic) for run in ramps],
        "pressure": pressure_facts(list(rows.values()), chaotic),
    }


def listed(runs: Sequence[RunData], name: str) -> str:
    """The values of a variable of the integrator in some runs."""
    return " or ".join(scientific(x) if x < 1e-2 else f"{x:g}" for x in sorted({getattr(run.case, name) for run in runs}))


def costs(runs: Sequence[RunData]) -> list[list[str]]:
    """Steps, their mean length and evaluations of the force, a row each, with thin spaces between thousands."""
    steps, evaluations = ([run.results[name] for run in runs] for name in ("steps", "evaluations"))
    grouped = [[f"{n:,.0f}".replace(",", "\u2009") for n in numbers] for numbers in (steps, evaluations)]
    return [["steps", *grouped[0]],
            ["mean step [µs]", *(f"{1e6*run.time[-1]/n:.1f}" for run, n in zip(runs, steps, strict=True))],
            ["evaluations of the force", *grouped[1]]]


def pressure_facts(rows: Sequence[dict[str, Any]], chaotic: Chaotic) -> dict[str, Any] | None:
    """What the text says of the largest pressures: of the first contacts of the left flange, and of all contacts; None where no
    pressure is known."""
    known = {name: max(some, key=lambda row: float(row[name])) for name in ("pmax_LF", "pmax")
             if (some := [row for row in rows if row[name] is not None])}
    if len(known) < 2:
        return None
    first, hardest = known["pmax_LF"], known["pmax"]
    return {"name": first["case"], "first": shown(first, "pmax_LF", chaotic, known=GPA).line, "hardest": hardest["case"],
            "largest": shown(hardest, "pmax", chaotic, known=GPA).line, "contact": CONTACT_NAMES[hardest["pmax_contact"]],
            "area": shown(first, "patch_LF", chaotic).line}


def pair_facts(runs: Sequence[RunData]) -> dict[str, str]:
    """Collect the facts about a pair of profiles."""
    left, right = (runs[0].results[f"clearance_{side}"] for side in ("left", "right"))
    return {"name": runs[0].pair, "clearance": clearance_words(left, right),
            "points": runs[0].header.table_points.replace(" x ", " × ")}


def exponents(rows: Mapping[RunData, Mapping[str, Any]]) -> list[dict[str, str]]:
    """The power of the initial velocity with which the first flange peak grows, from the slowest to the fastest run of a pair."""
    found = []
    for own in by_pair([run for run in free([*rows]) if rows[run]["first_peak_N_LF"] is not None]).values():
        peaks = sorted((run.values("vY")[0], rows[run]["first_peak_N_LF"]) for run in own)
        speed, force = np.log(peaks[-1]) - np.log(peaks[0])
        if speed > 0:
            found.append({"name": own[0].pair, "value": f"{force/speed:.2f}"})
    return found


def ramp_facts(run: RunData, row: Mapping[str, Any], chaotic: Chaotic) -> dict[str, Any]:
    """What the text says of a run of exercise 5."""
    return {"name": run.pair, "right_flange": f"{run.results['n_right_flange_contact']}"} | {
        name: shown(row, key, chaotic, TABLE.get(key)).line for name, key in (
            ("limit", "F_limit_left"), ("time", "t_derailment"), ("force", "F_derailment"),
            ("contacts", "n_left_flange_contact"), ("lift_offs", "n_right_wheel_lift_off"))}


def read_authors(file: Path) -> list[dict[str, str]]:
    """Name and affiliation of every author, as the description of what is sent has them for `submit`; none where it names none."""
    told = read_toml(file) if file.exists() else {}
    authors, organisation = told.get("authors", []), told.get("organisation", "")
    if not isinstance(authors, list) or not all(isinstance(author, str) and author.strip() for author in authors):
        raise Error(file=file, place="authors", expected='names as ["A. Author", "B. Author"]', found=repr(authors))
    if not isinstance(organisation, str):
        raise Error(file=file, place="organisation", expected='a text as "Institute, Town"', found=repr(organisation))
    return [{"name": author.strip(), "affiliation": organisation.strip()} for author in authors]


def bodies_facts(trusted: Sequence[Trust]) -> dict[str, Any] | None:
    """By how much the answers change with wheel and rail as bodies in the place of half-spaces: the least and the largest change
    in %, a row for each answer and a column for each run; and over all runs. None where no run has bodies."""
    known = {one.case: found for one in trusted
             if (found := {name: change for name in BODIES if (change := change_by_bodies(one, name))})}
    if not known:
        return None
    rows = {name: [found.get(name) for found in known.values()] for name in BODIES}
    return {
        "names": list(known),
        "rows": [[OUTCOME[name].short or OUTCOME[name].words, *(change_words(*found) if found else UNKNOWN for found in row)]
                 for name, row in rows.items() if not name.startswith("F_limit")],       # the same in all runs of a pair
        "over_all": {name: change_words(min(low for low, _ in changes), max(high for _, high in changes))
                     for name, row in rows.items() if (changes := [one for one in row if one])}}


def change_by_bodies(one: Trust, name: str) -> tuple[float, float] | None:
    """The least and the largest relative change of an answer; None where it does not happen, or where the twins do not share it."""
    found, answer = one.range_of("bodies", name), one.answers.get(name)
    if not found or not answer or not answer.value or answer.chaotic:
        return None
    low, high = (x/answer.value - 1 for x in found)
    return low, high


def change_words(low: float, high: float) -> str:
    """A range of relative changes in %."""
    return " to ".join(dict.fromkeys(percent_text(x, sign=True).removesuffix(" %") for x in (low, high)))
