"""Files that strangers would send to the benchmark: with mistakes, faultless in odd form, in the styles of codes.

A frame is a pandas DataFrame with the columns of docs/output.md in SI; `frames` is {"ex1_aw": frame, ...} with any of
the ten. Every function gives {file name: content}. Content is a str, to be written as UTF-8 without translating line
ends (newline=""), or bytes, to be written as they are. Functions work on those of the frames that they can use.

mistake_NAME(frames)         a participant did one thing wrong
mistake_NAME(frames, runs)   the same where RUNS has mistake_NAME: `runs` is {"ex2_aw": frame, ...} of runs with the
                             namelist variables of RUNS[name]; RUN_CASES[name] are the simulations that are used
                             (if not listed: all that are in `runs`); other files come from `frames`
faultless_NAME(frames)       nothing is wrong, the form is odd
STYLES[name](frame)          text of one file in the naming style of an imagined code

Mistakes that exchange whole files need both of them in `frames`; with one frame they change nothing. Use those of
exercise 5 (ramps, stopped at 40 s) with an ex5 frame, and faultless_exercise_1_at_2_kHz with an ex1 frame.

Written without reading the code that judges files. Needs numpy and pandas.
"""
import re

import numpy as np
import pandas as pd

G = 9.81
MASS, ROLL_INERTIA, PITCH_INERTIA, LOAD = 1568.0, 656.0, 168.0, 164618.0      # of the call
CONTACTS = ("LT", "LF", "RT", "RF")
MOTION = ("Y", "Z", "roll", "vY", "vZ", "roll_rate", "aY", "aZ", "roll_acc")
POINT = ("angle", "N", "Fy", "Fz", "y", "z", "radius")
ENERGY = ("KE_lat", "KE_vert", "KE_roll", "PE_grav", "PE_load", "PE_elastic_L", "PE_elastic_R")
CALL = ("time",) + MOTION + tuple(f"{q}_{c}" for c in CONTACTS for q in POINT)
ALL = CALL + ENERGY

SIDE = {"L": "left", "R": "right"}
PART = {"T": "tread", "F": "flange"}
ENGLISH = {
    "time": "time", "Y": "lateral displacement", "Z": "vertical displacement", "roll": "roll angle",
    "vY": "lateral velocity", "vZ": "vertical velocity", "roll_rate": "roll velocity",
    "aY": "lateral acceleration", "aZ": "vertical acceleration", "roll_acc": "roll acceleration",
    "KE_lat": "kinetic energy lateral", "KE_vert": "kinetic energy vertical", "KE_roll": "kinetic energy roll",
    "PE_grav": "potential energy gravity", "PE_load": "potential energy load",
    "PE_elastic_L": "elastic energy left", "PE_elastic_R": "elastic energy right"}
ENGLISH_POINT = {"angle": "contact angle", "N": "normal force", "Fy": "lateral force", "Fz": "vertical force",
                 "y": "contact point y", "z": "contact point z", "radius": "rolling radius"}


# ------------------------------------------------------------------------------------------------- tools

def _names(motion, point, side=SIDE, part=PART, form="{side} {part} {quantity}"):
    """{column: name} from names of the motion, of a contact's quantities, of sides and of parts."""
    names = dict(motion)
    for c in CONTACTS:
        for q, quantity in point.items():
            names[f"{q}_{c}"] = form.format(side=side[c[0]], part=part[c[1]], quantity=quantity)
    return names


PLAIN = _names(ENGLISH, ENGLISH_POINT)
SHORT = {name: text.replace(" ", "_") for name, text in PLAIN.items()}
SI = {"time": ("s", 1), "length": ("m", 1), "angle": ("rad", 1), "speed": ("m/s", 1), "spin": ("rad/s", 1),
      "acc": ("m/s2", 1), "spinacc": ("rad/s2", 1), "force": ("N", 1), "energy": ("J", 1)}
MM_KN = {"length": ("mm", 1e3), "force": ("kN", 1e-3)}
KINDS = {"time": "time", "Y": "length", "Z": "length", "roll": "angle", "vY": "speed", "vZ": "speed",
         "roll_rate": "spin", "aY": "acc", "aZ": "acc", "roll_acc": "spinacc",
         "angle": "angle", "N": "force", "Fy": "force", "Fz": "force", "y": "length", "z": "length", "radius": "length"}


def _kind(name):
    """Kind of unit of a column."""
    return "energy" if name in ENERGY else KINDS.get(name) or KINDS[name.rsplit("_", 1)[0]]


def _form(frame, names=PLAIN, units=None, signs=(), offset=None, order=ALL, extra=(), sep=",", head="brackets",
          na="NaN", digits="%.9g", decimal=".", eol="\n", before=""):
    """Text of a frame: `units` is {kind or column: (label, factor)}, `signs` the columns with the other sign,
    `offset` {column: SI value added before the unit}, `extra` (name, unit, values), `head` a kind of header."""
    units, offset, columns = {**SI, **(units or {})}, offset or {}, []
    for name in order:
        label, factor = units.get(name) or units[_kind(name)]
        values = frame[name].to_numpy(float) + offset.get(name, 0.0)
        columns.append((names.get(name, name), label, values*factor*(-1.0 if name in signs else 1.0)))
    columns += [(name, unit, np.broadcast_to(values, len(frame))) for name, unit, values in extra]
    table = pd.DataFrame({i: values for i, (_, _, values) in enumerate(columns)}) + 0.0
    texts, labels = [c[0] for c in columns], [c[1] for c in columns]
    lines = {"brackets": [[f"{t} [{u}]" for t, u in zip(texts, labels, strict=False)]],
             "parens": [[f"{t} ({u})" for t, u in zip(texts, labels, strict=False)]],
             "glued": [[f"{t}[{u}]" for t, u in zip(texts, labels, strict=False)]],
             "quoted": [[f'"{t} [{u}]"' for t, u in zip(texts, labels, strict=False)]],
             "two lines": [texts, labels],
             "two lines in brackets": [texts, [f"[{u}]" for u in labels]],
             "quoted two lines": [[f'"{t}"' for t in texts], [f'"{u}"' for u in labels]],
             "names": [texts], "none": []}[head]
    body = table.to_csv(sep=sep, header=False, index=False, na_rep=na, float_format=digits, decimal=decimal,
                        lineterminator="\n", quoting=3, escapechar="\\")
    body = body.replace("\\", "")
    text = before + "".join(sep.join(line) + "\n" for line in lines) + body
    return text.replace("\n", eol) if eol != "\n" else text


def _files(frames, name="{case}.csv", **options):
    """All frames in one form."""
    return {name.format(case=case, **_title(case)): _form(frame, **options) for case, frame in frames.items()}


def _title(case):
    """Parts of a file's name: {n} exercise, {what} actual or simplified."""
    return {"n": case[2], "what": {"aw": "actual", "sw": "simplified"}[case[4:]]}


def _changed(frames, change, **options):
    """Plain files of frames that `change` alters; it gets a copy and gives a frame, or None and has altered the copy."""
    changed = {}
    for case, frame in frames.items():
        copy = frame.copy()
        result = change(copy)
        changed[case] = copy if result is None else result
    return _files(changed, **options)


def _each(change):
    """A mistake, or an odd form, that alters every frame."""
    return lambda frames: _changed(frames, change)


def _text(text):
    """An odd form whose files are what `text` makes of a frame."""
    return lambda frames: {f"{case}.csv": text(frame) for case, frame in frames.items()}


def _runs(frames, runs, cases=None):
    """Plain files in which runs replace the frames of `cases`, of all if None."""
    return _files({case: runs[case] if case in runs and (cases is None or case in cases) else frame
                   for case, frame in frames.items()})


def _swap(frame, one, other, quantities=POINT):
    """Exchange the columns of two contacts."""
    a, b = [f"{q}_{one}" for q in quantities], [f"{q}_{other}" for q in quantities]
    frame[a + b] = frame[b + a].to_numpy()


def _first_impact(frame, contact="LF"):
    """Rows of the first closed interval of a contact that presses with a tenth of its largest force at least."""
    force = frame[f"N_{contact}"].to_numpy(float)
    closed = np.concatenate([[False], force > 1.0, [False]])
    starts, ends = np.flatnonzero(closed[1:] & ~closed[:-1]), np.flatnonzero(~closed[1:] & closed[:-1])
    for start, end in zip(starts, ends, strict=False):
        if force[start:end].max() > 0.1*force.max():
            return start, end
    return len(frame)//3, len(frame)//3 + 1


def _at(frame, dt):
    """Rows nearest to multiples of dt."""
    t = frame["time"].to_numpy(float)
    wanted = np.arange(0.0, t[-1] + 1e-9, dt)
    after = np.searchsorted(t, wanted).clip(1, len(t) - 1)
    rows = np.where(wanted - t[after - 1] < t[after] - wanted, after - 1, after)
    return frame.iloc[np.unique(rows)].reset_index(drop=True)


def _sum(t, rate):
    """Integral over time by trapezia, zero at the start."""
    return np.concatenate([[0.0], np.cumsum(np.diff(t)*(rate[1:] + rate[:-1])/2)])


def _mean_over(t, values, width):
    """Running mean over a time, from the integral."""
    integral = _sum(t, values)
    a, b = np.clip(t - width/2, t[0], t[-1]), np.clip(t + width/2, t[0], t[-1])
    return (np.interp(b, t, integral) - np.interp(a, t, integral))/(b - a)


def _of(quantities, contacts=CONTACTS):
    """Names of columns of contacts."""
    return [f"{q}_{c}" for c in contacts for q in quantities]


def _axle_height(frame):
    """Height of the axle above the top of rail at the start, from the left contact point and its radius."""
    row = frame.iloc[0]
    return float(row["z_LT"] + row["radius_LT"])


def _scale(names, factor):
    """A change that multiplies columns."""
    def change(frame):
        frame[list(names)] *= factor
    return change


# ---------------------------------------------------------------------- runs that the caller makes for mistakes

ACTUAL = tuple(f"ex{n}_aw" for n in range(1, 6))
FREE = tuple(f"ex{n}_{p}" for n in range(1, 5) for p in ("aw", "sw"))
RUNS = {
    "mistake_radius_of_another_wheelset": {"rolling_radius": 0.460},
    "mistake_load_150": {"vertical_load": 150000.0},
    "mistake_load_180": {"vertical_load": 180000.0},
    "mistake_load_of_one_wheel": {"vertical_load": 82309.0},
    "mistake_gravity_missing": {"vertical_load": LOAD - MASS*G},
    "mistake_mass_1500": {"mass": 1500.0, "vertical_load": LOAD + 68*G},
    "mistake_mass_1600": {"mass": 1600.0, "vertical_load": LOAD - 32*G},
    "mistake_mass_1000": {"mass": 1000.0},
    "mistake_load_with_inertia": {"mass": MASS + LOAD/G, "vertical_load": 0.0},
    "mistake_roll_inertia_600": {"roll_inertia": 600.0},
    "mistake_roll_inertia_is_pitch_inertia": {"roll_inertia": PITCH_INERTIA},
    "mistake_back_to_back_1360": {"back_to_back": 1.360},
    "mistake_gauge_1432": {"gauge": 1.432},
    "mistake_gauge_at_the_top": {"gauge_depth": 0.005},
    "mistake_soft_steel": {"youngs_modulus": 2.1e10},
    "mistake_modulus_of_one_body": {"stiffness_scale": 2.0},
    "mistake_rail_of_the_other_pair": {"rail_profile": "profiles/srprof.yz"},
    "mistake_start_ten_percent_faster": {"vY": 0.55, "roll_rate": 0.01833},
    "mistake_start_ten_times_slower": {"vY": 0.05, "roll_rate": 0.001667},
    "mistake_roll_rate_missing": {"roll_rate": 0.0},
    "mistake_roll_rate_reversed": {"roll_rate": -0.0333},
    "mistake_start_1_mm_aside": {"Y": 0.001},
    "mistake_start_sunk_in": {"Z": -0.0005},
    "mistake_ramp_4": {"lateral_ramp": 4000.0},
    "mistake_ramp_6": {"lateral_ramp": 6000.0},
    "mistake_ramp_starts_at_50_kN": {"lateral_force": 50000.0},
    "mistake_numerical_damping": {"order": 2, "beta": 0.49, "gamma": 0.9, "dt": 1e-4, "energy_tolerance": 0.0},
    "mistake_numerical_damping_mild": {"order": 2, "beta": 0.3025, "gamma": 0.6, "dt": 1e-4, "energy_tolerance": 0.0},
    "mistake_spliced_to_a_slower_run": {"vY": 0.4, "roll_rate": 0.01333},
}
RUN_CASES = {
    "mistake_rail_of_the_other_pair": ACTUAL,
    "mistake_start_ten_percent_faster": ("ex2_aw", "ex2_sw"),
    "mistake_start_ten_times_slower": ("ex2_aw", "ex2_sw"),
    "mistake_roll_rate_missing": FREE,
    "mistake_roll_rate_reversed": ("ex3_aw", "ex3_sw"),
    "mistake_start_1_mm_aside": FREE,
    "mistake_start_sunk_in": FREE,
    "mistake_ramp_4": ("ex5_aw", "ex5_sw"),
    "mistake_ramp_6": ("ex5_aw", "ex5_sw"),
    "mistake_ramp_starts_at_50_kN": ("ex5_aw", "ex5_sw"),
    "mistake_numerical_damping": FREE,
    "mistake_numerical_damping_mild": FREE,
    "mistake_spliced_to_a_slower_run": ("ex2_aw", "ex2_sw"),
}


# ------------------------------------------------------------------------- mistakes: rolling radius and angles

@_each
def mistake_radius_left_and_right_exchanged(frame):
    """The participant exchanged the rolling radii of the left and the right wheel."""
    _swap(frame, "LT", "RT", ["radius"])
    _swap(frame, "LF", "RF", ["radius"])


@_each
def mistake_radius_always_nominal(frame):
    """The participant wrote the nominal rolling radius for every closed contact."""
    for name in _of(["radius"]):
        frame[name] = frame[name].where(frame[name].isna(), 0.457)


@_each
def mistake_radius_of_tread_for_flange(frame):
    """The participant took the tread's radius for the flange, which reaches 10 mm deeper."""
    for flange in ("LF", "RF"):
        frame[f"radius_{flange}"] = frame[f"radius_{flange}"].where(frame[f"radius_{flange}"].isna(), 0.457)


@_each
def mistake_radius_is_distance_to_the_centre(frame):
    """The participant took the distance from the centre of gravity, not from the axle's axis, as rolling radius."""
    for c in CONTACTS:
        frame[f"radius_{c}"] = np.hypot(frame[f"radius_{c}"], frame[f"y_{c}"] - frame["Y"])


# ---------------------------------------------------------------------------------- mistakes: wrong input data

def mistake_pairs_exchanged(frames):
    """The participant exchanged the names of the files of actual and simplified profiles."""
    def other(case):
        return case[:4] + {"aw": "sw", "sw": "aw"}[case[4:]]
    return _files({other(case): frame for case, frame in frames.items()})


def mistake_exercises_3_and_4_exchanged(frames):
    """The participant exchanged the files of exercises 3 and 4."""
    other = {"ex3": "ex4", "ex4": "ex3"}
    return _files({other.get(case[:3], case[:3]) + case[3:]: frame for case, frame in frames.items()})


def _mirror(frame):
    """The motion to the other side."""
    _swap(frame, "LT", "RT")
    _swap(frame, "LF", "RF")
    frame[["Y", "vY", "aY", "roll", "roll_rate", "roll_acc"] + _of(["Fy", "y"])] *= -1.0
    frame[["PE_elastic_L", "PE_elastic_R"]] = frame[["PE_elastic_R", "PE_elastic_L"]].to_numpy()


# ------------------------------------------------------------------------------------- mistakes: wrong physics

def mistake_spliced_to_a_slower_run(frames, runs):
    """The participant's contact loses 36 % of the energy at the turning point of the first impact."""
    def splice(fast, slow):
        a, b = (int(np.argmax(f["Y"].to_numpy())) for f in (fast, slow))
        rest = slow.iloc[b + 1:].copy()
        rest["time"] += fast["time"].iloc[a] - slow["time"].iloc[b]
        return pd.concat([fast.iloc[:a + 1], rest], ignore_index=True)
    return _files({case: splice(f, runs[case]) if case in runs and case[:3] == "ex2" else f for case, f in frames.items()})


@_each
def mistake_damper_in_the_contact_force(frame):
    """The participant added a damper of 100 kN s/m to the normal force, which the call excludes, at the given motion."""
    for c in CONTACTS:
        closed = frame[f"N_{c}"] > 1.0
        inwards = -1.0 if c[0] == "L" else 1.0
        angle = frame[f"angle_{c}"]
        vy = frame["vY"] - frame["roll_rate"]*(frame[f"z_{c}"] - frame["Z"] - _axle_height(frame))
        vz = frame["vZ"] + frame["roll_rate"]*(frame[f"y_{c}"] - frame["Y"])
        leaving = vy*inwards*np.sin(angle) + vz*np.cos(angle)
        force = (frame[f"N_{c}"] - 1e5*leaving).clip(lower=0.0).where(closed, 0.0)
        frame[f"N_{c}"] = force
        frame[f"Fy_{c}"] = (inwards*np.sin(angle)*force).where(closed, 0.0)
        frame[f"Fz_{c}"] = (np.cos(angle)*force).where(closed, 0.0)


def _friction(frame, coefficient):
    """Lateral friction against the lateral velocity of each contact point; gives its sum."""
    total = np.zeros(len(frame))
    for c in CONTACTS:
        slip = frame["vY"] + 0.457*frame["roll_rate"]
        force = -coefficient*frame[f"N_{c}"]*np.sign(slip)
        frame[f"Fy_{c}"] += force
        total += force.to_numpy()
    return total


@_each
def mistake_friction_in_the_forces(frame):
    """The participant left a friction coefficient of 0.1 in, which shows in lateral forces, not in the motion."""
    _friction(frame, 0.1)


def mistake_friction_in_the_motion(frames):
    """The participant left a friction coefficient of 0.002 in, which also slows the lateral motion of exercises 1 to 4."""
    def change(frame):
        extra, t = _friction(frame, 0.002)/MASS, frame["time"].to_numpy()
        frame["aY"] += extra
        slower = _sum(t, extra)
        frame["vY"] += slower
        frame["Y"] += _sum(t, slower)
        frame["KE_lat"] = 0.5*MASS*frame["vY"]**2
    return {**_files(frames), **_changed({case: f for case, f in frames.items() if case[:3] != "ex5"}, change)}


# ----------------------------------------------------------------------------- mistakes: time and rows

@_each
def mistake_4_ms_of_the_first_impact_cut_out(frame):
    """The participant lost 4 ms of rows at the peak of the first impact of the left flange; times stay right."""
    t, (start, end) = frame["time"], _first_impact(frame)
    peak = t.iloc[start + int(np.argmax(frame["N_LF"].to_numpy()[start:end]))]
    return frame[(t < peak - 0.002) | (t > peak + 0.002)]


@_each
def mistake_4_ms_of_the_first_impact_spliced(frame):
    """The participant lost 4 ms of rows at the peak of the first impact, and closed the gap in the times."""
    t, (start, end) = frame["time"], _first_impact(frame)
    peak = t.iloc[start + int(np.argmax(frame["N_LF"].to_numpy()[start:end]))]
    late = t > peak + 0.002
    frame.loc[late, "time"] = t[late] - 0.004
    return frame[(t < peak - 0.002) | late]


@_each
def mistake_first_5_ms_missing(frame):
    """The participant cut the first 5 ms off and counts time from there."""
    rest = frame[frame["time"] >= 0.005].copy()
    rest["time"] -= rest["time"].iloc[0]
    return rest


@_each
def mistake_forces_averaged_over_1_ms(frame):
    """The participant averaged all forces of contacts over 1 ms, and nothing else."""
    for name in _of(["N", "Fy", "Fz"]):
        frame[name] = _mean_over(frame["time"].to_numpy(), frame[name].to_numpy(), 1e-3)


@_each
def mistake_accelerations_averaged_over_5_ms(frame):
    """The participant filtered accelerations with a running mean of 5 ms, as measurements are filtered."""
    for name in ("aY", "aZ", "roll_acc"):
        frame[name] = _mean_over(frame["time"].to_numpy(), frame[name].to_numpy(), 5e-3)


@_each
def mistake_forces_2_ms_late(frame):
    """The participant's forces come 2 ms later than the motion, from a delayed channel."""
    t = frame["time"].to_numpy()
    rows = np.searchsorted(t, t - 2e-3).clip(0, len(t) - 1)
    frame[_of(["N", "Fy", "Fz"])] = frame[_of(["N", "Fy", "Fz"])].to_numpy()[rows]


# ------------------------------------------------------------------------ mistakes: bookkeeping of the contacts

@_each
def mistake_wheel_total_in_the_tread(frame):
    """The participant wrote the sum of tread and flange as the tread's vertical force and kept the flange's, too."""
    for side in "LR":
        frame[f"Fz_{side}T"] += frame[f"Fz_{side}F"]


@_each
def mistake_lateral_and_vertical_force_exchanged(frame):
    """The participant exchanged lateral and vertical force of all contacts."""
    for c in CONTACTS:
        frame[[f"Fy_{c}", f"Fz_{c}"]] = frame[[f"Fz_{c}", f"Fy_{c}"]].to_numpy()


@_each
def mistake_forces_along_the_contact_plane(frame):
    """The participant resolved forces in the plane of the contact, so the lateral ones are zero without friction."""
    for c in CONTACTS:
        frame[f"Fy_{c}"], frame[f"Fz_{c}"] = 0.0, frame[f"N_{c}"]


@_each
def mistake_closed_force_kept_after_opening(frame):
    """The participant's open flanges keep the last force of the contact instead of zero."""
    closed = {c: frame[f"N_{c}"] > 1.0 for c in ("LF", "RF")}
    for c, is_closed in closed.items():
        for q in ("N", "Fy", "Fz"):
            frame[f"{q}_{c}"] = frame[f"{q}_{c}"].where(is_closed).ffill().fillna(0.0)


@_each
def mistake_contact_points_in_the_wheelset(frame):
    """The participant measured lateral positions of contact points from the wheelset's centre, not the track's."""
    for c in CONTACTS:
        frame[f"y_{c}"] -= frame["Y"]


@_each
def mistake_flange_point_at_the_gauge_corner(frame):
    """The participant wrote a fixed point, 14 mm below the top at half the gauge, for flange contacts."""
    for c, sign in (("LF", 1.0), ("RF", -1.0)):
        frame[f"y_{c}"] = frame[f"y_{c}"].where(frame[f"y_{c}"].isna(), sign*1.4351/2)
        frame[f"z_{c}"] = frame[f"z_{c}"].where(frame[f"z_{c}"].isna(), -0.014)


# ------------------------------------------------------------------- mistakes: energies, columns, missing things

def mistake_columns_moved_by_one(frames):
    """The participant's header lacks the name of the vertical velocity, so later names stand one column too early."""
    def shifted(text):
        head, body = text.split("\n", 1)
        return head.replace("vertical velocity [m/s],", "") + ",spare [m]\n" + body
    return {name: shifted(text) for name, text in _files(frames).items()}


@_each
def mistake_flange_positions_all_zero(frame):
    """The participant's file has position, angle and radius of the flanges zero in all rows."""
    frame[_of(["angle", "y", "z", "radius"], ("LF", "RF"))] = 0.0


def mistake_overflow_stars(frames):
    """The participant's format is too narrow for the largest forces, which Fortran prints as stars."""
    def stars(value):
        return f"{value:8.0f}" if abs(value) < 3e5 else "********"
    def text(frame):
        lines = _form(frame, sep=" ", names=SHORT, head="two lines").split("\n")
        for i in range(2, len(lines) - 1):
            numbers = lines[i].split(" ")
            for j, name in enumerate(ALL):
                if name.startswith(("N_", "Fy_", "Fz_")):
                    numbers[j] = stars(float(numbers[j]))
            lines[i] = " ".join(numbers)
        return "\n".join(lines)
    return {f"{case}.txt": text(frame) for case, frame in frames.items()}


# -------------------------------------------------------------------------------------------- faultless: units

def faultless_contact_angles_in_degrees_roll_in_mrad(frames):
    """Contact angles in degrees and the roll angle in milliradians, in one file."""
    degrees = {f"angle_{c}": ("deg", 180/np.pi) for c in CONTACTS}
    return _files(frames, units={**degrees, "roll": ("mrad", 1e3)})


# -------------------------------------------------------------------------------------------- faultless: signs

RIGHT = ("Y", "vY", "aY") + tuple(_of(["Fy", "y"]))
DOWN = ("Z", "vZ", "aZ") + tuple(_of(["Fz", "z"]))
ROLL = ("roll", "roll_rate", "roll_acc")


def faultless_lateral_forces_on_the_rail_outwards(frames):
    """Lateral forces on the rail, positive outwards on either side, as the header says."""
    names = {f"Fy_{c}": f"{SIDE[c[0]]} {PART[c[1]]} lateral force on the rail, outwards positive" for c in CONTACTS}
    names = {name: text.replace(",", " -") for name, text in names.items()}
    return _files(frames, names={**PLAIN, **names}, signs=_of(["Fy"], ("LT", "LF")))


# ------------------------------------------------------------------------------------ faultless: zeros, origins

def faultless_contact_points_from_the_gauge_side(frames):
    """Lateral positions of contact points are measured from each rail's gauge line, half the gauge off the centre."""
    offset = {f"y_{c}": (-1 if c[0] == "L" else 1)*1.4351/2 for c in CONTACTS}
    return _files(frames, offset=offset)


# -------------------------------------------------------------------------------------------- faultless: names

def faultless_names_of_the_trade(frames):
    """wl.flange.N [kN], .Q, .Y, wheelset.vert_disp [mm]."""
    motion = dict(zip(MOTION, ("lat_disp", "vert_disp", "roll", "lat_vel", "vert_vel", "roll_vel", "lat_acc",
                               "vert_acc", "roll_acc"), strict=False))
    motion = {**ENGLISH, **{name: "wheelset." + text for name, text in motion.items()}}
    point = {"angle": "gamma", "N": "N", "Fy": "Y", "Fz": "Q", "y": "y_cp", "z": "z_cp", "radius": "r"}
    names = _names(motion, point, {"L": "wl", "R": "wr"}, form="{side}.{part}.{quantity}")
    return _files(frames, names=names, units=MM_KN)


def faultless_symbols(frames):
    """The call's symbols: Y, Z, Phi, dY/dt, d2Y/dt2; N_lt, delta_lf."""
    motion = {**ENGLISH, "time": "t", "Y": "Y", "Z": "Z", "roll": "Phi", "vY": "dY/dt", "vZ": "dZ/dt",
              "roll_rate": "dPhi/dt", "aY": "d2Y/dt2", "aZ": "d2Z/dt2", "roll_acc": "d2Phi/dt2"}
    point = {"angle": "delta", "N": "N", "Fy": "Fy", "Fz": "Fz", "y": "yc", "z": "zc", "radius": "rc"}
    names = _names(motion, point, {"L": "l", "R": "r"}, {"T": "t", "F": "f"}, "{quantity}_{side}{part}")
    return _files(frames, names=names, units=MM_KN)


def faultless_dotted_symbols(frames):
    """y, yp, ypp for the displacement and its rates."""
    motion = {**ENGLISH, "Y": "y", "Z": "z", "roll": "phi", "vY": "yp", "vZ": "zp", "roll_rate": "phip",
              "aY": "ypp", "aZ": "zpp", "roll_acc": "phipp"}
    return _files(frames, names={**PLAIN, **motion})


FRENCH = _names(
    {"time": "temps", "Y": "déplacement latéral", "Z": "déplacement vertical", "roll": "angle de roulis",
     "vY": "vitesse latérale", "vZ": "vitesse verticale", "roll_rate": "vitesse de roulis",
     "aY": "accélération latérale", "aZ": "accélération verticale", "roll_acc": "accélération de roulis",
     "KE_lat": "énergie cinétique latérale", "KE_vert": "énergie cinétique verticale",
     "KE_roll": "énergie cinétique de roulis", "PE_grav": "énergie potentielle de pesanteur",
     "PE_load": "énergie potentielle de la charge", "PE_elastic_L": "énergie élastique gauche",
     "PE_elastic_R": "énergie élastique droite"},
    {"angle": "angle de contact", "N": "effort normal", "Fy": "effort latéral", "Fz": "effort vertical",
     "y": "position latérale du contact", "z": "position verticale du contact", "radius": "rayon de roulement"},
    {"L": "gauche", "R": "droite"}, {"T": "table", "F": "boudin"}, "{quantity} {part} roue {side}")
GERMAN = _names(
    {"time": "Zeit", "Y": "Querverschiebung", "Z": "Vertikalverschiebung", "roll": "Wankwinkel",
     "vY": "Quergeschwindigkeit", "vZ": "Vertikalgeschwindigkeit", "roll_rate": "Wankgeschwindigkeit",
     "aY": "Querbeschleunigung", "aZ": "Vertikalbeschleunigung", "roll_acc": "Wankbeschleunigung",
     "KE_lat": "kinetische Energie quer", "KE_vert": "kinetische Energie vertikal",
     "KE_roll": "kinetische Energie Wanken", "PE_grav": "potentielle Energie Gewicht",
     "PE_load": "potentielle Energie Last", "PE_elastic_L": "elastische Energie links",
     "PE_elastic_R": "elastische Energie rechts"},
    {"angle": "Kontaktwinkel", "N": "Normalkraft", "Fy": "Querkraft", "Fz": "Radkraft",
     "y": "Kontaktpunkt quer", "z": "Kontaktpunkt Höhe", "radius": "Rollradius"},
    {"L": "links", "R": "rechts"}, {"T": "Lauffläche", "F": "Spurkranz"}, "{quantity} {part} {side}")


def faultless_french_without_accents(frames):
    """French names without accents, blanks as underscores, columns by tabs."""
    plain = str.maketrans("éèêôâ", "eeeoa")
    names = {name: text.translate(plain).replace(" ", "_") for name, text in FRENCH.items()}
    return _files(frames, names=names, sep="\t", name="{case}.txt")


def faultless_german_Q_and_Y(frames):
    """German names, Q for the vertical and Y for the guiding force: 'Radkraft Q', 'Führungskraft Y'."""
    names = {**GERMAN}
    for c in CONTACTS:
        side, part = {"L": "links", "R": "rechts"}[c[0]], {"T": "Lauffläche", "F": "Spurkranz"}[c[1]]
        names[f"Fz_{c}"], names[f"Fy_{c}"] = f"Radkraft Q {part} {side}", f"Führungskraft Y {part} {side}"
    return _files(frames, names=names, units=MM_KN, sep=";")


def faultless_numbers_for_sides(frames):
    """Wheel 1 is the left one, wheel 2 the right one; contact 1 the tread, contact 2 the flange; a comment says so."""
    names = _names(ENGLISH, ENGLISH_POINT, {"L": "1", "R": "2"}, {"T": "1", "F": "2"},
                   "{quantity} wheel {side} contact {part}")
    return _files(frames, names=names, before="# wheel 1 left - wheel 2 right - contact 1 tread - contact 2 flange\n")


def faultless_capitals(frames):
    """All names in capitals, 16 characters at most, as old Fortran codes have them."""
    point = {"angle": "ANG", "N": "FN", "Fy": "FY", "Fz": "FZ", "y": "YC", "z": "ZC", "radius": "RR"}
    motion = dict(zip(ALL, ("TIME", "YDISP", "ZDISP", "ROLL", "YVEL", "ZVEL", "ROLLVEL", "YACC", "ZACC", "ROLLACC"), strict=False))
    energy = dict(zip(ENERGY, ("EKY", "EKZ", "EKROLL", "EPGRAV", "EPLOAD", "EELASTL", "EELASTR"), strict=False))
    names = _names({**motion, **energy}, point, {"L": "LEFT", "R": "RIGHT"}, {"T": "TREAD", "F": "FLANGE"},
                   "{quantity}_{part}_{side}")
    return _files(frames, names=names, head="two lines", sep=" ", name="{case}.out")


# -------------------------------------------------------------------------------- faultless: separators, headers

def _padded(text, width):
    """Right-justified words of each line, by the first character's run of blanks."""
    return "".join("".join(word.rjust(width) for word in line.split(" ")) + "\n" for line in text.splitlines())


def faultless_quoted_names_with_commas(frames):
    """Names in quotation marks that contain the separator: "normal force, left flange [N]"."""
    names = {f"{q}_{c}": f"{ENGLISH_POINT[q]}, {SIDE[c[0]]} {PART[c[1]]}" for c in CONTACTS for q in POINT}
    return _files(frames, names={**ENGLISH, **names}, head="quoted")


def faultless_ten_lines_of_report(frames):
    """Ten lines of free text, with numbers, stand above the names without any comment sign."""
    text = ("WHEELSET DYNAMICS PROGRAM, VERSION 4.2\nDate: 2006-06-12\n\nLD benchmark, exercise of the call\n"
            "Mass 1568 kg, roll inertia 656 kg.m2\nLoad 164.618 kN, g = 9.81 m/s2\nStep 1.0E-5 s\n"
            "Contacts: Hertz\nOutput every 0.1 ms\n\n")
    return _files(frames, before=text)


@_text
def faultless_table_of_columns_in_the_header(frame):
    """A numbered list of the columns in comments says names and units; names in the table are c1, c2, c3."""
    units = {**SI, **MM_KN}
    lines = [f"# column {i:2d}: {PLAIN[name]} [{units[_kind(name)][0]}]\n" for i, name in enumerate(ALL, 1)]
    names = {name: f"c{i}" for i, name in enumerate(ALL, 1)}
    return _form(frame, names=names, head="names", units=units, before="".join(lines))


@_text
def faultless_blank_lines(frame):
    """Blank lines stand above the names, below them and at the end."""
    head, body = _form(frame).split("\n", 1)
    return f"\n\n{head}\n\n{body}\n\n"


# ------------------------------------------------------------------------------- faultless: numbers, open contacts

def _open_as(frame, value):
    """Position, angle and radius of open contacts have a value."""
    return frame.assign(**{name: frame[name].fillna(value) for name in _of(["angle", "y", "z", "radius"])})


def faultless_open_contacts_minus_999_in_mm(frames):
    """Open contacts have -999 in the file's units, which are mm and degrees."""
    units = {**MM_KN, "angle": ("deg", 180/np.pi)}
    return {f"{case}.csv": _form(f, units=units, na="-999") for case, f in frames.items()}


def faultless_open_contacts_all_blank(frames):
    """Open contacts have empty cells for forces, too."""
    def change(frame):
        for c in CONTACTS:
            is_open = ~(frame[f"N_{c}"] > 0.0)
            for q in ("N", "Fy", "Fz"):
                frame[f"{q}_{c}"] = frame[f"{q}_{c}"].mask(is_open)
    return _changed(frames, change, na="")


@_each
def faultless_open_contacts_keep_the_last_place(frame):
    """Open contacts have zero forces, and keep position, angle and radius of the last contact; first ones have zero."""
    for name in _of(["angle", "y", "z", "radius"]):
        frame[name] = frame[name].ffill().fillna(0.0)


def faultless_exponents_without_E(frames):
    """Zeros are 1.0000000-120, as gfortran prints exponents of three digits without E."""
    def text(frame):
        body = _form(frame.mask(frame == 0.0, 1e-120), sep=" ", digits="%.7E", names=SHORT, head="two lines")
        return re.sub(r"E([+-]\d{3})", r"\1", body)
    return {f"{case}.txt": text(frame) for case, frame in frames.items()}


def faultless_exponents_with_D(frames):
    """Double precision of Fortran: 1.00000000D-03."""
    def text(frame):
        return re.sub(r"(\d)E([+-]\d)", r"\1D\2", _form(frame, sep=" ", digits="%.10E", names=SHORT, head="two lines"))
    return {f"{case}.txt": text(frame) for case, frame in frames.items()}


@_text
def faultless_numbers_without_leading_zero(frame):
    """.5 and -.5 for 0.5 and -0.5, as some Fortran compilers print."""
    return re.sub(r"(^|,)(-?)0\.(?=\d)", r"\1\2.", _form(frame, digits="%.10f"), flags=re.M)


# ------------------------------------------------------------------------------------------- faultless: rows

@_each
def faultless_variable_step(frame):
    """All rows while a flange is closed and 2 ms around it, else every second row."""
    t = frame["time"].to_numpy()
    closed = (frame["N_LF"].to_numpy() > 0) | (frame["N_RF"].to_numpy() > 0)
    near = _mean_over(t, closed.astype(float), 4e-3) > 0
    return frame[near | (np.arange(len(t)) % 2 == 0) | (np.arange(len(t)) == len(t) - 1)]


@_each
def faultless_events_twice(frame):
    """Rows at which a contact closes or opens stand in the file twice, with the same time."""
    closed = frame[["N_LT", "N_LF", "N_RT", "N_RF"]].to_numpy() > 0
    event = np.concatenate([[False], (closed[1:] != closed[:-1]).any(axis=1)])
    return frame.loc[frame.index.repeat(1 + event)].reset_index(drop=True)


# -------------------------------------------------------------------------------- faultless: columns and encodings

def faultless_columns_by_contact(frames):
    """Columns ordered by contact, right before left, motion at the end."""
    order = ["time"] + _of(POINT, ("RF", "RT", "LF", "LT")) + list(MOTION) + list(ENERGY)
    return _files(frames, order=order)


def faultless_columns_in_any_order(frames):
    """Columns in an order without a rule; time is not the first."""
    order = list(np.random.default_rng(7).permutation(ALL))
    return _files(frames, order=order)


@_text
def faultless_row_numbers(frame):
    """The first column counts the rows and has an empty name, as pandas writes an index."""
    head, *rows = _form(frame).splitlines()
    return "\n".join(["," + head, *(f"{i},{row}" for i, row in enumerate(rows))]) + "\n"


@_text
def faultless_extra_columns(frame):
    """Creepages and creep forces that are zero, the pitch, and the forward speed stand in further columns."""
    extra = [("pitch angle", "rad", frame["pitch"]), ("forward speed", "m/s", 1.0), ("yaw angle", "rad", 0.0)]
    extra += [(f"{SIDE[c[0]]} {PART[c[1]]} {what}", unit, 0.0) for c in CONTACTS
              for what, unit in (("creepage x", "-"), ("creepage y", "-"), ("spin", "1/m"), ("creep force", "N"))]
    return _form(frame, extra=extra)


@_text
def faultless_wheel_totals(frame):
    """Sums over each wheel, Q and Y and L/V, stand beside the forces of its contacts."""
    extra = []
    for side, word in SIDE.items():
        vertical, lateral = (frame[f"{q}_{side}T"] + frame[f"{q}_{side}F"] for q in ("Fz", "Fy"))
        ratio = (lateral.abs()/vertical.where(vertical > 1.0)).fillna(0.0)
        extra += [(f"{word} wheel Q", "N", vertical), (f"{word} wheel Y", "N", lateral),
                  (f"{word} wheel L/V", "-", ratio)]
    return _form(frame, extra=extra)


@_text
def faultless_constraint_forces(frame):
    """The moments of the yaw constraint and total energies stand in further columns."""
    kinetic = frame[["KE_lat", "KE_vert", "KE_roll"]].sum(axis=1)
    potential = frame[["PE_grav", "PE_load", "PE_elastic_L", "PE_elastic_R"]].sum(axis=1)
    return _form(frame, extra=[("yaw constraint moment", "N.m", frame["M_gyro"]), ("kinetic energy", "J", kinetic),
                               ("potential energy", "J", potential), ("total energy", "J", kinetic + potential)])


@_text
def faultless_sums_of_energies_only(frame):
    """Only kinetic, potential and total energy are given, as sums."""
    kinetic = frame[["KE_lat", "KE_vert", "KE_roll"]].sum(axis=1)
    potential = frame[["PE_grav", "PE_load", "PE_elastic_L", "PE_elastic_R"]].sum(axis=1)
    return _form(frame, order=CALL, extra=[("kinetic energy", "J", kinetic), ("potential energy", "J", potential),
                                           ("total energy", "J", kinetic + potential)])


def faultless_utf_16(frames):
    """UTF-16 with a byte order mark and tabs, as Excel saves 'Unicode text' (bytes)."""
    files = _files(frames, names=GERMAN, sep="\t", eol="\r\n", name="{case}.txt")
    return {name: text.encode("utf-16") for name, text in files.items()}


# ----------------------------------------------------------------------------------------- whole naming styles

def style_simpack(frame):
    """SIMPACK-like: $B_Wheelset.pos.y in brackets of units, wheel-rail pairs with contact patches, tabs."""
    motion = dict(zip(ALL, ("time", "$B_WS.pos.y", "$B_WS.pos.z", "$B_WS.ang.al", "$B_WS.vel.y", "$B_WS.vel.z",
                            "$B_WS.omega.al", "$B_WS.acc.y", "$B_WS.acc.z", "$B_WS.omega_dot.al"), strict=False))
    energy = dict(zip(ENERGY, (f"$E.{x}" for x in ("kin.y", "kin.z", "kin.al", "pot.grav", "pot.load", "pot.RWP_L",
                                                   "pot.RWP_R")), strict=False))
    point = {"angle": "Contact_angle", "N": "Normal_force", "Fy": "Lateral_force_track", "Fz": "Vertical_force_track",
             "y": "Contact_pos_y_track", "z": "Contact_pos_z_track", "radius": "Rolling_radius"}
    names = _names({**motion, **energy}, point, {"L": "Left", "R": "Right"}, {"T": "Tread", "F": "Flange"},
                   "$RWP_{side}.Patch_{part}.{quantity}")
    return _form(frame, names=names, sep="\t", head="brackets")


def style_nucars(frame):
    """NUCARS-like: capitals, inches, pounds and g, Y to the left, fixed width, units in a line of their own."""
    motion = dict(zip(ALL, ("TIME", "AXLE1_Y_DISP", "AXLE1_Z_DISP", "AXLE1_ROLL", "AXLE1_Y_VEL", "AXLE1_Z_VEL",
                            "AXLE1_ROLL_VEL", "AXLE1_Y_ACC", "AXLE1_Z_ACC", "AXLE1_ROLL_ACC"), strict=False))
    energy = dict(zip(ENERGY, ("KE_LATERAL", "KE_VERTICAL", "KE_ROLL", "PE_GRAVITY", "PE_LOAD", "PE_CONTACT_LEFT",
                               "PE_CONTACT_RIGHT"), strict=False))
    point = {"angle": "CONT_ANGLE", "N": "NORMAL", "Fy": "LATERAL", "Fz": "VERTICAL", "y": "CONT_Y", "z": "CONT_Z",
             "radius": "ROLL_RADIUS"}
    names = _names({**motion, **energy}, point, {"L": "LEFT", "R": "RIGHT"}, {"T": "TREAD", "F": "FLANGE"},
                   "AXLE1_{side}_{part}_{quantity}")
    units = {"length": ("in", 1/0.0254), "speed": ("in/s", 1/0.0254), "acc": ("g", 1/9.80665),
             "force": ("lbf", 1/4.4482216152605)}
    return _padded(_form(_open_as(frame, 0.0), names=names, units=units, sep=" ", head="two lines"), 32)


def style_vampire(frame):
    """VAMPIRE-like: words and units in parentheses, mm, kN, Z down, Y to the right, mrad, forces on the rail."""
    motion = dict(zip(ALL, ("Time", "Wheelset 1 Lateral Displacement", "Wheelset 1 Vertical Displacement",
                            "Wheelset 1 Roll Displacement", "Wheelset 1 Lateral Velocity",
                            "Wheelset 1 Vertical Velocity", "Wheelset 1 Roll Velocity",
                            "Wheelset 1 Lateral Acceleration", "Wheelset 1 Vertical Acceleration",
                            "Wheelset 1 Roll Acceleration"), strict=False))
    point = {"angle": "Contact Angle", "N": "Normal Force", "Fy": "Lateral Force (track)", "Fz": "Vertical Force (track)",
             "y": "Contact Lateral Position", "z": "Contact Vertical Position", "radius": "Rolling Radius"}
    names = _names({**ENGLISH, **motion}, point, {"L": "LH", "R": "RH"}, {"T": "Tread", "F": "Flange"},
                   "Wheelset 1 {side} {part} {quantity}")
    units = {**MM_KN, "angle": ("mrad", 1e3), "spin": ("mrad/s", 1e3)}
    on_rail = RIGHT[:3] + tuple(_of(["y"])) + DOWN[:3] + tuple(_of(["z"]))        # both turns cancel for forces
    return _form(frame, names=names, units=units, signs=on_rail, head="parens")


def style_vi_rail(frame):
    """VI-Rail-like: request names with dots, mm, N, degrees, quoted, blanks for open contacts."""
    motion = dict(zip(ALL, ("TIME", "wheelset_disp.lateral", "wheelset_disp.vertical", "wheelset_disp.roll",
                            "wheelset_vel.lateral", "wheelset_vel.vertical", "wheelset_vel.roll",
                            "wheelset_acc.lateral", "wheelset_acc.vertical", "wheelset_acc.roll"), strict=False))
    energy = dict(zip(ENERGY, ("energy.kinetic_lateral", "energy.kinetic_vertical", "energy.kinetic_roll",
                               "energy.potential_gravity", "energy.potential_load", "energy.elastic_left",
                               "energy.elastic_right"), strict=False))
    point = {"angle": "contact_angle", "N": "normal_force", "Fy": "lateral_force", "Fz": "vertical_force",
             "y": "contact_y", "z": "contact_z", "radius": "rolling_radius"}
    names = _names({**motion, **energy}, point, {"L": "lef", "R": "rig"}, {"T": "tread", "F": "flange"},
                   "{side}_wheel_{part}.{quantity}")
    degree = 180/np.pi
    units = {"length": ("mm", 1e3), "speed": ("mm/s", 1e3), "acc": ("mm/s2", 1e3), "angle": ("deg", degree),
             "spin": ("deg/s", degree), "spinacc": ("deg/s2", degree)}
    return _form(frame, names=names, units=units, head="quoted", na="")


def style_gensys(frame):
    """GENSYS-like: axl_111.y, cp_111l1.N, Y to the right and Z down, forces on the rail, blanks, a line of units."""
    motion = dict(zip(ALL, ("time", "axl_111.y", "axl_111.z", "axl_111.f", "axl_111.vy", "axl_111.vz", "axl_111.vf",
                            "axl_111.ay", "axl_111.az", "axl_111.af"), strict=False))
    energy = dict(zip(ENERGY, ("axl_111.Eky", "axl_111.Ekz", "axl_111.Ekf", "axl_111.Epg", "axl_111.Epload",
                               "cp_111l.Eel", "cp_111r.Eel"), strict=False))
    point = {"angle": "cang", "N": "Fn", "Fy": "Fy", "Fz": "Fz", "y": "ycp", "z": "zcp", "radius": "rr"}
    names = _names({**motion, **energy}, point, {"L": "l", "R": "r"}, {"T": "t", "F": "f"},
                   "cp_111{side}{part}.{quantity}")
    on_rail = RIGHT[:3] + tuple(_of(["y"])) + DOWN[:3] + tuple(_of(["z"]))
    return _form(_open_as(frame, 0.0), names=names, signs=on_rail, sep=" ", head="two lines",
                 before="# cp_111lt left tread, cp_111lf left flange, cp_111rt right tread, cp_111rf right flange\n")


def style_french(frame):
    """An own French code: dep_y, vit_y, acc_y; N_bg for boudin gauche, N_td for table droite; decimal commas, mm, kN."""
    motion = dict(zip(ALL, ("temps", "dep_y", "dep_z", "roulis", "vit_y", "vit_z", "vit_roulis", "acc_y", "acc_z",
                            "acc_roulis"), strict=False))
    energy = dict(zip(ENERGY, ("Ec_lat", "Ec_vert", "Ec_roulis", "Ep_pesanteur", "Ep_charge", "Ep_gauche", "Ep_droite"),
                       strict=False))
    point = {"angle": "angle", "N": "N", "Fy": "Fy", "Fz": "Fz", "y": "y", "z": "z", "radius": "rayon"}
    names = _names({**motion, **energy}, point, {"L": "gauche", "R": "droit"}, {"T": "table", "F": "boudin"},
                   "{quantity}_{part}_{side}")
    return _form(frame, names=names, units=MM_KN, sep=";", decimal=",", head="two lines", na="")


def style_german(frame):
    """An own German code: y_RS, vy_RS, N_Spurkranz_li, Q_Laufflaeche_re; kN, mm, mrad, semicolons, decimal commas."""
    motion = dict(zip(ALL, ("Zeit", "y_Radsatz", "z_Radsatz", "Wankwinkel", "vy_Radsatz", "vz_Radsatz",
                            "Wankgeschw", "ay_Radsatz", "az_Radsatz", "Wankbeschl"), strict=False))
    energy = dict(zip(ENERGY, ("Ekin_quer", "Ekin_vertikal", "Ekin_Wanken", "Epot_Gewicht", "Epot_Last",
                               "Eelast_links", "Eelast_rechts"), strict=False))
    point = {"angle": "Kontaktwinkel", "N": "Normalkraft", "Fy": "Y_Kraft", "Fz": "Q_Kraft", "y": "y_Kontakt",
             "z": "z_Kontakt", "radius": "Rollradius"}
    names = _names({**motion, **energy}, point, {"L": "li", "R": "re"}, {"T": "Laufflaeche", "F": "Spurkranz"},
                   "{quantity}_{part}_{side}")
    units = {**MM_KN, "angle": ("mrad", 1e3), "spin": ("mrad/s", 1e3)}
    return _form(frame, names=names, units=units, sep=";", decimal=",", head="brackets", na="-999")


def style_matlab(frame):
    """A Matlab script: ydot, yddot, FnLT, gammaLF; names in a comment with %, SI without units, blanks."""
    motion = dict(zip(ALL, ("t", "y", "z", "phi", "ydot", "zdot", "phidot", "yddot", "zddot", "phiddot"), strict=False))
    energy = dict(zip(ENERGY, ("Tlat", "Tvert", "Troll", "Vgrav", "Vload", "VelL", "VelR"), strict=False))
    point = {"angle": "gamma", "N": "Fn", "Fy": "Fy", "Fz": "Fz", "y": "yc", "z": "zc", "radius": "r"}
    names = _names({**motion, **energy}, point, {"L": "L", "R": "R"}, {"T": "T", "F": "F"}, "{quantity}{side}{part}")
    return _form(frame, names=names, sep=" ", before="% ", head="names", digits="%.10e")


def style_spreadsheet(frame):
    """A spreadsheet: title, empty lines, quoted names in words with units, semicolons, decimal commas, CRLF, BOM."""
    names = _names({name: text.capitalize() for name, text in ENGLISH.items()},
                   {q: text.capitalize() for q, text in ENGLISH_POINT.items()}, form="{quantity} ({side} {part})")
    units = {**MM_KN, "angle": ("deg", 180/np.pi), "time": ("ms", 1e3)}
    return "\ufeff" + _form(frame, names=names, units=units, sep=";", decimal=",", head="quoted", na="", eol="\r\n",
                            before="LD benchmark;;;\n;;;\n")


def style_finite_elements(frame):
    """A finite element program: U2, U3, UR1 at node AXLE, CFN, CF2, CF3 of contact pairs, 1e30 for open contacts."""
    motion = dict(zip(ALL, ("TIME", "U2_N_AXLE", "U3_N_AXLE", "UR1_N_AXLE", "V2_N_AXLE", "V3_N_AXLE", "VR1_N_AXLE",
                            "A2_N_AXLE", "A3_N_AXLE", "AR1_N_AXLE"), strict=False))
    energy = dict(zip(ENERGY, ("ALLKE_2", "ALLKE_3", "ALLKE_R1", "ALLPE_GRAV", "ALLPE_LOAD", "ALLSE_LEFT",
                               "ALLSE_RIGHT"), strict=False))
    point = {"angle": "CANGLE", "N": "CFN", "Fy": "CF2", "Fz": "CF3", "y": "CCOOR2", "z": "CCOOR3", "radius": "CRADIUS"}
    names = _names({**motion, **energy}, point, {"L": "LEFT", "R": "RIGHT"}, {"T": "TREAD", "F": "FLANGE"},
                   "{quantity}_{side}_{part}")
    return _form(_open_as(frame, 1e30), names=names, sep=" ", head="names", digits="%14.6E",
                 before="** units: N, m, s, rad; 2 lateral (left), 3 vertical (up)\n")


STYLES = {name[len("style_"):]: function for name, function in list(globals().items()) if name.startswith("style_")}
MISTAKES = {name: function for name, function in list(globals().items()) if name.startswith("mistake_")} | {
    name: _runs for name in RUNS if name not in globals()} | {
    # The participant subtracted the heights the wrong way round, so all rolling radii are negative.
    "mistake_radius_negative": lambda frames: _changed(frames, _scale(_of(["radius"]), -1.0)),
    # The participant reported diameters as rolling radii.
    "mistake_radius_doubled": lambda frames: _changed(frames, _scale(_of(["radius"]), 2.0)),
    # The participant measured rolling radii from a wrong line of the profile, 5 mm too large.
    "mistake_radius_5_mm_too_large": lambda frames: _changed(frames, lambda frame: frame.update(frame[_of(["radius"])] + 0.005)),
    # The participant wrote rolling radii in millimetres below a header that says metres.
    "mistake_radius_in_mm_below_m": lambda frames: _changed(frames, _scale(_of(["radius"]), 1e3)),
    # The participant wrote rolling radii in inches below a header that says millimetres.
    "mistake_radius_in_inches_below_mm": lambda frames:
        _changed(frames, _scale(_of(["radius"]), 1/25.4), units={f"radius_{c}": ("mm", 1e3) for c in CONTACTS}),
    # The participant wrote the contact angle of the left flange alone with the opposite sign.
    "mistake_angle_of_left_flange_negative": lambda frames: _changed(frames, _scale(["angle_LF"], -1.0)),
    # The participant wrote the contact angle of the right tread alone with the opposite sign.
    "mistake_angle_of_right_tread_negative": lambda frames: _changed(frames, _scale(["angle_RT"], -1.0)),
    # The participant wrote contact angles in degrees below a header that says radians.
    "mistake_angles_in_degrees_below_rad": lambda frames: _changed(frames, _scale(_of(["angle"]), 180/np.pi)),
    # The participant measured the direction of the force from the horizontal instead of from the vertical.
    "mistake_angles_from_the_horizontal": lambda frames:
        _changed(frames, lambda frame: frame.update(np.pi/2 - frame[_of(["angle"])])),
    # The participant wrote the slope of the profile (tan) as the contact angle in radians.
    "mistake_slopes_for_angles": lambda frames: _changed(frames, lambda frame: frame.update(np.tan(frame[_of(["angle"])]))),
    # The participant measured contact angles from the rail's axis and counted the cant of 1:40 twice.
    "mistake_angles_from_the_canted_rail": lambda frames:
        _changed(frames, lambda frame: frame.update(frame[_of(["angle"])] - 1/40)),
    # The participant exchanged the contact angles of the left and the right flange.
    "mistake_angles_of_left_and_right_exchanged": lambda frames:
        _changed(frames, lambda frame: _swap(frame, "LF", "RF", ["angle"])),
    # The participant switched gravity off: the wheelset has no weight (run with a load less by the weight).
    "mistake_gravity_missing": lambda frames, runs:
        _runs(frames, {case: f.assign(PE_load=f["PE_load"] + f["PE_grav"], PE_grav=0.0) for case, f in runs.items()}),
    # The participant ran the actual wheel on the simplified rail.
    "mistake_rail_of_the_other_pair": lambda frames, runs: _runs(frames, runs, ACTUAL),
    # The participant ran the simplified profiles in both groups of files.
    "mistake_simplified_pair_as_actual": lambda frames:
        _files({case: frames.get(case.replace("_aw", "_sw"), frame) for case, frame in frames.items()}),
    # The participant sent the result of exercise 2 under the name of exercise 3, too.
    "mistake_exercise_2_sent_as_3": lambda frames:
        _files({case: frames.get(case.replace("ex3", "ex2"), frame) for case, frame in frames.items()}),
    # The participant started exercise 2 with 0.55 m/s.
    "mistake_start_ten_percent_faster": lambda frames, runs: _runs(frames, runs, RUN_CASES["mistake_start_ten_percent_faster"]),
    # The participant started exercise 2 with 0.05 m/s, and no flange is hit hard.
    "mistake_start_ten_times_slower": lambda frames, runs: _runs(frames, runs, RUN_CASES["mistake_start_ten_times_slower"]),
    # The participant started with a roll rate of zero, with elastic contacts.
    "mistake_roll_rate_missing": lambda frames, runs: _runs(frames, runs, FREE),
    # The participant started exercise 3 with the roll rate the wrong way round.
    "mistake_roll_rate_reversed": lambda frames, runs: _runs(frames, runs, RUN_CASES["mistake_roll_rate_reversed"]),
    # The participant started 1 mm to the left of the centre.
    "mistake_start_1_mm_aside": lambda frames, runs: _runs(frames, runs, FREE),
    # The participant started half a millimetre below equilibrium, so the treads bounce from the beginning.
    "mistake_start_sunk_in": lambda frames, runs: _runs(frames, runs, FREE),
    # The participant started to the right, Y still positive to the left, so the right flange is hit first.
    "mistake_start_to_the_right": lambda frames: _changed(frames, _mirror),
    # The participant let the lateral force of exercise 5 grow by 4 kN/s.
    "mistake_ramp_4": lambda frames, runs: _runs(frames, runs, RUN_CASES["mistake_ramp_4"]),
    # The participant let the lateral force of exercise 5 grow by 6 kN/s.
    "mistake_ramp_6": lambda frames, runs: _runs(frames, runs, RUN_CASES["mistake_ramp_6"]),
    # The participant started exercise 5 with a lateral force of 50 kN instead of zero.
    "mistake_ramp_starts_at_50_kN": lambda frames, runs: _runs(frames, runs, RUN_CASES["mistake_ramp_starts_at_50_kN"]),
    # The participant's integrator (Newmark, gamma 0.9, step 0.1 ms) damps every impact strongly.
    "mistake_numerical_damping": lambda frames, runs: _runs(frames, runs, FREE),
    # The participant's integrator (Newmark, gamma 0.6, step 0.1 ms) takes a few percent of the energy per impact.
    "mistake_numerical_damping_mild": lambda frames, runs: _runs(frames, runs, FREE),
    # The participant's times are all 5 % too long, and the rates are not changed.
    "mistake_time_stretched_by_5_percent": lambda frames: _changed(frames, _scale(["time"], 1.05)),
    # The participant wrote milliseconds below a header that says seconds.
    "mistake_time_in_ms_below_s": lambda frames: _changed(frames, _scale(["time"], 1e3)),
    # The participant wrote the number of the row times 0.1 ms as time, though rows stand closer at events.
    "mistake_time_is_the_row": lambda frames: _changed(frames, lambda frame: frame.assign(time=1e-4*np.arange(len(frame)))),
    # The participant's file ends at half of the run, after the left flange and before the return.
    "mistake_half_of_the_run_missing": lambda frames:
        _changed(frames, lambda frame: frame[frame["time"] <= frame["time"].iloc[-1]/2]),
    # The participant stopped exercise 5 after 40 s, at 200 kN and before the derailment.
    "mistake_exercise_5_stopped_at_40_s": lambda frames:
        _files({case: f[f["time"] <= 40.0] if case[:3] == "ex5" else f for case, f in frames.items()}),
    # The participant kept every row at a whole millisecond, too few for the impacts, without a filter.
    "mistake_rows_at_1_kHz": lambda frames: _changed(frames, lambda frame: _at(frame, 1e-3)),
    # The participant kept a row every 5 ms, as for vehicle dynamics: impacts fall between the rows.
    "mistake_rows_at_200_Hz": lambda frames: _changed(frames, lambda frame: _at(frame, 5e-3)),
    # The participant printed three digits of every number, of times also.
    "mistake_three_digits": lambda frames: _files(frames, digits="%.3g"),
    # The participant joined two halves of the file in the wrong order.
    "mistake_rows_in_the_wrong_order": lambda frames:
        _changed(frames, lambda f: pd.concat([f.iloc[len(f)//2:], f.iloc[:len(f)//2]], ignore_index=True)),
    # The participant measured Y from a point 1 mm beside the track's centre.
    "mistake_Y_shifted_by_1_mm": lambda frames: _changed(frames, lambda frame: frame.assign(Y=frame["Y"] + 0.001)),
    # The participant reported Y of the wheelset's point at rail level, not of its centre.
    "mistake_Y_at_the_rails": lambda frames: _changed(frames, lambda frame: frame.assign(Y=frame["Y"] + 0.457*frame["roll"])),
    # The participant reported the lateral velocity of the point at rail level, not of the centre.
    "mistake_lateral_velocity_at_the_rails": lambda frames:
        _changed(frames, lambda frame: frame.assign(vY=frame["vY"] + 0.457*frame["roll_rate"])),
    # The participant wrote the roll velocity alone with the opposite sign.
    "mistake_roll_velocity_negative": lambda frames: _changed(frames, _scale(["roll_rate"], -1.0)),
    # The participant wrote the roll angle in milliradians below a header that says radians.
    "mistake_roll_in_mrad_below_rad": lambda frames: _changed(frames, _scale(["roll"], 1e3)),
    # The participant wrote the vertical acceleration alone downwards.
    "mistake_vertical_acceleration_negative": lambda frames: _changed(frames, _scale(["aZ"], -1.0)),
    # The participant's vertical acceleration contains gravity: 9.81 m/s2 at rest.
    "mistake_acceleration_of_an_accelerometer": lambda frames: _changed(frames, lambda frame: frame.assign(aZ=frame["aZ"] + G)),
    # The participant wrote accelerations in g below a header that says m/s2.
    "mistake_accelerations_in_g_below_m_s2": lambda frames: _changed(frames, _scale(["aY", "aZ"], 1/G)),
    # The participant wrote lateral and vertical velocity in km/h below a header that says m/s.
    "mistake_velocities_in_km_h_below_m_s": lambda frames: _changed(frames, _scale(["vY", "vZ"], 3.6)),
    # The participant wrote the forces of the right flange for the left flange, and the left one's for the right.
    "mistake_forces_of_the_wrong_wheel": lambda frames: _changed(frames, lambda frame: _swap(frame, "LF", "RF", ["N", "Fy", "Fz"])),
    # The participant exchanged the normal forces of the left and the right tread alone.
    "mistake_normal_force_of_the_wrong_wheel": lambda frames: _changed(frames, lambda frame: _swap(frame, "LT", "RT", ["N"])),
    # The participant exchanged tread and flange in all columns of the left wheel.
    "mistake_flange_and_tread_exchanged_left": lambda frames: _changed(frames, lambda frame: _swap(frame, "LT", "LF")),
    # The participant exchanged tread and flange in the forces of the right wheel alone.
    "mistake_flange_and_tread_forces_exchanged_right": lambda frames:
        _changed(frames, lambda frame: _swap(frame, "RT", "RF", ["N", "Fy", "Fz"])),
    # The participant gave lateral forces on the wheel at the right, and on the rail at the left.
    "mistake_lateral_forces_of_left_wheel_on_the_rail": lambda frames: _changed(frames, _scale(["Fy_LT", "Fy_LF"], -1.0)),
    # The participant counted lateral forces positive inwards on either side, below a header of one axis.
    "mistake_lateral_force_inwards": lambda frames:
        _changed(frames, _scale(["Fy_LT", "Fy_LF"], -1.0), names={**PLAIN, **{
            f"Fy_{c}": f"{SIDE[c[0]]} {PART[c[1]]} lateral force (positive to the left)" for c in CONTACTS}}),
    # The participant reported vertical and normal forces of treads as changes from 90 kN.
    "mistake_static_load_subtracted": lambda frames:
        _changed(frames, lambda frame: frame.update(frame[_of(["N", "Fz"], ("LT", "RT"))] - 9e4)),
    # The participant wrote the normal force of the left flange in kN, all other forces in N, below headers of N.
    "mistake_one_force_in_kN_below_N": lambda frames: _changed(frames, _scale(["N_LF"], 1e-3)),
    # The participant wrote forces in tonnes-force below a header that says kN.
    "mistake_forces_in_tonnes_below_kN": lambda frames: _changed(frames, _scale(_of(["N", "Fy", "Fz"]), 1/G), units=MM_KN),
    # The participant wrote the distance from the centre, positive on both sides, as lateral position.
    "mistake_contact_points_all_positive": lambda frames: _changed(frames, lambda frame: frame.update(frame[_of(["y"])].abs())),
    # The participant exchanged the heights of the contact points of tread and flange at the left.
    "mistake_heights_of_tread_and_flange_exchanged": lambda frames: _changed(frames, lambda frame: _swap(frame, "LT", "LF", ["z"])),
    # The participant wrote the height of the left flange's contact point alone downwards.
    "mistake_height_of_left_flange_downwards": lambda frames: _changed(frames, _scale(["z_LF"], -1.0)),
    # The participant forgot the factor 1/2 in all kinetic energies.
    "mistake_kinetic_energy_without_half": lambda frames: _changed(frames, _scale(["KE_lat", "KE_vert", "KE_roll"], 2.0)),
    # The participant counted the potential energy of the weight and left that of the load out.
    "mistake_potential_energy_of_load_missing": lambda frames: _changed(frames, lambda frame: frame.assign(PE_load=0.0)),
    # The participant wrote the work of gravity and load instead of their potential energy.
    "mistake_potential_energy_negative": lambda frames: _changed(frames, _scale(["PE_grav", "PE_load"], -1.0)),
    # The participant forgot one of the ten files, exercise 3 with simplified profiles.
    "mistake_simulation_missing": lambda frames: _files({case: frame for case, frame in frames.items() if case != "ex3_sw"}),
    # The participant did not report rolling radii.
    "mistake_rolling_radii_missing": lambda frames: _files(frames, order=[name for name in ALL if not name.startswith("radius")]),
    # The participant reported three contacts, without the right flange.
    "mistake_right_flange_missing": lambda frames: _files(frames, order=[name for name in ALL if not name.endswith("RF")]),
    # The participant gave the left and the right flange's normal force the same name.
    "mistake_one_name_twice": lambda frames: _files(frames, names={**PLAIN, "N_RF": PLAIN["N_LF"]}),
    # The participant's spreadsheet separates numbers by commas and writes decimal commas, without quotes.
    "mistake_decimal_commas_between_commas": lambda frames: _files(frames, decimal=","),
}
FAULTLESS = {name: function for name, function in list(globals().items()) if name.startswith("faultless_")} | {
    # Millimetres and kilonewtons, the rest SI.
    "faultless_mm_and_kN": lambda frames: _files(frames, units=MM_KN),
    # Lengths in mm, angles in mrad, velocities in mm/s and mrad/s, forces in kN.
    "faultless_mm_kN_mrad": lambda frames:
        _files(frames, units={**MM_KN, "angle": ("mrad", 1e3), "speed": ("mm/s", 1e3), "spin": ("mrad/s", 1e3)}),
    # All angles in degrees, called deg.
    "faultless_degrees": lambda frames:
        _files(frames, units={"angle": ("deg", 180/np.pi), "spin": ("deg/s", 180/np.pi), "spinacc": ("deg/s2", 180/np.pi)}),
    # Accelerations in g.
    "faultless_accelerations_in_g": lambda frames: _files(frames, units={"acc": ("g", 1/9.80665)}),
    # Units written m/s**2 and rad/s**2.
    "faultless_units_with_stars": lambda frames: _files(frames, units={"acc": ("m/s**2", 1), "spinacc": ("rad/s**2", 1)}),
    # Units written m.s-1, m.s-2, rad.s-1 and rad.s-2.
    "faultless_units_with_negative_powers": lambda frames:
        _files(frames, units={"speed": ("m.s-1", 1), "acc": ("m.s-2", 1), "spin": ("rad.s-1", 1), "spinacc": ("rad.s-2", 1)}),
    # Units written m/s^2 and rad/s^2.
    "faultless_units_with_carets": lambda frames: _files(frames, units={"acc": ("m/s^2", 1), "spinacc": ("rad/s^2", 1)}),
    # Units written m/s² and rad/s², and ° for degrees.
    "faultless_units_with_superscripts": lambda frames:
        _files(frames, units={"acc": ("m/s²", 1), "spinacc": ("rad/s²", 1), **{f"angle_{c}": ("°", 180/np.pi) for c in CONTACTS}}),
    # Units written m/s/s, as in the call.
    "faultless_units_m_s_s": lambda frames: _files(frames, units={"acc": ("m/s/s", 1), "spinacc": ("rad/s/s", 1)}),
    # Inches, inches per second, g and pounds-force.
    "faultless_imperial": lambda frames:
        _files(frames, units={"length": ("in", 1/0.0254), "speed": ("in/s", 1/0.0254), "acc": ("g", 1/9.80665),
                                     "force": ("lbf", 1/4.4482216152605)}),
    # Time in milliseconds.
    "faultless_time_in_ms": lambda frames: _files(frames, units={"time": ("ms", 1e3)}),
    # Forces in MN and energies in kJ.
    "faultless_MN_and_kJ": lambda frames: _files(frames, units={"force": ("MN", 1e-6), "energy": ("kJ", 1e-3)}),
    # Names without units; everything is SI.
    "faultless_no_units_SI": lambda frames: _files(frames, head="names"),
    # Rolling radii in m, all other lengths in mm.
    "faultless_radius_in_m_positions_in_mm": lambda frames:
        _files(frames, units={**MM_KN, **{f"radius_{c}": ("m", 1) for c in CONTACTS}}),
    # The lateral axis points to the right, also for forces and contact points.
    "faultless_Y_to_the_right": lambda frames: _files(frames, signs=RIGHT),
    # The vertical axis points down, also for forces and contact points.
    "faultless_Z_down": lambda frames: _files(frames, signs=DOWN),
    # X forward, Y to the right, Z down, the right-handed frame of vehicles; roll about X is as before.
    "faultless_Y_right_and_Z_down": lambda frames: _files(frames, signs=RIGHT + DOWN),
    # A positive roll lifts the right wheel.
    "faultless_roll_the_other_way": lambda frames: _files(frames, signs=ROLL),
    # Lateral and vertical forces are those of the wheel on the rail; normal forces are positive.
    "faultless_forces_of_the_wheel_on_the_rail": lambda frames: _files(frames, signs=_of(["Fy", "Fz"])),
    # Contact angles are rotations about X: positive at one wheel and negative at the other.
    "faultless_angles_signed_in_the_track_frame": lambda frames: _files(frames, signs=_of(["angle"], ("RT", "RF"))),
    # Y to the right, Z down, roll reversed, forces on the rail: forces have the signs of the call again.
    "faultless_everything_reversed": lambda frames:
        _files(frames, signs=RIGHT[:3] + tuple(_of(["y"])) + DOWN[:3] + tuple(_of(["z"])) + ROLL),
    # The vertical displacement is the height of the axle above the top of rail.
    "faultless_Z_from_the_rails": lambda frames:
        {f"{case}.csv": _form(f, names={**PLAIN, "Z": "axle height above rail"}, offset={"Z": _axle_height(f)})
                for case, f in frames.items()},
    # Z is zero where the rigid wheelset stands on the rails without load, so it starts at -0.18 mm.
    "faultless_Z_from_the_unloaded_position": lambda frames:
        {f"{case}.csv": _form(f, offset={"Z": _axle_height(f) - 0.457}) for case, f in frames.items()},
    # Heights of contact points are measured from the axle's height at rest.
    "faultless_contact_heights_from_the_axle": lambda frames:
        {f"{case}.csv": _form(f, offset={f"z_{c}": -_axle_height(f) for c in CONTACTS}) for case, f in frames.items()},
    # Heights of contact points are measured from the tread's contact point at rest.
    "faultless_contact_heights_from_the_static_contact": lambda frames:
        {f"{case}.csv": _form(f, offset={f"z_{c}": -float(f["z_LT"].iloc[0]) for c in CONTACTS}) for case, f in frames.items()},
    # The time starts at -0.1 s.
    "faultless_time_from_minus_100_ms": lambda frames: _files(frames, offset={"time": -0.1}),
    # The time starts at 10 s, after a settling run that is not in the file.
    "faultless_time_from_10_s": lambda frames: _files(frames, offset={"time": 10.0}),
    # Potential energies are zero at the top of rail, so they start at 7 and 75 kJ.
    "faultless_energies_from_the_rails": lambda frames:
        {f"{case}.csv": _form(f, offset={"PE_grav": MASS*G*_axle_height(f), "PE_load": LOAD*_axle_height(f)})
                for case, f in frames.items()},
    # The columns have the names of docs/output.md, without comment lines.
    "faultless_names_of_ours": lambda frames: _files(frames, names={}, head="names", sep=" ", name="{case}.txt"),
    # French names with accents, semicolons and decimal commas.
    "faultless_french": lambda frames: _files(frames, names=FRENCH, units=MM_KN, sep=";", decimal=","),
    # German names with umlauts, semicolons and decimal commas.
    "faultless_german": lambda frames: _files(frames, names=GERMAN, units={**MM_KN, "angle": ("mrad", 1e3)}, sep=";", decimal=","),
    # A spreadsheet of central Europe: semicolons between numbers, decimal commas.
    "faultless_semicolons_and_decimal_commas": lambda frames: _files(frames, sep=";", decimal=","),
    # Tabs between names and numbers.
    "faultless_tabs": lambda frames: _files(frames, sep="\t", name="{case}.txt"),
    # Tabs between numbers with decimal commas.
    "faultless_tabs_and_decimal_commas": lambda frames: _files(frames, sep="\t", decimal=",", name="{case}.txt"),
    # Names and numbers separated by single blanks, units in a line of their own.
    "faultless_single_blanks": lambda frames: _files(frames, sep=" ", names=SHORT, head="two lines", name="{case}.txt"),
    # Numbers right-justified in 32 characters below right-justified names.
    "faultless_fixed_width": lambda frames:
        {f"{case}.txt": _padded(_form(f, sep=" ", names=SHORT, head="two lines in brackets"), 32) for case, f in frames.items()},
    # Lines begin with blanks and numbers stand several blanks apart.
    "faultless_several_blanks_and_a_blank_start": lambda frames:
        {f"{case}.dat": re.sub("^", "   ", _form(f, sep=" ", names=SHORT, head="glued").replace(" ", "    ").rstrip("\n"),
                                      flags=re.M) + "\n" for case, f in frames.items()},
    # A comma and a blank between names and numbers.
    "faultless_comma_and_blank": lambda frames: {name: text.replace(",", ", ") for name, text in _files(frames).items()},
    # Every line ends with a comma, as loops print it.
    "faultless_trailing_separator": lambda frames: {name: text.replace("\n", ",\n") for name, text in _files(frames).items()},
    # Names and units together in quotation marks.
    "faultless_quoted_names": lambda frames: _files(frames, head="quoted"),
    # Units in parentheses behind the names.
    "faultless_units_in_parentheses": lambda frames: _files(frames, head="parens", units=MM_KN),
    # A line of names, then a line of units.
    "faultless_names_and_units_in_two_lines": lambda frames: _files(frames, head="two lines", units=MM_KN),
    # A line of quoted names, then a line of quoted units, semicolons.
    "faultless_quoted_names_and_units_in_two_lines": lambda frames: _files(frames, head="quoted two lines", units=MM_KN, sep=";"),
    # Comments with % above the names, as Matlab writes them.
    "faultless_comments_with_percent": lambda frames:
        _files(frames, before="% LD benchmark\n% single wheelset without friction\n%\n"),
    # Comments with // above the names.
    "faultless_comments_with_slashes": lambda frames:
        _files(frames, before="// LD benchmark, single wheelset without friction\n// solver: Newmark, 20 us\n"),
    # The names stand in a comment line with #, as NumPy writes them.
    "faultless_names_in_a_comment": lambda frames: _files(frames, before="# ", head="brackets"),
    # The names stand in a comment line with %, numbers are separated by blanks.
    "faultless_names_in_a_percent_comment": lambda frames:
        _files(frames, before="% ", head="glued", names=SHORT, sep=" ", name="{case}.dat"),
    # Lines of keys and values above the names: mass = 1568, author = ...
    "faultless_key_value_header": lambda frames:
        _files(frames, before="mass = 1568\nroll_inertia = 656\nauthor = A. Author\nsimulation = LD\n"),
    # Comment lines follow the rows.
    "faultless_footer": lambda frames: {name: text + "# end of run\n# 3 impacts\n" for name, text in _files(frames).items()},
    # Open contacts have -999 for position, angle and radius; a comment says so.
    "faultless_open_contacts_minus_999": lambda frames:
        {f"{case}.csv": _form(_open_as(f, -999.0), before="# -999 no contact\n") for case, f in frames.items()},
    # Open contacts have zero for position, angle and radius.
    "faultless_open_contacts_zero": lambda frames: {f"{case}.csv": _form(_open_as(f, 0.0)) for case, f in frames.items()},
    # Open contacts have empty cells for position, angle and radius.
    "faultless_open_contacts_blank": lambda frames: _files(frames, na=""),
    # Open contacts have n/a for position, angle and radius.
    "faultless_open_contacts_word": lambda frames: _files(frames, na="n/a"),
    # Open contacts have 1e30 for position, angle and radius, as finite element programs write.
    "faultless_open_contacts_huge": lambda frames: {f"{case}.csv": _form(_open_as(f, 1e30)) for case, f in frames.items()},
    # All numbers have a sign: +1.000000e+00.
    "faultless_plus_signs": lambda frames: _files(frames, digits="%+.9e"),
    # Single precision: seven digits.
    "faultless_seven_digits": lambda frames: _files(frames, digits="%.7g"),
    # All digits of double precision.
    "faultless_seventeen_digits": lambda frames: _files(frames, digits="%.17g"),
    # Rows at equal intervals of 0.1 ms, without rows at events.
    "faultless_rows_at_10_kHz": lambda frames: _changed(frames, lambda frame: _at(frame, 1e-4)),
    # Exercise 1 with rows every 0.5 ms, about ten of them in each impact, in the other exercises all rows.
    "faultless_exercise_1_at_2_kHz": lambda frames:
        _files({case: _at(f, 5e-4) if case[:3] == "ex1" else f for case, f in frames.items()}),
    # Times have six digits behind the point, so rows at events share a time with their neighbours.
    "faultless_equal_times_after_rounding": lambda frames:
        _changed(frames, lambda frame: frame.assign(time=frame["time"].round(6))),
    # The file begins with three equal rows at t = 0.
    "faultless_start_three_times": lambda frames:
        _changed(frames, lambda frame: pd.concat([frame.iloc[[0, 0]], frame], ignore_index=True)),
    # Columns ordered by quantity: four angles, four normal forces, and so on.
    "faultless_columns_by_quantity": lambda frames:
        _files(frames, order=["time", *MOTION, *(f"{q}_{c}" for q in POINT for c in CONTACTS), *ENERGY]),
    # Time is the last column.
    "faultless_time_last": lambda frames: _files(frames, order=list(ALL[1:]) + ["time"]),
    # The 37 quantities of the call, and no energies.
    "faultless_without_energies": lambda frames: _files(frames, order=CALL),
    # Line ends of Windows.
    "faultless_crlf": lambda frames: _files(frames, eol="\r\n"),
    # Line ends of old Macintoshes.
    "faultless_cr": lambda frames: _files(frames, eol="\r"),
    # UTF-8 with a byte order mark, as Excel writes it, with CRLF.
    "faultless_bom": lambda frames: {name: "\ufeff" + text for name, text in _files(frames, eol="\r\n").items()},
    # French names in Latin-1 (bytes).
    "faultless_latin_1": lambda frames:
        {name: text.encode("latin-1") for name, text in _files(frames, names=FRENCH, sep=";", decimal=",").items()},
    # The last row has no line end.
    "faultless_no_line_end_at_the_end": lambda frames: {name: text.rstrip("\n") for name, text in _files(frames).items()},
    # Files are called Exercise 3 simplified.txt.
    "faultless_names_of_files_in_words": lambda frames: _files(frames, name="Exercise {n} {what}.txt"),
    # Files are called MyCode_LDbench_EX3_SW.CSV.
    "faultless_names_of_files_with_a_code": lambda frames:
        {f"MyCode_LDbench_{case.upper()}.CSV": text for case, text in ((name[:-4], text) for name, text in _files(frames).items())},
    # Files are called exercise3_swprof.dat.
    "faultless_names_of_files_with_profiles": lambda frames:
        {f"exercise{case[2]}_{case[4:]}prof.dat": _form(f, sep="\t") for case, f in frames.items()},
}
