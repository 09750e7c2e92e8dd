"""Measured and worn profiles: what the program makes of them."""
import re
from pathlib import Path

import numpy as np
import pytest

import ldbench
import shapes
from probes import table_file
from running import REPO, Run, columns, header, run_case, short_case

WHEEL, RAIL = shapes.shape("awprof").round(7), shapes.shape("arprof").round(7)


def run(folder: Path, wheel: str, rail: str, model: str = "strip",
        wheel_back: float | None = None) -> tuple[float, np.ndarray, str]:
    """Clearance [mm], Y over time [m] and header of a short run with two profile texts, as Python converts them.

    The model hertz is quick and suits where nobody looks at Y.
    """
    folder.mkdir(exist_ok=True)
    for kind, text in ("wheel", wheel), ("rail", rail):
        (folder / kind).write_text(text)
        back = {"wheel_back": wheel_back} if kind == "wheel" else {}
        ldbench.Profile(folder / kind, kind, **back).write(folder / f"{kind}.yz")
    # Fast enough to reach a flange.
    text = short_case(folder, profiles={f"{kind}_profile": folder / f"{kind}.yz" for kind in ("wheel", "rail")},
                      contact={"model": model}, initial={"vY": 2.0, "roll_rate": 0.0667}, integrator={"dt": 1e-4, "t_end": 8e-3})
    done = run_case(text, folder)
    assert done.returncode == 0, done.stderr
    said = header(folder / "columns.txt")
    for line in re.findall(r"^\w+ profile: .*, CRC-32 \w+, .*$", said, re.M):
        assert line in " ".join(done.stdout.split())      # what the header says of a file, the summary says too, in lines of 100
    clearance = float(re.search(r"clearance \[mm\]: 2 x (\S+)", done.stdout)[1])
    return clearance, columns(folder / "columns.txt")["Y"], said


def files(**wheel_and_rail: np.ndarray) -> dict[str, str]:
    return {kind: shapes.rows(points) for kind, points in wheel_and_rail.items()}


@pytest.fixture(scope="module")
def clean(tmp_path_factory: pytest.TempPathFactory) -> tuple[float, np.ndarray, str]:
    return run(tmp_path_factory.mktemp("clean"), **files(wheel=WHEEL, rail=RAIL))


@pytest.mark.parametrize(("spacing", "noise"), [(0.02, 0.03), (0.4, 0.01)])
def test_noisy_points(spacing, noise, clean, tmp_path):
    """Dense points double back by their noise, sparse ones do not: with smoothing the run is that of the clean file."""
    wheel, rail = (shapes.noisy(shapes.shape(name, spacing), noise, seed) for seed, name in enumerate(("awprof", "arprof")))
    clearance, y, said = run(tmp_path, **files(wheel=wheel, rail=rail))
    assert clearance == pytest.approx(clean[0], abs=2*noise)
    assert y == pytest.approx(clean[1], abs=3e-3*noise)    # of 12 mm, after an impact at 2 m/s
    if spacing == 0.02:
        assert "put together to one" in said


@pytest.mark.parametrize("worn", shapes.WORN_WHEELS)
def test_worn_wheel(worn, tmp_path):
    """It runs on a worn rail, and with faces and noise, in another format, as it does clean."""
    wheel = shapes.WORN_WHEELS[worn](WHEEL)
    clearance, _, _ = run(tmp_path / "clean", **files(wheel=wheel, rail=shapes.side_worn(RAIL)), model="hertz")
    assert 5 < clearance < 16
    measured, _, _ = run(tmp_path / "measured", shapes.miniprof_old(shapes.noisy(shapes.with_faces(wheel), 0.01, 3), "wheel"),
                         shapes.rows(shapes.noisy(shapes.side_worn(RAIL), 0.01, 4)), "hertz")
    # Worn shapes conform: where tread ends and flange begins is less certain.
    assert measured == pytest.approx(clearance, abs=0.3)


def test_conforming_profiles(tmp_path):
    """A wheel of the rail's own shape, 0.1 mm off, from crown to gauge corner, with many arcs of either sign."""
    clearance, _, _ = run(tmp_path, **files(wheel=shapes.conforming(RAIL), rail=RAIL), wheel_back=0.0)
    assert 0.05 < clearance < 6


@pytest.mark.parametrize(("law", "pair"), [
    ("halfspace", "aw"), ("halfspace", "sw"), ("strip", "aw"), ("hertz", "S1002 on 60E1"), ("hertz", "measured")])
def test_force_grows_with_sinking(law: str, pair: str, shipped: dict[str, Run], strip_tables: dict[str, Path], tmp_path: Path):
    """On 275 curves, to 1.1 times the clearance on either side and 10 mrad of roll, F_z of the left wheel never falls while the
    wheel sinks by 0.4 mm in steps of 10 um. The measured profiles have noise of 10 um."""
    case = ldbench.Case.exercise(2, "sw" if pair == "sw" else "aw").replace(
        model=law, **{"table_file": ""} | ({"accuracy": 6e-3} if law == "hertz" else {"table_file": strip_tables[pair]}
                                          if law == "strip" else {"table_file": table_file(shipped, pair)}))
    if pair == "S1002 on 60E1":
        case = case.replace(wheel_profile=str(REPO/"profiles/s1002.yz"), rail_profile=str(REPO/"profiles/60e1.yz"), gauge=1.435,
                            back_to_back=1.36, n_lateral=120, n_roll=17, n_depth=17)
    if pair == "measured":
        for name, points in ("wheel", WHEEL), ("rail", RAIL):
            (tmp_path/name).write_text(shapes.rows(shapes.noisy(points, 0.01, 4)))
            case = case.replace(**{f"{name}_profile": str(tmp_path/name)})
    table = ldbench.ContactTable(case)
    y, roll, z = np.meshgrid(1.1*table.clearance*np.linspace(-1, 1, 55), np.linspace(-0.01, 0.01, 5),
                             table.rest[1] + np.arange(2e-2, -1e-2, -1e-5), indexing="ij")
    force = table.force(y, z, roll, "left", "nan")[..., 1]
    sinks = (force > 0) & (np.cumsum(force > 0, axis=2) <= 40)
    growth = np.diff(force, axis=2)[sinks[..., :-1] & sinks[..., 1:]]
    assert len(growth) > 9_000 and growth.min() > 0


# A stretch of the hollow tread passes beside the rail where the table has its middle, and touches farther out; the half-spaces of
# a wide tread are pressed to the largest roll angle of a wheelset that rolls over.
ROLLING_OVER = {"hollow": ("strip", 1e-2, lambda wheel: shapes.hollow_beside_throat(shapes.wide(wheel), 3.0)),
                "wide": ("halfspace", 6e-3, shapes.wide)}


@pytest.mark.parametrize("worn", ROLLING_OVER)
def test_table_holds_where_a_wide_wheel_rolls_over(worn, tmp_path):
    """The rms error in rolling over is within what a run with `&table accuracy` 2e-3 may have without a warning, 10 times that,
    though the table is asked for less. One pose of 150, 21 degrees from upright, makes the most of it."""
    model, accuracy, shape = ROLLING_OVER[worn]
    (tmp_path / "wheel").write_text(shapes.rows(shape(np.loadtxt(REPO / "profiles/awprof.yz", comments=("#", "!")))))
    text = short_case(tmp_path, profiles={"wheel_profile": tmp_path / "wheel", "rail_profile": REPO / "profiles/arprof.yz"},
                      contact={"model": model}, integrator={"dt": 1e-4, "t_end": 1e-3},
                      table={"accuracy": accuracy, "n_lateral": 360, "n_roll": 160, "n_depth": 40})
    done = run_case(text, tmp_path)
    assert done.returncode == 0, done.stderr
    assert float(re.search(r"going over (\S+) ", done.stdout)[1]) <= 2e-2


def test_table_holds_where_faces_of_wheel_and_rail_are_straight(tmp_path):
    """All stations of a straight flange face have one angle; the rail's corner and its straight face meet there as the wheelset
    rolls. The force on the flange has half of the error that a run with `&table accuracy` 2e-3 may have without a warning, though
    the table is asked for less."""
    wheel, rail = (np.loadtxt(REPO / f"profiles/{name}.yz", comments=("#", "!")) for name in ("awprof", "arprof"))
    (tmp_path / "wheel").write_text(shapes.rows(wheel))
    (tmp_path / "rail").write_text(shapes.rows(shapes.straight_face(rail, 75.3)))     # the wheel's face: 75 degrees
    text = short_case(tmp_path, profiles={"wheel_profile": tmp_path / "wheel", "rail_profile": tmp_path / "rail"},
                      contact={"model": "strip"}, integrator={"dt": 1e-4, "t_end": 1e-3},
                      table={"accuracy": 6e-3, "n_lateral": 360, "n_roll": 160, "n_depth": 40})
    done = run_case(text, tmp_path)
    assert done.returncode == 0, done.stderr
    assert float(re.search(r"flange (\S+) ", done.stdout)[1]) < 1e-3
