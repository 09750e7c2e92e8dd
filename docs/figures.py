"""Draw the figures of the documentation: `python docs/figures.py` writes docs/figures/*.svg.

The outlines are those of the program, the forces those of a run, so a figure cannot contradict them.
"""
from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

import ldbench
from ldbench.constants import MM
from ldbench.geometry.outlines import case_outlines, turned

FOLDER = Path(__file__).resolve().parent/"figures"
STEEL, RAIL, LINE, FORCE, PART, FRAME = "#e6e9ee", "#c9ced6", "#2b3440", "#c2410c", "#2563a8", "#15803d"
BELOW = -0.045          # where rails are cut off [m]
HEIGHT = 120.0          # of the wheels in the drawing of the frame [mm]


def frame_and_signs() -> None:
    """The track frame, the roll angle, the four contacts, and the forces at a flange."""
    case = ldbench.Case.exercise(2, "aw").replace(table_folder="", model="hertz")
    run = ldbench.run(case)
    row = run.data.iloc[int(run.data.N_LF.argmax())]
    figure, (whole, close) = plt.subplots(1, 2, figsize=(10.4, 3.5), width_ratios=(1.45, 1), layout="constrained")
    draw_frame(whole, case)
    draw_contact(close, case, row, run.results["axle_height"])
    figure.savefig(FOLDER/"frame.svg", metadata={"Date": None})
    plt.close(figure)


def draw_frame(axes: Axes, case: ldbench.Case) -> None:
    """The wheelset from behind, shortened: Y to the left of the reader, Z upwards, X away from the reader."""
    outlines = case_outlines(case)
    gap = 2*MM*np.abs(outlines.left.rail[:, 0]).min() - 520        # cut out of the axle

    def placed(points: np.ndarray, sign: int) -> tuple[np.ndarray, np.ndarray]:
        """Points of a side, drawn with Y to the left and nearer to the centre than they are."""
        return -sign*(MM*points[:, 0] - gap/2), MM*points[:, 1]

    for side, sign in outlines.sides:
        y, z = placed(side.rail, sign)
        order = np.argsort(y)
        axes.fill_between(y[order], z[order], MM*BELOW, color=RAIL, lw=0)
        axes.plot(y, z, color=LINE, lw=1)
        y, z = placed(side.wheel + [0, outlines.axle], sign)
        axes.fill(np.r_[y, y[-1], y[0]], np.r_[z, HEIGHT, HEIGHT], color=STEEL, lw=0)
        axes.plot(np.r_[y[0], y, y[-1]], np.r_[HEIGHT, z, HEIGHT], color=LINE, lw=1)
        for name, at, shift in (("T", 0.75, (-sign*20, -30)), ("F", 0.716, (sign*62, -26))):
            k = int(np.abs(np.abs(side.wheel[:, 0]) - at).argmin())
            spot = y[k], z[k]
            axes.annotate("LR"[sign < 0] + name, spot, (spot[0] + shift[0], spot[1] + shift[1]), color=PART, fontweight="bold",
                          ha="center", va="center", arrowprops={"arrowstyle": "-", "color": PART, "lw": 1})
            axes.plot(*spot, "o", color=PART, ms=4)
    inner = min(abs(placed(side.wheel, sign)[0]).min() for side, sign in outlines.sides)
    axes.fill_between([-inner, inner], 86, 104, color=STEEL, lw=0)
    axes.plot([-inner, inner], [86, 86], color=LINE, lw=1)
    axes.plot([-inner, inner], [104, 104], color=LINE, lw=1)
    arrow(axes, (0, 95), (-85, 95), FRAME)
    arrow(axes, (0, 95), (0, 180), FRAME)
    axes.plot(0, 95, "o", ms=12, mfc="white", mec=FRAME, mew=1.5)
    axes.plot(0, 95, "x", ms=7, mec=FRAME, mew=1.5)
    axes.text(-88, 108, "Y", color=FRAME, ha="center", fontsize=12, fontweight="bold")
    axes.text(12, 178, "Z", color=FRAME, va="center", fontsize=12, fontweight="bold")
    axes.text(14, 72, "X, forward", color=FRAME, ha="left", va="center", fontsize=10)
    turn = np.radians(np.linspace(128, 52, 40))
    axes.plot(112*np.cos(turn), 95 + 112*np.sin(turn), color=LINE, lw=1)
    axes.annotate("", (112*np.cos(turn[-1]), 95 + 112*np.sin(turn[-1])), (112*np.cos(turn[-4]), 95 + 112*np.sin(turn[-4])),
                  arrowprops={"arrowstyle": "-|>", "color": LINE, "lw": 1, "mutation_scale": 14})
    axes.text(0, 217, "roll > 0: the left wheel rises", ha="center", va="bottom", fontsize=10)
    axes.text(-260, 134, "left", ha="center", fontsize=10)
    axes.text(260, 134, "right", ha="center", fontsize=10)
    axes.plot([-330, 330], [0, 0], color=LINE, lw=0.7, ls=(0, (6, 4)))
    axes.text(0, -8, "top of rail", ha="center", va="top", fontsize=9)
    axes.text(0, -70, "The axle is drawn shorter and lower than it is.", ha="center", va="top", fontsize=9)
    axes.set(xlim=(-345, 345), ylim=(-95, 240), aspect="equal")
    axes.axis("off")
    axes.set_title("Track frame, seen from behind", fontsize=11)


def draw_contact(axes: Axes, case: ldbench.Case, row: Any, height: float) -> None:
    """The left wheel at the largest force of its flange, with the force and its components."""
    side = case_outlines(case).left
    rail, wheel = MM*side.rail, MM*turned(side.wheel, row.Y, height + row.Z, row.roll)
    order = np.argsort(rail[:, 0])
    axes.fill_between(-rail[order, 0], rail[order, 1], MM*BELOW, color=RAIL, lw=0)
    axes.plot(-rail[:, 0], rail[:, 1], color=LINE, lw=1)
    top = 34.0
    axes.fill(np.r_[-wheel[:, 0], -wheel[-1, 0], -wheel[0, 0]], np.r_[wheel[:, 1], top, top], color=STEEL, lw=0, alpha=0.8)
    axes.plot(-wheel[:, 0], wheel[:, 1], color=LINE, lw=1)
    spot = np.array([-MM*row.y_LF, MM*row.z_LF])
    force = 48*np.array([-row.Fy_LF, row.Fz_LF])/row.N_LF
    arrow(axes, spot, spot + force, FORCE)
    arrow(axes, spot, spot + [force[0], 0], FORCE, 1)
    arrow(axes, spot, spot + [0, force[1]], FORCE, 1)
    axes.plot(*spot, "o", color=PART, ms=5)
    axes.text(*(spot + force + [2, 1]), "N_LF", color=FORCE, fontweight="bold")
    axes.text(*(spot + [force[0] + 2, 0]), "Fy_LF < 0", color=FORCE, va="center")
    axes.text(*(spot + [-2, force[1] + 1]), "Fz_LF > 0", color=FORCE, ha="center")
    turn = np.linspace(np.pi/2, np.arctan2(force[1], force[0]), 30)
    axes.plot(spot[0] + 17*np.cos(turn), spot[1] + 17*np.sin(turn), color=PART, lw=1)
    axes.text(*(spot + [9.5, 19.5]), "angle_LF", color=PART, ha="left", va="bottom", fontsize=9)
    axes.annotate("(y_LF, z_LF)", spot, spot + [-30, -17], color=PART, fontsize=9, ha="center",
                  arrowprops={"arrowstyle": "-", "color": PART, "lw": 0.8})
    middle = spot[0]
    axes.set(xlim=(middle - 62, middle + 66), ylim=(MM*BELOW, 42), aspect="equal")
    axes.axis("off")
    axes.set_title("Contact force of the rail on the left flange", fontsize=11)


def arrow(axes: Axes, start: Any, end: Any, color: str, width: float = 2) -> None:
    axes.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "color": color, "lw": width, "mutation_scale": 12 + 2*width,
                                              "shrinkA": 0, "shrinkB": 0})


if __name__ == "__main__":
    plt.rcParams.update({"svg.hashsalt": "ldbench", "font.size": 10})
    FOLDER.mkdir(exist_ok=True)
    frame_and_signs()
