"""Units of the columns of a frame."""
from __future__ import annotations


class Units(dict[str, str]):
    """Units by column, for the `attrs` of a frame, which pandas copies in depth whenever a column is taken."""

    def __deepcopy__(self, memo: object) -> Units:
        return Units(self)
