"""ldbench from Python: cases, runs, the contact table, column files.

    import ldbench
    case = ldbench.Case.exercise(1, "aw").replace(vY=0.3, roll_link="rails")
    run = ldbench.run(case, progress=True)
    run.data.plot("time", "Y")
    other = ldbench.read_run("other_code.csv", map="other_code.toml")

Everything is in SI units and radians, in the track frame: X forward, Y to the left, Z up.
"""
import os
import sys

# `python -m ldbench` has the working folder first in its path. That may be a stranger's, whose numpy.py is not to be run: it goes
# before anything is imported that Python has not loaded at its own start, unless ldbench itself was found there.
if (sys.argv[:1] == ["-m"] and not getattr(sys.flags, "safe_path", False)
        and sys.path[:1] != [os.path.dirname(os.path.dirname(__file__))]):      # noqa: PTH120  # pathlib is not loaded yet
    del sys.path[:1]

import logging

from ._core.calls import version
from ._core.errors import Error, Warning
from .case import Case
from .ensembles.sweep import ensemble
from .profile import Profile
from .report.comparing import compare
from .results.columns import read_columns
from .results.contact_intervals import ContactInterval
from .results.events import Event
from .runs import Run, read_run, run
from .table import ContactTable
from .trust import Trust
from .viewer.page import view

__all__ = ["Case", "ContactInterval", "ContactTable", "Error", "Event", "Profile", "Run", "Trust", "Warning", "compare",
           "ensemble", "read_columns", "read_run", "run", "view"]
__version__ = version()
logging.getLogger(__name__).addHandler(logging.NullHandler())        # the program that imports it chooses what is shown
