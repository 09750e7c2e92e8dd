"""Words of other languages for the quantities of the benchmark, in English, and the encodings that their files have.

English, French and German stand in `column_names`.
"""
from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from ldbench.tools import read_bytes

#: English words, and patterns of what Italian, Spanish, Polish, Russian, Chinese and Japanese say for them; letters stand without
#: marks above or below them.
FOREIGN = {
    "time": r"tiempo|czas|врем\w+|时间|時間|时刻|時刻",
    "wheelset": r"sala montata|eje montado|zestaw\w* kolow\w*|колесн\w+ пар\w+|轮对|輪對|輪軸",
    "rolling radius": r"raggio(?: di rotolamento)?|radio(?: de rodadura)?|promien\w*(?: toczn\w+)?|радиус\w*(?: качени\w+)?|"
                      r"滚动(?:圆)?半径|滾動(?:圓)?半徑|転がり半径|半径|半徑",
    "contact angle": r"接触角|接觸角|angolo di contatto|angulo de contacto|kat\w* kontaktu|уг[оло]+\w* контакта",
    "contact point": r"接触点|接觸點|接点",
    "kinetic energy": r"动能|動能|運動エネルギー", "potential energy": r"势能|勢能|位置エネルギー",
    "kinetic": r"cinetic\w+|kinetyczn\w+|кинетическ\w+", "potential": r"potenzial\w+|potencial\w*|potencjaln\w+|потенциальн\w+",
    "elastic": r"elastic[ao]|sprezyst\w+|упруг\w+|弹性|彈性|弾性",
    "energy": r"energi[ae]\b|энерги\w+|能量|エネルギー", "gravity": r"\bpeso\b|gravita\b|gravedad|ciezar\w*|вес[а]?\b|重力",
    "load": r"\bcarico\b|\bcarga\b|obciazeni\w+|нагрузк\w+|载荷|載荷|荷重",
    "wheel load": r"輪重|轮重|carico ruota|nacisk\w* kola", "lateral force": r"横圧|横压力",
    "roll": r"rollio|balanceo|przechyl\w*|боков\w+ качк\w+|качк\w+|крен\w*|侧滚|侧倾|側滾|側傾|ロール",
    "angle": r"angolo|angulo|\bkat\b|уг[оло]+\w*|角(?!速|加)",
    "acceleration": r"accelerazione|aceleracion|przyspieszeni\w+|ускорени\w+|角?加速度",
    "velocity": r"velocita|velocidad|predkos\w+|скорост\w+|角?速度",
    "displacement": r"spostamento|desplazamiento|przemieszczeni\w+|перемещени\w+|смещени\w+|位移|変位|變位",
    "position": r"posizione|posicion|polozeni\w+|положени\w+|координат\w+|位置",
    "normal": r"normaln\w+|нормальн\w+|法線|法线|法向", "force": r"\bforza|\bfuerza|\bsil[aye]\b|сил[аыу]\b|力",
    "lateral": r"trasversale|laterale|transversal|poprzeczn\w+|поперечн\w+|横向|橫向|左右",
    "vertical": r"verticale|pionow\w+|вертикальн\w+|垂向|竖向|豎向|垂直|上下|鉛直",
    "tread": r"superficie di rotolamento|piano di rotolamento|banda(?: de rodadura)?|powierzchni\w+ toczn\w+|"
             r"поверхност\w+ катани\w+|踏面",
    "flange": r"bordino|pestana|obrzez\w+|гребен\w+|гребн\w+|реборд\w+|轮缘|輪緣|フランジ",
    "left": r"sinistr[ao]|izquierd[ao]|\blew\w+|\bлев\w+|左", "right": r"destr[ao]|derech[ao]|\bpraw\w+|\bправ\w+|右",
    "wheel": r"\bruota|\brueda|\bkol[aeo]\b|колес\w+|車輪|车轮|轮|輪", "rail": r"\brotaia|\bcarril|\bszyn\w+|рельс\w*|钢轨|レール",
    "contact": r"contatto|contacto|kontakt(?:u|ow\w+)?\b|контакт\w*|接触|接觸",
    "pitch": r"beccheggio|cabeceo|тангаж\w*|点头|ピッチ",
    "yaw": r"imbardata|guinada|рыскани\w+|виляни\w+|摇头|ヨー"}
#: Encodings that files have which are neither in UTF-8 nor in UTF-16; the first one is that of a file whose names say nothing.
ENCODINGS = "cp1252", "cp1250", "cp1251", "koi8_r", "gb18030", "shift_jis", "euc_jp", "big5"
HEAD = 2**16        # of a file, in which its names stand [bytes]


def bare(words: str) -> str:
    """Words in small letters without marks above or below them."""
    parts = unicodedata.normalize("NFKD", words.lower().replace("ł", "l").replace("ø", "o").replace("đ", "d"))
    return "".join(c for c in parts if not unicodedata.combining(c))


# The longer of two patterns at one place is meant, so those of more letters stand first.
_WORDS = sorted(((bare(word), english) for english, words in FOREIGN.items() for word in re.split(r"\|(?![^(]*\))", words)),
                key=lambda pair: -len(pair[0]))
_WORD = re.compile("|".join(f"({word})" for word, _ in _WORDS))


def in_english(name: str) -> str:
    """A name whose words of other languages are in English; others stay."""
    words = re.sub(r"(?<=[^\W\d_])[-_]+(?=[^\W\d_])", " ", name)
    return _WORD.sub(lambda found: f" {_WORDS[(found.lastindex or 1) - 1][1]} ", bare(words))


def encoding_of(file: Path, understood: Callable[[str], int]) -> str:
    """The encoding of a file that is not in UTF: the one in which the most words of its head are understood."""
    data = read_bytes(file)
    with suppress(UnicodeDecodeError):
        data.decode("utf-8")
        return "utf-8"
    # Names have bytes beyond ASCII, and numbers have none.
    head = b"\n".join(line for line in re.split(rb"[\r\n]+", data[:HEAD])[:-1] if not line.isascii())
    best, most = ENCODINGS[0], 0
    for encoding in ENCODINGS:
        try:
            found = understood(head.decode(encoding))
        except UnicodeDecodeError:
            continue
        if found > most:
            best, most = encoding, found
    return best
