"""What codes call the quantities of the benchmark."""
from __future__ import annotations

import re
from functools import lru_cache

from ldbench.results.columns import UNITS

from .languages import in_english
from .tasks import QUANTITIES

UNIT_OF = {"Y": "m", "Z": "m", "roll": "rad", "vY": "m/s", "vZ": "m/s", "roll_rate": "rad/s", "aY": "m/s2", "aZ": "m/s2",
           "roll_acc": "rad/s2", "N": "N", "Fy": "N", "Fz": "N", "angle": "rad", "y": "m", "z": "m", "radius": "m"}
#: SI unit of every column that may be named, as `UNITS` writes it.
SI = {column: UNIT_OF.get(column) or UNIT_OF[column.partition("_")[0]] for column in QUANTITIES}


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
    "lf": "left flange", "rt": "right tread", "rf": "right flange", "n": "normal", "fn": "normal", "nf": "normal",
    "yf": "force lateral", "qf": "wheel-load", "q": "wheel-load",
    "fy": "force lateral", "fz": "force vertical", "y": "lateral", "z": "vertical", "cp": "place", "ycp": "place lateral",
    "zcp": "place vertical", "rr": "radius", "cang": "angle", "a": "acceleration", "v": "velocity",
    "vy": "velocity lateral", "vz": "velocity vertical", "ay": "acceleration lateral", "az": "acceleration vertical",
    "phi": "roll", "al": "roll", "alpha": "roll angle", "delta": "angle", "omega": "velocity", "dot": "derivative",
    "vit": "velocity", "dep": "displacement",
    "ang": "angle", "gam": "angle", "gamma": "angle", "ca": "angle", "yc": "place lateral", "zc": "place vertical",
    "dt": "velocity", "dt2": "acceleration", "ylat": "displacement lateral",
    # Gensys turns about the axes f, k and p; a finite element program counts its axes.
    "vf": "velocity roll", "af": "acceleration roll", "ur1": "roll", "vr1": "velocity roll", "ar1": "acceleration roll",
    "u2": "displacement lateral", "v2": "velocity lateral", "a2": "acceleration lateral",
    "u3": "displacement vertical", "v3": "velocity vertical", "a3": "acceleration vertical",
    "cfn": "normal", "cf2": "force lateral", "cf3": "force vertical", "ccoor2": "place lateral",
    "ccoor3": "place vertical"}.items()}
# Names in one word of a direction, for which _ stands, and what is meant of it.
for _ways, _word in ("y lat", "lateral"), ("z vert", "vertical"), ("phi rx roll fi", "roll"):
    for _names, _kind in (("d_ disp_ _disp pos_ _pos u_", "displacement"), ("v_ _v vel_ _vel _d _dot _p _rate", "velocity"),
                          ("a_ _a acc_ _acc _dd _ddot _pp d2_", "acceleration")):
        LETTERS |= {name: [_word, _kind] for way in _ways.split() for name in _names.replace("_", way).split()}
_WORD = re.compile("|".join(f"(?P<w{k}>{words})" for k, words in enumerate(WORDS.values())))
AXIS = ("Y", "vY", "aY"), ("Z", "vZ", "aZ"), ("roll", "roll_rate", "roll_acc")
#: Places of contacts that stand behind a quantity, and what they mean: wheel and contact by letters, or by letter and number.
PLACES = {"lt": "lt", "lf": "lf", "rt": "rt", "rf": "rf", "l1": "lt", "l2": "lf", "r1": "rt", "r2": "rf", "11": "lt", "22": "rf"}
GLUED = re.compile(rf"\b([a-z]*)({'|'.join(PLACES)})\b")
#: Of two numbers either may be that of the wheel: the numbers of the column decide.
EITHER = {"12": ("lf", "rt"), "21": ("lf", "rt")}
LETTERS_EITHER = {"alpha": ("roll", "roll_acc"), "omega": ("roll_rate",)}
HUMPS = re.compile(r"(?<=[a-z]{2})(?=[A-Z])")       # between words as in normalForce
TIME = "t", "time", "temps", "zeit", "tempo"
TOWARDS = re.compile(r"\b(?:positive )?(?:to|towards) the (?:left|right)\b")     # a direction, not a wheel
NOTHING_OF_OURS = frozenset({"another quantity"})


def flat(name: str) -> str:
    """The words of a name in English, French or German, in lower case, in letters and digits of ASCII, with a blank between
    them."""
    words = HUMPS.sub(" ", name).lower().replace("ß", "ss").replace("ä", "ae").replace("ö", "oe").replace("ü", "ue")
    return re.sub(r"[^a-z0-9]+", " ", in_english(words)).strip()


def words_of(name: str) -> set[str]:
    """What the words of a name mean; words in one, as in German, are told apart."""
    words = TOWARDS.sub("", flat(name))
    words = GLUED.sub(apart, words)
    if re.search("tread|flange", words) and re.search("left|right", words):      # f and r are no places then, as in tread.f_n
        words = re.sub(r"\br ([yz])\b", r"\1c", re.sub(r"\bf ([nyz])\b", r"f\1", words))
    words += ("", " velocity", " acceleration")[min(derivatives(name), 2)]
    found = {word for letters in {*words.split(), *re.findall("[a-z]+", words)} for word in LETTERS.get(letters, ())}
    for match in _WORD.finditer(words):
        if match.lastgroup:
            found.add(list(WORDS)[int(match.lastgroup[1:])])
    return found - {""}


def apart(found: re.Match[str]) -> str:
    """A quantity and its place apart, where they stand together as in FnLF, Nf_L1 and Q11."""
    quantity, place = found.groups()
    known = found[0] not in LETTERS and (quantity in LETTERS or not (quantity or place.isdecimal()))
    return f"{'rr' if quantity == 'r' else quantity} {PLACES[place]}" if known else found[0]


def derivatives(name: str) -> int:
    """How often a name is derived with respect to time: by der() of Modelica, or by strokes behind it."""
    strokes = re.search(r"['\u2032\u2019]+(?=\s*$)", name.replace("\u2033", "''"))
    return max(len(re.findall(r"\bder\s*\(", name.lower())), len(strokes[0].strip()) if strokes else 0)


def by_words(name: str) -> set[str]:
    """The columns of ours that the words of a name describe. Words may also say that a column is none of ours."""
    words = words_of(name)
    if "other" in words:
        return set(NOTHING_OF_OURS)
    sides, places = words & {"left", "right"}, words & {"flange", "tread"}
    side = "" if len(sides) != 1 else "L" if "left" in sides else "R"
    place = "" if len(places) != 1 else "F" if "flange" in places else "T"
    if side and place:
        kinds = [kind for word, kind in (("normal", "N"), ("radius", "radius"), ("contact angle", "angle"), ("angle", "angle"),
                                         ("wheel-load", "Fz")) if word in words][:1]
        if not kinds and words & {"lateral", "vertical"}:
            force, point = ("Fy", "y") if "lateral" in words else ("Fz", "z")
            kinds = [force] if "force" in words else [point] if words & {"place", "displacement"} else [force, point]
        return {f"{kind}_{side}{place}" for kind in kinds}
    if "wheelset" in words:
        words = words - {"normal"}          # n also stands for a node, and no wheelset has a normal
    if sides or places or words & {"force", "normal", "radius", "contact angle"}:
        return set()                        # a contact whose place the name does not say, or a sum over a wheel
    order = 2 if "acceleration" in words or {"velocity", "derivative"} <= words else int("velocity" in words)
    for axis, columns in zip(("roll", "lateral", "vertical"), (AXIS[2], AXIS[0], AXIS[1]), strict=True):
        if axis in words and (order or axis == "roll" or words & {"displacement", "place", "wheelset"}):
            return {columns[order]}
    return set()


def either_place(words: str) -> set[str]:
    """The columns of a name as Q12, in which the wheel may have the first number or the second."""
    found = re.fullmatch(rf"([a-z]+) ?({'|'.join(EITHER)})", words)
    if found is None:
        return set()
    letters = "rr" if found[1] == "r" else found[1]
    return {column for place in EITHER[found[2]] for column in by_words(f"{letters}_{place}")}


@lru_cache
def meanings(name: str, unit: str = "") -> frozenset[str]:
    """The columns of ours that a name of another code may stand for; with a unit, those of its kind."""
    word = flat(name).replace(" ", "")
    found = {column for column in QUANTITIES if re.sub("[^a-z0-9]", "", column.lower()) == word}
    found = found or set(LETTERS_EITHER.get(word, ())) or either_place(flat(name)) or by_words(name)
    if word in TIME:
        found = {"time"}
    kind = UNITS.get(unit, ("",))[0]
    fitting = {column for column in found if column == "time" or not kind or column not in SI or SI[column] == kind}
    if found and not fitting:
        # The unit tells whether a displacement, a velocity or an acceleration is meant.
        fitting = {column for axis in AXIS for column in axis if found & set(axis) and SI[column] == kind}
    return frozenset(fitting or (NOTHING_OF_OURS if found else ()))


def understood(text: str) -> int:
    """How many words of a text, between separators of cells, name a column."""
    return sum(bool(meanings(cell.strip("\"' "))) for cell in {*re.split(r"[;,\t|\n]", text)} if re.search(r"[^\W\d]", cell))
