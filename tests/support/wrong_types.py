"""Lines that a type checker must refuse. `make lint` fails where one of them passes, because its `type: ignore` is unused then.
Lines that it must accept stand below."""
import numpy as np

import ldbench


def wrong(case: ldbench.Case, run: ldbench.Run, table: ldbench.ContactTable) -> None:
    ldbench.Case(vYY=3)                                         # type: ignore[call-arg]
    ldbench.Case(model="springs")                               # type: ignore[arg-type]
    case.replace(vY="fast")                                     # type: ignore[arg-type]
    print(case.nonsense)                                        # type: ignore[attr-defined]
    case.vY = 3.0                                               # type: ignore[misc]
    run.closed(3)                                               # type: ignore[arg-type]
    table.force(0.0, 0.4568, 0.0, wheel="port")                 # type: ignore[arg-type]


def right(case: ldbench.Case, run: ldbench.Run) -> None:
    ldbench.ensemble(case, {"vY": np.linspace(0.1, 1.0, 5)})
    ldbench.ensemble("case.nml", {"vY": [0.1, 1.0], "model": ["hertz"]})
    ldbench.ensemble([case, case])
    run.impacts("LF")
