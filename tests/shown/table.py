"""The table of shown numbers: for every place where a user reads numbers, what each is, its unit, side and moment, and how it
follows from the rows of the specimen."""
from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest

from raw import Raw, flange_slope
from reading import Line

MM, KN, DEG = 1e3, 1e-3, 180/np.pi
WORDS = {"LT": "left tread", "LF": "left flange", "RT": "right tread", "RF": "right flange"}
CONTACTS = {words: contact for contact, words in WORDS.items()}

# Words of pages and comparisons, and the columns, units and factors that they stand for.
COLUMNS = {
    "distance X": ("X", "m", 1), "lateral displacement Y": ("Y", "mm", MM), "vertical displacement Z": ("Z", "mm", MM),
    "roll Φ": ("roll", "mrad", 1e3), "pitch Ω": ("pitch", "rad", 1), "forward velocity": ("vX", "m/s", 1),
    "lateral velocity": ("vY", "m/s", 1), "vertical velocity": ("vZ", "m/s", 1), "roll velocity": ("roll_rate", "mrad/s", 1e3),
    "pitch velocity": ("pitch_rate", "rad/s", 1), "lateral acceleration": ("aY", "m/s²", 1),
    "vertical acceleration": ("aZ", "m/s²", 1), "roll acceleration": ("roll_acc", "rad/s²", 1),
    "external lateral force": ("F_ext", "kN", KN), "gyroscopic moment": ("M_gyro", "N·m", 1),
    "kinetic energy, forward": ("KE_long", "J", 1), "kinetic energy, lateral": ("KE_lat", "J", 1),
    "kinetic energy, vertical": ("KE_vert", "J", 1), "kinetic energy, roll": ("KE_roll", "J", 1),
    "kinetic energy, pitch": ("KE_pitch", "J", 1), "potential energy, gravity": ("PE_grav", "J", 1),
    "potential energy, vertical load": ("PE_load", "J", 1), "elastic energy, left wheel": ("PE_elastic_L", "J", 1),
    "elastic energy, right wheel": ("PE_elastic_R", "J", 1), "work of the lateral force": ("W_ext", "J", 1),
    "total energy": ("E_total", "J", 1), "energy drift": ("E_drift", "J", 1),
    **{f"{what}, {where}": (f"{column}_{contact}", unit, scale) for where, contact in CONTACTS.items()
       for what, column, unit, scale in (
           ("normal force", "N", "kN", KN), ("vertical force", "Fz", "kN", KN), ("lateral force", "Fy", "kN", KN),
           ("contact angle", "angle", "°", DEG), ("lateral position", "y", "mm", MM), ("vertical position", "z", "mm", MM),
           ("rolling radius", "radius", "mm", MM))}}

# The rows of the sheets: label of the axis, then label of each curve and what it shows.
def of_column(words: str, column: str) -> dict[str, dict[str, str]]:
    unit = COLUMNS[words][1]
    return {f"{words} [{unit}]": {words: f"{column} [{unit}]"}}


def of_places(words: str, unit: str, column: str) -> dict[str, dict[str, str]]:
    """A row for treads and one for flanges, y outwards."""
    return {f"{words}, {part}s [{unit}]": {WORDS[c]: f"{'-' if column + c[0] == 'yR' else ''}{column}_{c} [{unit}]"
                                           for c in (f"L{part[0].upper()}", f"R{part[0].upper()}")} for part in ("tread", "flange")}


def of_wheels(words: str, unit: str, column: str) -> dict[str, dict[str, str]]:
    return {f"{words}, {side} wheel [{unit}]": {WORDS[c]: f"{column}_{c} [{unit}]" for c in WORDS if c[0] == side[0].upper()}
            for side in ("left", "right")}


KINETIC = {"lateral": "KE_lat [J]", "vertical": "KE_vert [J]", "roll": "KE_roll [J]"}
ELASTIC = {"elastic left": "PE_elastic_L [J]", "elastic right": "PE_elastic_R [J]"}
SHEETS = {
    "motions and velocities": {
        **of_column("lateral displacement Y", "Y"), **of_column("vertical displacement Z", "Z"), **of_column("roll Φ", "roll"),
        **of_column("lateral velocity", "vY"), **of_column("vertical velocity", "vZ"), **of_column("roll velocity", "roll_rate")},
    "accelerations and contact angles": {
        **of_column("lateral acceleration", "aY"), **of_column("vertical acceleration", "aZ"),
        **of_column("roll acceleration", "roll_acc"), **of_places("contact angle", "°", "angle")},
    "contact forces": {**of_wheels("normal force", "kN", "N"), **of_wheels("vertical force", "kN", "Fz"),
                       **of_wheels("lateral force", "kN", "Fy")},
    "positions, rolling radii, energies": {
        **of_places("outward position", "mm", "y"), **of_places("vertical position", "mm", "z"),
        **of_places("rolling radius", "mm", "radius"), "kinetic, elastic energy [J]": KINETIC | ELASTIC,
        "potential energy [J]": {"gravity": "PE_grav [J]", "vertical load": "PE_load [J]",
                                 "work of the lateral force": "W_ext [J]"},
        "balance: energy drift [J]": {"balance: energy drift": "E_drift [J]"}}}
# The panels of the other pages over time and over the lateral force, and of the pages of several runs.
SIDES = {f"{side} wheel": side for side in ("left", "right")}
PANELS = {
    "N [kN]": {words: f"N_{c} [kN]" for c, words in WORDS.items()},
    "contact angle [°]": {WORDS[c]: f"angle_{c} [°]" for c in ("LF", "RF")},
    "velocity [m/s]": {"lateral": "vY [m/s]", "vertical": "vZ [m/s]"},
    "acceleration [m/s²]": {"lateral": "aY [m/s²]", "vertical": "aZ [m/s²]"},
    "energy [J]": KINETIC | {"elastic": "PE_elastic_L+PE_elastic_R [J]"},
    "L/V": {words: f"L/V {side}" for words, side in SIDES.items()},
    "vertical load [kN]": {words: f"Fz_{side[0].upper()}T+Fz_{side[0].upper()}F [kN]" for words, side in SIDES.items()},
    "normal N [kN]": {WORDS[c]: f"N_{c} [kN]" for c in ("LT", "LF", "RT")},
    "lateral Y [mm]": {"": "Y [mm]"}, "roll Φ [mrad]": {"": "roll [mrad]"},
    "pressure [GPa]": {"": "pressure LF [GPa]"}, "patch area [mm²]": {"": "area LF [mm²]"},
    "lateral velocity [m/s]": {"": "vY [m/s]"}, "vertical velocity [m/s]": {"": "vZ [m/s]"},
    "roll velocity [mrad/s]": {"": "roll_rate [mrad/s]"},
    "amplitude of Z [mm]": {"": "amplitude of Z [mm]"}, "amplitude of Φ [mrad]": {"": "amplitude of roll [mrad]"}}
# Left is blue, right is red; flanges are lighter.
COLOURS = {"LT": "#0072B2", "LF": "#56B4E9", "RT": "#D55E00", "RF": "#E69F00", "left": "#0072B2", "right": "#D55E00"}
# The labels of horizontal axes, and what they show.
ACROSS = {"time [s]": "time [s]", "frequency [Hz]": "frequency [Hz]", "lateral force [kN]": "F_ext [kN]",
          "lateral displacement Y [mm]": "Y [mm]", "vertical displacement Z [mm]": "Z [mm]", "roll Φ [mrad]": "roll [mrad]"}
PORTRAITS = {"lateral velocity [m/s]": "lateral displacement Y [mm]", "vertical velocity [m/s]": "vertical displacement Z [mm]",
             "roll velocity [mrad/s]": "roll Φ [mrad]"}


WAYS = ("Y", 1), ("Y", -1), ("Z", 1), ("Z", -1), ("roll", 1), ("roll", -1)      # of extremes


class Result(NamedTuple):
    """A result of a run: what it is in SI, and the words and the unit's factor under which documents, page and abstract have it."""

    truth: Callable[[Raw], float | None]
    words: str                  # of the summary page of the PDF, of the page's table; with the unit
    scale: float
    short: str = ""             # of the abstract
    slack: float = 0.0          # as a share: rows may miss what happens between them

    @property
    def brief(self) -> str:
        """The words of the table of results in the PDF; '' of what it leaves out."""
        key = next(key for key, one in RESULTS.items() if one is self)
        return BRIEF.get(key, self.words)


def passage(k: int) -> Callable[[Raw], float | None]:
    return lambda raw: raw.passages()[k] if len(raw.passages()) else None


def end_of_ramp(raw: Raw) -> bool:
    return bool(raw.c["F_ext"][-1] > 0)


def last_load(raw: Raw) -> float | None:
    """Lateral force when the right wheel carries for the last time [N]; None of a run without a ramp."""
    carries = np.flatnonzero(raw.c["N_RT"] + raw.c["N_RF"] > 0)
    return float(raw.c["F_ext"][carries[-1]]) if end_of_ramp(raw) else None


def overlap_of(contact: str) -> Callable[[Raw], float | None]:
    return lambda raw: None if raw.first_peak(contact) is None else raw.overlap(contact, raw.first_peak(contact))


RESULTS: dict[str, Result] = {
    "t_first_LF": Result(lambda r: r.start("LF"), "first contact of the left flange [s]", 1, "first left flange contact [s]"),
    "t_first_RF": Result(lambda r: r.start("RF"), "first contact of the right flange [s]", 1, "first right flange contact [s]"),
    "t_first_centre": Result(passage(0), "first passage of the centre after a flange contact [s]", 1),
    "t_return": Result(passage(-1), "return to the centre after turning back on both sides [s]", 1, "return to the centre [s]"),
    "F_limit_left": Result(lambda r: r.setting("F_limit_left"), "static limit of the lateral force, left [kN]", KN),   # quasistatic
    "F_unloaded": Result(last_load, "lateral force at which a wheel lifts for good [kN]", KN, "", 2e-3),
    "t_derailment": Result(lambda r: r.t[-1] if end_of_ramp(r) else None, "derailment [s]", 1, "derailment [s]", 5e-4),
    "F_derailment": Result(lambda r: r.c["F_ext"][-1] if end_of_ramp(r) else None, "lateral force at derailment [kN]", KN,
                           "lateral force at derailment [kN]", 5e-4),
    "farthest_left": Result(lambda r: r.extreme("Y", 1), "Y, largest [mm]", MM, "largest Y [mm]", 1e-4),
    "farthest_right": Result(lambda r: r.extreme("Y", -1), "Y, smallest [mm]", MM, "", 1e-4),
    "farthest_up": Result(lambda r: r.extreme("Z", 1), "Z, largest [mm]", MM, "largest Z [mm]", 1e-4),
    "farthest_down": Result(lambda r: r.extreme("Z", -1), "Z, smallest [mm]", MM, "", 1e-4),
    "largest_roll": Result(lambda r: r.extreme("roll", 1), "Φ, largest [mrad]", 1e3, "", 1e-4),
    "smallest_roll": Result(lambda r: r.extreme("roll", -1), "Φ, smallest [mrad]", 1e3, "", 1e-4),
    **{f"peak_N_{c}": Result(lambda r, c=c: r.peak(c)[0] or None, f"peak N, {words} [kN]", KN,
                             f"peak N, {words} [kN]" if c[1] == "F" else "")
       for c, words in WORDS.items()},
    **{f"first_peak_N_{c}": Result(lambda r, c=c: r.impact(c).get("peak"), f"peak N, first contact, {WORDS[c]} [kN]", KN)
       for c in ("LF", "RF")},
    **{f"first_duration_{c}": Result(lambda r, c=c: r.impact(c).get("duration"), f"duration, first contact, {WORDS[c]} [ms]", 1e3,
                                     "", 1e-4) for c in ("LF", "RF")},
    **{f"first_impulse_{c}": Result(lambda r, c=c: r.impact(c).get("impulse"), f"impulse, first contact, {WORDS[c]} [N·s]", 1,
                                    "", 3e-3) for c in ("LF", "RF")},
    **{f"approach_{c}": Result(overlap_of(c), f"approach, first contact, {WORDS[c]} [mm]", MM, "", 4e-3) for c in ("LF", "RF")},
    # Tests of the physics and section `pressure` of the validation solve the pressures of other rows.
    "pmax": Result(lambda r: r.result("pmax"), "largest pressure of the run [MPa]", 1e-6, "largest pressure [MPa]"),
    "n_left_flange_contact": Result(lambda r: len(r.episodes("LF")), "contacts of the left flange", 1, "", 0.15),
    "n_right_flange_contact": Result(lambda r: len(r.episodes("RF")), "contacts of the right flange", 1),
    "n_left_wheel_lift_off": Result(lambda r: r.lift_offs("L"), "lift-offs of the left wheel", 1, "lift-offs, left wheel", 0.06),
    "n_right_wheel_lift_off": Result(lambda r: r.lift_offs("R"), "lift-offs of the right wheel", 1, "lift-offs, right wheel"),
    "drift": Result(lambda r: r.drift()[0], "largest energy drift [J]", 1, "", 0.05),
    "drift_relative": Result(lambda r: r.drift()[1], "the drift over initial kinetic energy or work", 1, "energy drift, relative",
                             0.05),
    "step": Result(lambda r: r.setting("dt"), "time step [µs]", 1e6),
    "t": Result(lambda r: r.t[-1], "end of the run [s]", 1)}
# The words of the table of results in the PDF, where they are shorter; "" of what it leaves out.
BRIEF = {
    "t_first_LF": "first left flange contact [s]", "t_first_RF": "first right flange contact [s]",
    "t_first_centre": "first passage of the centre [s]", "t_return": "return to the centre [s]",
    "F_limit_left": "static limit of the lateral force [kN]", "F_unloaded": "lateral force, lift for good [kN]",
    "farthest_left": "largest Y [mm]", "farthest_right": "smallest Y [mm]", "farthest_up": "largest Z [mm]",
    "farthest_down": "smallest Z [mm]", "largest_roll": "largest Φ [mrad]", "smallest_roll": "smallest Φ [mrad]",
    **{f"approach_{c}": f"approach, {WORDS[c]} [mm]" for c in ("LF", "RF")}, "pmax": "largest pressure [MPa]",
    **{f"n_{side}_wheel_lift_off": f"lift-offs, {side} wheel" for side in ("left", "right")},
    "drift_relative": "energy drift, relative", "step": "", "t": ""}
# The pressure and the area of a patch must go with the force of the contact: N = 0.64 of pressure times area.
PRESSED = {c: (f"peak pressure, first contact, {WORDS[c]} [MPa]", f"patch area, first contact, {WORDS[c]} [mm²]")
           for c in ("LF", "RF")}
FULLNESS = 0.64, 0.03


def fits_contact(raw: Raw, contact: str, k: int, pressure: float, area: float, slack: float = 1.0) -> None:
    """Largest pressure and area of a patch go with the force and the overlap of its contact, as in Hertz's theory: the force is
    nearly 2/3 of pressure times area, and a circle of that area has 2 E* / pi times the overlap for radius times pressure."""
    stiffness = raw.setting("youngs_modulus")/(1 - raw.setting("poisson")**2)/np.pi
    assert raw.c[f"N_{contact}"][k]/(pressure*area) == pytest.approx(FULLNESS[0], abs=slack*FULLNESS[1]), contact
    assert np.sqrt(area/np.pi)*pressure/raw.overlap(contact, k)/stiffness == pytest.approx(1.27, abs=slack*0.1), contact


def text_of_summary(raw: Raw) -> tuple[list[Line], list[str]]:
    """The summary that a run prints: lines, and labels. What rows do not tell, the column file says beside them."""
    rough = (lambda share: share) if end_of_ramp(raw) else (lambda share: 0.0)     # rows of a millisecond miss short contacts

    def row(match: Any) -> int:
        return int(np.abs(raw.t - float(match[1])).argmin())

    def angle(_: Any, match: Any) -> tuple[float, float]:
        """The angle of the flange that closes, in the first row in which it has one."""
        k, found = row(match), raw.c[f"angle_{'L' if 'left' in match[0] else 'R'}F"]
        return raw.t[k], DEG*abs(found[k + int(np.argmax(~np.isnan(found[k:])))])

    lines = [
        Line(r"vertical displacement (\S+) m\b", "initial Z [m]", lambda w: raw.c["Z"][0]),
        Line(r"force growing by (\S+) kN/s", "ramp [kN/s]", lambda w: KN*raw.setting("lateral_ramp")) if end_of_ramp(raw) else
        Line(r"lateral velocity (\S+) m/s", "initial vY [m/s]", lambda w: raw.c["vY"][0]),
        Line(r"clearance \[mm\]: left (\S+), right (\S+)$", "rigid-axle clearances [mm], of the call",
             lambda w: (10.18, 16.94), 1e-3),
        Line(r"axle (\S+) m above", "height of the axle at rest [m]", lambda w: raw.setting("axle_height")),
        Line(r"(\S+) mm lower than with rigid contacts,\s", "sinking of the axle at rest [mm]",
             lambda w: MM*np.mean([raw.overlap(c, 0, at_rest=True) for c in ("LT", "RT")]), 5e-3),
        Line(r"(\S+) kN\s+per wheel", "load of a wheel [kN]", lambda w: KN*raw.weight/2),
        Line(r"Y = (\S+) m, Z = (\S+) m, roll =\s+(\S+) rad", "pose at rest [m, m, rad]",
             lambda w: [raw.setting(f"rest_{name}") for name in ("Y", "Z", "roll")]),
        Line(r"\[Hz\]: lateral (\S+), vertical (\S+), roll (\S+)$", "eigenfrequencies [Hz]",
             lambda w: raw.settings("eigenfrequencies")),
        Line(r"^  t = (\S+) s  ", "times of events [s]: a row stands there", lambda w, m: raw.t[row(m)], often=True),
        Line(r"^  t = (\S+) s  (?:left|right) flange contact at (\S+) degrees", "events: a flange closes [s], at an angle [deg]",
             angle, 0.03, often=True),
        *(Line(rf"^number of events:\n(?:  .*\n)*?  {words} (\d+)$", f"{words}: how often", lambda w, n=n: n, rough(slack))
          for words, n, slack in (*(one for side in ("left", "right") for one in (
              (f"{side} wheel lift-off", raw.lift_offs(side[0].upper()), 0.06),
              (f"{side} wheel landing", raw.lift_offs(side[0].upper(), landings=True), 0.06),
              (f"{side} flange contact", len(raw.episodes(f"{side[0].upper()}F")), 0.15))),
              ("centre passage", len(raw.passages()), 0.0), ("left flange over rail", int(end_of_ramp(raw)), 0.0),
              ("derailment", int(end_of_ramp(raw)), 0.0)) if n),
        Line(r"^largest lateral force with an equilibrium \[kN\]: left (\S+), right (\S+)$", "static limits [kN]",
             lambda w: [KN*raw.setting(f"F_limit_{way}") for way in ("left", "right")]),
        Line(r"^farthest \[mm\]: left (\S+) at \S+ s, right (\S+) at \S+ s, up (\S+) at \S+ s, down\s+(\S+) at",
             "farthest ways [mm]", lambda w: [MM*raw.extreme(column, sign) for column, sign in WAYS[:4]], 1e-3),
        Line(r"left \S+ at (\S+) s, right \S+ at (\S+) s, up \S+ at (\S+) s, down\s+\S+ at (\S+) s", "when [s], between rows",
             lambda w: [raw.t[int((sign*raw.c[column]).argmax())] for column, sign in WAYS[:4]], 0.02),
        Line(r"^roll \[mrad\]: largest (\S+) at (\S+) s, smallest (\S+) at (\S+) s$", "roll [mrad, s]",
             lambda w: [x for column, sign in WAYS[4:] for x in (
                 1e3*raw.extreme(column, sign), raw.t[int((sign*raw.c[column]).argmax())])], 0.02),
        Line(r"^largest pressure \[GPa\]: (\S+), .F at (\S+) s, y = (\S+) m, z = (\S+) m$", "largest pressure [GPa, s, m, m]",
             lambda w: (1e-9*raw.result("pmax"), *(raw.result(name) for name in ("t_pmax", "pmax_y", "pmax_z")))),
        Line(r"energy drift \[J\]: (\S+?)(?:,|$)", "largest energy drift [J]", lambda w: raw.drift()[0], 0.06),
        Line(r"^steps: (\d+) of at most (\S+) s, of which (\d+) were cut; contact evaluations: (\d+)$",
             "steps, the longest [s], cut ones, evaluations",
             lambda w: (raw.result("steps"), raw.setting("dt"), raw.result("cuts"), raw.result("evaluations"))),
        Line(r"^ended at t = (\S+) s", "end [s]", lambda w: raw.t[-1]),
        Line(r"\.txt, (\d+) rows", "rows", lambda w: len(raw.t))]
    lines += [Line(rf"^  {contact} (\S+) at (\S+) s", f"peak force [kN] of the {words} and its time [s]",
                   lambda w, c=contact: (KN*raw.peak(c)[0], raw.peak(c)[1]))
              for contact, words in WORDS.items() if raw.peak(contact)[0]]
    for contact, words in WORDS.items():
        if one := raw.impact(contact):
            lines.append(Line(
                rf"^  {contact} from (\S+) s, peak (\S+) kN at (\S+) s, lasts (\S+) ms, impulse\s+(\S+) N s$",
                f"first contact [s, kN, s, ms, N s], {words}", lambda w, one=one, c=contact: (
                    one["start"], KN*one["peak"], raw.t[raw.first_peak(c)], 1e3*one["duration"], one["impulse"]), 3e-3))
    lines += [Line(r"^(?:left |right )?contact table: model .* points$", "points of a table", lambda w, m: [], often=True),
              Line(r"^contact table: \d+ solutions, \d+ found$", "solutions: more where fewer were found", lambda w: [])]
    errors = raw.errors()
    stated = r"error of the contact force in poses of the run, rms \(largest\), relative to max\(\|F\|, 5 kN\):\n  "
    lines += [Line(stated + "  ".join([r"[a-z ]+ (\S+) \((\S+)\)\n"]*len(errors)), "errors of the contact force",
                   lambda w: [x for both in errors.values() for x in both])]
    if end_of_ramp(raw):
        lines += [Line(r"^a wheel lifts for good: (\S+) s, lateral force (\S+) kN$", "lift for good [s, kN]",
                       lambda w: (raw.result("t_unloaded"), KN*last_load(raw)), 2e-3),
                  Line(r"^derailment: (\S+) s, lateral force (\S+) kN$", "derailment [s, kN]",
                       lambda w: (raw.t[-1], KN*raw.c["F_ext"][-1]), 5e-4),
                  Line(r"largest work of the lateral force: (\S+)$", "drift over the work", lambda w: raw.drift()[1], 0.06)]
        lines.append(Line(r"^  t = (\S+) s .*, lateral force (\S+) kN", "events: lateral force [kN]",
                          lambda w, m: (raw.t[row(m)], KN*raw.c["F_ext"][row(m)]), often=True))
    else:
        lines.append(Line(r"^back at the centre after turning back on both sides: (\S+) s$", "return [s]",
                          lambda w: raw.passages()[-1]))
        lines.append(Line(r"initial kinetic energy: (\S+)", "drift over kinetic energy", lambda w: raw.drift()[1], 0.06))
    return lines, [CRC, r"first 5 events", r"^processor time .*$"]


CRC = r"CRC-32 [0-9A-F]{8}"     # test_profiles


# Other tables of results -------------------------------------------------------------------

def first_touch(raw: Raw, contact: str) -> float:
    """When a flange is first touched, by a force or an impact: where the row before is."""
    blows = raw.c.get(f"P_{contact}", np.zeros(len(raw.t)))
    touched = (raw.c[f"N_{contact}"] > 1.0) | (blows > 0)
    k = int(touched.argmax())
    return raw.t[k if blows[k] > 0 else k - 1] if touched.any() else np.inf


def in_results(raw: Raw) -> dict[str, tuple[float, float, float] | None]:
    """The entries of &results, each with a share and an absolute error; None for what rows do not tell."""
    ramp = end_of_ramp(raw)
    found: dict[str, tuple[float, float, float] | None] = {
        "t": (raw.t[-1], 1e-9, 0), "rows": (len(raw.t), 0, 0), "step": (raw.setting("dt"), 1e-12, 0),
        "drift": (raw.drift()[0], 0.06, 0),
        "kinetic_energy": (sum(raw.c[f"KE_{part}"][0] for part in ("lat", "vert", "roll")), 1e-8, 1e-9),
        "steps": None, "cuts": None, "missed": None, "evaluations": None,     # of the integration, not of rows
        "n_left_wheel_lift_off": (raw.lift_offs("L"), 0.06, 0), "n_right_wheel_lift_off": (raw.lift_offs("R"), 0, 0),
        "n_left_wheel_landing": (raw.lift_offs("L", landings=True), 0.06, 0),
        "n_right_wheel_landing": (raw.lift_offs("R", landings=True), 0, 0),
        "n_left_flange_contact": (len(raw.episodes("LF")), 0.15, 0), "n_right_flange_contact": (len(raw.episodes("RF")), 0, 0),
        "n_centre_passage": (len(raw.passages()), 0, 0), "n_left_flange_over_rail": (int(ramp), 0, 0),
        "n_right_flange_over_rail": (0, 0, 0), "n_derailment": (int(ramp), 0, 0)}
    for contact in WORDS:
        n, t = raw.peak(contact)
        found |= {f"peak_N_{contact}": (n, 1e-8, 0), f"t_peak_{contact}": (t, 1e-8, 0)}
    for contact in WORDS:
        if one := raw.impact(contact):
            found |= {f"t_first_{contact}": (one["start"], 1e-8, 1e-9), f"first_peak_N_{contact}": (one["peak"], 1e-8, 0),
                      f"t_first_peak_{contact}": (raw.t[raw.first_peak(contact)], 1e-8, 0),
                      f"first_duration_{contact}": (one["duration"], 1e-4, 0),
                      f"first_impulse_{contact}": (one["impulse"], 3e-3, 0)}
            if contact[1] == "F":
                found |= {f"{name}_{contact}": None for name in ("pmax", "patch", "approach")}       # test_summary_csv
                found[f"turn_impulse_{contact}"] = raw.turned(contact), 3e-3, 0
    for name, (column, sign) in zip(("farthest_left", "farthest_right", "farthest_up", "farthest_down", "largest_roll",
                                     "smallest_roll"), WAYS, strict=True):
        found[name] = raw.extreme(column, sign), 1e-3, 1e-7
        found[f"t_{name}"] = raw.t[int((sign*raw.c[column]).argmax())], 0, 1e-3
    # test_pressure of the physics, and section pressure of the validation
    found |= dict.fromkeys(("pmax", "pmax_contact", "t_pmax", "pmax_y", "pmax_z", "t_drift"))
    found |= {"drift_reference": (float(np.abs(raw.c["W_ext"]).max()) if ramp else found["kinetic_energy"][0], 1e-6, 0),
              "drift_relative": (raw.drift()[1], 0.06, 0)}
    if ramp:
        found |= {"t_derailment": (raw.t[-1], 5e-4, 0), "F_derailment": (raw.c["F_ext"][-1], 5e-4, 0),
                  "F_unloaded": (last_load(raw), 2e-3, 0), "t_unloaded": (last_load(raw)/raw.setting("lateral_ramp"), 2e-3, 0)}
    else:
        found |= {"t_first_centre": (raw.passages()[0], 1e-6, 0), "t_return": (raw.passages()[-1], 1e-6, 0)}
    return found


CSV_WORDS = {"case", "of", "exercise", "profiles", "model", "steps", "end", "pmax_contact"}


def in_csv(raw: Raw, key: str) -> tuple[float | None, str, float]:
    """A cell of summary.csv in SI: number, unit, error as a share."""
    if key in RESULTS:
        one = RESULTS[key]
        shown = re.search(r"\[(.*)\]", one.words)
        unit = shown[1] if shown else ""
        unit = {"kN": "N", "mm": "m", "ms": "s", "µs": "s", "mrad": "rad", "MPa": "Pa", "N·s": "N.s"}.get(unit, unit)
        rough = {"n_left_flange_contact", "n_left_wheel_lift_off", "t_derailment", "F_derailment", "F_unloaded"} if end_of_ramp(
            raw) else set()
        slack = one.slack if key in rough or key.startswith(("drift", "approach")) else max(one.slack, 1e-3)
        return one.truth(raw), unit, slack
    contact = key.rpartition("_")[2]
    k = raw.first_peak(contact) if contact in WORDS else None
    if key.startswith("t_peak_"):
        return raw.peak(contact)[1] or None, "s", 1e-6
    if key == "t_pmax":
        return raw.result("t_pmax"), "s", 1e-9
    if key == "t_unloaded":
        return raw.result("t_unloaded") if end_of_ramp(raw) else None, "s", 1e-9
    if key.startswith("t_first_peak_"):
        return None if k is None else raw.t[k], "s", 1e-6
    if key == "drift_reference":
        kinetic = sum(raw.c[f"KE_{part}"][0] for part in ("lat", "vert", "roll"))
        return kinetic or np.abs(raw.c["W_ext"]).max(), "J", 1e-6
    raise AssertionError(f"nobody knows the column {key} of summary.csv")


# Pages of a run ----------------------------------------------------------------------------

def pictured(raw: Raw) -> list[int]:
    """The rows of the cross-sections on the page of impacts."""
    first = raw.first_peak("LF")
    hardest = int(raw.c["N_LF"].argmax())
    return [first, raw.first_peak("RF") or hardest]


# Labels of pages of a run.
PAGE_LABELS = [CRC, r"^Exercise \d, |(?<!^)Exercise \d, actual", r"ldbench \d\.\d\.\d", r"Nadal, friction (?:0\.3|0)",
               r"friction 0 and 0\.3", r"at Y = 0; Φ > 0", r"longest of an instant is 40 mm",
               r"^(?:left|right): .*$"]      # test_page_of_impacts
IMPACT = r"^(?:left|right) flange {n} s {n} ms {n} kN {n}° {n} kN·s {n} J {n} → {n} J {n} → {n} J {n} → {n} J".format(n=r"(\S+)")


def row_of_impacts(raw: Raw) -> Callable[[Any, Any], list[float]]:
    def truth(_: Any, match: Any) -> list[float]:
        """The numbers are those of the contact of this flange that begins nearest."""
        contact = f"{match[0][0].upper()}F"
        ones = [raw.exchange(contact, rows) for rows in raw.episodes(contact)]
        one = min(ones, key=lambda one: abs(one["start"] - float(match[1])))
        found = [one["start"], 1e3*one["duration"], KN*one["peak"], DEG*one["angle"], KN*one["impulse"], one["elastic"],
                 *(one[f"{part}_{when}"] for part in ("lat", "vert", "roll") for when in ("before", "after"))]
        if not end_of_ramp(raw) or one["start"] == raw.start(contact):
            return found
        # Later ones of a ramp open between its rows, which are a millisecond apart; energies turn within one.
        rough = 0.05, 0.2, 0.0, 0.0, 0.05, *[np.inf]*7
        return [float(shown) if abs(x - float(shown)) <= share*x else x
                for x, shown, share in zip(found, match.groups(), rough, strict=True)]
    return truth


def words_of_a_page(raw: Raw, text: str) -> tuple[list[Line], list[str]]:
    """Words of a page of a run: settings of the case, and numbers from the rows."""
    ramp = end_of_ramp(raw)
    first = {contact: raw.first_peak(contact) for contact in ("LF", "RF")}

    def touched(contact: str) -> tuple[float, float]:
        return raw.start(contact), 1e3*raw.impact(contact)["duration"]

    flat = " ".join(text.split())       # captions are broken into lines anywhere
    lines = {
        "vertical displacement": Line(r"displacement (\S+) m,", "initial Z [m]", lambda w: raw.c["Z"][0]),
        "order": Line(r"order (\d), step (\S+) µs at most", "order; largest step [µs]",
                      lambda w: (raw.setting("order"), 1e6*raw.setting("dt"))),
        "errors of": Line(r"errors of (\S+) m and (\S+) J", "tolerances [m, J]",
                          lambda w: (raw.setting("error_tolerance"), raw.setting("energy_tolerance"))),
        "output every": Line(r"output every (\S+) ms", "interval of rows [ms]", lambda w: 1e3*raw.setting("interval")),
        "axle": Line(r"axle (\S+) mm above", "height of the axle at rest [mm]", lambda w: MM*raw.setting("axle_height")),
        "growing" if ramp else "lateral velocity": Line(
            r"growing by (\S+) kN/s", "ramp [kN/s]", lambda w: KN*raw.c["F_ext"][-1]/raw.t[-1]) if ramp else Line(
            r"lateral velocity (\S+) m/s", "initial vY [m/s]", lambda w: raw.c["vY"][0]),
        "flange: at": Line(r"contact of the (?:left|right) flange: at (\S+) s, lasts (\S+) ms", "touch [s], duration [ms]",
                           lambda w, m: touched("LF" if "left" in m[0] else "RF"), 1e-4, often=True),
        "forward motion": Line(r"forward motion (\S+) J and of pitch (\S+) J", "constant energies [J]",
                               lambda w: (raw.c["KE_long"][0], raw.c["KE_pitch"][0])),
        "eigenfrequencies": Line(r"at rest, (\S+), (\S+), (\S+) Hz", "eigenfrequencies [Hz]",
                                 lambda w: raw.settings("eigenfrequencies")),
        "steepest": Line(r"flange, (\S+)°", "steepest angle of the flange [deg]", lambda w: DEG*flange_slope()),
        "impulse ∫": Line(IMPACT, "impacts: begin [s], duration [ms], peak [kN], angle [deg], impulse [kN s], energies [J]",
                          row_of_impacts(raw), often=True),
        "first contact of the left flange, at": Line(r"t = (\S+) s: first contact of the left flange", "picture [s]",
                                                     lambda w: raw.t[first["LF"]]),
        "first contact of the right flange, at": Line(r"t = (\S+) s: first contact of the right flange", "picture [s]",
                                                      lambda w: raw.t[first["RF"]]),
        "s: hardest contact of": Line(r"t = (\S+) s: hardest contact of the left flange", "picture [s]",
                                                     lambda w: raw.peak("LF")[1], 2e-4),
        "the first 6": Line(r"the first 6 of (\d+)", "contacts of flanges", lambda w: len(raw.episodes("LF")), 0.02),
        "computed again": Line(r"row at t = (\S+) s, with rows every\s+(\S+) µs", "a row [s], interval [µs]: nearest row",
                               lambda w, m: (raw.t[np.abs(raw.t - float(m[1])).argmin()], 20), often=True),
        "largest; approach": Line(r"largest; approach (\S+) mm", "approach [mm] at the peak of the first or the hardest contact",
                                   lambda w: MM*raw.overlap("LF", int(raw.c["N_LF"].argmax()) if "): hardest" in flat else
                                                            first["LF"]), 4e-3)}
    own = [line if "^" in line.pattern else line._replace(pattern=line.pattern.replace(" ", r"\s+"))
           for words, line in lines.items() if words in flat]
    return own, [label if "^" in label else label.replace(" ", r"\s+") for label in PAGE_LABELS]


ABSTRACT = [
    Line(r"left ([\d.]+), right ([\d.]+) mm for", "clearances to the left and to the right [mm]",
         lambda w: (10.18, 16.94), 1e-3),
    Line(r"contact of (\S+) to (\S+) ms", "shortest and longest first contact [ms]",
         lambda w: [1e3*w.thrown.impact("LF")["duration"]]*2),
    Line(r"At (\S+) m/s the inclined", "initial velocity [m/s]", lambda w: w.thrown.c["vY"][0]),
    Line(r"up to (\S+) GPa", "largest pressure of a first contact [GPa]",
         lambda w: 1e-9*w.thrown.peak("LF")[0]/533e-6/FULLNESS[0], 0.05),
    Line(r"pressure of all runs is (\S+) \(\S+ to \S+\) GPa", "largest pressure [GPa]: median",
         lambda w: 1e-9*max(raw.result("pmax") for raw in (w.thrown, w.pushed)), 0.2),
    Line(r"(\d+) \(\d+ to \d+\) contacts of the left flange and", "contacts of the left flange: median",
         lambda w: len(w.pushed.episodes("LF")), 0.2),
    Line(r"and (\d+) \(\d+ to \d+\) lift-offs of the right", "lift-offs of the right wheel: median",
         lambda w: w.pushed.lift_offs("R"), 0.1),
    Line(r"the limit is (\S+) kN", "static limit [kN]", lambda w: KN*w.pushed.setting("F_limit_left")),
    Line(r"derail at (\S+) \(\S+ to \S+\) kN after (\S+) \(\S+ to \S+\) s", "derailment: force [kN], time [s], medians",
         lambda w: (KN*w.pushed.c["F_ext"][-1], w.pushed.t[-1]), 0.05),
    Line(r"𝐸 = (\d+) GPa and 𝜈 = (\S+?)\. Non-Hertzian", "modulus [GPa], Poisson's ratio",
         lambda w: (1e-9*w.thrown.setting("youngs_modulus"), w.thrown.setting("poisson"))),
    Line(r"penetrations of up to (\S+) mm", "depth of the table [mm]", lambda w: MM*w.thrown.setting("depth")),
    Line(r"a cant of (\d):(\d+),", "taper and cant, of the call", lambda w: (1, 40)),
    Line(r"\(right\) " + r"(\S+) % \((\S+) %\) "*4 + "Table 1", "largest errors of the contact force in the runs of a pair [%]",
         lambda w: [100*max(raw.errors()[at][k] for raw in (w.thrown, w.pushed) if at in raw.errors())
                    for at in ("tread", "flange", "both", "going_over") for k in range(2)]),
    Line(r"wheel that are at least (\S+)° steep", "least angle of a flange [deg]", lambda w: DEG*w.thrown.setting("flange_angle")),
    Line(r"tolerances of (\S+) m and (\S+) J, and at most \d+ µs long in exercise 5, with tolerances of (\S+) m and (\S+) J",
         "tolerances [m, J]", lambda w: tuple(raw.setting(f"{kind}_tolerance") for raw in (w.thrown, w.pushed)
                                              for kind in ("error", "energy"))),
    Line(r"presses an area of (\S+) mm²", "largest first patch of a flange [mm2]: the table has it", lambda w: 533),
    Line(r"steps (\d+ \d+) (\d+ \d+) mean", "steps", lambda w: (w.thrown.result("steps"), w.pushed.result("steps"))),
    Line(r"evaluations of the force (\d+ \d+) (\d+ \d+) Table", "evaluations",
         lambda w: (w.thrown.result("evaluations"), w.pushed.result("evaluations"))),
    Line(r"profiles(?: \(right\))? (\S+) m/s", "initial velocity of the curves [m/s]", lambda w, m: w.thrown.c["vY"][0],
         often=True),
    Line(r"drift of all steps is (\S+) of the", "drift, relative, exercises 1 to 4", lambda w: w.thrown.drift()[1], 0.05),
    Line(r"1 to 4 and (\S+) of the work", "drift, relative, exercise 5", lambda w: w.pushed.drift()[1], 0.05),
    Line(r"at most (\d+) µs long in exercises", "largest step [µs]", lambda w: 1e6*w.thrown.setting("dt")),
    Line(r"at most (\d+) µs long in exercise 5", "largest step, exercise 5 [µs]", lambda w: 1e6*w.pushed.setting("dt")),
    Line(r"mean step \[µs\] (\S+) (\S+)", "mean step [µs]", lambda w: tuple(
        1e6*raw.t[-1]/int(raw.text.split("#   steps = ")[1].split()[0]) for raw in (w.thrown, w.pushed))),
    Line(r"profiles \(right\), flange (\S+) kN at (\S+)°", "picture: force [kN], angle [deg] at the peak of the first contact",
         lambda w: (KN*w.thrown.impact("LF")["peak"], DEG*w.thrown.impact("LF")["angle"]))]


# Formulas, references and ticks of the abstract, and what other tests compare.
ABSTRACT_LABELS = [
    r"\[\d\]", r"\(\d\)(?= |\.)", r"(?:Table|Figure|Equation) \d", r"[Ee]xercises? \d(?: to \d)?", r"\d / 4\b",
    r"version \d\.\d\.\d",
    r"(?<=[.\d] )\d (?=The program|Contact geometry|Normal force|Integrator|Results|Limits)", r"References \[1\].*$",
    r"(?:(?<= )[-−]?\d[\d.]* ){3,}", r"\d{15,} y \[mm\](?: [-−\d]+)+", r"0\.1 1 lateral velocity \[m/s\] 1000 10000",
    r"10 100 1000(?=N of)",
    r"= 1 2 ?[∬∫]", r"𝑘 = 3 4", r"\(1 ?− ?𝜈2\)", r"𝑈 = 2 5", r"≥ ?0", r"𝛽 = ?0", r"𝑀−1", r"𝑖 ?= ?1,…,6",
    r"e = (?:1|0\.5|0)\b", r"force and 5 kN",
    r"of 8 twins|up to 3 µm|than 0\.1 %", r"\(\S+ to \S+\)(?: kN| s| GPa)?", r"about 1\.6 times", r"tables have [\d× +]+points",
    r"\(APTA 140M and 240\).*?exercise 5 by up to \S+ %"]          # test_docs: spread.json has what the check measured
