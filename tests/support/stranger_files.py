"""Files that strangers would send to the benchmark: with mistakes, faultless in odd form, in the styles of codes.

A frame is a pandas DataFrame with the columns of docs/output.md in SI, of exercise 2 with the actual profiles. Every function
gives the content of a file: a str, to be written as UTF-8 without translating line ends, or bytes. RUNS are mistakes in the
input. Written without reading the code that judges files.
"""
from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

G = 9.81
MASS, LOAD, HEIGHT = 1568.0, 164618.0, 0.457        # of the call; HEIGHT of the axle above the rails, without load
CONTACTS = ("LT", "LF", "RT", "RF")
MOTION = ("Y", "Z", "roll", "vY", "vZ", "roll_rate", "aY", "aZ", "roll_acc")
POINT = ("angle", "N", "Fy", "Fz", "y", "z", "radius")
PLACE = ("angle", "y", "z", "radius")
ENERGY = ("KE_lat", "KE_vert", "KE_roll", "PE_grav", "PE_load", "PE_elastic_L", "PE_elastic_R")


def of(quantities: Iterable[str], contacts: Iterable[str] = CONTACTS) -> list[str]:
    """Names of columns of contacts."""
    return [f"{q}_{c}" for c in contacts for q in quantities]


CALL = ("time", *MOTION, *of(POINT))
ALL = (*CALL, *ENERGY)

File = str | bytes
Form = Callable[[pd.DataFrame], File]


# ---- names and units -----------------------------------------------------------------
LEFT_RIGHT, TREAD_FLANGE = ("left", "right"), ("tread", "flange")


def names(words: str, points: str, form: str = "{side} {part} {quantity}", sides: Sequence[str] = LEFT_RIGHT,
          parts: Sequence[str] = TREAD_FLANGE) -> dict[str, str]:
    """{column: name}: words of the time, of the motion and of the energies, words of a contact's quantities, `/` between them."""
    found = dict(zip(("time", *MOTION, *ENERGY), words.split("/"), strict=True))
    for c in CONTACTS:
        for q, quantity in zip(POINT, points.split("/"), strict=True):
            found[f"{q}_{c}"] = form.format(side=sides["LR".index(c[0])], part=parts["TF".index(c[1])], quantity=quantity)
    return found


ENGLISH = ("time/lateral displacement/vertical displacement/roll angle/lateral velocity/vertical velocity/roll velocity/"
           "lateral acceleration/vertical acceleration/roll acceleration")
ENERGIES = ("/kinetic energy lateral/kinetic energy vertical/kinetic energy roll/potential energy gravity/potential energy load/"
            "elastic energy left/elastic energy right")
POINTS = "contact angle/normal force/lateral force/vertical force/contact point y/contact point z/rolling radius"
PLAIN = names(ENGLISH + ENERGIES, POINTS)
SHORT = {name: text.replace(" ", "_") for name, text in PLAIN.items()}
FRENCH = names(
    "temps/déplacement latéral/déplacement vertical/angle de roulis/vitesse latérale/vitesse verticale/vitesse de roulis/"
    "accélération latérale/accélération verticale/accélération de roulis/énergie cinétique latérale/énergie cinétique verticale/"
    "énergie cinétique de roulis/énergie potentielle de pesanteur/énergie potentielle de la charge/énergie élastique gauche/"
    "énergie élastique droite",
    "angle de contact/effort normal/effort latéral/effort vertical/position latérale du contact/position verticale du contact/"
    "rayon de roulement", "{quantity} {part} roue {side}", ("gauche", "droite"), ("table", "boudin"))
GERMAN = names(
    "Zeit/Querverschiebung/Vertikalverschiebung/Wankwinkel/Quergeschwindigkeit/Vertikalgeschwindigkeit/Wankgeschwindigkeit/"
    "Querbeschleunigung/Vertikalbeschleunigung/Wankbeschleunigung/kinetische Energie quer/kinetische Energie vertikal/"
    "kinetische Energie Wanken/potentielle Energie Gewicht/potentielle Energie Last/elastische Energie links/"
    "elastische Energie rechts",
    "Kontaktwinkel/Normalkraft/Querkraft/Radkraft/Kontaktpunkt quer/Kontaktpunkt Höhe/Rollradius", "{quantity} {part} {side}",
    ("links", "rechts"), ("Lauffläche", "Spurkranz"))

Units = dict[str, tuple[str, float]]        # label and factor from SI, of a kind of columns or of one
SI: Units = {"time": ("s", 1), "length": ("m", 1), "angle": ("rad", 1), "speed": ("m/s", 1), "spin": ("rad/s", 1),
             "acc": ("m/s2", 1), "spinacc": ("rad/s2", 1), "force": ("N", 1), "energy": ("J", 1)}
MM_KN: Units = {"length": ("mm", 1e3), "force": ("kN", 1e-3)}
MRAD: Units = {"angle": ("mrad", 1e3), "spin": ("mrad/s", 1e3)}
DEGREE = 180/np.pi
KINDS = {"time": "time", "Y": "length", "Z": "length", "roll": "angle", "vY": "speed", "vZ": "speed", "roll_rate": "spin",
         "aY": "acc", "aZ": "acc", "roll_acc": "spinacc", "angle": "angle", "N": "force", "Fy": "force", "Fz": "force",
         "y": "length", "z": "length", "radius": "length"}


def kind(name: str) -> str:
    """Kind of unit of a column."""
    return "energy" if name in ENERGY else KINDS.get(name) or KINDS[name.rpartition("_")[0]]


RIGHT, DOWN, ROLL = ("Y", "vY", "aY", *of(["Fy", "y"])), ("Z", "vZ", "aZ", *of(["Fz", "z"])), ("roll", "roll_rate", "roll_acc")
# The lateral axis to the right and the vertical one down; forces on the rail have the signs of the call again.
ON_RAIL = (*RIGHT[:3], *of(["y"]), *DOWN[:3], *of(["z"]))


# ---- the text of a frame -------------------------------------------------------------
def text_of(frame: pd.DataFrame, named: Mapping[str, str] = PLAIN, units: Units | None = None, signs: Sequence[str] = (),
            offset: Mapping[str, float] | None = None, order: Sequence[str] = ALL,
            extra: Sequence[tuple[str, str, Any]] = (), sep: str = ",", head: str = "brackets", na: str = "NaN",
            digits: str = "%.9g", decimal: str = ".", eol: str = "\n", before: str = "", hollow: float | None = None) -> str:
    """`signs`: columns with the other sign; `offset`: SI values added before the unit; `extra`: (name, unit, values); `hollow`:
    position, angle and radius of open contacts."""
    if hollow is not None:
        frame = frame.assign(**{name: frame[name].fillna(hollow) for name in of(PLACE)})
    known, offset, columns = SI | (units or {}), offset or {}, []
    for name in order:
        label, factor = known.get(name) or known[kind(name)]
        values = frame[name].to_numpy(float) + offset.get(name, 0.0)
        columns.append((named.get(name, name), label, values*factor*(-1.0 if name in signs else 1.0)))
    columns += [(name, unit, np.broadcast_to(values, len(frame))) for name, unit, values in extra]
    form = {"parens": "{} ({})", "glued": "{}[{}]", "quoted": '"{} [{}]"'}.get(head, "{} [{}]")
    texts, labels = [text for text, _, _ in columns], [label for _, label, _ in columns]
    lines = {"two lines": [texts, labels], "two lines in brackets": [texts, [f"[{label}]" for label in labels]],
             "names": [texts]}.get(head, [[form.format(*both) for both in zip(texts, labels, strict=True)]])
    row = sep.join([digits]*len(columns))
    body = "".join(row % cells + "\n" for cells in zip(*((values + 0.0).tolist() for _, _, values in columns), strict=True))
    body = re.sub(r"\+?nan", na, body.replace(".", decimal), flags=re.IGNORECASE)
    text = before + "".join(sep.join(line) + "\n" for line in lines) + body
    return text.replace("\n", eol)


def form(edit: Callable[[str], File] | None = None, **options: Any) -> Form:
    """A file in a form, its text edited."""
    def make(frame: pd.DataFrame) -> File:
        text = text_of(frame, **options)
        return edit(text) if edit else text
    return make


def changed(change: Callable[[pd.DataFrame], pd.DataFrame | None], **options: Any) -> Form:
    """A plain file of a frame that `change` alters; it gets a copy and gives a frame, or None and has altered the copy."""
    def make(frame: pd.DataFrame) -> str:
        copy = frame.copy()
        result = change(copy)
        return text_of(copy if result is None else result, **options)
    return make


def scaled(columns: Sequence[str], factor: float, **options: Any) -> Form:
    return changed(lambda frame: frame.assign(**{name: factor*frame[name] for name in columns}), **options)


def swapped(one: str, other: str, quantities: Sequence[str] = POINT) -> Form:
    """The columns of two contacts exchanged."""
    a, b = of(quantities, [one]), of(quantities, [other])
    return changed(lambda frame: frame.assign(**{x: frame[y] for x, y in zip(a + b, b + a, strict=True)}))


def padded(text: str, width: int = 32) -> str:
    """Right-justified words of each line."""
    return "".join("".join(word.rjust(width) for word in line.split(" ")) + "\n" for line in text.splitlines())


def at(frame: pd.DataFrame, dt: float) -> pd.DataFrame:
    """Rows nearest to multiples of dt."""
    t = frame["time"].to_numpy(float)
    rows = [int(np.abs(t - wanted).argmin()) for wanted in np.arange(0.0, t[-1] + 1e-9, dt)]
    return frame.iloc[np.unique(rows)].reset_index(drop=True)


def integral(t: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Integral over time by trapezia, zero at the start."""
    return np.concatenate([[0.0], np.cumsum(np.diff(t)*(rate[1:] + rate[:-1])/2)])


def mean_over(t: np.ndarray, values: np.ndarray, width: float) -> np.ndarray:
    """Running mean over a time, from the integral."""
    total = integral(t, values)
    a, b = np.clip(t - width/2, t[0], t[-1]), np.clip(t + width/2, t[0], t[-1])
    return (np.interp(b, t, total) - np.interp(a, t, total))/(b - a)


def averaged(columns: Sequence[str], width: float) -> Form:
    return changed(lambda frame: frame.assign(**{
        name: mean_over(frame["time"].to_numpy(), frame[name].to_numpy(), width) for name in columns}))


def axle_height(frame: pd.DataFrame) -> float:
    """Height of the axle above the top of rail at the start, from the left contact point and its radius."""
    return float(frame["z_LT"].iloc[0] + frame["radius_LT"].iloc[0])


# ---- mistakes ------------------------------------------------------------------------
# The participant's input was wrong: runs with these namelist variables.
RUNS: dict[str, dict[str, Any]] = {
    "load 150 kN": {"vertical_load": 150000.0},
    "gravity missing": {"vertical_load": LOAD - MASS*G},
    "mass 1500 kg and the weight of the call": {"mass": 1500.0, "vertical_load": LOAD + 68*G},
    "load with inertia": {"mass": MASS + LOAD/G, "vertical_load": 0.0},
    "roll inertia is the pitch inertia": {"roll_inertia": 168.0},
    "modulus of one body": {"stiffness_scale": 2.0},
    "rail of the other pair": {"rail_profile": "profiles/srprof.yz"},
    "start ten percent faster": {"vY": 0.55, "roll_rate": 0.01833},
    "roll rate missing": {"roll_rate": 0.0},
    "start 1 mm aside": {"Y": 0.001},
    "numerical damping": {"order": 2, "beta": 0.3025, "gamma": 0.6, "dt": 1e-4, "energy_tolerance": 0.0},
}


def damper(frame: pd.DataFrame) -> None:
    """A damper of 100 kN s/m in the normal force, which the call excludes, at the given motion."""
    for c in CONTACTS:
        closed, angle, inwards = frame[f"N_{c}"] > 1.0, frame[f"angle_{c}"], -1.0 if c[0] == "L" else 1.0
        vy = frame["vY"] - frame["roll_rate"]*(frame[f"z_{c}"] - frame["Z"] - axle_height(frame))
        vz = frame["vZ"] + frame["roll_rate"]*(frame[f"y_{c}"] - frame["Y"])
        force = (frame[f"N_{c}"] - 1e5*(vy*inwards*np.sin(angle) + vz*np.cos(angle))).clip(lower=0.0)
        for q, share in ("N", 1.0), ("Fy", inwards*np.sin(angle)), ("Fz", np.cos(angle)):
            frame[f"{q}_{c}"] = (share*force).where(closed, 0.0)


def friction(frame: pd.DataFrame, coefficient: float) -> np.ndarray:
    """Lateral friction against the lateral velocity of each contact point; gives its sum."""
    slip = np.sign(frame["vY"] + HEIGHT*frame["roll_rate"])
    for c in CONTACTS:
        frame[f"Fy_{c}"] -= coefficient*frame[f"N_{c}"]*slip
    return -coefficient*(frame[of(["N"])].sum(axis=1)*slip).to_numpy()


def friction_in_the_forces(frame: pd.DataFrame) -> None:
    friction(frame, 0.1)


def friction_in_the_motion(frame: pd.DataFrame) -> None:
    extra, t = friction(frame, 0.002)/MASS, frame["time"].to_numpy()
    slower = integral(t, extra)
    frame["aY"] += extra
    frame["vY"] += slower
    frame["Y"] += integral(t, slower)
    frame["KE_lat"] = 0.5*MASS*frame["vY"]**2


def mirrored(frame: pd.DataFrame) -> pd.DataFrame:
    """The motion to the other side, Y still positive to the left."""
    found = frame.rename(columns=lambda name: re.sub("_([LR])([TF]?)$", lambda m: "_" + "RL"["LR".index(m[1])] + m[2], name))
    return found.assign(**{name: -found[name] for name in ("Y", "vY", "aY", *ROLL, *of(["Fy", "y"]))})


def cut_and_closed_up(frame: pd.DataFrame) -> pd.DataFrame:
    """4 ms of rows at the peak of the left flange are lost, and the gap in the times is closed."""
    t = frame["time"]
    peak = t[frame["N_LF"].idxmax()]
    return frame.assign(time=t.where(t < peak, t - 0.004))[(t - peak).abs() > 0.002]


def first_5_ms_missing(frame: pd.DataFrame) -> pd.DataFrame:
    rest = frame[frame["time"] >= 0.005]
    return rest.assign(time=rest["time"] - rest["time"].iloc[0])


def forces_late(frame: pd.DataFrame) -> None:
    """Forces come 2 ms later than the motion, from a delayed channel."""
    t = frame["time"].to_numpy()
    frame[of(["N", "Fy", "Fz"])] = frame[of(["N", "Fy", "Fz"])].to_numpy()[np.searchsorted(t, t - 2e-3).clip(0, len(t) - 1)]


def wheel_total_in_the_tread(frame: pd.DataFrame) -> None:
    for side in "LR":
        frame[f"Fz_{side}T"] += frame[f"Fz_{side}F"]


def force_kept_after_opening(frame: pd.DataFrame) -> None:
    """Open flanges keep the last force of the contact instead of zero."""
    for c in "LF", "RF":
        closed = frame[f"N_{c}"] > 1.0
        for name in of(["N", "Fy", "Fz"], [c]):
            frame[name] = frame[name].where(closed).ffill().fillna(0.0)


def overflow_stars(frame: pd.DataFrame) -> str:
    """The format is too narrow for the largest forces, which Fortran prints as stars."""
    lines = text_of(frame, sep=" ", named=SHORT, head="two lines").splitlines()
    forces = [k for k, name in enumerate(ALL) if name.startswith(("N_", "Fy_", "Fz_"))]
    for i, line in enumerate(lines[2:], 2):
        numbers = line.split(" ")
        for k in forces:
            numbers[k] = f"{float(numbers[k]):8.0f}".strip() if abs(float(numbers[k])) < 3e5 else "********"
        lines[i] = " ".join(numbers)
    return "\n".join(lines) + "\n"


def shifted(text: str) -> str:
    """The header lacks the name of the vertical velocity, so later names stand one column too early."""
    head, _, body = text.partition("\n")
    return head.replace("vertical velocity [m/s],", "") + ",spare [m]\n" + body


MISTAKES: dict[str, Form] = {
    "radius left and right exchanged": changed(lambda f: f.assign(
        radius_LT=f["radius_RT"], radius_RT=f["radius_LT"], radius_LF=f["radius_RF"], radius_RF=f["radius_LF"])),
    "radius of tread for flange": changed(lambda f: f.update(f[["radius_LF", "radius_RF"]]*0 + HEIGHT)),
    "radius 5 mm too large": changed(lambda f: f.update(f[of(["radius"])] + 0.005)),
    "radius in mm below m": scaled(of(["radius"]), 1e3),
    "radii missing": form(order=[name for name in ALL if not name.startswith("radius")]),
    "angle of left flange negative": scaled(["angle_LF"], -1.0),
    "angles in degrees below rad": scaled(of(["angle"]), DEGREE),
    "angles from the canted rail": changed(lambda f: f.update(f[of(["angle"])] - 1/40)),
    "start to the right": changed(mirrored),
    "damper in the contact force": changed(damper),
    "friction in the forces": changed(friction_in_the_forces),
    "friction in the motion": changed(friction_in_the_motion),
    "4 ms cut out and closed up": changed(cut_and_closed_up),
    "first 5 ms missing": changed(first_5_ms_missing),
    "half of the run missing": changed(lambda f: f[f["time"] <= f["time"].iloc[-1]/2]),
    "forces averaged over 1 ms": averaged(of(["N", "Fy", "Fz"]), 1e-3),
    "accelerations averaged over 5 ms": averaged(["aY", "aZ", "roll_acc"], 5e-3),
    "forces 2 ms late": changed(forces_late),
    "time stretched by 5 percent": scaled(["time"], 1.05),
    "time in ms below s": scaled(["time"], 1e3),
    "time is the row": changed(lambda f: f.assign(time=1e-4*np.arange(len(f)))),
    "rows at 1 kHz": changed(lambda f: at(f, 1e-3)),
    "rows in the wrong order": changed(lambda f: pd.concat([f.iloc[len(f)//2:], f.iloc[:len(f)//2]])),
    "three digits": form(digits="%.3g"),
    "Y shifted by 1 mm": changed(lambda f: f.assign(Y=f["Y"] + 0.001)),
    "lateral velocity at the rails": changed(lambda f: f.assign(vY=f["vY"] + HEIGHT*f["roll_rate"])),
    "roll velocity negative": scaled(["roll_rate"], -1.0),
    "acceleration of an accelerometer": changed(lambda f: f.assign(aZ=f["aZ"] + G)),
    "wheel total in the tread": changed(wheel_total_in_the_tread),
    "lateral and vertical force exchanged": changed(lambda f: f.rename(columns=lambda name: re.sub(
        "^F([yz])_", lambda m: f"F{'zy'['yz'.index(m[1])]}_", name))),
    "forces along the contact plane": changed(lambda f: f.assign(**{
        f"{q}_{c}": f[f"N_{c}"]*share for c in CONTACTS for q, share in (("Fy", 0.0), ("Fz", 1.0))})),
    "force kept after opening": changed(force_kept_after_opening),
    "forces of the wrong wheel": swapped("LF", "RF", ["N", "Fy", "Fz"]),
    "flange and tread exchanged": swapped("LT", "LF"),
    "lateral forces of the left wheel on the rail": scaled(["Fy_LT", "Fy_LF"], -1.0),
    "static load subtracted": changed(lambda f: f.update(f[of(["N", "Fz"], ("LT", "RT"))] - 9e4)),
    "one force in kN below N": scaled(["N_LF"], 1e-3),
    "forces in tonnes below kN": scaled(of(["N", "Fy", "Fz"]), 1/G, units=MM_KN),
    "contact points in the wheelset": changed(lambda f: f.update(f[of(["y"])].sub(f["Y"], axis=0))),
    "heights of tread and flange exchanged": swapped("LT", "LF", ["z"]),
    "kinetic energy without half": scaled(["KE_lat", "KE_vert", "KE_roll"], 2.0),
    "potential energy of the load missing": scaled(["PE_load"], 0.0),
    "columns moved by one": form(shifted),
    "flange positions all zero": scaled(of(PLACE, ("LF", "RF")), 0.0, na="0"),
    "overflow stars": overflow_stars,
    "right flange missing": form(order=[name for name in ALL if not name.endswith("RF")]),
    "one name twice": form(named=PLAIN | {"N_RF": PLAIN["N_LF"]}),
    "decimal commas between commas": form(decimal=","),
}


# ---- faultless, in odd form ----------------------------------------------------------
def open_contacts_all_blank(frame: pd.DataFrame) -> None:
    """Open contacts have empty cells for forces, too."""
    for c in CONTACTS:
        frame[of(["N", "Fy", "Fz"], [c])] = frame[of(["N", "Fy", "Fz"], [c])].where(frame[f"N_{c}"] > 0)


def variable_step(frame: pd.DataFrame) -> pd.DataFrame:
    """All rows while a flange is closed and 2 ms around it, else every second row."""
    closed = (frame["N_LF"] > 0) | (frame["N_RF"] > 0)
    near = mean_over(frame["time"].to_numpy(), closed.to_numpy(float), 4e-3) > 0
    return frame[near | (np.arange(len(frame)) % 2 == 0) | (np.arange(len(frame)) == len(frame) - 1)]


def events_twice(frame: pd.DataFrame) -> pd.DataFrame:
    """Rows at which a contact closes or opens stand in the file twice, with the same time."""
    closed = (frame[of(["N"])] > 0).astype(int)
    return frame.loc[frame.index.repeat(1 + (closed.diff().fillna(0) != 0).any(axis=1))]


def energies(frame: pd.DataFrame) -> list[tuple[str, str, Any]]:
    """Sums of energies in further columns."""
    kinetic, potential = frame[list(ENERGY[:3])].sum(axis=1), frame[list(ENERGY[3:])].sum(axis=1)
    return [("kinetic energy", "J", kinetic), ("potential energy", "J", potential), ("total energy", "J", kinetic + potential)]


def wheel_totals(frame: pd.DataFrame) -> list[tuple[str, str, Any]]:
    """Sums over each wheel, Q and Y and L/V."""
    found: list[tuple[str, str, Any]] = []
    for side, word in zip("LR", LEFT_RIGHT, strict=True):
        vertical, lateral = (frame[f"{q}_{side}T"] + frame[f"{q}_{side}F"] for q in ("Fz", "Fy"))
        found += [(f"{word} wheel Q", "N", vertical), (f"{word} wheel Y", "N", lateral),
                  (f"{word} wheel L/V", "-", (lateral.abs()/vertical.where(vertical > 1.0)).fillna(0.0))]
    return found


def creepages(frame: pd.DataFrame) -> list[tuple[str, str, Any]]:
    """Creepages and creep forces that are zero, the pitch, the forward speed, the moment of the yaw constraint."""
    creep = [(f"{name} {what}", unit, 0.0) for name in ("left tread", "left flange", "right tread", "right flange")
             for what, unit in (("creepage x", "-"), ("creepage y", "-"), ("spin", "1/m"), ("creep force", "N"))]
    return [("pitch angle", "rad", frame["pitch"]), ("forward speed", "m/s", 1.0), ("yaw angle", "rad", 0.0), *creep,
            ("yaw constraint moment", "N.m", frame["M_gyro"])]


def blank_lines(text: str) -> str:
    head, _, body = text.partition("\n")
    return f"\n\n{head}\n\n{body}\n\n"


def row_numbers(text: str) -> str:
    """The first column counts the rows and has an empty name, as pandas writes an index."""
    head, *rows = text.splitlines()
    return "\n".join(["," + head, *(f"{i},{row}" for i, row in enumerate(rows))]) + "\n"


FORTRAN = {"sep": " ", "named": SHORT, "head": "two lines"}
REPORT = ("WHEELSET DYNAMICS PROGRAM, VERSION 4.2\nDate: 2006-06-12\n\nLD benchmark, exercise of the call\n"
          "Mass 1568 kg, roll inertia 656 kg.m2\nLoad 164.618 kN, g = 9.81 m/s2\nStep 1.0E-5 s\nContacts: Hertz\n"
          "Output every 0.1 ms\n\n")
TRADE = ("time/wheelset.lat_disp/wheelset.vert_disp/wheelset.roll/wheelset.lat_vel/wheelset.vert_vel/wheelset.roll_vel/"
         "wheelset.lat_acc/wheelset.vert_acc/wheelset.roll_acc")

FAULTLESS: dict[str, Form] = {
    "mm and kN": form(units=MM_KN),
    "degrees, roll in mrad": form(units={"angle": ("deg", DEGREE), "spin": ("deg/s", DEGREE), "spinacc": ("deg/s2", DEGREE),
                                         "roll": ("mrad", 1e3)}),
    "accelerations in g": form(units={"acc": ("g", 1/9.80665)}),
    "powers in four ways": form(units={"speed": ("m.s-1", 1), "acc": ("m/s**2", 1), "spin": ("rad.s-1", 1),
                                       "spinacc": ("rad/s/s", 1)}),
    "units with superscripts": form(units={"acc": ("m/s²", 1), "spinacc": ("rad/s²", 1),
                                           **dict.fromkeys(of(["angle"]), ("°", DEGREE))}),
    "imperial": form(units={"length": ("in", 1/0.0254), "speed": ("in/s", 1/0.0254), "acc": ("g", 1/9.80665),
                            "force": ("lbf", 1/4.4482216152605)}),
    "ms, MN and kJ": form(units={"time": ("ms", 1e3), "force": ("MN", 1e-6), "energy": ("kJ", 1e-3)}),
    "no units": form(head="names"),
    "radius in m, positions in mm": form(units=MM_KN | dict.fromkeys(of(["radius"]), ("m", 1))),
    "Y to the right": form(signs=RIGHT),
    "Z down": form(signs=DOWN),
    "roll the other way": form(signs=ROLL),
    "everything reversed": form(signs=(*ON_RAIL, *ROLL)),
    "forces of the wheel on the rail": form(signs=of(["Fy", "Fz"])),
    "angles signed in the track's frame": form(signs=of(["angle"], ("RT", "RF"))),
    "Z from the rails": lambda f: text_of(f, named=PLAIN | {"Z": "axle height above rail"}, offset={"Z": axle_height(f)}),
    "Z from the unloaded position": lambda f: text_of(f, offset={"Z": axle_height(f) - HEIGHT}),
    "contact heights from the axle": lambda f: text_of(f, offset=dict.fromkeys(of(["z"]), -axle_height(f))),
    "contact points from the gauge side": form(offset={f"y_{c}": (-1 if c[0] == "L" else 1)*1.4351/2 for c in CONTACTS}),
    "energies from the rails": lambda f: text_of(f, offset={"PE_grav": MASS*G*axle_height(f), "PE_load": LOAD*axle_height(f)}),
    "time from -100 ms": form(offset={"time": -0.1}),
    "time from 10 s": form(offset={"time": 10.0}),
    "names of ours": form(named={}, head="names", sep=" "),
    "names of the trade": form(named=names(TRADE + ENERGIES, "gamma/N/Y/Q/y_cp/z_cp/r", "{side}.{part}.{quantity}", ("wl", "wr")),
                               units=MM_KN),
    "symbols": form(named=names(ENGLISH + ENERGIES, "delta/N/Fy/Fz/yc/zc/rc", "{quantity}_{side}{part}", "lr", "tf") | dict(zip(
        ("time", *MOTION), "t Y Z Phi dY/dt dZ/dt dPhi/dt d2Y/dt2 d2Z/dt2 d2Phi/dt2".split(), strict=True)), units=MM_KN),
    "dotted symbols": form(named=PLAIN | dict(zip(MOTION, "y z phi yp zp phip ypp zpp phipp".split(), strict=True))),
    "numbers for sides": form(named=names(ENGLISH + ENERGIES, POINTS, "{quantity} wheel {side} contact {part}", "12", "12"),
                              before="# wheel 1 left - wheel 2 right - contact 1 tread - contact 2 flange\n"),
    "capitals": form(named=names(
        "TIME/YDISP/ZDISP/ROLL/YVEL/ZVEL/ROLLVEL/YACC/ZACC/ROLLACC/EKY/EKZ/EKROLL/EPGRAV/EPLOAD/EELASTL/EELASTR",
        "ANG/FN/FY/FZ/YC/ZC/RR", "{quantity}_{part}_{side}", ("LEFT", "RIGHT"), ("TREAD", "FLANGE")), head="two lines", sep=" "),
    "French, decimal commas": form(named=FRENCH, units=MM_KN, sep=";", decimal=","),
    "German, decimal commas": form(named=GERMAN, units=MM_KN | {"angle": ("mrad", 1e3)}, sep=";", decimal=","),
    "fixed width": form(padded, sep=" ", named=SHORT, head="two lines in brackets"),
    "several blanks": form(lambda text: re.sub("^", "   ", text.replace(" ", "    ").rstrip("\n"), flags=re.MULTILINE) + "\n",
                           sep=" ", named=SHORT, head="glued"),
    "comma and blank": form(lambda text: text.replace(",", ", ")),
    "trailing separator": form(lambda text: text.replace("\n", ",\n")),
    "quoted names with commas": form(named=names(ENGLISH + ENERGIES, POINTS, "{quantity}, {side} {part}"), head="quoted"),
    "units in parentheses": form(head="parens", units=MM_KN),
    "comments above and below": form(lambda text: text + "# end of run\n# 3 impacts\n", before="% LD benchmark\n%\n"),
    "comments with slashes": form(before="// LD benchmark, single wheelset without friction\n// solver: Newmark, 20 us\n"),
    "names in a comment": form(before="# "),
    "keys and values above": form(before="mass = 1568\nroll_inertia = 656\nauthor = A. Author\nsimulation = LD\n"),
    "ten lines of report above": form(before=REPORT),
    "blank lines": form(blank_lines),
    "open contacts -999 in mm": form(na="-999", units=MM_KN | {"angle": ("deg", DEGREE)}),
    "open contacts zero": form(hollow=0.0),
    "open contacts blank": form(na=""),
    "open contacts n/a": form(na="n/a"),
    "open contacts huge": form(hollow=1e30),
    "open contacts all blank": changed(open_contacts_all_blank, na=""),
    "open contacts keep the last place": changed(lambda f: f.assign(**{name: f[name].ffill().fillna(0.0) for name in of(PLACE)})),
    "seven digits with signs": form(digits="%+.6e"),
    "exponents without E": lambda f: re.sub(r"E([+-]\d{3})", r"\1", text_of(f.mask(f == 0.0, 1e-120), digits="%.7E", **FORTRAN)),
    "exponents with D": form(lambda text: re.sub(r"(\d)E([+-]\d)", r"\1D\2", text), digits="%.10E", **FORTRAN),
    "no zero before the point": form(lambda text: re.sub(r"(^|,)(-?)0\.(?=\d)", r"\1\2.", text, flags=re.MULTILINE),
                                     digits="%.10f"),
    "rows at 10 kHz": changed(lambda f: at(f, 1e-4)),
    "variable step": changed(variable_step),
    "events twice": changed(events_twice),
    "equal times after rounding": changed(lambda f: f.assign(time=f["time"].round(6))),
    "start three times": changed(lambda f: pd.concat([f.iloc[[0, 0]], f])),
    "columns by contact": form(order=["time", *of(POINT, ("RF", "RT", "LF", "LT")), *MOTION, *ENERGY]),
    "columns in any order": form(order=[str(name) for name in np.random.default_rng(7).permutation(ALL)]),
    "sums of energies alone": lambda f: text_of(f, order=CALL, extra=energies(f)),
    "further columns": lambda f: text_of(f, extra=[*creepages(f), *wheel_totals(f), *energies(f)]),
    "row numbers": form(row_numbers),
    "line ends of old Macintoshes": form(eol="\r"),
    "no line end at the end": form(lambda text: text.rstrip("\n")),
    "byte order mark": form(lambda text: "\ufeff" + text, eol="\r\n"),
    "Latin-1": form(lambda text: text.encode("latin-1"), named=FRENCH, sep=";", decimal=","),
    "UTF-16": form(lambda text: text.encode("utf-16"), named=GERMAN, sep="\t", eol="\r\n"),
}


# ---- whole naming styles -------------------------------------------------------------
LR, TF = ("LEFT", "RIGHT"), ("TREAD", "FLANGE")
STYLES: dict[str, Form] = {
    "SIMPACK": form(sep="\t", named=names(
        "time/$B_WS.pos.y/$B_WS.pos.z/$B_WS.ang.al/$B_WS.vel.y/$B_WS.vel.z/$B_WS.omega.al/$B_WS.acc.y/$B_WS.acc.z/"
        "$B_WS.omega_dot.al/$E.kin.y/$E.kin.z/$E.kin.al/$E.pot.grav/$E.pot.load/$E.pot.RWP_L/$E.pot.RWP_R",
        "Contact_angle/Normal_force/Lateral_force_track/Vertical_force_track/Contact_pos_y_track/Contact_pos_z_track/"
        "Rolling_radius", "$RWP_{side}.Patch_{part}.{quantity}", ("Left", "Right"), ("Tread", "Flange"))),
    # Inches, pounds and g in fixed width.
    "NUCARS": form(padded, sep=" ", head="two lines", hollow=0.0, units={
        "length": ("in", 1/0.0254), "speed": ("in/s", 1/0.0254), "acc": ("g", 1/9.80665), "force": ("lbf", 1/4.4482216152605)},
        named=names("TIME/AXLE1_Y_DISP/AXLE1_Z_DISP/AXLE1_ROLL/AXLE1_Y_VEL/AXLE1_Z_VEL/AXLE1_ROLL_VEL/AXLE1_Y_ACC/AXLE1_Z_ACC/"
                    "AXLE1_ROLL_ACC/KE_LATERAL/KE_VERTICAL/KE_ROLL/PE_GRAVITY/PE_LOAD/PE_CONTACT_LEFT/PE_CONTACT_RIGHT",
                    "CONT_ANGLE/NORMAL/LATERAL/VERTICAL/CONT_Y/CONT_Z/ROLL_RADIUS", "AXLE1_{side}_{part}_{quantity}", LR, TF)),
    "VAMPIRE": form(units=MM_KN | MRAD, signs=ON_RAIL, head="parens", named=names(
        "Time/" + "/".join(f"Wheelset 1 {axis} {what}" for what in ("Displacement", "Velocity", "Acceleration")
                           for axis in ("Lateral", "Vertical", "Roll")) + ENERGIES,
        "Contact Angle/Normal Force/Lateral Force (track)/Vertical Force (track)/Contact Lateral Position/"
        "Contact Vertical Position/Rolling Radius", "Wheelset 1 {side} {part} {quantity}", ("LH", "RH"), ("Tread", "Flange"))),
    "GENSYS": form(signs=ON_RAIL, sep=" ", head="two lines", hollow=0.0,
                   before="# cp_111lt left tread, cp_111lf left flange, cp_111rt right tread, cp_111rf right flange\n",
                   named=names("time/" + "/".join(f"axl_111.{rate}{axis}" for rate in ("", "v", "a") for axis in "yzf")
                               + "/axl_111.Eky/axl_111.Ekz/axl_111.Ekf/axl_111.Epg/axl_111.Epload/cp_111l.Eel/cp_111r.Eel",
                               "cang/Fn/Fy/Fz/ycp/zcp/rr", "cp_111{side}{part}.{quantity}", "lr", "tf")),
    "a German code": form(units=MM_KN | MRAD, sep=";", decimal=",", na="-999", named=names(
        "Zeit/y_Radsatz/z_Radsatz/Wankwinkel/vy_Radsatz/vz_Radsatz/Wankgeschw/ay_Radsatz/az_Radsatz/Wankbeschl/Ekin_quer/"
        "Ekin_vertikal/Ekin_Wanken/Epot_Gewicht/Epot_Last/Eelast_links/Eelast_rechts",
        "Kontaktwinkel/Normalkraft/Y_Kraft/Q_Kraft/y_Kontakt/z_Kontakt/Rollradius", "{quantity}_{part}_{side}", ("li", "re"),
        ("Laufflaeche", "Spurkranz"))),
    "a Matlab script": form(sep=" ", before="% ", head="names", digits="%.10e", named=names(
        "t/y/z/phi/ydot/zdot/phidot/yddot/zddot/phiddot/Tlat/Tvert/Troll/Vgrav/Vload/VelL/VelR", "gamma/Fn/Fy/Fz/yc/zc/r",
        "{quantity}{side}{part}", "LR", "TF")),
    "a finite element program": form(sep=" ", head="names", digits="%14.6E", hollow=1e30,
                                     before="** units: N, m, s, rad; 2 lateral (left), 3 vertical (up)\n", named=names(
        "TIME/U2_N_AXLE/U3_N_AXLE/UR1_N_AXLE/V2_N_AXLE/V3_N_AXLE/VR1_N_AXLE/A2_N_AXLE/A3_N_AXLE/AR1_N_AXLE/ALLKE_2/ALLKE_3/"
        "ALLKE_R1/ALLPE_GRAV/ALLPE_LOAD/ALLSE_LEFT/ALLSE_RIGHT", "CANGLE/CFN/CF2/CF3/CCOOR2/CCOOR3/CRADIUS",
        "{quantity}_{side}_{part}", LR, TF)),
    # Quoted names below a title and an empty line of a sheet.
    "a spreadsheet": form(lambda text: "\ufeff" + text, units=MM_KN | {"angle": ("deg", DEGREE), "time": ("ms", 1e3)}, sep=";",
                          decimal=",", head="quoted", na="", eol="\r\n", before="LD benchmark;;;\n;;;\n",
                          named=names(ENGLISH + ENERGIES, POINTS, "{quantity} ({side} {part})")),
}
