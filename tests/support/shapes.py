"""Profiles as people have them, made from the shipped shapes: worn, with faces, noisy, in other formats."""
from collections.abc import Callable

import numpy as np

import make_profiles as arcs

DOWN = np.array([1, -1])
Points = np.ndarray     # (n, 2) y, z [mm], left side, z up


def shape(name: str, spacing: float = arcs.STEP) -> Points:
    """The exact shape of a shipped profile."""
    made = {"arprof": arcs.arprof, "srprof": arcs.srprof, "60e1": arcs.rail60e1,
            "awprof": lambda: arcs.awprof(55.130579), "swprof": lambda: arcs.swprof(39.123982)}
    return arcs.sample(made[name](), spacing)


def normals(points: Points) -> Points:
    y, z = np.gradient(points, axis=0).T
    return np.column_stack([-z, y])/np.hypot(y, z)[:, None]


def noisy(points: Points, noise: float, seed: int) -> Points:
    """Points off the curve by a normally distributed distance, and along it by as much."""
    random = np.random.default_rng(seed)
    n = normals(points)
    along = np.column_stack([n[:, 1], -n[:, 0]])
    return points + noise*(n*random.normal(size=(len(points), 1)) + along*random.normal(size=(len(points), 1)))


def with_faces(wheel: Points, step: float = 0.25) -> Points:
    """A wheel from its back's face over the tread, chamfer and rim face, as a gauge measures it."""
    back = np.column_stack([np.full(60, wheel[0, 0]), wheel[0, 1] + step*np.arange(60, 0, -1)])
    edge = wheel[-1]
    chamfer = edge + np.outer(np.arange(step, 5, step), [1, 1])
    face = chamfer[-1] + np.outer(np.arange(step, 20, step), [0, 1])
    return np.concatenate([back, wheel, chamfer, face])


def bump(points: Points, centre: float, width: float, height: float) -> Points:
    """Points moved along their normal, where y is near `centre`: worn by a height > 0 on a wheel."""
    share = np.clip(1 - ((points[:, 0] - centre)/width)**2, 0, None)**2
    return points + height*share[:, None]*normals(points)


def hollow(wheel: Points) -> Points:
    """A tread worn hollow by 1.5 mm."""
    return bump(wheel, 80, 28, 1.5)


def wide(wheel: Points, width: float = 30.0, step: float = 0.25) -> Points:
    """A wheel whose tread goes on to the field side by a width."""
    run = np.arange(step, width + step/2, step)[:, None]
    way = wheel[-1] - wheel[-5]
    return np.concatenate([wheel, wheel[-1] + run*way/way[0]])


def hollow_beside_throat(wheel: Points, depth: float) -> Points:
    """A tread worn hollow close to the throat of the flange."""
    y, z = wheel.T
    return np.column_stack([y, z + depth*np.exp(-((y - 75)/15)**2)*np.clip((y - 45)/15, 0, 1)])


def thin_flange(wheel: Points) -> Points:
    """A flange face worn by 2 mm, as steep as it was."""
    return bump(wheel, 31, 11, 2.0)


def flat_spot(wheel: Points) -> Points:
    """A tread with a level strip, 66 to 76 mm from the back, and a ramp of 1:20 up to it."""
    y, z = wheel.T
    level = np.interp(76, y[y > 60], z[y > 60])
    rise = np.clip(np.minimum(level - z, (y - 60)/20), 0, None)
    return np.column_stack([y, z + np.where((y > 60) & (y < 76), rise, 0)])


def conforming(rail: Points) -> Points:
    """A wheel of the rail's own shape, 0.1 mm off, from crown to gauge corner, with many arcs of either sign."""
    head = rail[(rail[:, 1] > -9) & (rail[:, 0] < 43)] + [39.0, 0]     # conforms at Y = 2.5 mm
    normal = normals(head)
    near = head + 0.1*normal + 0.004*np.sin(head[:, :1])*normal
    low = near[0] + np.outer(np.arange(-5, 0, 0.25), [np.cos(1.2), np.sin(1.2)])
    tip = low[0] + 8*np.column_stack([np.sin(np.arange(-1.5, 1.2, 0.03)) - np.sin(1.2),
                                      np.cos(1.2) - np.cos(np.arange(-1.5, 1.2, 0.03))])
    tread = near[-1] + np.outer(np.arange(0.25, 50, 0.25), [1, 0.02])
    return np.concatenate([tip[:-1], low, near, tread])


def side_worn(rail: Points) -> Points:
    """A rail whose gauge corner is worn by 2 mm."""
    return bump(rail, 4, 14, -2.0)


def straight_face(rail: Points, angle: float, step: float = 0.1) -> Points:
    """A rail whose gauge face is straight for 20 mm, at an angle in degrees, below where the corner is as steep."""
    way = np.diff(rail, axis=0)
    first = np.argmax(np.arctan2(way[:, 1], way[:, 0]) < np.radians(angle))
    run = np.arange(20, 0, -step)[:, None]
    return np.concatenate([rail[first] - run*[np.cos(np.radians(angle)), np.sin(np.radians(angle))], rail[first:]])


WORN_WHEELS: dict[str, Callable[[Points], Points]] = {
    "hollow tread": hollow, "thin flange": thin_flange, "flat spot": flat_spot,
    "hollow tread, thin flange": lambda wheel: hollow(thin_flange(wheel))}


def rows(points: Points, between: str = " ", digits: int = 7, after: str = "") -> str:
    """The points as lines of text."""
    return "".join(f"{y:.{digits}f}{between}{z:.{digits}f}{after}\n" for y, z in points)


def miniprof(points: Points, kind: str, ends: str = "\n\n", digits: int = 7) -> str:
    """MiniProf's newer form: names and values, an offset, four columns; the flange's tip up."""
    return ("ProgramName=MiniProf\nProgramVer=2.4\nStock=%12\nXOffset=1.5\nYOffset=-2.0\nColumnDef=X,Y,A,C\n"
            f"XYPoints={len(points)}{ends}" + rows(points*DOWN - [1.5, -2], digits=digits, after=" 0.1 0.2"))


def old_miniprof(points: Points, kind: str, digits: int = 7) -> str:
    """MiniProf's older form: free lines, numbers among them, a blank line, then X Y A."""
    heading = f"#Mini{kind.capitalize()}Prof 2003 11\nmeasured by nobody\n32.58 37.11 14.71\n\n"
    return heading + rows(points*DOWN, "\t", digits, "\t0.0")


def simpack(points: Points, kind: str, unit: float = 1000.0, digits: int = 7) -> str:
    """z down, y of a wheel from the tape circle, shifted and mirrored back, one point beyond the bounds."""
    moved = (points - [70 if kind == "wheel" else 0, 0])*[-1, -1] - [2.5, 0]
    moved = np.vstack([moved, [300.0, 0.0]])*unit/1000
    shift, least, most = (f"{x*unit/1000:g}" for x in (2.5, -200, 200))
    return (f"! a profile\nheader.begin\n  version = 1\n  type = {int(kind == 'wheel')} ! 1 wheel\nheader.end\nspline.begin\n"
            f"  approx.smooth = 0.0\n  comment = 'none'\n  shift.y = {shift}\n  rotate = 0.0\n  bound.y.min = {least}\n"
            f"  bound.y.max = {most}\n  mirror.y = 1\n  units.len = 'mm'\n  units.len.f = {unit:g}\n  point.begin\n"
            + rows(moved, digits=digits, after=" 1.0") + "  point.end\nspline.end\n")


FORMATS: dict[str, Callable[[Points, str], str]] = {
    "plain": lambda points, kind: rows(points), "old MiniProf": old_miniprof, "MiniProf": miniprof, "SIMPACK": simpack}
