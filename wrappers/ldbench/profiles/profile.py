"""A wheel's or a rail's profile: read from any file, placed, mended, smoothed, and written as the core reads it."""
from __future__ import annotations

import atexit
import functools
import os
import shutil
import tempfile
import zlib
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from .._core import flat
from .._core.calls import kept_folder, path_bytes
from .._core.errors import OWN_NAMES, Error
from .._core.files import DEFAULT_FOLDER, complete, make_results_folder
from ..case import find_file
from ..constants import DEG, MM
from ..number_text import slope_words
from .formats import HIDDEN, REMARK, SCALE, of_array, read_file
from .measures import Stations, rail_remarks, survey, waviness
from .placing import place
from .repair import check as check_curve, mend, turns_of
from .smoothing import FAR, Smoothed, chord_lengths, smooth

FOLDER = Path(DEFAULT_FOLDER, "profiles")       # of curves that a case takes from an object
KINDS = "wheel", "rail"     # 1 and 2 in the core
NEGLIGIBLE = 1e-4           # noise that needs no smoothing [mm]: it changes the mean curvature over a patch by less than a tread's
SURE = 1.3                  # noise by cross-validation over that by neighbours, at most
MOST_WAVY = 0.25            # of a curve on which a contact is one patch
LEAST_EVEN, MOST_EVEN = 1e-3, 4e-2      # distances tried for waves [mm]
MOST_NOISE = 5e-3           # of points that show waves [mm]
LARGEST_TURN = np.radians(60)           # of a smoothed curve at a knot
TANGLE, MOST_TANGLES = 2.0, 6           # where points follow no curve, those so near are left out [mm]; places, at most
LEAST_SPACING = 1e-3        # nearer points are one to the core [mm]
GEOMETRY = "# geometry: "  # begins the line of a point of `geometry` in a file whose `curve` is smoothed further
MOST_SPACING = 1.0          # of points whose noise can be told from their curve [mm]
# Label of a measure, unit, scale from SI, decimals.
MEASURES = {
    "Sh": ("flange height Sh", "mm", MM, 2), "Sd": ("flange thickness Sd", "mm", MM, 2), "qR": ("qR", "mm", MM, 2),
    "flange_angle": ("flange angle", "°", DEG, 2), "tread_slope": ("tread slope", "", 1.0, 4),
    "hollow": ("hollow of the tread", "mm", MM, 2),
    "crown_radius": ("crown radius", "mm", MM, 1), "shoulder_radius": ("shoulder radius", "mm", MM, 1),
    "corner_radius": ("gauge corner radius", "mm", MM, 2),
    "lower_corner_radius": ("gauge corner radius, lower part", "mm", MM, 2),
    "gauge_point_y": ("gauge point at y", "mm", MM, 3), "top_y": ("top of rail at y", "mm", MM, 1),
    "inclination": ("inclination", "", 1.0, 4),
}


class ProfileData:
    """`ldbench.Profile` without its picture."""

    path: str                   # '' for points
    kind: str                   # 'wheel' or 'rail'
    format: str
    origin: str                 # how y = 0 was found
    noise: float                # of the points, rms, normal to the curve [mm]; NaN where their distance hides it
    smoothing: float            # rms distance between curve and points [mm]; 0: the curve goes through the points
    own_smoothing: float        # the same of `geometry` [mm]
    notes: list[str]            # what was done to the points, and what is doubtful, a line each
    scale: float                # 5 of a model 1:5
    hidden: float               # depth, at full size, to which a rail goes on behind its first point, in points left out [mm]
    remarks: dict[str, str]     # on measures, by name: what was done that changes them
    points: np.ndarray          # placed and mended, (n, 2) [mm]
    geometry: np.ndarray        # points of the curve by their noise alone, (m, 2) [mm]: cubic splines go through them
    curve: np.ndarray           # of the curve that a run uses; without the waves that would break a contact into several patches

    def __init__(self, source: str | os.PathLike[str] | Sequence[Sequence[float]] | np.ndarray, kind: str = "", *,
                 unit: str = "auto", flip: str = "auto", wheel_back: float | None = None, smoothing: float | None = None,
                 slice: int | None = None, gauge_depth: float = 0.014, scale: float | None = None) -> None:
        """Read a profile; Error, with file and line, where it cannot be one.

        source: a file, which is in the working folder or a shipped one, or points (n, 2) [mm]. kind: 'wheel' or 'rail'; '' as the
        file or the shape says. unit: 'mm', 'cm', 'm' or 'in'. flip: axes to turn over, 'none', 'y', 'z' or 'yz'. wheel_back: y of
        the wheel's back in the file [mm]. smoothing: rms distance that the curve may keep from the points [mm], 0 for none, None
        for their noise. slice: which profile of a file that has several, from 1. gauge_depth: down to which the gauge of a rail
        is measured, for `measures` [m]. scale: 5 of a model 1:5, None for what the size says.
        """
        if kind not in ("", *KINDS):
            raise ValueError(f"expected kind='wheel', 'rail' or '', found {kind!r}")
        self._options = (unit, flip, wheel_back, smoothing, slice, scale)
        self._gauge_depth = gauge_depth
        if isinstance(source, (str, os.PathLike)):
            self.path = where = find_file(source)
            raw = read_file(self.path, slice)
        else:
            self.path, where, raw = "", "the points", of_array(source)
        self.format, self.origin, self.kind, self.as_it_is = raw.format, "as the file has it", kind or raw.kind, False
        if raw.taken and self._default and self.kind:
            self.as_it_is = core_takes(self.path, self.kind)
        self.scale, self.hidden, self.remarks = raw.scale or 1.0, raw.hidden*(raw.scale or 1.0), dict(raw.remarks)
        if not self.as_it_is:
            placed = place(raw, where, kind, unit, flip, wheel_back, scale)
            self.kind, self.origin = placed.kind, placed.origin
            self.scale, self.hidden, self.remarks = placed.scale, placed.hidden, placed.remarks
            unmoved = bool(self.path) and self._default and np.array_equal(placed.points, raw.points)
            self.as_it_is = unmoved and core_takes(self.path, self.kind)
        if self.as_it_is:
            self.points = self.curve = raw.points
            told = geometry_lines(self.path) if raw.taken else np.empty((0, 2))
            self.geometry = told if len(told) else raw.points
            self.noise, self.smoothing, self.own_smoothing = MM*point_noise(raw.points), 0.0, 0.0
            self.notes = [raw.taken] if raw.taken else []
            return
        mended = mend(placed.points, placed.lines, where)
        check_curve(mended.points, mended.lines, where)
        self.points = mended.points
        self.notes = [*raw.notes, *placed.notes, *mended.notes]
        self._smooth(None if smoothing is None else self.scale*smoothing, raw.quantum*placed.unit/np.sqrt(12*mended.group))
        if self.scale != 1:         # a model is placed, mended and smoothed at full size
            for name in "points", "geometry", "curve", "noise", "own_smoothing", "smoothing":
                setattr(self, name, getattr(self, name)/self.scale)
        self._reconstruction = bool(self.path) and b"reconstruction" in Path(self.path).read_bytes().lower()

    def _smooth(self, distance: float | None, rounding: float) -> None:
        """Choose the curve. rounding: noise that the decimals of the points alone make [mm]."""
        spacing = np.diff(chord_lengths(self.points))
        self.noise, self.smoothing, self.own_smoothing = MM*point_noise(self.points), 0.0, 0.0
        self.curve = self.geometry = self.points[np.r_[True, spacing > LEAST_SPACING]]
        usual = float(np.median(spacing))
        if usual > MOST_SPACING:
            self.noise = np.nan
            self.notes.append(f"points {usual/self.scale:.1f} mm apart: their noise cannot be told from their curve")
        for k in np.flatnonzero(spacing > np.maximum(2.0, 8*usual)):
            self.notes.append(f"gap of {spacing[k]/self.scale:.1f} mm after y = {self.points[k, 0]/self.scale:.1f} mm")
        if rounding > NEGLIGIBLE:
            self.notes.append(f"points rounded: a noise of {1e3*rounding/self.scale:.1f} µm at least")
        quiet = distance is None and (np.isnan(self.noise) or max(self.noise, rounding) <= NEGLIGIBLE)
        if distance == 0 or (quiet and not self._wavy(self.points)):
            return
        # What neighbours do not tell of each other is noise; cross-validation takes a step for noise, too.
        most = SURE*self.noise if self.noise > max(rounding, NEGLIGIBLE) else np.inf
        found = self._smoothed(distance, rounding, most)
        self.noise = found.noise
        if not quiet:
            self.geometry, self.own_smoothing = found.points, found.distance
        even, asked = found, found.distance
        while distance is None and found.noise < MOST_NOISE and asked < MOST_EVEN and self._wavy(even.points):
            asked = min(max(LEAST_EVEN, 1.5*asked), MOST_EVEN)
            even = self._smoothed(asked, rounding, most)
        if asked > found.distance and self._wavy(even.points):
            self.notes.append("wavy: contacts fall into several patches")
        self.smoothing, self.curve = found.distance, found.points
        if asked > found.distance and not self._wavy(even.points):
            self.smoothing, self.curve = even.distance, even.points
            size, y = farthest(self.geometry, fine_points(self.curve))
            self.notes.append(f"wavy: for a run smoothed by {1e3*even.distance/self.scale:.2g} µm, more than the noise of "
                              f"{1e3*even.noise/self.scale:.2g} µm, so that a contact is one patch; its curve is up to "
                              f"{1e3*size/self.scale:.2g} µm from that of the geometry, at y = {y/self.scale:.1f} mm; "
                              "smoothing=0 keeps the waves")
        if len(found.far) and found.distance <= FAR*found.noise:
            places = ", ".join(f"{y/self.scale:.1f}" for y, _ in found.far[:5])
            self.notes.append(f"the curve keeps farther from the points than {FAR:.0f} times their noise at y = {places} mm"
                              + (f" and {len(found.far) - 5} more places" if len(found.far) > 5 else ""))

    def _smoothed(self, distance: float | None, rounding: float, most: float) -> Smoothed:
        """The smooth curve; where points follow no curve, as those of two scans that disagree, it is laid without them."""
        for _ in range(MOST_TANGLES):
            found = smooth(self.points, distance, rounding, most)
            turns = turns_of(found.points)
            if turns.max() <= LARGEST_TURN or (distance is not None and distance < found.noise):
                return found
            wild = found.points[1 + turns.argmax()]
            near = self.points[np.hypot(*(self.points - wild).T).argmin()]
            off = np.hypot(*(self.points - near).T) < TANGLE
            self.notes.append(f"{off.sum()} points about y = {near[0]/self.scale:.1f} mm left out: they do not follow a curve")
            self.points = self.points[~off]
        raise Error(file=self.path or 'the points', expected="points along a curve",
                    found=f"{MOST_TANGLES} places where they follow none",
                    advice="look whether two scans lie over each other")

    def _wavy(self, curve: np.ndarray) -> bool:
        """Whether contacts on a curve fall into several patches."""
        return waviness(survey(self.kind, *frames_of(curve), self.scale*self._gauge_depth)[0]) > MOST_WAVY

    @property
    def _default(self) -> bool:
        return self._options == ("auto", "auto", None, None, None, None)

    @functools.cached_property
    def rough(self) -> Stations:
        """The curve through `points`."""
        return self._survey(self.points)[0]

    @functools.cached_property
    def smooth(self) -> Stations:
        """The curve by the noise of the points alone: that of the measures and of conicity."""
        return self._survey(self.geometry)[0]

    @functools.cached_property
    def used(self) -> Stations:
        """The curve that a run uses."""
        return self._survey(self.curve)[0]

    @property
    def smoothed_further(self) -> bool:
        """Whether the curve that a run uses is not that of the geometry."""
        return self.geometry is not self.curve and not np.array_equal(self.geometry, self.curve)

    @functools.cached_property
    def moved(self) -> tuple[float, float]:
        """The largest distance of the curve that a run uses from that of the geometry, and y of its place [mm]."""
        return farthest(self.geometry, self._fine)

    @functools.cached_property
    def measures(self) -> dict[str, float]:
        """Measures of workshop and track, SI units; NaN where the profile does not go so far."""
        return self._survey(self.geometry)[1]

    def _survey(self, points: np.ndarray) -> tuple[Stations, dict[str, float]]:
        found, measures = survey(self.kind, *frames_of(self.scale*points), self.scale*self._gauge_depth, self.hidden/MM)
        return found if self.scale == 1 else found.scaled(1/self.scale), {
            name: value if MEASURES[name][1] != "mm" else value/self.scale for name, value in measures.items()}

    @functools.cached_property
    def data(self) -> bytes:
        """What `write` writes: two columns that the executable reads."""
        if self.as_it_is:
            return Path(self.path).read_bytes()
        rows = "\n".join(f"{y:.9f} {z:.9f}" for y, z in self.curve.tolist())
        # Column files take over this line, and are read by programs that know no other letters.
        taken = ", ".join([self.format, self.origin, *self.notes, self._kept()]).replace("µm", "um")
        return (f"# {self.kind} {Path(self.path).name}\n# taken: {taken}\n"
                + f"{SCALE} {self.scale:g}\n"*(self.scale != 1)
                + f"{HIDDEN} {self.hidden/self.scale:.4f}\n"*(self.hidden > 0)
                + "".join(f"{REMARK}{name}: {words}\n" for name, words in self.remarks.items())
                + "# reconstruction of another profile\n"*self._reconstruction
                + "".join(f"{GEOMETRY}{y:.9f} {z:.9f}\n" for y, z in self.geometry.tolist())*self.smoothed_further
                + "# columns: y z, both in mm, z up, y towards the field side\n" + rows + "\n").encode("ascii", "replace")

    def _kept(self) -> str:
        """The noise of the points, and how near to them the curve is."""
        noise = "unknown" if np.isnan(self.noise) else "below 0.0001 mm"
        if self.noise > NEGLIGIBLE:
            noise = f"about {self.noise:.4f} mm"
        curve = f"smoothed by {self.own_smoothing:.4f} mm" if self.own_smoothing else "curve through the points"
        if self.smoothing and self.smoothed_further:
            curve += f", for a run smoothed by {self.smoothing:.4f} mm"
        return f"noise of the points {noise}, {curve}"

    @property
    def checksum(self) -> str:
        """CRC-32 of the lines that the core reads."""
        return checksum(self.data)

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the curve for the executable: y and z in mm, z up, y to the field side."""
        with complete(Path(path)) as scratch:
            scratch.write_bytes(self.data)

    def __fspath__(self) -> str:
        """A path that a case takes: the file itself, or one in outputs/profiles where points or options made another curve. Where
        that folder may not be written, the file is in the user's cache."""
        if self.path and self._default:
            return self.path
        folder = Path(kept_folder(str(FOLDER)) or FOLDER)
        target = folder/f"{Path(self.path).stem or self.kind}-{self.checksum}.yz"
        if not target.exists():
            make_results_folder(folder)
            self.write(target)
        return str(target)

    def distance(self) -> np.ndarray:
        """Distance of every point from the curve, to the left of the walk positive, (n,) [mm]."""
        return distances(self.points, self._fine)

    @functools.cached_property
    def _fine(self) -> np.ndarray:
        """The curve that a run uses, every 0.02 mm, (2, n) [mm]."""
        return fine_points(self.curve)

    def facts(self) -> dict[str, object]:
        """The numbers, SI units."""
        return {"path": self.path, "kind": self.kind, "points": len(self.points), "checksum": self.checksum, "format": self.format,
                "origin": self.origin, "notes": self.notes, "noise": self.noise/MM if self.noise == self.noise else None,
                "smoothing": self.smoothing/MM, **({"scale": self.scale} if self.scale != 1 else {}), **self._told()}

    def _told(self) -> dict[str, object]:
        """Measures, each with the remark on it behind."""
        found: dict[str, object] = {}
        for name, value in self.measures.items():
            found[name] = value
            if words := self.remark(name):
                found[f"{name}_remark"] = words
        return found

    def remark(self, name: str) -> str:
        """What was done that changes a measure, or why there is none; '' for nothing."""
        found = [self.remarks[name]] if name in self.remarks else []
        if self.kind == "rail" and name in self._rail_remarks:
            found.append(self._rail_remarks[name])
        return "; ".join(found)

    @functools.cached_property
    def _rail_remarks(self) -> dict[str, str]:
        return rail_remarks(self.smooth, self.measures)

    def lines(self) -> list[str]:
        """What there is to say, line by line."""
        found = [f"{self.kind} {Path(self.path).name}: {len(self.points)} points, CRC-32 {self.checksum}",
                 *([] if self.as_it_is else [f"{self.format}, {self.origin}"]), *self.notes]
        found.append(self._kept())
        for name, value in self.measures.items():
            label, unit, scale, digits = MEASURES[name]
            number = f"{scale*value:.{digits}f}" if np.isfinite(value) else "not on the profile"
            if name in ("tread_slope", "inclination") and np.isfinite(value):
                number = slope_words(value, digits)
            remark = f" ({self.remark(name)})" if self.remark(name) else ""
            if remark and not np.isfinite(value):
                number = "none"
            found.append(f"{label} {number} {unit if np.isfinite(value) else ''}".rstrip() + remark)
        return found

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.lines()[0]}>"


def fine_points(points: np.ndarray) -> np.ndarray:
    """The curve through points (n, 2), every 0.02 mm, (2, m) [mm]."""
    length, frames = frames_of(points)
    return MM*frames(np.arange(0, length, 0.02e-3))[:2]


def farthest(points: np.ndarray, fine: np.ndarray) -> tuple[float, float]:
    """The largest distance of points (n, 2) from a curve through near points `fine`, (2, m), and y of its place [mm]."""
    off = np.abs(distances(points, fine))
    return float(off.max()), float(points[off.argmax(), 0])


def distances(points: np.ndarray, fine: np.ndarray) -> np.ndarray:
    """Distances of points (n, 2) from a curve through near points `fine`, (2, m), to the left of the walk positive, (n,) [mm]."""
    y, z = fine
    near = np.argmin((points[:, :1] - y)**2 + (points[:, 1:] - z)**2, axis=1).clip(1, len(y) - 2)
    along = np.stack([y[near + 1] - y[near - 1], z[near + 1] - z[near - 1]])
    off = points.T - np.stack([y[near], z[near]])
    return (along[0]*off[1] - along[1]*off[0])/np.hypot(*along)


def geometry_lines(path: str) -> np.ndarray:
    """Points of the geometry in a file that the program wrote, (n, 2) [mm]; none where they are those of the run."""
    with open(path, encoding="utf-8", errors="replace") as file:
        found = [line.removeprefix(GEOMETRY).split() for line in file if line.startswith(GEOMETRY)]
    return np.array(found, float).reshape(-1, 2)


def point_noise(points: np.ndarray) -> float:
    """The noise of points (n, 2) [mm], as the core judges whether it reads them [m]."""
    return float(flat.point_noise(*np.ascontiguousarray(points.T/MM)))


def frames_of(points: np.ndarray) -> tuple[float, Callable[[np.ndarray], np.ndarray]]:
    """The length [m] of the splines through points (n, 2) [mm], and what gives their frames at stations [m]."""
    columns = np.asfortranarray(points.T)
    return float(flat.curve_frames(columns, np.empty(0))[0]), lambda s: flat.curve_frames(columns, s)[1]


def core_takes(path: str, kind: str) -> bool:
    """Whether the core reads a file as it is."""
    _, length = flat.check_profile(path_bytes(path), 1 + KINDS.index(kind))
    return length == 0


def core_file(path: str, kind: str) -> str:
    """A file that the core reads as a 'wheel' or a 'rail': the profile's own, or what is made of it in a folder that the process
    removes at its end."""
    try:
        state = Path(path).stat()
    except OSError:
        return path             # the core tells it
    if made := _converted(os.path.realpath(path), kind, state.st_mtime_ns, state.st_size):
        OWN_NAMES[made] = path
    return made or path


def geometry_file(path: str, kind: str) -> str:
    """A file that the core reads, like `core_file`, with the curve by the noise of the points alone."""
    file = core_file(path, kind)
    try:
        state = Path(file).stat()
    except OSError:
        return file
    if made := _geometry(os.path.realpath(file), kind, state.st_mtime_ns, state.st_size):
        OWN_NAMES[made] = path
    return made or file


@functools.lru_cache(maxsize=1000)
def _geometry(path: str, kind: str, *state: int) -> str:
    """The file with the geometry of a file that the core reads; '' where that is its own."""
    if not len(points := geometry_lines(path)):
        return ""
    kept = [line for line in Path(path).read_text(encoding="utf-8", errors="replace").splitlines(keepends=True)
            if line.startswith((SCALE, HIDDEN, REMARK))]
    target = scratch_folder(os.getpid())/f"geometry-{checksum(Path(path).read_bytes())}-{Path(path).name}"
    rows = "".join(f"{y:.9f} {z:.9f}\n" for y, z in points.tolist())
    target.write_text(f"# {kind} {Path(path).name}\n# taken: smoothed by the noise of its points alone\n{''.join(kept)}{rows}")
    return str(target)


@functools.lru_cache(maxsize=1000)
def _converted(path: str, kind: str, *state: int) -> str:
    """The file that is made of a profile; '' where the core reads its own."""
    profile = ProfileData(path, kind)
    if profile.as_it_is:
        return ""
    target = scratch_folder(os.getpid())/f"{profile.checksum}-{Path(path).name}.yz"
    profile.write(target)
    return str(target)


@functools.lru_cache(maxsize=1)
def scratch_folder(process: int) -> Path:
    """The folder of a process for converted profiles."""
    folder = tempfile.mkdtemp(prefix="ldbench-")

    @atexit.register
    def remove() -> None:
        if os.getpid() == process:          # a fork leaves it to its parent
            shutil.rmtree(folder, ignore_errors=True)

    return Path(folder)


def checksum(data: bytes) -> str:
    """The checksum of a profile's lines, as the core computes it: tabs are blanks, line ends are one newline."""
    lines = data.replace(b"\t", b" ").splitlines()
    return f"{zlib.crc32(b''.join(line + bytes([10]) for line in lines)):08X}"
