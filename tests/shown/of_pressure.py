"""What the picture of pressures shows: each part says what it is, and is that."""
from __future__ import annotations

import re

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from ldbench.plots.named import Shown
from named_artists import all_named, artists, shown
from probes import gaps, left_rail, left_wheel, turned
from raw import PAIR, Raw
from specimen import World
from table import FULLNESS, MM

NAMES = {"pressure", "pressure.contours", "hertz", "cut.x", "cut.s", "hertz.x", "hertz.s", "section.rail", "section.wheel",
         "section.pressure", "section.pressed"}


def named_parts(figure: Figure, contact: str) -> dict[str, object]:
    """The parts of a page of one contact by their names; all of them have one."""
    *_, bar = figure.axes
    assert all_named(figure) and bar.get_xlabel() == "pressure [MPa]"
    parts = [part for ax, part in artists(figure) if ax is not bar]
    side = {"L": "left", "R": "right"}[contact[0]]
    assert all((side if shown(part).how == "outline" else contact) in shown(part).y.split() for part in parts)
    names = [part_name(shown(part)) for part in parts]
    assert sorted(names) == sorted(NAMES)
    return dict(zip(names, parts, strict=True))


def part_name(what: Shown) -> str:
    """A short name of a part."""
    return {"elements": "pressure", "contours": "pressure.contours", "ellipse": "hertz", "cut": f"cut.{what.x[0]}",
            "Hertz": f"hertz.{what.x[0]}", "outline": f"section.{what.y.split()[0]}", "crest": "section.pressure",
            "pressed": "section.pressed"}[what.how]


def check_section(parts: dict[str, object], raw: Raw, k: int, contact: str) -> None:
    """Wheel and rail of this side in the frame of the track, the pressed points at the contact, the crest on the wheel's side."""
    side, sign = contact[0], {"L": 1, "R": -1}[contact[0]]
    pose = np.array([raw.c["Y"][k], raw.setting("axle_height") + raw.c["Z"][k]])
    wheel = turned(left_wheel(PAIR[side]), sign*(raw.setting("axle_roll") + raw.c["roll"][k]))*[sign, 1] + pose
    assert np.abs(gaps(wheel, parts["section.wheel"].get_xydata()/MM)).max() < 1e-4
    assert np.abs(gaps(left_rail(PAIR[side])*[sign, 1], parts["section.rail"].get_xy()/MM)).max() < 1e-4
    point = np.array([raw.c[f"y_{contact}"][k], raw.c[f"z_{contact}"][k]])
    pressed = parts["section.pressed"].get_xydata()/MM
    assert np.hypot(*(pressed - point).T).min() < 1e-3 and np.abs(gaps(pressed, wheel)).max() < 1e-4
    crest = parts["section.pressure"].get_xy()/MM
    force = np.array([raw.c[f"Fy_{contact}"][k], raw.c[f"Fz_{contact}"][k]])
    ahead = (crest - point) @ force/np.hypot(*force)
    assert ahead.max() == pytest.approx(7e-3, rel=0.1) and ahead.min() > -2e-3      # the rail presses into the wheel


def check_pressure(world: World, contact: str, figure: Figure) -> None:
    """Against the columns and the profile files; the area and the force leave the largest pressure no room."""
    raw, k = world.thrown, world.thrown.first_peak(contact)
    figure.draw_without_rendering()
    parts, (surface, cuts, section, _) = named_parts(figure, contact), figure.axes
    assert (surface.get_xlabel(), surface.get_ylabel()) == ("x along the rail [mm]", "s along the profile [mm]")
    assert (cuts.get_xlabel(), cuts.get_ylabel()) == ("from the largest approach [mm]", "pressure [MPa]")
    assert (section.get_xlabel(), section.get_ylabel()) == ("y in the track [mm]", "z [mm]")
    assert surface.get_title(loc="left").startswith({"LF": "left flange: ", "RF": "right flange: "}[contact])
    # The pressure over x and s: its sum is the force, but for normals that turn; a flange's patch is long along the rail.
    image = parts["pressure"]
    x0, x1, s0, s1 = image.get_extent()
    p, force = np.nan_to_num(np.ma.filled(image.get_array(), np.nan)), raw.c[f"N_{contact}"][k]
    assert np.abs(p - p[:, ::-1]).max() < 1e-3*p.max() < np.abs(p - p[::-1]).max()        # as before the axle, so behind it
    cell = (x1 - x0)*(s1 - s0)/p.size
    assert 1e6*p.sum()*cell*1e-6 == pytest.approx(force, rel=0.04) and x1 - x0 > 2*(s1 - s0)
    largest = force/((p > 0).sum()*cell*1e-6)/FULLNESS[0]
    assert 1e6*p.max() == pytest.approx(largest, rel=0.05)
    ellipse = parts["hertz"]
    assert (ellipse.width, ellipse.height) == (pytest.approx(x1 - x0, rel=0.3), pytest.approx(s1 - s0, rel=0.3))
    assert s0 < ellipse.center[1] < s1 and ellipse.center[0] == 0
    # Cuts through the largest pressure, each with the colour of Hertz's beside it.
    for way, half, words in (("x", (x1 - x0)/2, "along the rail"), ("s", (s1 - s0)/2, "along the profile")):
        cut, hertz = parts[f"cut.{way}"], parts[f"hertz.{way}"]
        places, values = cut.get_xydata()[np.isfinite(cut.get_ydata())].T
        assert cut.get_label() == words and cut.get_color() == hertz.get_color()
        assert cut.get_linestyle() == "-" != hertz.get_linestyle()
        assert half/2 < np.ptp(places)/2 < 1.05*half and values.max() == pytest.approx(p.max(), rel=1e-9)
        assert np.ptp(hertz.get_xdata()) == pytest.approx({"x": ellipse.width, "s": ellipse.height}[way], rel=1e-9)
        volume = hertz.get_ydata().max()*2/3*np.pi/4*ellipse.width*ellipse.height
        assert volume == pytest.approx(p.sum()*cell, rel=0.02)
    check_section(parts, raw, int(k), contact)
    for ax in cuts, section:
        legend = ax.get_legend()
        texts = {text.get_text() for text in legend.get_texts()}
        assert texts == {part.get_label() for part in (*ax.lines, *ax.patches)}
    legend = section.get_legend()
    pressed = next(handle for handle, text in zip(legend.legend_handles, legend.get_texts(), strict=True)
                   if text.get_text() == "pressed")
    assert to_hex(pressed.get_color()) == to_hex(parts["section.pressed"].get_color())
    assert re.fullmatch(r"pressure at x = 0, (\d+) MPa at most", parts["section.pressure"].get_label())
