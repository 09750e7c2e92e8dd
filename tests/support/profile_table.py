"""Wheels and rails from files as people have them, and their measures beside those of raw_measures: python profile_table.py.

A specimen is a pair in files, with the points that the files stand for: those of the file, in the place that is known here.
"""
from __future__ import annotations

import functools
import itertools
import os
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import raw_measures
import shapes
from ldbench import Case, Profile
from ldbench.geometry.outlines import case_outlines
from running import REPO

Points = np.ndarray
ALLOWED = 0.03          # of a measure, where no remark stands beside it
SMALL = 0.05            # of the place of a gauge point [mm]


@dataclass(frozen=True)
class Specimen:
    """A pair: names and contents of both files, and what they stand for."""
    name: str
    wheel: Points
    rail: Points
    wheel_file: tuple[str, str]
    rail_file: tuple[str, str]
    gauge: float = 1435.0
    back_to_back: float = 1360.0
    scale: float = 1.0
    depth: float = 14.0
    options: dict[str, object] = field(default_factory=dict)


@functools.cache
def shipped(name: str) -> Points:
    return np.loadtxt(REPO/"profiles"/f"{name}.yz")


def lip(rail: Points, depth: float = 33.0, size: float = 1.5) -> Points:
    """A rail measured down to a depth with a lip that stands out of its gauge corner, 10.8 mm below its top."""
    rail = rail[rail[:, 1] > -depth]
    out = np.where(rail[:, 0] < 20, size*np.exp(-((rail[:, 1] + 10.8)/1.3)**2), 0)
    return rail - np.column_stack([out, np.zeros(len(rail))])


def section(rail: Points, closed: bool = True) -> Points:
    """Head, web and foot, from the foot's lower corner on the gauge side, every 0.5 mm."""
    head = rail[rail[:, 1] > -36]
    middle = head[[0, -1], 0].mean()

    def way(end: Points, side: int) -> Points:
        corners = np.array([end, *(np.array([middle, 0]) + [[side*a, b] for a, b in (
            (30, -40), (8.25, -51), (8.25, -140), (75, -160), (75, -172))])])
        s = np.r_[0.0, np.cumsum(np.hypot(*np.diff(corners, axis=0).T))]
        at = np.arange(0.5, s[-1], 0.5)
        return np.column_stack([np.interp(at, s, column) for column in corners.T])

    made = np.concatenate([way(head[0], -1)[::-1], head, way(head[-1], 1)])
    foot = np.linspace(made[-1], made[0], 300)[1:-1]
    return np.roll(np.concatenate([made, foot]), 700, axis=0) if closed else made


def flat_crown(rail: Points) -> Points:
    """A crown worn flat over 14 mm."""
    middle = rail[rail[:, 1].argmax(), 0]
    level = np.interp(middle + 7, rail[:, 0], rail[:, 1])
    return np.column_stack([rail[:, 0], np.minimum(rail[:, 1], level)])


def hollow(wheel: Points, depth: float = 1.34) -> Points:
    """A tread worn hollow about the tape circle, by a depth at most."""
    share = np.clip(1 - ((wheel[:, 0] - 66)/16)**2, 0, None)**1.5
    return wheel + np.column_stack([np.zeros(len(wheel)), depth*share])


def perturbed(points: Points, seed: int) -> Points:
    """Wavy by some hundredths of a millimetre over 20 to 60 mm along y."""
    random = np.random.default_rng(seed)
    waves = sum(random.uniform(0.01, 0.04)*np.sin(points[:, 0]/random.uniform(3, 9) + random.uniform(0, 6)) for _ in range(3))
    return points + waves[:, None]*shapes.normals(points)


def rounded_but_four(points: Points) -> str:
    """Rounded to 0.01 mm, but for four rows."""
    rows = [f"{y:.2f} {z:.2f}" for y, z in points]
    for k in 50, 51, 200, 300:
        rows[k] = f"{points[k, 0]:.6f} {points[k, 1]:.6f}"
    return "\n".join(rows) + "\n"


def specimens() -> Iterator[Specimen]:
    """Pairs of a round, models, and a wheel and a rail at a time, each of them changed or written in another way."""
    for which in "a", "s":
        w, r = shipped(f"{which}wprof"), shipped(f"{which}rprof")
        for name, change in {"new": lambda wheel: wheel, **shapes.WORN_WHEELS, "0.01 mm": lambda wheel: wheel.round(2)}.items():
            if (which, name) != ("s", "flat spot"):
                text = shapes.rows(change(w), digits=2 if name == "0.01 mm" else 7)
                yield Specimen(f"{which}wprof, {name}", change(w), r, ("w.txt", text), ("r.yz", shapes.rows(r)), 1435.1, 1352.14)
    wheel, rail = shipped("s1002"), shipped("60e1")
    for scale in 3.0, 4.0, 5.0, 8.0, 10.0:
        w, r = wheel/scale, rail/scale
        yield Specimen(f"1:{scale:.0f}", w, r, ("w.txt", shapes.rows(w)), ("r.txt", shapes.rows(r)), 1435/scale, 1360/scale, scale,
                       14/scale, {"unit": "mm"} if scale > 5 else {})
    for k, (one, other) in enumerate(itertools.zip_longest(wheels(wheel), rails(rail), fillvalue=("plain", rail, "rail.yz", ""))):
        (name, points, file, text), options = one[:4], one[4] if len(one) > 4 else {}
        yield Specimen(f"{name} on {other[0]}", points, other[1], (file, text or shapes.rows(points)),
                       (other[2], other[3] or shapes.rows(other[1])), depth=15.875 if k == 1 else 14.0, options=options)


def wheels(wheel: Points) -> Iterator[tuple[Any, ...]]:
    """Name, points, name and contents of a file, and options."""
    yield "plain", wheel, "w.yz", ""
    yield "rounded to 0.01 mm", wheel.round(2), "w.txt", shapes.rows(wheel, digits=2)
    for name, points in (("hollow by 1.34 mm", hollow(wheel)), ("flange worn", shapes.thin_flange(wheel)),
                         ("tread hollow", shapes.hollow(wheel)), ("hollow by the throat", shapes.hollow_beside_throat(wheel, 0.5)),
                         *((f"perturbed, {seed}", perturbed(wheel, seed)) for seed in range(2)),
                         *((f"noise of {1e3*noise:.0f} um", shapes.noisy(wheel, noise, 7)) for noise in (0.001, 0.003, 0.01))):
        yield name, points, "w.txt", ""
    yield "rounded but four rows", wheel.round(2), "w.txt", rounded_but_four(wheel)
    yield "rounded to 0.1 mm", wheel.round(1), "w.txt", shapes.rows(wheel, digits=1)
    faced, bare = shapes.with_faces(wheel), wheel[wheel[:, 0] > 6]
    for off in -0.2, 0.25, 0.0:
        yield f"MiniProf, face at {off} mm", wheel + [off, 0], "w.whl", shapes.miniprof(faced + [off, 0], "wheel")
    yield "back told by its face", wheel, "w.txt", shapes.rows(faced + [33, 0])
    yield "tape circle at 0", wheel, "w.txt", shapes.rows(faced - [70, 0])
    yield "wheel_back given", bare, "w.txt", shapes.rows(bare + [33, 0]), {"wheel_back": 33.0}


def rails(rail: Points) -> Iterator[tuple[str, Points, str, str]]:
    """Name, points, name and contents of a file."""
    low, deep, worn = lip(rail), lip(rail, 36.0, 2.5), flat_crown(rail)
    yield from [
        ("lip", low, "r.ban", ""), ("lip, gauge 15.875 mm down", low, "r.ban", ""),
        ("lip of 2.5 mm, whole section", deep, "r.ban", shapes.rows(section(deep))),
        ("closed section", rail, "r.ban", shapes.rows(section(rail))),
        ("closed section, upside down", rail, "r.ban", shapes.rows(section(rail)*[1, -1])),
        ("open section", rail, "r.ban", shapes.rows(section(rail, False))),
        ("flat crown", worn.round(2), "r.ban", shapes.rows(worn, digits=2)), ("side worn", shapes.side_worn(rail), "r.ban", ""),
        ("0.01 mm", rail.round(2), "r.ban", shapes.rows(rail, digits=2)),
        ("noise of 3 um", shapes.noisy(rail, 0.003, 3), "r.ban", ""),
        ("SIMPACK", rail, "r.prr", shapes.simpack(rail, "rail")),
        ("perturbed", perturbed(rail, 9), "r.ban", "")]


@dataclass(frozen=True)
class Row:
    """A measure of a specimen by the program and from its points [mm], and the program's remark on it."""
    specimen: str
    measure: str
    found: float
    raw: float
    remark: str

    @property
    def off(self) -> bool:
        return abs(self.found - self.raw) > (SMALL if self.measure == "gauge_point_y" else ALLOWED*self.raw)


def case_of(one: Specimen, folder: Path) -> tuple[Case, Profile, Profile]:
    """The case of exercise 2 with the specimen's files, and its profiles."""
    made = []
    for kind, (name, text) in ("wheel", one.wheel_file), ("rail", one.rail_file):
        path = folder/name
        path.write_text(text)
        options = one.options if kind == "wheel" or "unit" in one.options else {}
        made.append(Profile(path, kind, gauge_depth=1e-3*one.depth, **options))
    case = Case.exercise(2).replace(
        wheel_profile=made[0], rail_profile=made[1], gauge=1e-3*one.gauge, back_to_back=1e-3*one.back_to_back,
        gauge_depth=1e-3*one.depth, rolling_radius=0.457/one.scale)
    return case, *made


def rows(one: Specimen, folder: Path) -> list[Row]:
    case, wheel, rail = case_of(one, folder)
    outlines = case_outlines(case)
    raw: dict[str, float] = raw_measures.wheel(one.wheel, one.scale)
    found = {name: 1e3*wheel.measures[name] for name in raw}
    raw["gauge_point_y"] = raw_measures.gauge_point(one.rail, one.depth)
    found["gauge_point_y"] = 1e3*rail.measures["gauge_point_y"]
    raw["clearance"] = raw_measures.clearance(one.wheel, one.rail, one.gauge, one.back_to_back, 457/one.scale, one.depth,
                                              case.flange_angle)
    found["clearance"] = 1e3*outlines.clearance[0]
    remarks = {name: "; ".join(filter(None, (wheel.remark(name), rail.remark(name)))) for name in found}
    return [Row(one.name, name, found[name], raw[name], remarks[name]) for name in found]


def main() -> int:
    count, off = 0, []
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for one in specimens():
            made = rows(one, Path(folder))
            print(f"{one.name:32}", *(f"{row.measure} {row.found:.3f} {row.raw:.3f}{'*' if row.off else ''}" for row in made),
                  sep="  ")
            count += 1
            off += [row for row in made if row.off]
    print(count, "specimens;", len(off), "numbers off, of which", sum(not row.remark for row in off), "without a remark")
    return 0


if __name__ == "__main__":
    sys.exit(main())
