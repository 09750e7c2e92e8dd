"""What a run of the mirrored wheelset tells: columns and results."""
from __future__ import annotations

import re
from collections.abc import Mapping

import pandas as pd

NEGATIVE = "Y", "roll", "vY", "roll_rate", "aY", "roll_acc", "F_ext", "M_gyro", "delta_r"      # in the mirror
NEGATIVE_RESULTS = "farthest_left", "farthest_right", "largest_roll", "smallest_roll", "axle_roll", "rest_Y", "rest_roll", "pmax_y"
OTHER = {"left": "right", "right": "left", "largest_roll": "smallest_roll", "smallest_roll": "largest_roll",
         "LT": "RT", "LF": "RF", "RT": "LT", "RF": "LF"}


def mirrored(frame: pd.DataFrame) -> pd.DataFrame:
    """Columns, or geometry functions, of the mirrored wheelset."""
    names, signs = {}, {}
    for name in frame.columns:
        stem, _, side = name.rpartition("_")
        other = {"L": "R", "R": "L"}
        names[name] = f"{stem}_{other[side[0]]}{side[1:]}" if side in ("L", "R", "LT", "LF", "RT", "RF") else name
        signs[name] = -1 if name in NEGATIVE or stem in ("Fy", "y") else 1
    return pd.DataFrame({name: signs[name]*frame[names[name]] for name in frame.columns})


def mirrored_results(results: Mapping[str, object]) -> dict[str, object]:
    """Results of the mirrored wheelset."""
    image = {re.sub("|".join(OTHER), lambda word: OTHER[word[0]], name): x for name, x in results.items()}
    image = {name: -x if name in NEGATIVE_RESULTS else x for name, x in image.items()}
    return image | {"pmax_contact": OTHER.get(image.get("pmax_contact"), "")}
