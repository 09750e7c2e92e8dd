"""What codes call the quantities of the benchmark."""
from __future__ import annotations

import re
from functools import lru_cache

from ldbench.results.quantities import CONTACTS

LATERAL, VERTICAL = r"(?:y|lat(?:eral)?|transv(?:erse)?)", r"(?:z|vert(?:ical)?)"
ANGULAR = r"(?:roll|phi|rx|rotx|fi|tilt)"
SHIFT, SPEED, GROWTH = (r"(?:d|disp(?:l|lacement)?|pos(?:ition)?|u|shift)", r"(?:v|vel(?:o|ocity)?|d|dot|p|rate|speed)",
                        r"(?:a|acc(?:el|eleration)?|dd|ddot|pp)")


def around(kind: str, way: str, alone: bool = False) -> str:
    """A pattern: the direction before or behind the kind of quantity; also alone."""
    return rf"{kind}{way}|{way}{kind}" + (f"|{way}" if alone else "")


MOTION = {
    "time": r"t|time|temps|zeit|tempo",
    "Y": around(SHIFT, LATERAL, alone=True) + "|ylat|yaxle|ywheelset", "Z": around(SHIFT, VERTICAL, alone=True) + "|zaxle|height",
    "roll": ANGULAR + r"|" + around(r"(?:angle|disp(?:lacement)?)", ANGULAR),
    "vY": around(SPEED, LATERAL), "vZ": around(SPEED, VERTICAL),
    "roll_rate": around(SPEED, ANGULAR) + "|omegax|wx",
    "aY": around(GROWTH, LATERAL), "aZ": around(GROWTH, VERTICAL), "roll_acc": around(GROWTH, ANGULAR) + "|alphax",
}
FORCE, PLACE = r"(?:f|force)", r"(?:pos(?:ition)?|cp|c|p|contact|point)"
OF_CONTACT = {
    "N": r"n|fn|normal(?:force)?|qn|n?force", "Fz": around(FORCE, VERTICAL) + "|q|vertical|vert",
    "Fy": around(FORCE, LATERAL) + "|lateral|lat",
    "angle": r"(?:contact)?angle|gam(?:ma)?|delta|alpha|slope|ang|ca",
    "y": around(PLACE, LATERAL, alone=True), "z": around(PLACE, VERTICAL, alone=True),
    "radius": r"r|rad(?:ius)?|rr|rollingradius|rollrad",
}
SIDES = {"L": r"left|li|lh|l", "R": r"right|re|rh|r"}
PLACES = {"T": r"tread|tr|t", "F": r"flange|fl|f"}


def plain(name: str) -> str:
    """The letters and digits of a name, in lower case."""
    return re.sub(r"[^a-z0-9]", "", name.lower())


def patterns() -> dict[str, re.Pattern[str]]:
    """What a name has to be for every column of ours."""
    found = {column: re.compile(rf"(?:{words})") for column, words in MOTION.items()}
    for base, words in OF_CONTACT.items():
        for contact in CONTACTS:
            side, place = SIDES[contact[0]], PLACES[contact[1]]
            where = rf"(?:(?:{side})(?:wheel)?(?:{place})|(?:{place})(?:{side}))"
            found[f"{base}_{contact}"] = re.compile(rf"(?:{words}){where}|{where}(?:{words})")
    return found


@lru_cache
def _known() -> dict[str, re.Pattern[str]]:
    return patterns()


def meanings(name: str) -> set[str]:
    """The columns of ours that a name of another code may stand for."""
    word = plain(name)
    exact = {column for column in _known() if plain(column) == word}
    return exact or {column for column, pattern in _known().items() if pattern.fullmatch(word)}
