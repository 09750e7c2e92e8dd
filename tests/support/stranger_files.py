"""Files that strangers would send to the benchmark: with mistakes, faultless in odd form, in the styles of codes.

A frame is a pandas DataFrame with the columns of docs/output.md in SI. A row of MISTAKES and FAULTLESS says what is done to the
columns, how the file is written, and the verdict that it should get; `files` makes the files. Written without reading the code
that judges files. A text is written as UTF-8 without translating line ends, bytes as they are.
"""
from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from ldbench_round.findings import DOUBTFUL

Frame = pd.DataFrame
G = 9.81
MASS, LOAD = 1568.0, 164618.0       # of the call
DEGREE = 180/np.pi
CONTACTS = ("LT", "LF", "RT", "RF")
MOTION = ("Y", "Z", "roll", "vY", "vZ", "roll_rate", "aY", "aZ", "roll_acc")
POINT = ("angle", "N", "Fy", "Fz", "y", "z", "radius")
ENERGY = ("KE_lat", "KE_vert", "KE_roll", "PE_grav", "PE_load", "PE_elastic_L", "PE_elastic_R")
KINETIC, POTENTIAL = list(ENERGY[:3]), list(ENERGY[3:])
FORCES, PLACES = ("N", "Fy", "Fz"), ("angle", "y", "z", "radius")


def of(*quantities: str, contacts: Iterable[str] = CONTACTS) -> list[str]:
    """Columns of contacts."""
    return [f"{quantity}_{contact}" for contact in contacts for quantity in quantities]


CALL = ("time", *MOTION, *of(*POINT))
ALL = CALL + ENERGY
RIGHT, RIGHT_POINTS = ["Y", "vY", "aY"], of("y")         # columns that change their sign with the lateral axis, without forces
DOWN, DOWN_POINTS = ["Z", "vZ", "aZ"], of("z")
ROLL = ["roll", "roll_rate", "roll_acc"]


# Names of columns --------------------------------------------------------------------------

WORDS = ("time, lateral displacement, vertical displacement, roll angle, lateral velocity, vertical velocity, roll velocity, "
         "lateral acceleration, vertical acceleration, roll acceleration")
ENERGIES = ("kinetic energy lateral, kinetic energy vertical, kinetic energy roll, potential energy gravity, "
            "potential energy load, elastic energy left, elastic energy right")
POINTS = "contact angle, normal force, lateral force, vertical force, contact point y, contact point z, rolling radius"


def names(form: str = "{side} {part} {quantity}", motion: str = WORDS, point: str = POINTS, sides: str = "left right",
          parts: str = "tread flange", energy: str = ENERGIES) -> dict[str, str]:
    """The name of every column, from those of the time and the motion, of a contact's quantities, of sides and parts."""
    found = dict(zip(("time", *MOTION, *ENERGY), (*motion.split(", "), *energy.split(", ")), strict=True))
    for quantity, word in zip(POINT, point.split(", "), strict=True):
        for side, side_word in zip("LR", sides.split(), strict=True):
            for part, part_word in zip("TF", parts.split(), strict=True):
                found[f"{quantity}_{side}{part}"] = form.format(side=side_word, part=part_word, quantity=word)
    return found


PLAIN = names()
SHORT = {column: name.replace(" ", "_") for column, name in PLAIN.items()}
FRENCH = names(
    "{quantity} {part} roue {side}",
    "temps, déplacement latéral, déplacement vertical, angle de roulis, vitesse latérale, vitesse verticale, vitesse de roulis, "
    "accélération latérale, accélération verticale, accélération de roulis",
    "angle de contact, effort normal, effort latéral, effort vertical, position latérale du contact, "
    "position verticale du contact, rayon de roulement", "gauche droite", "table boudin",
    "énergie cinétique latérale, énergie cinétique verticale, énergie cinétique de roulis, énergie potentielle de pesanteur, "
    "énergie potentielle de la charge, énergie élastique gauche, énergie élastique droite")
GERMAN = names(
    "{quantity} {part} {side}",
    "Zeit, Querverschiebung, Vertikalverschiebung, Wankwinkel, Quergeschwindigkeit, Vertikalgeschwindigkeit, "
    "Wankgeschwindigkeit, Querbeschleunigung, Vertikalbeschleunigung, Wankbeschleunigung",
    "Kontaktwinkel, Normalkraft, Querkraft, Radkraft, Kontaktpunkt quer, Kontaktpunkt Höhe, Rollradius", "links rechts",
    "Lauffläche Spurkranz",
    "kinetische Energie quer, kinetische Energie vertikal, kinetische Energie Wanken, potentielle Energie Gewicht, "
    "potentielle Energie Last, elastische Energie links, elastische Energie rechts")


# Texts -------------------------------------------------------------------------------------

SI = {"time": ("s", 1), "length": ("m", 1), "angle": ("rad", 1), "speed": ("m/s", 1), "spin": ("rad/s", 1),
      "acc": ("m/s2", 1), "spinacc": ("rad/s2", 1), "force": ("N", 1), "energy": ("J", 1)}
MM_KN = {"length": ("mm", 1e3), "force": ("kN", 1e-3)}
MRAD, IN_DEGREES = {"angle": ("mrad", 1e3), "spin": ("mrad/s", 1e3)}, {"angle": ("deg", DEGREE)}
KINDS = {"time": "time", "Y": "length", "Z": "length", "roll": "angle", "vY": "speed", "vZ": "speed", "roll_rate": "spin",
         "aY": "acc", "aZ": "acc", "roll_acc": "spinacc", "angle": "angle", "N": "force", "Fy": "force", "Fz": "force",
         "y": "length", "z": "length", "radius": "length", **dict.fromkeys(ENERGY, "energy")}
NAMES, TWO_LINES = ("{name}",), ("{name}", "{unit}")     # lines of a head


def text_of(frame: Frame, names: Mapping[str, str] = PLAIN, units: Mapping[str, tuple[str, float]] = SI,
            order: Iterable[str] = ALL, extra: Callable[[Frame], list[tuple[str, str, Any]]] = lambda frame: [], sep: str = ",",
            head: Iterable[str] = ("{name} [{unit}]",), na: str = "NaN", digits: str = "%.9g", decimal: str = ".",
            eol: str = "\n", before: str = "") -> str:
    """Text of a frame. units: label and factor of a kind of quantity or of a column. extra: names, units and values of further
    columns. head: templates of the lines above the numbers. before: what stands above them."""
    units, columns = {**SI, **units}, []
    for column in order:
        label, factor = units.get(column) or units[KINDS.get(column) or KINDS[column.rpartition("_")[0]]]
        columns.append((names.get(column, column), label, frame[column].to_numpy(float)*factor))
    columns += [(name, unit, np.broadcast_to(values, len(frame))) for name, unit, values in extra(frame)]
    table = Frame({k: values for k, (_, _, values) in enumerate(columns)}) + 0.0
    body = table.to_csv(sep=sep, header=False, index=False, na_rep=na, float_format=digits, decimal=decimal,
                        lineterminator="\n", quoting=3, escapechar="\\").replace("\\", "")
    lines = (sep.join(line.format(name=name, unit=unit) for name, unit, _ in columns) + "\n" for line in head)
    return (before + "".join(lines) + body).replace("\n", eol)


def padded(text: str) -> str:
    """Words of a text that is separated by blanks, right-justified in 32 characters."""
    return "".join("".join(word.rjust(32) for word in line.split(" ")) + "\n" for line in text.splitlines())


# Changes of columns ------------------------------------------------------------------------

Change = Callable[[Frame], Frame]


def times(factor: float, *columns: str) -> Change:
    return lambda frame: frame.assign(**{name: frame[name]*factor for name in columns})


def each(columns: Iterable[str], change: Callable[[pd.Series], Any]) -> Change:
    return lambda frame: frame.assign(**{name: change(frame[name]) for name in columns})


def put(**columns: Callable[[Frame], Any]) -> Change:
    return lambda frame: frame.assign(**columns)


def swap(*pairs: str, quantities: Iterable[str] = POINT) -> Change:
    """Exchange columns of contacts, as "LT RT"."""
    def change(frame: Frame) -> Frame:
        one, other = (of(*quantities, contacts=contacts) for contacts in zip(*map(str.split, pairs), strict=True))
        return frame.assign(**{a: frame[b] for a, b in (*zip(one, other, strict=True), *zip(other, one, strict=True))})
    return change


def both(*changes: Change) -> Change:
    def change(frame: Frame) -> Frame:
        for one in changes:
            frame = one(frame)
        return frame
    return change


def rows(which: Callable[[Frame], Any]) -> Change:
    """Some rows, by a mask."""
    return lambda frame: frame[which(frame)]


def closed_as(value: float, columns: Iterable[str]) -> Change:
    """A value where a contact is closed."""
    return each(columns, lambda x: x.where(x.isna(), value))


def open_as(value: float) -> Change:
    """A value for position, angle and radius of open contacts."""
    return each(of(*PLACES), lambda x: x.fillna(value))


def at_intervals(dt: float) -> Change:
    """The rows nearest to multiples of dt."""
    def change(frame: Frame) -> Frame:
        t = frame["time"].to_numpy(float)
        wanted = np.arange(0.0, t[-1] + 1e-9, dt)
        after = np.searchsorted(t, wanted).clip(1, len(t) - 1)
        return frame.iloc[np.unique(np.where(wanted - t[after - 1] < t[after] - wanted, after - 1, after))].reset_index(drop=True)
    return change


def integral(t: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """By trapezia, zero at the start."""
    return np.concatenate([[0.0], np.cumsum(np.diff(t)*(rate[1:] + rate[:-1])/2)])


def mean_over(t: np.ndarray, values: np.ndarray, width: float) -> np.ndarray:
    """Running mean over a time."""
    whole = integral(t, values)
    a, b = np.clip(t - width/2, t[0], t[-1]), np.clip(t + width/2, t[0], t[-1])
    return (np.interp(b, t, whole) - np.interp(a, t, whole))/(b - a)


def averaged(width: float, *columns: str) -> Change:
    return lambda frame: frame.assign(**{
        name: mean_over(frame["time"].to_numpy(), frame[name].to_numpy(), width) for name in columns})


def axle_height(frame: Frame) -> float:
    """Height of the axle above the top of rail at the start, from the left contact point and its radius."""
    return float(frame["z_LT"].iloc[0] + frame["radius_LT"].iloc[0])


def first_peak(frame: Frame) -> float:
    """Time of the largest force in the first contact of the left flange that presses with a tenth of its largest force."""
    force = frame["N_LF"].to_numpy()
    closed = np.concatenate([[False], force > 1.0, [False]])
    for start, end in np.flatnonzero(closed[1:] != closed[:-1]).reshape(-1, 2):
        if force[start:end].max() > 0.1*force.max():
            return float(frame["time"].iloc[start + int(np.argmax(force[start:end]))])
    raise AssertionError("no contact of the left flange")


MIRROR = both(swap("LT RT", "LF RF"), times(-1.0, *RIGHT, *RIGHT_POINTS, *ROLL, *of("Fy")),
              lambda f: f.assign(PE_elastic_L=f["PE_elastic_R"], PE_elastic_R=f["PE_elastic_L"]))
WHEEL_TOTALS = put(**{f"Fz_{side}T": lambda f, side=side: f[f"Fz_{side}T"] + f[f"Fz_{side}F"] for side in "LR"})


def spliced(frame: Frame) -> Frame:
    """Without 4 ms about the peak of the first impact, the gap in the times closed."""
    t, peak = frame["time"], first_peak(frame)
    late = t > peak + 0.002
    return frame.assign(time=t.where(~late, t - 0.004))[(t < peak - 0.002) | late]


def slower_from_the_turning_point(fast: Frame, slow: Frame) -> Frame:
    """A contact that loses 36 % of the energy."""
    a, b = (int(np.argmax(frame["Y"])) for frame in (fast, slow))
    rest = slow.iloc[b + 1:].assign(time=lambda f: f["time"] + (fast["time"].iloc[a] - slow["time"].iloc[b]))
    return pd.concat([fast.iloc[:a + 1], rest], ignore_index=True)


def damped_force(frame: Frame) -> Frame:
    """With a damper of 100 kN s/m in the normal force, at the given motion."""
    found = frame.copy()
    for c in CONTACTS:
        closed, inwards, angle = frame[f"N_{c}"] > 1.0, -1.0 if c[0] == "L" else 1.0, frame[f"angle_{c}"]
        vy = frame["vY"] - frame["roll_rate"]*(frame[f"z_{c}"] - frame["Z"] - axle_height(frame))
        vz = frame["vZ"] + frame["roll_rate"]*(frame[f"y_{c}"] - frame["Y"])
        leaving = vy*inwards*np.sin(angle) + vz*np.cos(angle)
        force = (frame[f"N_{c}"] - 1e5*leaving).clip(lower=0.0).where(closed, 0.0)
        found[f"N_{c}"] = force
        found[f"Fy_{c}"] = (inwards*np.sin(angle)*force).where(closed, 0.0)
        found[f"Fz_{c}"] = (np.cos(angle)*force).where(closed, 0.0)
    return found


def friction(frame: Frame, coefficient: float) -> dict[str, pd.Series]:
    """Lateral forces of friction against the velocity of each contact point."""
    slip = np.sign(frame["vY"] + 0.457*frame["roll_rate"])
    return {f"Fy_{c}": -coefficient*frame[f"N_{c}"]*slip for c in CONTACTS}


def rubbed(frame: Frame) -> Frame:
    forces = friction(frame, 0.1)
    return frame.assign(**{name: frame[name] + force for name, force in forces.items()})


def slowed(frame: Frame) -> Frame:
    """With friction of 0.002, which slows the lateral motion too."""
    forces, t = friction(frame, 0.002), frame["time"].to_numpy()
    extra = sum(force.to_numpy() for force in forces.values())/MASS
    slower = integral(t, extra)
    found = frame.assign(**{name: frame[name] + force for name, force in forces.items()}, aY=frame["aY"] + extra,
                         vY=frame["vY"] + slower, Y=frame["Y"] + integral(t, slower))
    return found.assign(KE_lat=0.5*MASS*found["vY"]**2)


def late_forces(frame: Frame) -> Frame:
    """Forces 2 ms later than the motion."""
    t = frame["time"].to_numpy()
    before = np.searchsorted(t, t - 2e-3).clip(0, len(t) - 1)
    return frame.assign(**{name: frame[name].to_numpy()[before] for name in of(*FORCES)})


def dense_at_impacts(frame: Frame) -> Frame:
    """All rows while a flange is closed and 2 ms around it, else every second row."""
    t, k = frame["time"].to_numpy(), np.arange(len(frame))
    closed = (frame["N_LF"].to_numpy() > 0) | (frame["N_RF"].to_numpy() > 0)
    return frame[(mean_over(t, closed.astype(float), 4e-3) > 0) | (k % 2 == 0) | (k == len(t) - 1)]


def events_twice(frame: Frame) -> Frame:
    """Rows at which a contact closes or opens stand in the file twice."""
    closed = frame[of("N")].to_numpy() > 0
    event = np.concatenate([[False], (closed[1:] != closed[:-1]).any(axis=1)])
    return frame.loc[frame.index.repeat(1 + event)].reset_index(drop=True)


def stars(text: str) -> str:
    """Forces in a format that is too narrow for the largest, which Fortran prints as stars."""
    *head, body = text.split("\n", 2)
    lines = [line.split(" ") for line in body.splitlines()]
    for line in lines:
        for k, name in enumerate(ALL):
            if name.startswith(("N_", "Fy_", "Fz_")):
                line[k] = f"{float(line[k]):8.0f}" if abs(float(line[k])) < 3e5 else "********"
    return "\n".join([*head, *map(" ".join, lines)]) + "\n"


def numbered(text: str) -> str:
    """With the number of each row before it, as pandas writes an index."""
    head, *lines = text.splitlines()
    return "\n".join([f",{head}", *(f"{k},{line}" for k, line in enumerate(lines))]) + "\n"


# What is in further columns ----------------------------------------------------------------

def creepages(frame: Frame) -> list[tuple[str, str, Any]]:
    return [("pitch angle", "rad", frame["pitch"]), ("forward speed", "m/s", 1.0), ("yaw angle", "rad", 0.0),
            *((f"{name.removesuffix(' normal force')} {what}", unit, 0.0) for name in map(PLAIN.get, of("N"))
              for what, unit in (("creepage x", "-"), ("creepage y", "-"), ("spin", "1/m"), ("creep force", "N")))]


def wheel_totals(frame: Frame) -> list[tuple[str, str, Any]]:
    found: list[tuple[str, str, Any]] = []
    for side, word in ("L", "left"), ("R", "right"):
        vertical, lateral = (frame[f"{q}_{side}T"] + frame[f"{q}_{side}F"] for q in ("Fz", "Fy"))
        ratio = (lateral.abs()/vertical.where(vertical > 1.0)).fillna(0.0)
        found += [(f"{word} wheel Q", "N", vertical), (f"{word} wheel Y", "N", lateral), (f"{word} wheel L/V", "-", ratio)]
    return found


def sums_of_energies(frame: Frame) -> list[tuple[str, str, Any]]:
    kinetic, potential = frame[KINETIC].sum(axis=1), frame[POTENTIAL].sum(axis=1)
    return [("kinetic energy", "J", kinetic), ("potential energy", "J", potential), ("total energy", "J", kinetic + potential)]


# Rows --------------------------------------------------------------------------------------

class Row(NamedTuple):
    """A file that somebody sends."""

    change: Change = lambda frame: frame            # of the columns
    form: Mapping[str, Any] = {}                    # arguments of `text_of`
    after: Callable[[str], str | bytes] = str       # of the text
    run: Mapping[str, Any] = {}                     # namelist variables of a run that stands in the place of ours
    join: Callable[[Frame, Frame], Frame] = lambda ours, run: run
    exchanged: Mapping[str, str] = {}               # the simulation whose columns stand under the name of another one
    cases: tuple[str, ...] = ()                     # the simulations that show it, if not any
    name: str = "{case}.csv"
    verdict: str = ""                               # if not that of all others of the table


def files(row: Row, frames: Mapping[str, Frame], runs: Mapping[str, Frame] | None = None) -> dict[str, str | bytes]:
    """The files of a stranger by their names; `runs` are the runs of this row."""
    found = {}
    for case, ours in frames.items():
        frame = frames.get(row.exchanged.get(case, case), ours)
        frame = row.join(frame, runs[case]) if runs and case in runs else frame
        words = {"aw": "actual", "sw": "simplified"}[case[4:]]
        name = row.name.format(case=case, capitals=case.upper(), n=case[2], pair=case[4:], words=words)
        found[name] = row.after(text_of(row.change(frame), **row.form))
    return found


BLANKS = {"sep": " ", "names": SHORT, "head": TWO_LINES}
COMMAS = {"sep": ";", "decimal": ","}
RAMP = ("ex5_aw",)
FAST = ("ex3_aw",)

# A participant did one thing wrong.
MISTAKES = {
    # Rolling radii and angles.
    "radius_left_and_right_exchanged": Row(swap("LT RT", "LF RF", quantities=["radius"])),
    "radius_always_nominal": Row(closed_as(0.457, of("radius"))),
    "radius_of_tread_for_flange": Row(closed_as(0.457, ["radius_LF", "radius_RF"])),
    "radius_is_distance_to_the_centre": Row(put(**{
        f"radius_{c}": lambda f, c=c: np.hypot(f[f"radius_{c}"], f[f"y_{c}"] - f["Y"]) for c in CONTACTS})),
    "radius_negative": Row(times(-1.0, *of("radius"))),
    "radius_doubled": Row(times(2.0, *of("radius"))),
    "radius_5_mm_too_large": Row(each(of("radius"), lambda x: x + 0.005)),
    "radius_in_mm_below_m": Row(times(1e3, *of("radius"))),
    "radius_in_inches_below_mm": Row(times(1/25.4, *of("radius")), {"units": dict.fromkeys(of("radius"), ("mm", 1e3))}),
    "radius_of_another_wheelset": Row(run={"rolling_radius": 0.460}),
    "angle_of_left_flange_negative": Row(times(-1.0, "angle_LF")),
    "angle_of_right_tread_negative": Row(times(-1.0, "angle_RT")),
    "angles_in_degrees_below_rad": Row(times(DEGREE, *of("angle"))),
    "angles_from_the_horizontal": Row(each(of("angle"), lambda x: np.pi/2 - x)),
    "slopes_for_angles": Row(each(of("angle"), np.tan)),
    "angles_from_the_canted_rail": Row(each(of("angle"), lambda x: x - 1/40), verdict=DOUBTFUL),
    "angles_of_left_and_right_exchanged": Row(swap("LF RF", quantities=["angle"])),
    # Input data.
    "load_150": Row(run={"vertical_load": 150000.0}),
    "load_180": Row(run={"vertical_load": 180000.0}),
    "load_of_one_wheel": Row(run={"vertical_load": 82309.0}),
    "gravity_missing": Row(run={"vertical_load": LOAD - MASS*G},
                           join=lambda ours, run: run.assign(PE_load=run["PE_load"] + run["PE_grav"], PE_grav=0.0)),
    "mass_1500": Row(run={"mass": 1500.0, "vertical_load": LOAD + 68*G}),
    "mass_1600": Row(run={"mass": 1600.0, "vertical_load": LOAD - 32*G}),
    "mass_1000": Row(run={"mass": 1000.0}),
    "load_with_inertia": Row(run={"mass": MASS + LOAD/G, "vertical_load": 0.0}),
    "roll_inertia_600": Row(run={"roll_inertia": 600.0}),
    "roll_inertia_is_pitch_inertia": Row(run={"roll_inertia": 168.0}),
    "back_to_back_1360": Row(run={"back_to_back": 1.360}),
    "gauge_1432": Row(run={"gauge": 1.432}),
    "gauge_at_the_top": Row(run={"gauge_depth": 0.005}),
    "soft_steel": Row(run={"youngs_modulus": 2.1e10}),
    "modulus_of_one_body": Row(run={"stiffness_scale": 2.0}, verdict=DOUBTFUL),      # as a contact law of another code may have
    "rail_of_the_other_pair": Row(run={"rail_profile": "profiles/srprof.yz"}),
    "pairs_exchanged": Row(exchanged={"ex2_aw": "ex2_sw", "ex2_sw": "ex2_aw"}),
    "simplified_pair_as_actual": Row(exchanged={"ex2_aw": "ex2_sw"}),
    "exercises_3_and_4_exchanged": Row(exchanged={"ex3_aw": "ex4_aw", "ex4_aw": "ex3_aw"}, cases=("ex3_aw", "ex4_aw")),
    "exercise_2_sent_as_3": Row(exchanged={"ex3_aw": "ex2_aw"}, cases=("ex2_aw", "ex3_aw")),
    "start_ten_percent_faster": Row(run={"vY": 0.55, "roll_rate": 0.01833}),
    "start_ten_times_slower": Row(run={"vY": 0.05, "roll_rate": 0.001667}),
    "roll_rate_missing": Row(run={"roll_rate": 0.0}),
    "roll_rate_reversed": Row(run={"roll_rate": -0.0333}, cases=FAST),
    "start_1_mm_aside": Row(run={"Y": 0.001}),
    "start_sunk_in": Row(run={"Z": -0.0005}),
    "start_to_the_right": Row(MIRROR),
    "ramp_4": Row(run={"lateral_ramp": 4000.0}, cases=RAMP),
    "ramp_6": Row(run={"lateral_ramp": 6000.0}, cases=RAMP),
    "ramp_starts_at_50_kN": Row(run={"lateral_force": 50000.0}, cases=RAMP),
    # Physics.
    "numerical_damping": Row(run={"order": 2, "beta": 0.49, "gamma": 0.9, "dt": 1e-4, "energy_tolerance": 0.0}),
    "numerical_damping_mild": Row(run={"order": 2, "beta": 0.3025, "gamma": 0.6, "dt": 1e-4, "energy_tolerance": 0.0}),
    "spliced_to_a_slower_run": Row(run={"vY": 0.4, "roll_rate": 0.01333}, join=slower_from_the_turning_point),
    "damper_in_the_contact_force": Row(damped_force),
    "friction_in_the_forces": Row(rubbed),
    "friction_in_the_motion": Row(slowed, verdict=DOUBTFUL),
    # Time and rows.
    "time_stretched_by_5_percent": Row(times(1.05, "time")),
    "time_in_ms_below_s": Row(times(1e3, "time")),
    "time_is_the_row": Row(put(time=lambda f: 1e-4*np.arange(len(f)))),       # though rows stand closer at events
    "half_of_the_run_missing": Row(rows(lambda f: f["time"] <= f["time"].iloc[-1]/2)),
    "exercise_5_stopped_at_40_s": Row(rows(lambda f: f["time"] <= 40.0), cases=RAMP),
    "4_ms_of_the_first_impact_cut_out": Row(rows(lambda f: (f["time"] - first_peak(f)).abs() > 0.002)),
    "4_ms_of_the_first_impact_spliced": Row(spliced),
    "first_5_ms_missing": Row(both(rows(lambda f: f["time"] >= 0.005), put(time=lambda f: f["time"] - f["time"].iloc[0]))),
    "rows_at_1_kHz": Row(at_intervals(1e-3)),
    "rows_at_200_Hz": Row(at_intervals(5e-3)),
    "three_digits": Row(form={"digits": "%.3g"}),
    "rows_in_the_wrong_order": Row(lambda f: pd.concat([f.iloc[len(f)//2:], f.iloc[:len(f)//2]], ignore_index=True)),
    "forces_averaged_over_1_ms": Row(averaged(1e-3, *of(*FORCES))),
    "accelerations_averaged_over_5_ms": Row(averaged(5e-3, "aY", "aZ", "roll_acc")),
    "forces_2_ms_late": Row(late_forces),
    # Motion.
    "Y_shifted_by_1_mm": Row(put(Y=lambda f: f["Y"] + 0.001)),
    "Y_at_the_rails": Row(put(Y=lambda f: f["Y"] + 0.457*f["roll"])),
    "lateral_velocity_at_the_rails": Row(put(vY=lambda f: f["vY"] + 0.457*f["roll_rate"])),
    "roll_velocity_negative": Row(times(-1.0, "roll_rate")),
    "roll_in_mrad_below_rad": Row(times(1e3, "roll")),
    "vertical_acceleration_negative": Row(times(-1.0, "aZ")),
    "acceleration_of_an_accelerometer": Row(put(aZ=lambda f: f["aZ"] + G)),
    "accelerations_in_g_below_m_s2": Row(times(1/G, "aY", "aZ")),
    "velocities_in_km_h_below_m_s": Row(times(3.6, "vY", "vZ")),
    # Contacts.
    "forces_of_the_wrong_wheel": Row(swap("LF RF", quantities=FORCES)),
    "normal_force_of_the_wrong_wheel": Row(swap("LT RT", quantities=["N"])),
    "flange_and_tread_exchanged_left": Row(swap("LT LF")),
    "flange_and_tread_forces_exchanged_right": Row(swap("RT RF", quantities=FORCES)),
    "wheel_total_in_the_tread": Row(WHEEL_TOTALS),
    "lateral_and_vertical_force_exchanged": Row(lambda f: f.assign(
        **{f"Fy_{c}": f[f"Fz_{c}"] for c in CONTACTS}, **{f"Fz_{c}": f[f"Fy_{c}"] for c in CONTACTS})),
    "forces_along_the_contact_plane": Row(both(
        times(0.0, *of("Fy")), lambda f: f.assign(**{f"Fz_{c}": f[f"N_{c}"] for c in CONTACTS}))),
    "lateral_forces_of_left_wheel_on_the_rail": Row(times(-1.0, "Fy_LT", "Fy_LF")),
    "lateral_force_inwards": Row(times(-1.0, "Fy_LT", "Fy_LF"), {"names": {**PLAIN, **{
        name: f"{PLAIN[name]} (positive to the left)" for name in of("Fy")}}}),
    "static_load_subtracted": Row(each(of("N", "Fz", contacts=["LT", "RT"]), lambda x: x - 9e4)),
    "one_force_in_kN_below_N": Row(times(1e-3, "N_LF")),
    "forces_in_tonnes_below_kN": Row(times(1/G, *of(*FORCES)), {"units": MM_KN}),
    "closed_force_kept_after_opening": Row(lambda f: f.assign(**{
        f"{q}_{c}": f[f"{q}_{c}"].where(f[f"N_{c}"] > 1.0).ffill().fillna(0.0) for c in ("LF", "RF") for q in FORCES})),
    "contact_points_all_positive": Row(each(of("y"), np.abs)),
    "contact_points_in_the_wheelset": Row(lambda f: f.assign(**{name: f[name] - f["Y"] for name in of("y")})),
    "heights_of_tread_and_flange_exchanged": Row(swap("LT LF", quantities=["z"])),
    "height_of_left_flange_downwards": Row(times(-1.0, "z_LF")),
    "flange_point_at_the_gauge_corner": Row(both(
        closed_as(-0.014, ["z_LF", "z_RF"]), closed_as(1.4351/2, ["y_LF"]), closed_as(-1.4351/2, ["y_RF"]))),
    # Energies.
    "kinetic_energy_without_half": Row(times(2.0, *KINETIC)),
    "potential_energy_of_load_missing": Row(times(0.0, "PE_load")),
    "potential_energy_negative": Row(times(-1.0, "PE_grav", "PE_load")),
    # Columns.
    "columns_moved_by_one": Row(after=lambda text: text.replace("vertical velocity [m/s],", "").replace("\n", ",spare [m]\n", 1)),
    "rolling_radii_missing": Row(form={"order": [name for name in ALL if not name.startswith("radius")]}),
    "right_flange_missing": Row(form={"order": [name for name in ALL if not name.endswith("RF")]}),
    "flange_positions_all_zero": Row(each(of(*PLACES, contacts=["LF", "RF"]), lambda x: 0.0)),
    "one_name_twice": Row(form={"names": {**PLAIN, "N_RF": PLAIN["N_LF"]}}),
    "decimal_commas_between_commas": Row(form={"decimal": ","}),
    "overflow_stars": Row(form=BLANKS, after=stars, name="{case}.txt"),
}

# Nothing is wrong; the form is odd. Frames that are not those of the call, and another zero of time, are told.
FAULTLESS = {
    # Units.
    "mm_and_kN": Row(form={"units": MM_KN}),
    "mm_kN_mrad": Row(form={"units": {**MM_KN, **MRAD, "speed": ("mm/s", 1e3)}}),
    "degrees": Row(form={"units": {**IN_DEGREES, "spin": ("deg/s", DEGREE), "spinacc": ("deg/s2", DEGREE)}}),
    "contact_angles_in_degrees_roll_in_mrad": Row(
        form={"units": {**dict.fromkeys(of("angle"), ("deg", DEGREE)), "roll": ("mrad", 1e3)}}),
    "accelerations_in_g": Row(form={"units": {"acc": ("g", 1/9.80665)}}),
    "units_with_stars": Row(form={"units": {"acc": ("m/s**2", 1), "spinacc": ("rad/s**2", 1)}}),
    "units_with_negative_powers": Row(form={"units": {
        "speed": ("m.s-1", 1), "acc": ("m.s-2", 1), "spin": ("rad.s-1", 1), "spinacc": ("rad.s-2", 1)}}),
    "units_with_carets": Row(form={"units": {"acc": ("m/s^2", 1), "spinacc": ("rad/s^2", 1)}}),
    "units_with_superscripts": Row(form={"units": {
        "acc": ("m/s²", 1), "spinacc": ("rad/s²", 1), **dict.fromkeys(of("angle"), ("°", DEGREE))}}),
    "units_m_s_s": Row(form={"units": {"acc": ("m/s/s", 1), "spinacc": ("rad/s/s", 1)}}),
    "imperial": Row(form={"units": {"length": ("in", 1/0.0254), "speed": ("in/s", 1/0.0254), "acc": ("g", 1/9.80665),
                                    "force": ("lbf", 1/4.4482216152605)}}),
    "time_in_ms": Row(form={"units": {"time": ("ms", 1e3)}}),
    "MN_and_kJ": Row(form={"units": {"force": ("MN", 1e-6), "energy": ("kJ", 1e-3)}}),
    "no_units_SI": Row(form={"head": NAMES}),
    "radius_in_m_positions_in_mm": Row(form={"units": {**MM_KN, **dict.fromkeys(of("radius"), ("m", 1))}}),
    # Signs.
    "Y_to_the_right": Row(times(-1.0, *RIGHT, *RIGHT_POINTS, *of("Fy")), verdict=DOUBTFUL),
    "Z_down": Row(times(-1.0, *DOWN, *DOWN_POINTS, *of("Fz")), verdict=DOUBTFUL),
    "Y_right_and_Z_down": Row(times(-1.0, *RIGHT, *RIGHT_POINTS, *DOWN, *DOWN_POINTS, *of("Fy", "Fz")), verdict=DOUBTFUL),
    "roll_the_other_way": Row(times(-1.0, *ROLL), verdict=DOUBTFUL),
    "forces_of_the_wheel_on_the_rail": Row(times(-1.0, *of("Fy", "Fz"))),
    "angles_signed_in_the_track_frame": Row(times(-1.0, "angle_RT", "angle_RF")),
    "lateral_forces_on_the_rail_outwards": Row(times(-1.0, "Fy_LT", "Fy_LF"), {"names": {**PLAIN, **{
        name: f"{PLAIN[name]} on the rail - outwards positive" for name in of("Fy")}}}),
    "everything_reversed": Row(times(-1.0, *RIGHT, *RIGHT_POINTS, *DOWN, *DOWN_POINTS, *ROLL), verdict=DOUBTFUL),
    # Zeros and origins.
    "Z_from_the_rails": Row(put(Z=lambda f: f["Z"] + axle_height(f)), {"names": {**PLAIN, "Z": "axle height above rail"}}),
    "Z_from_the_unloaded_position": Row(put(Z=lambda f: f["Z"] + (axle_height(f) - 0.457))),
    "contact_heights_from_the_axle": Row(lambda f: each(of("z"), lambda x: x - axle_height(f))(f)),
    "contact_heights_from_the_static_contact": Row(lambda f: each(of("z"), lambda x: x - f["z_LT"].iloc[0])(f)),
    "contact_points_from_the_gauge_side": Row(both(
        each(["y_LT", "y_LF"], lambda x: x - 1.4351/2), each(["y_RT", "y_RF"], lambda x: x + 1.4351/2))),
    "time_from_minus_100_ms": Row(put(time=lambda f: f["time"] - 0.1), verdict=DOUBTFUL),
    "time_from_10_s": Row(put(time=lambda f: f["time"] + 10.0), verdict=DOUBTFUL),
    "energies_from_the_rails": Row(put(PE_grav=lambda f: f["PE_grav"] + MASS*G*axle_height(f),
                                       PE_load=lambda f: f["PE_load"] + LOAD*axle_height(f))),
    # Names.
    "names_of_ours": Row(form={"names": {}, "head": NAMES, "sep": " "}, name="{case}.txt"),
    "names_of_the_trade": Row(form={"units": MM_KN, "names": names(
        "{side}.{part}.{quantity}",
        "time, wheelset.lat_disp, wheelset.vert_disp, wheelset.roll, wheelset.lat_vel, wheelset.vert_vel, wheelset.roll_vel, "
        "wheelset.lat_acc, wheelset.vert_acc, wheelset.roll_acc", "gamma, N, Y, Q, y_cp, z_cp, r", "wl wr")}),
    "symbols": Row(form={"units": MM_KN, "names": names(
        "{quantity}_{side}{part}", "t, Y, Z, Phi, dY/dt, dZ/dt, dPhi/dt, d2Y/dt2, d2Z/dt2, d2Phi/dt2",
        "delta, N, Fy, Fz, yc, zc, rc", "l r", "t f")}),
    "dotted_symbols": Row(form={"names": names(motion="time, y, z, phi, yp, zp, phip, ypp, zpp, phipp")}),
    "french": Row(form={"names": FRENCH, "units": MM_KN, **COMMAS}),
    "french_without_accents": Row(form={"sep": "\t", "names": {
        column: name.translate(str.maketrans("éèêôâ ", "eeeoa_")) for column, name in FRENCH.items()}}, name="{case}.txt"),
    "german": Row(form={"names": GERMAN, "units": {**MM_KN, "angle": ("mrad", 1e3)}, **COMMAS}),
    "german_Q_and_Y": Row(form={"units": MM_KN, "sep": ";", "names": {column: name.replace("Radkraft", "Radkraft Q").replace(
        "Querkraft", "Führungskraft Y") for column, name in GERMAN.items()}}),
    "numbers_for_sides": Row(form={
        "names": names("{quantity} wheel {side} contact {part}", sides="1 2", parts="1 2"),
        "before": "# wheel 1 left - wheel 2 right - contact 1 tread - contact 2 flange\n"}),
    "capitals": Row(form={**BLANKS, "names": names(
        "{quantity}_{part}_{side}", "TIME, YDISP, ZDISP, ROLL, YVEL, ZVEL, ROLLVEL, YACC, ZACC, ROLLACC",
        "ANG, FN, FY, FZ, YC, ZC, RR", "LEFT RIGHT", "TREAD FLANGE", "EKY, EKZ, EKROLL, EPGRAV, EPLOAD, EELASTL, EELASTR")},
        name="{case}.out"),
    # Separators and heads.
    "semicolons_and_decimal_commas": Row(form=COMMAS),
    "tabs": Row(form={"sep": "\t"}, name="{case}.txt"),
    "tabs_and_decimal_commas": Row(form={"sep": "\t", "decimal": ","}, name="{case}.txt"),
    "single_blanks": Row(form=BLANKS, name="{case}.txt"),
    "fixed_width": Row(form={**BLANKS, "head": ("{name}", "[{unit}]")}, after=padded, name="{case}.txt"),
    "several_blanks_and_a_blank_start": Row(
        form={**BLANKS, "head": ("{name}[{unit}]",)},
        after=lambda text: re.sub("^(?=.)", "   ", text.replace(" ", "    "), flags=re.M), name="{case}.dat"),
    "comma_and_blank": Row(after=lambda text: text.replace(",", ", ")),
    "trailing_separator": Row(after=lambda text: text.replace("\n", ",\n")),
    "quoted_names": Row(form={"head": ('"{name} [{unit}]"',)}),
    "quoted_names_with_commas": Row(form={"head": ('"{name} [{unit}]"',), "names": names("{quantity}, {side} {part}")}),
    "units_in_parentheses": Row(form={"head": ("{name} ({unit})",), "units": MM_KN}),
    "names_and_units_in_two_lines": Row(form={"head": TWO_LINES, "units": MM_KN}),
    "quoted_names_and_units_in_two_lines": Row(form={"head": ('"{name}"', '"{unit}"'), "units": MM_KN, "sep": ";"}),
    "comments_with_percent": Row(form={"before": "% LD benchmark\n% single wheelset without friction\n%\n"}),
    "comments_with_slashes": Row(form={"before": "// LD benchmark, single wheelset without friction\n// solver: Newmark, 20 us\n"}),
    "names_in_a_comment": Row(form={"before": "# "}),
    "names_in_a_percent_comment": Row(form={**BLANKS, "before": "% ", "head": ("{name}[{unit}]",)}, name="{case}.dat"),
    "key_value_header": Row(form={"before": "mass = 1568\nroll_inertia = 656\nauthor = A. Author\nsimulation = LD\n"}),
    "ten_lines_of_report": Row(form={"before": (
        "WHEELSET DYNAMICS PROGRAM, VERSION 4.2\nDate: 2006-06-12\n\nLD benchmark, exercise of the call\n"
        "Mass 1568 kg, roll inertia 656 kg.m2\nLoad 164.618 kN, g = 9.81 m/s2\nStep 1.0E-5 s\nContacts: Hertz\n"
        "Output every 0.1 ms\n\n")}),
    "table_of_columns_in_the_header": Row(form={
        "names": {name: f"c{k}" for k, name in enumerate(ALL, 1)}, "head": NAMES, "units": MM_KN, "before": "".join(
            f"# column {k:2d}: {PLAIN[name]} [{({**SI, **MM_KN})[KINDS.get(name) or KINDS[name.rpartition('_')[0]]][0]}]\n"
            for k, name in enumerate(ALL, 1))}),
    "footer": Row(after=lambda text: text + "# end of run\n# 3 impacts\n"),
    "blank_lines": Row(form={"before": "\n\n"}, after=lambda text: re.sub(r"(\A\n\n.*\n)", r"\1\n", text) + "\n\n"),
    # Numbers and open contacts.
    "open_contacts_minus_999": Row(open_as(-999.0), {"before": "# -999 no contact\n"}),
    "open_contacts_minus_999_in_mm": Row(form={"units": {**MM_KN, **IN_DEGREES}, "na": "-999"}),
    "open_contacts_zero": Row(open_as(0.0)),
    "open_contacts_blank": Row(form={"na": ""}),
    "open_contacts_all_blank": Row(lambda f: f.assign(**{
        f"{q}_{c}": f[f"{q}_{c}"].mask(~(f[f"N_{c}"] > 0.0)) for c in CONTACTS for q in FORCES}), {"na": ""}),
    "open_contacts_word": Row(form={"na": "n/a"}),
    "open_contacts_huge": Row(open_as(1e30)),
    "open_contacts_keep_the_last_place": Row(each(of(*PLACES), lambda x: x.ffill().fillna(0.0))),
    "exponents_without_E": Row(lambda f: f.mask(f == 0.0, 1e-120), {**BLANKS, "digits": "%.7E"},
                               lambda text: re.sub(r"E([+-]\d{3})", r"\1", text), name="{case}.txt"),
    "exponents_with_D": Row(form={**BLANKS, "digits": "%.10E"},
                            after=lambda text: re.sub(r"(\d)E([+-]\d)", r"\1D\2", text), name="{case}.txt"),
    "numbers_without_leading_zero": Row(
        form={"digits": "%.10f"}, after=lambda text: re.sub(r"(^|,)(-?)0\.(?=\d)", r"\1\2.", text, flags=re.M)),
    "plus_signs": Row(form={"digits": "%+.9e"}),
    "seven_digits": Row(form={"digits": "%.7g"}),
    "seventeen_digits": Row(form={"digits": "%.17g"}),
    # Rows.
    "rows_at_10_kHz": Row(at_intervals(1e-4)),
    "exercise_1_at_2_kHz": Row(at_intervals(5e-4), cases=("ex1_aw",)),        # some ten rows in each impact
    "variable_step": Row(dense_at_impacts),
    "events_twice": Row(events_twice),
    "equal_times_after_rounding": Row(each(["time"], lambda t: t.round(6))),
    "start_three_times": Row(lambda f: pd.concat([f.iloc[[0, 0]], f], ignore_index=True)),
    # Columns and encodings.
    "columns_by_contact": Row(form={"order": ["time", *of(*POINT, contacts=("RF", "RT", "LF", "LT")), *MOTION, *ENERGY]}),
    "columns_by_quantity": Row(form={"order": ["time", *MOTION, *(name for q in POINT for name in of(q)), *ENERGY]}),
    "columns_in_any_order": Row(form={"order": np.random.default_rng(7).permutation(ALL).tolist()}),
    "time_last": Row(form={"order": [*ALL[1:], "time"]}),
    "row_numbers": Row(after=numbered),
    "extra_columns": Row(form={"extra": creepages}),
    "wheel_totals": Row(form={"extra": wheel_totals}),
    "constraint_forces": Row(form={"extra": lambda f: [("yaw constraint moment", "N.m", f["M_gyro"]), *sums_of_energies(f)]}),
    "without_energies": Row(form={"order": CALL}),
    "sums_of_energies_only": Row(form={"order": CALL, "extra": sums_of_energies}),
    "crlf": Row(form={"eol": "\r\n"}),
    "cr": Row(form={"eol": "\r"}),
    "bom": Row(form={"eol": "\r\n"}, after=lambda text: "\ufeff" + text),
    "latin_1": Row(form={"names": FRENCH, **COMMAS}, after=lambda text: text.encode("latin-1")),
    "utf_16": Row(form={"names": GERMAN, "sep": "\t", "eol": "\r\n"}, after=lambda text: text.encode("utf-16"), name="{case}.txt"),
    "no_line_end_at_the_end": Row(after=lambda text: text.rstrip("\n")),
    "names_of_files_in_words": Row(name="Exercise {n} {words}.txt"),
    "names_of_files_with_a_code": Row(name="MyCode_LDbench_{capitals}.CSV"),
    "names_of_files_with_profiles": Row(form={"sep": "\t"}, name="exercise{n}_{pair}prof.dat"),
}

# Whole styles of codes. With Y to the right and Z down, forces on the rail have the signs of the call.
ON_THE_RAIL = times(-1.0, *RIGHT, *RIGHT_POINTS, *DOWN, *DOWN_POINTS)
STYLES = {
    "simpack": Row(form={"sep": "\t", "names": names(
        "$RWP_{side}.Patch_{part}.{quantity}",
        "time, $B_WS.pos.y, $B_WS.pos.z, $B_WS.ang.al, $B_WS.vel.y, $B_WS.vel.z, $B_WS.omega.al, $B_WS.acc.y, $B_WS.acc.z, "
        "$B_WS.omega_dot.al",
        "Contact_angle, Normal_force, Lateral_force_track, Vertical_force_track, Contact_pos_y_track, Contact_pos_z_track, "
        "Rolling_radius", "Left Right", "Tread Flange",
        "$E.kin.y, $E.kin.z, $E.kin.al, $E.pot.grav, $E.pot.load, $E.pot.RWP_L, $E.pot.RWP_R")}),
    "nucars": Row(open_as(0.0), {**BLANKS, "units": FAULTLESS["imperial"].form["units"], "names": names(
        "AXLE1_{side}_{part}_{quantity}",
        "TIME, AXLE1_Y_DISP, AXLE1_Z_DISP, AXLE1_ROLL, AXLE1_Y_VEL, AXLE1_Z_VEL, AXLE1_ROLL_VEL, AXLE1_Y_ACC, AXLE1_Z_ACC, "
        "AXLE1_ROLL_ACC", "CONT_ANGLE, NORMAL, LATERAL, VERTICAL, CONT_Y, CONT_Z, ROLL_RADIUS", "LEFT RIGHT", "TREAD FLANGE",
        "KE_LATERAL, KE_VERTICAL, KE_ROLL, PE_GRAVITY, PE_LOAD, PE_CONTACT_LEFT, PE_CONTACT_RIGHT")}, padded),
    "vampire": Row(ON_THE_RAIL, {"head": ("{name} ({unit})",), "units": {**MM_KN, **MRAD}, "names": names(
        "Wheelset 1 {side} {part} {quantity}",
        "Time, Wheelset 1 Lateral Displacement, Wheelset 1 Vertical Displacement, Wheelset 1 Roll Displacement, "
        "Wheelset 1 Lateral Velocity, Wheelset 1 Vertical Velocity, Wheelset 1 Roll Velocity, Wheelset 1 Lateral Acceleration, "
        "Wheelset 1 Vertical Acceleration, Wheelset 1 Roll Acceleration",
        "Contact Angle, Normal Force, Lateral Force (track), Vertical Force (track), Contact Lateral Position, "
        "Contact Vertical Position, Rolling Radius", "LH RH", "Tread Flange")}),
    "vi_rail": Row(form={
        "units": {**IN_DEGREES, "spin": ("deg/s", DEGREE), "spinacc": ("deg/s2", DEGREE), "length": ("mm", 1e3),
                  "speed": ("mm/s", 1e3), "acc": ("mm/s2", 1e3)},
        "head": ('"{name} [{unit}]"',), "na": "", "names": names(
            "{side}_wheel_{part}.{quantity}",
            "TIME, wheelset_disp.lateral, wheelset_disp.vertical, wheelset_disp.roll, wheelset_vel.lateral, "
            "wheelset_vel.vertical, wheelset_vel.roll, wheelset_acc.lateral, wheelset_acc.vertical, wheelset_acc.roll",
            "contact_angle, normal_force, lateral_force, vertical_force, contact_y, contact_z, rolling_radius", "lef rig",
            "tread flange", "energy.kinetic_lateral, energy.kinetic_vertical, energy.kinetic_roll, energy.potential_gravity, "
            "energy.potential_load, energy.elastic_left, energy.elastic_right")}),
    "gensys": Row(both(open_as(0.0), ON_THE_RAIL), {
        **BLANKS, "before": "# cp_111lt left tread, cp_111lf left flange, cp_111rt right tread, cp_111rf right flange\n",
        "names": names(
            "cp_111{side}{part}.{quantity}", "time, axl_111.y, axl_111.z, axl_111.f, axl_111.vy, axl_111.vz, axl_111.vf, "
            "axl_111.ay, axl_111.az, axl_111.af", "cang, Fn, Fy, Fz, ycp, zcp, rr", "l r", "t f",
            "axl_111.Eky, axl_111.Ekz, axl_111.Ekf, axl_111.Epg, axl_111.Epload, cp_111l.Eel, cp_111r.Eel")}),
    "french": Row(form={**COMMAS, "head": TWO_LINES, "na": "", "units": MM_KN, "names": names(
        "{quantity}_{part}_{side}", "temps, dep_y, dep_z, roulis, vit_y, vit_z, vit_roulis, acc_y, acc_z, acc_roulis",
        "angle, N, Fy, Fz, y, z, rayon", "gauche droit", "table boudin",
        "Ec_lat, Ec_vert, Ec_roulis, Ep_pesanteur, Ep_charge, Ep_gauche, Ep_droite")}),
    "german": Row(form={**COMMAS, "na": "-999", "units": {**MM_KN, **MRAD}, "names": names(
        "{quantity}_{part}_{side}", "Zeit, y_Radsatz, z_Radsatz, Wankwinkel, vy_Radsatz, vz_Radsatz, Wankgeschw, ay_Radsatz, "
        "az_Radsatz, Wankbeschl", "Kontaktwinkel, Normalkraft, Y_Kraft, Q_Kraft, y_Kontakt, z_Kontakt, Rollradius", "li re",
        "Laufflaeche Spurkranz",
        "Ekin_quer, Ekin_vertikal, Ekin_Wanken, Epot_Gewicht, Epot_Last, Eelast_links, Eelast_rechts")}),
    "matlab": Row(form={"sep": " ", "before": "% ", "head": NAMES, "digits": "%.10e", "names": names(
        "{quantity}{side}{part}", "t, y, z, phi, ydot, zdot, phidot, yddot, zddot, phiddot", "gamma, Fn, Fy, Fz, yc, zc, r",
        "L R", "T F", "Tlat, Tvert, Troll, Vgrav, Vload, VelL, VelR")}),
    "spreadsheet": Row(form={
        **COMMAS, "units": {**MM_KN, **IN_DEGREES, "time": ("ms", 1e3)}, "head": ('"{name} [{unit}]"',), "na": "", "eol": "\r\n",
        "before": "LD benchmark;;;\n;;;\n", "names": {
            column: name[0].upper() + name[1:] for column, name in names("{quantity} ({side} {part})").items()}},
        after=lambda text: "\ufeff" + text),
    "finite_elements": Row(open_as(1e30), {
        "sep": " ", "head": NAMES, "digits": "%14.6E", "before": "** units: N, m, s, rad; 2 lateral (left), 3 vertical (up)\n",
        "names": names(
            "{quantity}_{side}_{part}", "TIME, U2_N_AXLE, U3_N_AXLE, UR1_N_AXLE, V2_N_AXLE, V3_N_AXLE, VR1_N_AXLE, A2_N_AXLE, "
            "A3_N_AXLE, AR1_N_AXLE", "CANGLE, CFN, CF2, CF3, CCOOR2, CCOOR3, CRADIUS", "LEFT RIGHT", "TREAD FLANGE",
            "ALLKE_2, ALLKE_3, ALLKE_R1, ALLPE_GRAV, ALLPE_LOAD, ALLSE_LEFT, ALLSE_RIGHT")}),
}
