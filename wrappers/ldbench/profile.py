"""Look at a wheel or rail profile, or at a pair, before a run: one page and the numbers.

The page shows which part is what, tangent angle and curvature before and after smoothing, the measures of
workshop and track, what was mended; for a pair clearance, contact positions, conicity and zones too.

examples:
  python -m ldbench profile profiles/awprof.yz
  python -m ldbench profile wheel.whl rail.ban --set smoothing_mm=0.02 gauge=1.435 back_to_back=1.36 -o pair.png
  python -m ldbench profile left.whl rail.ban --set wheel_profile_right=right.whl
"""
from __future__ import annotations

import argparse
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from . import _flat
from ._core import Error, Handle, check, check_written, complete, descriptions, path_bytes, text, text_bytes
from .case import Case
from .conicity import GEOMETRY_PITCH, equivalent_conicity, geometry_rows, linearised_conicity
from .measures import PARTS, Stations, survey
from .run import parse_setting
from .table import located

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

KINDS = "", "wheel", "rail"
MM, DEG = 1e3, 180/np.pi
# Label of a measure, unit, scale from SI, decimals.
MEASURES = {
    "Sh": ("flange height Sh", "mm", MM, 2), "Sd": ("flange thickness Sd", "mm", MM, 2), "qR": ("qR", "mm", MM, 2),
    "flange_angle": ("flange angle", "°", DEG, 2), "tread_slope": ("tread slope", "", 1.0, 4),
    "hollow": ("hollow of the tread", "mm", MM, 2),
    "crown_radius": ("crown radius", "mm", MM, 1), "shoulder_radius": ("shoulder radius", "mm", MM, 1),
    "corner_radius": ("gauge corner radius", "mm", MM, 2),
    "gauge_point_y": ("gauge point at y", "mm", MM, 3), "top_y": ("top of rail at y", "mm", MM, 1),
    "inclination": ("inclination", "rad", 1.0, 4),
}


@dataclass(frozen=True)
class Profile:
    """A profile as the program takes it."""
    path: str
    kind: str                   # 'wheel' or 'rail'
    smoothing: float            # [mm]
    checksum: str
    taken: str                  # how, where it says more than y, z in mm
    mended: str                 # '' where nothing was
    points: np.ndarray          # (n, 2) [mm], y from a wheel's back
    rough: Stations             # curve through the points
    smooth: Stations            # curve at the smoothing that is asked for
    noise: float                # of the points, estimated [m]
    measures: dict[str, float]  # SI units; NaN where the profile does not go so far

    def lines(self) -> list[str]:
        """What there is to say, line by line."""
        found = [f"{self.kind} {Path(self.path).name}: {len(self.points)} points, CRC-32 {self.checksum}"]
        found += [note for note in (self.taken, self.mended) if note]
        noise = f"about {MM*self.noise:.3f} mm" if self.noise >= 5e-7 else "below 0.001 mm"
        found.append(f"noise of the points {noise}, smoothing_mm = {self.smoothing:g}")
        for name, value in self.measures.items():
            label, unit, scale, digits = MEASURES[name]
            number = f"{scale*value:.{digits}f}" if np.isfinite(value) else "not on the profile"
            if name in ("tread_slope", "inclination") and np.isfinite(value) and abs(value) > 1e-4:
                number += f" (1:{1/value:.1f})"
            found.append(f"{label} {number} {unit if np.isfinite(value) else ''}".rstrip())
        return found


def inspect(path: str | os.PathLike[str], kind: str = "", smoothing: float = 0.0, flip: str = "auto",
            unit: str = "auto", gauge_depth: float = 0.014) -> Profile:
    """Read a profile file; without `kind` its shape says whether it is a wheel or a rail.

    smoothing [mm], flip and unit as in &profiles of a namelist, gauge_depth [m]. Raises Error as a run would.
    """
    address, *error = _flat.inspect_profile(path_bytes(path), KINDS.index(kind), smoothing, text_bytes(flip), text_bytes(unit))
    check(*error)
    handle = Handle(_flat.free_profile, address)
    (kind_number, n), (noise, length, rough_length), *listing = _flat.profile_facts(handle)
    found = KINDS[kind_number]
    checksum, taken, mended = text(*listing).split("\n")
    rough, _ = survey(found, rough_length, lambda s: _flat.profile_frames(handle, 0, s), gauge_depth)
    smooth, measures = survey(found, length, lambda s: _flat.profile_frames(handle, 1, s), gauge_depth)
    return Profile(os.fspath(path), found, smoothing, checksum, taken, mended, _flat.profile_points(handle, n).T, rough,
                   smooth, float(noise), measures)


@dataclass(frozen=True)
class Pair:
    """A wheel on a rail, rigid."""
    clearance: tuple[float, float]      # to the left, to the right [m]
    zones: dict[str, np.ndarray]        # of 'left', 'right' (zone, 4): first and last y on the wheel [m], flange 0 or 1,
                                        # contact angle [rad]
    geometry: dict[str, np.ndarray]     # the columns of a geometry file
    amplitude: np.ndarray       # [m]
    conicity: np.ndarray        # for the amplitudes, by EN 15302
    linearised: np.ndarray      # the same by harmonic linearisation

    def lines(self) -> list[str]:
        left, right = (MM*x for x in self.clearance)
        found = ["rigid-axle clearance " + (f"2 x {left:.3f} mm" if left == right else f"left {left:.3f}, right {right:.3f} mm")]
        for amplitude in (2e-3, 3e-3, 4e-3):
            if amplitude <= self.amplitude[-1]:
                values = (np.interp(amplitude, self.amplitude, x) for x in (self.conicity, self.linearised))
                found.append("equivalent conicity at {:.0f} mm {:.3f} (EN 15302), {:.3f} (harmonic linearisation)"
                             .format(MM*amplitude, *values))
        for side, zones in self.zones.items():
            where = "" if left == right else f"{side} "
            found += [f"{where}zone of the {'flange' if flange else 'tread'}: y {MM*first:.1f} to {MM*last:.1f} mm, "
                      f"angle {DEG*alpha:.1f}°" for first, last, flange, alpha in zones if where or side == "left"]
        return found


def pair(case: Case) -> Pair:
    """The rigid geometry of a case's profiles."""
    address, message, length = _flat.prepare_rigid_case(*case.arrays(), located(case))
    check(message, length, case.label)
    handle = Handle(_flat.free_prepared, address)
    (left, n_left), zones_left = _flat.rigid_numbers(handle, 1)
    (right, n_right), zones_right = _flat.rigid_numbers(handle, 2)
    zones = {"left": zones_left.T[:int(n_left)], "right": zones_right.T[:int(n_right)]}
    reach = max(20, int(1.3e4*max(left, right)))
    rows = geometry_rows(handle, GEOMETRY_PITCH*np.arange(-reach, reach + 1))
    rows = rows[:, np.isfinite(rows[7])]
    names = descriptions()[2].split()
    amplitude = GEOMETRY_PITCH*np.arange(2, int(1e4*rows[0, -1]) + 1)
    return Pair((left, right), zones, dict(zip(names, rows, strict=True)), amplitude,
                *(conicity(amplitude, rows[0], rows[7]) for conicity in (equivalent_conicity, linearised_conicity)))


# The page ---------------------------------------------------------------------------------

def page(profiles: list[Profile], found: Pair | None, note: str) -> Figure:
    """Profiles in columns: shape and parts, tangent angle, curvature; below them what a pair does."""
    from .plots import new_page
    from .style import BLACK, GREY, ORANGE, RED

    figure = new_page(" on ".join(Path(p.path).name for p in profiles), note)
    grid = figure.add_gridspec(4 if found else 3, len(profiles), left=0.06, right=0.735, top=0.915, bottom=0.075,
                               hspace=0.5, wspace=0.2, height_ratios=[1.35, 1, 1, 1][:4 if found else 3])
    for column, profile in enumerate(profiles):
        shape, angle, curvature = (figure.add_subplot(grid[row, column]) for row in range(3))
        draw_shape(shape, profile, found)
        for stations, label, color in ((profile.rough, "through the points", GREY),
                                       (profile.smooth, f"smoothing {profile.smoothing:g} mm", BLACK)):
            if stations is profile.rough and profile.smoothing == 0:
                continue
            label = label if profile.smoothing else "through the points"
            width = 0.5 if color == GREY else 0.9
            angle.plot(MM*stations.y, DEG*stations.angle, color=color, linewidth=width, label=label)
            curvature.plot(MM*stations.y, stations.curvature, color=color, linewidth=width, label=label)
        usual = np.percentile(np.abs(profile.smooth.curvature), 99)
        curvature.set_ylim(-1.4*usual, 1.4*usual)
        angle.set_ylabel("tangent angle [°]")
        curvature.set_ylabel("curvature [1/m]")
        curvature.set_xlabel("y [mm]")
        curvature.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.1)
    if found:
        positions, conicity = (figure.add_subplot(grid[3, column]) for column in range(2))
        y = MM*found.geometry["Y"]
        for side, sign, color in ("left", 1, BLACK), ("right", -1, ORANGE):
            contact = found.geometry[f"y_{side[0].upper()}"]
            positions.plot(y, sign*MM*contact, ".", markersize=2, color=color, label=side)
        positions.set_ylabel("contact, outward |y| [mm]")
        conicity.plot(MM*found.amplitude, found.conicity, color=BLACK, label="EN 15302")
        conicity.plot(MM*found.amplitude, found.linearised, "--", color=RED, linewidth=0.8,
                      label="harmonic linearisation")
        conicity.set_ylim(bottom=0)
        conicity.set_ylabel("equivalent conicity")
        positions.set_xlabel("lateral displacement Y [mm]")
        conicity.set_xlabel("amplitude [mm]")
        for ax in positions, conicity:
            for reach in set(found.clearance):
                ax.axvline(MM*reach, color=GREY, linewidth=0.6, linestyle=":")
        positions.legend(loc="center left", markerscale=3)
        conicity.legend(loc="upper right")
    write_lines(figure, profiles, found)
    return figure


def draw_shape(ax: Axes, profile: Profile, found: Pair | None) -> None:
    """Points, curve and parts; of a wheel in a pair the ends of its zones."""
    from .style import BLUE, GREEN, GREY, ORANGE, PURPLE, RED, SKY

    colors = dict(zip(PARTS, (GREY, RED, ORANGE, BLUE, GREEN, PURPLE, BLUE, GREEN), strict=True))
    c = profile.smooth
    ax.plot(*profile.points.T, ".", markersize=1.5, color=SKY, zorder=1)
    for k, name in enumerate(PARTS, 1):
        here = c.part == k
        if here.any():
            ax.plot(MM*np.where(here, c.y, np.nan), MM*c.z, color=colors[name], linewidth=1.4, label=name)
    if found and profile.kind == "wheel":
        for first, *_ in found.zones["left"][:-1]:
            k = int(np.argmin(np.where((c.part > 1) & (c.part < 5), np.abs(c.y - first), np.inf)))
            ax.plot(MM*c.y[k], MM*c.z[k], "|", color="black", markersize=12)
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.03, 0.08)
    ax.set_ylabel("z [mm]")
    ax.set_title(profile.kind, loc="left", weight="bold")
    ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=5, borderaxespad=0.1, columnspacing=1.0)


def write_lines(figure: Figure, profiles: list[Profile], found: Pair | None) -> None:
    """The numbers, in a column on the right."""
    import textwrap

    from .style import plain

    blocks = [profile.lines() for profile in profiles] + ([found.lines()] if found else [])
    wrapped = []
    for block in blocks:
        wrapped += [line for entry in block for line in textwrap.wrap(entry, 52, subsequent_indent="  ")] + [""]
    figure.text(0.752, 0.905, plain("\n".join(wrapped)), fontsize=6.5, va="top", linespacing=1.45)


def save(figure: Figure, target: Path) -> None:
    from .style import ldbench_style

    with ldbench_style(), complete(target) as scratch:
        figure.savefig(scratch, format=target.suffix[1:], dpi=110)


# The command ------------------------------------------------------------------------------

def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("files", nargs="+", metavar="FILE", help="a wheel or a rail, or one of each")
    parser.add_argument("--set", metavar="NAME=VALUE", nargs="+", action="extend", default=[],
                        help="values of a namelist: smoothing_mm, wheel_flip, gauge, back_to_back ...")
    parser.add_argument("-o", "--output", type=Path, default=Path("ldbench_profile.pdf"),
                        help="the page, .pdf or .png (%(default)s)")


def main(args: argparse.Namespace) -> int:
    from .style import ldbench_style

    if len(args.files) > 2:
        raise Error(f"expected a wheel or a rail, or one of each, found {len(args.files)} files")
    if args.output.suffix not in (".pdf", ".png"):
        raise Error(f"expected a page that ends with .pdf or .png, found {args.output}")
    check_written([args.output], map(Path, args.files))
    case = Case.from_namelist("&case /").replace(**dict(map(parse_setting, args.set)))
    profiles = sorted((read(file, case) for file in args.files), key=lambda profile: profile.kind, reverse=True)
    found = None
    if len(profiles) == 2:
        if profiles[0].kind == profiles[1].kind:
            raise Error(f"expected a wheel and a rail, found two {profiles[0].kind}s: {', '.join(args.files)}")
        found = pair(case.replace(wheel_profile=profiles[0].path, rail_profile=profiles[1].path))
    blocks: list[Profile | Pair] = [*profiles, *([found] if found else [])]
    for block in blocks:
        print(block.lines()[0], *(f"  {line}" for line in block.lines()[1:]), sep="\n")
    note = f"gauge {case.gauge:g} m, back-to-back {case.back_to_back:g} m" if found else ""
    with ldbench_style():
        figure = page(profiles, found, note)
    save(figure, args.output)
    print(args.output)
    return 0


def read(file: str, case: Case) -> Profile:
    """A file as the case would take it, whichever it is."""
    found = inspect(file, smoothing=case.smoothing_mm, gauge_depth=case.gauge_depth)
    flip, unit = ((case.wheel_flip, case.wheel_unit) if found.kind == "wheel" else (case.rail_flip, case.rail_unit))
    if (flip, unit) != ("auto", "auto"):
        found = inspect(file, found.kind, case.smoothing_mm, flip, unit, case.gauge_depth)
    return found
