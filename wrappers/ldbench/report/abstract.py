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
from ..geometry.pressures import full_row
from ..plots.document import save_pages
from ..plots.figures import by_pair, contact_figure, derailment_figure, first_shown, free, impact_figure, motion_figure
from ..plots.style import ldbench_style
from ..results.columns import read_toml, time_mean
from ..results.contact_intervals import ContactInterval
from ..results.quantities import GRAVITY, KN, OUTCOME, scientific
from ..results.run_data import RETURNED, RunData
from ..results.summary import Chaotic, shown, summary_row
from . import formulations

TEMPLATE = Path(__file__).resolve().parent/"template"/"abstract.typ"
SPREAD = TEMPLATE.parent/"spread.json"       # how far the answers move with the unknown profiles [%], as `make validate` has it

AUTHORS = "authors.toml"                    # in the working directory
KEYS = "name", "affiliation"                # of an author
TIMES = {1: "once", 2: "twice"}

FIGURES = {"motion": motion_figure, "impact": impact_figure, "derailment": derailment_figure, "contact": contact_figure}

# Rows of the table of results, by their names in `quantities.OUTCOME`, and decimals where they are other ones.
TABLE: dict[str, int | None] = {
    "t_first_LF": 5, "t_first_RF": 5, "t_return": 5, "t_derailment": 4, "F_derailment": 1, "Y_max": 2, "Z_max": 2,
    "peak_N_LT": 0, "peak_N_LF": 0, "peak_N_RT": 0, "peak_N_RF": 0, "pmax_LF": 0, "patch_LF": 0,
    "n_left_wheel_lift_off": 0, "n_right_wheel_lift_off": 0,
    "drift_relative": None}


# Where a contact table measures its error, by the names in the header of a column file.
PLACES = {"tread": "tread alone", "flange": "flange alone", "both": "tread and flange", "going over": "rolling over the rail"}


def make_abstract(runs: Sequence[RunData], target: Path, outcomes: Sequence[formulations.Outcome] = (),
                  chaotic: Chaotic | None = None, authors: Sequence[Mapping[str, str]] = ()) -> None:
    """Typeset the abstract of the ten runs, with a comparison of formulations if `outcomes` are given.
    `chaotic`: the results of each run that are in italics; `authors`: name and affiliation of each."""
    typst = needed("typst", "report")
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        shutil.copytree(TEMPLATE.parent, folder, dirs_exist_ok=True)
        data = facts(runs, chaotic or {})
        data["authors"] = list(authors)
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
    """Collect the numbers of the text, ready to print; `chaotic` ones of the table, which are in italics, are in a dictionary."""
    rows = [full_row(run) for run in runs]
    first, loose = runs[0], free(runs)
    ramps = [run for run in runs if run.exercise == 5 and run.first("derailment") and run.time[-1] > 2]
    struck = [(run, one) for run in loose if (one := run.first_interval("LF"))]
    spans = [1e3*one.duration for _, one in struck] or [0.0]
    lifts: dict[float, list[bool]] = {}         # by initial velocity [m/s], whether a wheel lifts off, with each pair of profiles
    for run, row in zip(runs, rows, strict=True):
        if run in loose:
            lifts.setdefault(float(run.values("vY")[0]), []).append(
                bool(row["n_left_wheel_lift_off"] or row["n_right_wheel_lift_off"]))
    return {
        "version": first.header.version,
        "names": [run.name for run in runs],
        "table": [[OUTCOME[key].brief, *({"leaning": text} if leaning else text for text, leaning in (
            shown(row, key, chaotic, TABLE[key]) for row in rows))] for key in TABLE],
        "marked": any(key in TABLE for found in chaotic.values() for key in found),
        "costs": costs(runs),
        "first": {"name": drawn.name} if (drawn := first_shown(runs)) else None,
        "pairs": [pair_facts(own) for own in by_pair(runs).values()],
        "reconstruction": any(run.header.reconstruction for run in runs),
        "models": sorted({str(run.setting("contact", "model")) for run in runs}),
        "places": [PLACES.get(place, place) for place in first.header.table_errors],
        "errors": [[own[0].pair, *(f"{percent(rms)} ({percent(largest)})" for rms, largest in
                                   own[0].header.table_errors.values())]
                   for own in by_pair(runs).values() if own[0].header.table_errors],
        "others": [{"name": run.name, "ending": run.ending} for run in loose if run.ending != RETURNED],
        "corners": [{"name": run.name, "times": TIMES.get(n, f"{n} times")} for run in loose if (
            n := sum(run.count(f"{side} flange over rail") or 0 for side in ("left", "right")))],
        "exponents": exponents(struck),
        "drift_free": scientific(max(r["drift_relative"] for r in rows if r["exercise"] != 5)),
        "drift_ramp": scientific(max([r["drift_relative"] for r in rows if r["exercise"] == 5], default=0.0)),
        "steps_free": sorted({f"{1e6*r['step']:.3g}" for r in rows if r["exercise"] != 5}, key=float),
        "steps_ramp": sorted({f"{1e6*run.result('step'):.3g}" for run in ramps}, key=float),
        "order_free": f"{loose[0].number('integrator', 'order'):.0f}",
        "order_ramp": f"{ramps[0].number('integrator', 'order'):.0f}" if ramps else "",
        "scheme": str(first.setting("integrator", "scheme")),
        # Whether the runs have the integrator that the text describes.
        "explicit": all(run.setting("integrator", "scheme") == "newmark" and run.number("integrator", "beta") == 0 and run.number(
            "integrator", "order") == 4 and run.number("integrator", "energy_tolerance") > 0 for run in runs),
        "energy_free": scientific(loose[0].number("integrator", "energy_tolerance")),
        "energy_ramp": scientific(ramps[0].number("integrator", "energy_tolerance")) if ramps else "",
        "calm": [f"{speed:g}" for speed, lifted in sorted(lifts.items()) if not any(lifted)],
        "thrown": [f"{speed:g}" for speed, lifted in sorted(lifts.items()) if all(lifted)],
        "duration": [f"{min(spans):.1f}", f"{max(spans):.1f}"],
        "depth": f"{1e3*max(run.number('table', 'depth') for run in runs):.1f}",
        "threshold": f"{np.degrees(first.number('contact', 'flange_angle')):.0f}",
        "young": f"{1e-9*first.number('material', 'youngs_modulus'):.0f}",
        "poisson": f"{first.number('material', 'poisson'):.2f}",
        "ramps": (told := [ramp_facts(run, chaotic) for run in ramps]),
        "ramp_spread": f"{max((abs(r['derails'] - float(r['statics'])) for r in told), default=0.0):.0f}",
        "pressure": pressure_facts(rows),
    }


def costs(runs: Sequence[RunData]) -> list[list[str]]:
    """Steps, their mean length and evaluations of the force, a row each, with thin spaces between thousands."""
    steps, evaluations = ([run.result(name) for run in runs] for name in ("steps", "evaluations"))
    grouped = [[f"{n:,.0f}".replace(",", "\u2009") for n in numbers] for numbers in (steps, evaluations)]
    return [["steps", *grouped[0]],
            ["mean step [µs]", *(f"{1e6*run.time[-1]/n:.1f}" for run, n in zip(runs, steps, strict=True))],
            ["evaluations of the force", *grouped[1]]]


def pressure_facts(rows: Sequence[dict[str, Any]]) -> dict[str, str] | None:
    """What the text says of the hardest first contact of a left flange; None where no pressure is known."""
    known = [row for row in rows if row["pmax_LF"] is not None]
    if not known:
        return None
    row = max(known, key=lambda row: float(row["pmax_LF"]))
    return {"name": row["case"], "largest": f"{1e-9*row['pmax_LF']:.1f}", "area": OUTCOME["patch_LF"].text(row["patch_LF"])}


def pair_facts(runs: Sequence[RunData]) -> dict[str, str]:
    """Collect the facts about a pair of profiles."""
    left, right = (1e3*runs[0].result(f"clearance_{side}") for side in ("left", "right"))
    return {
        "name": runs[0].pair,
        "clearance": f"2 × {left:.2f}" if abs(left - right) < 5e-3 else f"{left:.2f} (left) and {right:.2f} (right)",
        "points": runs[0].header.table_points.replace(" x ", " × "),
    }


def percent(share: float) -> str:
    """Write a share in percent with two digits."""
    return f"{100*share:#.2g}".rstrip(".") + " %"


def exponents(struck: Sequence[tuple[RunData, ContactInterval]]) -> list[dict[str, str]]:
    """The power of the initial velocity with which the first flange peak grows, from the slowest to the fastest run of a pair."""
    found = []
    for own in by_pair([run for run, _ in struck]).values():
        peaks = {float(run.values("vY")[0]): one.peak for run, one in struck if run in own}
        if len(peaks) > 1:
            slow, fast = min(peaks), max(peaks)
            found.append({"name": own[0].pair, "value": f"{np.log(peaks[fast]/peaks[slow])/np.log(fast/slow):.2f}"})
    return found


def ramp_facts(run: RunData, chaotic: Chaotic | None = None) -> dict[str, Any]:
    """What the text says of a run of exercise 5.

    The lateral force at derailment is that of the event. The static limit is the lateral force at which the wheelset
    overturns about its flange contact: weight times lever arm over the height of the axle above that contact, at the mean
    pose of the second before the last.
    """
    rows = (run.time > run.time[-1] - 2) & (run.time < run.time[-1] - 1)
    weight = run.number("wheelset", "mass")*GRAVITY + run.number("wheelset", "vertical_load")
    lever = time_mean(run.time[rows], (run.values("y_LF") - run.values("Y"))[rows])
    height = time_mean(run.time[rows], (run.result("axle_height") + run.values("Z") - run.values("z_LF"))[rows])
    row = summary_row(run)

    def told(key: str) -> str:
        text, leaning = shown(row, key, chaotic or {}, TABLE.get(key))
        return f"about {text}" if leaning else text

    return {
        "name": run.pair, "statics": f"{1e-3*weight*lever/height:.1f}",
        "derails": KN*float(row["F_derailment"] or np.nan),
        "right_flange": f"{run.count('right flange contact') or 0}",
    } | {name: told(key) for name, key in (("time", "t_derailment"), ("force", "F_derailment"), ("peak", "peak_N_LF"),
                                           ("contacts", "n_left_flange_contact"), ("lift_offs", "n_right_wheel_lift_off"))}


def read_authors(file: Path) -> list[dict[str, str]]:
    """Name and affiliation of every author; none where the file does not exist.

        [[author]]
        name = "A. Author"
        affiliation = "Institute, Town"     # may be left out
    """
    if not file.exists():
        return []
    told = read_toml(file)
    authors = told.get("author", [])
    if strange := [key for key in told if key != "author"]:
        raise Error(f"{file}, {strange[0]}: expected tables [[author]] alone, found another name. Remove it")
    if not isinstance(authors, list) or not all(isinstance(author, dict) for author in authors):
        kind = type(authors).__name__
        raise Error(f"{file}, author: expected tables [[author]], found {kind}. Write the name in double brackets")
    for author in authors:
        for key, value in author.items():
            if key not in KEYS or not isinstance(value, str) or not value.strip():
                raise Error(f"{file}, author, {key}: expected a text for {' or '.join(KEYS)}, found {value!r}. Correct the file")
        if "name" not in author:
            raise Error(f"{file}, author: expected a name, found none. Add name = \"...\"")
    return [{key: str(author.get(key, "")).strip() for key in KEYS} for author in authors]
