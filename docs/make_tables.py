"""Write into the pages what they take from the program: tables of variables, columns and results, and measured results.

    python docs/make_tables.py             writes the tables and the numbers
    python docs/make_tables.py --check     fails where a page has other ones

It writes the types of the variables of a case, `wrappers/ldbench/_core/case_types.pyi`, too.

A table stands between the comments `<!-- table: NAME -->` and `<!-- end of table -->`. Names, units, defaults and ranges
are the program's; it is an error when a column or a result is not explained here, or explained and unknown to it. Measured
results are those of docs/measured.json; `quotes.py` says how a page quotes them.
"""
from __future__ import annotations

import re
import sys
from collections.abc import Callable
from pathlib import Path

from ldbench import Case, case, run
from ldbench.__main__ import make_parser
from ldbench._core.calls import descriptions
from ldbench.case import shortest_name, variables
from ldbench.commands import COMMANDS
from ldbench.results.columns import UNITS
from ldbench.results.events import event_kinds
from ldbench.results.quantities import si_unit
from ldbench_round.horizon import yardsticks
from quotes import TABLES as MEASURED_TABLES, measured, quoted, table

DOCS = Path(__file__).resolve().parent
TYPES = Path(case.__file__).with_name("_core")/"case_types.pyi"
CONTACT = "C"       # stands for LT, LF, RT, RF

GROUPS = {
    "case": "The name and the title of the case.",
    "wheelset": "Mass, inertia, dimensions and load of the wheelset.",
    "track": "Gauge and friction.",
    "material": "Elastic constants of wheel and rail, which are of one material.",
    "profiles": "Files of the profiles. [Profiles](profiles.md) explains the formats.",
    "initial": "State of the wheelset at t = 0.",
    "loading": "The lateral force at the centre of gravity, `lateral_force + lateral_ramp*t`.",
    "contact": "Treatment of contact: the formulation, and the law of elastic contact.",
    "table": "The contact table, from which elastic forces are interpolated. The run stops where a wheel leaves the range.",
    "integrator": "Time integration, and the end of the run.",
    "output": "Files that the run writes.",
}

COLUMNS = {
    "time": "time",
    "X": "distance travelled, positive forward",
    "Y": "lateral displacement of the axle's centre, positive to the left",
    "Z": "vertical displacement of the axle's centre from static equilibrium at Y = 0, positive upwards",
    "roll": "roll angle from static equilibrium at Y = 0, positive if the left wheel rises",
    "pitch": "pitch angle, positive in the sense of forward rolling",
    "vX": "forward velocity, constant",
    "vY": "lateral velocity of the axle's centre",
    "vZ": "vertical velocity of the axle's centre",
    "roll_rate": "roll velocity",
    "pitch_rate": "pitch velocity, constant",
    "aY": "lateral acceleration of the axle's centre",
    "aZ": "vertical acceleration of the axle's centre",
    "roll_acc": "roll acceleration",
    "angle_C": "contact angle, between the contact force and the vertical, positive if the rail pushes the wheel towards the "
               "track's centre, on either side",
    "N_C": "normal force; negative where a rail pulls (`bilateral` only)",
    "Fy_C": "lateral force of the rail on the wheel",
    "Fz_C": "vertical force of the rail on the wheel",
    "y_C": "lateral position of the contact point, from the track's centre",
    "z_C": "vertical position of the contact point, from the top of rail",
    "radius_C": "rolling radius: distance of the contact point from the axle's axis",
    "F_ext": "external lateral force at the centre of gravity",
    "M_gyro": "moment about Z with which the yaw constraint holds the wheelset: pitch inertia × pitch rate × roll rate",
    "KE_long": "kinetic energy of the forward motion, constant",
    "KE_lat": "kinetic energy of the lateral motion",
    "KE_vert": "kinetic energy of the vertical motion",
    "KE_roll": "kinetic energy of the roll motion",
    "KE_pitch": "kinetic energy of the pitch motion, constant",
    "PE_grav": "potential energy of the weight, zero at Z = 0",
    "PE_load": "potential energy of the vertical load, zero at Z = 0",
    "PE_elastic_L": "elastic energy of the contacts of the left wheel",
    "PE_elastic_R": "elastic energy of the contacts of the right wheel",
    "W_ext": "work of the external lateral force since t = 0",
    "E_total": "total energy: the sum of all kinetic and potential energies",
    "E_drift": "energy error: E_total minus its value at t = 0, minus W_ext, plus E_lost. The exact motion has zero",
    "P_C": "sum of the impulses so far (rigid contacts only): of impacts with `unilateral`; with `bilateral`, of contacts that "
           "jump along the wheel",
    "E_lost": "energy lost in all impacts so far (rigid contacts only)",
}

# Results: unit and meaning. Those of the setup come first.
RESULTS = {
    "clearance_left": ("m", "rigid-axle flange clearance to the left"),
    "clearance_right": ("m", "rigid-axle flange clearance to the right"),
    "axle_height": ("m", "height of the axle above the top of rail, at rest, held at Y = 0; Z is measured from it"),
    "axle_roll": ("rad", "roll angle at rest, held at Y = 0; zero for equal sides. The column `roll` is measured from it"),
    "rest_Y": ("m", "Y at which the wheelset rests if nothing holds it"),
    "rest_Z": ("m", "Z at which the wheelset rests if nothing holds it"),
    "rest_roll": ("rad", "roll at which the wheelset rests if nothing holds it"),
    "frequency_1, frequency_2, frequency_3": ("Hz", "eigenfrequencies at rest; the file has them as `eigenfrequencies`. NaN if "
                                                    "rigid contacts leave fewer"),
    "end": ("", "why the run ended"),
    "t": ("s", "time of the last row"),
    "rows": ("", "number of rows"),
    "farthest_left, farthest_right": ("m", "largest and smallest Y of all steps"),
    "farthest_up": ("m", "largest Z of all steps"),
    "t_farthest_left, t_farthest_right, t_farthest_up": ("s", "times of these"),
    "peak_N_C": ("N", "largest normal force of a contact, over all steps"),
    "t_peak_C": ("s", "time of the largest normal force"),
    "peak_P_C": ("N.s", "largest impulse of one impact at a contact (rigid contacts only)"),
    "t_peak_P_C": ("s", "time of the largest impulse"),
    "lost": ("J", "energy lost in impacts (rigid contacts only)"),
    "drift": ("J", "largest absolute energy error of all steps"),
    "kinetic_energy": ("J", "kinetic energy of lateral, vertical and roll motion at t = 0"),
    "changes": ("", "initial values that the constraints replaced (rigid contacts only)"),
    "steps": ("", "number of steps"),
    "step": ("s", "largest step, `dt`"),
    "cuts": ("", "number of steps that were halved"),
    "missed": ("", "number of steps that miss `energy_tolerance` after `max_halvings` cuts"),
    "evaluations": ("", "number of evaluations of the contact forces"),
    "n_KIND": ("", "number of events of a kind, for example `n_left_flange_contact`"),
    "derailed": ("", "Python only: whether the wheelset derailed"),
}


def main(words: list[str]) -> int:
    stale = []
    values = measured()
    if TYPES.read_text() != case_types():
        stale.append(TYPES.name)
        if "--check" not in words:
            TYPES.write_text(case_types())
    for path in (DOCS.parent/"README.md", *sorted(DOCS.glob("*.md"))):
        page = path.name
        old = path.read_text()
        new = quoted(filled(old, PAGES.get(page, {})), values)
        if new != old:
            stale.append(page)
            if "--check" not in words:
                path.write_text(new)
    if "--check" in words and stale:
        print(f"docs: expected the tables and measured results of the program in {', '.join(stale)}, found others. "
              "Run python docs/make_tables.py", file=sys.stderr)
        return 1
    return 0


def filled(text: str, tables: dict[str, Callable[[], str]]) -> str:
    """A page with its tables made anew."""
    for name, make in tables.items():
        start, end = f"<!-- table: {name} -->\n", "<!-- end of table -->"
        before, found, rest = text.partition(start)
        if not found:
            raise SystemExit(f"docs: expected the comment {start.strip()}, found none")
        text = f"{before}{start}\n{make()}\n{end}{rest.partition(end)[2]}"
    return text


def variable_tables() -> str:
    """Every variable, a table per group."""
    found = []
    for group in dict.fromkeys(variable.group for variable in variables()):
        rows = [(f"`{variable.name}`" + ("" if shortest_name(k) == variable.name else f"<br>`{shortest_name(k)}` in Python"),
                 meaning(variable.meaning, variable.name), f"`{variable.default.strip()}`", unit(variable.unit),
                 admitted(variable.range))
                for k, variable in enumerate(variables()) if variable.group == group]
        found.append(f"### &{group}\n\n{GROUPS[group]}\n\n" + table(("name", "meaning", "default", "unit", "range"), rows))
    return "\n".join(found)


def case_types() -> str:
    """The stub by which type checkers know the variables of a case."""
    kinds = {"real": "float", "integer": "int"}
    attributes, arguments = [], []
    for k, variable in enumerate(variables()):
        choices = variable.range.startswith("one of ")
        for name in dict.fromkeys((shortest_name(k), f"{variable.group}_{variable.name}")):
            attributes.append(f"    {name}: Final[{kinds.get(variable.kind, 'str')}]")
            arguments.append(f"    {name}: {kinds.get(variable.kind, 'str' if choices else 'str | PathLike[str]')}")
    return "\n".join([
        '"""Types of the variables of a case, for type checkers. docs/make_tables.py makes this file of the core\'s list."""',
        "from os import PathLike", "from typing import Final, TypedDict", "", "class Variables:", *attributes, "",
        "class Values(TypedDict, total=False):", *arguments, ""])


def unit(name: str) -> str:
    return "" if name in ("", "1") else re.sub(r"(?<=m|s)2\b", "²", name).replace(".", "·")


def admitted(words: str) -> str:
    """A range as a table has it."""
    if found := re.match(r"a (whole )?number from (\S+) to (\S+)", words):
        return f"{plain(found[2])} to {plain(found[3])}{', whole' if found[1] else ''}"
    if found := re.match(r"one of (.*)", words):
        return ", ".join(f"`{word}`" for word in found[1].split())
    return "text"


def plain(number: str) -> str:
    """A bound of a range in few digits."""
    return f"{float(number):g}".replace("e+0", "e").replace("e-0", "e-")


def meaning(words: str, name: str) -> str:
    words = words or name.replace("_", " ")
    return words[0].upper() + words[1:]


def column_table() -> str:
    """Every column of a column file; those of a contact once."""
    names, units = (line.split() for line in descriptions()[:2])
    rows: dict[str, tuple[str, str, str]] = {}
    for name, si in zip(names, units, strict=True):
        key = re.sub(r"_(LT|LF|RT|RF)$", f"_{CONTACT}", name)
        if key not in COLUMNS:
            raise SystemExit(f"docs: expected a meaning of the column {key} in {__file__}, found none")
        rows[key] = f"`{key}`", COLUMNS[key], unit(si)
    if unknown := COLUMNS.keys() - rows.keys():
        raise SystemExit(f"docs: expected columns of the program in {__file__}, found {', '.join(unknown)}")
    return table(("column", "meaning", "unit"), rows.values())


def result_table() -> str:
    """Every result of a run."""
    short = run(Case.exercise(1).replace(formulation="unilateral", t_end=1e-3, table_file=""))
    kinds = {f"n_{re.sub('[ -]', '_', kind)}" for kind in event_kinds()}
    told = {re.sub(r"_(LT|LF|RT|RF)$", f"_{CONTACT}", name) for name in short.results.keys() - kinds} | {"n_KIND"}
    explained = {name for names in RESULTS for name in names.split(", ")}
    if told != explained:
        raise SystemExit(f"docs: expected a meaning of every result in {__file__}, found differences: {sorted(told ^ explained)}")
    for names, (si, _) in RESULTS.items():
        for name in names.split(", "):
            known = si_unit(name.replace(f"_{CONTACT}", "_LT"))
            if known not in ("", si or "1"):
                raise SystemExit(f"docs: expected the unit {known} of the result {name}, found {si}")
    rows = ((", ".join(f"`{name}`" for name in names.split(", ")), words, unit(si)) for names, (si, words) in RESULTS.items())
    return table(("result", "meaning", "unit"), rows)


def command_table() -> str:
    """Every command with its arguments and options, less those that all have."""
    common = {"-h", "-q", "-v"}
    rows = []
    for name, parser in make_parser(COMMANDS).commands.items():
        actions = [action for action in parser._actions if not common & set(action.option_strings)]
        arguments = [str(action.metavar or "|".join(action.choices)) for action in actions if not action.option_strings]
        options = [" ".join(filter(None, (*action.option_strings[:1], action.metavar))) for action in actions
                   if action.option_strings]
        rows.append((f"`{name}`", COMMANDS[name], *(", ".join(f"`{word}`" for word in words) for words in (arguments, options))))
    return table(("command", "what it does", "arguments", "options"), rows)


def event_list() -> str:
    return ", ".join(f"`{kind}`" for kind in event_kinds()) + ".\n"


def unit_list() -> str:
    """The units that other codes' files may have."""
    by_unit: dict[str, list[str]] = {}
    for name, (si, _) in UNITS.items():
        by_unit.setdefault(si, []).append(f"`{name}`")
    return table(("SI unit", "units that are read"), ((unit(si) or "none", ", ".join(names)) for si, names in by_unit.items()))


def horizon_table() -> str:
    """The horizon and the end of every simulation, and the growth of a difference."""
    return table(("simulation", "horizon [s]", "end [s]", "growth"), [
        [f"`{name}`", f"{own.horizon:.3g}" if own.reached else f"above {own.horizon:.3g}",
         "later" if own.end is None else f"{own.end:.3g}", f"{own.growth:,.0f}"] for name, own in yardsticks().items()])


PAGES: dict[str, dict[str, Callable[[], str]]] = {
    "input.md": {"variables": variable_tables},
    "output.md": {"columns": column_table, "results": result_table, "events": event_list},
    "commands.md": {"commands": command_table},
    "compare.md": {"units": unit_list},
    "accuracy.md": MEASURED_TABLES,
    "organiser.md": {"horizons": horizon_table},
}

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
