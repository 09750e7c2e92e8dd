"""What commands print for other programs: every number, in SI, is the one that the rows say."""
from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ldbench import ContactTable
from ldbench.__main__ import main
from probes import turned
from raw import Raw
from reading import numbers_that_differ
from specimen import World
from table import FULLNESS, in_results

Told = Mapping[str, Any]


def asked(capsys: pytest.CaptureFixture[str], *words: str) -> dict[str, Any]:
    """What a command prints as JSON."""
    assert main([*words, "--json", "-q"]) == 0
    return json.loads(capsys.readouterr().out)


def of_place(raw: Raw) -> Told:
    """What the core knows of the place of the wheelset before the run: clearances of the call, equilibrium, its frequencies."""
    return {"clearance_left": (10.18e-3, 1e-3), "clearance_right": (16.94e-3, 1e-3), "axle_height": raw.setting("axle_height"),
            "axle_roll": raw.setting("axle_roll")}


def of_event(raw: Raw) -> Any:
    """The fields of an event: those of the file, which test_results_in_the_column_file compares with the rows."""
    def told(match: re.Match[str]) -> object:
        t, _, more = raw.events[int(match[1])]
        return {"t": t, "loss": 0.0}.get(match[2], more.get(match[2]))
    return told


@pytest.mark.parametrize("name", ["ex2_aw", "ex5_aw"])
def test_run(name: str, world: World, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    """Results and events of the rows that the run writes; what did not happen is null."""
    monkeypatch.chdir(world.folder)
    file = tmp_path/f"{name}.txt"
    told = asked(capsys, "run", f"inputs/{name}.nml", "-o", str(file))
    raw = Raw(file)
    assert (told["case"], told["file"], told["derailed"]) == (name, str(file), name == "ex5_aw")
    results = in_results(raw)
    by_rows = {key: (x[0], x[1] or 1e-9, x[2]) for key, x in results.items() if x}
    assert numbers_that_differ(told, {
        **of_place(raw), **by_rows, r"frequency_(\d)": lambda m: raw.settings("eigenfrequencies")[int(m[1]) - 1],
        r"F_limit_left|F_limit_right|rest_\w+": lambda m: raw.setting(m[0]),
        r"(?:t_)?peak_P_\w\w|lost|n_impact|n_rail_pulls": 0.0,                                        # of rigid contacts
        r"events\.(\d+)\.(\w+)": of_event(raw), "seconds": told["seconds"],
        # The file has what no row tells, or it did not happen.
        r"\w+": lambda m: raw.result(m[0]) if f" {m[0]} = " in raw.text[len(raw.head):] else None}) == []
    assert told["seconds"] > 0


def test_table(world: World, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    """Place, load and errors as in the head of the column file; the axle sinks by what wheels and rails overlap."""
    monkeypatch.chdir(world.folder)
    raw = world.thrown
    told = asked(capsys, "table", "inputs/ex2_aw.nml")
    assert numbers_that_differ(told, {
        **of_place(raw), "sinking": (float(np.mean([raw.overlap(c, 0, at_rest=True) for c in ("LT", "RT")])), 5e-3),
        "load_per_wheel": raw.weight/2, r"frequencies\.(\d)": lambda m: raw.settings("eigenfrequencies")[int(m[1])],
        r"error\.(\w+)\.(rms|largest)": lambda m: raw.errors()[m[1]][m[2] == "largest"],
        r"solutions\.(solved|not_converged)": 0, r"solutions\.found": told["solutions"]["found"]}) == []
    assert told["solutions"]["found"] > 1000 and set(told["error"]) == set(raw.errors())
    # In words: the vertical stiffness is by how much the rails push more when the resting wheelset is lowered.
    assert main(["table", "inputs/ex2_aw.nml"]) == 0
    stiffness = float(re.search(r"vertical stiffness (\S+) kN/mm", capsys.readouterr().out)[1])
    table, step = ContactTable("inputs/ex2_aw.nml"), 1e-7
    up, down = (table.force(0.0, table.equilibrium + way*step, 0.0)[1] for way in (1, -1))
    assert stiffness == pytest.approx(1e-6*(down - up)/(2*step), rel=1e-3)


@pytest.mark.parametrize("contact", ["LF", "RF"])
def test_pressure(contact: str, world: World, tmp_path: Path, undrawn: None, capsys: pytest.CaptureFixture[str]):
    """Force, place and angle are those of the columns, the approach is the overlap, the rest goes with them as in an ellipse."""
    raw = world.thrown
    k = raw.first_peak(contact)
    words = "--at", repr(float(raw.t[k])), "--contact", contact, "-o", str(tmp_path/"p.pdf")
    told = asked(capsys, "pressure", str(raw.file), *words)
    one, = told["patches"]
    side = {"L": 1, "R": -1}[contact[0]]
    force, area = raw.c[f"N_{contact}"][k], one["area"]
    place = side*raw.c[f"y_{contact}"][k], raw.c[f"z_{contact}"][k]
    # The place as the wheel has it, seen from the centre of the axle.
    away = np.array(place) - [side*raw.c["Y"][k], raw.setting("axle_height") + raw.c["Z"][k]]
    in_wheel, = turned(away[None], -side*(raw.c["roll"][k] + raw.setting("axle_roll")))
    whole = np.pi*one["half_x"]*one["half_s"]
    assert one["contact"] == contact and area == pytest.approx(whole, rel=0.25)
    patch = r"patches\.0\."
    assert numbers_that_differ(told, {
        "time": raw.t[k], rf"{patch}force": force, rf"{patch}integral": (force, 0.04),
        rf"{patch}largest": (force/area/FULLNESS[0], 0.05),
        rf"{patch}mean": (force/area, 0.04), rf"{patch}angle": abs(raw.c[f"angle_{contact}"][k]),
        rf"{patch}approach": (raw.overlap(contact, k), 4e-3), rf"{patch}area": (whole, 0.25),
        rf"{patch}energy": (0.4*force*raw.overlap(contact, k), 0.1),
        rf"{patch}centre\.([01])": lambda m: ([side, 1][int(m[1])]*place[int(m[1])], 2e-3, 2e-4),
        rf"{patch}half_x": (one["hertz"]["half_x"], 0.3), rf"{patch}half_s": (one["hertz"]["half_s"], 0.3),
        rf"{patch}s_centre": (np.mean(one["s_ends"]), 0.1), rf"{patch}s_ends\.([01])": lambda m: (
            one["s_centre"] + (-1, 1)[int(m[1])]*one["half_s"], 0.1),
        rf"{patch}centre_wheel\.([01])": lambda m: ([side, 1][int(m[1])]*in_wheel[int(m[1])], 2e-3),
        rf"{patch}hertz\.area": (np.pi*one["hertz"]["half_x"]*one["hertz"]["half_s"], 1e-9),
        rf"{patch}hertz\.half_(\w)": lambda m: (one[f"half_{m[1]}"], 0.3),
        rf"{patch}hertz\.largest": (1.5*one["integral"]/one["hertz"]["area"], 1e-6)}) == []
