"""The PDF of plots: every quantity of the benchmark's list against time, for each run.

A page shows a quantity over the whole run and, beside it, around the first contact of
the left flange.  A long run of many rattling impacts (exercise 5) is drawn as the band between
smallest and largest value, and its last second beside it.  Every page is drawn by one function that returns a figure.
"""
from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter, NullLocator
from matplotlib.transforms import ScaledTranslation
from pypdf import PdfReader, PdfWriter

from ._core import Error, check_written, complete, usable_cores
from .case import data_folder
from .columns import read_columns
from .profile import inspect
from .record import CONTACT_NAMES, CONTACTS, PAIRS, Record, Setting, header_lines, parse_header, read_record, summary_row
from .style import (BLACK, BLUE, CONTACT_LINES, DASH_DOT, DASHED, DOTTED, GREEN, GREY, ORANGE, PAGE, PURPLE, RED,
                    SERIES, Line, ldbench_style)

ENVELOPE_ROWS = 20_000     # longer runs are drawn as bands
BINS = 700                 # of a band
MM, KN, DEG = 1e3, 1e-3, 180/np.pi


# What is drawn ----------------------------------------------------------------------------

@dataclass(frozen=True)
class Curve:
    columns: tuple[str, ...]      # added up
    label: str
    line: Line

    def values(self, record: Record) -> np.ndarray:
        return sum(record.values(column) for column in self.columns)


@dataclass(frozen=True)
class Panel:
    label: str
    unit: str
    scale: float                  # from SI to the unit
    curves: tuple[Curve, ...]


@dataclass(frozen=True)
class Page:
    title: str
    panels: tuple[Panel, ...]
    note: str | Callable[[Record], str] = ""


@dataclass(frozen=True)
class Window:
    """A stretch of time that a column of panels shows."""
    title: str
    start: float                  # [s]
    end: float                    # [s]
    milliseconds: bool = False
    band: bool = False            # smallest and largest value, not the curve

    @property
    def scale(self) -> float:
        return 1e3 if self.milliseconds else 1.0

    def rows(self, record: Record) -> slice:
        """The rows inside and one more at either side."""
        t = record.time
        return slice(max(np.searchsorted(t, self.start) - 1, 0), np.searchsorted(t, self.end, "right") + 1)


def contact_curves(quantity: str, *contacts: str) -> tuple[Curve, ...]:
    return tuple(Curve((f"{quantity}_{c}",), CONTACT_NAMES[c], CONTACT_LINES[c]) for c in contacts)


def single(column: str, label: str, unit: str, scale: float = 1.0) -> Panel:
    return Panel(label, unit, scale, (Curve((column,), label, Line(BLACK)),))


def by_side(quantity: str, label: str, unit: str, scale: float) -> tuple[Panel, ...]:
    """Left and right wheel, each with tread and flange."""
    return (Panel(f"{label}, left wheel", unit, scale, contact_curves(quantity, "LT", "LF")),
            Panel(f"{label}, right wheel", unit, scale, contact_curves(quantity, "RT", "RF")))


def by_part(quantity: str, label: str, unit: str, scale: float) -> tuple[Panel, ...]:
    """Treads and flanges, each left and right."""
    return (Panel(f"{label}, treads", unit, scale, contact_curves(quantity, "LT", "RT")),
            Panel(f"{label}, flanges", unit, scale, contact_curves(quantity, "LF", "RF")))


IMPULSES = Page("impulses of impacts, and energy lost", (
    *by_side("P", "impulses so far", "kN·s", 1e-3), single("E_lost", "energy lost so far", "J")),
    "rigid contacts: forces that last are on the pages of forces, impacts on this one")


def constant_energies(record: Record) -> str:
    forward, pitch = (record.values(column)[0] for column in ("KE_long", "KE_pitch"))
    return (f"constant and not drawn: kinetic energy of forward motion {forward:.3f} J and of pitch {pitch:.3f} J; "
            "drift: total energy − work of the lateral force − total energy at the start")


PAGES = (
    Page("displacements", (
        single("Y", "lateral Y", "mm", MM), single("Z", "vertical Z", "mm", MM),
        single("roll", "roll Φ", "mrad", 1e3))),
    Page("velocities", (
        single("vY", "lateral dY/dt", "m/s"), single("vZ", "vertical dZ/dt", "m/s"),
        single("roll_rate", "roll dΦ/dt", "mrad/s", 1e3))),
    Page("accelerations", (
        single("aY", "lateral", "m/s²"), single("aZ", "vertical", "m/s²"), single("roll_acc", "roll", "rad/s²"))),
    Page("contact angles and rolling radii",
         by_part("angle", "angle", "°", DEG) + by_part("radius", "radius", "mm", MM),
         "angle of the contact normal to the vertical, positive towards the flange"),
    Page("normal forces", by_side("N", "normal force", "kN", KN)),
    Page("vertical forces", by_side("Fz", "vertical force", "kN", KN), "of the rail on the wheel, up positive"),
    Page("lateral forces", by_side("Fy", "lateral force", "kN", KN), "of the rail on the wheel, left positive"),
    Page("contact positions, lateral",
         tuple(Panel(f"y, {CONTACT_NAMES[c]}", "mm", MM, contact_curves("y", c)) for c in CONTACTS),
         "from the track centreline, left positive"),
    Page("contact positions, vertical", by_part("z", "z", "mm", MM), "from the top of the rails, up positive"),
    Page("energy balance", (
        Panel("kinetic", "J", 1.0, (
            Curve(("KE_lat",), "lateral", Line(BLACK)), Curve(("KE_vert",), "vertical", Line(GREEN, DASHED)),
            Curve(("KE_roll",), "roll", Line(PURPLE, DASH_DOT)))),
        Panel("potential", "J", 1.0, (
            Curve(("PE_grav",), "gravity", Line(BLACK)), Curve(("PE_load",), "vertical load", Line(GREEN, DASHED)),
            Curve(("PE_elastic_L",), "elastic left", Line(BLUE)),
            Curve(("PE_elastic_R",), "elastic right", Line(RED)))),
        Panel("sums", "J", 1.0, (
            Curve(("KE_lat", "KE_vert", "KE_roll"), "kinetic", Line(BLACK)),
            Curve(("PE_grav", "PE_load", "PE_elastic_L", "PE_elastic_R"), "potential", Line(GREEN, DASHED)),
            Curve(("W_ext",), "work of the lateral force", Line(ORANGE)))),
        Panel("drift", "J", 1.0, (
            Curve(("E_drift",), "total − work of the lateral force − total at the start", Line(BLACK)),))),
        constant_energies),
)


# Windows ----------------------------------------------------------------------------------

def first_episode(record: Record, contact: str) -> tuple[float, float] | None:
    """Times [s] at which a contact first closes and opens again, to the spacing of the rows."""
    if f"N_{contact}" not in record.columns:
        return None
    closed = record.values(f"N_{contact}") != 0
    if not closed.any():
        return None
    first = int(np.argmax(closed))
    opened = closed[first:].argmin()
    last = first + int(opened) if opened else len(closed) - 1
    return float(record.time[first]), float(record.time[last])


def windows(record: Record) -> list[Window]:
    """The stretches of time to show of a run."""
    t = record.time
    long = len(t) > ENVELOPE_ROWS
    found = [Window("until the last second: smallest to largest value, and mean", t[0], t[-1] - 1, band=True) if long
             else Window("whole run", t[0], t[-1])]
    episode = first_episode(record, "LF")
    impact = record.first_contact("LF")
    if impact is not None and record.formulation == "unilateral":
        episode = impact, impact + 0.01
    if episode:
        start, end = episode
        length = max(end - start, 4*(t[1] - t[0]))
        zoom = max(t[0], start - 0.6*length), min(t[-1], end + 1.2*length)
        found.append(Window("first contact of the left flange", *zoom, milliseconds=True))
    if long:
        found.append(Window("last second", t[-1] - 1, t[-1]))
    return found


def band(t: np.ndarray, x: np.ndarray, bins: int = BINS) -> tuple[np.ndarray, ...]:
    """Bin centres, smallest, largest and mean value of x in `bins` equal numbers of rows; nan where
    all are nan."""
    edges = np.linspace(0, len(t), min(bins, len(t)) + 1).astype(int)[:-1]
    known = ~np.isnan(x)
    count = np.add.reduceat(known.astype(float), edges)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.add.reduceat(np.where(known, x, 0.0), edges)/count
    low, high = np.fmin.reduceat(x, edges), np.fmax.reduceat(x, edges)
    ends = np.append(edges[1:], len(t)) - 1
    return (t[edges] + t[ends])/2, low, high, mean


# Pages ------------------------------------------------------------------------------------

def new_page(title: str, subtitle: str = "", caption: str = "") -> Figure:
    figure = Figure(figsize=PAGE)
    figure.text(0.055, 0.962, title, fontsize=12, weight="bold", va="top")
    figure.text(0.985, 0.959, subtitle, fontsize=8, va="top", ha="right", color="#404040")
    figure.text(0.055, 0.014, caption, fontsize=6.5, va="bottom", color="#404040", linespacing=1.4)
    return figure


def caption(record: Record) -> str:
    """The settings of a run."""
    scheme = record.setting("integrator", "scheme")
    if not scheme:
        return str(record.file)
    explicit = scheme == "newmark" and not record.setting("integrator", "beta")
    names = {"energy": "average acceleration with discrete gradient", "newmark": "explicit" if explicit else "Newmark"}
    order, tolerance = (record.setting("integrator", name) for name in ("order", "energy_tolerance"))
    cut = f" at most, cut where it changes the energy by more than {tolerance:.0e} J" if tolerance else ""
    in_flight = record.setting("output", "flight_interval")
    thinned = f", in flight {1e3*in_flight:.3g} ms" if in_flight else ""
    law = f"normal contact '{record.setting('contact', 'model')}'; {names.get(str(scheme), scheme)}, order {order:.0f}"
    if record.formulation == "bilateral":
        law = "rigid contacts, both wheels held on the rails; explicit along the path, order 4"
    if record.formulation == "unilateral":
        law = (f"rigid contacts that only push, restitution {record.setting('contact', 'restitution'):g}; from event to "
               "event, order 4")
    settings = (
        f"ldbench {record.version}: {law}, step {1e6*record.step:.3g} µs{cut}; "
        f"output every {1e3*float(record.setting('output', 'interval')):.3g} ms{thinned}; "
        f"axle {MM*record.axle_height:.3f} mm above the rails at equilibrium; Y left, Z up")
    two_sided = len(record.profiles) > 2
    profiles = "; ".join(f"{which} {Path(text).name if two_sided else text}" for which, text in record.profiles.items())
    if record.reconstruction:
        which = "some of the" if two_sided else "both"
        profiles += f"; {which} profiles are reconstructions, not the organisers' files"
    return f"{settings}\n{profiles}"


def time_page(record: Record, page: Page) -> Figure:
    """A page of panels against time; one column of panels per window."""
    figure = new_page(f"{record.heading}: {page.title}", record.title,
                      f"{page.note(record) if callable(page.note) else page.note}\n{caption(record)}".strip())
    shown = windows(record)
    widths = {1: [1], 2: [1.7, 1], 3: [1.5, 1, 1]}[len(shown)]
    axes = figure.subplots(len(page.panels), len(shown), sharex="col", squeeze=False, gridspec_kw={
        "width_ratios": widths, "left": 0.07, "right": 0.985, "top": 0.885, "bottom": 0.125,
        "hspace": 0.16 + 0.04*len(page.panels), "wspace": 0.1 + 0.05*len(shown)})
    for i, panel in enumerate(page.panels):
        for j, window in enumerate(shown):
            draw_panel(axes[i, j], record, panel, window, legend=j == 0)
            if j == 0:
                label_y(axes[i, 0], f"{panel.label} [{panel.unit}]")
                mark_events(axes[i, 0], record, window, labels=i == 0)
                for zoom in shown[1:2]:
                    axes[i, 0].axvspan(zoom.start, zoom.end, color="#E6E6E6", linewidth=0, zorder=0)
    for window, top, bottom in zip(shown, axes[0], axes[-1], strict=True):
        above_legend = len(page.panels[0].curves) > 1
        top.set_title(window.title, loc="left", fontsize=8, color="#404040", pad=12 if above_legend else 4)
        label_x(bottom, "time [ms]" if window.milliseconds else "time [s]")
        bottom.set_xlim(window.start*window.scale, window.end*window.scale)
    return figure


def label_x(ax: Axes, text: str, below: float = 19) -> None:
    """The label of the horizontal axis, at a fixed distance [pt]: matplotlib would measure all ticks first."""
    ax.set_xlabel(text)
    ax.xaxis.set_label_coords(0.5, 0.0, ax.transAxes + ScaledTranslation(0, -below/72, ax.figure.dpi_scale_trans))
    ax.xaxis.label.set_verticalalignment("center")


def label_y(ax: Axes, text: str, left: float = 40) -> None:
    ax.set_ylabel(text)
    ax.yaxis.set_label_coords(0.0, 0.5, ax.transAxes + ScaledTranslation(-left/72, 0, ax.figure.dpi_scale_trans))


def draw_panel(ax: Axes, record: Record, panel: Panel, window: Window, legend: bool = True) -> None:
    """One quantity in one window."""
    rows = window.rows(record)
    t = window.scale*record.time[rows]
    drawn = [(curve, panel.scale*curve.values(record)[rows]) for curve in panel.curves]
    for curve, x in drawn:
        style = curve.line.kwargs()
        if window.band:
            centre, low, high, x = band(t, x)
            ax.fill_between(centre, low, high, color=curve.line.color, alpha=0.35, linewidth=0)
            ax.plot(centre, x, label=curve.label, **style)
        else:
            marker = {"marker": ".", "markersize": 2.5} if len(t) < 60 else {}
            ax.plot(t, x, label=curve.label, **style, **marker)
    if legend and len(panel.curves) > 1:
        ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.1, columnspacing=1.2)
    if all(np.isnan(x).all() for _, x in drawn):
        ax.text(0.5, 0.5, "no contact", transform=ax.transAxes, ha="center", va="center", color="#606060", fontsize=7)
        ax.set_yticks([])
    else:
        widen_flat(ax)
        ax.yaxis.get_major_locator().set_params(nbins=6)
    ax.xaxis.get_major_locator().set_params(nbins=6)


def widen_flat(ax: Axes) -> None:
    """Axis limits for a constant: matplotlib would show its rounding."""
    low, high = ax.get_ylim()
    middle = (low + high)/2
    if high - low < 1e-9*max(abs(middle), 1e-3):
        half = max(0.05*abs(middle), 0.1)
        ax.set_ylim(middle - half, middle + half)


def key_events(record: Record) -> list[tuple[float, str]]:
    """The events to mark on the whole run."""
    found = []
    for contact, label in (("LF", "left flange"), ("RF", "right flange")):
        t = record.first_contact(contact)
        if t is not None:
            found.append((t, label))
    passage = summary_row(record)["t_first_centre"]
    if passage is not None:
        found.append((passage, "centre"))
    derailment = record.first("derailment")
    if derailment:
        found.append((derailment.time, "derailment"))
    return sorted(found)


def mark_events(ax: Axes, record: Record, window: Window, labels: bool) -> None:
    last = -np.inf
    for t, label in key_events(record):
        if not window.start <= t <= window.end:
            continue
        ax.axvline(window.scale*t, color=GREY, linewidth=0.6, linestyle=":", zorder=1)
        apart = (t - last)/(window.end - window.start)
        if labels and apart > 0.02:
            ax.annotate(label, (window.scale*t, 0.97), xycoords=("data", "axes fraction"), xytext=(-1, 0),
                        textcoords="offset points", rotation=90, ha="right", va="top", fontsize=5.5, color="#505050",
                        bbox={"facecolor": "white", "alpha": 0.7, "linewidth": 0, "pad": 0.5})
            last = t


def phase_page(record: Record) -> Figure:
    """Velocity against displacement of the three degrees of freedom."""
    t = record.time
    stretches: list[tuple[str, slice]] = [("whole run", slice(None))]
    if len(t) > ENVELOPE_ROWS:
        contact = first_episode(record, "LF") or (t[0], t[0])
        early = min(contact[1] + 1.0, t[-1])
        stretches = [(f"first {early:.2f} s", slice(0, np.searchsorted(t, early))),
                     ("last second", slice(np.searchsorted(t, t[-1] - 1), None))]
    figure = new_page(f"{record.heading}: phase portrait", record.title, caption(record))
    axes = figure.subplots(len(stretches), 3, squeeze=False, gridspec_kw={
        "left": 0.065, "right": 0.985, "top": 0.885, "bottom": 0.135, "hspace": 0.3, "wspace": 0.24})
    for row, (title, rows) in zip(axes, stretches, strict=True):
        row[0].set_title(title, loc="left", color="#404040")
        for ax, (q, v, x_label, y_label, x_scale, y_scale) in zip(row, (
                ("Y", "vY", "Y [mm]", "dY/dt [m/s]", MM, 1.0), ("Z", "vZ", "Z [mm]", "dZ/dt [m/s]", MM, 1.0),
                ("roll", "roll_rate", "Φ [mrad]", "dΦ/dt [mrad/s]", 1e3, 1e3)), strict=True):
            x, y = x_scale*record.values(q)[rows], y_scale*record.values(v)[rows]
            ax.plot(x, y, color=BLACK, linewidth=0.6)
            ax.plot(x[:1], y[:1], "o", color=GREEN, markersize=5, label="start")
            for contact, marker in (("LF", "<"), ("RF", ">")):
                first = record.first_contact(contact)
                if first is not None and t[rows][0] <= first <= t[rows][-1]:
                    k = np.searchsorted(t[rows], first)
                    ax.plot(x[k:k + 1], y[k:k + 1], marker, color=CONTACT_LINES[contact].color, markersize=6,
                            markeredgecolor=BLACK, markeredgewidth=0.4, linestyle="none",
                            label=f"{CONTACT_NAMES[contact]} first touches")
            ax.plot(x[-1:], y[-1:], "s", color=PURPLE, markersize=5, label="end")
            ax.margins(0.04)
            label_x(ax, x_label)
            label_y(ax, y_label)
        row[2].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.1, columnspacing=1.0)
    return figure


# Cross-sections ---------------------------------------------------------------------------

@dataclass(frozen=True)
class Section:
    """The left wheel in the frame of the wheelset, origin at the axle centre, and the left rail in
    the frame of the track; each an array of points (n, 2) [m], Y left and Z up. Of the right side the
    mirror images, None: as the left one."""
    wheel: np.ndarray
    rail: np.ndarray
    right_wheel: np.ndarray | None = None
    right_rail: np.ndarray | None = None

    def wheel_at(self, y: float, z: float, roll: float, right: bool = False) -> np.ndarray:
        """The wheel's points in the track frame, with the axle centre at (y, z) [m]."""
        points = self.mirrored(self.wheel, self.right_wheel) if right else self.wheel
        c, s = np.cos(roll), np.sin(roll)
        return points @ np.array([[c, s], [-s, c]]) + [y, z]

    def rail_at(self, right: bool = False) -> np.ndarray:
        return self.mirrored(self.rail, self.right_rail) if right else self.rail

    @staticmethod
    def mirrored(left: np.ndarray, right: np.ndarray | None) -> np.ndarray:
        return (left if right is None else right)*[-1, 1]


def read_profile(path: str | Path, kind: str, settings: Mapping[str, Setting]) -> np.ndarray:
    """The points of a profile file of any format, (n, 2) [m], as the core takes them; `settings` are those of &profiles.
    Raises Error where a run would."""
    flip, unit = (str(settings.get(f"{kind}_{what}") or "auto") for what in ("flip", "unit"))
    return 1e-3*inspect(path, kind, flip=flip, unit=unit).points


def find_profile(record: Record, which: str, right: bool = False) -> Path | None:
    """The profile file of a run: relative to here, to the column file, or a shipped one."""
    name = record.setting("profiles", f"{which}_profile")
    if right:
        name = record.setting("profiles", f"{which}_profile_right") or name
    folders = (Path(), record.file.parent, record.file.parent.parent, data_folder())
    return next((folder/str(name) for folder in folders if (folder/str(name)).is_file()), None) if name else None


def section(record: Record) -> Section | None:
    """Wheel and rail of a run, placed as the program places them; None if a file is missing."""
    left, right = side_section(record), (None, None)
    if any(record.setting("profiles", f"{which}_profile_right") for which in ("wheel", "rail")):
        right = side_section(record, right=True)
    return Section(*left, *right) if left and right else None


def side_section(record: Record, right: bool = False) -> tuple[np.ndarray, np.ndarray] | None:
    """Wheel and rail of a side, as on the left."""
    wheel_file, rail_file = (find_profile(record, which, right) for which in ("wheel", "rail"))
    if not (wheel_file and rail_file) or np.isnan(record.axle_height):
        return None
    files = record.settings.get("profiles", {})
    try:
        rail, wheel = read_profile(rail_file, "rail", files), read_profile(wheel_file, "wheel", files)
    except Error:
        return None
    rail = place_rail(rail, float(record.setting("track", "gauge")),
                      float(record.setting("track", "gauge_depth")))
    wheel = wheel + [float(record.setting("wheelset", "back_to_back"))/2, 0.0]
    tread, side = ("RT", -1) if right else ("LT", 1)
    touching = np.flatnonzero(~np.isnan(record.values(f"y_{tread}")))
    if not touching.size:
        return None
    # The columns tell where a point of the tread is, seen from the axle centre.
    k = touching[0]
    y, z, roll = pose(record, k)
    dy = side*(record.values(f"y_{tread}")[k] - y)
    dz = record.values(f"z_{tread}")[k] - z
    c, s = np.cos(side*roll), np.sin(side*roll)
    along, across = c*dy + s*dz, c*dz - s*dy
    order = np.argsort(wheel[:, 0], kind="stable")
    wheel[:, 1] += across - np.interp(along, wheel[order, 0], wheel[order, 1])
    return wheel, rail


def place_rail(points: np.ndarray, gauge: float, depth: float) -> np.ndarray:
    """The left rail with its top at z = 0 and its gauge side, `depth` below, at half the gauge."""
    points = points - [0.0, points[:, 1].max()]
    above = points[:, 1] > -depth
    i = np.flatnonzero(above[1:] != above[:-1])
    share = (-depth - points[i, 1])/(points[i + 1, 1] - points[i, 1])
    gauge_side = (points[i, 0] + share*(points[i + 1, 0] - points[i, 0])).min()
    return points + [gauge/2 - gauge_side, 0.0]


def instants(record: Record) -> list[tuple[str, int]]:
    """Rows worth a picture: peak of the first contact of each flange, or the hardest, and the end."""
    found = []
    for contact in ("LF", "RF"):
        episode = first_episode(record, contact)
        if episode:
            rows = slice(*np.searchsorted(record.time, episode) + [0, 1])
            k = rows.start + int(np.argmax(record.values(f"N_{contact}")[rows]))
            found.append((f"first contact of the {CONTACT_NAMES[contact]}, at its peak", k))
    if first_episode(record, "RF") is None and found:
        found.append(("hardest contact of the left flange", int(np.argmax(record.values("N_LF")))))
    found.append(("end", len(record.time) - 1))
    return found


def section_page(record: Record) -> Figure | None:
    """Wheels on rails with contact points and forces: left rail, whole wheelset, right rail."""
    placed = section(record)
    if placed is None:
        return None
    chosen = instants(record)
    figure = new_page(f"{record.heading}: cross-sections", record.title,
                      "seen in the direction of travel, left is left; arrows: force of the rail on the wheel, "
                      f"the longest of a picture is 40 mm\n{caption(record)}")
    axes = figure.subplots(3, 3, squeeze=False, gridspec_kw={
        "left": 0.045, "right": 0.985, "top": 0.885, "bottom": 0.125, "hspace": 0.32, "wspace": 0.12,
        "width_ratios": [1, 1.05, 1]})
    for ax in axes[len(chosen):].ravel():
        ax.set_visible(False)
    for (label, k), (left, whole, right) in zip(chosen, axes, strict=False):
        draw_detail(left, record, placed, k, right=False)
        draw_wheelset(whole, record, placed, k)
        draw_detail(right, record, placed, k, right=True)
        left.set_title(f"t = {record.time[k]:.4f} s: {label}", loc="left", color="#404040")
    return figure


RAIL_GREY, WHEEL_GREY = "#D0D0D0", "#F2F2F2"


def draw_detail(ax: Axes, record: Record, placed: Section, k: int, right: bool) -> None:
    """One rail head with its wheel, contact points and force arrows at row k."""
    wheel = placed.wheel_at(*pose(record, k), right=right)
    rail = placed.rail_at(right)
    ax.add_artist(Polygon(MM*rail, facecolor=RAIL_GREY, edgecolor=BLACK, linewidth=0.7))
    ax.plot(MM*wheel[:, 0], MM*wheel[:, 1], color=BLACK, linewidth=0.9)
    contacts = ("RT", "RF") if right else ("LT", "LF")
    longest = max(record.values(f"N_{c}")[k] for c in CONTACTS) or 1.0
    words = []
    for c in contacts:
        N = record.values(f"N_{c}")[k]
        if N <= 0:
            continue
        x, z = MM*record.values(f"y_{c}")[k], MM*record.values(f"z_{c}")[k]
        arrow = 40/longest*np.array([record.values(f"Fy_{c}")[k], record.values(f"Fz_{c}")[k]])
        color = CONTACT_LINES[c].color
        ax.quiver([x], [z], [arrow[0]], [arrow[1]], angles="xy", scale_units="xy", scale=1, color=color, width=0.008,
                  zorder=4)
        ax.plot([x], [z], "o", color=color, markersize=3.5, markeredgecolor=BLACK, markeredgewidth=0.4, zorder=5)
        words.append(f"{CONTACT_NAMES[c]}: {KN*N:.1f} kN at {DEG*record.values(f'angle_{c}')[k]:.1f}°")
    ax.text(0.02 if not right else 0.98, 0.96, "\n".join(words) or "no contact", transform=ax.transAxes, va="top",
            ha="left" if not right else "right", fontsize=6.5)
    middle = -755 if right else 755
    ax.set(xlim=(middle + 92, middle - 92), ylim=(-44, 62))
    ax.set_aspect("equal")
    ax.tick_params(labelsize=6)
    label_x(ax, "y [mm]", below=16)


def pose(record: Record, k: int) -> tuple[float, float, float]:
    """Axle centre and roll angle in the track frame at row k [m, m, rad]."""
    return (record.values("Y")[k], record.axle_height + record.values("Z")[k], record.axle_roll + record.values("roll")[k])


def draw_wheelset(ax: Axes, record: Record, placed: Section, k: int) -> None:
    """The whole wheelset on its rails at row k; axle and wheel bodies are sketched."""
    y, z, roll = pose(record, k)
    for right in (False, True):
        rail = placed.rail_at(right)
        foot = np.array([[rail[-1, 0], -0.12], [rail[0, 0], -0.12]])
        ax.add_artist(Polygon(np.vstack([rail, foot]), facecolor=RAIL_GREY, edgecolor=BLACK, linewidth=0.5))
        wheel = placed.wheel if placed.right_wheel is None or not right else placed.right_wheel
        profile = Section(np.vstack([wheel, wheel[::-1]*[1, -1]]), placed.rail)
        ax.add_artist(Polygon(profile.wheel_at(y, z, roll, right), facecolor=WHEEL_GREY, edgecolor=BLACK,
                              linewidth=0.6))
    half = placed.wheel[:, 0].min()
    axle = Section(np.array([[-half, -0.08], [half, -0.08], [half, 0.08], [-half, 0.08]]), placed.rail)
    ax.add_artist(Polygon(axle.wheel_at(y, z, roll), facecolor=WHEEL_GREY, edgecolor=BLACK, linewidth=0.6))
    ax.plot([y], [z], "+", color=BLACK, markersize=6, markeredgewidth=0.8)
    ax.set(xlim=(1.15, -1.15), ylim=(-0.14, 1.42))
    ax.set_aspect("equal")
    ax.tick_params(labelsize=6)
    ax.grid(False)
    ax.text(0.5, 0.97, f"Y {MM*y:.2f} mm, Z {MM*(z - record.axle_height):.2f} mm, Φ {1e3*roll:.2f} mrad",
            transform=ax.transAxes, ha="center", va="top", fontsize=6.5,
            bbox={"facecolor": "white", "alpha": 0.8, "linewidth": 0, "pad": 0.5})
    label_x(ax, "y [m]", below=15)


# Contact geometry -------------------------------------------------------------------------

def geometry_page(path: Path) -> Figure:
    """The geometry functions of a pair, from the file that `&output geometry_file` asks for."""
    facts = parse_header(header_lines(path))
    record = Record(file=path, columns=read_columns(path), **facts)
    y = MM*record.values("Y")
    pair = PAIRS.get(record.name.partition("_")[2], record.name)
    figure = new_page(f"Contact geometry, {pair}", "rigid wheelset standing on both rails",
                      f"dotted: rigid-axle clearance, {clearance_words(record)} mm; conicity: equivalent, by "
                      f"harmonic linearisation, for the amplitude |Y|\n{caption(record).splitlines()[-1]}")
    axes = figure.subplots(2, 4, gridspec_kw={
        "left": 0.062, "right": 0.985, "top": 0.885, "bottom": 0.125, "hspace": 0.28, "wspace": 0.4})
    left, right = CONTACT_LINES["LT"], CONTACT_LINES["RT"]

    def both(ax: Axes, quantity: str, label: str, scale: float, sign: float = 1.0) -> None:
        ax.plot(y, scale*record.values(f"{quantity}_L"), label="left", **left.kwargs())
        ax.plot(y, sign*scale*record.values(f"{quantity}_R"), label="right", **right.kwargs())
        label_y(ax, label)
        ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.1)

    def one(ax: Axes, column: str, label: str, scale: float) -> None:
        ax.plot(y, scale*record.values(column), color=BLACK, linewidth=0.9)
        label_y(ax, label)

    both(axes[0, 0], "angle", "contact angle [°]", DEG)
    both(axes[0, 1], "radius", "rolling radius [mm]", MM)
    one(axes[0, 2], "delta_r", "Δr = left − right [mm]", MM)
    one(axes[0, 3], "conicity", "equivalent conicity", 1.0)
    axes[0, 3].set_yscale("log")
    axes[0, 3].yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes[0, 3].set_ylim(bottom=0.02)
    axes[0, 3].yaxis.set_major_formatter(FormatStrFormatter("%g"))
    axes[0, 3].yaxis.set_minor_locator(NullLocator())
    both(axes[1, 0], "y", "contact position, outward |y| [mm]", MM, -1.0)
    both(axes[1, 1], "z", "contact position z [mm]", MM)
    one(axes[1, 2], "roll", "roll Φ [mrad]", 1e3)
    one(axes[1, 3], "Z", "height Z [mm]", MM)
    for ax in axes.ravel():
        label_x(ax, "lateral displacement Y [mm]")
        for reach in (-record.clearance_right, record.clearance):
            ax.axvline(MM*reach, color=GREY, linewidth=0.6, linestyle=":")
    return figure


def clearance_words(record: Record) -> str:
    """'2 × 10.18', or of either side [mm]."""
    if record.clearance == record.clearance_right:
        return f"2 × {MM*record.clearance:.2f}"
    return f"left {MM*record.clearance:.2f}, right {MM*record.clearance_right:.2f}"


# Summary ----------------------------------------------------------------------------------

def scaled(scale: float, digits: int) -> Callable[[object], str]:
    return lambda x: f"{scale*float(x):.{digits}f}"


SUMMARY_LINES: tuple[tuple[str, str, Callable[[object], str]], ...] = (
    ("first contact of the left flange [s]", "t_first_LF", scaled(1, 6)),
    ("first contact of the right flange [s]", "t_first_RF", scaled(1, 6)),
    ("first passage of the centre [s]", "t_first_centre", scaled(1, 6)),
    ("return to the centre after both flanges [s]", "t_return", scaled(1, 6)),
    ("derailment [s]", "t_derailment", scaled(1, 6)),
    ("lateral force at derailment [kN]", "F_derailment", scaled(KN, 3)),
    ("Y, largest [mm]", "Y_max", scaled(MM, 4)),
    ("Y, smallest [mm]", "Y_min", scaled(MM, 4)),
    ("Z, largest [mm]", "Z_max", scaled(MM, 4)),
    ("Z, smallest [mm]", "Z_min", scaled(MM, 4)),
    ("Φ, largest [mrad]", "roll_max", scaled(1e3, 4)),
    ("Φ, smallest [mrad]", "roll_min", scaled(1e3, 4)),
    ("peak N, left tread [kN]", "N_max_LT", scaled(KN, 2)),
    ("peak N, left flange [kN]", "N_max_LF", scaled(KN, 2)),
    ("peak N, right tread [kN]", "N_max_RT", scaled(KN, 2)),
    ("peak N, right flange [kN]", "N_max_RF", scaled(KN, 2)),
    ("contacts of the left flange", "left_flange_contacts", str),
    ("contacts of the right flange", "right_flange_contacts", str),
    ("lift-offs of the left wheel", "left_lift_offs", str),
    ("lift-offs of the right wheel", "right_lift_offs", str),
    ("largest energy drift [J]", "E_drift_max", lambda x: f"{float(x):.1e}"),
    ("the same over initial kinetic energy or work", "E_drift_relative", lambda x: f"{float(x):.1e}"),
    ("time step [µs]", "dt", scaled(1e6, 0)),
    ("end of the run [s]", "t_end", scaled(1, 4)),
)


def summary_page(rows: Sequence[dict[str, object]], note: str = "") -> Figure:
    """All runs in one table."""
    figure = new_page("LD benchmark: summary of all runs", "single wheelset without friction", note)
    ax = figure.add_axes((0.055, 0.10, 0.93, 0.80))
    ax.set_axis_off()
    names = [str(row["case"]) for row in rows]
    cells = [[text if (x := row.get(key)) is not None and (text := write(x)) != "nan" else "–" for row in rows]
             for _, key, write in SUMMARY_LINES]
    share = 0.24
    table = ax.table(cells, rowLabels=None, colLabels=names, cellLoc="right", loc="center",
                     bbox=(share, 0.0, 1 - share, 1.0))
    labels = ax.table([[label] for label, _, _ in SUMMARY_LINES], colLabels=[""], cellLoc="left",
                      bbox=(0.0, 0.0, share, 1.0))
    for part in (table, labels):
        part.auto_set_font_size(False)
        part.set_fontsize(7)
        for (i, _), cell in part.get_celld().items():
            cell.set(linewidth=0, facecolor="#F0F0F0" if i and i % 2 == 0 else "white")
            cell.PAD = 0.03
            if i == 0:
                cell.set_text_props(weight="bold")
    return figure


SUMMARY_NOTE = (
    "Event times and peaks of forces lie within the steps; Y, Z and Φ are those of the rows. –: did not happen.  aw: "
    "actual wheel and rail profiles, sw: simplified.\n"
    "In all plots: Y left, Z up, Φ lifts the left wheel; Z and Φ from static equilibrium at Y = 0; left blue, right "
    "red; tread dark and solid, flange light and dashed; grey: the stretch of time enlarged beside it.")


# Figures of the abstract ------------------------------------------------------------------

def small_figure(width: float = 6.7, height: float = 2.4) -> Figure:
    return Figure(figsize=(width, height))


def by_pair(records: Sequence[Record]) -> dict[str, list[Record]]:
    """Runs by pair of profiles, 'aw' and 'sw'."""
    return {pair: [run for run in records if run.name.endswith(f"_{pair}")] for pair in PAIRS}


def motion_figure(records: Sequence[Record]) -> Figure:
    """Lateral displacement of exercises 1 to 4 against the distance that the first velocity would cover."""
    figure = small_figure()
    axes = figure.subplots(1, 2, gridspec_kw={"left": 0.085, "right": 0.99, "top": 0.9, "bottom": 0.2, "wspace": 0.2})
    for ax, (pair, runs) in zip(axes, by_pair(records).items(), strict=True):
        for run, line in zip([r for r in runs if r.exercise in range(1, 5)], SERIES, strict=False):
            speed = run.values("vY")[0]
            ax.plot(MM*speed*run.time, MM*run.values("Y"), label=f"{speed:g} m/s", **line.kwargs())
        ax.set_title(PAIRS[pair], loc="left", fontsize=8)
        label_x(ax, "initial velocity × time [mm]")
    label_y(axes[0], "Y [mm]", left=30)
    axes[1].legend(loc="upper right", fontsize=6.5)
    return figure


def impact_figure(records: Sequence[Record]) -> Figure:
    """First contact of the left flange: normal force against time, its peak against velocity."""
    figure = small_figure()
    left, right = figure.subplots(1, 2, gridspec_kw={
        "left": 0.085, "right": 0.99, "top": 0.9, "bottom": 0.2, "wspace": 0.25, "width_ratios": [1.5, 1]})
    for (pair, runs), dashes, marker in zip(by_pair(records).items(), ("-", DASHED), "os", strict=True):
        speeds, peaks = [], []
        for run, line in zip([r for r in runs if r.exercise in range(1, 5)], SERIES, strict=False):
            episode = first_episode(run, "LF")
            if episode is None:
                continue
            rows = slice(*np.searchsorted(run.time, episode) + [0, 1])
            t, N = 1e3*(run.time[rows] - episode[0]), KN*run.values("N_LF")[rows]
            left.plot(t, N, color=line.color, linestyle=dashes, linewidth=0.9,
                      label=f"{run.values('vY')[0]:g} m/s" if dashes == "-" else None)
            speeds.append(run.values("vY")[0])
            peaks.append(N.max())
        right.plot(speeds, peaks, marker, color=BLACK, markersize=4, label=PAIRS[pair],
                   markerfacecolor=BLACK if marker == "o" else "white")
        if pair == "aw" and speeds:
            v = np.array([min(speeds), max(speeds)])
            right.plot(v, peaks[0]*(v/speeds[0])**1.2, color=GREY, linewidth=0.8, linestyle=DOTTED, label="slope 6/5")
    left.set(yscale="log", ylim=(10, None))
    left.set_title("solid: actual, dashed: simplified profiles", loc="left", fontsize=8)
    left.legend(loc="upper right", fontsize=6.5)
    right.set(xscale="log", yscale="log")
    right.margins(0.08)
    right.legend(loc="lower right", fontsize=6.5)
    label_x(left, "time since the flange touched [ms]")
    label_y(left, "N of the left flange [kN]", left=30)
    label_x(right, "lateral velocity [m/s]")
    label_y(right, "first peak [kN]", left=30)
    for axis in (left.yaxis, right.yaxis, right.xaxis):
        axis.set_major_formatter(FormatStrFormatter("%g"))
        axis.set_minor_formatter(NullFormatter())
    return figure


def derailment_figure(records: Sequence[Record]) -> Figure | None:
    """Exercise 5: vertical forces until the last second, band and mean, against the lateral force."""
    if not any(run.exercise == 5 and run.time[-1] > 2 for run in records):
        return None
    figure = small_figure()
    axes = figure.subplots(1, 2, sharey=True, gridspec_kw={
        "left": 0.085, "right": 0.985, "top": 0.9, "bottom": 0.2, "wspace": 0.08})
    for ax, (pair, runs) in zip(axes, by_pair(records).items(), strict=True):
        for run in (r for r in runs if r.exercise == 5 and r.time[-1] > 2):
            rows = run.time < run.time[-1] - 1
            force = KN*run.values("F_ext")[rows]
            for contact in ("LF", "LT", "RT"):
                x, low, high, mean = band(force, KN*run.values(f"Fz_{contact}")[rows], BINS//2)
                line = CONTACT_LINES[contact]
                ax.fill_between(x, low, high, color=line.color, alpha=0.25, linewidth=0)
                ax.plot(x, mean, label=CONTACT_NAMES[contact], **line.kwargs())
        ax.set_title(PAIRS[pair], loc="left", fontsize=8)
        label_x(ax, "lateral force [kN]")
    label_y(axes[0], "vertical force [kN]", left=30)
    drawn = next(ax for ax in axes[::-1] if ax.get_lines())
    drawn.legend(loc="upper center", ncols=3, fontsize=6.5)
    return figure


# The document -----------------------------------------------------------------------------

@dataclass(frozen=True)
class Part:
    """Pages under one bookmark."""
    title: str
    file: Path
    pages: tuple[str, ...]        # their titles
    summary: dict[str, object] | None = None


def case_figures(record: Record) -> Iterable[tuple[str, Figure]]:
    for page in (*PAGES, IMPULSES) if "E_lost" in record.columns else PAGES:
        yield page.title, time_page(record, page)
    yield "phase portrait", phase_page(record)
    picture = section_page(record)
    if picture is not None:
        yield "cross-sections", picture


def save_pages(path: Path, figures: Iterable[tuple[str, Figure]]) -> tuple[str, ...]:
    titles = []
    with PdfPages(path, metadata={"CreationDate": None}) as pdf:
        for title, figure in figures:
            pdf.savefig(figure)
            titles.append(title)
    return tuple(titles)


def case_part(source: Path, target: Path) -> Part:
    """All pages of one run."""
    record = read_record(source)
    with ldbench_style():
        return Part(record.heading, target, save_pages(target, case_figures(record)), summary_row(record))


def geometry_part(source: Path, target: Path) -> Part:
    with ldbench_style():
        figure = geometry_page(source)
        return Part(figure.texts[0].get_text(), target, save_pages(target, [("geometry", figure)]))


def make_plots(files: Sequence[Path], target: Path, geometry: Sequence[Path] = (), jobs: int | None = None,
               done: Callable[[], None] = lambda: None, further: Callable[[Path], Part] | None = None) -> int:
    """Write the PDF of plots of column files; the number of its pages.  `done` is called after
    each file; `further` makes a last part in a file."""
    check_written([target], [*files, *geometry])
    with tempfile.TemporaryDirectory() as scratch, ProcessPoolExecutor(jobs or usable_cores()) as pool:
        # The longest first; the order of the document is that of the files.
        work = [(case_part, f) for f in files] + [(geometry_part, f) for f in geometry]
        order = sorted(range(len(work)), key=lambda k: -work[k][1].stat().st_size)
        tasks = {k: pool.submit(work[k][0], work[k][1], Path(scratch)/f"{k}.pdf") for k in order}
        for task in tasks.values():
            task.add_done_callback(lambda _: done())
        try:
            parts = [tasks[k].result() for k in range(len(work))]
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
        runs, shapes = parts[:len(files)], parts[len(files):]
        with ldbench_style():
            first = Path(scratch)/"summary.pdf"
            figure = summary_page([part.summary for part in runs], SUMMARY_NOTE)
            parts = [Part("Summary", first, save_pages(first, [("summary", figure)])), *shapes, *runs]
        if further:
            parts.append(further(Path(scratch)/"further.pdf"))
        return bind(parts, target)


def bind(parts: Sequence[Part], target: Path, title: str = "ldbench: plots of all results") -> int:
    """Put parts together with bookmarks."""
    writer = PdfWriter()
    for part in parts:
        start = len(writer.pages)
        writer.append(PdfReader(part.file), import_outline=False)
        chapter = writer.add_outline_item(title=part.title, page_number=start)
        if len(part.pages) > 1:
            for k, name in enumerate(part.pages):
                writer.add_outline_item(title=name, page_number=start + k, parent=chapter)
    writer.add_metadata({"/Title": title})
    writer.compress_identical_objects()
    with complete(target) as scratch:
        writer.write(scratch)
    return len(writer.pages)
