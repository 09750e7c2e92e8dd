"""Files that strangers would send to the benchmark: with mistakes, faultless in odd form, in the styles of codes.

A frame is a pandas DataFrame with the columns of docs/output.md in SI. A row of MISTAKES and FAULTLESS says what is done to the
columns, how the file is written, and the verdict that it should get; `files` makes the files. Written without reading the code
that judges files. A text is written as UTF-8 without translating line ends, bytes as they are.
"""
from __future__ import annotations

import functools
import itertools
import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.integrate import cumulative_trapezoid

from ldbench.constants import CONTACTS
from ldbench_round.findings import DOUBTFUL

Frame = pd.DataFrame
Change = Callable[[Frame], Frame]
G, MASS, LOAD = 9.81, 1568.0, 164618.0       # of the call
DEGREE = 180/np.pi
MOTION = ("Y", "Z", "roll", "vY", "vZ", "roll_rate", "aY", "aZ", "roll_acc")
POINT = ("angle", "N", "Fy", "Fz", "y", "z", "radius")
KINETIC, POTENTIAL = ["KE_lat", "KE_vert", "KE_roll"], ["PE_grav", "PE_load", "PE_elastic_L", "PE_elastic_R"]
ENERGY = (*KINETIC, *POTENTIAL)
FORCES, PLACES = ("N", "Fy", "Fz"), ("angle", "y", "z", "radius")


def of(*quantities: str, contacts: Iterable[str] = CONTACTS) -> list[str]:
    """Columns of contacts."""
    return [f"{quantity}_{contact}" for contact in contacts for quantity in quantities]


CALL = ("time", *MOTION, *of(*POINT))
ALL = CALL + ENERGY
# Columns that change their sign with the lateral axis, with the vertical one, and with the sense of the roll.
RIGHT, DOWN, ROLL = ["Y", "vY", "aY", *of("y")], ["Z", "vZ", "aZ", *of("z")], ["roll", "roll_rate", "roll_acc"]

# Names of columns --------------------------------------------------------------------------
# Form, names of time and motion, quantities of a contact, sides, parts, and energies, with | between them.
WORDS = """{side} {part} {quantity} | time, lateral displacement, vertical displacement, roll angle, lateral velocity, vertical
    velocity, roll velocity, lateral acceleration, vertical acceleration, roll acceleration | contact angle, normal force, lateral
    force, vertical force, contact point y, contact point z, rolling radius | left right | tread flange | kinetic energy lateral,
    kinetic energy vertical, kinetic energy roll, potential energy gravity, potential energy load, elastic energy left, elastic
    energy right"""


def names(text: str = "") -> dict[str, str]:
    """The name of every column, from a text like WORDS, which stands in for parts that are missing or empty."""
    mine, words = ([" ".join(part.split()) for part in some.split("|")] for some in (text, WORDS))
    form, motion, point, sides, parts, energy = (own or word for own, word in itertools.zip_longest(mine, words))
    found = dict(zip(("time", *MOTION, *ENERGY), (*motion.split(", "), *energy.split(", ")), strict=True))
    contacts = zip(CONTACTS, itertools.product(sides.split(), parts.split()), strict=True)
    return found | {f"{quantity}_{contact}": form.format(side=side, part=part, quantity=word)
                    for contact, (side, part) in contacts for quantity, word in zip(POINT, point.split(", "), strict=True)}


PLAIN = names()
SHORT = {column: name.replace(" ", "_") for column, name in PLAIN.items()}
FRENCH = names("""{quantity} {part} roue {side} | temps, déplacement latéral, déplacement vertical, angle de roulis, vitesse
    latérale, vitesse verticale, vitesse de roulis, accélération latérale, accélération verticale, accélération de roulis | angle
    de contact, effort normal, effort latéral, effort vertical, position latérale du contact, position verticale du contact, rayon
    de roulement | gauche droite | table boudin | énergie cinétique latérale, énergie cinétique verticale, énergie cinétique de
    roulis, énergie potentielle de pesanteur, énergie potentielle de la charge, énergie élastique gauche, énergie élastique
    droite""")
GERMAN = names("""{quantity} {part} {side} | Zeit, Querverschiebung, Vertikalverschiebung, Wankwinkel, Quergeschwindigkeit,
    Vertikalgeschwindigkeit, Wankgeschwindigkeit, Querbeschleunigung, Vertikalbeschleunigung, Wankbeschleunigung | Kontaktwinkel,
    Normalkraft, Querkraft, Radkraft, Kontaktpunkt quer, Kontaktpunkt Höhe, Rollradius | links rechts | Lauffläche Spurkranz |
    kinetische Energie quer, kinetische Energie vertikal, kinetische Energie Wanken, potentielle Energie Gewicht, potentielle
    Energie Last, elastische Energie links, elastische Energie rechts""")

# Texts -------------------------------------------------------------------------------------
Units = Mapping[str, tuple[str, float]]         # label and factor of a kind of quantity or of a column
SI: Units = {"time": ("s", 1), "length": ("m", 1), "angle": ("rad", 1), "speed": ("m/s", 1), "spin": ("rad/s", 1),
             "acc": ("m/s2", 1), "spinacc": ("rad/s2", 1), "force": ("N", 1), "energy": ("J", 1)}
MM_KN: Units = {"length": ("mm", 1e3), "force": ("kN", 1e-3)}
MRAD: Units = {"angle": ("mrad", 1e3), "spin": ("mrad/s", 1e3)}
IN_DEGREES: Units = {"angle": ("deg", DEGREE)}
DEGREES: Units = {**IN_DEGREES, "spin": ("deg/s", DEGREE), "spinacc": ("deg/s2", DEGREE)}
IMPERIAL: Units = {"length": ("in", 1/0.0254), "speed": ("in/s", 1/0.0254), "acc": ("g", 1/9.80665),
                   "force": ("lbf", 1/4.4482216152605)}
KINDS = {"time": "time", "roll": "angle", "roll_rate": "spin", "roll_acc": "spinacc", "angle": "angle",
         **dict.fromkeys(("Y", "Z", "y", "z", "radius"), "length"), **dict.fromkeys(("vY", "vZ"), "speed"),
         **dict.fromkeys(("aY", "aZ"), "acc"), **dict.fromkeys(FORCES, "force"), **dict.fromkeys(ENERGY, "energy")}
NAMES, TWO_LINES, QUOTED = ("{name}",), ("{name}", "{unit}"), ('"{name} [{unit}]"',)       # lines of a head
BLANKS = {"sep": " ", "names": SHORT, "head": TWO_LINES}
COMMAS = {"sep": ";", "decimal": ","}


def unit_of(column: str, units: Units) -> tuple[str, float]:
    """The unit of a column and its number in an SI unit."""
    units = {**SI, **units}
    return units.get(column) or units[KINDS.get(column) or KINDS[column.rpartition("_")[0]]]


def text_of(frame: Frame, names: Mapping[str, str] = PLAIN, units: Units = SI, order: Iterable[str] = ALL,
            extra: Callable[[Frame], list[tuple[str, str, Any]]] = lambda frame: [], sep: str = ",",
            head: Iterable[str] = ("{name} [{unit}]",), na: str = "NaN", digits: str = "%.9g", decimal: str = ".",
            eol: str = "\n", before: str = "") -> str:
    """Text of a frame. extra: names, units and values of further columns. head: templates of the lines above the numbers.
    before: what stands above them."""
    columns = [(names.get(column, column), unit, frame[column].to_numpy(float)*factor)
               for column in order for unit, factor in [unit_of(column, units)]]
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
def each(columns: Iterable[str], change: Callable[[pd.Series], Any]) -> Change:
    return lambda frame: frame.assign(**{name: change(frame[name]) for name in columns})


def times(factor: float, *columns: str) -> Change:
    return each(columns, lambda x: x*factor)


def plus(amount: float, *columns: str) -> Change:
    return each(columns, lambda x: x + amount)


def at_contacts(quantity: str, value: Callable[[Frame, str], Any]) -> Change:
    """A quantity of every contact, from the frame and the contact."""
    return lambda frame: frame.assign(**{f"{quantity}_{contact}": value(frame, contact) for contact in CONTACTS})


def swap(*pairs: str, quantities: Iterable[str] = POINT) -> Change:
    """Exchange columns of contacts, as "LT RT"."""
    partner = {a: b for pair in pairs for a, b in (pair.split(), pair.split()[::-1])}
    return lambda frame: frame.assign(**{f"{q}_{a}": frame[f"{q}_{b}"] for q in quantities for a, b in partner.items()})


def both(*changes: Change) -> Change:
    return lambda frame: functools.reduce(lambda found, change: change(found), changes, frame)


def closed_as(value: float, *columns: str) -> Change:
    """A value where a contact is closed."""
    return each(columns, lambda x: x.where(x.isna(), value))


def open_as(value: float) -> Change:
    """A value for position, angle and radius of open contacts."""
    return each(of(*PLACES), lambda x: x.fillna(value))


def at_intervals(dt: float) -> Change:
    """The rows nearest to multiples of dt."""
    def change(frame: Frame) -> Frame:
        t = frame["time"].to_numpy(float)
        nearest = np.floor(np.interp(np.arange(0.0, t[-1] + 1e-9, dt), t, np.arange(len(t))) + 0.5)
        return frame.iloc[np.unique(nearest.astype(int))].reset_index(drop=True)
    return change


def mean_over(t: np.ndarray, values: np.ndarray, width: float) -> np.ndarray:
    """Running mean over a time."""
    a, b = np.clip(t - width/2, t[0], t[-1]), np.clip(t + width/2, t[0], t[-1])
    whole = cumulative_trapezoid(values, t, initial=0)
    return (np.interp(b, t, whole) - np.interp(a, t, whole))/(b - a)


def averaged(width: float, *columns: str) -> Change:
    return lambda f: f.assign(**{name: mean_over(f["time"].to_numpy(), f[name].to_numpy(), width) for name in columns})


def axle_height(frame: Frame) -> float:
    """Height of the axle above the top of rail at the start, from the left contact point and its radius."""
    return float(frame["z_LT"].iloc[0] + frame["radius_LT"].iloc[0])


def first_peak(frame: Frame) -> float:
    """Time of the largest force in the first contact of the left flange that presses with a tenth of its largest force."""
    force = frame["N_LF"].to_numpy()
    closed = np.concatenate([[False], force > 1.0, [False]])
    start, end = next(span for span in np.flatnonzero(closed[1:] != closed[:-1]).reshape(-1, 2)
                      if force[slice(*span)].max() > 0.1*force.max())
    return float(frame["time"].iloc[start + int(np.argmax(force[start:end]))])


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
        force = (frame[f"N_{c}"] - 1e5*(vy*inwards*np.sin(angle) + vz*np.cos(angle))).clip(lower=0.0)
        for name, share in ("N", 1.0), ("Fy", inwards*np.sin(angle)), ("Fz", np.cos(angle)):
            found[f"{name}_{c}"] = (share*force).where(closed, 0.0)
    return found


def rubbed(frame: Frame, coefficient: float = 0.1) -> Frame:
    """With lateral forces of friction against the velocity of each contact point."""
    slip = np.sign(frame["vY"] + 0.457*frame["roll_rate"])
    return at_contacts("Fy", lambda f, c: f[f"Fy_{c}"] + -coefficient*f[f"N_{c}"]*slip)(frame)


def slowed(frame: Frame) -> Frame:
    """With friction of 0.002, which slows the lateral motion too."""
    t, found = frame["time"].to_numpy(), rubbed(frame, 0.002)
    extra = sum((-0.002*frame[name]*np.sign(frame["vY"] + 0.457*frame["roll_rate"])).to_numpy() for name in of("N"))/MASS
    slower = cumulative_trapezoid(extra, t, initial=0)
    return found.assign(aY=frame["aY"] + extra, vY=frame["vY"] + slower, KE_lat=0.5*MASS*(frame["vY"] + slower)**2,
                        Y=frame["Y"] + cumulative_trapezoid(slower, t, initial=0))


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
    def cell(name: str, x: str) -> str:
        return x if name not in of(*FORCES) else f"{float(x):8.0f}" if abs(float(x)) < 3e5 else "********"

    *head, body = text.split("\n", 2)
    rows = [" ".join(map(cell, ALL, line.split(" "))) for line in body.splitlines()]
    return "\n".join([*head, *rows]) + "\n"


# What is in further columns ----------------------------------------------------------------
def creepages(frame: Frame) -> list[tuple[str, str, Any]]:
    return [("pitch angle", "rad", frame["pitch"]), ("forward speed", "m/s", 1.0), ("yaw angle", "rad", 0.0),
            *((f"{PLAIN[name].removesuffix(' normal force')} {what}", unit, 0.0) for name in of("N")
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


def changes(**those: Change) -> dict[str, Row]:
    """Rows of changed columns."""
    return {name: Row(change) for name, change in those.items()}


def forms(file: str = "{case}.csv", **those: Mapping[str, Any]) -> dict[str, Row]:
    """Rows of another form, in files of this name."""
    return {name: Row(form=form, name=file) for name, form in those.items()}


def runs(*cases: str, **those: Mapping[str, Any]) -> dict[str, Row]:
    """Rows of a run with other input."""
    return {name: Row(run=run, cases=cases) for name, run in those.items()}


# A participant did one thing wrong.
MISTAKES = {
    # Rolling radii and angles.
    **changes(
        radius_left_and_right_exchanged=swap("LT RT", "LF RF", quantities=["radius"]),
        radius_always_nominal=closed_as(0.457, *of("radius")),
        radius_of_tread_for_flange=closed_as(0.457, "radius_LF", "radius_RF"),
        radius_is_distance_to_the_centre=at_contacts("radius", lambda f, c: np.hypot(f[f"radius_{c}"], f[f"y_{c}"] - f["Y"])),
        radius_negative=times(-1.0, *of("radius")), radius_doubled=times(2.0, *of("radius")),
        radius_5_mm_too_large=plus(0.005, *of("radius")), radius_in_mm_below_m=times(1e3, *of("radius")),
        angle_of_left_flange_negative=times(-1.0, "angle_LF"), angle_of_right_tread_negative=times(-1.0, "angle_RT"),
        angles_in_degrees_below_rad=times(DEGREE, *of("angle")), slopes_for_angles=each(of("angle"), np.tan),
        angles_from_the_horizontal=each(of("angle"), lambda x: np.pi/2 - x),
        angles_of_left_and_right_exchanged=swap("LF RF", quantities=["angle"])),
    "radius_in_inches_below_mm": Row(times(1/25.4, *of("radius")), {"units": dict.fromkeys(of("radius"), ("mm", 1e3))}),
    "angles_from_the_canted_rail": Row(plus(-1/40, *of("angle")), verdict=DOUBTFUL),
    # Input data.
    **runs(
        radius_of_another_wheelset={"rolling_radius": 0.460}, load_150={"vertical_load": 150000.0},
        load_180={"vertical_load": 180000.0}, load_of_one_wheel={"vertical_load": 82309.0},
        mass_1500={"mass": 1500.0, "vertical_load": LOAD + 68*G}, mass_1600={"mass": 1600.0, "vertical_load": LOAD - 32*G},
        mass_1000={"mass": 1000.0}, load_with_inertia={"mass": MASS + LOAD/G, "vertical_load": 0.0},
        roll_inertia_600={"roll_inertia": 600.0}, roll_inertia_is_pitch_inertia={"roll_inertia": 168.0},
        back_to_back_1360={"back_to_back": 1.360}, gauge_1432={"gauge": 1.432}, gauge_at_the_top={"gauge_depth": 0.005},
        soft_steel={"youngs_modulus": 2.1e10}, rail_of_the_other_pair={"rail_profile": "profiles/srprof.yz"},
        start_ten_percent_faster={"vY": 0.55, "roll_rate": 0.01833}, start_ten_times_slower={"vY": 0.05, "roll_rate": 0.001667},
        roll_rate_missing={"roll_rate": 0.0}, start_1_mm_aside={"Y": 0.001}, start_sunk_in={"Z": -0.0005},
        numerical_damping={"order": 2, "beta": 0.49, "gamma": 0.9, "dt": 1e-4, "energy_tolerance": 0.0, "error_tolerance": 0.0},
        numerical_damping_mild={"order": 2, "beta": 0.3025, "gamma": 0.6, "dt": 1e-4, "energy_tolerance": 0.0,
                                "error_tolerance": 0.0}),
    **runs("ex3_aw", roll_rate_reversed={"roll_rate": -0.0333}),
    **runs("ex5_aw", ramp_4={"lateral_ramp": 4000.0}, ramp_6={"lateral_ramp": 6000.0},
           ramp_starts_at_50_kN={"lateral_force": 50e3}),
    "modulus_of_one_body": Row(run={"stiffness_scale": 2.0}, verdict=DOUBTFUL),      # as a contact law of another code may have
    "gravity_missing": Row(run={"vertical_load": LOAD - MASS*G},
                           join=lambda ours, run: run.assign(PE_load=run["PE_load"] + run["PE_grav"], PE_grav=0.0)),
    "spliced_to_a_slower_run": Row(run={"vY": 0.4, "roll_rate": 0.01333}, join=slower_from_the_turning_point),
    "pairs_exchanged": Row(exchanged={"ex2_aw": "ex2_sw", "ex2_sw": "ex2_aw"}),
    "simplified_pair_as_actual": Row(exchanged={"ex2_aw": "ex2_sw"}),
    "exercises_3_and_4_exchanged": Row(exchanged={"ex3_aw": "ex4_aw", "ex4_aw": "ex3_aw"}, cases=("ex3_aw", "ex4_aw")),
    "exercise_2_sent_as_3": Row(exchanged={"ex3_aw": "ex2_aw"}, cases=("ex2_aw", "ex3_aw")),
    # Physics, time and rows.
    "friction_in_the_motion": Row(slowed, verdict=DOUBTFUL),
    "exercise_5_stopped_at_40_s": Row(lambda f: f[f["time"] <= 40.0], cases=("ex5_aw",)),
    **forms(three_digits={"digits": "%.3g"}),
    **changes(
        start_to_the_right=both(swap("LT RT", "LF RF"), times(-1.0, *RIGHT, *ROLL, *of("Fy")), lambda f: f.assign(
            PE_elastic_L=f["PE_elastic_R"], PE_elastic_R=f["PE_elastic_L"])),
        damper_in_the_contact_force=damped_force, friction_in_the_forces=rubbed,
        time_stretched_by_5_percent=times(1.05, "time"), time_in_ms_below_s=times(1e3, "time"),
        time_is_the_row=lambda f: f.assign(time=1e-4*np.arange(len(f))),       # though rows stand closer at events
        half_of_the_run_missing=lambda f: f[f["time"] <= f["time"].iloc[-1]/2],
        first_5_ms_missing=both(lambda f: f[f["time"] >= 0.005], each(["time"], lambda t: t - t.iloc[0])),
        rows_at_1_kHz=at_intervals(1e-3), rows_at_200_Hz=at_intervals(5e-3),
        rows_in_the_wrong_order=lambda f: pd.concat([f.iloc[len(f)//2:], f.iloc[:len(f)//2]], ignore_index=True),
        forces_averaged_over_1_ms=averaged(1e-3, *of(*FORCES)), forces_2_ms_late=lambda f: each(
            of(*FORCES), lambda x: x.to_numpy()[np.searchsorted(f["time"], f["time"] - 2e-3).clip(0, len(f) - 1)])(f),
        accelerations_averaged_over_5_ms=averaged(5e-3, "aY", "aZ", "roll_acc"),
        # Motion.
        Y_shifted_by_1_mm=plus(0.001, "Y"), Y_at_the_rails=lambda f: f.assign(Y=f["Y"] + 0.457*f["roll"]),
        lateral_velocity_at_the_rails=lambda f: f.assign(vY=f["vY"] + 0.457*f["roll_rate"]),
        roll_velocity_negative=times(-1.0, "roll_rate"), roll_in_mrad_below_rad=times(1e3, "roll"),
        vertical_acceleration_negative=times(-1.0, "aZ"),
        acceleration_of_an_accelerometer=plus(G, "aZ"), accelerations_in_g_below_m_s2=times(1/G, "aY", "aZ"),
        velocities_in_km_h_below_m_s=times(3.6, "vY", "vZ"),
        # Contacts.
        forces_of_the_wrong_wheel=swap("LF RF", quantities=FORCES), normal_force_of_the_wrong_wheel=swap("LT RT", quantities=["N"]),
        flange_and_tread_exchanged_left=swap("LT LF"), flange_and_tread_forces_exchanged_right=swap("RT RF", quantities=FORCES),
        wheel_total_in_the_tread=lambda f: f.assign(Fz_LT=f["Fz_LT"] + f["Fz_LF"], Fz_RT=f["Fz_RT"] + f["Fz_RF"]),
        lateral_forces_of_left_wheel_on_the_rail=times(-1.0, "Fy_LT", "Fy_LF"),
        lateral_and_vertical_force_exchanged=lambda f: f.assign(
            **{f"Fy_{c}": f[f"Fz_{c}"] for c in CONTACTS}, **{f"Fz_{c}": f[f"Fy_{c}"] for c in CONTACTS}),
        forces_along_the_contact_plane=both(times(0.0, *of("Fy")), at_contacts("Fz", lambda f, c: f[f"N_{c}"])),
        static_load_subtracted=plus(-9e4, *of("N", "Fz", contacts=["LT", "RT"])), one_force_in_kN_below_N=times(1e-3, "N_LF"),
        closed_force_kept_after_opening=lambda f: f.assign(**{
            f"{q}_{c}": f[f"{q}_{c}"].where(f[f"N_{c}"] > 1.0).ffill().fillna(0.0) for c in ("LF", "RF") for q in FORCES}),
        contact_points_all_positive=each(of("y"), np.abs),
        contact_points_in_the_wheelset=at_contacts("y", lambda f, c: f[f"y_{c}"] - f["Y"]),
        heights_of_tread_and_flange_exchanged=swap("LT LF", quantities=["z"]), height_of_left_flange_downwards=times(-1.0, "z_LF"),
        flange_point_at_the_gauge_corner=both(
            closed_as(-0.014, "z_LF", "z_RF"), closed_as(1.4351/2, "y_LF"), closed_as(-1.4351/2, "y_RF")),
        flange_positions_all_zero=each(of(*PLACES, contacts=["LF", "RF"]), lambda x: 0.0),
        # Energies.
        kinetic_energy_without_half=times(2.0, *KINETIC), potential_energy_of_load_missing=times(0.0, "PE_load"),
        potential_energy_negative=times(-1.0, "PE_grav", "PE_load")),
    "4_ms_of_the_first_impact_cut_out": Row(lambda f: f[(f["time"] - first_peak(f)).abs() > 0.002]),
    "4_ms_of_the_first_impact_spliced": Row(spliced),
    "lateral_force_inwards": Row(times(-1.0, "Fy_LT", "Fy_LF"), {"names": {**PLAIN, **{
        name: f"{PLAIN[name]} (positive to the left)" for name in of("Fy")}}}),
    "forces_in_tonnes_below_kN": Row(times(1/G, *of(*FORCES)), {"units": MM_KN}),
    # Columns.
    "columns_moved_by_one": Row(after=lambda text: text.replace("vertical velocity [m/s],", "").replace("\n", ",spare [m]\n", 1)),
    **forms(rolling_radii_missing={"order": [name for name in ALL if not name.startswith("radius")]},
            right_flange_missing={"order": [name for name in ALL if not name.endswith("RF")]},
            one_name_twice={"names": {**PLAIN, "N_RF": PLAIN["N_LF"]}}, decimal_commas_between_commas={"decimal": ","}),
    "overflow_stars": Row(form=BLANKS, after=stars, name="{case}.txt"),
}

# Nothing is wrong; the form is odd. Frames that are not those of the call, and another zero of time, are told.
FAULTLESS = {
    # Units.
    **{name: Row(form={"units": units}) for name, units in {
        "mm_and_kN": MM_KN, "mm_kN_mrad": {**MM_KN, **MRAD, "speed": ("mm/s", 1e3)}, "degrees": DEGREES, "imperial": IMPERIAL,
        "contact_angles_in_degrees_roll_in_mrad": {**dict.fromkeys(of("angle"), ("deg", DEGREE)), "roll": ("mrad", 1e3)},
        "accelerations_in_g": {"acc": ("g", 1/9.80665)},
        "units_with_stars": {"acc": ("m/s**2", 1), "spinacc": ("rad/s**2", 1)},
        "units_with_negative_powers": {
            "speed": ("m.s-1", 1), "acc": ("m.s-2", 1), "spin": ("rad.s-1", 1), "spinacc": ("rad.s-2", 1)},
        "units_with_carets": {"acc": ("m/s^2", 1), "spinacc": ("rad/s^2", 1)},
        "units_with_superscripts": {"acc": ("m/s²", 1), "spinacc": ("rad/s²", 1), **dict.fromkeys(of("angle"), ("°", DEGREE))},
        "units_m_s_s": {"acc": ("m/s/s", 1), "spinacc": ("rad/s/s", 1)}, "time_in_ms": {"time": ("ms", 1e3)},
        "MN_and_kJ": {"force": ("MN", 1e-6), "energy": ("kJ", 1e-3)},
        "radius_in_m_positions_in_mm": {**MM_KN, **dict.fromkeys(of("radius"), ("m", 1))}}.items()},
    # Signs, zeros and origins.
    **{name: Row(change, verdict=DOUBTFUL) for name, change in {
        "Y_to_the_right": times(-1.0, *RIGHT, *of("Fy")), "Z_down": times(-1.0, *DOWN, *of("Fz")),
        "Y_right_and_Z_down": times(-1.0, *RIGHT, *DOWN, *of("Fy", "Fz")), "roll_the_other_way": times(-1.0, *ROLL),
        "everything_reversed": times(-1.0, *RIGHT, *DOWN, *ROLL), "time_from_minus_100_ms": plus(-0.1, "time"),
        "time_from_10_s": plus(10.0, "time")}.items()},
    **changes(
        forces_of_the_wheel_on_the_rail=times(-1.0, *of("Fy", "Fz")),
        angles_signed_in_the_track_frame=times(-1.0, "angle_RT", "angle_RF"),
        Z_from_the_unloaded_position=lambda f: f.assign(Z=f["Z"] + (axle_height(f) - 0.457)),
        contact_heights_from_the_axle=lambda f: plus(-axle_height(f), *of("z"))(f),
        contact_heights_from_the_static_contact=lambda f: plus(-f["z_LT"].iloc[0], *of("z"))(f),
        contact_points_from_the_gauge_side=both(plus(-1.4351/2, "y_LT", "y_LF"), plus(1.4351/2, "y_RT", "y_RF")),
        energies_from_the_rails=lambda f: f.assign(PE_grav=f["PE_grav"] + MASS*G*axle_height(f),
                                                   PE_load=f["PE_load"] + LOAD*axle_height(f))),
    "lateral_forces_on_the_rail_outwards": Row(times(-1.0, "Fy_LT", "Fy_LF"), {"names": {**PLAIN, **{
        name: f"{PLAIN[name]} on the rail - outwards positive" for name in of("Fy")}}}),
    "Z_from_the_rails": Row(lambda f: f.assign(Z=f["Z"] + axle_height(f)), {"names": {**PLAIN, "Z": "axle height above rail"}}),
    # Names.
    **forms(
        names_of_the_trade={"units": MM_KN, "names": names("""{side}.{part}.{quantity} | time, wheelset.lat_disp,
            wheelset.vert_disp, wheelset.roll, wheelset.lat_vel, wheelset.vert_vel, wheelset.roll_vel, wheelset.lat_acc,
            wheelset.vert_acc, wheelset.roll_acc | gamma, N, Y, Q, y_cp, z_cp, r | wl wr""")},
        symbols={"units": MM_KN, "names": names("""{quantity}_{side}{part} | t, Y, Z, Phi, dY/dt, dZ/dt, dPhi/dt, d2Y/dt2,
            d2Z/dt2, d2Phi/dt2 | delta, N, Fy, Fz, yc, zc, rc | l r | t f""")},
        dotted_symbols={"names": names("| time, y, z, phi, yp, zp, phip, ypp, zpp, phipp")},
        french={"names": FRENCH, "units": MM_KN, **COMMAS},
        german={"names": GERMAN, "units": {**MM_KN, "angle": ("mrad", 1e3)}, **COMMAS},
        german_Q_and_Y={"units": MM_KN, "sep": ";", "names": {
            column: name.replace("Radkraft", "Radkraft Q").replace("Querkraft", "Führungskraft Y")
            for column, name in GERMAN.items()}},
        numbers_for_sides={"names": names("{quantity} wheel {side} contact {part} | | | 1 2 | 1 2"),
                           "before": "# wheel 1 left - wheel 2 right - contact 1 tread - contact 2 flange\n"}),
    **forms("{case}.txt",
            names_of_ours={"names": {}, "head": NAMES, "sep": " "},
            french_without_accents={"sep": "\t", "names": {
                column: name.translate(str.maketrans("éèêôâ ", "eeeoa_")) for column, name in FRENCH.items()}}),
    **forms("{case}.out", capitals={**BLANKS, "names": names("""{quantity}_{part}_{side} | TIME, YDISP, ZDISP, ROLL, YVEL, ZVEL,
        ROLLVEL, YACC, ZACC, ROLLACC | ANG, FN, FY, FZ, YC, ZC, RR | LEFT RIGHT | TREAD FLANGE | EKY, EKZ, EKROLL, EPGRAV, EPLOAD,
        EELASTL, EELASTR""")}),
    # Separators and heads.
    **forms(
        no_units_SI={"head": NAMES}, semicolons_and_decimal_commas=COMMAS, quoted_names={"head": QUOTED},
        quoted_names_with_commas={"head": QUOTED, "names": names("{quantity}, {side} {part}")},
        units_in_parentheses={"head": ("{name} ({unit})",), "units": MM_KN},
        names_and_units_in_two_lines={"head": TWO_LINES, "units": MM_KN},
        quoted_names_and_units_in_two_lines={"head": ('"{name}"', '"{unit}"'), "units": MM_KN, "sep": ";"},
        comments_with_percent={"before": "% LD benchmark\n% single wheelset without friction\n%\n"},
        comments_with_slashes={"before": "// LD benchmark, single wheelset without friction\n// solver: Newmark, 20 us\n"},
        names_in_a_comment={"before": "# "},
        key_value_header={"before": "mass = 1568\nroll_inertia = 656\nauthor = A. Author\nsimulation = LD\n"},
        ten_lines_of_report={"before": (
            "WHEELSET DYNAMICS PROGRAM, VERSION 4.2\nDate: 2006-06-12\n\nLD benchmark, exercise of the call\n"
            "Mass 1568 kg, roll inertia 656 kg.m2\nLoad 164.618 kN, g = 9.81 m/s2\nStep 1.0E-5 s\nContacts: Hertz\n"
            "Output every 0.1 ms\n\n")},
        table_of_columns_in_the_header={
            "names": {name: f"c{k}" for k, name in enumerate(ALL, 1)}, "head": NAMES, "units": MM_KN, "before": "".join(
                f"# column {k:2d}: {PLAIN[name]} [{unit_of(name, MM_KN)[0]}]\n" for k, name in enumerate(ALL, 1))}),
    **forms("{case}.txt", tabs={"sep": "\t"}, tabs_and_decimal_commas={"sep": "\t", "decimal": ","}, single_blanks=BLANKS),
    **forms("{case}.dat", names_in_a_percent_comment={**BLANKS, "before": "% ", "head": ("{name}[{unit}]",)}),
    "comma_and_blank": Row(after=lambda text: text.replace(",", ", ")),
    "trailing_separator": Row(after=lambda text: text.replace("\n", ",\n")),
    "footer": Row(after=lambda text: text + "# end of run\n# 3 impacts\n"),
    "fixed_width": Row(form={**BLANKS, "head": ("{name}", "[{unit}]")}, after=padded, name="{case}.txt"),
    "several_blanks_and_a_blank_start": Row(
        form={**BLANKS, "head": ("{name}[{unit}]",)},
        after=lambda text: re.sub("^(?=.)", "   ", text.replace(" ", "    "), flags=re.M), name="{case}.dat"),
    "blank_lines": Row(form={"before": "\n\n"}, after=lambda text: re.sub(r"(\A\n\n.*\n)", r"\1\n", text) + "\n\n"),
    # Numbers and open contacts.
    **forms(open_contacts_minus_999_in_mm={"units": {**MM_KN, **IN_DEGREES}, "na": "-999"}, open_contacts_blank={"na": ""},
            open_contacts_word={"na": "n/a"}, plus_signs={"digits": "%+.9e"}, seven_digits={"digits": "%.7g"},
            seventeen_digits={"digits": "%.17g"}),
    **changes(open_contacts_zero=open_as(0.0), open_contacts_huge=open_as(1e30),
              open_contacts_keep_the_last_place=each(of(*PLACES), lambda x: x.ffill().fillna(0.0))),
    "open_contacts_minus_999": Row(open_as(-999.0), {"before": "# -999 no contact\n"}),
    "open_contacts_all_blank": Row(lambda f: f.assign(**{
        f"{q}_{c}": f[f"{q}_{c}"].mask(~(f[f"N_{c}"] > 0.0)) for c in CONTACTS for q in FORCES}), {"na": ""}),
    "exponents_without_E": Row(lambda f: f.mask(f == 0.0, 1e-120), {**BLANKS, "digits": "%.7E"},
                               lambda text: re.sub(r"E([+-]\d{3})", r"\1", text), name="{case}.txt"),
    "exponents_with_D": Row(form={**BLANKS, "digits": "%.10E"},
                            after=lambda text: re.sub(r"(\d)E([+-]\d)", r"\1D\2", text), name="{case}.txt"),
    "numbers_without_leading_zero": Row(
        form={"digits": "%.10f"}, after=lambda text: re.sub(r"(^|,)(-?)0\.(?=\d)", r"\1\2.", text, flags=re.M)),
    # Rows.
    **changes(rows_at_10_kHz=at_intervals(1e-4), variable_step=dense_at_impacts, events_twice=events_twice,
              equal_times_after_rounding=each(["time"], lambda t: t.round(6)),
              start_three_times=lambda f: pd.concat([f.iloc[[0, 0]], f], ignore_index=True)),
    "exercise_1_at_2_kHz": Row(at_intervals(5e-4), cases=("ex1_aw",)),        # some ten rows in each impact
    # Columns and encodings.
    **forms(columns_by_contact={"order": ["time", *of(*POINT, contacts=("RF", "RT", "LF", "LT")), *MOTION, *ENERGY]},
            columns_by_quantity={"order": ["time", *MOTION, *(name for q in POINT for name in of(q)), *ENERGY]},
            columns_in_any_order={"order": np.random.default_rng(7).permutation(ALL).tolist()},
            time_last={"order": [*ALL[1:], "time"]}, extra_columns={"extra": creepages}, wheel_totals={"extra": wheel_totals},
            constraint_forces={"extra": lambda f: [("yaw constraint moment", "N.m", f["M_gyro"]), *sums_of_energies(f)]},
            without_energies={"order": CALL}, sums_of_energies_only={"order": CALL, "extra": sums_of_energies},
            crlf={"eol": "\r\n"}, cr={"eol": "\r"}),
    "no_line_end_at_the_end": Row(after=lambda text: text.rstrip("\n")),
    "row_numbers": Row(after=lambda text: "".join(
        f"{k - 1 if k else ''},{line}\n" for k, line in enumerate(text.splitlines()))),      # as pandas writes an index
    "bom": Row(form={"eol": "\r\n"}, after=lambda text: "\ufeff" + text),
    "latin_1": Row(form={"names": FRENCH, **COMMAS}, after=lambda text: text.encode("latin-1")),
    "utf_16": Row(form={"names": GERMAN, "sep": "\t", "eol": "\r\n"}, after=lambda text: text.encode("utf-16"), name="{case}.txt"),
    **forms("Exercise {n} {words}.txt", names_of_files_in_words={}),
    **forms("MyCode_LDbench_{capitals}.CSV", names_of_files_with_a_code={}),
    **forms("exercise{n}_{pair}prof.dat", names_of_files_with_profiles={"sep": "\t"}),
}

# Whole styles of codes. With Y to the right and Z down, forces on the rail have the signs of the call.
ON_THE_RAIL = times(-1.0, *RIGHT, *DOWN)
STYLES = {
    "simpack": Row(form={"sep": "\t", "names": names("""$RWP_{side}.Patch_{part}.{quantity} | time, $B_WS.pos.y, $B_WS.pos.z,
        $B_WS.ang.al, $B_WS.vel.y, $B_WS.vel.z, $B_WS.omega.al, $B_WS.acc.y, $B_WS.acc.z, $B_WS.omega_dot.al | Contact_angle,
        Normal_force, Lateral_force_track, Vertical_force_track, Contact_pos_y_track, Contact_pos_z_track, Rolling_radius | Left
        Right | Tread Flange | $E.kin.y, $E.kin.z, $E.kin.al, $E.pot.grav, $E.pot.load, $E.pot.RWP_L, $E.pot.RWP_R""")}),
    "nucars": Row(open_as(0.0), {**BLANKS, "units": IMPERIAL, "names": names("""AXLE1_{side}_{part}_{quantity} | TIME,
        AXLE1_Y_DISP, AXLE1_Z_DISP, AXLE1_ROLL, AXLE1_Y_VEL, AXLE1_Z_VEL, AXLE1_ROLL_VEL, AXLE1_Y_ACC, AXLE1_Z_ACC, AXLE1_ROLL_ACC
        | CONT_ANGLE, NORMAL, LATERAL, VERTICAL, CONT_Y, CONT_Z, ROLL_RADIUS | LEFT RIGHT | TREAD FLANGE | KE_LATERAL, KE_VERTICAL,
        KE_ROLL, PE_GRAVITY, PE_LOAD, PE_CONTACT_LEFT, PE_CONTACT_RIGHT""")}, padded),
    "vampire": Row(ON_THE_RAIL, {"head": ("{name} ({unit})",), "units": {**MM_KN, **MRAD}, "names": names("""Wheelset 1 {side}
        {part} {quantity} | Time, Wheelset 1 Lateral Displacement, Wheelset 1 Vertical Displacement, Wheelset 1 Roll Displacement,
        Wheelset 1 Lateral Velocity, Wheelset 1 Vertical Velocity, Wheelset 1 Roll Velocity, Wheelset 1 Lateral Acceleration,
        Wheelset 1 Vertical Acceleration, Wheelset 1 Roll Acceleration | Contact Angle, Normal Force, Lateral Force (track),
        Vertical Force (track), Contact Lateral Position, Contact Vertical Position, Rolling Radius | LH RH | Tread Flange""")}),
    "vi_rail": Row(form={
        "units": {**DEGREES, "length": ("mm", 1e3), "speed": ("mm/s", 1e3), "acc": ("mm/s2", 1e3)}, "head": QUOTED, "na": "",
        "names": names("""{side}_wheel_{part}.{quantity} | TIME, wheelset_disp.lateral, wheelset_disp.vertical,
            wheelset_disp.roll, wheelset_vel.lateral, wheelset_vel.vertical, wheelset_vel.roll, wheelset_acc.lateral,
            wheelset_acc.vertical, wheelset_acc.roll | contact_angle, normal_force, lateral_force, vertical_force, contact_y,
            contact_z, rolling_radius | lef rig | tread flange | energy.kinetic_lateral, energy.kinetic_vertical,
            energy.kinetic_roll, energy.potential_gravity, energy.potential_load, energy.elastic_left, energy.elastic_right""")}),
    "gensys": Row(both(open_as(0.0), ON_THE_RAIL), {
        **BLANKS, "before": "# cp_111lt left tread, cp_111lf left flange, cp_111rt right tread, cp_111rf right flange\n",
        "names": names("""cp_111{side}{part}.{quantity} | time, axl_111.y, axl_111.z, axl_111.f, axl_111.vy, axl_111.vz,
            axl_111.vf, axl_111.ay, axl_111.az, axl_111.af | cang, Fn, Fy, Fz, ycp, zcp, rr | l r | t f | axl_111.Eky, axl_111.Ekz,
            axl_111.Ekf, axl_111.Epg, axl_111.Epload, cp_111l.Eel, cp_111r.Eel""")}),
    "french": Row(form={**COMMAS, "head": TWO_LINES, "na": "", "units": MM_KN, "names": names("""{quantity}_{part}_{side} | temps,
        dep_y, dep_z, roulis, vit_y, vit_z, vit_roulis, acc_y, acc_z, acc_roulis | angle, N, Fy, Fz, y, z, rayon | gauche droit |
        table boudin | Ec_lat, Ec_vert, Ec_roulis, Ep_pesanteur, Ep_charge, Ep_gauche, Ep_droite""")}),
    "german": Row(form={**COMMAS, "na": "-999", "units": {**MM_KN, **MRAD}, "names": names("""{quantity}_{part}_{side} | Zeit,
        y_Radsatz, z_Radsatz, Wankwinkel, vy_Radsatz, vz_Radsatz, Wankgeschw, ay_Radsatz, az_Radsatz, Wankbeschl | Kontaktwinkel,
        Normalkraft, Y_Kraft, Q_Kraft, y_Kontakt, z_Kontakt, Rollradius | li re | Laufflaeche Spurkranz | Ekin_quer, Ekin_vertikal,
        Ekin_Wanken, Epot_Gewicht, Epot_Last, Eelast_links, Eelast_rechts""")}),
    "matlab": Row(form={"sep": " ", "before": "% ", "head": NAMES, "digits": "%.10e", "names": names("""{quantity}{side}{part} |
        t, y, z, phi, ydot, zdot, phidot, yddot, zddot, phiddot | gamma, Fn, Fy, Fz, yc, zc, r | L R | T F | Tlat, Tvert, Troll,
        Vgrav, Vload, VelL, VelR""")}),
    "spreadsheet": Row(form={
        **COMMAS, "units": {**MM_KN, **IN_DEGREES, "time": ("ms", 1e3)}, "head": QUOTED, "na": "", "eol": "\r\n",
        "before": "LD benchmark;;;\n;;;\n", "names": {
            column: name[0].upper() + name[1:] for column, name in names("{quantity} ({side} {part})").items()}},
        after=lambda text: "\ufeff" + text),
    "finite_elements": Row(open_as(1e30), {
        "sep": " ", "head": NAMES, "digits": "%14.6E", "before": "** units: N, m, s, rad; 2 lateral (left), 3 vertical (up)\n",
        "names": names("""{quantity}_{side}_{part} | TIME, U2_N_AXLE, U3_N_AXLE, UR1_N_AXLE, V2_N_AXLE, V3_N_AXLE, VR1_N_AXLE,
            A2_N_AXLE, A3_N_AXLE, AR1_N_AXLE | CANGLE, CFN, CF2, CF3, CCOOR2, CCOOR3, CRADIUS | LEFT RIGHT | TREAD FLANGE |
            ALLKE_2, ALLKE_3, ALLKE_R1, ALLPE_GRAV, ALLPE_LOAD, ALLSE_LEFT, ALLSE_RIGHT""")}),
}
