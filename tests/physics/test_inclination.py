"""Rails that lean: &track rail_inclination and rail_inclination_right."""
from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import en15302
import shapes
from geometry_table import cone, rails
from ldbench import Case, ContactTable, Profile, read_run, run
from ldbench.__main__ import main
from ldbench.geometry.pair import Pair, pair
from ldbench.profiles.measures import survey
from ldbench.profiles.profile import frames_of
from mirror_image import mirrored
from rigid_numpy import Level, read, turned
from running import REPO, header, run_case, short_case

TRACK = {"gauge": 1.435, "back_to_back": 1.36}
CANT = float(np.arctan(1/40))


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Wheels, and rails as they are published: upright."""
    folder = tmp_path_factory.mktemp("profiles")
    points = {"cone 1:20": cone(1/20), "cone 1:40": cone(1/40), "cylinder": cone(0.0), "upright": rails()["60E1"],
              "C": en15302.points("C")[1:]}
    found = {name: folder/f"{name.replace(':', '_').replace(' ', '_')}.yz" for name in points}
    for name, path in found.items():
        path.write_text(shapes.rows(points[name], digits=9))
    return found | {"S1002": REPO/"profiles/s1002.yz", "60E1 1:40": REPO/"profiles/60e1.yz"}


def placed(wheel: Path, rail: Path, **changes: object) -> Pair:
    return pair(Case(wheel_profile=wheel, rail_profile=rail, **TRACK).replace(changes))


# Conicity at 3 mm of S1002 on 60E1, upright, at 1:40 and at 1:20, by an independent program from the same files.
PUBLISHED = {"0": 0.137, "1:40": 0.174, "1:20": 0.009}


@pytest.mark.parametrize("lean", ["0", "1:40", "1:20"])
@pytest.mark.parametrize("wheel", ["S1002", "cone 1:20", "cone 1:40", "C"])
def test_conicity_is_that_of_the_points(wheel: str, lean: str, files: dict[str, Path]):
    """On a rail that is published upright: by the points of the files alone, and as another program has it."""
    found = placed(files[wheel], files["upright"], rail_inclination=lean)
    angle = np.arctan(1/float(lean[2:])) if lean != "0" else 0.0
    for amplitude in 1.0, 2.0, 3.0:
        expected = Level.of(read(files[wheel]), read(files["upright"]), angle).conicity(amplitude)
        assert found.level.conicity_at(1e-3*amplitude) == pytest.approx(expected, rel=0.02, abs=1e-3), amplitude
    if wheel == "S1002":
        assert found.level.conicity_at(3e-3) == pytest.approx(PUBLISHED[lean], abs=1e-3)


def test_turned_rails_are_turned_files(files: dict[str, Path], tmp_path: Path):
    """A file whose points were turned before gives the same geometry; the top stays at z = 0, the gauge point at half the gauge."""
    (tmp_path/"turned.yz").write_text(shapes.rows(turned(read(files["upright"]), CANT), digits=9))
    by_file = placed(files["S1002"], tmp_path/"turned.yz")
    by_angle = placed(files["S1002"], files["upright"], rail_inclination="1:40")
    assert by_angle.clearance == pytest.approx(by_file.clearance, abs=1e-9)
    assert np.allclose(by_angle.outlines.left.rail, by_file.outlines.left.rail, atol=1e-10)
    assert by_angle.outlines.left.rail[:, 1].max() == pytest.approx(0, abs=1e-12)
    for found in by_angle, placed(files["S1002"], files["60E1 1:40"]):
        y, z = found.outlines.left.rail.T
        face = slice(0, z.argmax() + 1)
        assert np.interp(-0.014, z[face], y[face]) == pytest.approx(TRACK["gauge"]/2, abs=1e-6)
        rail = 1e3*np.column_stack([y, z])
        assert survey("rail", *frames_of(rail), 0.014)[1]["inclination"] == pytest.approx(CANT, abs=2e-5)


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
        (tmp_path/"columns.txt").unlink()
    assert texts["quoted"] == texts["plain"] == texts["number"]
    assert texts["none"] == texts["zero"] and "inclin" not in texts["none"][1].replace(str(REPO), "")
    assert f"  rail_inclination = {CANT!r}  ! rad\n" in texts["quoted"][1]
    assert f", inclined by {CANT!r} rad beyond its file\n" in texts["quoted"][1]
    assert f", inclined by {-CANT!r} rad" in texts["minus"][1] and texts["minus"][0] != texts["quoted"][0]
    assert len(list((tmp_path/"tables").iterdir())) == 3       # a table for each inclination


def test_cases_of_python():
    case = Case(rail_inclination="1:40", rail_inclination_right="-1:20")
    assert (case.rail_inclination, case.rail_inclination_right) == (CANT, "-1:20")
    assert Case.from_namelist(case.to_namelist()) == case == eval(repr(case))
    assert Case(rail_inclination=np.float64(0.02), rail_inclination_right=0.02).rail_inclination_right == "0.02"
    with pytest.raises(ValueError, match=r"&track rail_inclination: expected a number from .* rad, or 1:n, found '1:5'"):
        Case(rail_inclination="1:5")


@pytest.mark.filterwarnings("ignore::ldbench.Warning")
@pytest.mark.parametrize("formulation", ["elastic", "unilateral"])
def test_mirrored_inclinations(formulation: str, files: dict[str, Path]):
    """Rails that lean otherwise on the right, and on the left of the mirror image: bit for bit."""
    case = Case.exercise(2).replace(wheel_profile=files["S1002"], rail_profile=files["upright"], **TRACK, formulation=formulation,
                                    model="hertz", lateral=0.02, t_end=0.03, stop_at="t_end", table_folder="", roll_link="none",
                                    rail_inclination="1:20", rail_inclination_right="1:40")
    opposite = case.replace(rail_inclination="1:40", rail_inclination_right="1:20", vY=-case.vY, roll_rate=-case.roll_rate)
    here, there = run(case), run(opposite)
    found = mirrored(there.data)
    for name in here.data:
        assert np.array_equal(here.data[name], found[name], equal_nan=True), name
    assert (here.table.clearance, here.table.clearance_right) == (there.table.clearance_right, there.table.clearance)
    both = ContactTable(case.replace(rail_inclination_right="1:20"))
    same = ContactTable(case.replace(rail_inclination_right=""))
    assert (both.clearance, both.equilibrium, both.frequencies[0]) == (same.clearance, same.equilibrium, same.frequencies[0])


def warned(case: Case) -> list[str]:
    """Warnings about the rail that stands upright, of a run of no length."""
    done = run(case.replace(t_end=1e-3, interval=1e-4, stop_at="t_end", model="hertz", lateral=0.02, table_folder=""))
    return [words for words in done.warnings if "upright" in words]


@pytest.mark.filterwarnings("ignore::ldbench.Warning")
def test_one_warning_where_a_design_rail_stands_upright(files: dict[str, Path]):
    """Under a coned wheel alone, until an inclination is given."""
    upright = Case(wheel_profile=files["S1002"], rail_profile=files["upright"], **TRACK)
    said = warned(upright)
    assert len(said) == 1 and "upright.yz is symmetric and stands upright under a wheel coned 1:" in said[0]
    assert "&track rail_inclination" in said[0]
    for case in (upright.replace(rail_inclination="1:40"), upright.replace(wheel_profile=files["cylinder"]),
                 upright.replace(rail_profile=files["60E1 1:40"]), Case.exercise(1), Case.exercise(1, "sw")):
        assert warned(case) == []
    assert list(pair(upright).warnings) == said


def test_the_command_and_its_page(files: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    """The option, --set and the case are one; the page names the inclination."""
    sizes = [f"--set={name}={value}" for name, value in TRACK.items()]
    names = [str(files["S1002"]), str(files["upright"]), *sizes, "-o", str(tmp_path/"page.png")]
    assert main(["profile", *names, "--rail-inclination", "1:40"]) == 0
    said = capsys.readouterr().out
    assert "rails inclined by 0.0250 (1:40.0) beyond their files" in said and "level 0.174" in said and "warning" not in said
    assert main(["profile", *names, "--set", "rail_inclination=1:40"]) == 0
    assert capsys.readouterr().out == said
    assert main(["profile", *names]) == 0
    said = capsys.readouterr().out
    assert said.count("stands upright") == 1 and "inclined by" not in said and "level 0.137" in said
    assert main(["profile", str(files["upright"]), "-o", str(tmp_path/"page.png")]) == 0
    assert "inclination 0.0000\n" in capsys.readouterr().out        # without a minus
    for wrong in (["--rail-inclination", "1:4"], ["--rail-inclination", "steep"]):
        assert main(["profile", *names, *wrong]) == 1
        assert "&track rail_inclination: expected a number from -0.12 to 0.12 rad, or 1:n, found" in capsys.readouterr().err


def test_a_rail_without_a_gauge_face_once_it_is_turned(files: dict[str, Path], tmp_path: Path):
    """A head that goes down to the gauge point and little farther."""
    rail = read(files["upright"])
    (tmp_path/"short.yz").write_text(shapes.rows(rail[rail[:, 1] > -14.6], digits=9))
    case = Case(wheel_profile=files["S1002"], rail_profile=tmp_path/"short.yz", **TRACK)
    assert pair(case).clearance[0] > 0.005
    with pytest.raises(Exception, match=r"^case, &track rail_inclination = -0\.05 rad: expected a gauge face 0\.014 m "
                       r"below the top of the turned rail, found none on \S*short\.yz; give a smaller angle"):
        pair(case.replace(rail_inclination=-0.05))


def test_profiles_are_kept_as_they_are(files: dict[str, Path]):
    """The inclination is the case's: the profile's own measures stay."""
    assert abs(Profile(files["upright"]).measures["inclination"]) < 1e-5
