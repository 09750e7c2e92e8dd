"""Files of strangers: 56 wheels and rails whose shape is known, and 39 that must be refused or told.

The specimens were written without knowledge of the reader: tests/support/stranger_profiles.py.
"""
from contextlib import nullcontext, suppress
from pathlib import Path

import numpy as np
import pytest

import ldbench
import shapes
from ldbench import Profile
from ldbench.profiles.profile import core_takes
from stranger_profiles import BROKEN, FILE_CHECK, SPECIMENS, Broken, Specimen

# What may pass if a note tells it: a word of the note.
TOLD = {"lastline.txt": "dropped", "cm.txt": "in cm", "rail_cm.txt": "in cm", "gap.txt": "gap"}


def distances(points: np.ndarray, exact: np.ndarray) -> np.ndarray:
    """Distances of points from a polygon [mm]."""
    start, way = exact[:-1], np.diff(exact, axis=0)
    lengths = np.maximum(np.sum(way**2, 1), 1e-30)
    found = []
    for p in points:
        share = np.clip(np.sum((p - start)*way, 1)/lengths, 0, 1)
        found.append(np.min(np.hypot(*(start + share[:, None]*way - p).T)))
    return np.array(found)


def placed(profile: Profile, points: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """Points with the truth's height; a rail's with its gauge point, too, of which only differences count in a run."""
    if profile.kind == "wheel":
        return points + [0.0, np.interp(70, *truth.T) - np.interp(70, *profile.curve.T)]
    measured = 1e3*profile.measures["gauge_point_y"]
    return points - [measured, profile.curve[:, 1].max() - truth[:, 1].max()]


@pytest.mark.parametrize("specimen", SPECIMENS, ids=lambda specimen: specimen.name)
def test_a_strangers_file_is_placed_and_smoothed(specimen: Specimen, tmp_path: Path):
    """The points lie on the true shape to their noise and rounding, the curve to three times that, and 2 um; measures of a
    wheel are those of the exact shape. What nobody could know from the file is refused, or what was assumed is noted."""
    file = tmp_path/specimen.name
    file.write_bytes(specimen.data)
    profile = None
    with suppress(ldbench.Error) if specimen.doubt else nullcontext():
        profile = Profile(file, specimen.kind, **specimen.hint)
    if profile is None:
        return
    assert profile.kind == specimen.kind
    if specimen.doubt:
        assert profile.notes
        return
    assert profile.format == specimen.format
    written = FILE_CHECK[specimen.name]       # rms distance of the file's numbers from the truth: noise and rounding [mm]
    off = distances(placed(profile, profile.points, specimen.truth), specimen.truth)
    assert off.max() < 5*written + 1e-3
    curve = distances(placed(profile, profile.curve, specimen.truth), specimen.truth)
    chord = np.median(np.hypot(*np.diff(specimen.truth, axis=0).T))**2/100       # of a side of the truth, on radii of 12 mm [mm]
    assert curve.max() < 3*written + 2e-3 + chord or "wavy: smoothed by" in str(profile.notes)
    if specimen.kind == "wheel":
        for name in "Sd", "Sh":
            assert 1e3*profile.measures[name] == pytest.approx(getattr(specimen, name), abs=2*specimen.noise + 6e-3)
    if specimen.noise:
        assert profile.noise == pytest.approx(specimen.noise, rel=0.2)


@pytest.mark.parametrize("broken", BROKEN, ids=lambda broken: broken.name)
def test_a_broken_file_is_refused_or_told(broken: Broken, tmp_path: Path):
    """In one line with the file's name and what was expected."""
    file = tmp_path/broken.name
    file.write_bytes(broken.data)
    if broken.name in TOLD:
        assert TOLD[broken.name] in str(Profile(file, broken.kind).notes)
        return
    with pytest.raises(ldbench.Error) as refused:
        Profile(file, broken.kind)
    assert str(file) in str(refused.value) and "expected" in str(refused.value) and "\n" not in str(refused.value)


def agreement() -> dict[str, tuple[str, bytes]]:
    """Kind and exact points of every specimen, and of shipped profiles as they are, mirrored, moved, with faces or a web."""
    found = {s.name: (s.kind, s.truth) for s in SPECIMENS}
    for kind, names, more in ("wheel", ("awprof", "swprof"), shapes.with_faces), (
            "rail", ("arprof", "srprof", "60e1"), shapes.with_web):
        for name in names:
            points = shapes.shape(name)
            for what, changed in (("", points), ("mirrored", (points*[-1, 1])[::-1]), ("more", more(points)),
                                  ("moved", points - [35, 0]), ("low", points - [0, 160]),
                                  ("moved, mirrored", ((points - [35, 0])*[-1, 1])[::-1])):
                found[f"{name} {what}"] = kind, changed
    return {name: (kind, shapes.rows(points).encode()) for name, (kind, points) in found.items()}


AGREEMENT = agreement()


@pytest.mark.parametrize("name", AGREEMENT)
def test_what_the_core_reads_python_leaves_as_it_is(name: str, tmp_path: Path):
    """So that the executable and Python never take one file for two curves."""
    kind, data = AGREEMENT[name]
    (tmp_path/"a.yz").write_bytes(b"# \xe9\n" + data)
    assert name not in ("awprof ", "swprof ", "arprof ", "srprof ", "60e1 ") or core_takes(str(tmp_path/"a.yz"), kind)
    if core_takes(str(tmp_path/"a.yz"), kind):
        profile = Profile(tmp_path/"a.yz", kind)
        assert profile.as_it_is and profile.data == (tmp_path/"a.yz").read_bytes()
