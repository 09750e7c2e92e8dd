"""ldbench from Python: cases, runs, the contact table, column files.

    import ldbench
    case = ldbench.Case.exercise(1, "aw").replace(vY=0.3)
    run = ldbench.run(case, progress=True)
    run.columns.plot("time", "Y")

Everything is in SI units and radians, in the track frame: X forward, Y to the left, Z up.
"""
from ._core import Error, version
from .case import Case
from .columns import read_columns
from .ensemble import ensemble
from .run import Event, Run, run
from .table import ContactTable
from .view import view

__all__ = ["Case", "ContactTable", "Error", "Event", "Run", "ensemble", "read_columns", "run", "view"]
__version__ = version()
