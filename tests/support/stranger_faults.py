"""What is wrong in a file that a stranger sends: a frame with one fault, and the words of what must be told of it.

Generated faults change one column in one way; those that have a name are of people who mean something else, or of programs. Faults
were written without reading the code that judges files; the words follow the terms of the findings.
"""
from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd

from ldbench.constants import CONTACTS
from stranger_files import (
    CALL,
    ENERGY,
    FORCES,
    KINDS,
    LOAD,
    MASS,
    MOTION,
    PLACES,
    PLAIN,
    POINT,
    RIGHT,
    ROLL,
    Change,
    Frame,
    G,
    at_contacts,
    both,
    each,
    of,
    plus,
    swap,
    times,
)


def closed_as(value: float, *columns: str) -> Change:
    """A value where a contact is closed."""
    return each(columns, lambda x: x.where(x.isna(), value))


def at_intervals(dt: float) -> Change:
    """The rows nearest to multiples of dt."""
    def change(frame: Frame) -> Frame:
        t = frame["time"].to_numpy(float)
        nearest = np.floor(np.interp(np.arange(0.0, t[-1] + 1e-9, dt), t, np.arange(len(t))) + 0.5)
        return frame.iloc[np.unique(nearest.astype(int))].reset_index(drop=True)
    return change


def dense_at_impacts(frame: Frame) -> Frame:
    """All rows within 20 rows of a closed flange, else every second row."""
    near = ((frame["N_LF"] > 0) | (frame["N_RF"] > 0)).rolling(41, center=True, min_periods=1).max() > 0
    return frame[near | (frame.index % 2 == 0) | (frame.index == len(frame) - 1)].reset_index(drop=True)


def events_twice(frame: Frame) -> Frame:
    """Rows at which a contact closes or opens stand in the file twice."""
    closed = frame[of("N")].to_numpy() > 0
    event = np.concatenate([[False], (closed[1:] != closed[:-1]).any(axis=1)])
    return frame.loc[frame.index.repeat(1 + event)].reset_index(drop=True)


def coarse_between_events(frame: Frame) -> Frame:
    """Times to a ms, but those of rows at events in full, so that a time may fall back by the rounding."""
    t = frame["time"]
    return frame.assign(time=t.where((t*1e4 % 1 - 0.5).abs() < 0.499, t.round(3)))


def peak(frame: Frame) -> float:
    """Time of the largest force of the left flange."""
    return float(frame["time"][frame["N_LF"].idxmax()])


def spliced(frame: Frame) -> Frame:
    """Without 4 ms about the largest force, the gap in the times closed."""
    t, at = frame["time"], peak(frame)
    late = t > at + 0.002
    return frame.assign(time=t.where(~late, t - 0.004))[(t < at - 0.002) | late]


def rubbed(frame: Frame, coefficient: float = 0.1) -> Frame:
    """With lateral forces of friction against the velocity of each contact point."""
    slip = np.sign(frame["vY"] + 0.457*frame["roll_rate"])
    return at_contacts("Fy", lambda f, c: f[f"Fy_{c}"] + -coefficient*f[f"N_{c}"]*slip)(frame)


def drift(amount: float, column: str) -> Change:
    """A drift that grows in proportion to the time to this amount at the end."""
    return lambda f: f.assign(**{column: f[column] + amount*f["time"]/f["time"].iloc[-1]})


def at_row(time: float, column: str, change: Callable[[float], float]) -> Change:
    """One value that is wrong."""
    def changed(frame: Frame) -> Frame:
        row = int(np.searchsorted(frame["time"], time))
        values = frame[column].to_numpy(float).copy()
        values[row] = change(values[row])
        return frame.assign(**{column: values})
    return changed


def frozen(frame: Frame, start: float = 0.075, end: float = 0.078) -> Frame:
    """All columns but the time keep their values for some ms."""
    t = frame["time"]
    held = frame.mask((t > start) & (t <= end)).ffill()
    return held.where(~frame.isna() | ((t > start) & (t <= end)).to_numpy()[:, None]).assign(time=t)


def late(rows: int, *columns: str) -> Change:
    return each(columns, lambda x: x.shift(rows).bfill())


def no_force(frame: Frame, where: Callable[[str], pd.Series], *contacts: str) -> Frame:
    """No forces of contacts in some rows."""
    return frame.assign(**{f"{q}_{c}": frame[f"{q}_{c}"].mask(where(c), 0.0) for c in contacts for q in FORCES})


# Faults with a name ------------------------------------------------------------------------
Fault = tuple[Change, str]      # and words that what is told has
PLACES_WRONG: dict[str, Fault] = {
    "radius of the other side": (swap("LT RT", "LF RF", quantities=["radius"]), "radius_"),
    "radius nominal": (closed_as(0.457, *of("radius")), "radius_"),
    "radius with Z": (at_contacts("radius", lambda f, c: f[f"radius_{c}"] + f["Z"]), "radius"),
    "angles from the plumb line": (each(of("angle"), lambda x: np.pi/2 - x), "angle_"),
    "angles of the other side": (swap("LF RF", quantities=["angle"]), "angle_[LR]F"),
    "angles from the canted rail": (plus(-1/40, *of("angle")), "angle_.T"),
    "angle of a drawing": (closed_as(np.pi/3, "angle_LF", "angle_RF"), "angle_.F"),
    "points in the wheelset": (at_contacts("y", lambda f, c: f[f"y_{c}"] - f["Y"]), "angle_.F is that of the rail"),
    "heights exchanged": (swap("LT LF", quantities=["z"]), "contact point of LF"),
    "places of flanges zero": (each(of(*PLACES, contacts=["LF", "RF"]), lambda x: 0.0), "contact point of .F|radius_.F"),
    "one y 5 mm aside": (at_row(0.01, "y_LT", lambda y: y + 0.005), "y_LT")}
REST_WRONG: dict[str, Fault] = {
    # Forces.
    "friction": (rubbed, "angle_|lateral"),
    "2 ms late": (lambda f: each(of(*FORCES), lambda x: x.to_numpy()[
        np.searchsorted(f["time"], f["time"] - 2e-3).clip(0, len(f) - 1)])(f), "momentum|mass"),
    "forces of the wrong wheel": (swap("LF RF", quantities=FORCES), "left flange first"),
    "normal force of the wrong wheel": (swap("LT RT", quantities=["N"]), "N_[LR]T is the resultant"),
    "flange and tread exchanged": (swap("LT LF"), "left flange first|clearance|contact point"),
    "forces of flange and tread exchanged": (swap("RT RF", quantities=FORCES), "angle_R|left flange first"),
    "without the static load": (plus(-9e4, *of("N", "Fz", contacts=["LT", "RT"])), "weight|not negative"),
    "kept after opening": (lambda f: f.assign(**{f"{q}_{c}": f[f"{q}_{c}"].where(f[f"N_{c}"] > 1.0).ffill().fillna(0.0)
                                                 for c in ("LF", "RF") for q in FORCES}), "momentum|Newton"),
    "none of flanges": (lambda f: no_force(f, lambda c: f["time"] >= 0, "LF", "RF"), "flange|N_LF|Newton"),
    "none of treads beside flanges": (lambda f: no_force(f, lambda c: f[f"N_{c[0]}F"] > 0.0, "LT", "RT"), "acceler|Newton"),
    "normal a sum": (at_contacts("N", lambda f, c: f[f"Fy_{c}"].abs() + f[f"Fz_{c}"].abs()), "N_.. is the resultant"),
    "no peak": (lambda f: f.assign(**{f"{q}_LF": f[f"{q}_LF"].mask((f["time"] - peak(f)).abs() < 3e-4) for q in FORCES}), "N_LF"),
    "right wheel a copy": (lambda f: f.assign(**{f"{q}_R{part}": f[f"{q}_L{part}"] for q in POINT for part in "TF"}), "_R|of R"),
    # Motion.
    "to the right": (both(swap("LT RT", "LF RF"), times(-1.0, *RIGHT, *ROLL, *of("Fy"))), "left flange first|axis"),
    "Y at the rails": (lambda f: f.assign(Y=f["Y"] + 0.457*f["roll"]), "lateral velocity is the rate"),
    "velocity at the rails": (lambda f: f.assign(vY=f["vY"] + 0.457*f["roll_rate"]), "lateral velocity is the rate|initial vY"),
    "velocity of the left wheel": (lambda f: f.assign(vZ=f["vZ"] + 0.75*f["roll_rate"]), "vZ|vertical velocity"),
    "an accelerometer": (plus(G, "aZ"), "weight and vertical load"),
    "accelerations half a ms late": (late(5, "aY", "aZ", "roll_acc"), "acceler|mass"),
    "Y to a mm": (each(["Y"], lambda y: y.round(3)), "lateral|Y"), "Y drifts by 0.2 mm": (drift(2e-4, "Y"), "Y does not drift"),
    "one Y 1 mm aside": (at_row(0.09, "Y", lambda y: y + 0.001), "no value of Y"), "frozen": (frozen, "velocity|acceler"),
    # Energies.
    "roll energy of the pitch inertia": (times(168/656, "KE_roll"), "kinetic energy, roll"),
    "no elastic energy": (times(0.0, *ENERGY[-2:]), "total energy"),
    "elastic energy of the other wheel": (lambda f: f.assign(PE_elastic_L=f["PE_elastic_R"], PE_elastic_R=f["PE_elastic_L"]),
                                          "no elastic energy of the (left|right) wheel in the air"),
    "energies in kJ": (times(1e-3, *ENERGY), "energy"),
    # Times and rows.
    "stretched by 5 %": (times(1.05, "time"), "velocity is the rate"), "ms below s": (times(1e3, "time"), "units"),
    "rows for times": (lambda f: f.assign(time=1e-4*np.arange(len(f))), "rate|momentum"),      # though rows stand closer at events
    "half of the run": (lambda f: f[f["time"] <= f["time"].iloc[-1]/2], "return to the centre"),
    "first 5 ms missing": (both(lambda f: f[f["time"] >= 0.005], each(["time"], lambda t: t - t.iloc[0])), "initial Y"),
    "rows at 1 kHz": (at_intervals(1e-3), "rows in an impact"), "rows at 200 Hz": (at_intervals(5e-3), "rows in an impact|rate"),
    "out of order": (lambda f: pd.concat([f.iloc[len(f)//2:], f.iloc[:len(f)//2]], ignore_index=True), "falls 1 time"),
    "run twice": (lambda f: pd.concat([f, f], ignore_index=True), "falls 1 time"),
    "4 ms cut out": (lambda f: f[(f["time"] - peak(f)).abs() > 0.002], "no rows are missing"),
    "4 ms spliced": (spliced, "jump"),
    "pause": (lambda f: f.assign(time=f["time"] + 0.010*(f["time"] > 0.078)), "rows are missing"),
    "start 2 mm aside": (lambda f: f[f["Y"].abs().cummax() >= 0.002].assign(
        time=lambda g: g["time"] - g["time"].min()), "initial Y"),
    "no radii": (lambda f: f.drop(columns=of("radius")), "quantities"),
    "no right flange": (lambda f: f.drop(columns=[name for name in f if name.endswith("RF")]), "quantities")}
# Faults beside which a place cannot be judged: contacts press in other rows, rows are too few, or the file is refused.
ALONE = {"forces of the wrong wheel", "flange and tread exchanged", "without the static load", "none of flanges", "frozen", "pause",
         "4 ms cut out", "4 ms spliced", "rows at 200 Hz", "out of order", "run twice", "no radii", "no right flange"}
MILD = {"radius with Z", "angles from the canted rail", "one y 5 mm aside", "Y drifts by 0.2 mm", "4 ms cut out"}     # doubtful

# Generated faults --------------------------------------------------------------------------
SIZES = {"length": 0.005, "angle": 0.3, "speed": 0.1, "spin": 0.01, "acc": 10.0, "spinacc": 20.0, "force": 2e4, "energy": 50.0}


def kind_of(column: str) -> str:
    return KINDS.get(column) or KINDS[column.rpartition("_")[0]]


def lonely(x: pd.Series) -> pd.Series:
    """With one value that stands apart, where a contact is closed."""
    row = int(np.flatnonzero(x.notna() & (x != 0))[(x.notna() & (x != 0)).sum()//3])
    return x.where(np.arange(len(x)) != row, x + 0.3*x.abs().max())


# What is done to one column, and in which columns it changes nothing that a reader could see: heights of treads are near zero,
# positions have free zeros and lie within the elastic approach, rows of a frozen contact are open.
ONE_COLUMN: dict[str, tuple[Callable[[pd.Series, float, pd.Series], pd.Series], str]] = {
    "turned": (lambda x, size, t: -x, "N_..|z_.T"), "doubled": (lambda x, size, t: 2*x, "z_.T"),
    "in thousandths": (lambda x, size, t: 1e3*x, "$."), "a tenth larger": (lambda x, size, t: 1.1*x, "Fy_.T|z_.T"),
    "shifted": (lambda x, size, t: x + size, "Z|y_.T|[KP]E_.*"), "drifting": (lambda x, size, t: x + size*t/t.iloc[-1], "y_.T"),
    "late": (lambda x, size, t: x.shift(8).bfill(), "(y|z|radius)_.."),
    "frozen": (lambda x, size, t: x.mask((t > 0.075) & (t <= 0.078)).ffill(), "vY|.*_.[TF]|KE_lat|PE_elastic_L"),
    "one value": (lambda x, size, t: lonely(x), "roll_acc|PE_elastic_."), "zero": (lambda x, size, t: 0.0*x.fillna(0.0), "z_.T"),
    "gone": (lambda x, size, t: np.nan*x, "[yz]_RF"),
    "rounded": (lambda x, size, t: (3*x/x.abs().max()).round()*x.abs().max()/3, "[yz]_.T|radius_RF")}
GENERATED = [(what, column) for what, (_, unseen) in ONE_COLUMN.items() for column in CALL[1:] + ENERGY
             if not re.fullmatch(unseen, column)]


def words_of(column: str) -> str:
    """What a finding about a column has; a place on a tread shows in those of the flanges, whose zero is that of the treads."""
    quantity, _, contact = column.partition("_")
    more = {"angle": "contact angle", "y": "contact point of .F|roll momentum", "z": "contact point of .F", "N": "energy",
            "Fy": "lateral", "Fz": "vertical", "KE": "energy", "PE": "energy"}
    axis = {"Y": "lateral", "Z": "vertical"}.get(column[-1], "roll")
    return "|".join([rf"\b{column}\b", PLAIN[column], axis if column in MOTION else more.get(quantity, contact),
                     contact if contact in CONTACTS else column])


def generated(what: str, column: str) -> Fault:
    """One column with one fault."""
    change, _ = ONE_COLUMN[what]
    return lambda f: f.assign(**{column: change(f[column], SIZES[kind_of(column)], f["time"])}), words_of(column)


# Runs with other input than that of the call, and what is told of them.
OTHER_INPUT: dict[str, tuple[dict[str, Any], str]] = {
    "mass 1500": ({"mass": 1500.0, "vertical_load": LOAD + 68*G}, "mass by"),
    "load 150 kN": ({"vertical_load": 150e3}, "vertical load"), "inertia": ({"roll_inertia": 600.0}, "roll inertia"),
    "load with inertia": ({"mass": MASS + LOAD/G, "vertical_load": 0.0}, "mass by"),
    "back to back": ({"back_to_back": 1.360}, "published clearance"),
    "gauge at the top": ({"gauge_depth": 0.005}, "clearance|rail"),
    "radius": ({"rolling_radius": 0.460}, "radius_"), "start 10 % faster": ({"vY": 0.55, "roll_rate": 0.01833}, "initial vY"),
    "no roll rate": ({"roll_rate": 0.0}, "initial roll_rate"), "start 1 mm aside": ({"Y": 0.001}, "initial Y"),
    "start sunk in": ({"Z": -0.0005}, r"\w"), "damped steps": ({
        "order": 2, "beta": 0.49, "gamma": 0.9, "dt": 1e-4, "energy_tolerance": 0.0, "error_tolerance": 0.0}, "energy closes")}
