"""The columns of a run of the mirrored wheelset."""
import pandas as pd

NEGATIVE = "Y", "roll", "vY", "roll_rate", "aY", "roll_acc", "F_ext", "M_gyro", "delta_r"      # in the mirror


def mirrored(frame: pd.DataFrame) -> pd.DataFrame:
    """Columns, or geometry functions, of the mirrored wheelset."""
    names, signs = {}, {}
    for name in frame.columns:
        stem, _, side = name.rpartition("_")
        other = {"L": "R", "R": "L"}
        names[name] = f"{stem}_{other[side[0]]}{side[1:]}" if side in ("L", "R", "LT", "LF", "RT", "RF") else name
        signs[name] = -1 if name in NEGATIVE or stem in ("Fy", "y") else 1
    return pd.DataFrame({name: signs[name]*frame[names[name]] for name in frame.columns})
