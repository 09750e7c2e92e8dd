"""Where a profile lies: its unit, which way its axes point, where a wheel's back is, and which points can be running surface.

The shape tells what the file does not. A wheel is placed by the convention of its format, by `wheel_back`, by a face of its back,
or by a y = 0 that can only be the tape circle or the back; nothing else is guessed.
"""
from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .._core.errors import Error
from ..constants import MM, TAPE_CIRCLE
from .formats import UNITS, Raw
from .repair import LEAST_POINTS, on_curve

FACE = np.sin(np.radians(60))           # sine of the angle of a face at the end of a profile
BACK_FACE = np.sin(np.radians(80))      # and of a wheel's back
LEAST_BACK = 3.0                        # height of a back that shows [mm]
CHORD = 3.0                             # length over which directions are taken: larger than any noise [mm]
FACE_NOISE = 0.15                       # by which a face may miss the origin that it confirms [mm]
LEAST_TOLD = 0.02                       # by which a face of the back may miss the back without a remark [mm]
NEAR = 3.0                              # from the end of the flange, y = 0 is the back [mm]
BACK_END = np.radians(55)               # steepness of the flange where it comes to the back
RIM = 10.0                              # the rim's face goes at most so far out [mm]
WIDTHS = {"wheel": (80.0, 200.0), "rail": (50.0, 110.0)}    # of a wheel, and of a rail's head [mm]
FLANGE = 15.0, 45.0                     # height [mm]
LEAST_FLANGE = 12.0                     # by which a wheel is told from a rail [mm]
SMALLEST = 10.0                         # of models: 1:10
SCALES = 3.0, 4.0, 5.0, 8.0, 10.0       # of models that the size tells: larger ones could be parts of a profile
USUAL = {"wheel": (135.0, 28.0), "rail": (72.0, 0.0)}   # width, and height of a flange, at full size [mm]
MODEL_OFF = 0.3                         # of the logarithm of a size of a model from the usual one
DEEPEST_GAUGE = 20.0                    # below the top of a rail, of all that are in use [mm]
GAP = 12.0                              # between points, over which the side of a rail is not known [mm]
SAME_SIDE = 0.02                        # by which points of a side may stand before its innermost one [mm]
DEEPEST = 60.0                          # below its top, a rail has no running surface [mm]
CLOSED = 0.15                           # distance of the ends of a whole section, over its outline, at most
LEAST_HEAD = 5.0                        # height of a rail's head above its sides [mm]
GAUGE_DEPTH = 14.0                      # below the top of a rail, at which its gauge and its head's width are measured [mm]
TIP = 3.0, 40.0                         # of a flange, from the back [mm]


@dataclass(frozen=True)
class Placed:
    """Points of a profile in its place."""
    points: np.ndarray      # (n, 2) [mm]: z up, y to the field side, in order towards it; y of a wheel from its back
    lines: np.ndarray       # (n,) line of each point in the file
    kind: str               # 'wheel' or 'rail'
    unit: float             # millimetres per unit of the file
    origin: str             # how the origin was taken, in words
    notes: list[str]        # what was turned over, converted, left out
    scale: float = 1.0      # 5 of a profile 1:5: `points` and `unit` are those of its full size
    hidden: float = 0.0     # depth below the top of a rail to which it goes on behind its first point, in points left out [mm]
    remarks: dict[str, str] = field(default_factory=dict)      # on measures, by name: what was done that changes them


@dataclass
class _Shape:
    """What points [mm] look like as a wheel or a rail."""
    kind: str                           # 'wheel', 'rail' or ''
    turned: tuple[bool, bool] = (False, False)      # whether y, z must be turned over
    width: float = 0.0                  # of a wheel, or of the head of a rail [mm]
    height: float = 0.0                 # of the flange above the tread's middle, or of the head above its sides [mm]

    def fault(self, kind: str) -> tuple[str, str] | None:
        """What is expected of a wheel or a rail and what is found instead; None where the shape is plausible."""
        if not 10 <= self.width <= 1000:
            return ("y in millimetres over 80 to 200 mm of a wheel or 50 to 110 mm of a rail's head",
                    f"a width of {self.width:.4g}")
        if (kind and self.kind != kind) or not self.kind:
            what = "a rail" if self.kind == "rail" else "a wheel" if self.kind == "wheel" else "neither"
            return (f"a {kind}" if kind else "a wheel or a rail",
                    f"the shape of {what}, {self.width:.4g} mm wide and {self.height:.3g} mm high")
        least, most = WIDTHS[self.kind]
        if not least <= self.width <= most:
            what = "a wheel" if self.kind == "wheel" else "a rail's head"
            return f"y in millimetres over {least:g} to {most:g} mm of {what}", f"a width of {self.width:.4g}"
        if self.kind == "wheel" and not FLANGE[0] <= self.height <= FLANGE[1]:
            return f"a flange {FLANGE[0]:g} to {FLANGE[1]:g} mm high", f"{self.height:.4g} mm"
        return None


def place(raw: Raw, where: str, kind: str = "", unit: str = "auto", flip: str = "auto", wheel_back: float | None = None,
          scale: float | None = None) -> Placed:
    """Bring points into millimetres, axes into direction, and y of a wheel to its back.

    `kind` is 'wheel', 'rail' or '' for what the file or the shape says; `unit` 'auto', 'mm', 'cm', 'm' or 'in'; `flip` 'auto',
    'none', 'y', 'z' or 'yz', the axes to turn over; `wheel_back` the y of the wheel's back in the file [mm]; `scale` 5 for a
    model 1:5, None for the one that the size says. Raises Error, beginning with `where`, for what is no profile or may be several.
    """
    if kind and raw.kind not in ("", kind):
        raise Error(file=where, expected=f"a {kind}", found=f"a file that says it is a {raw.kind}",
                    advice="name another file, or rename this one where only its ending says so")
    if unit not in ("auto", *UNITS) or flip not in ("auto", "none", "y", "z", "yz"):
        raise Error(file=where, expected="unit auto, mm, cm, m or in and flip auto, none, y, z or yz", found=f"{unit} and {flip}",
                    advice="correct them")
    notes: list[str] = []
    points, lines = _without_strays(raw, notes)
    if len(points) < LEAST_POINTS:
        raise Error(file=where, expected=f"at least {LEAST_POINTS} points", found=len(points),
                    advice="give more points")
    kind = kind or raw.kind
    if scale is not None and not 1 <= scale <= SMALLEST:
        raise Error(file=where, expected=f"a scale from 1 to {SMALLEST:g}, 5 for a model 1:5", found=f"{scale:g}")
    remarks: dict[str, str] = {}
    hidden = 0.0
    factor, scale, shape = _unit(raw, points, where, kind, unit, scale, notes)
    if scale > 1:
        remarks |= {"Sh": f"tape circle {MM*TAPE_CIRCLE/scale:.4g} mm from the back by the scale 1:{scale:g}",
                    "Sd": f"{10/scale:.4g} mm below the tape circle's level, scale 1:{scale:g}",
                    "qR": f"up to {2/scale:.4g} mm from the tip, scale 1:{scale:g}"} if shape.kind == "wheel" else {}
    if wheel_back is not None:
        wheel_back *= scale
    turned = shape.turned if flip == "auto" else ("y" in flip, "z" in flip)
    if raw.format == "VAMPIRE" and flip == "auto":
        turned = False, turned[1]       # the format says to which side y grows
    if turned[1] != shape.turned[1]:
        raise Error(file=where, expected="z upwards", found=f"the {shape.kind} upside down with flip={flip}",
                    advice="turn z over or leave flip out")
    if any(turned):
        notes.append(" and ".join(axis for axis, one in zip("yz", turned, strict=True) if one) + " turned over")
    sign = -1 if turned[0] else 1
    points, lines = _in_order(factor*points*[sign, -1 if turned[1] else 1], lines)
    on = np.flatnonzero(on_curve(points)[0])
    if shape.kind == "rail":
        first, last = _head(points[on])
        hidden = _hidden(points[on], first)
        depth = points[on][:, 1].max() - points[on][:, 1].min()
        origin = "as the file has it"
    else:
        back, origin, remark = _wheel_origin(raw, points[on], where, wheel_back, sign, factor, scale)
        if remark:
            remarks["clearance"] = remark
            remarks["Sd"] = "; ".join(filter(None, (remarks.get("Sd", ""), remark)))
        points = points - [back, 0.0]
        height, first, last = _running_surface(points[on])
        if not FLANGE[0] <= height <= FLANGE[1]:
            raise Error(file=where, expected=f"a flange {FLANGE[0]:g} to {FLANGE[1]:g} mm high",
                        found=f"{height:.4g} mm above the tape circle, with the {origin}",
                        advice="look at unit=, flip= and wheel_back=, and for points off the profile")
        if points[on[last]:, 0].max() > points[on[last], 0] + RIM:
            raise Error(file=where, line=lines[on[last]], expected="the face of a rim at the end of the profile",
                        found=f"a part as steep at y = {points[on[last], 0]:.1f} mm from the back",
                        advice="look for points off the profile")
    # Where nothing is cut, points off the curve stay at the end, to be mended.
    first, last = on[first] if first else 0, on[last] if last < len(on) - 1 else len(points) - 1
    if last - first + 1 >= LEAST_POINTS and last - first + 1 < len(points):
        if shape.kind == "rail" and depth > DEEPEST:
            count = len(points) - (last - first + 1)
            notes.append(f"a section of {depth/scale:.4g} mm, cut below its head: {count} points left out")
        else:
            notes.append("faces beyond the running surface left out")
        points, lines = points[first:last + 1], lines[first:last + 1]
        if hidden > 0:      # the depth is that of the lip
            depth = points[:, 1].max() - points[0, 1]
            words = f"the side goes back below a lip {depth/scale:.2f} mm down and stays behind it to {hidden/scale:.2f} mm"
            remarks["gauge_point_y"] = remarks["clearance"] = words
    return Placed(points, lines, shape.kind, factor, origin, notes, scale, hidden, remarks)


def _without_strays(raw: Raw, notes: list[str]) -> tuple[np.ndarray, np.ndarray]:
    """Drop first and last points that are farther from the others than a good part of the profile is wide, and off its
    direction."""
    points, lines = raw.points, raw.lines
    if _closed(points):
        return points, lines
    for end in 0, -1:
        if len(points) <= LEAST_POINTS:
            break
        a, b, c = points[[0, 1, 2] if end == 0 else [-1, -2, -3]]
        extent = np.ptp(np.delete(points, end, axis=0), axis=0).max()
        usual = np.median(np.hypot(*np.diff(points, axis=0).T))
        way, ahead = np.hypot(*(a - b)), np.hypot(*(b - c))
        if way > extent*np.clip(20*usual/max(extent, 1e-9), 0.25, 0.75) and (a - b) @ (b - c) < np.cos(np.radians(20))*way*ahead:
            notes.append(f"line {lines[end]}, {way:.4g} from its neighbour, is off the profile: dropped")
            points, lines = np.delete(points, end, axis=0), np.delete(lines, end)
    return points, lines


def _unit(raw: Raw, points: np.ndarray, where: str, kind: str, unit: str, scale: float | None,
          notes: list[str]) -> tuple[float, float, _Shape]:
    """Millimetres of full size per unit, the scale, and the shape at full size.

    The unit is what the caller says, else what the file says, else the first of mm, m, inches and cm in which the shape is
    plausible at full size. A shape that is plausible in none of them is a model where a scale of SCALES makes it a
    usual one.
    """
    given = UNITS[unit] if unit != "auto" else raw.unit
    units = ((given, ""),) if given else ((1.0, ""), (1e3, "in m"), (25.4, "in inches"), (10.0, "in cm"))
    for factor, words in units:
        shape = _recognise((scale or 1.0)*factor*points[on_curve(factor*points)[0]], kind)
        if not (fault := shape.fault(kind)):
            notes += [words] if words else []
            if scale and scale != 1:
                notes.append(f"scale 1:{scale:g}")
            return (scale or 1.0)*factor, scale or 1.0, shape
        if factor == (given or 1.0):
            expected, found = fault
    for factor, words in () if scale else units:
        if model := _model(factor*points, kind):
            notes += [*([words] if words else []), f"scale 1:{model[0]:g}, by the size"]
            return model[0]*factor, *model
    raise Error(file=where, expected=expected, found=found,
                advice="look at the unit (unit=), the scale of a model (scale=), the columns, and for points off the profile")


def _model(points: np.ndarray, kind: str) -> tuple[float, _Shape] | None:
    """The scale of a model whose points are in mm, and its shape at full size; None where the points are no model."""
    found = []
    for scale in SCALES:
        shape = _recognise(scale*points[on_curve(scale*points)[0]], kind)
        if shape.fault(kind):
            continue
        width, height = USUAL[shape.kind]
        off = [abs(np.log(shape.width/width)), abs(np.log(shape.height/height)) if height else 0.0]
        if max(off) < MODEL_OFF:
            found.append((sum(off), scale, shape))
    return min(found, key=lambda one: one[0])[1:] if found else None


def _recognise(points: np.ndarray, kind: str) -> _Shape:
    """Tell a wheel from a rail, by which of them is plausible, and which axes must be turned over."""
    beside = 0.5 if kind == "rail" else 0.4     # a worn head may have its top at one side
    found = [_as_wheel(points), _as_rail(points, beside)]
    if _closed(points):
        found = [_as_rail(np.roll(points, -end, axis=0), beside) for end in (points[:, 1].argmin(), points[:, 1].argmax())]
    found.sort(key=lambda shape: (bool(kind) and shape.kind != kind, not shape.kind))
    return next((shape for shape in found if not shape.fault(kind)), found[0])


def _as_wheel(points: np.ndarray) -> _Shape:
    """Without the faces at both ends, the flange reaches farthest from the level of the tread, and beside its middle."""
    s, angle = _directions(points, CHORD)
    flat = np.flatnonzero(np.abs(np.sin(angle)) <= FACE)
    width = float(np.ptp(points[:, 0]))
    shape = _Shape("", width=width, height=float(np.ptp(points[:, 1])))
    if len(flat) < 6:
        return shape
    inner, length = points[flat[0]:flat[-1] + 1], np.gradient(s)[flat[0]:flat[-1] + 1]
    order = inner[:, 1].argsort()
    level = inner[order[np.searchsorted(np.cumsum(length[order]), length.sum()/2)], 1]
    low, high = level - inner[:, 1].min(), inner[:, 1].max() - level
    tip = inner[inner[:, 1].argmax() if high > low else inner[:, 1].argmin()]
    beyond = (points[:, 1].max() - tip[1]) if high > low else (tip[1] - points[:, 1].min())
    middle = (points[:, 0].min() + points[:, 0].max())/2
    # The head of a rail has its top in the middle, and both of its sides go down farther than where they become faces.
    if max(low, high) >= max(LEAST_FLANGE, 1.5*min(low, high)) and abs(tip[0] - middle) > 0.15*width and beyond < 1:
        return _Shape("wheel", (bool(tip[0] > middle), bool(high > low)), width, float(max(low, high)))
    return shape


def _as_rail(points: np.ndarray, beside: float) -> _Shape:
    """The head is above its sides, with its top within a share `beside` of its width from its middle. The side towards the track
    is the one at y = 0, else the lower one; the y of an upright rail stays."""
    away = np.abs(points[:, 0] - (points[:, 0].min() + points[:, 0].max())/2)
    rises = points[away <= max(away.min(), 0.02*np.ptp(points[:, 0])), 1] - points[[0, -1], 1].mean()
    rise = rises[np.abs(rises).argmax()]
    y, z = points[:, 0], points[:, 1]*(1 if rise > 0 else -1)
    top = int(z.argmax())
    low = z < z[top] - GAUGE_DEPTH
    before, after = np.flatnonzero(low[:top]), np.flatnonzero(low[top:])
    first, last = before[-1] + 1 if len(before) else 0, top + after[0] - 1 if len(after) else len(z) - 1
    sides = y[[first, last]]
    width = float(abs(np.diff(sides)[0]))
    if abs(rise) < LEAST_HEAD or abs(y[top] - sides.mean()) > beside*width:
        return _Shape("", width=width, height=float(abs(rise)))
    turn = False
    if np.abs(sides).min() < NEAR and np.abs(sides).max() > 30:
        turn = bool(sides.sum() < 0)
    else:
        crown = (np.abs(y - sides.mean()) < width/4) & (z > z[top] - 10)
        if crown.sum() > 2:
            slope = np.polyfit(y[crown] - sides.mean(), z[crown], 1)[0]
            turn = bool(slope < -3e-3)
    return _Shape("rail", (turn, bool(rise < 0)), width, float(abs(rise)))


def _directions(points: np.ndarray, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Stations of points [mm], and the direction of a chord of the given length about each of them [rad], both (n,)."""
    # Where points are dense their polygon is longer than the profile, by the noise: means of some points are not.
    coarse = np.hypot(*np.diff(points[::max(1, len(points)//400)], axis=0).T).sum()
    group = int(np.clip(0.4*len(points)/max(coarse, 1e-9), 1, max(1, len(points)//10)))
    sides = group//2, (group - 1)//2
    means = np.stack([np.convolve(np.pad(x, sides, "edge"), np.full(group, 1/group), "valid") for x in points.T])
    s = np.r_[0.0, np.cumsum(np.hypot(*np.diff(means)))]
    i = np.arange(len(s))
    low = np.minimum(np.maximum(np.searchsorted(s, s - length/2, "right") - 1, 0), np.maximum(i - 1, 0))
    high = np.clip(np.searchsorted(s, s + length/2), np.minimum(i + 1, len(s) - 1), len(s) - 1)
    way = (means[:, high] - means[:, low]).T
    return s, np.arctan2(way[:, 1], way[:, 0])


def _closed(points: np.ndarray) -> bool:
    """Whether points go round a whole rail: their ends are near to each other for so long a way, also where a part of the way
    along web or foot is missing."""
    # Where points are dense, some of them tell the way without its noise; corners of a section may be all that it has.
    steps = np.hypot(*np.diff(points[::max(1, len(points)//400)], axis=0).T)
    longest = float(steps[1:-1].max(initial=0.0))
    return bool(np.hypot(*(points[-1] - points[0])) < max(CLOSED*steps.sum(), 1.2*longest))


def _in_order(points: np.ndarray, lines: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points in order towards the field side. A closed contour begins at its lowest point."""
    n = len(points)
    forward = bool(points[0, 0] <= points[-1, 0])
    if _closed(points):
        low = points[:, 1].argmin()
        points, lines = np.roll(points, -low, axis=0), np.roll(lines, -low)
        top = int(points[:, 1].argmax())
        forward = bool(points[max(top - 1, 0), 0] <= points[min(top + 1, n - 1), 0])
    return (points, lines) if forward else (points[::-1], lines[::-1])


def _wheel_origin(raw: Raw, points: np.ndarray, where: str, wheel_back: float | None, sign: int,
                  factor: float, scale: float) -> tuple[float, str, str]:
    """y of the wheel's back among turned points [mm], how it is told, and a remark where a face of the back is elsewhere."""
    tip = int(points[:, 1].argmin())
    end, face = float(points[:tip + 1, 0].min()), _back_face(points, tip)
    turned, remark = sign/scale, ""         # from full size to the file
    advice = f"give wheel_back=, the y of the wheel's back in the file in mm (the flange ends at {turned*end:.4g} mm)"
    if wheel_back is not None:
        back, words = sign*wheel_back, f"back of the wheel at y = {wheel_back/scale:g} mm of the file (wheel_back)"
        advice = f"correct wheel_back (the flange ends at {turned*end:.4g} mm of the file)"
    elif raw.back is not None:
        back = sign*factor*raw.back
        words = f"tape circle at y = 0, {MM*TAPE_CIRCLE/scale:g} mm from the back ({raw.format})"
        tape = abs(abs(back)/scale - MM*TAPE_CIRCLE) < 1e-6
        if tape:
            back /= scale
        # Left and right sides have the back at opposite signs of y.
        back = -back if back > points[tip, 0] else back
        if not tape:
            words = f"back of the wheel at y = {turned*back:.6g} mm of the file ({raw.format})"
        if face is not None and abs(face - back) > NEAR:
            raise Error(file=where, expected=f"the {words}", found=f"a face of the back at {turned*face:.4g} mm",
                        advice=advice)
    else:
        back, words = _told_origin(points, tip, end, face, turned, raw.format == "MiniProf")
        if not words:
            raise Error(file=where, expected=f"y = 0 on the tread, at the tape circle, or within {NEAR:g} mm of the wheel's back",
                        found=f"the tip of the flange at {turned*points[tip, 0]:.4g} mm and no face of the back",
                        advice=advice)
    if not (TIP[0] <= points[tip, 0] - back <= TIP[1] and back < end + NEAR):
        raise Error(file=where,
                    expected=f"the tip of the flange {TIP[0]:g} to {TIP[1]:g} mm from the back and no points beyond it",
                    found=f"{points[tip, 0] - back:.4g} mm and points from {end - back:.4g} mm on, with the {words}",
                    advice=advice)
    if face is not None and wheel_back is None and abs(face - back) > LEAST_TOLD:
        remark = f"from the {words.split(' (')[0]}; a face of the back stands at y = {turned*face:.2f} mm, not used"
    elif "of the file" in words and raw.back is None and wheel_back is None:
        remark = f"from the most negative point of the back's face, y = {turned*back:.2f} mm of the file"
    return back, words, remark


def _told_origin(points: np.ndarray, tip: int, end: float, face: float | None, turned: float,
                 convention: bool) -> tuple[float, str]:
    """The back as the shape tells it, by its face or by where y = 0 lies; no words where it does not tell it. Where a format has
    the `convention` that y = 0 is the back, a face near to it does not count."""
    back, tape = "back of the wheel at y = 0", f"tape circle at y = 0, {abs(turned)*MM*TAPE_CIRCLE:g} mm from the back"
    if face is not None:
        if convention and abs(face) <= NEAR:
            return 0.0, back
        near = min((0.0, -MM*TAPE_CIRCLE), key=lambda y: abs(y - face))
        if abs(face - near) <= FACE_NOISE:
            return near, tape if near else back
        return face, f"back of the wheel at y = {round(turned*face, 3):g} mm of the file"
    if abs(end) <= NEAR and -_directions(points[:tip + 1], CHORD/2)[1][0] > BACK_END:
        return 0.0, back
    _, angle = _directions(points[tip:], CHORD)
    tread = np.flatnonzero((np.abs(angle) < np.radians(20)) & (points[tip:, 0] > points[tip, 0] + 15))
    first, last = points[tip + tread[[0, -1]], 0] if len(tread) else (1, 0)
    if first <= 0 <= last and TIP[0] <= points[tip, 0] + MM*TAPE_CIRCLE <= TIP[1]:
        return -MM*TAPE_CIRCLE, tape
    return 0.0, ""


def _back_face(points: np.ndarray, tip: int) -> float | None:
    """y of a nearly vertical part, at least 3 mm high, before the tip of the flange; None where there is none."""
    if tip < 1:
        return None
    way = np.diff(points[:tip + 1], axis=0)
    if np.hypot(*way.T).min() < CHORD/2:
        _, angle = _directions(points[:tip + 1], CHORD/2)
        steep = (np.abs(np.sin(angle)) > BACK_FACE)[:-1]
    else:
        steep = np.abs(way[:, 1]) > BACK_FACE*np.hypot(*way.T)
    edges = np.flatnonzero(np.diff(np.r_[False, steep, False].astype(int)))
    runs = [points[a:b + 1] for a, b in zip(edges[::2], edges[1::2], strict=True)]
    run = max(runs, key=lambda run: float(np.ptp(run[:, 1])), default=points[:1])
    if np.ptp(run[:, 1]) < LEAST_BACK or run[:, 0].min() > points[:tip + 1, 0].min() + 1:
        return None
    # The median of three neighbours keeps a clean face, and takes a good part of the noise.
    y = np.r_[run[0, 0], run[:, 0], run[-1, 0]]
    return float(np.median([y[:-2], y[1:-1], y[2:]], axis=0).min())


def _running_surface(points: np.ndarray) -> tuple[float, int, int]:
    """Height of the flange at the tape circle [mm], and first and last point of a wheel that can be running surface: neither the
    back above the level of the tread nor the rim face."""
    tip = int(points[:, 1].argmin())
    tape = min(len(points) - 1, tip + int((points[tip:, 0] < MM*TAPE_CIRCLE).argmin() or len(points)))
    above = np.flatnonzero(points[:tip + 1, 1] > points[tape, 1])
    _, angle = _directions(points, CHORD/2)
    # Points that go back have another direction than a face.
    rim = np.flatnonzero(np.sin(angle[tape:]) > FACE)
    height = float(points[tape, 1] - points[tip, 1])
    return height, int(above[-1]) if len(above) else 0, tape + int(rim[0]) if len(rim) else len(points) - 1


def _head(points: np.ndarray) -> tuple[int, int]:
    """First and last point of a rail down to where the sides of its head end: 0.5 mm inside them, 10 mm or more below the top, or
    60 mm below it."""
    y, z = points.T
    top = int(z.argmax())
    ends = []
    for side, way in (-1, np.arange(top, -1, -1)), (1, np.arange(top, len(z))):
        inside = side*y[way] - np.maximum.accumulate(side*y[way])
        below = ((inside < -0.5) & (z[way] < z[top] - 10)) | (z[way] < z[top] - DEEPEST)
        if not below.any():
            ends.append(int(way[-1]))
        else:       # the last point within 0.02 mm of the outermost so far
            ends.append(int(way[np.flatnonzero(inside[:below.argmax() + 1] > -SAME_SIDE)[-1]]))
    return ends[0], ends[1]


def _hidden(points: np.ndarray, first: int) -> float:
    """Depth below the top to which the gauge side of a rail goes on behind its first point [mm]: down to where the points that
    are left out come before it again, are missing, or end. 0 where the side ends deeper than any gauge is measured."""
    y, z = points[:first + 1].T[:, ::-1]
    top = points[:, 1].max()
    if not first or top - z[0] > DEEPEST_GAUGE:
        return 0.0
    ends = np.flatnonzero((y[1:] < y[0] - SAME_SIDE) | (np.hypot(np.diff(y), np.diff(z)) > GAP))
    return float(top - z[:ends[0] + 1 if len(ends) else len(z)].min())
