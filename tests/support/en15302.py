"""Reference wheels and the reference rail of EN 15302:2021, annex I, as formulas, and their points as profile files.

A zone holds from its first y on [mm], y = 0 on the tape circle of a wheel and on the line of the rail above which the tape
circle of the centred wheel stands; depth grows downwards [mm]. A zone is a line (value at y = 0, slope), or an arc (y and
depth of its centre, radius, side: 1 below the centre, -1 above it).

The last zone of wheel C begins at 59 mm with the depth with which the zone before it ends.
"""
from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

from ldbench import Case
from ldbench.conicity import level_rows
from ldbench.geometry.pair import raised_surfaces, rigid_geometry

TAPE_CIRCLES = 1.5          # distance between the tape circles, and between the lines of the rails [m]
TAPE_CIRCLE = 70.0          # of a wheel, from its back [mm]
RADIUS = 0.46               # on the tape circle [m]
SMALLER = 0.459             # of the right wheel in the combinations with diameters of 920 mm and 918 mm [m]
GAUGE_DEPTH = 14.0          # below the top of the rail [mm]
NEAR = 1e-4                 # to which displacements are known where the contact jumps [mm]
FINE, GROWTH, STEP = 0.005, 1.2, 0.1     # distance between points at the ends of a zone, its growth, largest distance [mm]


@dataclass(frozen=True)
class Arc:
    """Part of a circle [mm]."""

    y: float
    depth: float
    radius: float
    side: int

    def __call__(self, y: np.ndarray) -> np.ndarray:
        return self.depth + self.side*np.sqrt(np.maximum(self.radius**2 - (y - self.y)**2, 0))


@dataclass(frozen=True)
class Line:
    """A line [mm]."""

    at_zero: float
    slope: float

    def __call__(self, y: np.ndarray) -> np.ndarray:
        return self.at_zero + self.slope*y


Zones = dict[float, Arc | Line]
NARROW = 14375**0.5         # depth of the centre of a wheel I's throat [mm]
ENDS = {"A": 65.0, "B": 65.0, "C": 65.0, "H": 65.0, "I": 65.0, "rail": 39.2705}     # last y of a profile [mm]
PROFILES: dict[str, Zones] = {
    "A": {-70.0: Arc(-49.5, 9.51926, 20.5, 1), -62.7647: Arc(-55.0, 16.00065, 12.0, 1), -49.6625: Arc(-58.5583, 8.83556, 20.0, 1),
          -39.7645: Line(-93.57685, -2.7475), -38.7372: Arc(-25.5816, 17.64215, 14.0, -1),
          -29.4591: Arc(-2.6594, 97.16493, 96.76055, -1), -10.8749: Arc(18.4173, 344.50806, 345.0, -1),
          18.4173: Line(-0.49194, 0.0), 30.0: Line(1.50804, -0.066666), 60.0: Line(57.50808, -1.0)},
    "B": {-70.0: Arc(-49.5, 9.5193, 20.5, 1), -62.7647: Arc(-55.0, 16.0, 12.0, 1), -49.6625: Arc(-58.5583, 8.8349, 20.0, 1),
          -39.764: Line(-93.5767, -2.7475), -38.7879: Arc(-25.6322, 17.7814, 14.0, -1), -29.3505: Arc(2.5204, 119.9745, 120.0, -1),
          -0.4787: Line(0.0, -0.025), 30.0: Line(0.75, -0.05), 60.0: Line(57.75, -1.0)},
    "C": {-70.0: Line(21.39173 + 7.11537*69.40268, 7.11537), -69.4027: Arc(-59.5, 20.00006, 10.0, 1),
          -59.5: Arc(-60.4941, 12.02753, 18.0, 1), -43.8048: Line(11.96051 - 2.47508685*41.05339, -2.47508685),
          -41.0534: Arc(-29.0, 16.830365, 13.0, -1), -32.3621: Arc(-6.5, 100.870534, 100.0, -1),
          -17.587: Arc(19.0, 329.45258, 330.0, -1), 19.0: Line(-0.54742374, 0.0), 29.0: Line(-0.54742374 + 2.9, -0.1),
          59.0: Line(-3.54742374 + 59.0, -1.0)},
    "H": {-70.0: Arc(-49.5, 9.5193, 20.5, 1), -62.7647: Arc(-55.0, 16.0, 12.0, 1), -49.6625: Arc(-58.5583, 8.8349, 20.0, 1),
          -39.7645: Line(-93.5767, -2.7475), -38.722: Arc(-25.5663, 17.6003, 14.0, -1), -28.3119: Line(-1.7902, -0.2),
          -10.2297: Line(0.0, -0.025), 30.0: Line(1.251, -0.0667), 60.0: Line(57.249, -1.0)},
    "I": {-70.0: Arc(-49.5, 9.51929, 20.5, 1), -62.7647: Arc(-55.0, 16.00054, 12.0, 1), -49.6625: Arc(-58.5583, 8.83545, 20.0, 1),
          -39.764: Line(-93.5767, -2.7475), -39.0486: Arc(-25.8929, 18.49733, 14.0, -1), -29.9231: Arc(5.0, NARROW, 120.0, -1),
          5.0: Line(NARROW - 120.0, 0.0), 30.0: Line(1.89679, -0.0667), 60.0: Line(57.89479, -1.0)},
    "rail": {-32.634: Arc(-19.63949, 15.899044, 13.0, -1), -23.2401: Arc(-1.0825, 80.277908, 80.0, -1),
             -7.8749: Arc(17.5966, 299.48349, 300.0, -1), 13.0989: Arc(14.29829, 79.508225, 80.0, -1),
             28.6709: Arc(26.33535, 13.598369, 13.0, -1)}}
# Wheel A without the step with which two of its zones meet: the throat is moved onto the tread's zone.
STEP_AT = -29.4591
_throat, _tread = PROFILES["A"][-38.7372], PROFILES["A"][STEP_AT]
PROFILES["A closed"] = PROFILES["A"] | {-38.7372: replace(_throat, depth=_throat.depth + _tread(STEP_AT) - _throat(STEP_AT))}
ENDS["A closed"] = ENDS["A"]


def depth(name: str, y: np.ndarray) -> np.ndarray:
    """Depth of a profile at y [mm]."""
    zones = list(PROFILES[name].values())
    which = np.clip(np.searchsorted(list(PROFILES[name]), y, "right") - 1, 0, len(zones) - 1)
    return np.select([which == k for k in range(len(zones))], [zone(y) for zone in zones])


def points(name: str) -> np.ndarray:
    """Points of a profile, (n, 2) [mm], y from a wheel's back or from the rail's line, z up: dense where zones meet."""
    found = []
    for (first, zone), last in zip(PROFILES[name].items(), [*list(PROFILES[name])[1:], ENDS[name]], strict=True):
        y = np.linspace(first, last, 20001)
        along = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(y), np.diff(zone(y))))])
        half = np.concatenate([[0.0], np.cumsum(np.minimum(FINE*GROWTH**np.arange(1000), STEP))])
        half = half[half < along[-1]/2 - FINE]
        y = np.interp([*half, *(along[-1] - half[::-1])], along, y)
        found.append(np.column_stack([y, -zone(y)])[bool(found):])
    return np.vstack(found) + [0.0 if name == "rail" else TAPE_CIRCLE, 0.0]


# Rolling radius differences of annex J; with two wheels alike the tables are odd, and only y >= 0 stands here.
PITCH = 0.1         # between displacements [mm]
# First displacement [mm] and values [um], as printed.
TABLES: dict[str, tuple[float, str]] = {
    "A": (0.0, (
        "0 28 51 71 93 116 142 168 197 227 259 292 327 364 402 442 484 572 572 619 667 717 769 822 877 934 993 1053 1114 1178 "
        "1243 1294 1349 1407 1469 1534 1603 1675 1751 1830 1913 1999 2089 2182 2279 2379 2483 2591 2702 2817 2936 3058 3184 "
        "3314 3447 3584 3725 3870 4018 4170 4327 4486 4650 5061 5688 6515 7590 9001 10940")),
    "B": (0.0, (
        "0 5 10 15 20 25 30 35 40 45 50 55 60 65 70 75 80 85 90 95 100 105 110 115 120 125 130 135 140 145 1948 2001 2055 2110 "
        "2165 2222 2279 2336 2395 2454 2515 2576 2637 2700 2763 2827 2892 2958 3025 3092 3160 3229 3299 3370 3441 3513 3586 "
        "3660 3735 3810 3886 3963 4041 4120 5408 6132 7076 8304 9942 12319")),
    "C": (0.0, (
        "0 103 206 309 412 515 618 721 825 928 1024 1117 1164 1179 1192 1205 1218 1231 1244 1257 1271 1284 1297 1310 1323 1336 "
        "1349 1363 1376 1389 1402 1415 1428 1441 1455 1468 1481 1494 1507 1520 1533 1547 1560 1573 1586 1599 1612 1625 1639 "
        "1652 1665 1678 1692 1705 1719 1732 1746 1760 1773 1787 1801 1815 1829 1843 1857 1871 1885 1899 1913 1928 1942 1956 "
        "1971 1985 2000 2015 2029 2071 2130 2191 2255 2322 2390 2462 2536 2613 2692 2774 2858 2946 3035 3128 3223 3320 12606")),
    "H": (0.0, (
        "0 5 10 15 20 25 30 35 40 45 50 55 60 65 70 75 80 85 90 95 100 105 110 115 120 125 2402 2424 2447 2469 2492 1514 2537 "
        "2559 2582 2604 2627 2649 2672 2694 2717 2739 2762 2784 2807 2829 2852 2874 2897 2919 2942 2964 2987 3009 3032 3054 "
        "3077 3099 3122 3144 3167 3189 3212 3234 3257 3279 3302 3324 11199")),
    "I": (0.0, (
        "0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 2353 2414 2475 2538 2601 2665 2729 2795 2861 2928 2996 3065 3134 3205 3276 3348 "
        "3421 3494 3569 3644 3720 3797 3875 3953 4033 4113 4194 4276 4358 4442 4526 4612 4696 4728 4761 4793 4826 4859 4892 "
        "4925 4958 4992 5025 5059 5092 5126 5160 5194 5469 6075 6878 7922 9288 11150")),
    "A-918": (-6.9, (
        "-12396 -9940 -8001 -6590 -5515 -4688 -4061 -3650 -3486 -3327 -3170 -3018 -2870 -2725 -2584 -2447 -2314 -2184 -2058 "
        "-1936 -1817 -1702 -1591 -1483 -1379 -1279 -1182 -1089 -999 -913 -830 -751 -675 -603 -534 -469 -407 -349 -294 -243 -178 "
        "-114 -53 7 66 123 178 231 283 333 381 428 473 516 558 598 636 673 708 741 773 803 832 858 884 907 929 949 972 1000 "
        "1028 1051 1071 1093 1116 1142 1168 1197 1227 1259 1292 1327 1364 1402 1442 1484 1572 1572 1619 1667 1717 1769 1822 "
        "1877 1934 1993 2053 2114 2178 2243 2294 2349 2407 2469 2534 2603 2675 2751 2830 2913 2999 3089 3182 3279 3379 3483 "
        "3591 3702 3817 3936 4058 4184 4314 4447 4584 4725 4870 5018 5170 5327 5486 5650 6061 6688 7515 8590 10001 11940")),
    "B-918": (-6.9, (
        "-11319 -8942 -7304 -6076 -5132 -4408 -3120 -3041 -2963 -2886 -2810 -2735 -2660 -2586 -2513 -2441 -2370 -2299 -2229 "
        "-2160 -2092 -2025 -1958 -1892 -1827 -1763 -1700 -1637 -1576 -1515 -1454 -1395 -1336 -1279 -1222 -1165 -1110 -1055 "
        "-1001 -948 855 860 865 870 875 880 885 890 895 900 905 910 915 920 925 930 935 940 945 950 955 960 965 970 975 980 985 "
        "990 995 1000 1005 1010 1015 1020 1025 1030 1035 1040 1045 1050 1055 1060 1065 1070 1075 1080 1085 1090 1095 1100 1105 "
        "1110 1115 1120 1125 1130 1135 1140 1145 2948 3001 3055 3110 3165 3222 3279 3336 3395 3454 3515 3576 3637 3700 3763 "
        "3827 3892 3958 4025 4092 4160 4229 4299 4370 4441 4513 4586 4660 4735 4810 4886 4963 5041 5120 6408 7132 8076 9304 "
        "10942")),
    "H-918": (-6.8, (
        "-10199 -2324 -2302 -2279 -2257 -2234 -2212 -2189 -2167 -2144 -2122 -2099 -2077 -2054 -2032 -2009 -1987 -1964 -1942 "
        "-1919 -1897 -1874 -1852 -1829 -1807 -1784 -1762 -1739 -1717 -1694 -1672 -1649 -1627 -1604 -1582 -1559 -1537 -1514 "
        "-1492 -1469 -1447 -1424 -1402 875 880 885 890 895 900 905 910 915 920 925 930 935 940 945 950 955 960 965 970 975 980 "
        "985 990 995 1000 1005 1010 1015 1020 1025 1030 1035 1040 1045 1050 1055 1060 1065 1070 1075 1080 1085 1090 1095 1100 "
        "1105 1110 1115 1120 1125 3402 3424 3447 3469 3492 3514 3537 3559 3582 3604 3627 3649 3672 3694 3717 3739 3762 3784 "
        "3807 3829 3852 3874 3897 3919 3942 3964 3987 4009 4032 4054 4077 4099 4122 4144 4167 4189 4212 4234 4257 4279 4302 "
        "4324 12199")),
    "I-918": (-7.1, (
        "-10150 -8288 -6922 -5878 -5075 -4469 -4194 -4160 -4126 -4092 -4059 -4025 -3992 -3958 -3925 -3892 -3859 -3826 -3793 "
        "-3761 -3728 -3696 -3612 -3526 -3442 -3358 -3276 -3194 -3113 -3033 -2953 -2875 -2797 -2720 -2644 -2569 -2494 -2421 "
        "-2348 -2276 -2205 -2134 -2065 -1996 -1928 -1861 -1795 -1729 -1665 -1601 -1538 -1475 -1414 -1353 1000 1000 1000 1000 "
        "1000 1000 1000 1000 1000 1000 1000 1000 1000 1000 1000 1000 1000 1000 1000 1000 1000 1000 1000 1000 1000 1000 1000 "
        "1000 1000 1000 1000 1000 1000 1000 1000 3353 3414 3475 3538 3601 3665 3729 3795 3861 3928 3996 4065 4134 4205 4276 "
        "4348 4421 4494 4569 4644 4720 4797 4875 4953 5033 5113 5194 5276 5358 5442 5526 5612 5696 5728 5761 5793 5826 5859 "
        "5892 5925 5958 5992 6025 6059 6092 6126 6160 6194 6469 7075 7878 8922 10288")),
    "A-B": (-6.9, (
        "-12386 -10011 -8376 -7151 -6208 -5487 -4202 -4126 -4050 -3976 -3902 -3829 -3757 -3686 -3615 -3545 -3477 -3408 -3341 "
        "-3275 -3209 -3144 -3080 -3017 -2954 -2893 -2832 -2772 -2713 -2654 -2596 -2539 -2483 -2427 -2373 -2319 -2265 -2213 "
        "-2161 -2110 -308 -305 -302 -299 -296 -292 -289 -285 -282 -278 -275 -271 -268 -264 -260 -256 -252 -249 -245 -241 -237 "
        "-232 -228 -224 -220 -215 -211 -206 -198 -182 -165 -146 -125 -103 -78 -52 -25 4 35 68 102 139 176 216 257 300 345 391 "
        "439 489 540 594 649 705 764 824 886 949 1014 1081 1135 1192 1252 1316 1383 1454 1529 1607 1688 1773 1862 1954 2050 "
        "2149 2252 2359 2469 2583 2700 2821 2946 3075 3207 3343 3482 3626 3773 3924 4079 4237 4399 4566 4979 5609 6438 7516 "
        "8929 10871")),
}

# What breaks the smooth run of a table, by combination and displacement [mm]: the value that would not [mm]. Digits are wrong.
MISPRINTS = {("A", 1.7): 0.527, ("A-918", 1.7): 1.527, ("H", 3.1): 2.514}
# Two zones of wheel A meet at -29.4591 mm with a step of 0.056 um. An arc of 14 mm nearly conforms to one of 13 mm there, and
# the step moves the contact by 0.1 mm. The tables have the values of a wheel without the step.
AT_A_STEP = {("A", 6.2), ("A-918", 6.2), ("A-918", -6.2), ("A-B", 6.2)}


def table(combination: str) -> tuple[np.ndarray, np.ndarray]:
    """Displacements and rolling radius differences as printed [mm]."""
    first, words = TABLES[combination]
    values = np.array(words.split(), float)/1e3
    return np.round(first + PITCH*np.arange(values.size), 1), values


@cache
def gauge() -> float:
    """Distance between two rails, GAUGE_DEPTH below their top [m]."""
    y = np.linspace(-32.634, 39.2705, 2_000_001)
    down = depth("rail", y)
    side = y < y[np.argmin(down)]
    return TAPE_CIRCLES + 2e-3*float(np.interp(-np.min(down) - GAUGE_DEPTH, -down[side], y[side]))


def write(folder: Path) -> dict[str, str]:
    """Write all profiles; their paths by name."""
    paths = {}
    for name in PROFILES:
        paths[name] = str(folder/f"en15302_{name.replace(' ', '_')}.yz")
        np.savetxt(paths[name], points(name), fmt="%.9f")
    return paths


def case(combination: str, paths: dict[str, str]) -> Case:
    """The case of a combination, named as in ldbench.geometry.en15302: its right wheel is our left one."""
    left, _, right = combination.removesuffix("-918").partition("-")
    return Case.from_namelist("&case /").replace(
        wheel_profile=paths[left], wheel_profile_right=paths[right] if right else "", rail_profile=paths["rail"],
        gauge=gauge(), gauge_depth=1e-3*GAUGE_DEPTH, back_to_back=TAPE_CIRCLES - 2e-3*TAPE_CIRCLE, rolling_radius=RADIUS,
        table_folder="")


def radii(combination: str) -> tuple[float, float]:
    """Radii of both wheels on the tape circle [m]."""
    return RADIUS, SMALLER if combination.endswith("-918") else RADIUS


def deviations(combination: str, paths: dict[str, str]) -> tuple[np.ndarray, np.ndarray]:
    """Displacements of a combination's table [mm] and by how much the level wheelset's radius difference is off it [um].

    Misprints are put right. Where the radius difference jumps at a displacement of the table, either end of the jump counts.    """
    y, printed = table(combination)
    meant = [MISPRINTS.get((combination, y_k), value) for y_k, value in zip(y.tolist(), printed, strict=True)]
    made = case(combination, paths)
    handle = rigid_geometry(made)
    raised = raised_surfaces(made, handle, radii(combination))
    off = [1e6*level_rows(handle, 1e-3*(y + near), raised)[7] - 1e3*np.array(meant) for near in (-NEAR, 0.0, NEAR)]
    return y, np.min(np.abs(off), axis=0)
