"""The small Fortran programs of tests/fortran, as functions of arrays."""
import re
import subprocess
from dataclasses import dataclass
from io import StringIO

import numpy as np
from scipy.optimize import newton

from ldbench import ContactTable
from running import FORTRAN_TESTS, HANG, REPO, Run

# The benchmark's wheelset.
MASS, ROLL_INERTIA, PITCH_INERTIA = 1568.0, 656.0, 168.0     # [kg, kg m2]
WEIGHT = MASS*9.81 + 164618                                  # with the vertical load [N]
GAUGE, BACK_TO_BACK, ROLLING_RADIUS = 1.4351, 1.35214, 0.457 # [m]
TAPER = np.arctan(1/40)                                      # of the tread [rad]
E_STAR = 2.1e11/(2*(1 - 0.28**2))                            # of the steel [Pa]
# S1002 on 60E1.
MODERN = {"wheel_profile": str(REPO/"profiles/s1002.yz"), "rail_profile": str(REPO/"profiles/60e1.yz"), "gauge": 1.435,
          "back_to_back": 1.36, "table_folder": ""}
MIRROR = np.array([-1.0, 1.0, -1.0])     # (y, z, roll) of the mirrored wheelset


def text(rows: np.ndarray) -> str:
    """Numbers as lines at full precision."""
    return "".join(" ".join(f"{x:.17g}" for x in row) + "\n" for row in np.atleast_2d(rows))


def probe(program: str, *arguments: object, stdin: str = "") -> np.ndarray:
    """The numbers that a test program writes, one row per line."""
    done = subprocess.run([FORTRAN_TESTS / program, *map(str, arguments)], input=stdin, cwd=REPO,
                          capture_output=True, text=True, timeout=HANG)
    assert done.returncode == 0, f"{program}: {done.stderr}"
    return np.loadtxt(StringIO(done.stdout), ndmin=2)


class States:
    """The wheelset's contacts at poses (y, z, roll), z being the height of the axle centre; NaN off the table."""

    def __init__(self, table: ContactTable, poses: np.ndarray) -> None:
        place = {"outside": "nan"}
        self.energy = np.stack([table.potential(*poses.T, wheel=wheel, **place) for wheel in ("left", "right")], axis=1)   # [J]
        self.gradient = -table.forces_by_contact(*poses.T, **place)     # (pose, contact LT LF RT RF, coordinate) [N, N m]
        self.hessian = table.tangent(*poses.T, **place)                 # (pose, coordinate, coordinate) of the sum of the energies
        self.total = self.gradient.sum(axis=1)                          # gradient of that sum
        self.force = np.hypot(self.gradient[..., 0], self.gradient[..., 1])     # size of each contact's force, (pose, contact) [N]


def rest_height(run: Run) -> float:
    """Height of the axle centre above top of rail at Z = 0 [m]."""
    return float(re.search(r"axle_height = (\S+)", run.header)[1])


def poses(run: Run) -> np.ndarray:
    """y, z, roll of every row, z being the height of the axle centre."""
    c = run.columns
    return np.column_stack([c["Y"], rest_height(run) + c["Z"], c["roll"]])


def profile(name: str) -> np.ndarray:
    """Points of a shipped profile, as they stand in the file [m]."""
    return np.loadtxt(REPO / "profiles" / f"{name}.yz", comments="#")*1e-3


@dataclass
class Pendulum:
    """The rigid wheelset on two round rail heads: a cone whose motion is known at any amplitude."""
    rho: float               # radius of the rail heads [m]
    centre: np.ndarray       # of the left one, track frame [m]

    @classmethod
    def of(cls, pair: str) -> "Pendulum":
        """The circle through the crown of the pair's rail."""
        points = left_rail(pair)
        crown = points[np.abs(tangent_angles(points) - TAPER) < np.radians(3)]
        (y, z, c), *_ = np.linalg.lstsq(np.column_stack([2*crown, np.ones(len(crown))]), (crown**2).sum(axis=1))
        return cls(np.sqrt(c + y*y + z*z), np.array([y, z]))

    def __post_init__(self) -> None:
        self.R = self.centre[0]/np.sin(2*TAPER)
        self.d = ROLLING_RADIUS + self.centre[0]*np.tan(TAPER) + self.rho*np.cos(TAPER)
        # The angular frequency of small oscillations [rad/s].
        self.omega = np.sqrt(WEIGHT*(4*self.R - self.d)/(MASS*(2*self.R - self.d)**2 + ROLL_INERTIA))

    def radius(self, poses: np.ndarray) -> np.ndarray:
        """Rolling radius of the left wheel at poses."""
        head = turned(self.centre - poses[:, :2], -poses[:, 2])
        return -head[:, 1] - self.rho*np.cos(TAPER)

    def poses(self, y: np.ndarray) -> np.ndarray:
        """y, height of the axle centre and roll at lateral displacements."""
        roll = newton(lambda roll: self.R*np.sin(2*roll) - self.d*np.sin(roll) - y, y/30, x1=y/20 + 1e-6, tol=1e-17, maxiter=60)
        rise = self.R*(1 - np.cos(2*roll)) - self.d*(1 - np.cos(roll))
        return np.column_stack([y, self.centre[1] + self.rho*np.cos(TAPER) + ROLLING_RADIUS + rise, roll])


def top(x: np.ndarray) -> float:
    """The largest value, on the parabola through three evenly spaced rows."""
    k = int(x.argmax())
    a, b, c = x[k - 1:k + 2]
    return b + (a - c)**2/(8*(2*b - a - c))


def gaps(points: np.ndarray, line: np.ndarray) -> np.ndarray:
    """Distances of points from a polyline, positive on its left when it is walked along."""
    start, way = line[:-1], np.diff(line, axis=0)
    found = []
    for block in np.array_split(points, len(points)//1000 + 1):
        offset = block[:, None] - start
        share = np.clip((offset*way).sum(axis=2)/(way**2).sum(axis=1), 0, 1)
        offset = offset - share[..., None]*way
        length = np.hypot(*np.moveaxis(offset, 2, 0))
        nearest = (np.arange(len(block)), length.argmin(axis=1))
        side = way[nearest[1], 0]*offset[nearest][:, 1] - way[nearest[1], 1]*offset[nearest][:, 0]
        found.append(np.copysign(length[nearest], side))
    return np.concatenate(found)


def turned(points: np.ndarray, angle: float | np.ndarray) -> np.ndarray:
    """Points rotated about the origin."""
    c, s = np.cos(angle), np.sin(angle)
    return np.column_stack([points[:, 0]*c - points[:, 1]*s, points[:, 0]*s + points[:, 1]*c])


def tangent_angles(points: np.ndarray) -> np.ndarray:
    """Angle of a polyline to the y axis at its points [rad]."""
    y, z = np.gradient(points, axis=0).T
    return np.arctan2(z, y)


def left_rail(pair: str) -> np.ndarray:
    """Points of the left rail, track frame [m]."""
    return profile(f"{pair[0]}rprof") + [GAUGE/2, 0]


def left_wheel(pair: str) -> np.ndarray:
    """Points of the left wheel, wheelset frame [m]: radius 457 mm at the centred contact point."""
    wheel = profile(f"{pair}prof") + [BACK_TO_BACK/2, 0]
    rail = Pendulum.of(pair)
    tread = np.polyfit(*wheel[wheel[:, 0] > BACK_TO_BACK/2 + 60e-3].T, 1)
    return wheel - [0, ROLLING_RADIUS + np.polyval(tread, rail.centre[0] - rail.rho*np.sin(TAPER))]
