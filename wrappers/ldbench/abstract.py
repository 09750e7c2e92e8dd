"""The abstract: its figures and numbers are taken from the runs, its words from wrappers/abstract."""
from __future__ import annotations

import json
import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from . import formulations, plots
from ._core import complete, needed
from .columns import time_mean
from .record import PAIRS, Record, summary_row
from .style import ldbench_style

# In the installed package among the other data, in the repository beside the package.
PACKAGE = Path(__file__).resolve().parent
TEMPLATE = (PACKAGE/"data" if (PACKAGE/"data").is_dir() else PACKAGE.parent)/"abstract"/"abstract.typ"

FIGURES = {
    "motion": plots.motion_figure,
    "impact": plots.impact_figure,
    "derailment": plots.derailment_figure,
}

# Rows of the table of results: those of the summary page, in short words.
TABLE = (
    ("first left flange contact [s]", "t_first_LF"),
    ("first right flange contact [s]", "t_first_RF"),
    ("return to the centre [s]", "t_return"),
    ("derailment [s]", "t_derailment"),
    ("lateral force then [kN]", "F_derailment"),
    ("largest Y [mm]", "Y_max"),
    ("largest Z [mm]", "Z_max"),
    ("peak N, left tread [kN]", "N_max_LT"),
    ("peak N, left flange [kN]", "N_max_LF"),
    ("peak N, right tread [kN]", "N_max_RT"),
    ("peak N, right flange [kN]", "N_max_RF"),
    ("lift-offs, left wheel", "left_lift_offs"),
    ("lift-offs, right wheel", "right_lift_offs"),
    ("energy drift, relative", "E_drift_relative"),
)
DIGITS = {"t_first_LF": 5, "t_first_RF": 5, "t_return": 5, "t_derailment": 4, "F_derailment": 1, "Y_max": 2, "Z_max": 2,
          "N_max_LT": 0, "N_max_LF": 0, "N_max_RT": 0, "N_max_RF": 0}
SCALES = {"F_derailment": 1e-3, "Y_max": 1e3, "Z_max": 1e3, "N_max_LT": 1e-3, "N_max_LF": 1e-3, "N_max_RT": 1e-3,
          "N_max_RF": 1e-3}


def make_abstract(records: Sequence[Record], target: Path, outcomes: Sequence[formulations.Outcome] = ()) -> None:
    """Typeset the abstract of the ten runs; outcomes: those of the formulations, if the abstract shall tell."""
    typst = needed("typst", "report")
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        shutil.copytree(TEMPLATE.parent, folder, dirs_exist_ok=True)
        data = facts(records)
        data["formulations"] = formulations.words(outcomes) if outcomes else None
        with ldbench_style():
            for name, draw in FIGURES.items():
                figure = draw(records)
                data["figures"][name] = figure is not None
                if figure is not None:
                    figure.savefig(folder/f"{name}.pdf", metadata={"CreationDate": None})
        (folder/"data.json").write_text(json.dumps(data))
        typst.compile(folder/TEMPLATE.name, output=folder/"abstract.pdf", root=folder)
        with complete(target) as scratch:
            shutil.copy(folder/"abstract.pdf", scratch)


def facts(records: Sequence[Record]) -> dict[str, Any]:
    """What the text says about the runs, ready to print."""
    rows = [summary_row(run) for run in records]
    first = records[0]
    ramps = [run for run in records if run.exercise == 5 and run.first("derailment") and run.time[-1] > 2]
    return {
        "version": first.version,
        "figures": {},
        "names": [run.name for run in records],
        "table": [[label, *(cell(key, row[key]) for row in rows)] for label, key in TABLE],
        "pairs": [pair_facts(pair, runs) for pair, runs in plots.by_pair(records).items() if runs],
        "reconstruction": any(run.reconstruction for run in records),
        "models": sorted({str(run.setting("contact", "model")) for run in records}),
        "endings": {run.name: run.ending for run in records},
        "drift_free": scientific(max(r["E_drift_relative"] for r in rows if r["exercise"] != 5)),
        "drift_ramp": scientific(max([r["E_drift_relative"] for r in rows if r["exercise"] == 5], default=0.0)),
        "steps_free": sorted({f"{1e6*r['dt']:.3g}" for r in rows if r["exercise"] != 5}, key=float),
        "steps_ramp": sorted({f"{1e6*run.step:.3g}" for run in ramps}, key=float),
        "order_free": f"{free(records)[0].number('integrator', 'order'):.0f}",
        "order_ramp": f"{ramps[0].number('integrator', 'order'):.0f}" if ramps else "",
        "scheme": str(first.setting("integrator", "scheme")),
        "explicit": all(is_explicit(run) for run in records),
        "energy_free": scientific(free(records)[0].number("integrator", "energy_tolerance")),
        "energy_ramp": scientific(ramps[0].number("integrator", "energy_tolerance")) if ramps else "",
        "calm": [f"{speed:g}" for speed in speeds(records, lifting=False)],
        "thrown": [f"{speed:g}" for speed in speeds(records, lifting=True)],
        "duration": durations(records),
        "depth": f"{1e3*max(run.number('table', 'depth') for run in records):.1f}",
        "split": f"{np.degrees(first.number('contact', 'split_angle')):.0f}",
        "young": f"{1e-9*first.number('material', 'youngs_modulus'):.0f}",
        "poisson": f"{first.number('material', 'poisson'):.2f}",
        "ramps": [ramp_facts(run) for run in ramps],
    }


def is_explicit(run: Record) -> bool:
    """Whether the run has the integrator that the text describes."""
    return (run.setting("integrator", "scheme") == "newmark" and run.number("integrator", "beta") == 0
            and run.number("integrator", "order") == 4 and run.number("integrator", "energy_tolerance") > 0)


def cell(key: str, value: float | str | None) -> str:
    if value is None:
        return "–"
    if key == "E_drift_relative":
        return scientific(float(value))
    if isinstance(value, float):
        return f"{SCALES.get(key, 1.0)*value:.{DIGITS[key]}f}"
    return str(value)


def scientific(x: float) -> str:
    """'1.3e-12' as the text prints it: 1.3·10⁻¹²."""
    if not x:
        return "0"
    mantissa, exponent = f"{x:.1e}".split("e")
    power = str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return (f"{mantissa.removesuffix('.0')}·" if mantissa != "1.0" else "") + f"10{power}"


def pair_facts(pair: str, runs: Sequence[Record]) -> dict[str, str]:
    return {
        "name": PAIRS[pair],
        "clearance": f"{1e3*runs[0].clearance:.2f}",
        "points": runs[0].table_points.replace(" x ", " × "),
        "errors": ", ".join(f"{place} {percent(rms)} ({percent(largest)})" for place, (rms, largest) in
                            runs[0].table_errors.items()),
    }


def percent(share: float) -> str:
    """Two digits."""
    return f"{100*share:.2g} %"


def free(records: Sequence[Record]) -> list[Record]:
    """Exercises 1 to 4."""
    return [run for run in records if run.exercise in range(1, 5)]


def speeds(records: Sequence[Record], lifting: bool) -> list[float]:
    """Initial velocities [m/s] of exercises 1 to 4 at which a wheel ever lifts off, or never does, with
    all pairs of profiles."""
    lifts: dict[float, list[bool]] = {}
    for run in free(records):
        row = summary_row(run)
        lifts.setdefault(float(run.values("vY")[0]), []).append(bool(row["left_lift_offs"] or row["right_lift_offs"]))
    return sorted(speed for speed, found in lifts.items() if (all(found) if lifting else not any(found)))


def durations(records: Sequence[Record]) -> list[str]:
    """Shortest and longest first contact of the left flange in exercises 1 to 4 [ms]."""
    episodes = [episode for run in free(records) if (episode := plots.first_episode(run, "LF"))]
    spans = [1e3*(end - start) for start, end in episodes] or [0.0]
    return [f"{min(spans):.1f}", f"{max(spans):.1f}"]


def ramp_facts(run: Record) -> dict[str, str]:
    """Exercise 5: the lateral force at derailment, and the one at which statics lets the wheelset turn over
    its flange contact: weight times lever arm over height of the axle above that contact, at the mean
    pose of the second before the last."""
    rows = (run.time > run.time[-1] - 2) & (run.time < run.time[-1] - 1)
    weight = run.number("wheelset", "mass")*9.81 + run.number("wheelset", "vertical_load")
    lever = time_mean(run.time[rows], (run.values("y_LF") - run.values("Y"))[rows])
    height = time_mean(run.time[rows], (run.axle_height + run.values("Z") - run.values("z_LF"))[rows])
    row = summary_row(run)
    return {
        "name": PAIRS[run.name[-2:]],
        "time": cell("t_derailment", row["t_derailment"]),
        "force": cell("F_derailment", row["F_derailment"]),
        "statics": f"{1e-3*weight*lever/height:.1f}",
        "contacts": f"{run.counts.get('left flange contact', 0)}",
        "lift_offs": f"{run.counts.get('right wheel lift-off', 0)}",
        "peak": cell("N_max_LF", row["N_max_LF"]),
        "right_flange": f"{run.counts.get('right flange contact', 0)}",
    }
