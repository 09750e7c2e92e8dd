"""Measures of many wheels and rails beside those that numpy has from their points; what is said of odd ones; runs of them."""
from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import profile_table as table
import shapes
from ldbench import Case, Error, Profile, run
from ldbench.conicity import FINE_PITCH
from ldbench.geometry.pair import pair

SPECIMENS = {one.name: one for one in table.specimens()}
WHEEL, RAIL = table.shipped("s1002"), table.shipped("60e1")
EXERCISE = {"gauge": 1.435, "back_to_back": 1.36, "model": "hertz", "roll_link": "rails", "table_folder": ""}


@pytest.fixture(autouse=True)
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """The rolling radius difference is found at fewer displacements, for conicities that are compared to a tenth of a percent."""
    monkeypatch.setattr("ldbench.geometry.pair.FINE_PITCH", 5*FINE_PITCH)


@pytest.mark.parametrize("name", SPECIMENS)
def test_measures_are_those_of_the_points(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """None is off by more than 3 % without a remark on its line."""
    monkeypatch.chdir(tmp_path)
    rows = table.rows(SPECIMENS[name], tmp_path)
    assert [row for row in rows if row.off and not row.remark] == [] and len(rows) == 5
    assert np.isfinite([row.found for row in rows]).all()


def written(folder: Path, name: str, points: np.ndarray, digits: int = 7) -> str:
    (folder/name).write_text(shapes.rows(points, digits=digits))
    return str(folder/name)


def line_of(profile: Profile, label: str) -> str:
    return next(line for line in profile.lines() if line.startswith(label))


def test_a_lip_is_the_gauge_point(tmp_path: Path):
    """Down to 14 or 15.875 mm the innermost point is the lip's; deeper than the file the rail has no gauge, and the message names
    the user's file. A file that the program wrote is the same rail."""
    lip = table.lip(RAIL)
    rail = Profile(written(tmp_path, "low.ban", lip), gauge_depth=0.015875)
    innermost = lip[lip[:, 1] > -15.875, 0].min()
    assert 1e3*rail.measures["gauge_point_y"] == pytest.approx(innermost, abs=2e-3)
    line = line_of(rail, "gauge point at y -0.72")
    assert "goes back below a lip 11.0" in line and "32.87" in line
    assert "goes back below a lip" in str(rail.facts()["gauge_point_y_remark"])
    rail.write(tmp_path/"low.yz")
    again = Profile(tmp_path/"low.yz", gauge_depth=0.015875)
    assert again.as_it_is and again.measures == pytest.approx(rail.measures, nan_ok=True)
    assert again.remark("gauge_point_y") == rail.remark("gauge_point_y")
    case = Case.exercise(2).replace(**EXERCISE, wheel_profile=str(table.REPO/"profiles/s1002.yz"), gauge_depth=0.015875)
    of_lip, of_written, whole = (pair(case.replace(rail_profile=path)) for path in (
        rail.path, tmp_path/"low.yz", str(table.REPO/"profiles/60e1.yz")))
    assert of_lip.clearance == of_written.clearance and "goes back below a lip" in of_lip.lines()[0]
    # Gauge is between the lips: the rest of the rails is farther apart by what the lip stands out.
    assert whole.clearance[0] - of_lip.clearance[0] == pytest.approx(-1e-3*innermost, abs=1.5e-4)
    with pytest.raises(Error, match=r"low\.ban: the rail has no gauge face 0\.04 m below its top") as caught:
        pair(case.replace(rail_profile=rail.path, gauge_depth=0.04))
    assert "ldbench-" not in str(caught.value)
    short = written(tmp_path, "short.ban", table.lip(RAIL, 12.5))
    with pytest.raises(Error, match=r"short\.ban: the rail has no gauge face 0\.015875 m"):
        pair(case.replace(rail_profile=short))


@pytest.mark.parametrize("kind", ["", "rail"])
@pytest.mark.parametrize("shift", [None, 0, 400, 800])
def test_a_section_is_cut_below_its_head(kind: str, shift: int | None):
    """Closed, from any point of its outline on; or open, from one corner of the foot to the other."""
    points = table.section(RAIL, closed=False) if shift is None else np.roll(table.section(RAIL), shift, axis=0)
    rail = Profile(points, kind)
    assert rail.kind == "rail" and rail.points[:, 1].min() > -60
    assert any(note.startswith("a section of 171.7 mm, cut below its head: ") for note in rail.notes)
    assert 1e3*rail.measures["corner_radius"] == pytest.approx(13, rel=1e-3)


def test_the_corners_of_a_section_are_enough(tmp_path: Path):
    """As of a drawing: every second millimetre on the head, the corners of web and foot."""
    head = RAIL[(RAIL[:, 1] > -36)][::8]
    middle = head[[0, -1], 0].mean()
    side = np.array([(8.25, -51), (8.25, -140), (75, -160), (75, -172)])
    drawn = np.concatenate([[middle, 0] + side[::-1]*[-1, 1], head, [middle, 0] + side])
    for shift in 0, 2, 4, -2, 40:
        for way in 1, -1:
            rail = Profile(np.roll(drawn, shift, axis=0)*[1, way])
            assert rail.kind == "rail" and 1e3*rail.measures["gauge_point_y"] == pytest.approx(0, abs=0.02)


def test_a_back_is_that_of_the_convention(tmp_path: Path):
    """y = 0 in MiniProf's files, though a face of the back stands elsewhere; the face where no format says it."""
    faced = shapes.with_faces(WHEEL)
    for off in -0.24, 0.5:
        (tmp_path/"a.whl").write_text(shapes.miniprof(faced + [off, 0], "wheel"))
        wheel = Profile(tmp_path/"a.whl")
        assert 1e3*wheel.measures["Sd"] == pytest.approx(32.5 + off, abs=0.01)
        assert f"a face of the back stands at y = {off:.2f} mm, not used" in line_of(wheel, "flange thickness")
        found = pair(Case.exercise(2).replace(**EXERCISE, wheel_profile=wheel.path,
                                              rail_profile=str(table.REPO/"profiles/60e1.yz")))
        assert "a face of the back stands" in found.lines()[0] and "a face" in str(found.facts()["clearance_remark"])
    wheel = Profile(written(tmp_path, "b.txt", faced + [-0.24, 0]))
    assert 1e3*wheel.measures["Sd"] == pytest.approx(32.5, abs=0.01)
    assert "y = -0.24 mm" in line_of(wheel, "flange thickness")


def test_a_hollow_wheel_turns_away(tmp_path: Path):
    """Where the rolling radius difference has the other sign there is no wave, and every line says so."""
    wheel = written(tmp_path, "hollow.txt", table.hollow(WHEEL))
    found = pair(Case.exercise(2).replace(**EXERCISE, wheel_profile=wheel, rail_profile=str(table.REPO/"profiles/60e1.yz")))
    for geometry in found.level, found.rolled:
        assert geometry.difference_at(2e-3) < 0 < geometry.difference_at(3e-3)
        assert np.isnan(geometry.conicity_at(2e-3)) and np.isfinite(geometry.conicity_at(3e-3))
        assert "the rolling radius difference is -0.0" in geometry.why_none(2e-3) and not geometry.why_none(3e-3)
        assert "stands on both rails up to Y = " in geometry.why_none(0.5)
    lines = found.lines()
    at = [next(line for line in lines if line.startswith(f"equivalent conicity at {mm} mm")) for mm in (2, 3, 4)]
    assert "level none, with roll none (EN 15302)" in at[0] and "turns the wheelset away from the centre" in at[0]
    assert "none" not in at[1] + at[2]
    assert any(line.startswith("nonlinearity parameter") and line.endswith("none without the conicities at 2 and 4 mm")
               for line in lines)
    facts = found.facts()["conicity"]["level"]
    assert list(facts["none"]) == ["2 mm"] and np.nanmin(facts["rolling_radius_difference"]) < 0


def test_a_model_is_its_full_size(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Lengths over the scale, conicity the same at amplitudes over the scale."""
    monkeypatch.chdir(tmp_path)
    case = Case.exercise(2).replace(**EXERCISE, wheel_profile=str(table.REPO/"profiles/s1002.yz"),
                                    rail_profile=str(table.REPO/"profiles/60e1.yz"))
    full = pair(case)
    for scale in 5.0, 10.0:
        wheel, rail = (Profile(written(tmp_path, f"{kind}.txt", points/scale), kind, scale=scale if scale > 5 else None,
                               unit="mm" if scale > 5 else "auto") for kind, points in (("wheel", WHEEL), ("rail", RAIL)))
        assert wheel.scale == rail.scale == scale
        small = pair(case.replace(wheel_profile=wheel, rail_profile=rail, gauge=1.435/scale, back_to_back=1.36/scale,
                                  gauge_depth=0.014/scale, rolling_radius=0.457/scale))
        assert scale*small.clearance[0] == pytest.approx(full.clearance[0], rel=2e-3)
        for amplitude in 2e-3, 3e-3, 4e-3:
            assert small.level.conicity_at(amplitude/scale) == pytest.approx(full.level.conicity_at(amplitude), abs=2e-3)
        assert f"scale 1:{scale:g}" in line_of(wheel, "flange height") and f"at {3/scale:g} mm" in small.lines()[2]
        wheel.write(tmp_path/"again.yz")
        again = Profile(tmp_path/"again.yz")
        assert again.as_it_is and again.scale == scale and again.measures == pytest.approx(wheel.measures, nan_ok=True)
    with pytest.raises(Error, match="scale from 1 to 10"):
        Profile(WHEEL/5, scale=12)


def test_noise_of_rounding_is_that_of_most_points(tmp_path: Path):
    (tmp_path/"w.txt").write_text(table.rounded_but_four(WHEEL))
    (tmp_path/"v.txt").write_text(shapes.rows(WHEEL.round(2), digits=4))
    for name in "w.txt", "v.txt":
        assert "points rounded: a noise of 2.9 µm at least" in Profile(tmp_path/name).notes


def corner(*radii: float) -> np.ndarray:
    """A rail's head, upright, with arcs of radii over equal angles from 80 to 20 degrees, beside a crown of 300 mm."""
    import make_profiles as arcs

    ends = np.radians(np.linspace(80, 20, len(radii) + 1))
    parts = [arcs.arc(radius, a, b) for radius, a, b in zip(radii, ends[:-1], ends[1:], strict=True)]
    half = arcs.chain((0.0, -40.0), arcs.line(np.radians(80), 20.0), *parts, arcs.arc(40.0, np.radians(20), np.radians(3)),
                      arcs.arc(300.0, np.radians(3), 0.0))
    points = arcs.sample(half, 0.1)
    return np.concatenate([points, (points*[-1, 1] + [2*points[-1, 0], 0])[-2::-1]])


def test_both_radii_of_a_corner_or_none():
    one, two, many = (Profile(corner(*radii), "rail") for radii in ((13.0,), (8.0, 16.0), (6.0, 20.0, 6.0, 20.0, 6.0)))
    assert 1e3*one.measures["corner_radius"] == pytest.approx(13, rel=2e-3) and "lower_corner_radius" not in one.measures
    assert 1e3*two.measures["corner_radius"] == pytest.approx(16, rel=0.03)
    assert 1e3*two.measures["lower_corner_radius"] == pytest.approx(8, rel=0.03)
    assert "one of two arcs" in line_of(two, "gauge corner radius, lower part")
    assert np.isnan(many.measures["corner_radius"]) and "none (no single arc" in line_of(many, "gauge corner radius")


def test_a_flat_crown_has_no_radius():
    flat = table.flat_crown(RAIL)
    for points in flat, flat.round(2):
        rail = Profile(points, "rail")
        assert np.isnan(rail.measures["crown_radius"]) and "none (no single arc" in line_of(rail, "crown radius")
        level = flat[flat[:, 1] > flat[:, 1].max() - 1e-9, 0]
        assert 1e3*rail.measures["top_y"] == pytest.approx((level[0] + level[-1])/2, abs=0.7)
        assert "flat within 3 µm from y = " in line_of(rail, "top of rail")


RUNS = {"lip": (WHEEL, table.lip(RAIL), 1.0), "section": (WHEEL, table.section(RAIL), 1.0),
        "hollow": (table.hollow(WHEEL), RAIL, 1.0), "roller rig": (WHEEL/5, RAIL/5, 5.0)}


@pytest.mark.parametrize("name", RUNS)
def test_exercise_2_runs(name: str, tmp_path: Path):
    """From the files to columns, with masses and loads of the scale's third and second power."""
    wheel, rail, scale = RUNS[name]
    case = Case.exercise(2)
    small = {"gauge": 1.435/scale, "back_to_back": 1.36/scale, "rolling_radius": case.rolling_radius/scale,
             "gauge_depth": case.gauge_depth/scale, "mass": case.mass/scale**3, "vertical_load": case.vertical_load/scale**2,
             "roll_inertia": case.roll_inertia/scale**5, "pitch_inertia": case.pitch_inertia/scale**5}
    found = run(case.replace(**EXERCISE | small, wheel_profile=written(tmp_path, "wheel.txt", wheel),
                             rail_profile=written(tmp_path, "rail.txt", rail), t_end=0.1))
    energy = found.data[["KE_lat", "KE_vert", "KE_roll", "PE_grav", "PE_load", "PE_elastic_L", "PE_elastic_R"]].sum(axis=1)
    assert np.ptp(energy) < 1e-6*found.data["KE_lat"].iloc[0]
    assert found.data["N_LF"].max() > 0 and "ldbench-" not in "".join(str(found.case.files().values()))
