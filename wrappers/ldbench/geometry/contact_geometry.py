"""What a rigid wheelset does on rigid rails, kept level as in EN 15302 or with roll, and the parameters of that standard."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..conicity import GEOMETRY_PITCH, ROUNDING, equivalent_conicity, harmonic_slope, linearised_conicity, motion_centre
from ..constants import MM

AMPLITUDE = 3e-3            # at which parameters are told [m]
SOFT, STIFF = 2e-3, 4e-3    # amplitudes of the nonlinearity parameter [m]
CURVE = 300.0               # radius of the curve for which the rolling radii coefficient is told [m]


@dataclass(frozen=True)
class ContactGeometry:
    """Geometry functions and conicity of a wheelset that is kept level, or that rolls until it stands on both rails."""
    kept: str                           # 'level' or 'with roll'
    geometry: dict[str, np.ndarray]     # the columns of a geometry file, but the conicity
    flange_ends: tuple[float, float]    # largest y of the left and the right wheel's flange zone in the wheelset [m]
    amplitude: np.ndarray               # [m]
    conicity: np.ndarray                # for the amplitudes, by EN 15302
    linearised: np.ndarray              # the same by harmonic linearisation
    scale: float = 1.0                  # 5 of models 1:5: amplitudes and curves are those of the full size, over it

    @classmethod
    def of(cls, kept: str, names: list[str], rows: np.ndarray, flange_ends: tuple[float, float],
           scale: float = 1.0) -> ContactGeometry:
        """From rows of geometry functions, (12, n), as far as they go without a gap about the centre."""
        gaps = np.flatnonzero(~np.isfinite(rows[7]))
        centre = rows.shape[1]//2
        rows = rows[:, max(gaps[gaps < centre], default=-1) + 1:min(gaps[gaps >= centre], default=rows.shape[1])]
        reach = min(-rows[0, 0], rows[0, -1]) if rows.shape[1] else 0.0
        pitch = GEOMETRY_PITCH/scale
        amplitude = pitch*np.arange(2, int(reach/pitch + 1e-6) + 1)
        wave, linearised = (conicity(amplitude, rows[0], rows[7]) if amplitude.size else amplitude
                            for conicity in (equivalent_conicity, linearised_conicity))
        return cls(kept, dict(zip(names, rows, strict=False)), flange_ends, amplitude, wave, linearised, scale)

    def conicity_at(self, amplitude: float) -> float:
        """Equivalent conicity by EN 15302; NaN beyond the amplitudes."""
        return float(np.interp(amplitude, self.amplitude, self.conicity, right=np.nan)) if self.amplitude.size else np.nan

    def difference_at(self, amplitude: float) -> float:
        """Rolling radius difference at a displacement, the mean of both ways [m]: a negative one turns the wheelset away from the
        centre. NaN where the wheelset does not get there."""
        y, delta_r = self.geometry["Y"], self.geometry["delta_r"]
        if not y.size or amplitude > min(-y[0], y[-1]) + ROUNDING:
            return np.nan
        return float(np.interp(amplitude, y, delta_r) - np.interp(-amplitude, y, delta_r))/2

    def why_none(self, amplitude: float) -> str:
        """Why there is no equivalent conicity for an amplitude; '' where there is one."""
        if np.isfinite(self.conicity_at(amplitude)):
            return ""
        if not np.isfinite(difference := self.difference_at(amplitude)):
            reach = MM*min(-self.geometry["Y"][0], self.geometry["Y"][-1]) if self.geometry["Y"].size else 0.0
            return f"{self.kept} the wheelset stands on both rails up to Y = {reach:.2f} mm"
        y, delta_r = self.geometry["Y"], self.geometry["delta_r"]
        away = np.abs(y[(np.sign(y)*delta_r < 0) & (np.abs(y) <= amplitude + ROUNDING)])
        where = f", which turns the wheelset away from the centre up to Y = {MM*away.max():.2f} mm" if away.size else ""
        return f"{self.kept} the rolling radius difference is {MM*difference:+.3f} mm{where}"

    @property
    def nonlinearity(self) -> float:
        """Nonlinearity parameter [1/m]: growth of the conicity from 2 mm to 4 mm over the 2 mm."""
        soft, stiff = SOFT/self.scale, STIFF/self.scale
        return (self.conicity_at(stiff) - self.conicity_at(soft))/(stiff - soft)

    @property
    def distance(self) -> float:
        """Distance between the contacts of the centred wheelset [m]."""
        k = int(np.argmin(np.abs(self.geometry["Y"])))
        return float(self.geometry["y_L"][k] - self.geometry["y_R"][k])

    @property
    def steering(self) -> float:
        """Radius difference [m] that the treads give before a flange takes over, the smaller one of left and right."""
        g = self.geometry
        found = []
        for wheel, end, way in ("L", self.flange_ends[0], 1), ("R", self.flange_ends[1], -1):
            across = way*(g[f"y_{wheel}"] - g["Y"]) - way*np.sin(g["roll"])*g[f"radius_{wheel}"]
            tread = (across/np.cos(g["roll"]) > end) & (way*g["Y"] >= 0)
            found.append(float(np.max(way*g["delta_r"][tread], initial=0.0)))
        return min(found)

    def rolling_radii_coefficient(self, curve: float | None = None) -> float:
        """Radius difference of the treads over the one with which the wheelset takes a curve by rolling alone; `curve` is the
        radius of the curve [m], that of CURVE at full size by default."""
        curve = CURVE/self.scale if curve is None else curve
        k = int(np.argmin(np.abs(self.geometry["Y"])))
        radius = (self.geometry["radius_L"][k] + self.geometry["radius_R"][k])/2
        return self.steering*curve/(self.distance*radius)

    def parameter(self, name: str, amplitude: float | None = None) -> float:
        """Contact 'angle' parameter or 'roll' angle parameter by harmonic linearisation; NaN where the motion leaves y.

        Half the distance of the contacts times the growth, over y, of half the difference of the tangents of the contact angles,
        left minus right, or of the roll angle.
        """
        g, amplitude = self.geometry, AMPLITUDE/self.scale if amplitude is None else amplitude
        values = {"angle": (np.tan(g["angle_L"]) - np.tan(g["angle_R"]))/2, "roll": g["roll"]}[name]
        if not self.amplitude.size or amplitude > self.amplitude[-1]:
            return np.nan
        centre = motion_centre(np.array([amplitude]), g["Y"], g["delta_r"])[0]
        return self.distance/2*harmonic_slope(amplitude, centre, g["Y"], values) if np.isfinite(centre) else np.nan

    def facts(self) -> dict[str, object]:
        """The numbers, SI units."""
        none = {f"{MM*amplitude:g} mm": words for amplitude in (SOFT/self.scale, AMPLITUDE/self.scale, STIFF/self.scale)
                if (words := self.why_none(amplitude))}
        away = {"rolling_radius_difference": np.array([self.difference_at(amplitude) for amplitude in self.amplitude]),
                "none": none}
        return {"amplitude": self.amplitude, "EN 15302": self.conicity, "harmonic linearisation": self.linearised,
                **(away if none else {}),
                "nonlinearity_parameter": self.nonlinearity, "rolling_radii_coefficient": self.rolling_radii_coefficient(),
                "contact_angle_parameter": self.parameter("angle"), "roll_angle_parameter": self.parameter("roll")}
