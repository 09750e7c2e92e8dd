"""Write the reconstructed wheel and rail profiles of the benchmark, and the pair S1002 on 60E1.

    python make_profiles.py [--out DIR]

Every profile is a tangent-continuous chain of arcs and straight lines in the
plane (y, z), mm, z up.  The angle g is that of the tangent to the y axis when
the chain is walked towards +y; the normal is n = (-sin g, cos g).  An arc is
the set of points c + R n(g): R > 0 curves downwards (rail head, wheel throat),
R < 0 upwards (flange tip).  On the left wheel and the left rail y points to the
field side, so flange contact has g > 0.

The arcs of the benchmark's profiles are assumptions (see README.md).  The one free length of each wheel,
the y at which the throat leaves the tread line, follows from the rigid-axle
clearance the call publishes.

The spacing of the points was chosen with rigid contacts, which feel every kink: against points every 0.0125 mm, the return time
of exercises 1 to 4 moves by 5e-5 at most, and by 4e-3 with points every 0.25 mm alone.
"""
import argparse
from dataclasses import dataclass
from itertools import pairwise
from math import asin, atan, ceil, cos, degrees, inf, pi, radians, sin, sqrt, tan
from pathlib import Path

import numpy as np

# What the call publishes, mm
WHEEL_BACK = 1352.14 / 2        # wheel back, from the track centreline
GAUGE_POINT = 1435.1 / 2        # gauge point of the rail, from the track centreline
GAUGE_DEPTH = 14.0              # depth below top of rail at which gauge is measured
ROLLING_RADIUS = 457.0          # at the contact point of the centred wheelset
CLEARANCES = {"aw": 10.18, "sw": 16.94}     # of one side of the centred wheelset, published
TAPER = CANT = atan(1 / 40)
FLANGE_ANGLE = radians(25)     # least contact angle of a flange contact, as &contact flange_angle

STEP = 0.25                     # spacing of the points along the profile, at most
FINE, GROWTH = 0.05, 1.3        # spacing at the ends of arcs and lines, where curvature jumps, and its growth from there
WHEEL_WIDTH = 135.0
RAIL_BOTTOM = -40.0


# ---- chains of arcs and lines --------------------------------------------------------
@dataclass
class Piece:
    """Arc (R finite, centre c) or line (R infinite, start p) from angle g0 to g1."""
    R: float
    g0: float
    g1: float
    p: np.ndarray               # first point
    length: float

    @property
    def c(self):
        return self.p - self.R * normal(self.g0)

    def at(self, s):
        """Point at arc length s from the start of the piece."""
        if self.R == inf:
            return self.p + s * np.array([cos(self.g0), sin(self.g0)])
        return self.c + self.R * normal(self.g0 - s / self.R)

    @property
    def end(self):
        return self.at(self.length)


def normal(g):
    return np.array([-sin(g), cos(g)])


def arc(R, g0, g1):
    return R, g0, g1, abs(R * (g1 - g0))


def line(g, length):
    return inf, g, g, length


def chain(start, *parts):
    """Join arcs and lines end to end; each must start with the angle the last one ended with."""
    pieces = []
    for R, g0, g1, length in parts:
        assert not pieces or abs(pieces[-1].g1 - g0) < 1e-12, "tangent jumps"
        pieces.append(Piece(R, g0, g1, pieces[-1].end if pieces else np.array(start, float), length))
    return pieces


def shift(pieces, dy, dz):
    return [Piece(q.R, q.g0, q.g1, q.p + (dy, dz), q.length) for q in pieces]


def sample(pieces, spacing=STEP):
    points = [pieces[0].p]
    for q in pieces:
        n = max(1, round(q.length / spacing))
        points += [q.at(q.length * i / n) for i in range(1, n + 1)]
    return np.array(points)


def graded(pieces):
    """Points for a file: a spline through them has its jumps of curvature where the pieces have them."""
    points = [pieces[0].p]
    for q in pieces:
        steps = np.minimum(FINE * GROWTH ** np.arange(ceil(q.length / FINE)), STEP)
        half = np.concatenate([[0], np.cumsum(steps)])
        half = half[half < q.length / 2 - steps[0]]
        n = max(1, round((q.length / 2 - half[-1]) / STEP))
        half = np.concatenate([half, half[-1] + (q.length / 2 - half[-1]) * np.arange(1, n + 1) / n])
        points += [q.at(s) for s in [*half[1:], *(q.length - half[-2::-1])]]
    return np.array(points)


# ---- the four profiles ---------------------------------------------------------------
def rail(head):
    """Rail from its list of head arcs: vertical gauge side, top at z = 0, gauge point at y = 0."""
    arcs = chain((0, 0), *head)
    crown_top = next(q for q in arcs if q.g0 >= 0 >= q.g1)          # where the tangent is level
    arcs = shift(arcs, 0, -(crown_top.c[1] + crown_top.R))
    corner, (y, z) = arcs[0], arcs[0].p
    if z > -GAUGE_DEPTH:                                            # gauge point on the straight side
        gauge_y = y
    else:                                                           # still on the corner arc
        gauge_y = corner.c[0] - sqrt(corner.R**2 - (-GAUGE_DEPTH - corner.c[1])**2)
    arcs = shift(arcs, -gauge_y, 0)
    gauge_side = (arcs[0].p[1] - RAIL_BOTTOM) / sin(arcs[0].g0)
    field_side = (arcs[-1].end[1] - RAIL_BOTTOM) / -sin(arcs[-1].g1)
    parts = [line(arcs[0].g0, gauge_side), *head, line(arcs[-1].g1, field_side)]
    return chain((arcs[0].p[0] - gauge_side * cos(arcs[0].g0), RAIL_BOTTOM), *parts)


def arprof():
    a1 = asin(16.5 / 254)                       # edge of the crown, about the rail's own axis
    a2, a3 = radians(30), pi / 2 - CANT         # edge of the shoulder; 1:40 side
    head = [(14.2875, a3, a2), (31.75, a2, a1), (254, a1, -a1), (31.75, -a1, -a2), (14.2875, -a2, -a3)]
    return rail([arc(R, g0 + CANT, g1 + CANT) for R, g0, g1 in head])


def srprof():
    a = asin(24 / 300)
    return rail([arc(12, pi / 2, a + CANT), arc(300, a + CANT, -a + CANT), arc(12, -a + CANT, -pi / 2)])


def wheel(throat_y, datum_y, *flange):
    """Wheel from its flange pieces, lowest point to tread; the tread line has z = 0 at datum_y."""
    low_y = throat_y - chain((0, 0), *flange)[-1].end[0]
    tread = line(TAPER, (WHEEL_WIDTH - throat_y) / cos(TAPER))
    pieces = chain((0, 0), arc(-low_y, -pi / 2, 0), *flange, tread)
    return shift(pieces, 0, (throat_y - datum_y) / 40 - pieces[-1].p[1])


def awprof(throat_y):
    a, b = radians(75), radians(25)
    return wheel(throat_y, 78, arc(-10, 0, a), line(a, 3.1 / sin(a)), arc(17.4625, a, b), arc(38.1, b, TAPER))


def swprof(throat_y):
    a = radians(70)
    return wheel(throat_y, 76, arc(-10, 0, a), line(a, 6 / sin(a)), arc(18, a, TAPER))


# ---- the pair S1002 and 60E1 -------------------------------------------------------------
# EN 13715, wheel S1002 with flange height 28 mm and thickness 32.5 mm: F(s), towards the flange's tip, over
# s, from the tape circle to the field side; each section from its s down to the next.
S1002_POLYNOMIALS = {
    "A": (60.0, (1.364323640, -0.066666667)),
    "B": (32.15796, (0.0, -3.358537058e-02, 1.565681624e-03, -2.810427944e-05, 5.844240864e-08, -1.562379023e-08,
                     5.309217349e-15, -5.957839843e-12, 2.646656573e-13)),
    "C": (-26.0, (-4.320221063e+03, -1.038384026e+03, -1.065501873e+02, -6.051367875, -2.054332446e-01,
                  -4.169739389e-03, -4.687195829e-05, -2.252755540e-07)),
    "E": (-38.426669071, (-93.576667419, -2.747477419)),
}
S1002_ARCS = {          # centre s, centre F, radius, the side of the centre that it is on
    "D": (-35.0, -26.210665, 16.446, 13.0, -1),
    "F": (-39.764473993, -58.558326413, 8.834924130, 20.0, 1),
    "G": (-49.662510381, -55.0, 16.0, 12.0, 1),
    "H": (-62.764705882, -49.5, 9.519259302, 20.5, 1),
}
S1002_END = -70.0               # the wheel's back
TAPE_CIRCLE = 70.0              # from the wheel's back

# EN 13674-1, rail 60E1: crown, shoulder and corner, with the widths of crown and shoulder; sides 1:20.
CROWN_60E1, SHOULDER_60E1, CORNER_60E1 = 300.0, 80.0, 13.0
CROWN_WIDTH_60E1, SHOULDER_WIDTH_60E1 = 20.456, 52.053
SIDE_60E1 = atan(1 / 20)


def s1002_section(name, s):
    """F of a section at s."""
    if name in S1002_POLYNOMIALS:
        return np.polynomial.polynomial.polyval(s, S1002_POLYNOMIALS[name][1])
    _, centre, level, radius, side = S1002_ARCS[name]
    return level + side * np.sqrt(np.maximum(radius**2 - (s - centre) ** 2, 0))


def s1002():
    """Points of the wheel from its back to the field side, z = 0 on the tape circle."""
    starts = {name: part[0] for name, part in (S1002_POLYNOMIALS | S1002_ARCS).items()}
    names = sorted(starts, key=starts.get)
    points = []
    edges = [S1002_END, *(starts[name] for name in names)]
    for name, (low, high) in zip(names, pairwise(edges), strict=True):
        s = low + (high - low) * (1 - np.cos(np.linspace(0, pi, 20001))) / 2     # dense at both ends
        along = np.concatenate([[0], np.cumsum(np.hypot(np.diff(s), np.diff(s1002_section(name, s))))])
        s = np.interp(np.linspace(0, along[-1], max(1, round(along[-1] / STEP)) + 1), along, s)
        part = np.column_stack([s + TAPE_CIRCLE, -s1002_section(name, s)])
        points += [*part[bool(points):]]
    return np.array(points)


def rail60e1():
    """The rail 60E1, canted 1:40."""
    a1 = asin(CROWN_WIDTH_60E1 / 2 / CROWN_60E1)
    a2 = asin(sin(a1) + (SHOULDER_WIDTH_60E1 - CROWN_WIDTH_60E1) / 2 / SHOULDER_60E1)
    a3 = pi / 2 - SIDE_60E1
    head = [(CORNER_60E1, a3, a2), (SHOULDER_60E1, a2, a1), (CROWN_60E1, a1, -a1), (SHOULDER_60E1, -a1, -a2),
            (CORNER_60E1, -a2, -a3)]
    return rail([arc(R, g0 + CANT, g1 + CANT) for R, g0, g1 in head])


# ---- rigid contact of the exact pieces -----------------------------------------------
def touch(wheel, rail, Y, roll):
    """Highest contact of these left wheel pieces (axle centre at lateral Y) on the left rail.

    Returns the height of the axle centre, the contact angle and the contact point.  The common
    normal of two arcs joins their centres, so their lateral distance alone gives the angle.
    """
    turn = np.array([[cos(roll), -sin(roll)], [sin(roll), cos(roll)]])
    best = (-inf, None, None)
    for w in wheel:
        for r in (r for r in rail if r.R != inf):
            if w.R == inf:
                g, (wy, wz) = w.g0 + roll, turn @ w.p + (Y, 0)
                y, z = r.c + r.R * normal(g)
                inside = wy <= y <= wy + w.length * cos(g)
                height = z - wz - tan(g) * (y - wy)
            else:
                wy, wz = turn @ w.c + (Y, 0)
                if 0 < w.R <= r.R or abs(wy - r.c[0]) > abs(w.R - r.R):
                    continue                    # hollow too tight for the rail, or no common normal
                g = asin((wy - r.c[0]) / (w.R - r.R))
                inside = min(w.g0, w.g1) <= g - roll <= max(w.g0, w.g1)
                height = r.c[1] - wz + (r.R - w.R) * cos(g)
            if inside and r.g1 <= g <= r.g0 and height > best[0]:
                best = height, g, r.c + r.R * normal(g)
    return best


def root(f, a, b):
    """Bisection: f(a) < 0 < f(b)."""
    for _ in range(60):
        m = (a + b) / 2
        a, b = (m, b) if f(m) < 0 else (a, m)
    return (a + b) / 2


def on_flange(wheel, rail, Y):
    """Whether the left wheel of a wheelset that moves outwards from the centre is on its flange: positive if so.

    While it rides on both treads, this is how much higher the flange than the tread wants the axle [mm]; afterwards by how much
    the wheel's point of contact is steeper than where the flange begins [rad]."""
    def standing(part):
        return root(lambda p: touch(part, rail, -Y, -p)[0] - touch(part, rail, Y, p)[0], -0.01, 0.01)

    flange, tread, whole = wheel[1:-1], wheel[-1:], wheel[1:]
    roll = standing(tread)
    gap = touch(flange, rail, Y, roll)[0] - touch(tread, rail, Y, roll)[0]
    if gap < 0:
        return gap
    roll = standing(whole)
    return touch(whole, rail, Y, roll)[1] - roll - FLANGE_ANGLE


def solve_throat(make_wheel, rail, clearance):
    """y of the tread/throat junction that gives the rigid-axle clearance, to 1e-6 mm."""
    rail = shift(rail, GAUGE_POINT, 0)

    def gap(throat_y):
        wheel = shift(make_wheel(throat_y), WHEEL_BACK, 0)
        height, _, (_, z) = touch(wheel[-1:], rail, 0, 0)
        return on_flange(shift(wheel, 0, height - z - ROLLING_RADIUS), rail, clearance)

    return round(root(gap, 35, 60), 6)


# ---- the same from the rounded points, as a check ------------------------------------
def dense(p, n=20):
    """A parabola over the chords' length through every three neighbours, n points per interval."""
    a, b, c = p[:-2, None], p[1:-1, None], p[2:, None]
    back, on = (np.linalg.norm(way, axis=2, keepdims=True) for way in (b - a, c - b))
    t = (np.arange(n) / n)[:, None] * (back + on) / 2 - back / 2
    slope = (b - a) / back
    return (b + t * slope + t * (t + back) * ((c - b) / on - slope) / (back + on)).reshape(-1, 2)


def sampled_clearance(wheel, rail, throat_y):
    head = dense(rail[rail[:, 1] > -12]) + (GAUGE_POINT, 0)
    tread, flange = (dense(wheel[m]) + (WHEEL_BACK, 0) for m in (wheel[:, 0] > throat_y, wheel[:, 0] < throat_y))

    def gaps(part, Y, roll):                    # axle heights at which each point touches
        y, z = (part @ np.array([[cos(roll), sin(roll)], [-sin(roll), cos(roll)]])).T
        return np.interp(y + Y, *head.T, left=-inf, right=-inf) - z

    datum = tread[gaps(tread, 0, 0).argmax(), 1] + ROLLING_RADIUS
    for part in (tread, flange):
        part -= (0, datum)

    def gap(Y):
        roll = root(lambda p: gaps(tread, -Y, -p).max() - gaps(tread, Y, p).max(), -0.01, 0.01)
        return gaps(flange, Y, roll).max() - gaps(tread, Y, roll).max()

    return root(gap, 1, 25)


# ---- output --------------------------------------------------------------------------
def write_points(path, points, title, notes, decimals=6, finer=""):
    points = points.round(decimals) + 0.0       # + 0.0 turns -0 into 0
    rows = [f"{path.name}: {title}", *notes[:1],
            f"written by make_profiles.py; {len(points)} points about {STEP} mm apart along the profile{finer}",
            "columns: y z, both in mm, z up, y towards the field side", *notes[1:]]
    text = "".join(f"# {row}\n" for row in rows) + "".join(f"{y:.{decimals}f} {z:.{decimals}f}\n" for y, z in points)
    path.write_bytes(text.encode("ascii"))
    return points


def write(path, pieces, title, notes, origin="RECONSTRUCTION, not the numeric file of the benchmark's organisers; see README.md"):
    rows = [origin, *notes, "pieces (R > 0 curves downwards, angles of the tangent to the y axis):"]
    for q in pieces:
        shape = "line" if q.R == inf else f"R {q.R:.4f}"
        y0, z0, y1, z1 = np.round([*q.p, *q.end], 4) + 0.0
        rows.append(f"  {shape:12s} {degrees(q.g0):9.4f} to {degrees(q.g1):9.4f} deg"
                    f"   from {y0:9.4f} {z0:9.4f}   to {y1:9.4f} {z1:9.4f}")
    return write_points(path, graded(pieces), title, rows, 9, f", {FINE} mm at the ends of pieces")


def main():
    here = Path(__file__).resolve().parent
    parser = argparse.ArgumentParser(description="Write the reconstructed wheel and rail profiles.")
    parser.add_argument("--out", type=Path, default=here, help="folder to write to (default: this script's)")
    out = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)

    for kind, make_rail, make_wheel, datum_y, clearance in (("actual", arprof, awprof, 78, CLEARANCES["aw"]),
                                                            ("simplified", srprof, swprof, 76, CLEARANCES["sw"])):
        rail, name = make_rail(), make_rail.__name__
        points = write(out / f"{name}.yz", rail, f"{kind} rail, left, canted 1:40 towards the track centre",
                       ["y = 0 at the gauge point 14 mm below top of rail, z = 0 at top of rail"])
        gauge_side = points[:points[:, 1].argmax()]
        print(f"{name}: {len(points)} points, top of rail z = {points[:, 1].max():.6f}, "
              f"y at z = -14: {np.interp(-GAUGE_DEPTH, *dense(gauge_side).T[::-1]):.6f}, "
              f"width {np.ptp(points[:, 0]):.3f}")

        throat_y, name = solve_throat(make_wheel, rail, clearance), make_wheel.__name__
        wheel, rail_points = make_wheel(throat_y), points
        points = write(out / f"{name}.yz", wheel, f"{kind} wheel, left, tread 1:40",
                       [f"y = 0 at the wheel back, z = 0 on the tread at y = {datum_y}",
                        f"throat leaves the tread line at y = {throat_y:.6f}, solved for a rigid-axle",
                        f"  clearance of {clearance} mm on {make_rail.__name__} (roll following both treads)"])
        low = points[:, 1].argmin()
        tread = points[points[:, 0] > throat_y]
        print(f"{name}: {len(points)} points, throat at y = {throat_y:.6f}, "
              f"flange height {-points[low, 1]:.3f} (lowest at y = {points[low, 0]:.3f}), "
              f"thickness {np.interp(-10, *dense(points[low:])[:, ::-1].T):.3f} at z = -10, "
              f"taper 1:{1 / np.polyfit(*tread.T, 1)[0]:.4f}")
        print(f"  clearance from the written points {sampled_clearance(points, rail_points, throat_y):.6f}, "
              f"published {clearance}")

    write_points(out / "s1002.yz", s1002(), "wheel S1002, EN 13715, flange 28 mm high and 32.5 mm thick, left",
                 ["from the polynomials and arcs of the standard; see README.md",
                  "y = 0 at the wheel back, z = 0 on the tape circle at y = 70"])
    write(out / "60e1.yz", rail60e1(), "rail 60E1, EN 13674-1, left, canted 1:40 towards the track centre",
          ["y = 0 at the gauge point 14 mm below top of rail, z = 0 at top of rail"],
          "from the arcs of the standard; see README.md")


if __name__ == "__main__":
    main()
