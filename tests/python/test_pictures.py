"""The pictures of README and of the documentation are those of today's program."""
from __future__ import annotations

import json
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


@pytest.fixture(scope="module")
def runs(shipped: dict[str, Run]) -> dict[str, RunData]:
    """The runs of the shipped inputs."""
    return {case: read_data(shipped[case].file) for case in ("ex2_aw", "ex3_aw", "ex4_aw")}


def test_pictures_of_a_moment(runs: dict[str, RunData]):
    """Each number is that of the run at the time of the picture; the caption of README says which contacts are closed."""
    for name, case in (("wheelset", "ex2_aw"), ("view_ex2_aw", "ex2_aw"), ("view_ex3", "ex3_aw")):
        told, run = numbers(name), runs[case]
        k = np.searchsorted(run.time, told["t [s]"] + 1e-9) - 1
        for key in told.keys() - {"t [s]"}:
            assert run.values(key.removesuffix(" [N]"))[k] == pytest.approx(told[key], rel=1e-3, abs=1.0), (name, key)
    told = numbers("wheelset")
    assert told["N_LF [N]"] > 0 == told["N_LT [N]"] == told["N_RT [N]"]


def test_picture_of_two_laws(runs: dict[str, RunData], read_hertz: Callable[[str], ldbench.ContactTable]):
    told = numbers("ex2_aw")
    case = ldbench.Case.exercise(2, "aw").replace(model="hertz", table_folder="")
    hertz = ldbench.run(case, table=read_hertz("aw").for_case(case))
    assert [told[f"t_return [s].{law}"] for law in ("halfspace", "hertz")] == pytest.approx(
        [runs["ex2_aw"].time[-1], hertz.time[-1]], abs=1e-3)
    assert np.log10(told["drift [J].halfspace"]/runs["ex2_aw"].results["drift"]) == pytest.approx(0, abs=0.3)


def test_picture_of_formulations(runs: dict[str, RunData]):
    told = numbers("ex4_formulations")
    assert [key.partition(".")[2] for key, value in told.items() if key.startswith("derailed") and value] == ["bilateral"]
    rigid = ldbench.run(ldbench.Case.exercise(4, "aw").replace(formulation="unilateral", restitution=0.5))
    for name, run in ("elastic", runs["ex4_aw"]), ("unilateral, e = 0.5", rigid):
        assert told[f"t [s].{name}"] == pytest.approx(run.time[-1], abs=1e-3)


def test_picture_of_a_profile():
    files = {f"{kind}_profile": str(REPO/f"profiles/{name}.yz") for kind, name in (("wheel", "s1002"), ("rail", "60e1"))}
    case = ldbench.Case().replace(**files, gauge=1.435, back_to_back=1.36, formulation="unilateral", table_folder="")
    told = numbers("profile")["clearance [m]"]
    assert ldbench.ContactTable(case).clearance == pytest.approx(told, abs=1e-7)
    assert f"{1e3*told:.3f}" in (REPO/"docs/profiles.md").read_text()
