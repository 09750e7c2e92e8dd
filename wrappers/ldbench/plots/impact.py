"""The page of impacts: cross-sections, the first contact of the left flange enlarged, and a table of impacts."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from ..geometry.pressures import patch_history
from ..results.contact_intervals import ContactInterval
from ..results.derived import PARTS, exchange
from ..results.events import FLANGE_ANGLE
from ..results.quantities import CONTACT_NAMES, DEG, KN, MM
from ..results.run_data import RunData
from .frame import caption, label_x, label_y, new_page
from .sections import draw_detail, instants, placed_outlines
from .series import CLOSE, Page
from .stretches import Window, first_impact
from .style import BLACK, CONTACT_LINES
from .tables import draw_table
from .times import BOTTOM, LEFT, RIGHT, TOP, draw_columns

MOST = 6            # impacts in the table
HARDEST = "hardest contact of the left flange"
SECTIONS = 2        # instants with a picture
SOLVED = 9          # instants of the first contact at which its patch is solved
HEADS = ("impact", "begins at", "lasts", "peak N", "at angle", "impulse ∫N dt", "elastic, largest",
         "lateral KE", "vertical KE", "roll KE")
EDGES = LEFT - 0.02, 0.12, 0.175, 0.235, 0.31, 0.375, 0.475, 0.575, 0.71, 0.845, RIGHT      # of the table's columns
LINE = 0.0205       # height of the table's rows, over that of the page


@dataclass(frozen=True)
class Recomputed:
    """A part of a run that was computed again with more rows."""

    run: RunData            # whose time counts from `start`
    start: float            # [s]

    @property
    def window(self) -> Window:
        """The times of this part, in milliseconds of the whole run."""
        return Window("", 0.0, float(self.run.time[-1]), milliseconds=True, zero=-self.start)

    @property
    def words(self) -> str:
        """A note on the page."""
        return (f"computed again from the row at t = {self.start:.6f} s, with rows every "
                f"{1e6*self.run.number('output', 'interval'):.3g} µs; black dots: rows of the run")


def impact_page(run: RunData, first: Recomputed | None = None) -> Figure | None:
    """Cross-sections at the first impacts of flanges, the first one of the left flange over time, and the impacts of flanges
    in numbers; None where a run has none of these. `first`: the first contact, computed again."""
    window, placed = first_impact(run), placed_outlines(run)
    if window is None and placed is None:
        return None
    notes = ["cross-sections seen in the direction of travel, left is left, arrows: force of the rail on the wheel, the "
             "longest of an instant is 40 mm"] if placed else []
    if first is not None:
        notes.append(f"first contact of the left flange: {first.words}")
    figure = new_page(f"{run.heading}: impacts of flanges", run.header.title, f"{'; '.join(notes)}\n{caption(run)}".strip())
    if placed:
        shown = instants(run)[:SECTIONS]
        axes = figure.subplots(1, 2*SECTIONS, squeeze=False, gridspec_kw={
            "left": 0.03, "right": RIGHT, "top": 0.872, "bottom": 0.66, "wspace": 0.13})[0]
        for ax in axes[2*len(shown):]:
            ax.set_visible(False)
        for (label, k), left, right in zip(shown, axes[::2], axes[1::2], strict=False):
            draw_detail(left, run, placed, k, right=False)
            draw_detail(right, run, placed, k, right=True)
            figure.text(left.get_position().x0, 0.897, f"t = {run.time[k]:.4f} s: {label}", fontsize=8, color="#404040")
    if window is not None:
        draw_close(figure, run, first or window, 0.60, 0.33)
    draw_impacts(figure, run, 0.248)
    return figure


def hardest_page(run: RunData, hardest: Recomputed) -> Figure:
    """The hardest contact of the left flange, computed again with rows as close as it needs."""
    figure = new_page(f"{run.heading}: {HARDEST}", run.header.title, f"{hardest.words}\n{caption(run)}")
    draw_close(figure, run, hardest, TOP, BOTTOM, 3*SOLVED)
    return figure


def draw_close(figure: Figure, run: RunData, shown: Window | Recomputed, top: float, bottom: float, number: int = SOLVED) -> None:
    """The panels around an impact, between two heights of a page; its patch is solved at `number` instants."""
    fine, window = (shown.run, shown.window) if isinstance(shown, Recomputed) else (run, shown)
    page = Page("", CLOSE).of(fine)
    if page is None:
        return
    pressed = patch_history(fine, "LF", number)
    axes = figure.subplots(max(map(len, page.columns)), len(page.columns) + bool(pressed.size), sharex=True, squeeze=False,
                           gridspec_kw={"left": LEFT, "right": RIGHT, "top": top, "bottom": bottom, "hspace": 0.3, "wspace": 0.28})
    draw_columns(axes[:, :len(page.columns)], fine, page.columns, window, alone=False)
    if pressed.size:
        draw_patch(axes[:, -1], pressed, window)
    if isinstance(shown, Recomputed):
        rows = slice(*np.searchsorted(run.time, [shown.start, shown.start + fine.time[-1]]))
        axes[0, 0].plot(1e3*run.time[rows], KN*run.values("N_LF")[rows], ".", color=BLACK, markersize=3, zorder=6)


def draw_patch(axes: np.ndarray, pressed: np.ndarray, window: Window) -> None:
    """Largest pressure and area of the patches of the left flange; the approach at the largest pressure in words."""
    t = window.scale*(pressed[0] - window.zero)
    look = CONTACT_LINES["LF"].kwargs() | {"marker": "o", "markersize": 2.5}
    axes[0].plot(t, 1e-9*pressed[1], **look)
    axes[1].plot(t, 1e6*pressed[2], **look)
    hardest = int(pressed[1].argmax())
    axes[0].set_title(f"left flange, largest; approach {MM*pressed[3, hardest]:.3f} mm", fontsize=6.3, loc="right", pad=2.5)
    label_y(axes[0], "pressure [GPa]", left=26)
    label_y(axes[1], "patch area [mm²]", left=26)
    label_x(axes[1], "time [ms]" if window.milliseconds else "time [s]")
    for ax in axes:
        ax.set_ylim(bottom=0)
        ax.yaxis.get_major_locator().set_params(nbins=5)


def chosen_impacts(run: RunData) -> tuple[list[ContactInterval], int]:
    """The first impacts of flanges, and the number of all: of the steps of an elastic run, as the rows miss some."""
    found = run.impacts(("LF", "RF"))
    told = [run.count(f"{side} flange contact") for side in ("left", "right")]
    return found[:MOST], sum(n or 0 for n in told) if None not in told and run.formulation == "elastic" else len(found)


def table_rows(run: RunData, found: Sequence[ContactInterval]) -> list[list[str]]:
    """Numbers of impacts as the page shows them."""
    rows = []
    for one in found:
        rigid = one.duration == 0
        energies = exchange(run, one.start, one.end)
        row = [CONTACT_NAMES[one.contact] + ", root"*one.at_root, f"{one.start:.6f} s",
               "–" if rigid else f"{1e3*one.duration:.3f} ms",
               "–" if np.isnan(one.peak) else f"{KN*one.peak:.1f} kN", "–" if np.isnan(one.angle) else f"{DEG*one.angle:.1f}°",
               f"{KN*one.impulse:.4f} kN·s"]
        if energies is None:
            rows.append([*row, "–", "–", "–", "–"])
        else:
            rows.append([*row, f"{energies.elastic:.1f} J", *(
                f"{energies.before[part]:.1f} → {energies.after[part]:.1f} J" for part in PARTS)])
    return rows


def draw_impacts(figure: Figure, run: RunData, top: float) -> None:
    """The impacts of flanges in numbers, below the height `top`."""
    found, count = chosen_impacts(run)
    which = f"the first {MOST} of {count}" if count > MOST else "all"
    words = f"Impacts of flanges, {which}" if count else "No impact of a flange that begins and ends in the run"
    if any(one.at_root for one in found):
        words += f"; root: contact angle below {DEG*FLANGE_ANGLE:.0f}°"
    figure.text(LEFT - 0.02, top, words, fontsize=8, color="#404040", va="bottom")
    if count:
        rows = [list(HEADS), *table_rows(run, found)]
        draw_table(figure, (0.0, top - 0.0075 - LINE*len(rows), 1.0, LINE*len(rows)), rows, EDGES, pad=0.0, size=6.8,
                   band=lambda i: "")
