"""More files that strangers would send: thirty habits of writing a file without a fault, thirty files with one fault each.

A row is that of `stranger_files`. HABITS are faultless; a verdict stands where a frame, a sign or a coarse time is to be told.
PLANTED has one fault in each file, written by such a habit, and the words of which one must stand in what the reader is told.
Files and faults were written without reading the code that judges them, but for the faults of AFTERWARDS; the words that a fault
asks for, and the verdict on coarse times, follow the terms of the findings.
"""
from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from ldbench_round.findings import DOUBTFUL
from stranger_files import (
    ALL,
    CALL,
    CONTACTS,
    DEGREE,
    ENERGY,
    FORCES,
    KINETIC,
    MM_KN,
    PLACES,
    POINT,
    RIGHT,
    ROLL,
    TWO_LINES,
    Change,
    Frame,
    Row,
    both,
    closed_as,
    each,
    first_peak,
    names,
    of,
    plus,
    times,
)

# Names -------------------------------------------------------------------------------------
ITALIAN = names("""{quantity} {part} ruota {side} | tempo, spostamento laterale, spostamento verticale, angolo di rollio, velocità
    laterale, velocità verticale, velocità di rollio, accelerazione laterale, accelerazione verticale, accelerazione di rollio |
    angolo di contatto, forza normale, forza laterale, forza verticale, posizione laterale del contatto, posizione verticale del
    contatto, raggio di rotolamento | sinistra destra | superficie-di-rotolamento bordino | energia cinetica laterale, energia
    cinetica verticale, energia cinetica di rollio, energia potenziale del peso, energia potenziale del carico, energia elastica
    sinistra, energia elastica destra""")
POLISH = names("""{quantity} {part} {side} koło | czas, przemieszczenie poprzeczne, przemieszczenie pionowe, kąt przechyłu, prędkość
    poprzeczna, prędkość pionowa, prędkość przechyłu, przyspieszenie poprzeczne, przyspieszenie pionowe, przyspieszenie przechyłu |
    kąt kontaktu, siła normalna, siła poprzeczna, siła pionowa, położenie poprzeczne kontaktu, położenie pionowe kontaktu, promień
    toczny | lewe prawe | powierzchnia-toczna obrzeże | energia kinetyczna poprzeczna, energia kinetyczna pionowa, energia
    kinetyczna przechyłu, energia potencjalna ciężaru, energia potencjalna obciążenia, energia sprężysta lewa, energia sprężysta
    prawa""")
SPANISH = names("""{quantity} {part} rueda {side} | tiempo, desplazamiento lateral, desplazamiento vertical, ángulo de balanceo,
    velocidad lateral, velocidad vertical, velocidad de balanceo, aceleración lateral, aceleración vertical, aceleración de balanceo
    | ángulo de contacto, fuerza normal, fuerza lateral, fuerza vertical, posición lateral del contacto, posición vertical del
    contacto, radio de rodadura | izquierda derecha | banda pestaña | energía cinética lateral, energía cinética vertical, energía
    cinética de balanceo, energía potencial del peso, energía potencial de la carga, energía elástica izquierda, energía elástica
    derecha""")
RUSSIAN = names("""{quantity} {part} {side} колесо | время, поперечное перемещение, вертикальное перемещение, угол боковой качки,
    поперечная скорость, вертикальная скорость, скорость боковой качки, поперечное ускорение, вертикальное ускорение, ускорение
    боковой качки | угол контакта, нормальная сила, поперечная сила, вертикальная сила, поперечное положение контакта, вертикальное
    положение контакта, радиус качения | левое правое | поверхность-катания гребень | кинетическая энергия поперечная, кинетическая
    энергия вертикальная, кинетическая энергия качки, потенциальная энергия веса, потенциальная энергия нагрузки, упругая энергия
    левая, упругая энергия правая""")
CHINESE = names("""{side}轮{part}{quantity} | 时间, 横向位移, 垂向位移, 侧滚角, 横向速度, 垂向速度, 侧滚角速度, 横向加速度,
    垂向加速度, 侧滚角加速度 | 接触角, 法向力, 横向力, 垂向力, 接触点横向位置, 接触点垂向位置, 滚动半径 | 左 右 | 踏面 轮缘 |
    横向动能, 垂向动能, 侧滚动能, 重力势能, 载荷势能, 左侧弹性势能, 右侧弹性势能""")
JAPANESE = names("""{side}車輪{part}{quantity} | 時間, 左右変位, 上下変位, ロール角, 左右速度, 上下速度, ロール角速度, 左右加速度,
    上下加速度, ロール角加速度 | 接触角, 法線力, 横圧, 輪重, 接触点左右位置, 接触点上下位置, 転がり半径 | 左 右 | 踏面 フランジ |
    左右運動エネルギー, 上下運動エネルギー, ロール運動エネルギー, 重力位置エネルギー, 荷重位置エネルギー, 左弾性エネルギー,
    右弾性エネルギー""")
MODELICA = names("""wheelset.{side}Wheel.{part}.{quantity} | time, wheelset.y, wheelset.z, wheelset.phi, der(wheelset.y),
    der(wheelset.z), der(wheelset.phi), der(der(wheelset.y)), der(der(wheelset.z)), der(der(wheelset.phi)) | delta, f_n, f_y, f_z,
    r_y, r_z, radius | left right | tread flange | wheelset.E_kin_y, wheelset.E_kin_z, wheelset.E_kin_phi, wheelset.E_pot_g,
    wheelset.E_pot_load, wheelset.leftWheel.E_elastic, wheelset.rightWheel.E_elastic""")
NUMBERED = names("""{quantity}_{side}{part} | t, y, z, phi, vy, vz, omega, ay, az, alpha | gamma, Nf, Yf, Qf, yc, zc, rr | L R | 1 2
    | Tkin_y, Tkin_z, Tkin_phi, Upot_g, Upot_Q, Uel_L, Uel_R""")
TWO_DIGITS = names("""{quantity}{side}{part} | t, y, z, phi, y', z', phi', y'', z'', phi'' | delta, N, Y, Q, yc, zc, r | 1 2 | 1 2
    | Ek_y, Ek_z, Ek_phi, Ep_g, Ep_Q, Eel_1, Eel_2""")
CAMELS = {column: re.sub(r" (\w)", lambda found: found[1].upper(), name) for column, name in names().items()}
OF_R = {column: name.replace(" ", ".") for column, name in names().items()}
UPPER = {column: name.upper().replace(" ", "_") for column, name in names().items()}

# Units -------------------------------------------------------------------------------------
MICRO = {"time": ("µs", 1e6), "length": ("cm", 1e2), "angle": ("µrad", 1e6), "speed": ("cm/s", 1e2), "force": ("daN", 0.1),
         "energy": ("kJ", 1e-3)}
OF_AMERICA = {"length": ("ft", 1/0.3048), "speed": ("ft/s", 1/0.3048), "acc": ("ft/s^2", 1/0.3048),
              "force": ("kip", 1/4448.2216152605), "energy": ("ft-lbf", 1/1.3558179483314), "angle": ("deg", DEGREE)}
SEMICOLONS = {"sep": ";", "decimal": ","}


# Texts -------------------------------------------------------------------------------------
def of_rows(change: Callable[[int, str], str], head: int = 1) -> Callable[[str], str]:
    """A change of the lines below the head, from the number of each and its text."""
    def changed(text: str) -> str:
        lines = text.splitlines()
        return "\n".join([*lines[:head], *(change(k, line) for k, line in enumerate(lines[head:]))]) + "\n"
    return changed


def encoded(encoding: str) -> Callable[[str], bytes]:
    return lambda text: text.encode(encoding)


def grouped(text: str) -> str:
    """Three digits of large numbers stand together, with narrow blanks that do not break between them."""
    return re.sub(r"(?<![\w,])\d{4,}(?=[,;\n])", lambda found: f"{int(found[0]):,}".replace(",", "\u202f"), text)


def tecplot(text: str) -> str:
    head, *rows = text.splitlines()
    variables = "\n".join(f'"{name}"' for name in head.split(";"))
    return f'TITLE = "LD benchmark"\nVARIABLES =\n{variables}\nZONE T="wheelset", I={len(rows)}, F=POINT\n' + "\n".join(rows) + "\n"


def matrix(text: str) -> str:
    head, *rows = text.splitlines()
    return f"% {head}\ndata = [\n" + "\n".join(f"{row};" for row in rows) + "\n];\n"


def piped(text: str) -> str:
    head, *rows = (f"| {line.replace('|', ' | ')} |" for line in text.splitlines())
    return "\n".join([head, "|---"*len(ALL) + "|", *rows]) + "\n"


def in_pages(text: str) -> str:
    """The head stands again above every hundred rows, on a new page."""
    names_, units, *rows = text.splitlines()
    return "".join(f"\f {names_}\n {units}\n" + "".join(f" {row}\n" for row in rows[k:k + 100]) for k in range(0, len(rows), 100))


def with_names_of_r(text: str) -> str:
    """As R writes a data frame: quoted names without blanks and brackets, and names of rows without one above them."""
    head, *rows = text.splitlines()
    quoted = ",".join('"' + re.sub(r"[^\w.]", ".", name) + '"' for name in head.split(","))
    return "\n".join(['"",' + quoted, *(f'"{k}",{row}' for k, row in enumerate(rows, 1))]) + "\n"


def coarse_between_events(frame: Frame) -> Frame:
    """Times to a ms, but those of rows at events in full, so that a time may fall back by the rounding."""
    t = frame["time"]
    return frame.assign(time=t.where((t*1e4 % 1 - 0.5).abs() < 0.499, t.round(3)))


LABVIEW = ("LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\nDate\t2006/06/12\nTime\t10:31:07,52\n"
           "***End_of_Header***\t\n\t\n")


class Habit(NamedTuple):
    """How somebody writes a file."""

    form: Mapping[str, Any] = {}
    after: Callable[[str], str | bytes] = str
    name: str = "{case}.csv"
    change: Change = lambda frame: frame
    verdict: str = ""

    def row(self, change: Change = lambda frame: frame, cases: tuple[str, ...] = (), **form: Any) -> Row:
        return Row(both(change, self.change), {**self.form, **form}, self.after, name=self.name, cases=cases, verdict=self.verdict)


TXT, DAT = "{case}.txt", "{case}.dat"
WAYS = {
    # Cells that are no number.
    "not_available_of_a_spreadsheet": Habit({**SEMICOLONS, "na": "#N/A", "eol": "\r\n", "before": "sep=;\n", "units": MM_KN}),
    "stars_for_open_contacts": Habit({"sep": " ", "names": UPPER, "head": ("{name}",), "na": "**************",
                                      "digits": "%14.6E"}, name="{case}.out"),
    "indefinite_of_windows": Habit({"sep": "\t", "na": "-1.#IND", "eol": "\r\n", "units": MM_KN}, name=TXT),
    "dashes_for_open_contacts": Habit({"sep": ";", "na": "--", "head": ("{name} / {unit}",), "units": MM_KN}),
    # Cells.
    "all_cells_quoted": Habit(after=lambda text: re.sub(r"[^,\n]+", lambda found: f'"{found[0]}"', text)),
    "unicode_minus": Habit({"sep": "\t", "units": MM_KN}, lambda text: re.sub(r"-(?=\d)", "\u2212", text), TXT),
    "digits_in_groups": Habit({**SEMICOLONS, "digits": "%.6f", "names": SPANISH}, grouped),
    "small_d_without_sign": Habit({"sep": " ", "digits": "%.9e", "names": NUMBERED, "head": ("{name}",)},
                                  lambda text: re.sub(r"(\d)e\+?(-?\d)", r"\1d\2", text), DAT),
    # Lines.
    "last_line_END": Habit({"sep": " ", "names": UPPER, "head": TWO_LINES}, lambda text: text + "END\n", DAT),
    "closing_words": Habit({"sep": "\t"}, lambda text: text + "\nNormal termination of job 17\nCPU time: 3.21 s\n", TXT),
    "units_above_names": Habit({"sep": ";", "head": ("{unit}", "{name}"), "units": MM_KN}),
    "names_units_and_numbers_of_columns": Habit({"head": ("{name}", "({unit})")}, lambda text: re.sub(
        r"\A(.*\n.*\n)", lambda found: found[1] + ",".join(map(str, range(1, len(ALL) + 1))) + "\n", text)),
    "units_in_a_comment": Habit({"head": ("{name}",), "units": MM_KN,
                                 "before": "# units: mm, kN, s, rad, m/s, m/s2, rad/s, rad/s2, J\n"}),
    "a_head_on_every_page": Habit({"sep": " ", "names": UPPER, "head": TWO_LINES}, in_pages, "{case}.lis"),
    "names_between_commas_rows_between_blanks": Habit(after=of_rows(lambda k, line: "  " + line.replace(",", "  ")), name=DAT),
    "every_row_twice": Habit({"sep": "\t"}, of_rows(lambda k, line: f"{line}\n{line}"), TXT),
    # Programs.
    "matrix_of_matlab": Habit({"sep": " ", "head": ("{name}[{unit}]",), "names": CAMELS}, matrix, "{case}.m"),
    "tecplot": Habit({"sep": ";", "units": MM_KN}, lambda text: tecplot(text).replace(";", " "), DAT),
    "pipes": Habit({"sep": "|", "units": MM_KN}, piped, "{case}.md"),
    "frame_of_r": Habit(after=with_names_of_r),
    "labview": Habit({"sep": "\t", "before": LABVIEW, "eol": "\r\n"}, name="{case}.lvm"),
    "modelica": Habit({"names": MODELICA, "head": ('"{name}"',)}),
    # Names.
    "wheel_letter_and_contact_number": Habit({"sep": " ", "names": NUMBERED, "head": TWO_LINES, "units": MM_KN}, name=TXT),
    "Q_and_Y_with_two_digits": Habit({**SEMICOLONS, "names": TWO_DIGITS, "units": MM_KN}),
    "units_at_the_end_of_names": Habit({"names": {}, "head": ("{name}_{unit}",), "sep": " ",
                                        "units": {"speed": ("mps", 1), "acc": ("mps2", 1), "spin": ("radps", 1),
                                                  "spinacc": ("radps2", 1)}}, name=TXT),
    "italian": Habit({**SEMICOLONS, "names": ITALIAN, "units": MM_KN}, encoded("cp1252")),
    "polish": Habit({**SEMICOLONS, "names": POLISH, "units": MM_KN}, encoded("cp1250")),
    "russian": Habit({**SEMICOLONS, "names": RUSSIAN}, encoded("cp1251")),
    "chinese": Habit({"names": CHINESE, "units": MM_KN}, encoded("gb18030")),
    "japanese": Habit({"names": JAPANESE, "sep": "\t", "units": {**MM_KN, "angle": ("mrad", 1e3)}}, encoded("shift_jis"), TXT),
    # Units and frames.
    "micrometres_of_time": Habit({"units": MICRO, "head": ("{name} <{unit}>",)}),
    "feet_and_kips": Habit({"units": OF_AMERICA, "names": UPPER}),
    "X_backwards": Habit({"sep": ";"}, change=both(times(-1.0, *RIGHT, *of("Fy")), times(-1.0, *ROLL)), verdict=DOUBTFUL),
    "vertical_forces_on_the_rail": Habit({"sep": "\t"}, name=TXT, change=times(-1.0, *of("Fz"))),
    "all_columns_backwards": Habit({"order": ALL[::-1], "units": MM_KN}),
    # Times.
    "times_to_a_ms": Habit({"sep": ";"}, change=each(["time"], lambda t: t.round(3)), verdict=DOUBTFUL),
    "times_to_a_ms_but_at_events": Habit({"sep": ";"}, change=coarse_between_events, verdict=DOUBTFUL),
    "times_half_as_dense_as_rows": Habit({"sep": "\t"}, name=TXT, verdict=DOUBTFUL, change=each(
        ["time"], lambda t: (t*5e3).round()/5e3)),
}
HABITS = {name: way.row() for name, way in WAYS.items()}


# One fault in each ------------------------------------------------------------------------------
def drift(amount: float, column: str) -> Change:
    """A drift that grows in proportion to the time to this amount at the end."""
    return lambda f: f.assign(**{column: f[column] + amount*f["time"]/f["time"].iloc[-1]})


def at_row(time: float, column: str, change: Callable[[float], float]) -> Change:
    """One value that is wrong."""
    def changed(frame: Frame) -> Frame:
        row = int(np.searchsorted(frame["time"], time))
        values = frame[column].to_numpy(float).copy()
        values[row] = change(values[row])
        return frame.assign(**{column: values})
    return changed


def capped(frame: Frame, most: float = 5e5) -> Frame:
    """Forces of a transducer that shows no more than this."""
    return frame.assign(**{f"{q}_{c}": frame[f"{q}_{c}"]*(most/frame[f"N_{c}"].clip(lower=most)) for c in CONTACTS for q in FORCES})


def frozen(frame: Frame, start: float = 0.075, end: float = 0.078) -> Frame:
    """All columns but the time keep their values for some ms."""
    t = frame["time"]
    held = frame.mask((t > start) & (t <= end)).ffill()
    return held.where(~frame.isna() | ((t > start) & (t <= end)).to_numpy()[:, None]).assign(time=t)


def late(rows: int, *columns: str) -> Change:
    return each(columns, lambda x: x.shift(rows).bfill())


def one_contact_a_wheel(frame: Frame) -> Frame:
    """No force on the tread while the flange of its wheel presses."""
    return frame.assign(**{f"{q}_{side}T": frame[f"{q}_{side}T"].where(~(frame[f"N_{side}F"] > 0.0), 0.0)
                           for side in "LR" for q in FORCES})


def without_the_peak(frame: Frame) -> Frame:
    """No forces of the left flange for 0.6 ms about its first peak."""
    near = (frame["time"] - first_peak(frame)).abs() < 3e-4
    return frame.assign(**{f"{q}_LF": frame[f"{q}_LF"].mask(near) for q in FORCES})


def paused(frame: Frame, at: float = 0.078, pause: float = 0.010) -> Frame:
    return frame.assign(time=frame["time"] + pause*(frame["time"] > at))


def energies_without_the_elastic(frame: Frame) -> list[tuple[str, str, Any]]:
    kinetic, potential = frame[KINETIC].sum(axis=1), frame[["PE_grav", "PE_load"]].sum(axis=1)
    return [("kinetic energy", "J", kinetic), ("potential energy", "J", potential), ("total energy", "J", kinetic + potential)]


def started_late(frame: Frame) -> Frame:
    """A second at rest before the ramp of force begins."""
    rest = frame.iloc[[0]*100].assign(time=np.arange(100)*0.01)
    return pd.concat([rest, frame.assign(time=frame["time"] + 1.0)], ignore_index=True)


class Fault(NamedTuple):
    row: Row
    words: str          # what one of the findings that are not passed must name


def fault(words: str, way: str, change: Change = lambda frame: frame, cases: Iterable[str] = (), **form: Any) -> Fault:
    return Fault(WAYS[way].row(change, tuple(cases), **form), words)


PLANTED = {
    # Energies.
    "elastic_energies_left_out": fault("energy", "all_cells_quoted", order=[*CALL, *ENERGY[:-2]]),
    "elastic_energies_zero": fault("energy", "italian", times(0.0, *ENERGY[-2:])),
    "elastic_energies_zero_in_the_ramp": fault("elastic energy", "italian", times(0.0, *ENERGY[-2:]), cases=["ex5_aw"]),
    "total_energy_without_the_elastic": fault("energy", "closing_words", order=CALL, extra=energies_without_the_elastic),
    "energies_in_kJ_below_J": fault("energy", "last_line_END", times(1e-3, *ENERGY)),
    "roll_energy_of_the_pitch_inertia": fault("energy", "matrix_of_matlab", times(168/656, "KE_roll")),
    "elastic_energies_of_the_other_wheel": fault("elastic energy", "labview", lambda f: f.assign(
        PE_elastic_L=f["PE_elastic_R"], PE_elastic_R=f["PE_elastic_L"])),
    # Drifts and one row.
    "Y_drifts_by_0.2_mm": fault("Y", "not_available_of_a_spreadsheet", drift(0.0002, "Y")),
    "Z_drifts_by_0.1_mm": fault("Z", "polish", drift(0.0001, "Z")),
    "roll_drifts_by_0.2_mrad": fault("roll", "small_d_without_sign", drift(0.0002, "roll")),
    "one_Y_off_by_1_mm": fault("Y", "tecplot", at_row(0.09, "Y", lambda y: y + 0.001)),
    "one_aZ_hundredfold": fault("aZ|vertical acceleration", "pipes", at_row(0.09, "aZ", lambda a: 100*a)),
    "one_y_of_a_tread_off_by_5_mm": fault("y_LT", "frame_of_r", at_row(0.01, "y_LT", lambda y: y + 0.005)),
    "one_Fz_a_third_larger": fault("vertical", "units_in_a_comment", at_row(0.09, "Fz_RT", lambda force: 1.3*force + 1e4)),
    "values_frozen_for_3_ms": fault("Y|vY|time|velocity", "units_above_names", frozen),
    # Forces.
    "flange_forces_all_zero": fault("flange|N_LF", "frame_of_r", both(
        times(0.0, *of(*FORCES, contacts=("LF", "RF"))), each(of(*PLACES, contacts=("LF", "RF")), lambda x: np.nan))),
    "forces_capped_at_500_kN": fault("force|N_L", "stars_for_open_contacts", capped),
    "forces_to_10_kN": fault("force|N_L|digits", "labview", each(of(*FORCES), lambda x: (x/1e4).round()*1e4)),
    "no_tread_force_beside_a_flange": fault("force|acceler", "chinese", one_contact_a_wheel),
    "normal_force_is_a_sum_of_components": fault("N_|normal", "japanese", lambda f: f.assign(
        **{f"N_{c}": f[f"Fy_{c}"].abs() + f[f"Fz_{c}"].abs() for c in CONTACTS})),
    "peak_cells_blank": fault("N_LF", "dashes_for_open_contacts", without_the_peak),
    "forces_halved": fault("force|load", "russian", times(0.5, *of(*FORCES))),
    "right_wheel_is_a_copy": fault("_R", "indefinite_of_windows", lambda f: f.assign(
        **{f"{q}_R{part}": f[f"{q}_L{part}"] for q in POINT for part in "TF"})),
    # Motion.
    "roll_acceleration_negative": fault("roll", "modelica", times(-1.0, "roll_acc")),
    "accelerations_half_a_ms_late": fault("acceler|aY|aZ|roll_acc", "every_row_twice", late(5, "aY", "aZ", "roll_acc")),
    "vertical_velocity_of_the_left_wheel": fault("vZ|vertical velocity", "feet_and_kips", lambda f: f.assign(
        vZ=f["vZ"] + 0.75*f["roll_rate"])),
    "Y_in_cm_below_mm": fault("lateral displacement", "names_units_and_numbers_of_columns", times(0.1, "Y"), units=MM_KN),
    "Y_to_a_mm": fault("lateral|Y", "Q_and_Y_with_two_digits", each(["Y"], lambda y: y.round(3))),
    "start_2_mm_aside": fault("Y|start|time", "unicode_minus", lambda f: f[f["Y"].abs().cummax() >= 0.002].assign(
        time=lambda g: g["time"] - g["time"].iloc[0])),
    # Places.
    "right_flange_point_5_mm_inwards": fault("RF", "micrometres_of_time", plus(0.005, "y_RF")),
    "radius_with_the_vertical_displacement": fault("radius", "units_at_the_end_of_names", lambda f: f.assign(
        **{f"radius_{c}": f[f"radius_{c}"] + f["Z"] for c in CONTACTS})),
    "flange_angle_of_a_drawing": fault("angle", "digits_in_groups", closed_as(np.pi/3, "angle_LF", "angle_RF")),
    "gon_below_degrees": fault("angle|roll", "vertical_forces_on_the_rail", units={"angle": ("deg", 200/np.pi)}),
    # Times.
    "pause_of_10_ms": fault("rows are missing", "wheel_letter_and_contact_number", paused),
    "run_twice_in_one_file": fault("time|row", "a_head_on_every_page", lambda f: pd.concat([f, f], ignore_index=True)),
    "ramp_a_second_late": fault("F_ext|force|time|ramp", "all_columns_backwards", started_late, cases=["ex5_aw"]),
}
# Faults that passed when the rules had been made for the others; rules were made for these, too.
AFTERWARDS = "elastic_energies_of_the_other_wheel", "one_y_of_a_tread_off_by_5_mm", "one_Fz_a_third_larger"
