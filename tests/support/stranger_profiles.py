"""Wheels and rails as strangers' files hold them, with what is true of each by construction (numpy only, deterministic).

truth: exact noise-free points, mm, z up, y outward, from the back or gauge side to the field side. Wheel: y = 0 at the back,
z = 0 on the tape circle (y = 70), so the flange has negative z. Rail: y = 0 at the gauge point 14 mm below the top, z = 0 at top.
Row i of the file is row i of truth (row n-1-i where the note says 'reverse'). truth has all points, also those a reader leaves
out (back, rim face, web, foot). noise: rms of what was added normal to the profile; rounding comes on top. Sd, Sh: of the
noise-free curve every 2 um, not of the points of the file. hint wheel_back: y of the back in the file's own y column, mm.
"""
from dataclasses import dataclass, field

import numpy as np

H = 0.002                                   # [mm] spacing of the dense curves; chord error below 3e-7 mm at R = 2 mm

@dataclass
class Specimen:
    """A file of a stranger and what is true of it."""
    name: str
    data: bytes
    kind: str
    format: str
    noise: float
    truth: np.ndarray
    Sd: float
    Sh: float
    corner: bool
    hint: dict = field(default_factory=dict)
    doubt: bool = False
    note: str = ""

@dataclass
class Broken:
    """A file that must be refused or clearly told, and the kind as which a user names it."""
    name: str
    data: bytes
    why: str
    kind: str

class Curve:
    """A dense polyline p with the indices k of its junctions and corners, travelled from back or gauge side to the field side."""
    def __init__(self, p, k=()):
        self.p, self.k = np.asarray(p, float), np.unique(np.asarray(list(k), int))
    def s(self):
        """Arc length."""
        return np.concatenate([[0], np.cumsum(np.hypot(*np.diff(self.p, axis=0).T))])
    def normal(self):
        """Unit normals to the left of the way: into a wheel, out of a rail."""
        t = np.gradient(self.p, axis=0)
        return np.column_stack([-t[:, 1], t[:, 0]]) / np.hypot(*t.T)[:, None]
    def then(self, q):
        """With the points or the curve q (which starts beyond the end) appended; the joint is a junction."""
        p, k = (q.p, q.k) if isinstance(q, Curve) else (q, np.zeros(0, int))
        return Curve(np.vstack([self.p, p]), [*self.k, len(self.p) - 1, *(len(self.p) + k)])
    def displaced(self, d):
        """Displaced by d along the left normal."""
        return Curve(self.p + self.normal() * np.asarray(d)[:, None], self.k)
    def near(self, y, after=0.0):
        """Index of the point nearest to y beyond the fraction `after` of the points."""
        i = int(after * len(self.p))
        return i + int(np.argmin(np.abs(self.p[i:, 0] - y)))

def path(start, *pieces):
    """Curve of lines ('L', length, angle) and arcs ('A', R, angle from, angle to), angles of the heading in degrees from +y."""
    out, k = [np.array([start], float)], []
    for piece in pieces:
        p = out[-1][-1]
        if piece[0] == "L":
            a, n = np.radians(piece[2]), max(2, int(np.ceil(piece[1] / H)))
            q = p + np.linspace(0, piece[1], n + 1)[1:, None] * [np.cos(a), np.sin(a)]
        else:
            _, r, a0, a1 = piece
            n = max(2, int(np.ceil(r * abs(np.radians(a1 - a0)) / H)))
            a, r = np.radians(np.linspace(a0, a1, n + 1)), r if a1 > a0 else -r
            q = (p + r * (np.column_stack([np.sin(a), -np.cos(a)]) - [np.sin(a[0]), -np.cos(a[0])]))[1:]
        k.append(sum(map(len, out)) - 1)
        out.append(q)
    return Curve(np.vstack(out), k[1:])

def poly(vertices):
    """Curve through the vertices (y, z, radius); radius 0 is a sharp corner. The first and the last vertex are ends."""
    v = np.array([(*a, 0.0)[:3] for a in vertices], float)
    at, pieces = v[0, :2], []
    for i in range(1, len(v)):
        d = v[i, :2] - v[i - 1, :2]
        e = v[i + 1, :2] - v[i, :2] if i < len(v) - 1 else d
        a, turn = np.degrees(np.arctan2(d[1], d[0])), np.degrees(np.arctan2(d[0] * e[1] - d[1] * e[0], d @ e))
        cut = v[i, 2] * np.tan(np.radians(abs(turn)) / 2)
        pieces.append(("L", np.hypot(*(v[i, :2] - cut * d / np.hypot(*d) - at)), a))
        at = v[i, :2] + cut * e / np.hypot(*e)
        if cut:
            pieces.append(("A", v[i, 2], a, a + turn))
    return path(v[0, :2], *pieces)

def cross(y, level, i):
    """Position between the points where y first reaches the level from point i on: index and fraction."""
    j = i + int(np.flatnonzero((y[i:-1] - level) * (y[i + 1:] - level) <= 0)[0])
    return j, (level - y[j]) / (y[j + 1] - y[j])

def measures(p):
    """Sd, Sh and the height of the tape circle of a wheel whose back is at y = 0."""
    tip = int(np.argmin(p[:, 1]))
    j, f = cross(p[:, 0], 70.0, tip)
    z70 = p[j, 1] + f * (p[j + 1, 1] - p[j, 1])
    j, f = cross(p[:, 1], z70 - 10.0, tip)
    return p[j, 0] + f * (p[j + 1, 0] - p[j, 0]), z70 - p[tip, 1], z70

def framed(c, kind):
    """The curve in the frame of truth."""
    if kind == "wheel":
        return Curve(c.p - [0, measures(c.p)[2]], c.k)
    p = c.p - [0, c.p[:, 1].max()]
    g = p[int(np.argmax(p[:, 1]))::-1]
    j, f = cross(g[:, 1], -14.0, 0)
    return Curve(p - [g[j, 0] + f * (g[j + 1, 0] - g[j, 0]), 0], c.k)

def s1002():
    """S1002 (EN 13715, UIC 510-2): arcs and polynomials of the standard, from the back to y = 130 mm."""
    a, b, d = np.degrees(np.arcsin([-13.264705882 / 20.5, 5.337489619 / 12, 8.789335 / 13]))
    c = path((-70, -9.519259302), ("A", 20.5, -90, a), ("A", 12, a, b), ("A", 20, b, 70.0),
             ("L", np.hypot(1, 2.747477419) * (39.764473993 - 38.426669071), 70.0), ("A", 13, 70.0, d))
    y = np.arange(-35 + H, 60 + H / 2, H)
    pb = [0, -3.358537058e-2, 1.565681624e-3, -2.810427944e-5, 5.844240864e-8, -1.562379023e-8, 5.309217349e-15,
          -5.957839843e-12, 2.646656573e-13]             # of the standard, from the tape circle
    pc = [-4.320221063e3, -1.038384026e3, -1.065501873e2, -6.051367875, -2.054332446e-1, -4.169739389e-3, -4.687195829e-5,
          -2.252755540e-7]
    z = np.where(y < -26, np.polyval(pc[::-1], y), np.where(y > 32.15796, 1.364323640 - 0.066666667 * y, np.polyval(pb[::-1], y)))
    c = c.then(np.column_stack([y, -z]))
    return Curve(c.p + [70, 0], [*c.k, len(c.p) - len(y) + 4500, len(c.p) - len(y) + 33579])

def wheel(Sh, Sd, face, arcs, tread, width=130.0, tip=(16.0, 11.0), back=0.0):
    """A wheel of arcs: tip radii, a flank of `face` degrees, arcs (R, angle at the end) to the tread of angle `tread` and the rim
    at `width`. The length of the flank and the crest are solved for Sh and Sd."""
    def build(x):
        c = path((0, 0), ("A", tip[0], -90, 0), ("L", x[0], 0), ("A", tip[1], 0, face), ("L", x[1], face),
                 *(("A", r, a, b) for (r, b), a in zip(arcs, [face, *(b for _, b in arcs)], strict=False)))
        more = (width - c.p[-1, 0]) / np.cos(np.radians(tread))
        t = c.then(path(c.p[-1], ("L", more, tread)).p[1:])
        return t if not back else Curve(np.vstack([path((0, back), ("L", back, -90)).p, t.p[1:]]),
                                        [int(np.ceil(back / H)), *(t.k + int(np.ceil(back / H)))])
    x = np.array([3.0, 6.0])
    for _ in range(8):
        f = [np.array(measures(build(x + e).p)[:2]) for e in ((0, 0), (0.1, 0), (0, 0.1))]
        x = x - np.linalg.solve(np.column_stack([f[1] - f[0], f[2] - f[0]]) / 0.1, f[0] - [Sd, Sh])
    assert x.min() >= 0, x
    return build(x)

SL = {n: float(np.degrees(np.arctan(1 / n))) for n in (8, 20, 40)}         # angles of treads 1:n
def cone(n, back=0.0):
    """A conical wheel 1:n."""
    return wheel(28, 32.5, 70, [(14, 12), (60, SL[n])], SL[n], back=back)

def aar(back=0.0):
    """AAR-1B wide flange: 75 degrees, 11/16 in, 1 1/2 in, tread 1:20, 5 23/32 in wide."""
    return wheel(25.4, 33.3, 75, [(17.4625, 25), (38.1, SL[20])], SL[20], 145.256, (19.05, 9.525), back)

def head(half, radii=(300.0, 80.0, 13.0), flat=10.228, side=20.0, cant=0.0, depth=37.5):
    """A rail head: half width, radii from the crown to the corner, half width of the crown, side 1:side (0: upright), cant 1:n."""
    lean = 90 - (np.degrees(np.arctan(1 / side)) if side else 0)                            # angle of the side
    b, sl = np.degrees(np.arcsin(flat / radii[0])), np.sin(np.radians(lean))
    a = np.degrees(np.arcsin((half - radii[2] * sl - flat + radii[1] * flat / radii[0]) / (radii[1] - radii[2])))
    assert b < a < lean, (b, a)
    arcs = [(radii[2], lean, a), (radii[1], a, b), (radii[0], b, -b), (radii[1], -b, -a), (radii[2], -a, -lean)]
    drop = sum(r * (np.cos(np.radians(y)) - np.cos(np.radians(x))) for r, x, y in arcs[:2]) + radii[0] * (1 - np.cos(np.radians(b)))
    line = (depth - drop) / sl
    c = path((0, 0), ("L", line, lean), *(("A", *x) for x in arcs), ("L", line, -lean))
    c = Curve(c.p - [(c.p[0, 0] + c.p[-1, 0]) / 2, c.p[:, 1].max()], c.k)
    return Curve(c.p @ np.array([[cant, 1], [-1, cant]]) / np.hypot(1, cant), c.k) if cant else c

def section(c, height, foot, web, ends=8):
    """Web and foot below an upright head: closed from the middle of the sole, or without the sole (ends = 7)."""
    y, z = c.p[-1]
    right = poly([(y, z), (y + .2, z - 3, 3), (web, z - 3 - (y - web) / 2.75, 12), (web, -height + 27, 30),
                  (foot - 2, -height + 12, 2), (foot, -height + 9.5, 1), (foot, -height, 2), (0, -height)][:ends])
    left = Curve(right.p[::-1] * [-1, 1], len(right.p) - 1 - right.k)
    return Curve(left.p[:-1], left.k).then(c).then(Curve(right.p[1:], right.k - 1))

def dip(c, y0, y1, depth, after=0.0):
    """Worn by a smooth dip between the ordinates of the curve; depth along the left normal (negative for a rail)."""
    s = c.s()
    a, b = s[c.near(y0, after)], s[c.near(y1, after)]
    return c.displaced(depth * np.sin(np.pi * np.clip((s - a) / (b - a), 0, 1)) ** 2)

def waved(c, length=6.0, height=0.010):
    """Waves as real geometry, height from bottom to crest."""
    return c.displaced(height / 2 * np.sin(2 * np.pi * c.s() / length))

def facet(c, y0, y1, after=0.3):
    """A flat chord between two ordinates."""
    i, j = c.near(y0, after), c.near(y1, after)
    p = c.p.copy()
    p[i:j + 1] = p[i] + np.linspace(0, 1, j - i + 1)[:, None] * (p[j] - p[i])
    return Curve(p, [*c.k, i, j])

def stepped(c, y, h):
    """An upright step of h at y."""
    i = c.near(y, 0.3)
    return Curve(np.vstack([c.p[:i + 1], c.p[i] + [0, h], c.p[i + 1:] + [0, h]]), [*c.k[c.k < i], i, i + 1, *(c.k[c.k > i] + 1)])

def spot(c, y, width):
    """A spot of the width, level with the axle, cut into the tread."""
    i, j = c.near(y, 0.3), c.near(y + width, 0.3)
    level = np.column_stack([c.p[i:j, 0], np.full(j - i, c.p[j, 1])])
    return Curve(np.vstack([c.p[:i + 1], level, c.p[j:]]), [*c.k[c.k < i], i, i + 1, j + 1, *(c.k[c.k > j] + 1)])

def rim(c, *vertices):
    """Rim of vertices (dy, dz, radius) relative to the end of the tread."""
    q = poly([(*c.p[-1], 0.0), *((c.p[-1, 0] + v[0], c.p[-1, 1] + v[1], *v[2:]) for v in vertices)])
    return c.then(Curve(q.p[1:], q.k - 1))

def plain(sep=" ", dec=".", head="", eol="\n", bom=False, index=False, quote=False):
    """Writer of plain columns."""
    def write(rows, _):
        q = '"' * quote
        out = [sep.join(q + v.replace(".", dec) + q for v in [str(i)] * index + r) for i, r in enumerate(rows, 1)]
        return b"\xef\xbb\xbf" * bom + "".join(x + eol for x in [head] * bool(head) + out).encode()
    return write

def miniprof(columns="X,Y", xoff=0.0, yoff=0.0, what="Wheel"):
    """Writer of MiniProf."""
    def write(rows, xy):
        out = ["ProgramName=MiniProf BT", "ProgramVer=3.2.7", "Date=12-05-2021", f"ProfileType={what}", f"XYPoints={len(rows)}",
               f"ColumnDef={columns}", f"XOffset={xoff:.4f}", f"YOffset={yoff:.4f}", "Tilt=0.0000", ""]
        t = np.gradient(xy, axis=0)
        a = np.unwrap(np.arctan2(t[:, 1], t[:, 0]))
        k = np.gradient(a) / np.maximum(np.hypot(*t.T), 1e-9)
        for i, row in enumerate(rows):
            out.append("\t".join([*row, f"{a[i]:.6f}", f"{k[i]:.6f}", str(i + 1)] if "A" in columns else row))
        return "".join(x + "\r\n" for x in out).encode()
    return write

def simpack(kind, factor=1000.0, **more):
    """Writer of SIMPACK; more: shift_y etc."""
    def write(rows, _):
        out = ["header.begin", "  version  = 1", f"  type     = {int(kind == 'wheel')}", "header.end", "spline.begin",
               "  approx.smooth = 0.000000", "  comment       = 'as delivered'", f"  units.len.f   = {factor:g}.",
               "  units.ang.f   = 1.", *(f"  {k.replace('_', '.')} = {v}" for k, v in more.items()), "  point.begin",
               *("    " + "  ".join([*r, "1.0"]) for r in rows), "  point.end", "spline.end"]
        return "".join(x + "\n" for x in out).encode()
    return write

SPECIMENS: list[Specimen] = []
FILE_CHECK: dict = {}                       # name: rms distance [mm] of the numbers as written from truth, for the table

def add(name, kind, c, step=0.25, noise=0.0, digits=4, y0=0.0, z0=0.0, sy=1, sz=1, unit=1.0, write=None, corner=False, hint=None,
        doubt=False, note="", reverse=False, mode="s", keep=None):
    """Sample the curve, add noise, write and keep it: file y = sy (y - y0) / unit, file z = sz (z - z0) / unit."""
    c, rng = framed(c, kind), np.random.default_rng(7000 + len(SPECIMENS))
    s, Sd, Sh = c.s(), *(measures(c.p)[:2] if kind == "wheel" else (np.nan, np.nan))
    y0 = (c.p[0, 0] + c.p[-1, 0]) / 2 if y0 == "mid" else y0
    if mode == "y":
        at = np.interp(np.arange(np.ceil(c.p[0, 0] / step) * step, c.p[-1, 0] + 1e-9, step), c.p[:, 0], s)
    else:
        at = np.linspace(0, s[-1], round(s[-1] / step) + 1)
        if noise:
            at[1:-1] += rng.uniform(-.25, .25, len(at) - 2) * step
    if mode == "k":                         # 5 um apart on either side of every junction
        at = np.concatenate([at, *(x + np.arange(-20, 21) * 0.005 for x in s[c.k])])
        at = np.unique(at.round(6))
        at = at[(at >= 0) & (at <= s[-1]) & (np.diff(at, prepend=-1) > 0.004)]
    elif corner and not noise:              # whoever computes corners writes them
        at = at[np.min(np.abs(at[:, None] - s[c.k]), axis=1) > 0.2 * step] if len(c.k) else at
        at = np.unique(np.concatenate([at, s[c.k]]))
    truth = np.column_stack([np.interp(at, s, x) for x in c.p.T])
    if keep:
        truth, at = (x[(truth[:, 0] >= keep[0]) & (truth[:, 0] <= keep[1])] for x in (truth, at))
    normal = np.column_stack([np.interp(at, s, x) for x in c.normal().T])
    e = rng.normal(0, 1, len(at))
    xy = truth + normal / np.hypot(*normal.T)[:, None] * (noise * e / np.sqrt(np.mean(e ** 2)))[:, None]
    xy = (xy - [y0, z0]) * [sy, sz] / unit
    xy = xy[::-1] if reverse else xy
    rows = [[f"{v:.{digits}f}" for v in r] for r in xy]
    back = np.array(rows, float) * unit * [sy, sz] + [y0, z0]
    FILE_CHECK[name] = float(np.sqrt(np.mean(np.sum(((back[::-1] if reverse else back) - truth) ** 2, axis=1))))
    assert abs(FILE_CHECK[name] ** 2 - noise ** 2) < 0.05 * noise ** 2 + (unit * 10.0 ** -digits) ** 2 / 4 + 1e-12, name
    form = {"txt": "plain", "csv": "plain", "dat": "plain", "prw": "SIMPACK", "prr": "SIMPACK"}.get(name[-3:], "MiniProf")
    SPECIMENS.append(Specimen(name, (write or plain())(rows, xy), kind, form, noise, truth, Sd, Sh, corner, hint or {}, doubt,
                              note + ", reverse" * reverse))

def build():
    """Make all specimens."""
    s, W, R, P, M, S = s1002(), "wheel", "rail", plain, miniprof, simpack
    lm = wheel(27, 32, 70, [(14, 12), (100, 5.5), (500, 1.5), (220, SL[8])], SL[8])         # China, TB/T 449, as far as known
    p8 = wheel(30, 29, 68, [(13, 20), (40, 8), (100, SL[20])], SL[20], 127, (14, 10))       # in the manner of the British P8
    gv40 = wheel(28.5, 32.5, 70, [(13, 15), (40, 6), (150, SL[40])], SL[40], 135)           # in the manner of the French GV 1/40
    add("s1002_exact.txt", W, s, digits=6, note="S1002 as computed")
    add("s1002_down.txt", W, s, 0.5, sz=-1, write=P("   "), note="z down")
    add("s1002_2digits.txt", W, s, 0.5, digits=2, write=P("\t"), note="two digits")
    add("s1002_fine.txt", W, s, 0.05, 0.030, 3, write=P(eol="\r\n"), note="dense and noisy, CRLF")
    add("s1002_m.txt", W, s, 0.2, 0.003, 6, unit=1000, write=P("\t", head="y (m)\tz (m)"), note="metres, unit in the header")
    add("s1002_xy.whl", W, s, 0.2, 0.003, sz=-1, write=M(), note="flange up")
    add("s1002_acn.whl", W, s, 0.25, 0.001, y0=63.25, z0=-11.5, sz=-1, write=M("X,Y,A,C,N", 63.25, 11.5), note="offsets to add")
    add("s1002.prw", W, s, 0.3, y0=70, sz=-1, digits=6, reverse=True, write=S(W), note="tape circle, z down")
    add("s1002_shift.prw", W, s, 0.3, digits=6, write=S(W, shift_y="-70.0", mirror_z=1), note="shift.y to tape circle, mirror.z")
    add("s1002_si.prw", W, s, 0.4, 0, 6, 70, sz=-1, unit=1000, write=S(W, 1.0), note="tape circle, z down, units.len.f = 1: m")
    add("s1002_right.txt", W, s, 0.25, 0.001, sy=-1, reverse=True, note="right-hand wheel: y inward")
    add("s1002_kpf.dat", W, s, 0.1, 0, 5, 70, 0, -1, -1, reverse=True, mode="y", write=P("   ", head="# field side first"),
        note="GENSYS: tape circle, y to the track centre, z down, equal steps of y")
    add("s1002_first.txt", W, s, 0.25, 0.003, y0=-64.5, z0=5, keep=(5.4, 131), hint={"wheel_back": 64.5}, note="cut, back unseen")
    add("s1002_cut.txt", W, s, 0.3, 0.001, y0=64.5, keep=(3.0, 131), hint={"wheel_back": -64.5}, note="cut, back unseen, own mark")
    add("s1002_unknown.txt", W, s, 0.3, 0.001, y0=7.3, keep=(7.3, 126), doubt=True, note="cut, y = 0 at first point: unknowable")
    add("s1002_worn.whl", W, dip(s, 22, 48, 2.0, 0.15), 0.2, 0.010, sz=-1, write=M(), note="flank and throat worn by 2 mm")
    add("s1002_waves.whl", W, waved(s), 0.15, 0.003, sz=-1, write=M(), note="waves 6 mm, 10 um are real")
    add("s1002_facet.txt", W, facet(s, 40.0, 48.0, 0.2), 0.2, 0.001, 4, corner=True, note="facet in the throat, y = 40 to 48")
    add("lm.csv", W, lm, 0.25, 0.010, 3, write=P(",", head="y [mm],z [mm]"), note="LM, header line")
    add("lm_hollow.txt", W, dip(lm, 45, 105, 2.0), 0.1, 0.030, 3, sz=-1, note="hollow tread, smooth dip of 2 mm, z down")
    add("lm_quoted.csv", W, lm, 0.5, 0.001, 4, write=P(",", head='"y","z"', quote=True), note="quoted numbers")
    add("p8_excel.csv", W, p8, 0.25, 0.003, 3, write=P(";", ",", "y;z", "\r\n", True), note="decimal comma, semicolon, BOM")
    add("p8_tape.txt", W, p8, 1.0, 0, 3, 70, note="tape circle, coarse")
    add("gv40_m.txt", W, gv40, 0.2, 0.010, 6, unit=1000, write=P(", "), note="metres, no word about it")
    add("gv40.mpt", W, gv40, 0.25, 0.003, 3, -12.0, sz=-1, write=M("X,Y", -12.0), note="ending without kind, XOffset, flange up")
    add("gv40_sharp.txt", W, rim(wheel(28, 31, 70, [(13, 15), (40, SL[40])], SL[40], 130, (20, 2)), (3, .075, 2), (3, 25)), 0.1,
        corner=True, note="flange tip and rim edge with R = 2 mm")
    add("aar1b_in.txt", W, aar(), 0.4, 0, 4, unit=25.4, write=P("  ", head="# AAR-1B wide flange, inches"), note="inches")
    add("aar1b_back.txt", W, aar(25), 0.3, 0.001, 4, -250, -460, note="back face measured, origin of a drawing")
    add("cone40_index.txt", W, cone(40), 0.5, 0, 3, write=P("\t", head="No\ty\tz", index=True), note="index column, named")
    add("cone40_bare_index.txt", W, cone(40), 0.5, 0, 3, write=P(" ", index=True), doubt=True, note="index column, not named")
    ch, c = ((5, 5), (5, 30)), cone(20, 40)
    add("cone20_chamfer.txt", W, rim(cone(20), *ch), 2.0, 0, 2, corner=True, note="2 digits, chamfer 45 degrees, rim face")
    add("cone20_full.txt", W, rim(cone(20, 30), *ch), 0.25, 0.003, 4, corner=True, note="back face, chamfer and rim face")
    c = rim(c, (5, 5), (5, c.p[0, 1] - c.p[-1, 1]), (-130, c.p[0, 1] - c.p[-1, 1]))
    add("cone20_closed.csv", W, c, 0.5, 0, 3, write=P(","), corner=True, doubt=True, note="closed")
    add("cone20_lip.txt", W, rim(cone(20), (5.2, .25, .6), (6.06, 2, .5), (5, 4), (5, 30)), .1, .001, corner=True, note="lip")
    add("cone20_step.txt", W, stepped(cone(20), 88.0, 0.1), 0.1, 0, 5, corner=True, note="upright step of 0.1 mm at y = 88")
    add("cone20_step_noise.txt", W, stepped(cone(20), 88.0, 0.1), 0.1, 0.003, 4, corner=True, note="step of 0.1 mm, noise 3 um")
    add("cone20_spot.txt", W, spot(cone(20), 75.0, 2.0), 0.1, 0, 4, corner=True, note="flat spot 2 mm wide, level with the axle")
    add("cone20_5um.txt", W, rim(cone(20), (5, 5), (5, 20)), 0.25, 0, 5, mode="k", corner=True, note="5 um apart at junctions")
    e60, e54, us = {"half": 36.0, "flat": 10.228}, {"half": 35.0, "flat": 10.3}, (37.3, (254.0, 31.75, 14.2875), 18.0, 40)
    u60, c60 = head(**e60), head(**e60, cant=40)
    add("60e1_canted.txt", R, c60, digits=6, note="60E1, cant 1:40")
    add("uic60.prr", R, u60, 0.3, 0, 6, "mid", sz=-1, write=S(R), note="uncanted, symmetrical about 0, z down")
    add("60e1_si.prr", R, head(**e60, cant=20), 0.25, 0, 6, "mid", sz=-1, unit=1000, write=S(R, 1.0), note="cant 1:20, m, z down")
    add("60e1.ban", R, c60, 0.2, 0.003, write=M("X,Y,A,C,N", what="Rail"), note="z up")
    add("60e1_worn.ban", R, dip(c60, -38, -10, -3.5), .2, .01, 4, 5, -2, write=M("X,Y", 5, -2, "Rail"), note="corner worn 3.5 mm")
    add("60e1_waves.txt", R, waved(c60), 0.15, 0.003, note="waves 6 mm, 10 um are real")
    add("60e1_fine.txt", R, head(**e60, cant=40, depth=20), 0.05, 0.030, 3, sz=-1, write=P("\t"), note="dense and noisy, z down")
    add("60e1_ground.txt", R, facet(facet(c60, -33, -27, 0), -27, -18, 0), 0.2, 0, corner=True, note="two facets as ground")
    add("60e1_mm_in_m.txt", R, c60, 1.0, 0, 3, unit=1000, doubt=True, note="metres with three digits: steps of 1 mm")
    add("60e1_closed.csv", R, section(u60, 172, 75, 8.25), 0.5, 0, 3, "mid", -172, write=P(","), corner=True, doubt=True,
        note="closed section, symmetrical about 0, z from the base")
    add("54e1.csv", R, head(**e54), 0.25, 0.010, 3, write=P(";", ",", "Y [mm];Z [mm]"), note="54E1, decimal comma")
    add("54e1_foot.txt", R, section(head(**e54), 159, 70, 8, 7), .4, .001, 4, "mid", corner=True, note="web and foot, about 0")
    add("49e1_gauge.txt", R, head(33.5, cant=20), 0.3, 0.003, 3, z0=-149, note="cant 1:20, y from the gauge point, z from the base")
    add("49e1_right.txt", R, head(33.5, cant=40), 0.25, 0.001, sy=-1, reverse=True, note="right-hand rail: y inward")
    add("136re_in.txt", R, head(*us, depth=33), 0.4, 0, 4, "mid", unit=25.4, write=P(","), note="inches, symmetrical about 0")
    add("136re_coarse.txt", R, head(*us, 40, 33), 2.0, 0, 2, note="2 mm apart, 2 digits, cant 1:40")
    add("bv50.txt", R, head(35.0, side=0, depth=30), 0.25, 0.001, 4, "mid", sz=-1, write=P(head="! BV50"), note="upright sides")
    add("50_r2.txt", R, head(33.0, (300, 60, 2), 20.0, 20, 40, 25), 0.1, 0, 4, corner=True, note="corner radius 2 mm, cant 1:40")

build()
BY_NAME = {x.name: x for x in SPECIMENS}

def broken():
    """Files that must be refused or clearly told."""
    wh, ra = BY_NAME["s1002_exact.txt"].truth, BY_NAME["60e1_canted.txt"].truth
    rng, y, u = np.random.default_rng(99), np.linspace(0, 130, 21), np.linspace(0, 2 * np.pi, 60)
    def tx(p, digits=4, sep=" "):
        return "".join(sep.join(f"{v:.{digits}f}" for v in r) + "\n" for r in p).encode()
    txt, mini, pack = tx(wh), BY_NAME["s1002_xy.whl"].data, BY_NAME["s1002.prw"].data
    loop = np.vstack([wh[:400], wh[400] + 6 * np.column_stack([np.sin(u), 1 - np.cos(u)]), wh[400:]])
    spike, gap = wh.copy(), wh[(wh[:, 0] < 62) | (wh[:, 0] > 84)]
    spike[450:453, 1] -= 9.0
    ang = np.degrees(np.unwrap(np.arctan2(*np.gradient(wh, axis=0).T[::-1])))
    lines = txt.splitlines(keepends=True)
    short = b"".join(lines[:300] + [b" ".join(x.split()[:1]) + b"\n" for x in lines[300:305]] + lines[305:])
    png = b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR\x00\x00\x00\x10\x00\x00\x00\x10\x08\x02" + rng.bytes(900)
    rows = [
        ("lastline.txt", txt + b"615 615\n", "a last line 615 615: the count, not a point", "wheel"),
        ("cm.txt", tx(wh / 10, 5), "centimetres, without a word: 13 units wide", "wheel"),
        ("rail_cm.txt", tx(ra / 10, 5), "centimetres, without a word: 7.5 units wide", "rail"),
        ("flangeless.txt", tx(np.column_stack([y, -0.01 * (y < 30)])), "21 points with a flange of 0.01 mm", "wheel"),
        ("tread_only.txt", tx(wh[wh[:, 0] > 45]), "no flange: the tread from y = 45 on", "wheel"),
        ("truncated.txt", b"".join(lines[:330]) + b"60.1", "ends in the middle of a number and of the profile", "wheel"),
        ("truncated.whl", mini[:len(mini) * 2 // 3], "MiniProf cut off: fewer points than XYPoints", "wheel"),
        ("truncated.prw", pack[:len(pack) // 2], "SIMPACK cut off: no point.end, half a wheel", "wheel"),
        ("two_wheels.txt", txt + b"\n" + tx(wh + [0, 0.4]), "two profiles in one file", "wheel"),
        ("left_right.txt", txt + tx(wh[::-1] * [-1, 1] + [1500, 0]), "both wheels of a wheelset in one file", "wheel"),
        ("letters.txt", txt.replace(b"70.", b"7O."), "letter O for nought", "wheel"),
        ("nan.txt", b"".join(lines[:200]) + b"nan nan\n" + b"".join(lines[200:]), "NaN among the points", "wheel"),
        ("inf.txt", b"".join(lines[:200]) + b"1e999 0.0\n" + b"".join(lines[200:]), "an infinite number", "wheel"),
        ("header.whl", mini[:mini.index(b"\r\n\r\n") + 4], "only a header", "wheel"),
        ("wheel_named.ban", mini, "a wheel named as a rail", "rail"),
        ("wheel_named.prr", pack, "a wheel in a file of a rail (type = 1 within)", "rail"),
        ("rail_named.whl", tx(ra), "a rail named as a wheel", "wheel"),
        ("loop.txt", tx(loop), "the curve crosses itself", "wheel"),
        ("picture.txt", png, "an image", "wheel"),
        ("page.txt", b"<!DOCTYPE html><html><body><h1>404 Not Found</h1><p>12 34 56 78</p></body></html>\n", "a web page", "rail"),
        ("book.csv", b"PK\x03\x04\x14\x00\x06\x00\x08\x00" + rng.bytes(1200), "a spreadsheet (zip) named csv", "rail"),
        ("empty.txt", b"", "an empty file", "wheel"),
        ("swapped.txt", tx(wh[:, ::-1]), "columns swapped: z y", "wheel"),
        ("rail_swapped.txt", tx(ra[:, ::-1]), "columns swapped: z y", "rail"),
        ("angles.txt", tx(np.column_stack([wh[:, 0], ang])), "angles [deg] in place of z", "wheel"),
        ("three.txt", b"0 -28\n30 -10\n130 3\n", "three points", "wheel"),
        ("same.txt", b"70.0 0.0\n" * 300, "all points alike", "wheel"),
        ("one_column.txt", tx(wh[:, 1:]), "one column", "wheel"),
        ("shuffled.txt", tx(rng.permutation(wh)), "points in random order", "wheel"),
        ("short_lines.txt", short, "five lines in the middle have lost their second number", "wheel"),
        ("spike.txt", tx(spike), "three points 9 mm off the tread", "wheel"),
        ("gap.txt", tx(gap), "22 mm without a point around the tape circle", "wheel"),
        ("whole_mm.txt", tx(wh, 0), "rounded to whole millimetres", "wheel"),
        ("comma_comma.csv", tx(wh, 2, ",").replace(b".", b","), "decimal comma and comma between: y,yy,z,zz", "wheel"),
        ("rotated.prw", pack.replace(b"  point.begin", b"  rotate = 0.025\n  point.begin"), "rotate is not 0", "wheel"),
        ("unit_lie.txt", b"y [mm] z [mm]\n" + tx(wh / 1000, 6), "header says mm, numbers are metres", "wheel"),
        ("half_head.txt", tx(ra[ra[:, 0] > 36]), "only the field half of a rail head", "rail"),
        ("crown_only.txt", tx(ra[ra[:, 1] > -3]), "only the crown: nothing 14 mm below the top", "rail"),
        ("flat_rail.txt", tx(np.column_stack([np.linspace(0, 72, 200), np.zeros(200)])), "a straight line as a rail", "rail"),
    ]
    return [Broken(*r) for r in rows]

BROKEN = broken()

if __name__ == "__main__":
    print(f"{'name':24}{'kind':6} {'format':11}{'n':>6}{'Sd':>9}{'Sh':>9}{'noise um':>9}{'file um':>9} corner doubt hint | note")
    for x in SPECIMENS:
        assert x.data.count(b"\n") >= len(x.truth) and np.isfinite(x.truth).all() and x.name.isprintable()
        if x.kind == "wheel" and x.truth[-1, 0] > 100:          # points against the dense curve: sagitta of the spacing
            gap = np.percentile(np.hypot(*np.diff(x.truth, axis=0).T), 95)
            assert np.abs(np.subtract(measures(x.truth)[:2], (x.Sd, x.Sh))).max() < gap ** 2 / 12 + 1e-5, x.name
        print(f"{x.name:24}{x.kind:6} {x.format:11}{len(x.truth):6}{x.Sd:9.4f}{x.Sh:9.4f}{1000 * x.noise:9.0f}"
              f"{1000 * FILE_CHECK[x.name]:9.2f} {'corner' * x.corner:6} {'doubt' * x.doubt:5} {x.hint or '':} | {x.note}")
    print(f"{len(SPECIMENS)} specimens, {sum(x.kind == 'wheel' for x in SPECIMENS)} wheels, {len(BROKEN)} broken")
