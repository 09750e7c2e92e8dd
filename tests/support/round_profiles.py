"""Cones and arcs on rails with round heads: profiles whose rolling radii and conicity have closed forms at any amplitude.

Cone on round heads: with the heads' centres at +-e, R = e/sin(2 g) and d the height of the axle over the cones' common line
through these centres, y = R sin(2 roll) - d sin(roll), delta_r = 2 e sin(roll), tan(gamma_e) -> e/(2 R - d).

Arc on arc, radius R_w of the wheel and R_r of the rail: the centres of curvature are the joints of a four-bar linkage with
cranks of length D = R_w - R_r; e_w and h place the wheel's centre of curvature in the wheelset: delta_r = R_w (cos(angle_R +
roll) - cos(angle_L - roll)), tan(gamma_e) -> R_w sin(g) (e_w - D sin g)/(D (e_w cos g + h sin g)), which is Wickens' R_w
g/(R_w - R_r) (b + R_r g)/(b - r_0 g) for small contact angles g (Fundamentals of Rail Vehicle Dynamics, 2003).
"""
from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.optimize import brentq, newton
from scipy.special import ellipe, ellipkm1

import make_profiles as arcs
from ldbench import Case, ContactTable
from ldbench.constants import MM

RADIUS = 0.457              # at the contact of the centred wheelset [m]
FLANGE = np.radians(70)
THROAT = 38.0               # where the tread begins, from the wheel back [mm]


def hertz(A: float, B: float, approach: float, modulus: float) -> tuple[float, float, float, float]:
    """Semi-axes along x and s [m], largest pressure [Pa] and force [N] for the gap A x² + B s², an approach and the modulus E*
    (K. L. Johnson, Contact Mechanics, 4.25-4.32)."""
    def integrals(k: float) -> tuple[float, float]:
        """K and (K - E)/(1 - k²) of an ellipse with the axis ratio k, minor to major."""
        K = ellipkm1(k*k)
        return K, (K - ellipe(1 - k*k))/(1 - k*k)

    def miss(k: float) -> float:
        K, D = integrals(k)
        return (K - D)/(k*k*D) - max(A, B)/min(A, B)

    k = brentq(miss, 1e-7, 1 - 1e-9, xtol=1e-15)
    K, D = integrals(k)
    long = np.sqrt(approach*D/(K*min(A, B)))
    largest = modulus*approach/(k*long*K)
    axes = (long, k*long) if A <= B else (k*long, long)
    return *axes, largest, 2/3*np.pi*k*long**2*largest


@dataclass
class Shape:
    """A wheel with a straight (R_w infinite) or hollow tread on a rail with a round head."""

    taper: float            # angle of the contact of the centred wheelset [rad]
    R_w: float              # [m]
    R_r: float              # [m]

    def __post_init__(self) -> None:
        s, c = np.sin(self.taper), np.cos(self.taper)
        crown = next(piece for piece in self.rail() if piece.R == MM*self.R_r)
        self.head = (arcs.GAUGE_POINT + crown.c[0])/MM          # lateral position of the centre of the left rail's head [m]
        self.contact = self.head - self.R_r*s                   # and of the left contact of the centred wheelset [m]
        self.R, self.d = self.head/np.sin(2*self.taper), RADIUS + self.head*s/c + self.R_r*c
        self.e_w, self.h = self.contact + self.R_w*s, -RADIUS - self.R_w*c
        self.steepest = np.arcsin(s + (self.contact - (arcs.WHEEL_BACK + THROAT)/MM)/self.R_w)  # of the tread, at the throat [rad]

    def geometry(self, y: np.ndarray, spacing: float = arcs.STEP) -> pd.DataFrame:
        """What the core finds from points `spacing` mm apart; the table is small: only the rigid geometry is read."""
        with tempfile.TemporaryDirectory() as folder:
            return ContactTable(self.case(Path(folder), spacing).replace(
                contact_model="hertz", lateral=0.02, table_roll=0.02)).geometry(y)

    def case(self, folder: Path, spacing: float = arcs.STEP) -> Case:
        """A case of profiles that are written to a folder, from points `spacing` mm apart."""
        paths = [folder/f"{name}.yz" for name in ("wheel", "rail")]
        for path, shape in zip(paths, (self.wheel(), self.rail()), strict=True):
            np.savetxt(path, arcs.sample(shape, spacing), fmt="%.17g")
        return Case.from_namelist("&case /").replace(wheel_profile=str(paths[0]), rail_profile=str(paths[1]))

    def rail(self) -> list[arcs.Piece]:
        edge = np.arcsin(0.024/self.R_r)
        return arcs.rail([arcs.arc(12, np.pi/2, edge + self.taper),
                          arcs.arc(MM*self.R_r, edge + self.taper, -edge + self.taper),
                          arcs.arc(12, -edge + self.taper, -np.pi/2)])

    def wheel(self) -> list[arcs.Piece]:
        """Tip, flange of 70 degrees, throat and tread; a hollow tread has the angle `taper` over the rail's crown."""
        tread = arcs.line(self.taper, 90) if np.isinf(self.R_w) else arcs.arc(MM*self.R_w, self.steepest, np.radians(-3))
        flange = arcs.arc(-10, 0, FLANGE), arcs.line(FLANGE, 6/np.sin(FLANGE)), arcs.arc(18, FLANGE, tread[1])
        low = THROAT - arcs.chain((0, 0), *flange)[-1].end[0]
        return arcs.chain((0, 0), arcs.arc(-low, -np.pi/2, 0), *flange, tread)

    def lateral(self, roll: np.ndarray) -> np.ndarray:
        """Displacement at a roll angle [m]."""
        if np.isinf(self.R_w):
            return self.R*np.sin(2*roll) - self.d*np.sin(roll)
        mean, half = self.angles(roll)
        return self.h*np.sin(roll) + (self.R_w - self.R_r)*np.cos(mean)*np.sin(half)

    def angles(self, roll: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean and half the difference of the contact angles of the linkage."""
        half = np.arctan2(self.e_w*np.sin(roll), self.e_w*np.cos(roll) - self.head)
        return np.arcsin((self.e_w*np.cos(roll) - self.head)/(self.R_w - self.R_r)/np.cos(half)), half

    def roll(self, y: np.ndarray | float) -> np.ndarray:
        """Roll angle at displacements."""
        y = np.asarray(y, float)
        return newton(lambda roll: self.lateral(roll) - y, y/30, x1=y/20 + 1e-6, tol=1e-17, maxiter=60)

    def delta_r(self, y: np.ndarray) -> np.ndarray:
        """Closed form of the difference of the rolling radii [m]."""
        roll = self.roll(y)
        if np.isinf(self.R_w):
            return 2*self.head*np.sin(roll)
        mean, half = self.angles(roll)
        return self.R_w*(np.cos(mean - half + roll) - np.cos(mean + half - roll))

    @property
    def small(self) -> float:
        """Equivalent conicity for small amplitudes."""
        if np.isinf(self.R_w):
            return self.head/(2*self.R - self.d)
        D, s, c = self.R_w - self.R_r, np.sin(self.taper), np.cos(self.taper)
        return self.R_w*s*(self.e_w - D*s)/(D*(self.e_w*c + self.h*s))
