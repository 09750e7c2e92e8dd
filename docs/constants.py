"""Tables of the constants of the program that a reader may ask for: limits and sizes, taken from the sources."""
from __future__ import annotations

import math
import re
from functools import cache
from pathlib import Path

from ldbench import Case
from ldbench.constants import TAPE_CIRCLE
from ldbench.geometry.contact_geometry import CURVE
from ldbench.number_text import number_text
from ldbench.plots.stretches import SWINGS
from ldbench.profiles import profile
from ldbench.results.contact_intervals import CLOSED
from ldbench.results.quantities import PAIRS
from ldbench_round import drift_checks, energies, fingerprint, jumps, kept_entries, physics_checks, row_checks
from ldbench_round.tasks import clearances
from quotes import table

CORE = Path(__file__).resolve().parents[1]/"fortran"
SCALES = {"µm": 1e6, "mm": 1e3, "m": 1.0, "kN": 1e-3, "N": 1.0, "°": 180/math.pi, "rad": 1.0, "%": 100.0, "MB": 1e-6, "ms": 1e3,
          "": 1.0}


@cache
def core(module: str, name: str, index: int = 0) -> float:
    """A named constant of a module of the core, in its own unit; one number of a list by its index.

    SystemExit if the module has no such constant, or one that is not a number, a list of numbers, or a number of degrees.
    """
    text = next(CORE.rglob(f"{module}.f90")).read_text()
    found = re.search(rf"parameter ::[^!\n]*?\b{name}(?:\(\d+\))? = (\[[^\]]*\]|[^,!\n]*)", text)
    try:
        value = found[1].strip(" []").split(",")[index].replace("_dp", "").strip() if found else ""
        number, _, unit = value.partition("*")
        return float(number)*{"": 1.0, "degree": math.pi/180}[unit]
    except (KeyError, ValueError, IndexError):
        raise SystemExit(f"docs: expected a number for the constant {name} of fortran/**/{module}.f90, found "
                         f"{value or 'none'}") from None


def shown(value: float, unit: str) -> str:
    """A number in SI units as a page has it in another unit."""
    return f"{number_text(SCALES[unit]*value, digits=6, trim=True)}{'' if unit in ('', '°') else ' '}{unit}"


def call_table() -> str:
    """What the call asks of each exercise."""
    columns = {"vY": "m/s", "roll_rate": "rad/s", "lateral_ramp": "N/s"}
    cases = {k: Case.exercise(k) for k in range(1, 6)}
    stops = {"return_to_centre": "the return to the centre after turning back on both sides", "derailment": "derailment"}
    return table(("exercise", *(f"`{name}` [{unit}]" for name, unit in columns.items()), "ends with"), (
        (str(k), *(f"{getattr(case, name):g}" for name in columns), stops[case.stop_at]) for k, case in cases.items()))


def clearance_table() -> str:
    """The clearances that the call publishes."""
    return table(("profiles", "published clearance, left and right"),
                 ((PAIRS[pair], shown(size, "mm")) for pair, size in clearances().items()))


def theory_table() -> str:
    """Constants of the core that the equations need."""
    rows = (
        ("smallest noise of points that the core refuses", shown(core("profile", "negligible"), "µm"), "profile"),
        ("arc over which curvatures are means", shown(core("wheel_rail_pair", "window"), "mm"), "wheel_rail_pair"),
        ("rail angles to either side over which its curvature is a mean, with weights that fall to 0",
         shown(2*core("placement", "half"), "°"), "placement"),
        ("curve of the rolling radii coefficient", shown(CURVE, "m"), "contact_geometry"),
        ("shortest arc without contact between two zones", shown(core("contact_zones", "least_gap"), "mm"), "contact_zones"),
        ("least growth of the angle between the normals along it", shown(core("contact_zones", "least_turn"), "rad"),
         "contact_zones"),
        ("wheel angle of the cut where no such arc is", shown(core("contact_zones", "root_angle"), "°"), "contact_zones"),
        ("running tread, to either side of the running point", shown(core("contact_zones", "service"), "mm"), "contact_zones"),
        ("shortest cell of $u$", shown(core("table_layout", "shortest_u"), "mm"), "table_layout"),
        ("longest cell of $u$ where flanges are reached", shown(core("table_layout", "longest_u"), "mm"), "table_layout"),
        ("way of the contact along the wheel in a cell of $u$", shown(core("table_layout", "travel"), "mm"), "table_layout"),
        ("cell of $\\varphi$ of an upright wheelset", shown(core("table_layout", "shortest_roll"), "rad"), "table_layout"),
        ("height by which a kink of $h$ is rounded off", shown(core("table_layout", "rounding"), "µm"), "table_layout"),
        ("points of $\\rho$", f"{core('table_layout', 'points_q'):g}", "table_layout"),
        ("largest tensile force of a zone that counts as open", shown(core("zone_tables", "largest_pull"), "kN"), "zone_tables"),
        ("force to which errors of smaller forces are relative", shown(core("contact_law", "force_floor"), "kN"),
         "contact_law"),
        ("force above which a contact is closed in files", shown(CLOSED, "N"), "contact_intervals"),
        ("depth below the top of rail from which a flange's tip is over the rail", shown(core("events", "shoulder"), "mm"),
         "events"),
        ("energy drift of which a run warns, over the largest kinetic energy",
         shown(core("run_results", "largest_drift"), "%"), "run_results"))
    return table(("constant", "value", "module"), ((words, value, f"`{module}`") for words, value, module in rows))


def smoothing_table() -> str:
    """Limits of reading and smoothing profiles."""
    return table(("limit", "value"), (
        ("noise of points that are taken as they are, below", shown(1e-3*profile.NEGLIGIBLE, "µm")),
        ("rms distance of the curve from points with waves, at most", shown(1e-3*profile.MOST_EVEN, "µm")),
        ("noise of points whose waves are smoothed, below", shown(1e-3*profile.MOST_NOISE, "µm")),
        ("tape circle and running circle, from the wheel's back", shown(TAPE_CIRCLE, "mm"))))


def reading_table() -> str:
    """Limits of reading other codes' files."""
    return table(("limit", "value"), (
        ("largest file that is read", shown(kept_entries.LARGEST, "MB")),
        ("uncertainty of our Hertzian force beside a file's, and for each factor of two", shown(fingerprint.MOTION, "%"))))


def output_table() -> str:
    """Limits by which output is made."""
    return table(("limit", "value"), (
        ("force above which a contact is closed in the rows of a file", shown(CLOSED, "N")),
        ("oscillations to a millimetre of paper, from which a curve is drawn as a band", shown(SWINGS/2, ""))))


def check_table() -> str:
    """Limits of the check of a file."""
    def percent(*limits: float) -> tuple[str, ...]:
        return tuple(shown(x, "%") for x in limits)

    def both(one: tuple[float, float], unit: str) -> tuple[str, ...]:
        return tuple(shown(x, unit) for x in one)

    balances = percent(physics_checks.DOUBT, physics_checks.FAIL)
    rows = (
        ("a file or a quantity is missing", "", "one"),
        ("units; one sign for each axis", "frame other than the call's", "one column"),
        ("Y at the start", *both(physics_checks.START, "mm")),
        ("velocities at the start", *percent(*physics_checks.START_RATE)),
        ("left flange first, right flange, centre; derailment in exercise 5", "derailment in 1 to 4", "does not happen"),
        ("first flange contact at the published clearance", *percent(*physics_checks.CLEARANCE)),
        ("rows missing in an impact: change of velocity", *percent(*physics_checks.GAP_CHANGE)),
        ("velocity jump of an elastic code", "", "one"),
        ("N negative, over the largest force", *both(physics_checks.NEGATIVE, "")),
        ("N against Fy and Fz", *balances),
        ("contact angle against the force", *both(physics_checks.ANGLE, "rad")),
        ("contact angle against the rail", *both(row_checks.TURNED, "rad")),
        ("contact point off the rail", *both(row_checks.AWAY, "mm")),
        ("rolling radius", *both(row_checks.RADIUS, "mm")),
        ("mass, weight with load", *percent(*row_checks.INERTIA)),
        ("roll inertia", *percent(*row_checks.ROLL_INERTIA)),
        ("rates, momentum", *balances),
        ("drift of Y, Z or roll from the integral of its velocity, of its range", *percent(*drift_checks.DRIFT)),
        ("one value of Y, Z or roll beside those before and behind it, of its range", *percent(*drift_checks.ALONE)),
        ("force and acceleration of one row, in a file whose other rows obey Newton's law", *percent(*drift_checks.BROKEN)),
        ("rolling radius that follows Z", "one contact", ""),
        ("cells without a number", "in accelerations", "in other motion, in forces of closed contacts"),
        ("times of few digits", "rows of equal times", "a fall by more than the last digit"),
        ("given energies, energy balance, dips of the total energy", *percent(*energies.WRONG)),
        ("energy that contacts store and the file does not tell, over the change of kinetic energy in a contact",
         *percent(*energies.UNTOLD)),
        ("rows in an impact of a flange", f"fewer than {physics_checks.FEW_ROWS}",
         f"fewer than {physics_checks.TOO_FEW_ROWS}; exercise 5: {physics_checks.RAMP_ROWS}"),
        ("rows of a rigid code about a jump: their distance", "", f"above {shown(jumps.SHORT, 'ms')}"))
    return table(("finding", "doubtful from", "failed from"), rows)
