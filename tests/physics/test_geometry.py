"""Wheels as they stand on rails: measures, clearance, conicity and warnings, against numpy alone from the points of the files."""
from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import geometry_table
import shapes
from geometry_table import cone, rails, waved
from ldbench import Case, ContactTable, Profile, read_run, run
from ldbench.__main__ import main
from ldbench.geometry.outlines import case_outlines
from ldbench.geometry.pair import Pair, pair
from ldbench.profiles.measures import survey
from ldbench.profiles.profile import frames_of
from rigid_numpy import Level, read, turned
from running import REPO, header, run_case, short_case

TRACK = {"gauge": 1.435, "back_to_back": 1.36}
CANT = float(np.arctan(1/40))
S1002, RAIL_60E1 = REPO/"profiles/s1002.yz", REPO/"profiles/60e1.yz"
SMALL = {"model": "hertz", "lateral": 0.02, "table_folder": ""}     # a table that is built in little time


def placed(wheel: Path | Profile, rail: Path, **changes: object) -> Pair:
    return pair(Case(wheel_profile=wheel, rail_profile=rail, **TRACK).replace(changes))


def warned(case: Case, word: str) -> list[str]:
    """The warnings with a word of a run of no length."""
    done = run(case.replace(SMALL, t_end=1e-3, interval=1e-4, stop_at="t_end"))
    return [words for words in done.warnings if word in words]


QUICK = [("S1002, noise 3 um", "1:40")]     # tests/python/test_en15302.py has the wheels of the standard


@pytest.mark.parametrize(("wheel", "lean"), [
    pytest.param(*one, marks=() if one in QUICK else pytest.mark.slow) for one in geometry_table.PAIRS])
def test_numbers_are_those_of_the_points(wheel: str, lean: str, tmp_path: Path):
    """Measures, clearance and conicity, level and rolled, of many pairs."""
    ours, theirs, _ = geometry_table.numbers(wheel, lean, tmp_path)
    assert geometry_table.outside(ours, theirs) == []


# Rails that lean


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A cylinder, and the rail 60E1 as it is published: upright."""
    folder = tmp_path_factory.mktemp("profiles")
    found = {name: folder/f"{name}.yz" for name in ("cylinder", "upright")}
    for name, points in ("cylinder", cone(0.0)), ("upright", rails()["60E1"]):
        found[name].write_text(shapes.rows(points, digits=9))
    return found


# Conicity at 3 mm of S1002 on 60E1, by an independent program from the same files.
PUBLISHED = {"0": 0.137, "1:40": 0.174, "1:20": 0.009}


@pytest.mark.parametrize("lean", ["0", "1:20"])
def test_conicity_is_the_published_one(lean: str, files: dict[str, Path]):
    found = placed(S1002, files["upright"], rail_inclination=lean)
    assert found.level.conicity_at(3e-3) == pytest.approx(PUBLISHED[lean], abs=1e-3)


def test_turned_rails_are_turned_files(files: dict[str, Path], tmp_path: Path):
    """A file whose points were turned before gives the same rail; the top stays at z = 0, the gauge point at half the gauge. The
    inclination is the case's: the measures of the profile stay."""
    (tmp_path/"turned.yz").write_text(shapes.rows(turned(read(files["upright"]), CANT), digits=9))
    case = Case(wheel_profile=S1002, rail_profile=tmp_path/"turned.yz", **TRACK)
    by_file = case_outlines(case)
    by_angle = case_outlines(case.replace(rail_profile=files["upright"], rail_inclination="1:40"))
    assert by_angle.clearance == pytest.approx(by_file.clearance, abs=1e-9)
    assert np.allclose(by_angle.left.rail, by_file.left.rail, atol=1e-10)
    y, z = by_angle.left.rail.T
    face = slice(0, z.argmax() + 1)
    assert z.max() == pytest.approx(0, abs=1e-12)
    assert np.interp(-0.014, z[face], y[face]) == pytest.approx(TRACK["gauge"]/2, abs=1e-6)
    assert survey("rail", *frames_of(1e3*np.column_stack([y, z])), 0.014)[1]["inclination"] == pytest.approx(CANT, abs=2e-5)
    assert abs(Profile(files["upright"]).measures["inclination"]) < 1e-5


def test_words_and_numbers(tmp_path: Path):
    """A slope in quotes, without them, and the angle of it are one; 0 is as nothing. Headers have what is not 0, and read it."""
    texts = {}
    given = {"quoted": "'1:40'", "plain": "1:40", "number": f"{CANT!r}", "none": "", "zero": "0", "minus": "'-1:40'"}
    for name, words in given.items():
        text = short_case(tmp_path, table={"folder": tmp_path/"tables"})
        if words:
            text = text.replace("&initial", f"&track\n  rail_inclination = {words}\n/\n&initial", 1)
        done = run_case(text, tmp_path)
        assert done.returncode == 0, done.stderr
        texts[name] = (tmp_path/"columns.txt").read_bytes(), header(tmp_path/"columns.txt")
        case = read_run(tmp_path/"columns.txt").case
        assert case.rail_inclination == {"none": 0, "zero": 0, "minus": -CANT}.get(name, CANT)
    assert texts["quoted"] == texts["plain"] == texts["number"] and texts["minus"][0] != texts["quoted"][0]
    assert texts["none"] == texts["zero"] and "inclin" not in texts["none"][1].replace(str(REPO), "")
    assert f"  rail_inclination = {CANT!r}  ! rad\n" in texts["quoted"][1]
    assert f", inclined by {-CANT!r} rad beyond its file\n" in texts["minus"][1]
    assert len(list((tmp_path/"tables").iterdir())) == 3       # a table for each inclination


def test_cases_of_python():
    case = Case(rail_inclination="1:40", rail_inclination_right="-1:20")
    assert (case.rail_inclination, case.rail_inclination_right) == (CANT, "-1:20")
    assert Case.from_namelist(case.to_namelist()) == case == eval(repr(case))
    assert Case(rail_inclination=np.float64(0.02), rail_inclination_right=0.02).rail_inclination_right == "0.02"
    with pytest.raises(ValueError, match=r"&track rail_inclination: expected a number from .* rad, or 1:n, found '1:5'"):
        Case(rail_inclination="1:5")


@pytest.mark.filterwarnings("ignore::ldbench.Warning")
def test_one_warning_where_a_design_rail_stands_upright(files: dict[str, Path]):
    """Under a coned wheel alone, until an inclination is given. It tells the mean slope of the tread over 20 mm."""
    upright = Case(wheel_profile=S1002, rail_profile=files["upright"], **TRACK)
    said = warned(upright, "upright")
    assert len(said) == 1 and "&track rail_inclination" in said[0]
    told = re.search(r"upright\.yz is symmetric and stands upright under a wheel coned 1:(\d+);", said[0])
    wheel = read(S1002)
    running = ContactTable(upright.replace(formulation="unilateral")).geometry([0.0]).y_L[0]*1e3 - 680
    ends = np.interp([running - 10, running + 10], *wheel[wheel[:, 1].argmin():].T)
    assert abs(20/(ends[1] - ends[0]) - int(told[1])) < 0.02*int(told[1]) + 0.5
    for case in upright.replace(rail_inclination="1:40"), upright.replace(wheel_profile=files["cylinder"]), Case.exercise(1, "sw"):
        assert warned(case, "upright") == []


@pytest.mark.usefixtures("undrawn")
def test_the_command(files: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    sizes = [f"--set={name}={value}" for name, value in TRACK.items()]
    names = [str(S1002), str(files["upright"]), *sizes, "-o", str(tmp_path/"page.png")]
    assert main(["profile", *names, "--rail-inclination", "1:40"]) == 0
    said = capsys.readouterr().out
    assert "rails inclined by 0.0250 (1:40.0) beyond their files" in said and "warning" not in said
    assert f"level {PUBLISHED['1:40']}" in said
    for wrong in "1:4", "steep":
        assert main(["profile", *names, "--rail-inclination", wrong]) == 1
        assert "&track rail_inclination: expected a number from -0.12 to 0.12 rad, or 1:n, found" in capsys.readouterr().err


def test_a_rail_without_a_gauge_face_once_it_is_turned(files: dict[str, Path], tmp_path: Path):
    """A head that goes down to the gauge point and little farther."""
    rail = read(files["upright"])
    (tmp_path/"short.yz").write_text(shapes.rows(rail[rail[:, 1] > -14.6], digits=9))
    case = Case(wheel_profile=S1002, rail_profile=tmp_path/"short.yz", **TRACK, formulation="unilateral")
    assert ContactTable(case).clearance > 0.005
    with pytest.raises(Exception, match=r"^case, &track rail_inclination = -0\.05 rad: expected a gauge face 0\.014 m "
                       r"below the top of the turned rail, found none on \S*short\.yz; give a smaller angle"):
        ContactTable(case.replace(rail_inclination=-0.05))


# Waves and noise of measured profiles


@pytest.mark.filterwarnings("ignore::ldbench.Warning")
@pytest.mark.parametrize("shape", [
    pytest.param(lambda: cone(1/40), id="cone 1:40"), pytest.param(lambda: read(S1002), id="S1002", marks=pytest.mark.slow)])
def test_conicity_of_a_wheel_with_waves(shape, tmp_path: Path):
    """The conicity of the file is that of the shape, by numpy. The smoothing of a run would give another one: the pair and every
    run say so, with the numbers of the wheel without that smoothing and of the run, each by itself."""
    exact = waved(shape(), 0.010, 6)
    points = shapes.noisy(exact, 2e-4, 1).round(5)
    path = tmp_path/"wave.whl"
    path.write_text(shapes.miniprof(points, "wheel", digits=5))
    wheel = Profile(path)
    assert wheel.smoothed_further and wheel.smoothing > 3*wheel.own_smoothing and 1e-4 < wheel.noise < 1e-3
    level = np.interp(70, *exact.T)
    assert 1e3*wheel.measures["Sh"] == pytest.approx(level - exact[:, 1].min(), abs=5e-3)      # the tip is between two points
    size, y = wheel.moved
    assert 0 < size < 10*wheel.smoothing and exact[0, 0] <= y <= exact[-1, 0]
    assert any(f"up to {1e3*size:.2g} µm" in note and f"y = {y:.1f} mm" in note for note in wheel.notes)
    found = placed(path, RAIL_60E1)
    (tmp_path/"curve.yz").write_text(shapes.rows(wheel.curve, digits=9))
    expected, smoothed = (Level.of(one, read(RAIL_60E1)).conicity(3.0) for one in (exact, read(tmp_path/"curve.yz")))
    assert found.level.conicity_at(3e-3) == pytest.approx(expected, rel=0.03, abs=3e-3)
    assert len(found.warnings) == 1
    told = re.search(r"equivalent conicity at 3 mm (\S+) -> (\S+?),", found.warnings[0])
    assert [float(told[1]), float(told[2])] == pytest.approx([expected, smoothed], rel=0.03, abs=3e-3)

    case = Case(wheel_profile=path, rail_profile=RAIL_60E1, **TRACK, t_end=1e-3, interval=1e-4).replace(SMALL)
    done = run(case)
    said = [words for words in done.warnings if words.startswith("waves are smoothed so that a contact is one patch")]
    assert len(said) == 1 and f"warning: {said[0]}\n" in header(done.write(tmp_path/"columns.txt"))
    plain = ContactTable(case.replace(wheel_profile=Profile(wheel.geometry, "wheel", smoothing=0, wheel_back=0.0)))
    for words in (f"wheel wave.whl up to {1e3*size:.2g} um from its points' curve, at y = {y:.1f} mm",
                  f"clearance {1e3*plain.clearance:.3f} -> {1e3*done.table.clearance:.3f} mm",
                  f"lateral frequency {plain.frequencies[0]:.3f}", f" -> {done.table.frequencies[0]:.3f} Hz"):
        assert words in said[0]
    heavier = done.table.for_case(case.replace(mass=2000.0))
    again = next(words for words in run(heavier.case, table=heavier).warnings if words.startswith("waves are"))
    assert f"-> {heavier.frequencies[0]:.3f} Hz" in again
    assert warned(case.replace(wheel_profile=S1002), "waves") == []


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_points_as_they_are_stand_on_their_treads(seed: int):
    """With smoothing 0, whatever noise and waves wheel and rail have; the clearance is that of smoothed ones to some noise."""
    random = np.random.default_rng(seed)
    points = []
    for shape in read(S1002), read(RAIL_60E1):
        moved = waved(shape, random.choice([0.0, 0.002, 0.01]), random.choice([3, 6, 10]), random.uniform(0, 6))
        points.append(shapes.noisy(moved, random.choice([3e-4, 3e-3, 1e-2]), seed))
    found = pair(Case(**TRACK).replace(wheel_profile=Profile(points[0], "wheel", smoothing=0, wheel_back=0.0),
                                       rail_profile=Profile(points[1], "rail", smoothing=0)))
    assert 1e3*found.clearance[0] == pytest.approx(6.05, abs=0.4)
    assert found.level.conicity_at(3e-3) == pytest.approx(Level.of(*points).conicity(3.0), rel=0.03, abs=3e-3)


WHEEL, RAIL = shapes.shape("awprof").round(7), shapes.shape("arprof").round(7)


def case_of(folder: Path, wheel: str | np.ndarray, rail: np.ndarray, wheel_back: float | None = None, **changes: object) -> Case:
    """A case whose profiles are those that Python makes of files with these texts or points, in `folder`."""
    folder.mkdir(exist_ok=True)
    for kind, text in ("wheel", wheel), ("rail", rail):
        (folder/kind).write_text(text if isinstance(text, str) else shapes.rows(text))
        Profile(folder/kind, kind, wheel_back=wheel_back if kind == "wheel" else None).write(folder/f"{kind}.yz")
    return Case.exercise(2).replace(SMALL, wheel_profile=folder/"wheel.yz", rail_profile=folder/"rail.yz",
                                    stop_at="t_end", rows="interval").replace(changes)


def test_noisy_points(tmp_path: Path):
    """Dense points double back by their noise: with smoothing the run is that of the clean file, through an impact at 2 m/s. What
    the header says of a file, the summary says too, in lines of 100."""
    noise = 0.03
    thrown = {"vY": 2.0, "roll_rate": 0.0667, "dt": 1e-4, "t_end": 8e-3}
    wheel, rail = (shapes.noisy(shapes.shape(name, 0.02), noise, seed) for seed, name in enumerate(("awprof", "arprof")))
    clean, found = (run(case_of(tmp_path/name, *points, **thrown)) for name, points in (
        ("clean", (WHEEL, RAIL)), ("noisy", (wheel, rail))))
    assert 1e3*found.table.clearance == pytest.approx(1e3*clean.table.clearance, abs=2*noise)
    assert found.data.Y.to_numpy() == pytest.approx(clean.data.Y.to_numpy(), abs=3e-3*noise) and clean.data.N_LF.any()
    said = header(found.write(tmp_path/"columns.txt"))
    assert "put together to one" in said
    told = re.findall(r"^\w+ profile: .*, CRC-32 \w+, .*$", said, re.M)
    assert len(told) == 2 and all(line in " ".join(found.text.split()) for line in told)


@pytest.mark.parametrize("worn", shapes.WORN_WHEELS)
def test_worn_wheel(worn: str, tmp_path: Path):
    """On a worn rail it has with faces and noise, in another format, the clearance that it has clean."""
    def clearance(folder: str, wheel: str | np.ndarray, rail: np.ndarray) -> float:
        return 1e3*ContactTable(case_of(tmp_path/folder, wheel, rail, formulation="unilateral")).clearance

    wheel, rail = shapes.WORN_WHEELS[worn](WHEEL), shapes.side_worn(RAIL)
    clean = clearance("clean", wheel, rail)
    assert 5 < clean < 16
    measured = shapes.old_miniprof(shapes.noisy(shapes.with_faces(wheel), 0.01, 3), "wheel")
    # Worn shapes conform: where tread ends and flange begins is less certain.
    assert clearance("measured", measured, shapes.noisy(rail, 0.01, 4)) == pytest.approx(clean, abs=0.3)


def test_conforming_profiles(tmp_path: Path):
    """A wheel of the rail's own shape, 0.1 mm off, from crown to gauge corner, with many arcs of either sign."""
    assert 5e-5 < ContactTable(case_of(tmp_path, shapes.conforming(RAIL), RAIL, 0.0)).clearance < 6e-3
