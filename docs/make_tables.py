"""Write into the pages what they take from the program: tables of variables, columns, constants and measured results.

    python docs/make_tables.py             writes the tables
    python docs/make_tables.py --check     fails where a page has other ones

It writes the types of the variables of a case, `wrappers/ldbench/_core/case_types.pyi`, too.

A table stands between the comments `<!-- table: NAME -->` and `<!-- end of table -->`. Names, units, defaults and ranges
are the program's; it is an error when a column or a result is not explained here, or explained and unknown to it, and when
a page lacks a table of PAGES or has another one. Measured results come by `quotes.py`, constants by `constants.py`.
"""
from __future__ import annotations

import re
import sys
from collections.abc import Callable
from pathlib import Path

import constants
from ldbench import Case, case, run
from ldbench.__main__ import make_parser
from ldbench._core.calls import descriptions
from ldbench.case import shortest_name, variables
from ldbench.commands import COMMANDS
from ldbench.results.columns import UNITS
from ldbench.results.events import event_kinds
from ldbench.results.quantities import si_unit
from ldbench_round.own_runs import yardsticks
from quotes import (
    PLUG_TABLES,
    TABLES as MEASURED_TABLES,
    build_table,
    formulation_table,
    mistake_table,
    need_table,
    run_table,
    short_table,
    table,
)

DOCS = Path(__file__).resolve().parent
TYPES = Path(case.__file__).with_name("_core")/"case_types.pyi"
TABLE = re.compile(r"^<!-- table: (.*) -->$", re.MULTILINE)
CONTACT = "C"       # stands for LT, LF, RT, RF

# What the names of groups do not say.
GROUPS = {
    "profiles": "[Profiles](profiles.md) explains the formats.",
    "loading": "The lateral force is `lateral_force + lateral_ramp*t`.",
    "table": "Elastic forces are interpolated from the contact table. The run stops where a wheel leaves the range.",
}

COLUMNS = {
    "time": "time",
    "X": "distance travelled, positive forward",
    "Y": "lateral displacement of the axle's centre, positive to the left",
    "Z": "vertical displacement of the axle's centre from static equilibrium at Y = 0, positive upwards",
    "roll": "roll angle from static equilibrium at Y = 0, positive if the left wheel rises",
    "pitch": "pitch angle, positive in the sense of forward rolling",
    "vX": "forward velocity, constant",
    "vY, vZ": "lateral and vertical velocity of the axle's centre",
    "roll_rate, pitch_rate": "roll velocity; pitch velocity, constant",
    "aY, aZ": "lateral and vertical acceleration of the axle's centre",
    "roll_acc": "roll acceleration",
    "angle_C": "contact angle, between the contact force and the vertical, positive if the rail pushes the wheel towards the "
               "track's centre, on either side",
    "N_C": "normal force; negative where a rail pulls (`bilateral` only)",
    "Fy_C, Fz_C": "lateral and vertical force of the rail on the wheel",
    "y_C, z_C": "position of the contact point, from the track's centre and from the top of rail",
    "radius_C": "rolling radius: distance of the contact point from the axle's axis",
    "F_ext": "external lateral force at the centre of gravity",
    "M_gyro": "moment with which the yaw constraint holds the wheelset, about its own vertical axis, which leans with the roll: "
              "pitch inertia × pitch rate × roll rate",
    "KE_long, KE_lat, KE_vert, KE_roll, KE_pitch": "kinetic energies; those of forward motion and pitch are constant",
    "PE_grav, PE_load": "potential energies of the weight and of the vertical load, zero at Z = 0",
    "PE_elastic_L, PE_elastic_R": "elastic energy of the contacts of the left and the right wheel, zero without contact",
    "W_ext": "work of the external lateral force since t = 0",
    "E_total": "total energy: the sum of all kinetic and potential energies",
    "E_drift": "energy error: E_total minus its value at t = 0, minus W_ext, plus E_lost. The exact motion has zero",
    "P_C": "sum of the impulses so far (rigid contacts only): of impacts with `unilateral`; with `bilateral`, of contacts that "
           "jump along the wheel",
    "E_lost": "energy lost in all impacts so far (rigid contacts only)",
}

# Results: unit and meaning. Those of the setup come first.
RESULTS = {
    "clearance_left, clearance_right": ("m", "rigid-axle flange clearances"),
    "axle_height": ("m", "height of the axle above the top of rail, at rest, held at Y = 0; Z is measured from it"),
    "axle_roll": ("rad", "roll angle at rest, held at Y = 0; zero for equal sides. The column `roll` is measured from it"),
    "rest_Y, rest_Z": ("m", "Y and Z at which the wheelset rests if nothing holds it"),
    "rest_roll": ("rad", "roll angle there"),
    "frequency_1, frequency_2, frequency_3": ("Hz", "eigenfrequencies at rest; the file has them as `eigenfrequencies`. NaN if "
                                                    "rigid contacts leave fewer"),
    "end": ("", "why the run ended; in Python `run.ending`"),
    "t": ("s", "time of the last row"),
    "F_limit_left, F_limit_right": ("N", "static limit: the largest lateral force at the centre of gravity with an equilibrium"),
    "farthest_left, farthest_right": ("m", "largest and smallest Y of all steps"),
    "farthest_up, farthest_down": ("m", "largest and smallest Z of all steps"),
    "largest_roll, smallest_roll": ("rad", "largest and smallest roll of all steps"),
    "t_farthest_left, t_farthest_right, t_farthest_up, t_farthest_down, t_largest_roll, t_smallest_roll": ("s", "times of these"),
    "t_first_centre": ("s", "first passage of the centre after a flange has touched"),
    "t_return": ("s", "first passage of the centre after the wheelset has turned back on both sides"),
    "t_unloaded, t_derailment": ("s", "times at which a wheel lifts for good, and of the derailment"),
    "F_unloaded, F_derailment": ("N", "lateral forces at these times"),
    "peak_N_C": ("N", "largest normal force of a contact, over all steps"),
    "t_peak_C": ("s", "time of the largest normal force"),
    "t_first_C": ("s", "first touch of a contact; zero for one that is closed at the start. The **first contact** lasts from there "
                  "until it first opens"),
    "first_peak_N_C": ("N", "largest normal force of the first contact; NaN with rigid contacts"),
    "t_first_peak_C": ("s", "time of this force"),
    "first_duration_C": ("s", "duration of the first contact"),
    "first_impulse_C": ("N.s", "impulse of the first contact: integral of the normal force, and impulses of impacts"),
    "turn_impulse_LF, turn_impulse_RF": ("N.s", "impulse of a flange from its first touch until the wheelset moves back"),
    "pmax": ("Pa", "largest pressure of all contacts (model `halfspace`)"),
    "pmax_contact": ("", "contact of the largest pressure"),
    "t_pmax": ("s", "time of the largest pressure"),
    "pmax_y, pmax_z": ("m", "place of the largest pressure in the frame of the track"),
    "pmax_LF, pmax_RF": ("Pa", "largest pressure at the first peak of a flange"),
    "patch_LF, patch_RF": ("m2", "area under pressure then"),
    "approach_LF, approach_RF": ("m", "approach then"),
    "peak_P_C": ("N.s", "largest impulse of one impact at a contact (rigid contacts only)"),
    "t_peak_P_C": ("s", "time of the largest impulse"),
    "lost": ("J", "energy lost in impacts (rigid contacts only)"),
    "drift": ("J", "largest absolute energy error of all steps"),
    "t_drift": ("s", "time of this error"),
    "drift_reference": ("J", "kinetic energy of lateral, vertical and roll motion at t = 0, or the largest work of the lateral "
                        "force where that is zero"),
    "drift_relative": ("", "drift over this energy"),
    "kinetic_energy": ("J", "kinetic energy of lateral, vertical and roll motion at t = 0"),
    "changes": ("", "initial values that the constraints replaced (rigid contacts only)"),
    "rows, steps, cuts, evaluations": ("", "numbers of rows, of steps, of halved steps, of evaluations of the contact forces"),
    "step": ("s", "largest step, `dt`"),
    "missed": ("", "number of steps that miss a tolerance after `max_halvings` cuts"),
    "n_KIND": ("", "number of events of a kind, for example `n_left_flange_contact`"),
    "derailed": ("", "Python only: whether the wheelset derailed"),
}


def main(words: list[str]) -> int:
    stale = []
    if TYPES.read_text() != case_types():
        stale.append(TYPES.name)
        if "--check" not in words:
            TYPES.write_text(case_types())
    for path in (DOCS.parent/"README.md", *sorted(DOCS.glob("*.md"))):
        page = path.name
        old = path.read_text()
        new = filled(old, PAGES.get(page, {}))
        if new != old:
            stale.append(page)
            if "--check" not in words:
                path.write_text(new)
    if "--check" in words and stale:
        print(f"docs: expected the tables of the program in {', '.join(stale)}, found others. "
              "Run python docs/make_tables.py", file=sys.stderr)
        return 1
    return 0


def filled(text: str, tables: dict[str, Callable[[], str]]) -> str:
    """A page with its tables made anew. SystemExit if it has other tables than these."""
    if others := set(TABLE.findall(text)) ^ tables.keys():
        raise SystemExit(f"docs: expected the tables {', '.join(tables) or 'none'} in a page, found differences: "
                         f"{', '.join(sorted(others))}")
    for name, make in tables.items():
        start, end = f"<!-- table: {name} -->\n", "<!-- end of table -->"
        before, _, rest = text.partition(start)
        text = f"{before}{start}\n{make()}\n{end}{rest.partition(end)[2]}"
    return text


def variable_tables() -> str:
    """Every variable, a table per group."""
    found = []
    for group in dict.fromkeys(variable.group for variable in variables()):
        rows = [(f"`{variable.name}`" + ("" if shortest_name(k) == variable.name else f"<br>`{shortest_name(k)}` in Python"),
                 meaning(variable.meaning, variable.name), f"`{variable.default.strip()}` {unit(variable.unit)}".strip(),
                 admitted(variable.range))
                for k, variable in enumerate(variables()) if variable.group == group]
        remark = f"{GROUPS[group]}\n\n" if group in GROUPS else ""
        found.append(f"### &{group}\n\n{remark}" + table(("name", "meaning", "default", "range"), rows))
    return "\n".join(found)


def case_types() -> str:
    """The stub by which type checkers know the variables of a case."""
    kinds = {"real": "float", "integer": "int"}
    attributes, arguments = [], []
    for k, variable in enumerate(variables()):
        words = variable.range.removeprefix("one of ").split()
        choices = f"Literal[{', '.join(map(repr, words))}]".replace("'", '"') if variable.range.startswith("one of ") else ""
        accepted = "float | str" if variable.is_slope else kinds.get(variable.kind, choices or "str | PathLike[str]")
        for name in dict.fromkeys((shortest_name(k), f"{variable.group}_{variable.name}")):
            attributes.append(f"    {name}: Final[{kinds.get(variable.kind, choices or 'str')}]")
            arguments.append(f"    {name}: {accepted}")
    return "\n".join([
        '"""Types of the variables of a case, for type checkers. docs/make_tables.py makes this file of the core\'s list."""',
        "from os import PathLike", "from typing import Final, Literal, TypedDict", "", "class Variables:", *attributes, "",
        "class Values(TypedDict, total=False):", *arguments, ""])


def unit(name: str) -> str:
    return "" if name in ("", "1") else re.sub(r"(?<=m|s)2\b", "²", name).replace(".", "·")


def admitted(words: str) -> str:
    """A range as a table has it."""
    if found := re.match(r"a (whole )?number from (\S+) to (\S+)", words):
        return f"{plain(found[2])} to {plain(found[3])}{', whole' if found[1] else ''}{', or `1:n`' if '1:n' in words else ''}"
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
    told = {re.sub(r"_(LT|LF|RT|RF)$", f"_{CONTACT}", name): unit(si) for name, si in zip(names, units, strict=True)}
    explained = {name for names in COLUMNS for name in names.split(", ")}
    if told.keys() != explained:
        raise SystemExit(f"docs: expected a meaning of every column in {__file__}, found differences: "
                         f"{sorted(told.keys() ^ explained)}")
    rows = []
    for group, words in COLUMNS.items():
        members = group.split(", ")
        if len({told[name] for name in members}) > 1:
            raise SystemExit(f"docs: expected one unit of the columns {group}, found several")
        rows.append((", ".join(f"`{name}`" for name in members), words, told[members[0]]))
    return table(("column", "meaning", "unit"), rows)


def result_table() -> str:
    """Every result of a run."""
    short = run(Case.exercise(1).replace(formulation="unilateral", t_end=1e-3, table_folder=""))
    kinds = {f"n_{re.sub('[ -]', '_', kind)}" for kind in event_kinds()}
    explained = {name for names in RESULTS for name in names.split(", ")}
    told = {name if name in explained else re.sub(r"_(LT|LF|RT|RF)$", f"_{CONTACT}", name) for name in short.results.keys() - kinds}
    told |= {"n_KIND", "end"}
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
        usage = " ".join((name, *arguments))
        options = [" ".join(filter(None, (*action.option_strings[:1], action.metavar))) for action in actions
                   if action.option_strings]
        rows.append((f"`{usage}`", COMMANDS[name], ", ".join(f"`{word}`" for word in options)))
    return table(("command", "what it does", "options"), rows)


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
    "README.md": {"results in short": short_table, "needs": need_table},
    "input.md": {"the call": constants.call_table, "clearances": constants.clearance_table, "ten runs": run_table,
                 "variables": variable_tables},
    "output.md": {"columns": column_table, "results": result_table, "events": event_list, "limits": constants.output_table},
    "profiles.md": {"limits": constants.smoothing_table},
    "commands.md": {"commands": command_table},
    "compare.md": {"units": unit_list, "formulations": formulation_table},
    "accuracy.md": MEASURED_TABLES,
    "install.md": {"builds": build_table},
    "plug.md": PLUG_TABLES,
    "organiser.md": {"limits": constants.reading_table, "horizons": horizon_table},
    "participant.md": {"findings": constants.check_table, "files": mistake_table},
    "theory.md": {"constants": constants.theory_table},
}

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
