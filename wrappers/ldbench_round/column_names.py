"""What codes call the quantities of the benchmark."""
from __future__ import annotations

import re
import unicodedata
from functools import lru_cache

from ldbench.results.columns import UNITS
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
    "vY": around(SPEED, LATERAL) + "|dydt", "vZ": around(SPEED, VERTICAL) + "|dzdt",
    "roll_rate": around(SPEED, ANGULAR) + f"|omegax|wx|d{ANGULAR}dt",
    "aY": around(GROWTH, LATERAL) + "|d2ydt2", "aZ": around(GROWTH, VERTICAL) + "|d2zdt2",
    "roll_acc": around(GROWTH, ANGULAR) + f"|alphax|d2{ANGULAR}dt2",
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


#: SI unit of every column that may be named, as `UNITS` writes it.
SI = {"Y": "m", "Z": "m", "roll": "rad", "vY": "m/s", "vZ": "m/s", "roll_rate": "rad/s", "aY": "m/s2", "aZ": "m/s2",
      "roll_acc": "rad/s2"} | {f"{base}_{contact}": unit for contact in CONTACTS for base, unit in (
          ("N", "N"), ("Fy", "N"), ("Fz", "N"), ("angle", "rad"), ("y", "m"), ("z", "m"), ("radius", "m"))}


def plain(name: str) -> str:
    """The letters and digits of a name, in lower case."""
    return re.sub(r"[^a-z0-9]", "", name.lower())


@lru_cache
def patterns() -> dict[str, re.Pattern[str]]:
    """What a name has to be for every column of ours."""
    found = {column: re.compile(rf"(?:{words})") for column, words in MOTION.items()}
    for base, words in OF_CONTACT.items():
        for contact in CONTACTS:
            side, place = SIDES[contact[0]], PLACES[contact[1]]
            where = rf"(?:(?:{side})(?:wheel)?(?:{place})|(?:{place})(?:{side}))"
            found[f"{base}_{contact}"] = re.compile(rf"(?:{words}){where}|{where}(?:{words})")
    return found


# What words mean, in English, French and German. Longer words stand before those that they begin with.
WORDS = {
    "radius": r"rolling ?radius|roll ?radius|rollradius|laufkreisradius|rayon(?: ?de ?roulement)?|radius",
    "other": r"energy|energie|pitch|nick|tangage|yaw|gier|lacet|longitudinal|laengs|moment|creep|work|total|sum|power|stiffness|"
             r"derailment",
    "wheelset": r"wheelset|radsatz|essieu|axle|achse|centre|center",
    # Where wheels and contacts have numbers, the first ones are the left wheel and the tread.
    "flange": r"flange|spurkranz|boudin|mentonnet|contact 2\b",
    "tread": r"tread|laufflaeche|laufflache|table(?: ?de ?roulement)?|bande|contact 1\b",
    "left": r"left|links|linkes|linker|linke|gauche|wheel 1\b", "right": r"right|rechts|rechtes|rechter|rechte|droite?|wheel 2\b",
    "wheel-load": r"radkraft|radlast|wheel ?load",
    "normal": r"normalkraft|normale?", "force": r"force|effort|kraft|load|last|charge",
    "acceleration": r"acceleration|beschl(?:eunigung)?|accel|acc",
    "velocity": r"velocity|geschw(?:indigkeit)?|vitesse|speed|veloc|vel|rate",
    "place": r"contact ?point|point ?de ?contact|kontaktpunkt|beruehrpunkt|beruhrpunkt|position|punkt|lage|point|pos",
    "displacement": r"displacement|verschiebung|deplacement|disp|shift|weg",
    "contact angle": r"contact ?angle|angle ?de ?contact|kontaktwinkel|beruehrwinkel|beruhrwinkel",
    "roll": r"wankwinkel|wank|roulis|roll", "angle": r"angle|winkel|angular|gamma|delta",
    "lateral": r"lateral|quer|transverse|transv|lat", "vertical": r"vertikal|vertical|hoehe|hohe|height|vert|hub",
    "": r"wheel|rad|roue|rail|schiene|contact|kontakt|patch|coordinate|koordinate|axis|component"}
LETTERS = {letters: words.split() for letters, words in {
    "l": "left", "r": "right", "lh": "left", "rh": "right", "li": "left", "re": "right", "lef": "left", "rig": "right",
    "wl": "left", "wr": "right", "f": "flange", "t": "tread", "fl": "flange", "tr": "tread", "lt": "left tread",
    "lf": "left flange", "rt": "right tread", "rf": "right flange", "n": "normal", "fn": "normal", "q": "wheel-load",
    "fy": "force lateral", "fz": "force vertical", "y": "lateral", "z": "vertical", "cp": "place", "ycp": "place lateral",
    "zcp": "place vertical", "rr": "radius", "cang": "angle", "a": "acceleration", "v": "velocity",
    "vy": "velocity lateral", "vz": "velocity vertical", "ay": "acceleration lateral", "az": "acceleration vertical",
    "phi": "roll", "al": "roll", "omega": "velocity", "dot": "derivative", "vit": "velocity", "dep": "displacement",
    "ang": "angle",
    # Gensys turns about the axes f, k and p; a finite element program counts its axes.
    "vf": "velocity roll", "af": "acceleration roll", "ur1": "roll", "vr1": "velocity roll", "ar1": "acceleration roll",
    "u2": "displacement lateral", "v2": "velocity lateral", "a2": "acceleration lateral",
    "u3": "displacement vertical", "v3": "velocity vertical", "a3": "acceleration vertical",
    "cfn": "normal", "cf2": "force lateral", "cf3": "force vertical", "ccoor2": "place lateral",
    "ccoor3": "place vertical"}.items()}
_WORD = re.compile("|".join(f"(?P<w{k}>{words})" for k, words in enumerate(WORDS.values())))
AXIS = ("Y", "vY", "aY"), ("Z", "vZ", "aZ"), ("roll", "roll_rate", "roll_acc")
TOWARDS = re.compile(r"\b(?:positive )?(?:to|towards) the (?:left|right)\b")     # a direction, not a wheel
NOTHING_OF_OURS = frozenset({"another quantity"})


def flat(name: str) -> str:
    """The words of a name in lower case, in letters and digits of ASCII, with a blank between them."""
    words = unicodedata.normalize("NFKD", name.lower().replace("ß", "ss").replace("ä", "ae").replace("ö", "oe").replace("ü", "ue"))
    return re.sub(r"[^a-z0-9]+", " ", "".join(c for c in words if not unicodedata.combining(c))).strip()


def words_of(name: str) -> set[str]:
    """What the words of a name mean; words in one, as in German, are told apart."""
    words = TOWARDS.sub("", flat(name))
    found = {word for letters in {*words.split(), *re.findall("[a-z]+", words)} for word in LETTERS.get(letters, ())}
    for match in _WORD.finditer(words):
        if match.lastgroup:
            found.add(list(WORDS)[int(match.lastgroup[1:])])
    return found - {""}


def by_words(name: str) -> set[str]:
    """The columns of ours that the words of a name describe. Words may also say that a column is none of ours."""
    words = words_of(name)
    if "other" in words:
        return set(NOTHING_OF_OURS)
    sides, places = words & {"left", "right"}, words & {"flange", "tread"}
    side = "" if len(sides) != 1 else "L" if "left" in sides else "R"
    place = "" if len(places) != 1 else "F" if "flange" in places else "T"
    if side and place:
        if "normal" in words:
            kinds = {"N"}
        elif "radius" in words:
            kinds = {"radius"}
        elif words & {"contact angle", "angle"}:
            kinds = {"angle"}
        elif "wheel-load" in words:
            kinds = {"Fz"}
        elif words & {"lateral", "vertical"}:
            force, point = ("Fy", "y") if "lateral" in words else ("Fz", "z")
            kinds = {force} if "force" in words else {point} if words & {"place", "displacement"} else {force, point}
        else:
            return set()
        return {f"{kind}_{side}{place}" for kind in kinds}
    if "wheelset" in words:
        words = words - {"normal"}          # n also stands for a node, and no wheelset has a normal
    if sides or places or words & {"force", "normal", "radius", "contact angle"}:
        return set()                        # a contact whose place the name does not say, or a sum over a wheel
    turning = {"velocity", "derivative"} <= words
    rate = "acceleration" if "acceleration" in words or turning else "velocity" if "velocity" in words else ""
    if "roll" in words:
        return {{"acceleration": "roll_acc", "velocity": "roll_rate", "": "roll"}[rate]}
    for axis, letter in ("lateral", "Y"), ("vertical", "Z"):
        if axis in words and (rate or words & {"displacement", "place", "wheelset"}):
            return {{"acceleration": f"a{letter}", "velocity": f"v{letter}", "": letter}[rate]}
    return set()


@lru_cache
def meanings(name: str, unit: str = "") -> frozenset[str]:
    """The columns of ours that a name of another code may stand for; with a unit, those of its kind."""
    word = plain(name)
    exact = {column for column in patterns() if plain(column) == word}
    found = exact or {column for column, pattern in patterns().items() if pattern.fullmatch(word)} or by_words(name)
    kind = UNITS.get(unit, ("",))[0]
    fitting = {column for column in found if column == "time" or not kind or column not in SI or SI[column] == kind}
    if found and not fitting:
        # The unit tells whether a displacement, a velocity or an acceleration is meant.
        fitting = {column for axis in AXIS for column in axis if found & set(axis) and SI[column] == kind}
    return frozenset(fitting or (NOTHING_OF_OURS if found else ()))
