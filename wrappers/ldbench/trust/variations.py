"""The variations of a case, one cause at a time."""
from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from .._core.errors import Error
from ..case import Case, Value, shortest_name, variables
from ..profiles.profile import ProfileData
from ..results.twins import TWINS, twin_cases

#: Kinds of variations that leave the data of the case as they are.
PROGRAM = "twin", "accuracy", "influence", "bodies"
INFLUENCES = "local", "flat", "apart"
SUPPORTS: tuple[Literal["infinite", "clamped"], ...] = ("infinite", "clamped")     # of bodies
LAWS = "halfspace", "strip", "hertz"
#: Factors on &table accuracy, and on the smoothing of measured profiles.
FACTORS = 0.5, 2.0
#: Groups of the namelist whose numbers are inputs of the physics.
INPUT_GROUPS = "wheelset", "track", "material", "initial", "loading"
RISE = 0.01         # of an input
#: Lengths that are known better than to a hundredth, and how well [m]: gauges of tracks and of wheelsets are measured to a tenth of
#: a millimetre, and a hundredth of them is more than the flange clearance.
LENGTHS = dict.fromkeys(("gauge", "back_to_back", "gauge_depth"), 1e-4)
SMOOTHED = re.compile(r"^# taken: .* smoothed by ([\d.]+) mm", re.MULTILINE)


@dataclass(frozen=True)
class Variation:
    """A case that differs in one cause."""

    kind: str               # 'twin', 'accuracy', 'influence', 'bodies', 'law', 'smoothing' or 'input'
    name: str               # of the cause, in words; twins are one cause
    case: Case
    factor: float = 1.0     # on the forces of the run: those of the varied case are larger by it


def variations(case: Case, laws: bool, folder: Path) -> tuple[list[Variation], list[str]]:
    """All variations of a case, and what is said of causes that cannot be varied, a line each.

    laws: the other contact laws too. folder: for profiles that are smoothed otherwise and for bodies; they are read from it while
    the variations run.
    """
    from .. import bodies  # SciPy takes longer to import than a short run

    name = f"start, within {1e6*max(TWINS):.0f} µm"
    found = [Variation("twin", name, twin) for twin in twin_cases(case)]
    notes: list[str] = []
    if case.formulation == "elastic":
        found += [Variation("accuracy", f"table accuracy {case.accuracy*factor:g}", case.replace(accuracy=case.accuracy*factor))
                  for factor in FACTORS]
        if case.model == "halfspace":
            found += [Variation("influence", f"influence {other}", case.replace({"influence": other}))
                      for other in INFLUENCES if other != case.influence]
            found += [Variation("bodies", f"{support} bodies", case.replace(
                {"influence": "bodies", "bodies": bodies.kept(case, support, folder)})) for support in SUPPORTS]
        if laws:
            found += [Variation("law", f"law {other}", case.replace({"model": other})) for other in LAWS if other != case.model]
    elif laws:
        notes.append(f"laws: contacts are {case.formulation}, which have none")
    found += smoothings(case, folder, notes)
    found += inputs(case)
    return found, notes


def inputs(case: Case) -> Iterator[Variation]:
    """Inputs that are not zero, raised; lowered where the case does not allow more, such as a restitution of 1.

    One sign is run: small changes of an answer are in proportion. A change of many per cent is not, and tells the size alone.
    """
    for k, variable in enumerate(variables()):
        value, name = case.values[k], shortest_name(k)
        listed = variable.group in INPUT_GROUPS or (name == "restitution" and case.formulation == "unilateral")
        if not listed or variable.kind != "real" or not value:
            continue
        step = LENGTHS.get(name, RISE*abs(float(value)))
        words = f"{1e3*step:g} mm" if name in LENGTHS else f"{100*RISE:g} %"
        for sign, way in (1, "+"), (-1, "−"):
            with suppress(Error):
                changed, factor = with_input(case, name, float(value) + sign*step*(1 if float(value) > 0 else -1))
                yield Variation("input", f"{name} {way} {words}", changed, factor)
                break


def with_input(case: Case, name: str, value: float) -> tuple[Case, float]:
    """The case with another value of an input, and the factor on its forces.

    The elastic energy is proportional to the contact modulus E/(1 - nu^2), whatever the pose. In the equations of motion a modulus
    that is larger by a factor is masses and loads that are smaller by it, with the same contact table; the motion is the same, and
    all forces, impulses, pressures and energies are smaller by that factor.
    """
    changed = case.replace({name: value})
    if name not in ("youngs_modulus", "poisson") or case.formulation != "elastic":
        return changed, 1.0
    factor = contact_modulus(changed)/contact_modulus(case)
    smaller = ("mass", "roll_inertia", "pitch_inertia", "vertical_load", "lateral_force", "lateral_ramp", "energy_tolerance")
    return case.replace({other: getattr(case, other)/factor for other in smaller}), factor


def contact_modulus(case: Case) -> float:
    """The modulus of two half-spaces of the case's material [Pa], up to a constant."""
    return case.youngs_modulus/(1 - case.poisson**2)


def smoothings(case: Case, folder: Path, notes: list[str]) -> Iterator[Variation]:
    """Measured profiles, smoothed by half and by twice as much; `notes` gets those whose points are not at hand."""
    sides: dict[tuple[str, str], list[str]] = {}
    for variable, path in case.profile_files().items():
        sides.setdefault((path, variable.partition("_")[0]), []).append(variable)
    for (path, kind), names in sides.items():
        profile = ProfileData(path, kind)
        if profile.as_it_is:
            if found := SMOOTHED.search(Path(path).read_text(errors="replace")):
                notes.append(f"smoothing of {path}: {found[1]} mm were applied when it was written; name the measured file in its "
                             "place to vary them")
            continue
        for factor in FACTORS if profile.smoothing else ():
            words = f"smoothing of the {kind} {Path(path).name} {1e3*factor*profile.smoothing:.2g} µm"
            target = folder/f"{kind}-{len(list(folder.iterdir()))}.yz"
            ProfileData(path, kind, smoothing=factor*profile.smoothing).write(target)
            changes: dict[str, Value | os.PathLike[str]] = dict.fromkeys(names, target)
            yield Variation("smoothing", words, case.replace(changes))
