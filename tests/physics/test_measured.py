"""Measured profiles, worn ones, other codes' files: what the program makes of them."""
import itertools
import random
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

import ldbench
import shapes
from ldbench.profiles.inspect import inspect
from probes import table_file
from running import FORTRAN_TESTS, HANG, REPO, Run, columns, header, refusal, run_case, short_case

WHEEL, RAIL = shapes.shape("awprof").round(7), shapes.shape("arprof").round(7)


def run(folder: Path, wheel: str, rail: str, model: str = "strip", **profiles: object) -> tuple[float, np.ndarray, str]:
    """Clearance [mm], Y over time [m] and header of a short run with two profile texts.

    The model hertz is quick and suits where nobody looks at Y.
    """
    folder.mkdir(exist_ok=True)
    (folder / "wheel").write_text(wheel)
    (folder / "rail").write_text(rail)
    # Fast enough to reach a flange.
    text = short_case(folder, profiles={"wheel_profile": folder / "wheel", "rail_profile": folder / "rail"} | profiles,
                      contact={"model": model}, initial={"vY": 2.0, "roll_rate": 0.0667}, integrator={"dt": 1e-4, "t_end": 8e-3})
    done = run_case(text, folder)
    assert done.returncode == 0, done.stderr
    said = header(folder / "columns.txt")
    for line in re.findall(r"^\w+ profile: .*(?:mended|turned|MiniProf|SIMPACK|in m\b).*$", said, re.M):
        assert line in " ".join(done.stdout.split())      # what the header says of a file, the summary says too, in lines of 100
    clearance = float(re.search(r"clearance \[mm\]: 2 x (\S+)", done.stdout)[1])
    return clearance, columns(folder / "columns.txt")["Y"], said


def files(**wheel_and_rail: np.ndarray) -> dict[str, str]:
    return {kind: shapes.rows(points) for kind, points in wheel_and_rail.items()}


@pytest.fixture(scope="module")
def clean(tmp_path_factory: pytest.TempPathFactory) -> tuple[float, np.ndarray, str]:
    return run(tmp_path_factory.mktemp("clean"), **files(wheel=WHEEL, rail=RAIL))


# ---- the same shapes in other clothes ------------------------------------------------
@pytest.mark.parametrize("written", shapes.FORMATS)
def test_format_is_told_by_its_contents(written, clean, tmp_path):
    write = shapes.FORMATS[written]
    clearance, y, said = run(tmp_path, write(WHEEL, "wheel"), write(RAIL, "rail"))
    assert clearance == clean[0]
    assert y == pytest.approx(clean[1], abs=2e-9)      # points are rounded to 1e-7 mm of another origin
    if written != "plain":
        assert f", {written.split()[-1]}" in said


CLOTHES = {
    "z down": (lambda p: p*[1, -1], "z turned over"),
    "mirrored": (lambda p: p*[-1, 1], "y turned over"),
    "z down, mirrored": (lambda p: p*[-1, -1], "y and z turned over"),
    "other direction": (lambda p: p[::-1], ""),
    "in m": (lambda p: p*1e-3, "in m"),
    "in inches": (lambda p: p/25.4, "in inches"),
}


@pytest.mark.parametrize("clothes", CLOTHES)
def test_sides_and_units_are_told_by_the_shape(clothes, clean, tmp_path):
    put_on, words = CLOTHES[clothes]
    texts = ("".join(f"{y:.12g} {z:.12g}\n" for y, z in put_on(p)) for p in (WHEEL, RAIL))
    clearance, y, said = run(tmp_path, *texts)
    assert clearance == clean[0]
    assert y == pytest.approx(clean[1], abs=2e-9)
    lines = re.findall(r"^(?:wheel|rail) profile: .*$", said, re.M)
    assert all(words in line for line in lines) and len(lines) == 2


def test_namelist_overrides_the_shape(clean, tmp_path):
    """A mirrored rail that is told not to be; a file in an unlikely unit."""
    right, _, _ = run(tmp_path / "a", **files(wheel=WHEEL, rail=RAIL), model="hertz", rail_flip="none", wheel_flip="none")
    assert right == clean[0]
    other, _, said = run(tmp_path / "b", **files(wheel=WHEEL, rail=RAIL*[-1, 1] + [75.6, 0]), model="hertz", rail_flip="none")
    assert abs(other - right) > 0.05 and "turned over" not in said
    forced, _y, _ = run(tmp_path / "c", **files(wheel=WHEEL*1e-3, rail=RAIL), model="hertz", wheel_unit="m")
    assert forced == clean[0]
    text = short_case(tmp_path, profiles={"wheel_profile": tmp_path / "c" / "wheel", "wheel_unit": "mm"})
    assert "expected y in millimetres over 10.0 to 1000.0 mm, found a width of 0.135" in refusal(text, tmp_path)


def test_faces_are_no_running_surface(clean, tmp_path):
    """Flange back, chamfer, rim face, underside of the head: the run stays."""
    wheel, rail = shapes.with_faces(WHEEL), shapes.with_web(RAIL)
    clearance, y, said = run(tmp_path / "a", **files(wheel=wheel*[1, -1], rail=rail))
    assert clearance == pytest.approx(clean[0], abs=1e-3)
    assert y == pytest.approx(clean[1], abs=1e-8)
    assert said.count("faces beyond the running surface left out") == 2


def test_repeated_points_and_small_ways_back_are_mended(clean, tmp_path):
    """Points twice, two exchanged, a point far off: mended, said, with a run as of the clean file."""
    wheel = np.repeat(WHEEL, 1 + (np.arange(len(WHEEL)) % 40 == 5), axis=0)
    rail = RAIL.copy()
    rail[[300, 301]] = rail[[301, 300]]
    rail[200] += [0.4, 1.0]
    clearance, y, said = run(tmp_path, **files(wheel=wheel, rail=rail))
    assert clearance == pytest.approx(clean[0], abs=2e-3)
    assert y == pytest.approx(clean[1], abs=1e-7)
    assert f"points mended: {len(wheel) - len(WHEEL)} repeated dropped" in said
    off = re.search(r"points mended: 1 off the curve by up to (\S+) mm dropped, 2 that doubled back moved by up to 0.25 mm",
                    said)
    assert off and 0.5 < float(off[1]) < 1.1


@pytest.mark.parametrize("name", ["awprof", "arprof", "swprof", "srprof", "s1002", "60e1"])
def test_exact_points_are_interpolated(name):
    """Points of the shipped files, exact but for their last decimals, need no smoothing."""
    found = inspect(REPO / "profiles" / f"{name}.yz")
    assert found.smoothing == 0
    assert np.array_equal(found.smooth.curvature, found.rough.curvature)


@pytest.mark.parametrize("noise", [0.0005, 0.003, 0.02])
def test_the_curve_keeps_the_noise_of_its_points(noise, tmp_path):
    """Without a smoothing the curve is smoothed by the noise, neither more nor less; the run tells it."""
    wheel, rail = (shapes.noisy(shapes.shape(name), noise, seed) for seed, name in enumerate(("awprof", "arprof")))
    for name, points in ("wheel", wheel), ("rail", rail):
        (tmp_path / name).write_text(shapes.rows(points))
        assert inspect(tmp_path / name).smoothing == pytest.approx(noise, rel=0.15)
    _clearance, _y, said = run(tmp_path / "run", **files(wheel=wheel, rail=rail), model="hertz")
    told = [float(x) for x in re.findall(r"^\w+ profile: .*; smoothed by (\S+) mm$", said.replace("# ", ""), re.M)]
    assert told == pytest.approx([noise, noise], rel=0.15, abs=6e-5)
    assert "smoothing_mm of at least" not in said


def wavy(points: np.ndarray, height: float, length: float) -> np.ndarray:
    """A profile's points with waves of a height and a length [mm] across the curve."""
    way = np.gradient(points, axis=0)
    across = way[:, ::-1]*[-1, 1]/np.hypot(*way.T)[:, None]
    s = np.r_[0, np.cumsum(np.hypot(*np.diff(points, axis=0).T))]
    return points + height*np.sin(2*np.pi*s/length)[:, None]*across


def test_waves_shorter_than_a_contact_are_smoothed(tmp_path):
    """Waves of 6 mm have 22 per metre of curvature at 20 um, which would part every patch; those of 40 mm are the shape."""
    clean = inspect(REPO / "profiles/s1002.yz", "wheel")
    for name, height, length in ("short", 0.02, 6.0), ("long", 0.02, 40.0):
        (tmp_path / name).write_text(shapes.rows(wavy(np.loadtxt(REPO / "profiles/s1002.yz"), height, length).round(6)))
        found = inspect(tmp_path / name, "wheel")
        tread = (found.smooth.y > 0.06) & (found.smooth.y < 0.11)
        waves = found.smooth.curvature[tread] - np.interp(found.smooth.y[tread], clean.smooth.y, clean.smooth.curvature)
        size = np.sqrt(2*np.mean(waves**2))         # amplitude [1/m]
        if name == "long":
            assert found.smoothing == 0
            assert size == pytest.approx(1e-3*height*(2e3*np.pi/length)**2, rel=0.1)
        else:
            assert 0.002 < found.smoothing < 0.04
            assert size < 2


def test_less_smoothing_than_the_points_need_is_told(tmp_path):
    wheel = shapes.rows(shapes.noisy(shapes.shape("awprof"), 0.01, 1))
    rail = shapes.rows(shapes.shape("arprof"))
    for smoothing, told in (0.0, True), (0.005, True), (0.01, False), (-1.0, False):
        # With too little smoothing Hertz's contacts pull.
        said = run(tmp_path / str(smoothing), wheel, rail, "strip" if told else "hertz", smoothing_mm=smoothing)[2]
        assert ("wheel: expected &profiles smoothing_mm of at least 0.0" in said) == told
        assert "rail: expected &profiles smoothing_mm" not in said


@pytest.mark.parametrize(("spacing", "noise"), [(0.02, 0.01), (0.02, 0.03), (0.1, 0.03), (0.4, 0.01)])
def test_noisy_points(spacing, noise, clean, tmp_path):
    """Dense points double back by their noise, sparse ones do not: with smoothing the run is that of the clean file."""
    wheel, rail = (shapes.noisy(shapes.shape(name, spacing), noise, seed) for seed, name in enumerate(("awprof", "arprof")))
    clearance, y, said = run(tmp_path, **files(wheel=wheel, rail=rail), smoothing_mm=noise)
    assert clearance == pytest.approx(clean[0], abs=2*noise)
    assert y == pytest.approx(clean[1], abs=3e-3*noise)    # of 12 mm, after an impact at 2 m/s
    if spacing == 0.02:
        assert "put together to one" in said


def test_few_and_many_points(clean, tmp_path):
    """From 40 points to ten thousand."""
    for folder, spacing in ("few", 5.0), ("many", 0.018):
        wheel, rail = (shapes.shape(name, spacing) for name in ("awprof", "arprof"))
        clearance, _, _ = run(tmp_path / folder, **files(wheel=wheel, rail=rail), model="hertz")
        assert clearance == pytest.approx(clean[0], abs=0.2 if spacing > 1 else 2e-3)


# ---- worn shapes ---------------------------------------------------------------------
@pytest.mark.parametrize("worn", shapes.WORN_WHEELS)
def test_worn_wheel(worn, tmp_path):
    """It runs, on a new and on a worn rail, and with faces, noise and in another format as it does clean."""
    wheel = shapes.WORN_WHEELS[worn](WHEEL)
    for folder, rail, model in ("new", RAIL, "hertz"), ("side worn", shapes.side_worn(RAIL), "strip"):
        clearance, _y, _ = run(tmp_path / folder, **files(wheel=wheel, rail=rail), model=model)
        assert 5 < clearance < 16
    again, _, _ = run(tmp_path / "again", shapes.miniprof_new(shapes.with_faces(wheel), "wheel"),
                      shapes.simpack(shapes.side_worn(RAIL), "rail"), "hertz")
    assert again == pytest.approx(clearance, abs=2e-3)
    measured, _, _ = run(tmp_path / "measured", shapes.miniprof_old(shapes.noisy(shapes.with_faces(wheel), 0.01, 3), "wheel"),
                         shapes.rows(shapes.noisy(shapes.side_worn(RAIL), 0.01, 4)), "hertz", smoothing_mm=0.01)
    # Worn shapes conform: where tread ends and flange begins is less certain.
    assert measured == pytest.approx(clearance, abs=0.3)


def test_conforming_profiles(tmp_path):
    """A wheel of the rail's own shape, 0.1 mm off, from crown to gauge corner, with many arcs of either sign."""
    head = RAIL[(RAIL[:, 1] > -9) & (RAIL[:, 0] < 43)] + [39.0, 0]     # conforms at Y = 2.5 mm
    normal = shapes.normals(head)
    near = head + 0.1*normal + 0.004*np.sin(head[:, :1])*normal
    low = near[0] + np.outer(np.arange(-5, 0, 0.25), [np.cos(1.2), np.sin(1.2)])
    tip = low[0] + 8*np.column_stack([np.sin(np.arange(-1.5, 1.2, 0.03)) - np.sin(1.2),
                                      np.cos(1.2) - np.cos(np.arange(-1.5, 1.2, 0.03))])
    tread = near[-1] + np.outer(np.arange(0.25, 50, 0.25), [1, 0.02])
    wheel = np.concatenate([tip[:-1], low, near, tread])
    clearance, _, _ = run(tmp_path, **files(wheel=wheel, rail=RAIL))
    assert 0.05 < clearance < 6


@pytest.mark.parametrize(("law", "pair"), [("halfspace", "aw"), ("halfspace", "sw"), *itertools.product(
    ["strip", "hertz"], ["aw", "sw", "S1002 on 60E1", "measured"])])
def test_force_grows_with_sinking(law: str, pair: str, shipped: dict[str, Run], tmp_path: Path):
    """On 605 curves, to 1.1 times the clearance on either side and 10 mrad of roll, F_z of the left wheel never falls while the
    wheel sinks by 0.4 mm in steps of 10 um. The measured profiles have noise of 10 um."""
    case = ldbench.Case.exercise(2, "sw" if pair == "sw" else "aw").replace(
        model=law, table_file=table_file(shipped, pair) if law == "halfspace" else "")
    if pair == "S1002 on 60E1":
        case = case.replace(wheel_profile=str(REPO/"profiles/s1002.yz"), rail_profile=str(REPO/"profiles/60e1.yz"), gauge=1.435,
                            back_to_back=1.36)
    if pair == "measured":
        for name, points in ("wheel", WHEEL), ("rail", RAIL):
            (tmp_path/name).write_text(shapes.rows(shapes.noisy(points, 0.01, 4)))
            case = case.replace(**{f"{name}_profile": str(tmp_path/name)})
    table = ldbench.ContactTable(case)
    y, roll, z = np.meshgrid(1.1*table.clearance*np.linspace(-1, 1, 55), np.linspace(-0.01, 0.01, 11),
                             table.rest[1] + np.arange(2e-2, -1e-2, -1e-5), indexing="ij")
    force = table.force(y, z, roll, "left", "nan")[..., 1]
    sinks = (force > 0) & (np.cumsum(force > 0, axis=2) <= 40)
    growth = np.diff(force, axis=2)[sinks[..., :-1] & sinks[..., 1:]]
    assert len(growth) > 20_000 and growth.min() > 0


# ---- what cannot be mended -----------------------------------------------------------
def test_hopeless_points_are_refused_by_line(tmp_path):
    scattered = WHEEL + np.random.default_rng(1).normal(0, 3, WHEEL.shape)
    (tmp_path / "wheel").write_text("# a wheel\n" + shapes.rows(scattered))
    message = refusal(short_case(tmp_path, profiles={"wheel_profile": tmp_path / "wheel"}), tmp_path)
    assert re.search(r"wheel(: the curve crosses itself between lines|, line) \d+", message)


BROKEN = {
    "a rail's file for a wheel": (shapes.simpack(RAIL, "rail"), "expected a wheel, found a file that says it is a rail"),
    "no end of the points": (shapes.simpack(WHEEL, "wheel").split("    point.end")[0],
                             "expected point.end, found the end of the file"),
    "points without a spline": ("point.begin\n1 2\npoint.end\n", "line 1: expected the sections header, spline"),
    "a word among the points": (shapes.simpack(WHEEL, "wheel").replace("    point.end", "abc\n    point.end"),
                                "expected two numbers, y and z, found \"abc\""),
    "a turned profile": (shapes.simpack(WHEEL, "wheel").replace("rotate = 0.0", "rotate = 0.1"),
                         "line 11: expected rotate = 0, found \"0.1\""),
    "no unit": (shapes.simpack(WHEEL, "wheel").replace("units.len.f = 1000.0", "units.len.f = 0"),
                "expected units.len.f above 0"),
    "no columns": (shapes.miniprof_new(WHEEL, "wheel").replace("X,Y,A,C", "A,C"), "line 6: expected columns X and Y"),
    "no offset": (shapes.miniprof_new(WHEEL, "wheel").replace("XOffset=1.5000", "XOffset=x"),
                  "line 4: expected a number after xoffset="),
}


@pytest.mark.parametrize("broken", BROKEN)
def test_broken_format_is_refused(broken, tmp_path):
    text, words = BROKEN[broken]
    (tmp_path / "wheel").write_text(text)
    assert words in refusal(short_case(tmp_path, profiles={"wheel_profile": tmp_path / "wheel"}), tmp_path)


def mutated(text: str, chance: random.Random) -> str:
    """A text with one to five lines or characters changed, lost, repeated, moved."""
    lines = text.split("\n")
    for _ in range(chance.randint(1, 5)):
        k = chance.randrange(len(lines))
        what = chance.randrange(8)
        if what == 0:
            del lines[k:k + chance.choice([1, 1, 2, 30])]
        elif what == 1:
            lines.insert(chance.randrange(len(lines) + 1), lines[k])
        elif what == 2:
            j = chance.randrange(len(lines))
            lines[k], lines[j] = lines[j], lines[k]
        elif what == 3 and lines[k]:
            j = chance.randrange(len(lines[k]))
            lines[k] = lines[k][:j] + chance.choice("0123456789.-+eE= \t#!%\"',;xyz\0ÿ") + lines[k][j + 1:]
        elif what == 4 and lines[k]:
            j = chance.randrange(len(lines[k]))
            lines[k] = lines[k][:j] + lines[k][j + 1:]
        elif what == 5:
            lines[k] = " ".join(chance.choice(["0", "-1", "1e30", "12.5", "1e-9", "NaN"]) for _ in range(2))
        elif what == 6:
            lines = lines[:max(1, k)]
        else:
            lines[k] = lines[k].replace(".", chance.choice([",", "", "..", "0."]), 1)
        lines = lines or [""]
    return "\n".join(lines)


def test_a_refused_value_is_told_as_the_file_has_it(tmp_path):
    (tmp_path / "wheel").write_text(shapes.FORMATS["SIMPACK"](WHEEL, "wheel").replace("type = 1 ", "type = 0, 9 ", 1))
    assert 'found "0, 9"' in refusal(short_case(tmp_path, profiles={"wheel_profile": tmp_path / "wheel"}), tmp_path)


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
    assert float(re.search(r"going over (\S+) ", done.stdout)[1]) < 2e-2


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


@pytest.mark.parametrize("written", shapes.FORMATS)
def test_mutated_files(written, tmp_path):
    """A run or one true line of error, for 160 files; `make fuzz` takes as many as wanted."""
    chance = random.Random(7)
    rail = tmp_path / "rail"
    rail.write_text(shapes.rows(shapes.shape("arprof", 1.0)))
    base = {1: shapes.FORMATS[written](shapes.with_faces(shapes.shape("awprof", 1.0), 1.0), "wheel"),
            2: shapes.FORMATS[written](shapes.shape("arprof", 1.0), "rail")}
    for kind, other in (1, rail), (2, tmp_path / "wheel"):
        other.write_text(shapes.rows(shapes.shape("arprof" if kind == 1 else "awprof", 1.0)))
        texts = [mutated(base[kind], chance) for _ in range(80)]
        paths = [tmp_path / f"{kind}_{i}" for i in range(len(texts))]
        for path, text in zip(paths, texts, strict=True):
            path.write_bytes(text.encode("latin-1"))
        asked = "".join(f"{-kind if i % 40 == 0 else kind:2d} {path}\n" for i, path in enumerate(paths))
        done = subprocess.run([FORTRAN_TESTS / "read_profiles", other], input=asked, capture_output=True, encoding="latin-1",
                              timeout=HANG)
        assert done.returncode == 0, done.stderr
        answers = done.stdout.splitlines()
        assert len(answers) == len(texts)
        assert 8 < sum(answer == "good" for answer in answers) < 72
        for path, text, answer in zip(paths, texts, answers, strict=True):
            check_answer(path, text, answer)


def check_answer(path: Path, text: str, answer: str) -> None:
    """What an error claims is so."""
    if answer == "good" or re.fullmatch(r"\s*\S+E[-+]\d+", answer):
        return
    assert answer.isprintable() and len(answer) < 600, answer
    assert str(path) in answer or answer.startswith("&track gauge"), answer
    lines = text.split("\n")
    if found := re.search(rf"{path}, line (\d+): ", answer):
        assert int(found[1]) <= len(lines), answer
        if quoted := re.search(r'found "([^"?]*)"$', answer):
            assert quoted[1].strip()[:40] in lines[int(found[1]) - 1].replace("\t", " "), answer
    if found := re.search(r"over (\S+) to (\S+) mm, found a width of (\S+)", answer):
        least, most, width = map(float, found.groups())
        assert not least <= width <= most, answer
    if found := re.search(r"at least 10 points, found (\d+)", answer):
        assert int(found[1]) < 10, answer
    if found := re.search(r"at most 120 degrees at a point, found (\d+)", answer):
        assert int(found[1]) >= 120, answer
