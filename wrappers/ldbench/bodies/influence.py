"""What the influence of a body differs by from that of half-spaces, and the file that the executable reads."""
from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.special import k0

from .._core.errors import Error
from .._core.files import complete, digest, read_bytes
from .._core.kept import program_digest
from ..case import Case
from ..profiles.profile import core_file
from .elements import influences
from .mesh import make_mesh
from .sections import HEAD_DEPTH, PARTS, RIM_THICKNESS, WIDTH, Kind, Section, Support, section

WAVES = np.geomspace(0.2, 800, 25)      # wave numbers [1/m]
POINTS = 60                             # of Gauss's rule for a strip

HEAD = """\
# What the influence of bodies differs by from that of half-spaces, for &contact bodies
# format, units and sign: fortran/contact/body_file.f90
"""


@dataclass(frozen=True)
class Body:
    """A body and its influence; E* is that of wheel and rail together."""

    section: Section
    profile: str                # name of the file
    support: Support
    poisson: float
    nodes: int                  # of the mesh
    middles: np.ndarray         # of the strips, counterclockwise, (strips, 2) [m]
    angles: np.ndarray          # of the strips to the y axis [rad]
    # E* times the mean displacement of a strip into the body by a load per length of another one, (waves, strips, strips)
    whole: np.ndarray
    halfspace: np.ndarray       # the same of half-spaces with the local normals

    @property
    def kind(self) -> Kind:
        """'wheel' or 'rail'."""
        return self.section.kind

    def over_halfspace(self, one: float, other: float) -> float:
        """Influence of loads that are even over some millimetres along x, over the half-space's, between the strips whose angles
        come nearest to two angles [rad], from the steepest one on towards the tread or the crown."""
        steepest = int(np.argmax(self.angles))
        gauge = np.arange(steepest, len(self.angles)) if self.kind == "wheel" else np.arange(steepest + 1)
        i, j = (gauge[np.argmin(np.abs(self.angles[gauge] - angle))] for angle in (one, other))
        return float(np.trapezoid(self.whole[:, i, j], WAVES)/np.trapezoid(self.halfspace[:, i, j], WAVES))


def find(case: Case, support: Support = "infinite", rim_thickness: float = RIM_THICKNESS, head_depth: float = HEAD_DEPTH,
         rim: str | os.PathLike[str] | None = None, head: str | os.PathLike[str] | None = None,
         kinds: Iterable[Kind] = ("wheel", "rail")) -> list[Body]:
    """The bodies of a case's wheels and rails.

    `rim` and `head` are files with outlines of the sections, closed polygons of y and z in mm as in the profiles' files. Without
    them the profiles go on to a base that is rim_thickness [m] above the tape circle, or head_depth [m] below the rail's top.
    Behind the base the body is infinite, or it is clamped there. Takes some seconds of processor time a body.
    """
    found = []
    for kind in kinds:
        names = {path for name, path in case.profile_files().items() if name.startswith(kind)}
        outline = rim if kind == "wheel" else head
        for name in sorted(names):
            points = 1e-3*np.loadtxt(core_file(name, kind), comments=("#", "!", "%"), ndmin=2)
            found.append(body_of(section(kind, points, support, rim_thickness if kind == "wheel" else head_depth,
                                         read_outline(outline) if outline else None, str(outline or "")),
                                 Path(name).name, support, case.poisson))
    return found


def kept(case: Case, support: Support, folder: Path) -> Path:
    """The file of a case's bodies with generic sections, beside its contact tables, or in another folder if the case keeps nothing.
    It is made once."""
    home = Path(case.kept_folder or folder)
    contents = [read_bytes(Path(core_file(path, name.partition("_")[0]))) for name, path in case.profile_files().items()]
    words = f"{program_digest()} {support} {case.poisson} {[digest(data) for data in contents]}"
    file = home/f"{support}_{digest(words.encode())[:16]}.bodies"
    if not file.exists():
        home.mkdir(parents=True, exist_ok=True)
        write(file, find(case, support))
    return file


def read_outline(file: str | os.PathLike[str]) -> np.ndarray:
    """The corners of an outline, (n, 2) [m]."""
    try:
        points = np.loadtxt(file, comments=("#", "!", "%"), ndmin=2)
    except (OSError, ValueError) as error:
        raise Error(file=file, expected="lines of y and z in mm", found=str(error)) from None
    if points.shape[1] != 2 or len(points) < 4 or not np.isfinite(points).all():
        raise Error(file=file, expected="at least four lines with two numbers, y and z in mm",
                    found=f"{len(points)} of {points.shape[1]}")
    return 1e-3*points


def body_of(section: Section, profile: str, support: Support, poisson: float) -> Body:
    """The influence of the body with a section, by finite elements."""
    mesh = make_mesh(section.ends, section.rest, section.held, WIDTH/PARTS)
    strips = (len(section.ends) - 1)//PARTS
    modulus = 1/(2*(1 - poisson**2))        # E* for E = 1 Pa
    found = modulus*influences(mesh, poisson, WAVES)
    found = found.reshape(len(WAVES), strips, PARTS, strips, PARTS).mean(axis=(2, 4))
    ends = section.ends[::PARTS]
    way = np.diff(ends, axis=0)*(1 if section.kind == "wheel" else -1)
    angles = np.arctan2(way[:, 1], way[:, 0])
    apart = WIDTH*np.abs(np.arange(strips)[:, None] - np.arange(strips))
    halfspace = np.array([mean_k0(k, apart) for k in WAVES])/np.pi*np.cos(angles[:, None] - angles)
    middles = np.column_stack([np.interp((np.arange(strips) + 0.5)*PARTS, np.arange(len(section.ends)), x) for x in section.ends.T])
    return Body(section, profile, support, poisson, len(mesh.points), middles, angles, found, halfspace)


def mean_k0(k: float, apart: np.ndarray) -> np.ndarray:
    """Mean of K_0(k d) over the points, d apart, of two strips whose middles are so far apart [m]. The points are dense at d = 0,
    where K_0 has a logarithm."""
    at, weight = np.polynomial.legendre.leggauss(POINTS)
    share = ((at + 1)/2)**3
    weight = weight/2*3*((at + 1)/2)**2*(1 - share)
    return sum(np.sum(weight*k0(k*np.abs(apart[..., None] + sign*share*WIDTH)), axis=-1) for sign in (-1, 1))


def write(file: str | os.PathLike[str], bodies: Iterable[Body]) -> None:
    """Write the file that `&contact bodies` names."""
    lines = [HEAD]
    for body in bodies:
        difference, middles = body.whole - body.halfspace, 1e3*body.middles
        if body.kind == "rail":             # strips in the order of the profile
            difference, middles = difference[:, ::-1, ::-1], middles[::-1]
        base = 1e3*body.section.rest[0, 1]
        lines.append(f"\n# {body.profile}; {body.support} body behind z = {base:.1f} mm; {body.nodes} nodes\n"
                     f"body {body.kind}\npoisson {body.poisson:g}\nwidth {1e3*WIDTH:g}\n")
        lines += [f"strip {y:.5f} {z:.5f}\n" for y, z in middles]
        for k, rows in zip(WAVES, difference, strict=True):
            lines.append(f"wave {1e-3*k:.6g}\n")
            lines += [" ".join(f"{x:.4g}" for x in row[:i + 1]) + "\n" for i, row in enumerate(rows)]
    with complete(Path(file)) as scratch:
        scratch.write_text("".join(lines))
