"""Profiles: the class Profile, which a case takes."""
from __future__ import annotations

from typing import TYPE_CHECKING

from .profiles.profile import ProfileData

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Profile(ProfileData):
    """A wheel or a rail from a file of any known format, or from points.

        wheel = ldbench.Profile("wheel.whl")
        print(*wheel.notes, sep="\\n")
        run = ldbench.run(ldbench.Case.exercise(2).replace(wheel_profile=wheel))

    A case takes a path or such an object. y goes to the field side, from a wheel's back, z up. What the executable reads as
    it is stays as it is; anything else is turned over, mended where points repeat, lie off the curve or double back, and
    smoothed by its noise. `notes` says what was done, `write` writes what the executable reads.
    """

    def plot(self) -> Figure:
        """The points and the curve, their distance, the tangent angle and the curvature, in a figure."""
        from .plots.profile_page import profile_page
        from .plots.style import ldbench_style

        with ldbench_style():
            return profile_page([self], None, "")
