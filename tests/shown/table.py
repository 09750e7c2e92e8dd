"""The table of shown numbers: for every place where a user reads numbers, what each is, its unit, side and moment, and how it
follows from the rows of the specimen."""
from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from typing import Any, NamedTuple

import numpy as np
import pytest

from raw import Raw, flange_slope
from reading import Known, Line

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
# What the axes of all pages show, by their words: the beginnings of names; of the curves of some, by their own words.
CURVES = {words: curves for panels in (*SHEETS.values(), PANELS) for words, curves in panels.items()}
AXES = {words: tuple(curves.values()) for words, curves in CURVES.items()}
for words, names in {
        "time [s]": ("time [s]",), "time since the touch [ms]": ("time since",), "frequency [Hz]": ("frequency",),
        "time since the flange touched [ms]": ("time since LF",), "lateral force [kN]": ("F_ext",), "vertical force [kN]": ("Fz_",),
        "N of the left flange [kN]": ("N_LF",), "N of flanges [kN]": ("N_LF", "-N_RF"), "N, first contact [kN]": ("N_LF",),
        "kinetic energy [J]": ("KE_lat+KE_vert+KE_roll",), "Y [mm]": ("Y",), "initial velocity × time [mm]": ("time × first vY",),
        "lateral velocity [m/s]": ("vY", "first vY"), "initial lateral velocity [m/s]": ("first vY",),
        "first peak [kN]": ("first peak of N_LF",), "peak N [kN]": ("first peak of N_LF",),
        "duration [ms]": ("first duration of N_LF",),
        "impulse ∫N dt [kN·s]": ("first impulse of N_LF",), "lateral velocity after / before, reversed": ("rebound of N_LF",),
        "share of the kinetic energy before the contact [%]": ("share of ",), "vertical Z [mm]": ("Z [mm]",),
        "left flange: impulse [kN·s]": ("impulse_LF",), "work of weight and load [J]": ("PE_grav+PE_load", "first KE_lat"),
        "contact angle [°]": ("angle_",), "rolling radius [mm]": ("radius_",), "Δr = left − right [mm]": ("delta_r",),
        "equivalent conicity": ("conicity", "linearised"), "contact position, outward |y| [mm]": ("y_L", "-y_R"),
        "contact position z [mm]": ("z_",), "height Z [mm]": ("Z",), "contact angle γ [°]": ("angle_",),
        "½(tan γL − tan γR)": ("tan",),
        "contact, outward |y| [mm]": ("out_",), "amplitude [mm]": ("amplitude",), "tangent angle [°]": ("tangent angle",),
        "curvature [1/m]": ("curvature",)}.items():
    AXES[words] = AXES.get(words, ()) + names


WAYS = ("Y", 1), ("Y", -1), ("Z", 1), ("Z", -1), ("roll", 1), ("roll", -1)      # of extremes


def end_of_ramp(raw: Raw) -> bool:
    return bool(raw.c["F_ext"][-1] > 0)


class Result(NamedTuple):
    """The words and the unit's factor under which documents, page and abstract have a result of a run."""

    words: str                  # of the page's table; with the unit
    scale: float
    short: str = ""             # of the abstract; "" of what it leaves out
    paper: str | None = None    # of the table of results in the PDF, where it has other words

    @property
    def brief(self) -> str:
        """The words of the table of results in the PDF; '' of what it leaves out."""
        return self.words if self.paper is None else self.paper


RESULTS: dict[str, Result] = {
    "t_first_LF": Result("first contact of the left flange [s]", 1, *["first left flange contact [s]"]*2),
    "t_first_RF": Result("first contact of the right flange [s]", 1, *["first right flange contact [s]"]*2),
    "t_first_centre": Result("first passage of the centre after a flange contact [s]", 1, "", "first passage of the centre [s]"),
    "t_return": Result("return to the centre after turning back on both sides [s]", 1, *["return to the centre [s]"]*2),
    "F_limit_left": Result("static limit of the lateral force, left [kN]", KN, "", "static limit of the lateral force [kN]"),
    "F_unloaded": Result("lateral force at which a wheel lifts for good [kN]", KN, "", "lateral force, lift for good [kN]"),
    "t_derailment": Result("derailment [s]", 1, "derailment [s]"),
    "F_derailment": Result("lateral force at derailment [kN]", KN, "lateral force at derailment [kN]"),
    "farthest_left": Result("Y, largest [mm]", MM, *["largest Y [mm]"]*2),
    "farthest_right": Result("Y, smallest [mm]", MM, "", "smallest Y [mm]"),
    "farthest_up": Result("Z, largest [mm]", MM, *["largest Z [mm]"]*2),
    "farthest_down": Result("Z, smallest [mm]", MM, "", "smallest Z [mm]"),
    "largest_roll": Result("Φ, largest [mrad]", 1e3, "", "largest Φ [mrad]"),
    "smallest_roll": Result("Φ, smallest [mrad]", 1e3, "", "smallest Φ [mrad]"),
    **{f"peak_N_{c}": Result(f"peak N, {words} [kN]", KN, f"peak N, {words} [kN]" if c[1] == "F" else "")
       for c, words in WORDS.items()},
    **{f"{name}_{c}": Result(f"{words}, first contact, {WORDS[c]} [{unit}]", scale, "", paper and f"{paper}, {WORDS[c]} [{unit}]")
       for name, words, unit, scale, paper in (
           ("first_peak_N", "peak N", "kN", KN, None), ("first_duration", "duration", "ms", 1e3, None),
           ("first_impulse", "impulse", "N·s", 1, None), ("approach", "approach", "mm", MM, "approach"))
       for c in ("LF", "RF")},
    "pmax": Result("largest pressure of the run [MPa]", 1e-6, *["largest pressure [MPa]"]*2),
    "n_left_flange_contact": Result("contacts of the left flange", 1),
    "n_right_flange_contact": Result("contacts of the right flange", 1),
    "n_left_wheel_lift_off": Result("lift-offs of the left wheel", 1, *["lift-offs, left wheel"]*2),
    "n_right_wheel_lift_off": Result("lift-offs of the right wheel", 1, *["lift-offs, right wheel"]*2),
    "drift": Result("largest energy drift [J]", 1),
    "drift_relative": Result("the drift over initial kinetic energy or work", 1, *["energy drift, relative"]*2),
    "step": Result("time step [µs]", 1e6, "", ""), "t": Result("end of the run [s]", 1, "", "")}
# The pressure and the area of a patch must go with the force of the contact: N = 0.64 of pressure times area.
PRESSED = {c: (f"peak pressure, first contact, {WORDS[c]} [MPa]", f"patch area, first contact, {WORDS[c]} [mm²]")
           for c in ("LF", "RF")}
FULLNESS = 0.64, 0.03


def fits_contact(raw: Raw, contact: str, k: int, pressure: float, area: float) -> None:
    """Whether largest pressure and area of a patch go with its contact."""
    for shown, one in zip((pressure, area), patches(raw, contact, k, pressure, area), strict=True):
        assert shown == pytest.approx(one.value, rel=one.slack), contact


def text_of_summary(raw: Raw) -> list[Line]:
    """The summary that a run prints. What rows do not tell, the column file says beside them."""
    told = known(raw)

    def all_of(*names: str, scale: float = 1.0) -> Callable[[Any], list[Known]]:
        return lambda w: [told[name].of(scale) for name in names]

    def event(kind: str, _: Any, match: Any) -> list[Any]:
        """The time of an event, at which the rows show a change of its kind, the angle of a flange that closes [deg], in the first
        row in which it has one, and the lateral force [kN]."""
        times = raw.changes(kind)
        when = times[np.abs(times - float(match[1])).argmin()]
        k, angles = int(np.abs(raw.t - when).argmin()), raw.c[f"angle_{kind[0].upper()}F"] if "contact" in kind else np.zeros(0)
        closed = angles[k:][np.isfinite(angles[k:])]
        return [when, *([Known(DEG*abs(closed[0]), 0.03)] if closed.size else []), *([KN*raw.c["F_ext"][k]] if ramp else [])]

    kinds = [f"n_{kind.replace(' ', '_').replace('-', '_')}" for kind in EVENTS]
    ways = "farthest_left", "farthest_right", "farthest_up", "farthest_down"
    errors, ramp = raw.errors(), end_of_ramp(raw)
    stated = r"error of the contact force in poses of the run, rms \(largest\), relative to max\(\|F\|, 5 kN\):\n  "
    lines = [
        Line(r"vertical displacement (\S+) m\b", "initial Z [m]", lambda w: raw.c["Z"][0]),
        Line(r"clearance \[mm\]: left (\S+), right (\S+)$", "rigid-axle clearances [mm]", lambda w: CLEARANCE, 1e-3),
        Line(r"axle (\S+) m above", "height of the axle at rest [m]", lambda w: raw.setting("axle_height")),
        Line(r"(\S+) mm lower than with rigid contacts,\s", "sinking of the axle at rest [mm]", lambda w: MM*raw.sinking, 5e-3),
        Line(r"(\S+) kN\s+per wheel", "load of a wheel [kN]", lambda w: KN*raw.weight/2),
        Line(r"Y = (\S+) m, Z = (\S+) m, roll =\s+(\S+) rad", "pose at rest [m, m, rad]",
             lambda w: [raw.setting(f"rest_{name}") for name in ("Y", "Z", "roll")]),
        Line(r"\[Hz\]: lateral (\S+), vertical (\S+), roll (\S+)$", "eigenfrequencies [Hz]",
             lambda w: raw.settings("eigenfrequencies")),
        *(Line(rf"^  t = (\S+) s  {kind}" + r" at (\S+) degrees"*("contact" in kind) + r", lateral force (\S+) kN"*ramp + "$",
               f"events: {kind} [s], angle [deg], lateral force [kN]", partial(event, kind), often=True)
          for kind, name in zip(EVENTS, kinds, strict=True) if told[name].value),
        *(Line(rf"^number of events:\n(?:  .*\n)*?  {kind} (\d+)$", f"{kind}: how often", lambda w, name=name: told[name])
          for kind, name in zip(EVENTS, kinds, strict=True) if told[name].value),
        Line(r"^largest lateral force with an equilibrium \[kN\]: left (\S+), right (\S+)$", "static limits [kN]",
             all_of("F_limit_left", "F_limit_right", scale=KN)),
        Line(r"^farthest \[mm\]: left (\S+) at \S+ s, right (\S+) at \S+ s, up (\S+) at \S+ s, down\s+(\S+) at",
             "farthest ways [mm]", all_of(*ways, scale=MM)),
        Line(r"left \S+ at (\S+) s, right \S+ at (\S+) s, up \S+ at (\S+) s, down\s+\S+ at (\S+) s", "when [s], between rows",
             all_of(*(f"t_{way}" for way in ways))),
        Line(r"^roll \[mrad\]: largest (\S+) at \S+ s, smallest (\S+) at \S+ s$", "roll [mrad]",
             all_of("largest_roll", "smallest_roll", scale=1e3)),
        Line(r"^roll \[mrad\]: largest \S+ at (\S+) s, smallest \S+ at (\S+) s$", "roll [s]",
             all_of("t_largest_roll", "t_smallest_roll")),
        Line(r"^largest pressure \[GPa\]: (\S+), .F at (\S+) s, y = (\S+) m, z = (\S+) m$", "largest pressure [GPa, s, m, m]",
             lambda w: (1e-9*raw.result("pmax"), *(raw.result(name) for name in ("t_pmax", "pmax_y", "pmax_z")))),
        Line(r"energy drift \[J\]: (\S+?)(?:,|$)", "largest energy drift [J]", all_of("drift")),
        Line(r"(?:initial kinetic energy|largest work of the lateral force): (\S+)$", "drift over kinetic energy or work",
             all_of("drift_relative")),
        Line(r"^steps: (\d+) of at most (\S+) s, of which (\d+) were cut; contact evaluations: (\d+)$",
             "steps, the longest [s], cut ones, evaluations",
             lambda w: (raw.result("steps"), raw.setting("dt"), raw.result("cuts"), raw.result("evaluations"))),
        Line(r"^ended at t = (\S+) s", "end [s]", all_of("t")), Line(r"\.txt, (\d+) rows", "rows", all_of("rows")),
        Line(stated + "  ".join([r"[a-z ]+ (\S+) \((\S+)\)\n"]*len(errors)), "errors of the contact force",
             lambda w: [x for both in errors.values() for x in both])]
    for contact, words in WORDS.items():
        if raw.peak(contact)[0]:
            lines.append(Line(rf"^  {contact} (\S+) at (\S+) s", f"peak force [kN] of the {words} and its time [s]",
                              lambda w, c=contact: (told[f"peak_N_{c}"].of(KN), told[f"t_peak_{c}"])))
        if raw.first(contact):
            names = ("t_first", 1), ("first_peak_N", KN), ("t_first_peak", 1), ("first_duration", 1e3), ("first_impulse", 1)
            lines.append(Line(
                rf"^  {contact} from (\S+) s, peak (\S+) kN at (\S+) s, lasts (\S+) ms, impulse\s+(\S+) N s$",
                f"first contact [s, kN, s, ms, N s], {words}",
                lambda w, c=contact, names=names: [told[f"{name}_{c}"].of(scale) for name, scale in names]))
    if ramp:
        return [*lines, Line(r"force growing by (\S+) kN/s", "ramp [kN/s]", lambda w: KN*raw.setting("lateral_ramp")),
                Line(r"^a wheel lifts for good: (\S+) s, lateral force (\S+) kN$", "lift for good [s, kN]",
                     lambda w: (told["t_unloaded"], told["F_unloaded"].of(KN))),
                Line(r"^derailment: (\S+) s, lateral force (\S+) kN$", "derailment [s, kN]",
                     lambda w: (told["t_derailment"], told["F_derailment"].of(KN)))]
    return [*lines, Line(r"lateral velocity (\S+) m/s", "initial vY [m/s]", lambda w: raw.c["vY"][0]),
            Line(r"^back at the centre after turning back on both sides: (\S+) s$", "return [s]", all_of("t_return"))]


# They belong to the contact table and to the processor, not to the run.
SUMMARY_LABELS = [r"CRC-32 [0-9A-F]{8}", r"first 5 events", r"^processor time .*$",
                  r"^(?:left |right )?contact table: model .* points$", r"^contact table: \d+ solutions, \d+ found$"]
EVENTS = (*(f"{side} {kind}" for kind in ("wheel lift-off", "wheel landing", "flange contact", "flange over rail")
            for side in ("left", "right")), "centre passage", "derailment")
CLEARANCE = 10.18, 16.94        # of the rigid axle to the left and to the right, of the call [mm]
CRC = r"CRC-32 [0-9A-F]{8}"     # test_profiles


def first_touch(raw: Raw, contact: str) -> float:
    """When a flange is first touched, by a force or an impact: where the row before is."""
    blows = raw.c.get(f"P_{contact}", np.zeros(len(raw.t)))
    touched = (raw.c[f"N_{contact}"] > 1.0) | (blows > 0)
    k = int(touched.argmax())
    return raw.t[k if blows[k] > 0 else k - 1] if touched.any() else np.inf


# Results ------------------------------------------------------------------------------------

# What no row tells: the run's file has it, and tests of the physics and of the validation compare it with other computations.
BEYOND_ROWS = "steps", "cuts", "missed", "evaluations", "pmax", "t_pmax", "pmax_y", "pmax_z", "t_drift"


@cache
def known(raw: Raw) -> dict[str, Known]:
    """What rows tell of the results of a run, and what the core knew before it, SI."""
    ramp, (drift, relative), (left, right) = end_of_ramp(raw), raw.drift(), (raw.lift_offs(side) for side in "LR")
    kinetic = sum(raw.c[f"KE_{part}"][0] for part in ("lat", "vert", "roll"))
    carries = np.flatnonzero(raw.c["N_RT"] + raw.c["N_RF"] > 0)[-1]      # the right wheel, for the last time
    passed = [*raw.passages()]
    found = {
        "t": Known(raw.t[-1], 1e-9), "rows": Known(len(raw.t)), "step": Known(raw.setting("dt")), "drift": Known(drift, 0.06),
        "kinetic_energy": Known(kinetic, 1e-8, 1e-9), "drift_relative": Known(relative, 0.06),
        "drift_reference": Known(kinetic or np.abs(raw.c["W_ext"]).max(), 1e-6),
        # Rows of a ramp miss short contacts.
        "n_left_flange_contact": Known(len(raw.episodes("LF")), 0.15*ramp),
        "n_right_flange_contact": Known(len(raw.episodes("RF"))), "n_left_wheel_lift_off": Known(left, 0.06*ramp),
        "n_right_wheel_lift_off": Known(right),
        "n_left_wheel_landing": Known(raw.lift_offs("L", landings=True), 0.06*ramp),
        "n_right_wheel_landing": Known(raw.lift_offs("R", landings=True)), "n_centre_passage": Known(len(passed)),
        "n_left_flange_over_rail": Known(int(ramp)), "n_right_flange_over_rail": Known(0), "n_derailment": Known(int(ramp)),
        "t_first_centre": Known(passed[0] if passed else None, 1e-6), "t_return": Known(passed[-1] if passed else None, 1e-6),
        "t_derailment": Known(raw.t[-1] if ramp else None, 5e-4),
        "F_derailment": Known(raw.c["F_ext"][-1] if ramp else None, 5e-4),
        "F_unloaded": Known(raw.c["F_ext"][carries] if ramp else None, 2e-3),
        "t_unloaded": Known(raw.t[carries] if ramp else None, 2e-3),
        **{f"F_limit_{way}": Known(raw.setting(f"F_limit_{way}")) for way in ("left", "right")}}      # quasistatic
    for contact in WORDS:
        n, t = raw.peak(contact)
        found |= {f"peak_N_{contact}": Known(n), f"t_peak_{contact}": Known(t)}
        one, k = raw.impact(contact), raw.first_peak(contact)
        found |= {f"t_first_{contact}": Known(one.get("start"), 1e-8, 1e-9), f"first_peak_N_{contact}": Known(one.get("peak")),
                  f"t_first_peak_{contact}": Known(None if k is None else raw.t[k]),
                  f"first_duration_{contact}": Known(one.get("duration"), 1e-4),
                  f"first_impulse_{contact}": Known(one.get("impulse"), 3e-3),
                  f"approach_{contact}": Known(raw.overlap(contact, k) if k is not None and contact[1] == "F" else None, 4e-3)}
        if one and contact[1] == "F":
            found[f"turn_impulse_{contact}"] = Known(raw.turned(contact), 3e-3)
    for name, (column, sign) in zip(("farthest_left", "farthest_right", "farthest_up", "farthest_down", "largest_roll",
                                     "smallest_roll"), WAYS, strict=True):
        found[name] = Known(raw.extreme(column, sign), 1e-3, 1e-7)
        found[f"t_{name}"] = Known(raw.t[int((sign*raw.c[column]).argmax())], 0.0, 1e-3)
    return found


SI_UNITS = {"t": "s", "first_duration": "s", "step": "s", "F": "N", "peak_N": "N", "first_peak_N": "N", "first_impulse": "N.s",
            "turn_impulse": "N.s", "farthest": "m", "approach": "m", "pmax_y": "m", "pmax_z": "m", "pmax": "Pa", "patch": "m2",
            "drift_relative": "", "drift": "J", "kinetic_energy": "J", "largest_roll": "rad", "smallest_roll": "rad"}


def unit_of(key: str) -> str:
    """The unit of a result in files, in brackets behind its name."""
    unit = next((unit for name, unit in SI_UNITS.items() if f"{key}_".startswith(f"{name}_")), "")
    return f" [{unit}]" if unit else ""


def patches(raw: Raw, contact: str, k: int, pressure: float, area: float) -> tuple[Known, Known]:
    """Largest pressure and area of a patch [Pa, m2] go with the force and the overlap of its contact, and with each other, as in
    Hertz's theory: the force is nearly 2/3 of pressure times area, and a circle of that area has 2 E* / pi times the overlap for
    radius times pressure."""
    stiffness = raw.setting("youngs_modulus")/(1 - raw.setting("poisson")**2)/np.pi
    radius = 1.27*raw.overlap(contact, k)*stiffness/pressure
    return Known(raw.c[f"N_{contact}"][k]/area/FULLNESS[0], FULLNESS[1]/FULLNESS[0]), Known(np.pi*radius**2, 0.17)


# Pages of a run ----------------------------------------------------------------------------

def pictured(raw: Raw) -> list[int]:
    """The rows of the cross-sections on the page of impacts."""
    first = raw.first_peak("LF")
    hardest = int(raw.c["N_LF"].argmax())
    return [first, raw.first_peak("RF") or hardest]


# Labels of pages of a run.
PAGE_LABELS = [r"CRC-32\s+[0-9A-F]{8}", r"^Exercise \d, |(?<!^)Exercise\s+\d, actual", r"ldbench\s+\d\.\d\.\d",
               r"Nadal, friction (?:0\.3|0)", r"friction\s+0\s+and\s+0\.3", r"at\s+Y\s+=\s+0; Φ\s+>\s+0",
               r"longest\s+of\s+an\s+instant\s+is\s+40\s+mm"]
IMPACT = r"^(?:left|right) flange {n} s {n} ms {n} kN {n}° {n} kN·s {n} J {n} → {n} J {n} → {n} J {n} → {n} J".format(n=r"(\S+)")


def impact_of(raw: Raw, match: Any) -> list[Any]:
    """The numbers of the contact of a flange that begins nearest."""
    contact = f"{match[0][0].upper()}F"
    ones = [raw.exchange(contact, rows) for rows in raw.episodes(contact)]
    one = min(ones, key=lambda one: abs(one["start"] - float(match[1])))
    return [one["start"], Known(1e3*one["duration"], 1e-4), KN*one["peak"], DEG*one["angle"], Known(KN*one["impulse"], 3e-3),
            one["elastic"], *(one[f"{part}_{when}"] for part in ("lat", "vert", "roll") for when in ("before", "after"))]


def words_of_a_page(raw: Raw, text: str) -> list[Line]:
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
                          lambda w, m: impact_of(raw, m), often=True),
        "first contact of the left flange, at": Line(r"t = (\S+) s: first contact of the left flange", "picture [s]",
                                                     lambda w: raw.t[first["LF"]]),
        "first contact of the right flange, at": Line(r"t = (\S+) s: first contact of the right flange", "picture [s]",
                                                      lambda w: raw.t[first["RF"]]),
        "s: hardest contact of": Line(r"t = (\S+) s: hardest contact of the left flange", "picture [s]",
                                                     lambda w: raw.peak("LF")[1], 2e-4),
        "the first 6": Line(r"the first 6 of (\d+)", "contacts of flanges", lambda w: len(raw.episodes("LF")), 0.02),
        "computed again": Line(
            r"row at t = (\S+) s, with rows every\s+(\S+) µs", "a row 9 ms before the contact [s], interval [µs]",
            lambda w: (Known((raw.peak("LF")[1] if "hardest" in flat else raw.start("LF")) - 9e-3, 0.0, 5e-4), 20)),
        "largest; approach": Line(r"largest; approach (\S+) mm", "approach [mm] at the peak of the first or the hardest contact",
                                   lambda w: MM*raw.overlap("LF", int(raw.c["N_LF"].argmax()) if "): hardest" in flat else
                                                            first["LF"]), 4e-3)}
    return [line if "^" in line.pattern else line._replace(pattern=line.pattern.replace(" ", r"\s+"))
            for words, line in lines.items() if words in flat]


ABSTRACT = [
    Line(r"left ([\d.]+), right ([\d.]+) mm for", "clearances to the left and to the right [mm]",
         lambda w: CLEARANCE, 1e-3),
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
        1e6*raw.t[-1]/raw.result("steps") for raw in (w.thrown, w.pushed))),
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
