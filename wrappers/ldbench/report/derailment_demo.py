"""A demonstration of ensembles: peak flange force and derailment force over mass, gauge and flange angle."""
from __future__ import annotations

from math import cos, radians, sin
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.figure import Figure
from tqdm import tqdm

from .._core.errors import Error
from .._core.files import complete, make_results_folder
from ..case import Case, data_folder
from ..ensembles.sweep import ensemble
from ..plots.frame import new_page
from ..plots.style import BLACK, BLUE, DASHED, GREEN, GREY, ORANGE, PURPLE, RED, SKY, Line, ldbench_style
from ..results.quantities import GRAVITY, KN, MM
from ..table import ContactTable

if TYPE_CHECKING:
    import xarray as xr

GAUGES = 1.4301, 1.4326, 1.4351, 1.4376, 1.4401         # [m]
MASSES = np.linspace(1000, 3000, 60)                    # [kg]
ANGLES = 45.0, 50.0, 55.0, 60.0, 65.0, 70.0, 75.0       # of the flange [deg]
RAMP_MASSES = np.linspace(1000, 3000, 8)                # [kg]
BEFORE = 10e3                                           # exercise 5 starts so much below the limit load [N]
CLEARANCE = 10.18                                       # published [mm]
GAUGE_LINES = Line(SKY), Line(GREEN), Line(BLUE), Line(ORANGE), Line(PURPLE)


def derailment_demo(output: Path, scheduler: str | None, threads: int | None) -> str:
    """Run both ensembles, plot them to `output`, keep their Datasets beside it; what came out, in words.

    Exercise 3 in full over mass and gauge. Exercise 5 over mass and flange angle, from equilibrium on the flange
    10 kN below the largest load that has one.
    """
    make_results_folder(output.parent)
    how: dict[str, Any] = {"scheduler": scheduler, "threads": threads, "progress": True}
    impact = ensemble(Case.exercise(3), {"gauge": GAUGES, "mass": MASSES.tolist()},
                      store=output.with_name("demo_impact.zarr"), **how)
    profiles = flange_profiles(output.parent/"demo_profiles")
    tables = [ContactTable.quiet(Case.exercise(5).replace(wheel_profile=str(profiles[angle]), table_file=""))
              for angle in tqdm(ANGLES, desc="contact tables", disable=None, leave=False)]
    members = [(table, mass) for table in tables for mass in RAMP_MASSES]
    starts, limits = zip(*(ramp_case(*member) for member in tqdm(members, desc="limit loads", disable=None, leave=False)),
                         strict=True)
    ramp = ensemble(starts, tables=tables, store=output.with_name("demo_ramp.zarr"), columns=("Y", "Z", "y_LF", "z_LF"),
                    rows=2, **how)
    ramp = ramp.assign(limit_load=("member", np.array(limits), {"units": "N"}),
                       flange_angle=("member", np.repeat(ANGLES, len(RAMP_MASSES)), {"units": "deg"}),
                       mass=("member", np.tile(RAMP_MASSES, len(ANGLES)), {"units": "kg"}))
    with ldbench_style(), complete(output) as scratch:
        plot(impact, ramp).savefig(scratch, format="pdf")
    over = (ramp.event_force.sel(kind="derailment", occurrence=1) - ramp.limit_load)/ramp.limit_load
    failed = int((impact.error != "").sum() + (ramp.error != "").sum())
    return (f"{impact.error.size} runs of exercise 3, {ramp.error.size} of exercise 5, {failed} failed\n"
            f"peak flange force: {KN*float(impact.peak_N_LF.min()):.0f} to {KN*float(impact.peak_N_LF.max()):.0f} kN\n"
            f"derailment {100*float(over.min()):.2f} to {100*float(over.max()):.2f} % above the limit load\n{output}")


def flange_profiles(folder: Path) -> dict[float, Path]:
    """The actual wheel with other flange angles [deg]: height and clearance are kept, the straight face is as long as these ask."""
    mp = SimpleNamespace(**run_path(str(data_folder()/"profiles"/"make_profiles.py")))      # of the shipped profiles
    folder.mkdir(exist_ok=True)
    rail = mp.arprof()
    files = {}
    for angle in ANGLES:
        a, b = radians(angle), radians(25)
        face = 3.1 + (10 + 17.4625)*(cos(a) - cos(radians(75)))     # height of the straight face [mm]

        def wheel(y: float, a: float = a, b: float = b, face: float = face) -> list[Any]:
            return mp.wheel(y, 78, mp.arc(-10, 0, a), mp.line(a, face/sin(a)), mp.arc(17.4625, a, b), mp.arc(38.1, b, mp.TAPER))

        files[angle] = folder/f"awprof_{angle:g}.yz"
        mp.write(files[angle], wheel(mp.solve_throat(wheel, rail, CLEARANCE)), f"wheel, flange angle {angle:g}", [])
    return files


def standing(table: ContactTable, q: np.ndarray, F: float | None = None) -> np.ndarray | None:
    """Pose (y, z, roll) of equilibrium near q, by Newton: at its y, or under the lateral force F."""
    free = slice(1 if F is None else 0, 3)
    load = np.array([F or 0.0, -table.weight, 0.0])
    for _ in range(20):
        move = np.zeros(3)
        move[free] = np.linalg.solve(table.tangent(*q)[free, free], (table.force(*q) + load)[free])
        if np.abs(move).max() > 1e-3:
            return None
        q = q + move
        if np.abs(move).max() < 1e-12:
            return q
    return None


def press(table: ContactTable, short_of: float) -> tuple[float, np.ndarray]:
    """Largest lateral force with an equilibrium on the left flange [N]; the equilibrium `short_of` that force.

    The wheelset is moved to the left, in steps that are halved where the force would fall."""
    q, F, step = np.array([0.0, table.equilibrium, 0.0]), 0.0, 1e-4
    path = [(F, q)]
    while step > 1e-9:
        new = standing(table, q + [step, 0, 0])
        force = 0.0 if new is None else -table.force(*new)[0]
        if new is None or force <= F:
            step /= 2
            continue
        F, q = force, new
        path.append((F, q))
        step = min(1.5*step, 1e-5 if q[0] > table.clearance - 1e-4 else 1e-4)
    below = next(pose for load, pose in reversed(path) if load <= F - short_of)
    found = standing(table, below, F - short_of)
    if found is None:
        raise Error(file=table.case.label, expected=f"an equilibrium {short_of:g} N below the limit load",
                    found="none")
    return F, found


def ramp_case(table: ContactTable, mass: float) -> tuple[Case, float]:
    """Exercise 5 from rest in equilibrium shortly below the limit load; that load [N]."""
    own = table.for_case(table.case.replace(mass=mass))
    limit, (y, z, roll) = press(own, BEFORE)
    return own.case.replace(Y=y, Z=z - own.equilibrium, initial_roll=roll, lateral_force=limit - BEFORE, t_end=10,
                            interval=1e-3), limit


def rigid_limit(angle: np.ndarray, b: float, h: float) -> np.ndarray:
    """Lateral force over weight at which the rigid wheelset climbs its flange or, what comes first, overturns.

    b, h: lateral and vertical distance of the left flange's contact from the centre of gravity [m]; angle [deg] is
    the steepest of the flange. Moments about the centre share the weight between the left flange and the right
    tread: V_L (b - h tan g) = V_R (b_R - h_R/40); F = V_L tan g - V_R/40. At tan g = b/h the right wheel carries
    nothing, and the wheelset overturns before it climbs.
    """
    tangent = np.minimum(np.tan(np.radians(angle)), b/h)
    arm = 0.76 - 0.457/40           # of the right tread [m]
    left = arm/(arm + b - h*tangent)
    return left*tangent - (1 - left)/40


def plot(impact: xr.Dataset, ramp: xr.Dataset) -> Figure:
    """Draw flange forces over the mass, and forces at derailment over the flange angle."""
    figure = new_page("Flange force and derailment", "actual profiles",
                      "left: exercise 3; lines: largest normal force of the left flange, struck first; dots: right flange, struck "
                      "after hops, where small differences grow\n"
                      "right: exercise 5 with other flange angles, from equilibrium on the flange 10 kN below the largest load "
                      "that has one; the weight includes the vertical load")
    left, right = figure.subplots(1, 2)
    mass, gauges = impact.mass.values, impact.gauge.values
    for k, (line, gauge) in enumerate(zip(GAUGE_LINES, gauges, strict=False)):
        left.plot(mass, KN*impact.peak_N_LF.isel(gauge=k), label=f"gauge {MM*gauge:.1f} mm", **line.kwargs())
        left.plot(mass, KN*impact.peak_N_RF.isel(gauge=k), ".", color=line.color, markersize=4)
    first, middle = KN*impact.peak_N_LF.isel(gauge=len(gauges)//2).values, len(mass)//2
    left.plot(mass, first[middle]*(mass/mass[middle])**0.6, color=BLACK, linestyle=DASHED, linewidth=0.9,
              label="power 3/5 of the mass")
    left.margins(x=0.02)
    left.set_ylim(bottom=0)
    left.set_title("exercise 3: largest normal force of a flange", loc="left")
    left.legend(loc="lower right", ncols=2)
    left.set(xlabel="mass of the wheelset [kg]", ylabel="peak normal force [kN]")
    figure.colorbar(draw_derailment(right, ramp), ax=right, shrink=0.5, label="mass of the wheelset [kg]")
    return figure


def draw_derailment(ax: Axes, ramp: xr.Dataset) -> PathCollection:
    """Exercise 5: lateral force over weight at derailment over the flange angle; returns the dots, coloured by mass."""
    weight = ramp.mass*GRAVITY + Case.exercise(5).vertical_load
    derailed = ramp.event_force.sel(kind="derailment", occurrence=1).values
    dots = ax.scatter(ramp.flange_angle, derailed/weight, s=14, c=ramp.mass, cmap="viridis", zorder=3,
                      label="derailment in the run")
    ax.plot(ramp.flange_angle, ramp.limit_load/weight, "_", color=RED, markersize=14, label="largest load with an equilibrium")
    angle = np.linspace(float(ramp.flange_angle.min()), float(ramp.flange_angle.max()), 300)
    start = ramp.isel(member=-1, row=0)
    reach, height = float(start.y_LF - start.Y), float(start.axle_height + start.Z - start.z_LF)
    ax.plot(angle, rigid_limit(angle, reach, height), color=BLACK, linewidth=0.9,
            label=f"rigid: climbs, or overturns at b/h = {reach/height:.3f}")
    ax.plot(angle, np.tan(np.radians(angle)), color=GREY, linestyle=DASHED, linewidth=0.9,
            label="tan γ: Nadal without friction, all the weight on the flange")
    ax.set_ylim(0.6, 1.8)
    ax.margins(x=0.04)
    ax.set_title("exercise 5: lateral force when the wheelset derails", loc="left")
    ax.legend(loc="lower right")
    ax.set(xlabel="steepest angle γ of the flange [°]", ylabel="lateral force over weight")
    return dots
