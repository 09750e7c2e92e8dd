"""The picture of the pressure between wheels and rails at one moment: developed surface, cuts, cross-section."""
from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, Polygon

from ..constants import CONTACT_NAMES, DEG, KN, MM
from ..geometry.outlines import Outlines, pose, run_outlines, turned
from ..geometry.pressures import hardest
from ..pressure import Patch
from ..results.run_data import RunData
from .frame import caption, legend_above, new_page
from .impact import RAIL_GREY
from .named import shows
from .sheets import save_sheets
from .style import BLACK, BLUE, DASHED, GREEN, RED, ldbench_style

MPA = 1e-6
LEVELS = 10             # of the contours
REACH = 16.0            # of the cross-section, upwards and downwards [mm]
WIDEST = 2.2            # cross-section, its width over its height
HAIR = 7.0              # of the largest pressure in the cross-section [mm]


def pressure_page(run: RunData, k: int, patches: Sequence[Patch]) -> Figure:
    """A column for each contact: developed surface, cuts through the largest pressure, cross-section."""
    contacts = {name: list(found) for name, found in groupby(patches, key=patch_name)}
    figure = new_page(f"{run.heading}: pressure at t = {run.time[k]:.6f} s", run.header.title,
                      "pressure of elastic half-spaces on the surface developed into the plane: x along the rail, s along the "
                      "wheel's profile towards the field side; dashed: Hertz's ellipse with ∫p dA and the curvatures where the "
                      "approach is largest; forces and angles are those of the columns, by which the elastic energy changes "
                      "with the pose; ∫p dA adds pressures without their directions and exceeds the force where normals turn over "
                      "a patch"
                      f"\n{caption(run)}")
    axes = figure.subplots(3, len(contacts), squeeze=False, gridspec_kw={"height_ratios": [1, 0.85, 1]})
    outlines, _ = run_outlines(run)
    for (name, found), (surface, cuts, section) in zip(contacts.items(), axes.T, strict=True):
        draw_surface(figure, surface, found)
        surface.set_title("\n".join([f"{name}: {force_words(run, k, found[0])}", *map(words, found)]), fontsize=7, loc="left",
                          linespacing=1.4)
        draw_cuts(cuts, found)
        if outlines is None:
            section.set_visible(False)
        else:
            draw_section(section, found, outlines, pose(run, k))
    return figure


def patch_name(patch: Patch) -> str:
    """The contact of a patch in words, or both contacts that share it: 'left flange', 'left flange and tread, one patch'."""
    return CONTACT_NAMES[patch.contact] + (f" and {CONTACT_NAMES[patch.also].split()[1]}, one patch" if patch.also else "")


def force_words(run: RunData, k: int, patch: Patch) -> str:
    """The forces and the contact angles that the columns have for the contacts of a patch at row k."""
    return " and ".join(f"{KN*run.values(f'N_{contact}')[k]:.2f} kN at {DEG*run.values(f'angle_{contact}')[k]:.1f}°"
                        for contact in patch.contacts)


def words(patch: Patch) -> str:
    """What there is to say of a patch, in lines."""
    hertz = f"\nHertz: {MPA*patch.hertz.largest:.0f} MPa on {1e6*patch.hertz.area:.0f} mm²" if patch.hertz else ""
    return (f"∫p dA {KN*patch.integral:.1f} kN on {1e6*patch.area:.0f} mm²\n"
            f"largest {MPA*patch.largest:.0f} MPa, mean {MPA*patch.mean:.0f} MPa{hertz}")


def draw_surface(figure: Figure, ax: Axes, patches: Sequence[Patch]) -> None:
    """Pressed elements over x and s, contours of pressure, and Hertz's ellipses."""
    largest = MPA*hardest(patches).largest
    half_x: list[float] = []        # of all patches and ellipses
    ends: list[float] = []
    for patch in patches:
        half_x.append(patch.half_x)
        ends += patch.s_ends
        x, s, p = patch.sections
        ends_of_image = (MM*x[0], MM*x[-1], MM*s[0], MM*s[-1])
        colours = ax.imshow(MPA*p.T, extent=ends_of_image, origin="lower", aspect="auto", cmap="cividis", vmin=0, vmax=largest,
                            interpolation="nearest")
        names = f"pressure {patch.contact} [MPa]", "x, s [mm]"
        shows(colours, *names, "elements")
        lines = ax.contour(MM*x, MM*s, MPA*np.nan_to_num(p).T, largest*np.arange(1, LEVELS)/LEVELS, colors="white", linewidths=0.3)
        shows(lines, *names, "contours")
        if patch.hertz:
            half_x.append(patch.hertz.half_x)
            ends += [patch.s_deepest - patch.hertz.half_s, patch.s_deepest + patch.hertz.half_s]
            ellipse = Ellipse((0, MM*patch.s_deepest), 2*MM*patch.hertz.half_x, 2*MM*patch.hertz.half_s, fill=False,
                              edgecolor=RED, linestyle=DASHED, linewidth=1.1, label="Hertz's ellipse")
            ax.add_artist(shows(ellipse, f"Hertz's ellipse {patch.contact} [mm]", "x, s [mm]", "ellipse"))
    spare, widest = 0.05*(max(ends) - min(ends)), 1.05*MM*max(half_x)
    ax.set(xlim=(-widest, widest), ylim=(MM*(min(ends) - spare), MM*(max(ends) + spare)), xlabel="x along the rail [mm]",
           ylabel="s along the profile [mm]")
    ax.set_aspect("equal", adjustable="box")
    ax.grid(False)
    bar = figure.colorbar(colours, ax=ax, location="bottom", pad=0.02, aspect=30, fraction=0.06)
    bar.set_label("pressure [MPa]")
    shows(bar.solids, "pressure [MPa]", how="legend")


def draw_cuts(ax: Axes, patches: Sequence[Patch]) -> None:
    """The pressure along the rail and along the profile through the largest one, from there."""
    patch = hardest(patches)
    x, s, p = patch.sections
    i, j = np.unravel_index(int(np.nanargmax(p)), p.shape)
    pressure = f"pressure {patch.contact} [MPa]"
    along, = ax.plot(MM*x, MPA*p[:, j], color=BLUE, linewidth=1.1, label="along the rail")
    across, = ax.plot(MM*(s - patch.s_deepest), MPA*p[i], color=GREEN, linewidth=1.1, label="along the profile")
    shows(along, pressure, "x [mm]", "cut")
    shows(across, pressure, "s [mm]", "cut")
    if patch.hertz:
        share = np.linspace(-1, 1, 201)
        for way, half, colour in ("x [mm]", patch.hertz.half_x, BLUE), ("s [mm]", patch.hertz.half_s, GREEN):
            smooth, = ax.plot(MM*half*share, MPA*patch.hertz.largest*np.sqrt(1 - share**2), color=colour, linestyle=DASHED,
                              linewidth=0.8, label="Hertz")
            shows(smooth, pressure, way, "Hertz")
    ax.set_ylim(bottom=0)
    ax.margins(x=0.03)
    legend_above(ax)
    ax.set(xlabel="from the largest approach [mm]", ylabel="pressure [MPa]")


def draw_section(ax: Axes, patches: Sequence[Patch], outlines: Outlines, at: tuple[float, float, float]) -> None:
    """Wheel and rail around the patches, with the pressure at x = 0 as a crest on the wheel."""
    right = patches[0].contact.startswith("R")
    side, sign = outlines.sides[right]
    wheel = turned(side.wheel*[sign, 1], *at)
    name = "right" if right else "left"
    rail = Polygon(MM*side.rail*[sign, 1], facecolor=RAIL_GREY, edgecolor=BLACK, linewidth=0.7, label="rail")
    ax.add_artist(shows(rail, f"rail {name} [mm]", "y [mm]", "outline"))
    outline, = ax.plot(*MM*wheel.T, color=BLACK, linewidth=0.9, label="wheel")
    shows(outline, f"wheel {name} [mm]", "y [mm]", "outline")
    scale = HAIR/hardest(patches).largest
    for patch in patches:
        track, along = MM*patch.track, np.gradient(patch.track, axis=0)
        normal = sign*np.stack([-along[:, 1], along[:, 0]], axis=1)/np.linalg.norm(along, axis=1)[:, None]
        crest = track + scale*patch.p[len(patch.x)//2][:, None]*normal
        names = f"pressure {patch.contact}", "place on the profile [mm]"
        area = Polygon(np.vstack([track, crest[::-1]]), facecolor=BLUE, alpha=0.35, linewidth=0,
                       label=f"pressure at x = 0, {MPA*hardest(patches).largest:.0f} MPa at most")
        ax.add_artist(shows(area, *names, "crest"))
        pressed = patch.p.max(axis=0) > 0
        touched, = ax.plot(*track[pressed].T, color=RED, linewidth=2.0, solid_capstyle="butt", label="pressed")
        shows(touched, *names, "pressed")
    handles = {handle.get_label(): handle for handle in (*ax.patches, *ax.lines) if not handle.get_label().startswith("_")}
    legend_above(ax, ncols=2, handles=list(handles.values()))
    centre = MM*np.mean([patch.centre for patch in patches], axis=0)
    apart = max(MM*abs(patch.centre[0] - patches[0].centre[0]) for patch in patches)
    height = REACH + apart
    ax.set(xlim=(centre[0] + WIDEST*height, centre[0] - WIDEST*height), ylim=(centre[1] - height, centre[1] + height),
           xlabel="y in the track [mm]", ylabel="z [mm]")
    ax.set_aspect("equal", adjustable="box")


def save_page(run: RunData, k: int, patches: Sequence[Patch], target: Path) -> None:
    """Write the picture, as the ending of the name says."""
    with ldbench_style():
        save_sheets([pressure_page(run, k, patches)], target)
