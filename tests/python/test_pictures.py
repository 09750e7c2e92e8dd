"""The pictures of README and of the documentation are those of today's program, and their captions tell its numbers."""
from __future__ import annotations

import json
import re
from collections.abc import Callable

import numpy as np
import pytest
from PIL import Image

import ldbench
from ldbench.results.run_data import RunData, read_data
from running import REPO, Run


def numbers(name: str) -> dict[str, float]:
    """The numbers that a picture keeps."""
    with Image.open(REPO/f"outputs/reference/{name}.png") as picture:
        return json.loads(picture.text["numbers"])


def caption(page: str, name: str) -> str:
    """The words below a picture, without the names of numbers."""
    words = (REPO/page).read_text().partition(f"outputs/reference/{name}.png)")[2].strip().partition("\n\n")[0]
    return re.sub(r"<!--.*?-->", "", words)


@pytest.fixture(scope="module")
def runs(shipped: dict[str, Run]) -> dict[str, RunData]:
    """The runs of the shipped inputs."""
    return {case: read_data(shipped[case].file) for case in ("ex2_aw", "ex3_aw", "ex4_aw")}


def row_at(run: RunData, column: str, t: float) -> float:
    return float(run.values(column)[np.searchsorted(run.time, t + 1e-9) - 1])


@pytest.mark.parametrize(("name", "case"), [("wheelset", "ex2_aw"), ("view_ex2_aw", "ex2_aw"), ("view_ex3", "ex3_aw")])
def test_pictures_of_a_moment_are_of_the_run(name: str, case: str, runs: dict[str, RunData]):
    told = numbers(name)
    for key, value in told.items():
        if key != "t [s]":
            column = key.removesuffix(" [N]")
            assert row_at(runs[case], column, told["t [s]"]) == pytest.approx(value, rel=1e-3, abs=1.0), key


def test_caption_of_the_wheelset_tells_its_force(runs: dict[str, RunData]):
    words = caption("README.md", "wheelset")
    found = re.search(r"([\d.]+) ms after the start. The left flange carries (\d+) kN and the treads have lifted off", words)
    time, force = found.groups()
    told = numbers("wheelset")
    assert time == f"{1e3*told['t [s]']:.1f}" and force == f"{1e-3*row_at(runs['ex2_aw'], 'N_LF', told['t [s]']):.0f}"
    assert told["N_LT [N]"] == told["N_RT [N]"] == 0


def test_picture_and_caption_of_two_laws_are_of_the_runs(runs: dict[str, RunData],
                                                         read_hertz: Callable[[str], ldbench.ContactTable]):
    told, words = numbers("ex2_aw"), caption("docs/compare.md", "ex2_aw")
    assert told["t_return [s].halfspace"] == pytest.approx(runs["ex2_aw"].time[-1], abs=1e-3)
    case = ldbench.Case.exercise(2, "aw").replace(model="hertz", table_file="")
    hertz = ldbench.run(case, table=read_hertz("aw").for_case(case))
    assert told["t_return [s].hertz"] == pytest.approx(hertz.time[-1], abs=1e-3)
    shown = [float(x) for x in re.findall(r"(\d\.\de-\d+) J", words)]
    # Drift is rounding and step control: its size is told, not its digits on another machine. Two digits round by 5 % at most.
    assert shown == pytest.approx([told["drift [J].halfspace"], told["drift [J].hertz"]], rel=0.05)
    assert np.log10(told["drift [J].halfspace"]/runs["ex2_aw"].result("drift")) == pytest.approx(0, abs=0.3)


def test_picture_and_caption_of_formulations_are_of_the_runs(runs: dict[str, RunData]):
    told, words = numbers("ex4_formulations"), " ".join(caption("docs/compare.md", "ex4_formulations").split())
    derailed = {key.partition(".")[2]: value for key, value in told.items() if key.startswith("derailed")}
    assert [name for name, value in derailed.items() if value] == ["bilateral"]
    assert "rolls over the left flange and derails" in words
    assert told["t [s].elastic"] == pytest.approx(runs["ex4_aw"].time[-1], abs=1e-3)
    assert f"{runs['ex4_aw'].result('kinetic_energy'):.0f} J" in words
    rigid = ldbench.run(ldbench.Case.exercise(4, "aw").replace(formulation="unilateral", restitution=0.5))
    assert told["t [s].unilateral, e = 0.5"] == pytest.approx(rigid.time[-1], abs=1e-3)


def test_picture_of_a_profile_is_of_the_pair():
    files = [str(REPO/f"profiles/{name}.yz") for name in ("s1002", "60e1")]
    case = ldbench.Case().replace(wheel_profile=files[0], rail_profile=files[1], gauge=1.435, back_to_back=1.36,
                                  formulation="unilateral", table_file="")
    assert ldbench.ContactTable(case).clearance == pytest.approx(numbers("profile")["clearance [m]"], abs=1e-7)
    assert f"{1e3*numbers('profile')['clearance [m]']:.3f}" in (REPO/"docs/profiles.md").read_text()
