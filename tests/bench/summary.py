"""The first page: the five figures that a reader needs."""
from __future__ import annotations

from collections.abc import Callable, Mapping

from measure import Measure, Section
from sheets import Table

TEXT = """Median (quartiles) of the rounds; every figure is on the pages that follow, with what it was measured by. A ratio
above 1 is in favour of ldbench. Of what was not measured this time there is a dash."""


def summary(sections: Mapping[str, Section]) -> Section:
    """From the sections that were run."""
    def found(name: str, wanted: Callable[[Measure], bool]) -> list[Measure]:
        return [m for m in sections[name].measures if wanted(m)] if name in sections else []

    peers = found("precision", lambda m: "SUNDIALS over ours" in m.quantity)
    cases = {m.case for m in peers}
    nearest = [min((m for m in peers if m.case == case), key=lambda m: m.median) for case in sorted(cases)]
    memory = found("cases", lambda m: m.quantity == "peak memory")
    rows = [
        ("the cases by the executable, one after the other", "s", found("cases", lambda m: m.case == "all cases")),
        ("the largest peak memory of one of them", "MB", sorted(memory, key=lambda m: -m.median)[:1]),
        ("an evaluation of all contact forces", "s", found(
            "evaluation", lambda m: (m.subject, m.quantity) == ("force alone", "time of an evaluation"))[-1:]),
        ("the best of the other integrators over ours at equal error, compiled", "times",
         sorted(nearest, key=lambda m: m.median)[::max(len(nearest) - 1, 1)]),
        ("a sweep by two processes, or threads, over one", "times", found(
            "ensemble", lambda m: m.quantity.startswith("times faster"))[-1:])]
    return Section("Five figures", TEXT, tables=[Table("What ldbench costs", ["figure", "value", "of"], [
        [what, f"{' to '.join(m.text() for m in some)} {unit}" if some else "–",
         ", ".join(f"{m.case}, {m.subject}" + f"; {m.note}"*bool(m.note) for m in some)] for what, unit, some in rows])])
