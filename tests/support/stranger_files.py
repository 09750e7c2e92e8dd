"""A grammar of the column files that strangers send to the benchmark: the layers in which they differ.

A frame is a pandas DataFrame with the columns of docs/output.md in SI. A form says how it is written: names, units, separators,
heads, numbers, lines, encodings. Each layer has options, which `generated.covering` puts together in combinations of its own.
Written without reading the code that judges files.
"""
from __future__ import annotations

import functools
import itertools
import re
from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from ldbench.constants import CONTACTS

Frame = pd.DataFrame
Change = Callable[[Frame], Frame]
Form = Mapping[str, Any]        # arguments of `text_of`, and what `bytes_of` makes of the text
G, MASS, LOAD = 9.81, 1568.0, 164618.0       # of the call
DEGREE = 180/np.pi
MOTION = ("Y", "Z", "roll", "vY", "vZ", "roll_rate", "aY", "aZ", "roll_acc")
POINT = ("angle", "N", "Fy", "Fz", "y", "z", "radius")
KINETIC, POTENTIAL = ["KE_lat", "KE_vert", "KE_roll"], ["PE_grav", "PE_load", "PE_elastic_L", "PE_elastic_R"]
ENERGY = (*KINETIC, *POTENTIAL)
FORCES, PLACES = ("N", "Fy", "Fz"), ("angle", "y", "z", "radius")


def of(*quantities: str, contacts: Iterable[str] = CONTACTS) -> list[str]:
    """Columns of contacts."""
    return [f"{quantity}_{contact}" for contact in contacts for quantity in quantities]


CALL = ("time", *MOTION, *of(*POINT))
ALL = CALL + ENERGY
# Columns that change their sign with the lateral axis, with the vertical one, and with the sense of the roll.
RIGHT, DOWN, ROLL = ["Y", "vY", "aY", *of("y")], ["Z", "vZ", "aZ", *of("z")], ["roll", "roll_rate", "roll_acc"]

# Names of columns --------------------------------------------------------------------------
# Form, names of time and motion, quantities of a contact, sides, parts, and energies, with | between them; what is missing is
# English. <a|b> <c|d> stands for a c, a d, b c, b d.
VOCABULARIES = """
English: {side} {part} {quantity} | time, <lateral|vertical> displacement, roll angle, <lateral|vertical|roll> velocity,
    <lateral|vertical|roll> acceleration | contact angle, <normal|lateral|vertical> force, contact point <y|z>, rolling radius |
    left right | tread flange | kinetic energy <lateral|vertical|roll>, potential energy <gravity|load>, elastic energy
    <left|right>
French: {quantity} {part} roue {side} | temps, déplacement <latéral|vertical>, angle de roulis, <vitesse|accélération>
    <latérale|verticale|de roulis> | angle de contact, effort <normal|latéral|vertical>, position <latérale|verticale> du contact,
    rayon de roulement | gauche droite | table boudin | énergie cinétique <latérale|verticale|de roulis>, énergie potentielle <de
    pesanteur|de la charge>, énergie élastique <gauche|droite>
German: {quantity} {part} {side} | Zeit, <Quer|Vertikal>verschiebung, Wankwinkel, <Quer|Vertikal|Wank>geschwindigkeit,
    <Quer|Vertikal|Wank>beschleunigung | Kontaktwinkel, Normalkraft, Querkraft, Radkraft, Kontaktpunkt <quer|Höhe>, Rollradius |
    links rechts | Lauffläche Spurkranz | kinetische Energie <quer|vertikal|Wanken>, potentielle Energie <Gewicht|Last>,
    elastische Energie <links|rechts>
German forces: {quantity} {part} {side} | Zeit, <Quer|Vertikal>verschiebung, Wankwinkel, <Quer|Vertikal|Wank>geschwindigkeit,
    <Quer|Vertikal|Wank>beschleunigung | Kontaktwinkel, Normalkraft, Führungskraft Y, Radkraft Q, Kontaktpunkt <quer|Höhe>,
    Rollradius | links rechts | Lauffläche Spurkranz
Italian: {quantity} {part} ruota {side} | tempo, spostamento <laterale|verticale>, angolo di rollio, <velocità|accelerazione>
    <laterale|verticale|di rollio> | angolo di contatto, forza <normale|laterale|verticale>, posizione <laterale|verticale> del
    contatto, raggio di rotolamento | sinistra destra | superficie-di-rotolamento bordino | energia cinetica
    <laterale|verticale|di rollio>, energia potenziale <del peso|del carico>, energia elastica <sinistra|destra>
Polish: {quantity} {part} {side} koło | czas, przemieszczenie <poprzeczne|pionowe>, kąt przechyłu, prędkość
    <poprzeczna|pionowa|przechyłu>, przyspieszenie <poprzeczne|pionowe|przechyłu> | kąt kontaktu, siła
    <normalna|poprzeczna|pionowa>, położenie <poprzeczne|pionowe> kontaktu, promień toczny | lewe prawe | powierzchnia-toczna
    obrzeże | energia kinetyczna <poprzeczna|pionowa|przechyłu>, energia potencjalna <ciężaru|obciążenia>, energia sprężysta
    <lewa|prawa>
Spanish: {quantity} {part} rueda {side} | tiempo, desplazamiento <lateral|vertical>, ángulo de balanceo, <velocidad|aceleración>
    <lateral|vertical|de balanceo> | ángulo de contacto, fuerza <normal|lateral|vertical>, posición <lateral|vertical> del
    contacto, radio de rodadura | izquierda derecha | banda pestaña | energía cinética <lateral|vertical|de balanceo>, energía
    potencial <del peso|de la carga>, energía elástica <izquierda|derecha>
Russian: {quantity} {part} {side} колесо | время, <поперечное|вертикальное> перемещение, угол боковой качки,
    <поперечная|вертикальная> скорость, скорость боковой качки, <поперечное|вертикальное> ускорение, ускорение боковой качки |
    угол контакта, <нормальная|поперечная|вертикальная> сила, <поперечное|вертикальное> положение контакта, радиус качения | левое
    правое | поверхность-катания гребень | кинетическая энергия <поперечная|вертикальная|качки>, потенциальная энергия
    <веса|нагрузки>, упругая энергия <левая|правая>
Chinese: {side}轮{part}{quantity} | 时间, <横向|垂向>位移, 侧滚角, <横向|垂向|侧滚角>速度, <横向|垂向|侧滚角>加速度 | 接触角,
    <法向|横向|垂向>力, 接触点<横向|垂向>位置, 滚动半径 | 左 右 | 踏面 轮缘 | <横向|垂向|侧滚>动能, <重力|载荷>势能,
    <左|右>侧弹性势能
Japanese: {side}車輪{part}{quantity} | 時間, <左右|上下>変位, ロール角, <左右|上下|ロール角>速度, <左右|上下|ロール角>加速度 |
    接触角, 法線力, 横圧, 輪重, 接触点<左右|上下>位置, 転がり半径 | 左 右 | 踏面 フランジ | <左右|上下|ロール>運動エネルギー,
    <重力|荷重>位置エネルギー, <左|右>弾性エネルギー
Modelica: wheelset.{side}Wheel.{part}.{quantity} | time, wheelset.<y|z|phi>, der(wheelset.<y|z|phi>), der(der(wheelset.<y|z|phi>))
    | delta, f_<n|y|z>, r_<y|z>, radius | left right | tread flange | wheelset.E_kin_<y|z|phi>, wheelset.E_pot_<g|load>,
    wheelset.<left|right>Wheel.E_elastic
letters and numbers: {quantity}_{side}{part} | t, y, z, phi, vy, vz, omega, ay, az, alpha | gamma, <N|Y|Q>f, yc, zc, rr | L R | 1
    2 | Tkin_<y|z|phi>, Upot_<g|Q>, Uel_<L|R>
two digits: {quantity}{side}{part} | t, y, z, phi, y', z', phi', y'', z'', phi'' | delta, N, Y, Q, yc, zc, r | 1 2 | 1 2 |
    Ek_<y|z|phi>, Ep_<g|Q>, Eel_<1|2>
dotted wheelset: {side}.{part}.{quantity} | time, wheelset.<lat|vert>_disp, wheelset.roll, wheelset.<lat|vert|roll>_vel,
    wheelset.<lat|vert|roll>_acc | gamma, N, Y, Q, y_cp, z_cp, r | wl wr
symbols: {quantity}_{side}{part} | t, Y, Z, Phi, d<Y|Z|Phi>/dt, d2<Y|Z|Phi>/dt2 | delta, N, Fy, Fz, yc, zc, rc | l r | t f
letters for dots: {side} {part} {quantity} | time, y, z, phi, yp, zp, phip, ypp, zpp, phipp
numbered wheels: {quantity} wheel {side} contact {part} | | | 1 2 | 1 2
capitals: {quantity}_{part}_{side} | TIME, <Y|Z>DISP, ROLL, <Y|Z|ROLL>VEL, <Y|Z|ROLL>ACC | ANG, FN, FY, FZ, YC, ZC, RR | LEFT
    RIGHT | TREAD FLANGE | EKY, EKZ, EKROLL, EPGRAV, EPLOAD, EELAST<L|R>
Simpack: $RWP_{side}.Patch_{part}.{quantity} | time, $B_WS.pos.<y|z>, $B_WS.ang.al, $B_WS.vel.<y|z>, $B_WS.omega.al,
    $B_WS.acc.<y|z>, $B_WS.omega_dot.al | Contact_angle, Normal_force, <Lateral|Vertical>_force_track, Contact_pos_<y|z>_track,
    Rolling_radius | Left Right | Tread Flange | $E.kin.<y|z|al>, $E.pot.<grav|load|RWP_L|RWP_R>
Nucars: AXLE1_{side}_{part}_{quantity} | TIME, AXLE1_<Y|Z>_DISP, AXLE1_ROLL, AXLE1_<Y|Z|ROLL>_VEL, AXLE1_<Y|Z|ROLL>_ACC |
    CONT_ANGLE, NORMAL, LATERAL, VERTICAL, CONT_<Y|Z>, ROLL_RADIUS | LEFT RIGHT | TREAD FLANGE | KE_<LATERAL|VERTICAL|ROLL>,
    PE_<GRAVITY|LOAD>, PE_CONTACT_<LEFT|RIGHT>
Vampire: Wheelset 1 {side} {part} {quantity} | Time, Wheelset 1 <Lateral|Vertical|Roll> Displacement, Wheelset 1
    <Lateral|Vertical|Roll> Velocity, Wheelset 1 <Lateral|Vertical|Roll> Acceleration | Contact Angle, Normal Force,
    <Lateral|Vertical> Force (track), Contact <Lateral|Vertical> Position, Rolling Radius | LH RH | Tread Flange
VI-Rail: {side}_wheel_{part}.{quantity} | TIME, wheelset_<disp|vel|acc>.<lateral|vertical|roll> | contact_angle,
    <normal|lateral|vertical>_force, contact_<y|z>, rolling_radius | lef rig | tread flange |
    energy.kinetic_<lateral|vertical|roll>, energy.potential_<gravity|load>, energy.elastic_<left|right>
Gensys: cp_111{side}{part}.{quantity} | time, axl_111.<|v|a><y|z|f> | cang, F<n|y|z>, ycp, zcp, rr | l r | t f |
    axl_111.Ek<y|z|f>, axl_111.Ep<g|load>, cp_111<l|r>.Eel
French symbols: {quantity}_{part}_{side} | temps, dep_<y|z>, roulis, <vit|acc>_<y|z|roulis> | angle, N, Fy, Fz, y, z, rayon |
    gauche droit | table boudin | Ec_<lat|vert|roulis>, Ep_<pesanteur|charge|gauche|droite>
German symbols: {quantity}_{part}_{side} | Zeit, <y|z>_Radsatz, Wankwinkel, v<y|z>_Radsatz, Wankgeschw, a<y|z>_Radsatz, Wankbeschl
    | Kontaktwinkel, Normalkraft, Y_Kraft, Q_Kraft, <y|z>_Kontakt, Rollradius | li re | Laufflaeche Spurkranz |
    Ekin_<quer|vertikal|Wanken>, Epot_<Gewicht|Last>, Eelast_<links|rechts>
Matlab: {quantity}{side}{part} | t, y, z, phi, <y|z|phi>dot, <y|z|phi>ddot | gamma, F<n|y|z>, yc, zc, r | L R | T F |
    T<lat|vert|roll>, V<grav|load|elL|elR>
finite elements: {quantity}_{side}_{part} | TIME, U<2|3>_N_AXLE, UR1_N_AXLE, V<2|3>_N_AXLE, VR1_N_AXLE, A<2|3>_N_AXLE, AR1_N_AXLE
    | CANGLE, CFN, CF<2|3>, CCOOR<2|3>, CRADIUS | LEFT RIGHT | TREAD FLANGE | ALLKE_<2|3|R1>, ALLPE_<GRAV|LOAD>,
    ALLSE_<LEFT|RIGHT>
"""


def spelt(words: str) -> list[str]:
    """Names between commas, with <a|b> spelt out."""
    def one(name: str) -> list[str]:
        before, mark, rest = name.partition("<")
        choices, _, after = rest.partition(">")
        return [before + choice + more for choice in choices.split("|") for more in one(after)] if mark else [name]

    return [found for name in words.split(", ") for found in one(name)]


def _parts(text: str) -> list[str]:
    return [part.strip() for part in re.split(r"\s\|(?=\s)", text)]


def vocabulary(text: str) -> dict[str, str]:
    """The name of every column, from the text of a vocabulary."""
    form, motion, point, sides, parts, energy = (
        own or english for own, english in itertools.zip_longest(_parts(text), ENGLISH, fillvalue=""))
    found = dict(zip(("time", *MOTION, *ENERGY), (*spelt(motion), *spelt(energy)), strict=True))
    contacts = zip(CONTACTS, itertools.product(sides.split(), parts.split()), strict=True)
    return found | {f"{quantity}_{contact}": form.format(side=side, part=part, quantity=word)
                    for contact, (side, part) in contacts for quantity, word in zip(POINT, spelt(point), strict=True)}


_TEXTS = dict(" ".join(text.split()).split(": ", 1) for text in re.split(r"\n(?=\S)", VOCABULARIES.strip()))
ENGLISH = _parts(_TEXTS["English"])
NAMES: dict[str, Mapping[str, str]] = {name: vocabulary(text) for name, text in _TEXTS.items()}
PLAIN = NAMES["English"]
SHORT = {column: name.replace(" ", "_") for column, name in PLAIN.items()}

# Units -------------------------------------------------------------------------------------
LIST = "list"       # of the columns, above all
Units = Mapping[str, tuple[str, float]]         # label and factor of a kind of quantity or of a column
SI: Units = {"time": ("s", 1), "length": ("m", 1), "angle": ("rad", 1), "speed": ("m/s", 1), "spin": ("rad/s", 1),
             "acc": ("m/s2", 1), "spinacc": ("rad/s2", 1), "force": ("N", 1), "energy": ("J", 1)}
MM_KN: Units = {"length": ("mm", 1e3), "force": ("kN", 1e-3)}
MRAD: Units = {"angle": ("mrad", 1e3), "spin": ("mrad/s", 1e3)}
DEGREES: Units = {"angle": ("deg", DEGREE), "spin": ("deg/s", DEGREE), "spinacc": ("deg/s2", DEGREE)}
IMPERIAL: Units = {"length": ("in", 1/0.0254), "speed": ("in/s", 1/0.0254), "acc": ("g", 1/G),
                   "force": ("lbf", 1/4.4482216152605)}
UNITS: dict[str, Units] = {
    "SI": {}, "mm and kN": MM_KN, "mm, kN, mrad": {**MM_KN, **MRAD, "speed": ("mm/s", 1e3)}, "degrees": DEGREES,
    "imperial": IMPERIAL, "degrees of contact angles": {**dict.fromkeys(of("angle"), ("°", DEGREE)), "roll": ("mrad", 1e3)},
    "stars": {"acc": ("m/s**2", 1), "spinacc": ("rad/s**2", 1)}, "m/s/s": {"acc": ("m/s/s", 1), "spinacc": ("rad/s/s", 1)},
    "powers": {"speed": ("m.s-1", 1), "acc": ("m.s-2", 1), "spin": ("rad.s-1", 1), "spinacc": ("rad.s-2", 1)},
    "carets": {"acc": ("m/s^2", 1), "spinacc": ("rad/s^2", 1)}, "superscripts": {"acc": ("m/s²", 1), "spinacc": ("rad/s²", 1)},
    "MN and kJ": {"time": ("ms", 1e3), "force": ("MN", 1e-6), "energy": ("kJ", 1e-3), "spinacc": ("mrad/s2", 1e3)},
    "radius in m": {**MM_KN, **dict.fromkeys(of("radius"), ("m", 1))},
    "micro": {"time": ("µs", 1e6), "length": ("cm", 1e2), "angle": ("µrad", 1e6), "speed": ("cm/s", 1e2), "acc": ("cm/s2", 1e2),
              "force": ("daN", 0.1)},
    "feet": {"length": ("ft", 1/0.3048), "speed": ("ft/s", 1/0.3048), "acc": ("ft/s^2", 1/0.3048), "angle": ("deg", DEGREE),
             "force": ("kip", 1/4448.2216152605), "energy": ("ft-lbf", 1/1.3558179483314)},
    "letters": {"speed": ("mps", 1), "acc": ("mps2", 1), "spin": ("radps", 1), "spinacc": ("radps2", 1)},
    "gon and kgf": {"angle": ("gon", 200/np.pi), "speed": ("km/h", 3.6), "acc": ("mm/s2", 1e3), "force": ("kgf", 1/9.80665)}}
KINDS = {"time": "time", "roll": "angle", "roll_rate": "spin", "roll_acc": "spinacc", "angle": "angle",
         **dict.fromkeys(("Y", "Z", "y", "z", "radius"), "length"), **dict.fromkeys(("vY", "vZ"), "speed"),
         **dict.fromkeys(("aY", "aZ"), "acc"), **dict.fromkeys(FORCES, "force"), **dict.fromkeys(ENERGY, "energy")}


def unit_of(column: str, units: Units) -> tuple[str, float]:
    """The unit of a column and its number in an SI unit."""
    units = {**SI, **units}
    return units.get(column) or units[KINDS.get(column) or KINDS[column.rpartition("_")[0]]]


# Texts -------------------------------------------------------------------------------------
def text_of(frame: Frame, names: Mapping[str, str] = PLAIN, units: Units = SI, order: Iterable[str] = ALL,
            extra: Callable[[Frame], list[tuple[str, str, Any]]] = lambda frame: [], sep: str = ",",
            head: Iterable[str] = ("{name} [{unit}]",), na: str = "NaN", digits: str = "%.9g", decimal: str = ".",
            number: tuple[str, str] = ("", ""), before: str = "") -> str:
    """Text of a frame. extra: names, units and values of further columns. head: templates of the lines above the numbers.
    number: pattern in the numbers and what stands for it. before: what stands above all."""
    columns = [(names.get(column, column), unit, frame[column].to_numpy(float)*factor)
               for column in order for unit, factor in [unit_of(column, units)]]
    columns += [(name, unit, np.broadcast_to(values, len(frame))) for name, unit, values in extra(frame)]
    table = Frame({k: values for k, (_, _, values) in enumerate(columns)}) + 0.0
    body = table.to_csv(sep=sep, header=False, index=False, na_rep="NaN", float_format=digits, decimal=decimal,
                        lineterminator="\n", quoting=3, escapechar="\\").replace("\\", "")
    body = re.sub(*number, body).replace("NaN", na)
    if before == LIST:
        before = "".join(f"# column {k:2d}: {name} [{unit}]\n" for k, (name, unit, _) in enumerate(columns, 1))
    return before + "".join(sep.join(line.format(name=name, unit=unit, k=k) for k, (name, unit, _) in enumerate(columns, 1)) + "\n"
                            for line in head) + body


class Row(NamedTuple):
    """A file that somebody sends."""

    change: Callable[[Frame], Frame] = lambda frame: frame      # of the columns
    form: Form = MappingProxyType({})                           # arguments of `text_of`
    after: Callable[[str], str] = str                           # of the text


# Layers ------------------------------------------------------------------------------------
# An option is a form; `after` changes the text at last. Blanks as separators leave none in names and heads.
TWO_LINES = ("{name}", "{unit}")
COMMAS = {"sep": ";", "decimal": ","}


def of_rows(change: Callable[[int, str], str], head: int = 1) -> Callable[[str], str]:
    """A change of the lines below the head, from the number of each and its text."""
    def changed(text: str) -> str:
        lines = text.splitlines()
        return "\n".join([*lines[:head], *(change(k, line) for k, line in enumerate(lines[head:]))]) + "\n"
    return changed


def padded(text: str) -> str:
    """Words between blanks, right-justified in columns of one width."""
    lines = [line.split(" ") for line in text.splitlines()]
    width = max(len(word) for line in lines for word in line) + 2
    return "".join("".join(word.rjust(width) for word in line) + "\n" for line in lines)


def tecplot(text: str) -> str:
    head, *rows = text.splitlines()
    variables = "\n".join(f'"{name}"' for name in head.split("\t"))
    rows = [row.replace("\t", " ") for row in rows]
    return f'TITLE = "LD benchmark"\nVARIABLES =\n{variables}\nZONE T="wheelset", I={len(rows)}, F=POINT\n' + "\n".join(rows) + "\n"


def matrix(text: str) -> str:
    head, *rows = text.splitlines()
    return f"% {head}\ndata = [\n" + "\n".join(f"{row};" for row in rows) + "\n];\n"


def piped(text: str) -> str:
    head, *rows = (f"| {line.replace('|', ' | ')} |" for line in text.splitlines())
    return "\n".join([head, "|---"*head.count(" | ") + "|---|", *rows]) + "\n"


def in_pages(text: str) -> str:
    """The head stands again above every hundred rows, on a new page."""
    names, units, *rows = text.splitlines()
    return "".join(f"\f {names}\n {units}\n" + "".join(f" {row}\n" for row in rows[k:k + 100]) for k in range(0, len(rows), 100))


def with_names_of_r(text: str) -> str:
    """As R writes a data frame: quoted names without blanks and brackets, and names of rows without one above them."""
    head, *rows = text.splitlines()
    quoted = ",".join('"' + re.sub(r"[^\w.]", ".", name) + '"' for name in head.split(","))
    return "\n".join(['"",' + quoted, *(f'"{k}",{row}' for k, row in enumerate(rows, 1))]) + "\n"


BRACKETS = {"head": ("{name} [{unit}]",)}
SEPARATORS: dict[str, Form] = {
    "commas": {}, "commas and blanks": {"after": lambda text: text.replace(",", ", ")}, "semicolons": {"sep": ";"},
    "decimal commas": COMMAS, "tabs": {"sep": "\t"}, "tabs and decimal commas": {"sep": "\t", "decimal": ","},
    "blanks": {"sep": " "}, "many blanks": {"sep": " ", "after": lambda text: re.sub(
        "^(?=.)", "   ", text.replace(" ", "    "), flags=re.M)},
    "fixed width": {"sep": " ", "head": ("{name}", "[{unit}]"), "after": padded},
    "strokes": {**BRACKETS, "sep": "|", "after": piped}, "matrix": {**BRACKETS, "sep": " ", "after": matrix},
    "Tecplot": {**BRACKETS, "sep": "\t", "after": tecplot}, "R": {**BRACKETS, "after": with_names_of_r},
    "pages": {"sep": " ", "head": TWO_LINES, "after": in_pages},
    "commas above blanks": {**BRACKETS, "after": of_rows(lambda k, line: "  " + line.replace(",", "  "))},
    "quoted cells": {**BRACKETS, "after": lambda text: re.sub(r"[^,\n]+", lambda found: f'"{found[0]}"', text)}}
HEADS: dict[str, Form] = {
    "brackets": {}, "parentheses": {"head": ("{name} ({unit})",)}, "angles": {"head": ("{name} <{unit}>",)},
    "strokes": {"head": ("{name} / {unit}",)}, "two lines": {"head": TWO_LINES}, "units above": {"head": TWO_LINES[::-1]},
    "quotes": {"head": ('"{name} [{unit}]"',)}, "quotes in two lines": {"head": ('"{name}"', '"{unit}"')},
    "units at the end": {"head": ("{name}_{unit}",)}, "without units": {"head": ("{name}",), "units": {}},
    "numbers": {"head": ("{name}", "({unit})", "{k}")}, "in a comment": {"head": ("{name} [{unit}]",), "before": "# "},
    "in a percent comment": {"head": ("{name} [{unit}]",), "before": "% "},
    "a list": {"head": ("c{k}",), "before": LIST}, "units in a comment": {
        "head": ("{name}",), "units": MM_KN, "before": "# units: mm, kN, s, rad, m/s, m/s2, rad/s, rad/s2, J\n"}}
BEFORE: dict[str, Form] = {name: {"before": text} for name, text in {
    "nothing": "", "percent": "% LD benchmark\n% single wheelset without friction\n%\n", "date": "31 May 2006\n\n",
    "slashes": "// LD benchmark, single wheelset without friction\n// solver: Newmark, 20 us\n", "sep": "sep={sep}\n",
    "keys": "mass = 1568\nroll_inertia = 656\nauthor = A. Author\nsimulation = LD\n", "blank lines": "\n\n",
    "report": "WHEELSET DYNAMICS PROGRAM, VERSION 4.2\nDate: 2006-06-12\n\nLD benchmark, exercise of the call\n"
              "Mass 1568 kg, roll inertia 656 kg.m2\nLoad 164.618 kN, g = 9.81 m/s2\nStep 1.0E-5 s\nContacts: Hertz\n\n",
    "stars": "** units: N, m, s, rad; 2 lateral (left), 3 vertical (up)\n",
    "LabVIEW": "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\nDate\t2006/06/12\n"
               "Time\t10:31:07,52\n***End_of_Header***\t\n\t\n", "cells": "LD benchmark;;;\n;;;\n"}.items()}
MISSING: dict[str, Form] = {mark or "nothing": {"na": mark} for mark in (
    "NaN", "", "-999", "n/a", "#N/A", "#NV", "**************", "########", "-1.#IND", "1.#QNAN", "nan(ind)", "n.a.", "--", "\u2014",
    "NULL", "1e30")}
DIGITS: dict[str, Form] = {
    "nine": {}, "plus signs": {"digits": "%+.9e"}, "seven": {"digits": "%.7g"}, "seventeen": {"digits": "%.17g"},
    "D": {"digits": "%.10E", "number": (r"(\d)E([+-]\d)", r"\1D\2")},
    "d without plus": {"digits": "%.9e", "number": (r"(\d)e\+?(-?\d)", r"\1d\2")},
    "no E": {"digits": "%.7E", "tiny": 1e-120, "number": (r"E([+-]\d{3})", r"\1")},
    "no leading zero": {"digits": "%.10f", "number": (r"(?<![\d.,])0([.,])(?=\d)", r"\1")},
    "true minus": {"number": (r"-(?=\d)", "\u2212")},
    "groups": {"digits": "%.9f", "number": (r"(?<![\d.,])(\d{1,3})(\d{3})(?=[.,]\d)", "\\1\u202f\\2")}}
LINES: dict[str, Form] = {
    "plain": {}, "footer": {"below": "# end of run\n# 3 impacts\n"}, "END": {"below": "END\n"},
    "closing words": {"below": "\nNormal termination of job 17\nCPU time: 3.21 s\n"}, "blank lines": {"below": "\n\n"},
    "no line end": {"below": None}, "rows twice": {"twice": True}, "last separator": {"last": True}, "index": {"index": True}}
ENDS: dict[str, Form] = {"LF": {}, "CRLF": {"eol": "\r\n"}, "CR": {"eol": "\r"}}
ENCODINGS: dict[str, Form] = {name: {"encoding": name} for name in ("utf-8", "utf-8-sig", "utf-16", "of the country")}
COUNTRY = {"French": "latin-1", "Italian": "cp1252", "Spanish": "cp1252", "Polish": "cp1250", "Russian": "cp1251",
           "Chinese": "gb18030", "Japanese": "shift_jis"}


def creepages(frame: Frame) -> list[tuple[str, str, Any]]:
    return [("pitch angle", "rad", frame["pitch"]), ("forward speed", "m/s", 1.0), ("yaw angle", "rad", 0.0),
            *((f"{PLAIN[name].removesuffix(' normal force')} {what}", unit, 0.0) for name in of("N")
              for what, unit in (("creepage x", "-"), ("creepage y", "-"), ("spin", "1/m"), ("creep force", "N")))]


def wheel_totals(frame: Frame) -> list[tuple[str, str, Any]]:
    found: list[tuple[str, str, Any]] = [("yaw constraint moment", "N.m", 0.0)]
    for side, word in ("L", "left"), ("R", "right"):
        vertical, lateral = (frame[f"{q}_{side}T"] + frame[f"{q}_{side}F"] for q in ("Fz", "Fy"))
        ratio = (lateral.abs()/vertical.where(vertical > 1.0)).fillna(0.0)
        found += [(f"{word} wheel Q", "N", vertical), (f"{word} wheel Y", "N", lateral), (f"{word} wheel L/V", "-", ratio)]
    return found


def sums_of_energies(frame: Frame) -> list[tuple[str, str, Any]]:
    kinetic, potential = frame[KINETIC].sum(axis=1), frame[POTENTIAL].sum(axis=1)
    return [("kinetic energy", "J", kinetic), ("potential energy", "J", potential), ("total energy", "J", kinetic + potential)]


ORDERS: dict[str, Form] = {
    "of the call": {}, "backwards": {"order": ALL[::-1]}, "time last": {"order": [*ALL[1:], "time"]},
    "no energies": {"order": CALL},
    "by contact": {"order": ["time", *of(*POINT, contacts=("RF", "RT", "LF", "LT")), *MOTION, *ENERGY]},
    "by quantity": {"order": ["time", *MOTION, *(name for q in POINT for name in of(q)), *ENERGY]},
    "any": {"order": np.random.default_rng(7).permutation(ALL).tolist()}, "creepages": {"extra": creepages},
    "totals": {"extra": wheel_totals}, "sums": {"order": CALL, "extra": sums_of_energies}}
FILES: dict[str, Form] = {name: {"file": name} for name in (
    "ex2_aw.csv", "ex2_aw.txt", "ex2_aw.dat", "ex2_aw.out", "Exercise 2 actual.txt", "MyCode_LDbench_EX2_AW.CSV",
    "exercise2_awprof.dat", "ex2_aw.lvm", "ex2_aw.m", "ex2_aw.md", "ex2_aw.lis")}
SPELLINGS: dict[str, Form] = {name: {"spelling": change} for name, change in {
    "as it is": str, "underscores": lambda name: name.replace(" ", "_"), "dots": lambda name: name.replace(" ", "."),
    "capitals": lambda name: name.upper().replace(" ", "_"),
    "no marks": lambda name: name.translate(str.maketrans("éèêôâ", "eeeoa")),
    "humps": lambda name: re.sub(r"(?<=[a-z]{3}) ([A-Za-z])(?=[a-z])", lambda found: found[1].upper(), name)}.items()}
LAYERS: dict[str, Mapping[str, Form]] = {
    "names": {name: {"names": found} for name, found in NAMES.items()},
    "units": {name: {"units": units} for name, units in UNITS.items()},
    "digits": DIGITS, "missing": MISSING, "before": BEFORE, "heads": HEADS, "separators": SEPARATORS, "lines": LINES, "ends": ENDS,
    "encodings": ENCODINGS, "orders": ORDERS, "files": FILES, "spellings": SPELLINGS}


def written(frame: Frame, options: Mapping[str, str]) -> tuple[str, bytes]:
    """Name and contents of the file of a frame, by an option of each layer; what does not go together gives way."""
    parts = {layer: LAYERS[layer][option] for layer, option in options.items()}
    if "head" in parts["separators"]:
        parts["heads"] = {}
    form = {key: value for part in parts.values() for key, value in part.items()}
    sep, after, spelling, units = form.get("sep", ","), form.get("after"), form["spelling"], form["units"]
    odd = any(re.search(r"[^\w .]", name) for name in form["names"].values())
    if after is with_names_of_r:
        after = None if odd else after
    head, na = form.get("head", BRACKETS["head"]), form["na"]
    if head == HEADS["units at the end"]["head"] and odd:
        head = BRACKETS["head"]
    if sep == " ":
        head = tuple("{name}[{unit}]" if " / " in line else line.replace(" ", "") for line in head)
    if (sep == " " or "blanks" in options["separators"] or after is tecplot) and na == "":
        na = "NaN"

    def spelt_out(name: str) -> str:
        return spelling(name).replace(" ", "_") if sep == " " else spelling(name)

    text = text_of(frame.mask(frame == 0.0, form["tiny"]).assign(time=frame["time"]) if "tiny" in form else frame,
                   {column: spelt_out(name) for column, name in form["names"].items()}, units, form.get("order", ALL),
                   lambda frame: [(spelt_out(name), unit, x) for name, unit, x in form.get("extra", lambda frame: [])(frame)],
                   sep, head, na, form.get("digits", "%.9g"), form.get("decimal", "."), form.get("number", ("", "")),
                   parts["heads"].get("before", ""))
    count = text.count("\n") - len(frame)
    if form.get("twice"):
        text = of_rows(lambda k, line: f"{line}\n{line}", count)(text)
    if form.get("last") and sep != " " and not after:
        text = text.replace("\n", f"{sep}\n")
    if form.get("index") and sep != " " and not after and count == 1:
        text = "".join(f"{k - 1 if k else ''}{sep}{line}\n" for k, line in enumerate(text.splitlines()))
    text = parts["before"]["before"].format(sep=sep)*(sep != " ") + (after(text) if after else text) + (form.get("below", "") or "")
    text = (text if form.get("below", "") is not None else text.rstrip("\n")).replace("\n", form.get("eol", "\n"))
    encoding = COUNTRY.get(options["names"], "utf-8") if form["encoding"] == "of the country" else form["encoding"]
    try:
        return form["file"], text.encode(encoding)
    except UnicodeEncodeError:
        return form["file"], text.encode()


# Changes of columns ------------------------------------------------------------------------
def each(columns: Iterable[str], change: Callable[[pd.Series], Any]) -> Change:
    return lambda frame: frame.assign(**{name: change(frame[name]) for name in columns})


def times(factor: float, *columns: str) -> Change:
    return each(columns, lambda x: x*factor)


def plus(amount: float, *columns: str) -> Change:
    return each(columns, lambda x: x + amount)


def at_contacts(quantity: str, value: Callable[[Frame, str], Any]) -> Change:
    """A quantity of every contact, from the frame and the contact."""
    return lambda frame: frame.assign(**{f"{quantity}_{contact}": value(frame, contact) for contact in CONTACTS})


def swap(*pairs: str, quantities: Iterable[str] = POINT) -> Change:
    """Exchange columns of contacts, as "LT RT"."""
    partner = {a: b for pair in pairs for a, b in (pair.split(), pair.split()[::-1])}
    return lambda frame: frame.assign(**{f"{q}_{a}": frame[f"{q}_{b}"] for q in quantities for a, b in partner.items()})


def both(*changes: Change) -> Change:
    return lambda frame: functools.reduce(lambda found, change: change(found), changes, frame)
