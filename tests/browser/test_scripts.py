"""The page's scripts without a browser: their syntax, derived columns and the reader of links, run by node."""
from __future__ import annotations

import json
import math
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ldbench
from ldbench.viewer.page import SCRIPTS, run_entry
from running import HANG
from specimen import World

NODE = shutil.which("node")
FILES = {path.name: path for path in sorted(Path(ldbench.__file__).parents[1].rglob("*.js"))}         # of both packages

pytestmark = pytest.mark.skipif(NODE is None, reason="no node")


def ask(task: str, scripts: tuple[str, ...], **question: object) -> Any:
    """What in_node.js answers."""
    text = json.dumps({"task": task, "scripts": [str(FILES[name]) for name in scripts], **question})
    done = subprocess.run([NODE, Path(__file__).with_name("in_node.js")], input=text, capture_output=True, encoding="utf-8",
                          timeout=HANG)
    assert done.returncode == 0 and done.stderr == "", done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize("name", sorted(FILES.keys() - set(SCRIPTS)))
def test_syntax(name: str):
    """No other test here reads these scripts."""
    done = subprocess.run([NODE, "--check", FILES[name]], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_loads_of_wheels(world: World):
    """L/V, V and L: the page and its scripts have the numbers of the rows, none where a wheel carries nothing."""
    raw = world.pushed
    loads = wheel_columns(world.run("ex5_aw"))
    forces = {name: x.tolist() for name, x in raw.c.items() if name[:2] in ("Fy", "Fz")}
    found = ask("derive", ("series.js", "derived.js"), exact=forces)
    assert set(loads) == {f"{kind}_{side}" for kind in ("LV", "Fz", "Fy") for side in "LR"}
    for side in "LR":
        expected = {"LV": raw.ratio(side), "Fz": raw.loads(side), "Fy": raw.c[f"Fy_{side}T"] + raw.c[f"Fy_{side}F"]}
        assert np.isnan(expected["LV"]).sum() > 100
        for kind, x in expected.items():
            for shown in loads, found:
                np.testing.assert_allclose(np.array(shown[f"{kind}_{side}"], float), x, rtol=1e-12, err_msg=f"{kind}_{side}")


# Links

HOSTILE = ("a&with=b", "#t=1", "100 %", "%00", "%E0%A4%A", "a+b c", "<img src=x onerror=alert(1)>", "</script>", "\"'`${1}",
           "Größe 力 ñ \u2028", "__proto__", "constructor", "")
RUNS = [{"name": "ex2_aw", "shown": True}, {"name": "ex2_sw", "shown": True}, {"name": "other", "shown": False}]
AT_FIRST = {"shown": ["ex2_aw", "ex2_sw"]}


def followed(*fragments: str, runs: list[dict[str, object]] | None = None) -> list[dict[str, Any]]:
    """To which time and view each fragment leads from 5 ms, where it does, and the runs that it shows."""
    return ask("follow", SCRIPTS, runs=runs or RUNS, t=5e-3, fragments=fragments)


def test_links_are_followed():
    expected = {
        "#t=0.02213&view=left": AT_FIRST | {"time": 0.02213, "view": "left"},
        "#t=1e-3": AT_FIRST | {"time": 1e-3},
        "#t=0.005&view=whole": AT_FIRST | {"view": "whole"},
        "#run=other": {"shown": ["other"]},
        "#view=right&with=other&run=ex2_sw&t=-1": {"shown": ["ex2_sw", "other"], "time": -1, "view": "right"},
        "#t=0.01&t=0.02": AT_FIRST | {"time": 0.01},
        "#run=ex2%5Faw": {"shown": ["ex2_aw"]},
    }
    assert dict(zip(expected, followed(*expected), strict=True)) == expected


def test_links_lead_to_what_they_were_made_of():
    """Whatever the names of the runs, and to nine digits of the time."""
    runs = [{"name": name, "shown": False} for name in HOSTILE[:-1]]
    moments = [{"t": math.pi*10.0**-k, "names": [run["name"] for run in runs[k:k + 1 + k % 3]], "view": ("whole", "left")[k % 2]}
               for k in range(len(runs))]
    links = ask("link", SCRIPTS, moments=moments)
    for moment, link, found in zip(moments, links, followed(*links, runs=runs), strict=True):
        assert found["shown"] == moment["names"], link
        assert found.get("view", "whole") == moment["view"]
        assert found["time"] == pytest.approx(moment["t"], rel=5e-9)
