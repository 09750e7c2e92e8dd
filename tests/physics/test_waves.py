"""Waves of a measured profile: the geometry is that of its points, and a run tells what their smoothing changes."""
from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

import shapes
from geometry_table import cone, waved
from ldbench import Case, ContactTable, Profile, run
from ldbench.__main__ import main
from ldbench.geometry.pair import Pair, pair
from rigid_numpy import Level, read
from running import REPO, header

TRACK = {"gauge": 1.435, "back_to_back": 1.36}
RAIL = REPO/"profiles/60e1.yz"
AMPLITUDES = 1.0, 2.0, 3.0      # [mm]


def s1002() -> np.ndarray:
    return read(REPO/"profiles/s1002.yz")


# Shape without noise, and standard deviation of the noise of its file's points [mm].
WAVES = {"S1002, 10 um, 6 mm": (lambda: waved(s1002(), 0.010, 6), 2e-4),
         "S1002, 20 um, 10 mm": (lambda: waved(s1002(), 0.020, 10), 3e-4),
         "cone 1:40, 5 um, 8 mm": (lambda: waved(cone(1/40), 0.005, 8, 1.0), 4e-4),
         "cone 1:20, 15 um, 9 mm": (lambda: waved(cone(1/20), 0.015, 9, 2.0), 5e-4)}


class Wave(NamedTuple):
    """A file of MiniProf."""
    path: Path
    shape: np.ndarray       # without noise
    points: np.ndarray      # of the file


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Wave]:
    """Files of MiniProf with the shapes and the points that they were made of."""
    folder, found = tmp_path_factory.mktemp("waves"), {}
    for k, (name, (make, noise)) in enumerate(WAVES.items()):
        shape = make()
        points = shapes.noisy(shape, noise, k + 1).round(5)
        found[name] = Wave(folder/f"wave{k}.whl", shape, points)
        found[name].path.write_text(shapes.miniprof(points, "wheel", digits=5))
    return found


def placed(wheel: Path | Profile) -> Pair:
    return pair(Case(wheel_profile=wheel, rail_profile=RAIL, **TRACK))


def conicities(found: Pair) -> list[float]:
    return [found.level.conicity_at(1e-3*amplitude) for amplitude in AMPLITUDES]


@pytest.mark.parametrize("name", WAVES)
def test_conicity_is_that_of_the_points(name: str, files: dict[str, Wave], tmp_path: Path):
    """The conicity of the file and of what is written for a run is that of the shape, by numpy; with smoothing 0 it is that of the
    points with their noise. The smoothing of a run would give another one, and the pair says so."""
    path, shape, points = files[name]
    expected, raw = ([Level.of(one, read(RAIL)).conicity(amplitude) for amplitude in AMPLITUDES]
                     for one in (shape, points))
    wheel = Profile(path)
    assert wheel.smoothed_further and wheel.smoothing > 3*wheel.own_smoothing and 1e-4 < wheel.noise < 1e-3
    wheel.write(tmp_path/"run.yz")
    found = placed(path)
    for one, reference in ((found, expected), (placed(tmp_path/"run.yz"), expected), (placed(Profile(path, smoothing=0)), raw)):
        assert conicities(one) == pytest.approx(reference, rel=0.03, abs=3e-3)
    assert len(found.warnings) == 1 and not placed(Profile(path, smoothing=0)).warnings
    curve = tmp_path/"curve.yz"
    curve.write_text(shapes.rows(wheel.curve, digits=9))
    smoothed = [Level.of(read(curve), read(RAIL)).conicity(amplitude) for amplitude in AMPLITUDES]
    assert any(abs(one - other) > max(0.03*one, 3e-3) for one, other in zip(expected, smoothed, strict=True))
    told = re.search(r"equivalent conicity at 3 mm (\S+) -> (\S+?),", found.warnings[0])
    assert float(told[1]) == pytest.approx(expected[2], rel=0.03, abs=3e-3)
    assert float(told[2]) == pytest.approx(smoothed[2], rel=0.03, abs=3e-3)


def test_measures_are_those_of_the_points(files: dict[str, Wave]):
    """Flange height and thickness from the points; the page of the run's curve moves them by no more than it says."""
    for path, shape, _ in files.values():
        wheel = Profile(path)
        level = np.interp(70, shape[:, 0], shape[:, 1])
        tip = shape[:, 1].min()
        assert 1e3*wheel.measures["Sh"] == pytest.approx(level - tip, abs=5e-3)      # the tip is between two points
        size, y = wheel.moved
        assert 0 < size < 10*wheel.smoothing and shape[0, 0] <= y <= shape[-1, 0]
        assert any(f"up to {1e3*size:.2g} µm" in note and f"y = {y:.1f} mm" in note for note in wheel.notes)


@pytest.mark.filterwarnings("ignore::ldbench.Warning")
def test_a_run_tells_what_the_smoothing_changes(files: dict[str, Wave], tmp_path: Path):
    """Header and warnings: the numbers of the unsmoothed wheel and of the run, each by itself; nothing of wheels without waves."""
    path, *_ = files["S1002, 10 um, 6 mm"]
    case = Case(wheel_profile=path, rail_profile=RAIL, **TRACK, t_end=1e-3, interval=1e-4, model="hertz", lateral=0.02)
    done = run(case)
    said = [words for words in done.warnings if words.startswith("waves are smoothed")]
    assert len(said) == 1 and f"warning: {said[0]}\n" in header(done.write(tmp_path/"columns.txt"))
    assert "wheel wave0.whl up to " in said[0]
    plain = ContactTable(case.replace(wheel_profile=Profile(Profile(path).geometry, "wheel", smoothing=0, wheel_back=0.0)))
    size, y = Profile(path).moved
    for words in (f"up to {1e3*size:.2g} um from its points' curve, at y = {y:.1f} mm",
                  f"clearance {1e3*plain.clearance:.3f} -> {1e3*done.table.clearance:.3f} mm",
                  f"lateral frequency {plain.frequencies[0]:.3f}", f" -> {done.table.frequencies[0]:.3f} Hz"):
        assert words in said[0]
    heavier = done.table.for_case(case.replace(mass=2000.0))
    again = next(words for words in run(heavier.case, table=heavier).warnings if words.startswith("waves are"))
    assert f"-> {heavier.frequencies[0]:.3f} Hz" in again
    assert not any("waves" in words for words in run(case.replace(wheel_profile=REPO/"profiles/s1002.yz")).warnings)


def test_the_page_tells_it(files: dict[str, Wave], tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    path, *_ = files["S1002, 20 um, 10 mm"]
    sizes = [f"--set={name}={value}" for name, value in TRACK.items()]
    assert main(["profile", str(path), str(RAIL), *sizes, "-o", str(tmp_path/"page.png")]) == 0
    said = capsys.readouterr().out
    assert said.count("waves are smoothed so that a contact is one patch: wheel wave1.whl up to ") == 1
    assert re.search(r"noise of the points about 0\.0003 mm, smoothed by 0\.0003 mm, for a run smoothed by 0\.0\d+ mm", said)


@pytest.mark.parametrize("seed", [0, 4, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2, 3, 5))])
def test_points_as_they_are_stand_on_their_treads(seed: int):
    """With smoothing 0, whatever noise and waves wheel and rail have; the clearance is that of smoothed ones to some noise."""
    random = np.random.default_rng(seed)
    points = []
    for shape in s1002(), read(RAIL):
        moved = waved(shape, random.choice([0.0, 0.002, 0.01]), random.choice([3, 6, 10]), random.uniform(0, 6))
        points.append(shapes.noisy(moved, random.choice([3e-4, 3e-3, 1e-2]), seed))
    case = Case(**TRACK).replace(wheel_profile=Profile(points[0], "wheel", smoothing=0, wheel_back=0.0),
                                 rail_profile=Profile(points[1], "rail", smoothing=0))
    found = pair(case)
    assert 1e3*found.clearance[0] == pytest.approx(6.05, abs=0.4)
    expected = Level.of(*points).conicity(3.0)
    assert found.level.conicity_at(3e-3) == pytest.approx(expected, rel=0.03, abs=3e-3)
