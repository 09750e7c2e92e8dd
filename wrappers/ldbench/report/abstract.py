"""The abstract: its figures and numbers are taken from the runs, its words from template/."""
from __future__ import annotations

import json
import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .._core.files import complete
from .._core.optional import needed
from ..plots.figures import by_pair, derailment_figure, impact_figure, motion_figure
from ..plots.stretches import first_episode
from ..plots.style import ldbench_style
from ..results.columns import time_mean
from ..results.quantities import OUTCOME, PAIRS
from ..results.run_data import RunData
from ..results.summary import summary_row
from . import formulations

TEMPLATE = Path(__file__).resolve().parent/"template"/"abstract.typ"

FIGURES = {
    "motion": motion_figure,
    "impact": impact_figure,
    "derailment": derailment_figure,
}

# Rows of the table of results, by their names in `quantities.OUTCOME`, and decimals where they are other ones.
TABLE = {
    "t_first_LF": 5, "t_first_RF": 5, "t_return": 5, "t_derailment": 4, "F_derailment": 1, "Y_max": 2, "Z_max": 2,
    "peak_N_LT": 0, "peak_N_LF": 0, "peak_N_RT": 0, "peak_N_RF": 0, "n_left_wheel_lift_off": 0, "n_right_wheel_lift_off": 0,
    "drift_relative": 0}


def make_abstract(runs: Sequence[RunData], target: Path, outcomes: Sequence[formulations.Outcome] = ()) -> None:
    """Typeset the abstract of the ten runs; outcomes: those of the formulations, if the abstract shall tell."""
    typst = needed("typst", "report")
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        shutil.copytree(TEMPLATE.parent, folder, dirs_exist_ok=True)
        data = facts(runs)
        data["formulations"] = formulations.words(outcomes) if outcomes else None
        with ldbench_style():
            for name, draw in FIGURES.items():
                figure = draw(runs)
                data["figures"][name] = figure is not None
                if figure is not None:
                    figure.savefig(folder/f"{name}.pdf", metadata={"CreationDate": None})
        (folder/"data.json").write_text(json.dumps(data))
        typst.compile(folder/TEMPLATE.name, output=folder/"abstract.pdf", root=folder)
        with complete(target) as scratch:
            shutil.copy(folder/"abstract.pdf", scratch)


def facts(runs: Sequence[RunData]) -> dict[str, Any]:
    """What the text says about the runs, ready to print."""
    rows = [summary_row(run) for run in runs]
    first = runs[0]
    ramps = [run for run in runs if run.exercise == 5 and run.first("derailment") and run.time[-1] > 2]
    return {
        "version": first.header.version,
        "figures": {},
        "names": [run.name for run in runs],
        "table": [[in_short(key), *(cell(key, row[key]) for row in rows)] for key in TABLE],
        "pairs": [pair_facts(pair, runs) for pair, runs in by_pair(runs).items() if runs],
        "reconstruction": any(run.header.reconstruction for run in runs),
        "models": sorted({str(run.setting("contact", "model")) for run in runs}),
        "endings": {run.name: run.ending for run in runs},
        "drift_free": scientific(max(r["drift_relative"] for r in rows if r["exercise"] != 5)),
        "drift_ramp": scientific(max([r["drift_relative"] for r in rows if r["exercise"] == 5], default=0.0)),
        "steps_free": sorted({f"{1e6*r['step']:.3g}" for r in rows if r["exercise"] != 5}, key=float),
        "steps_ramp": sorted({f"{1e6*run.result('step'):.3g}" for run in ramps}, key=float),
        "order_free": f"{free(runs)[0].number('integrator', 'order'):.0f}",
        "order_ramp": f"{ramps[0].number('integrator', 'order'):.0f}" if ramps else "",
        "scheme": str(first.setting("integrator", "scheme")),
        "explicit": all(is_explicit(run) for run in runs),
        "energy_free": scientific(free(runs)[0].number("integrator", "energy_tolerance")),
        "energy_ramp": scientific(ramps[0].number("integrator", "energy_tolerance")) if ramps else "",
        "calm": [f"{speed:g}" for speed in speeds(runs, lifting=False)],
        "thrown": [f"{speed:g}" for speed in speeds(runs, lifting=True)],
        "duration": durations(runs),
        "depth": f"{1e3*max(run.number('table', 'depth') for run in runs):.1f}",
        "split": f"{np.degrees(first.number('contact', 'split_angle')):.0f}",
        "young": f"{1e-9*first.number('material', 'youngs_modulus'):.0f}",
        "poisson": f"{first.number('material', 'poisson'):.2f}",
        "ramps": [ramp_facts(run) for run in ramps],
    }


def is_explicit(run: RunData) -> bool:
    """Whether the run has the integrator that the text describes."""
    return (run.setting("integrator", "scheme") == "newmark" and run.number("integrator", "beta") == 0
            and run.number("integrator", "order") == 4 and run.number("integrator", "energy_tolerance") > 0)


def in_short(key: str) -> str:
    """A result and its unit in few words."""
    known = OUTCOME[key]
    return f"{known.short} [{known.unit}]" if known.unit else known.short


def cell(key: str, value: float | None) -> str:
    """A result as the text prints it."""
    return scientific(float(value)) if key == "drift_relative" and value is not None else OUTCOME[key].text(value, TABLE[key])


def scientific(x: float) -> str:
    """'1.3e-12' as the text prints it: 1.3·10⁻¹²."""
    if not x:
        return "0"
    mantissa, exponent = f"{x:.1e}".split("e")
    power = str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return (f"{mantissa.removesuffix('.0')}·" if mantissa != "1.0" else "") + f"10{power}"


def pair_facts(pair: str, runs: Sequence[RunData]) -> dict[str, str]:
    """What the text says of a pair of profiles."""
    return {
        "name": PAIRS[pair],
        "clearance": f"{1e3*runs[0].result('clearance_left'):.2f}",
        "points": runs[0].header.table_points.replace(" x ", " × "),
        "errors": ", ".join(f"{place} {percent(rms)} ({percent(largest)})" for place, (rms, largest) in
                            runs[0].header.table_errors.items()),
    }


def percent(share: float) -> str:
    """Two digits."""
    return f"{100*share:.2g} %"


def free(runs: Sequence[RunData]) -> list[RunData]:
    """Exercises 1 to 4."""
    return [run for run in runs if run.exercise in range(1, 5)]


def speeds(runs: Sequence[RunData], lifting: bool) -> list[float]:
    """Initial velocities [m/s] of exercises 1 to 4 at which a wheel ever lifts off, or never does, with
    all pairs of profiles."""
    lifts: dict[float, list[bool]] = {}
    for run in free(runs):
        row = summary_row(run)
        lifts.setdefault(float(run.values("vY")[0]), []).append(bool(row["n_left_wheel_lift_off"] or row["n_right_wheel_lift_off"]))
    return sorted(speed for speed, found in lifts.items() if (all(found) if lifting else not any(found)))


def durations(runs: Sequence[RunData]) -> list[str]:
    """Shortest and longest first contact of the left flange in exercises 1 to 4 [ms]."""
    episodes = [episode for run in free(runs) if (episode := first_episode(run, "LF"))]
    spans = [1e3*(end - start) for start, end in episodes] or [0.0]
    return [f"{min(spans):.1f}", f"{max(spans):.1f}"]


def ramp_facts(run: RunData) -> dict[str, str]:
    """Exercise 5: the lateral force at derailment, and the one at which statics lets the wheelset turn over
    its flange contact: weight times lever arm over height of the axle above that contact, at the mean
    pose of the second before the last."""
    rows = (run.time > run.time[-1] - 2) & (run.time < run.time[-1] - 1)
    weight = run.number("wheelset", "mass")*9.81 + run.number("wheelset", "vertical_load")
    lever = time_mean(run.time[rows], (run.values("y_LF") - run.values("Y"))[rows])
    height = time_mean(run.time[rows], (run.result("axle_height") + run.values("Z") - run.values("z_LF"))[rows])
    row = summary_row(run)
    return {
        "name": PAIRS[run.name[-2:]],
        "time": cell("t_derailment", row["t_derailment"]),
        "force": cell("F_derailment", row["F_derailment"]),
        "statics": f"{1e-3*weight*lever/height:.1f}",
        "contacts": f"{run.count('left flange contact') or 0}",
        "lift_offs": f"{run.count('right wheel lift-off') or 0}",
        "peak": cell("peak_N_LF", row["peak_N_LF"]),
        "right_flange": f"{run.count('right flange contact') or 0}",
    }
