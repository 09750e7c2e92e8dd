"""Pictures of causes: a bar for each, the largest at the top."""
from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from ..plots.frame import legend_of_page, new_page
from ..plots.named import decoration, name, named_bars
from ..plots.style import BLUE, GREEN, GREY, ORANGE, PURPLE
from ..results.quantities import PAIRS
from .answers import NOT_AMONG, Answer, Trust
from .variations import PROGRAM

COLOURS = {**dict.fromkeys(PROGRAM, BLUE), "input": ORANGE, "smoothing": GREEN, "law": PURPLE, "others": GREY}
WORDS = {"program leaves open": BLUE, "inputs": ORANGE, "smoothing of profiles": GREEN, "contact law": PURPLE,
         "the others' sum": GREY}
BARS = 9            # of an answer, at most, with the others' sum
COLUMNS, ROWS = 4, 3    # of panels on a page
REPORTED = {"first_peak_N_LF": "first peak of the left flange", "t_return": "return to the centre"}
TITLE = "How far to trust an answer"
CAPTION = ("Each bar: by how much one cause alone changes the answer. Inputs are raised by 1 %, gauge, back_to_back, gauge_depth "
           f"by 0.1 mm. Not among the causes: {', '.join(NOT_AMONG)}.\n"
           "Below each title: the case's value, and the range that the program leaves open by twins, table accuracy, influence and "
           "bodies. "
           "A chaotic answer is one sample: its twins, whose starts differ by 3 µm at most, do not share it.")


def causes_pages(found: Trust, everything: bool = False) -> Iterator[Figure]:
    """The pages of a case: its answers, as `Trust.shown` lists them, a panel each."""
    answers = found.shown(everything)
    for first in range(0, len(answers), COLUMNS*ROWS):
        part = answers[first:first + COLUMNS*ROWS]
        columns = min(COLUMNS, len(part))
        figure = new_page(f"{TITLE}: {found.case}", found.title, CAPTION)
        axes = figure.subplots(-(-len(part)//columns), columns, squeeze=False).ravel()
        for ax, answer in zip(axes, part, strict=False):
            draw_causes(ax, found, answer, in_short(answer))
        for ax in axes[len(part):]:
            ax.set_axis_off()
        add_legend(figure, [found])
        yield figure


def report_pages(found: Sequence[Trust]) -> Iterator[tuple[str, Figure]]:
    """The pages of a report, one for each pair of profiles: first peak and return of the exercises."""
    for pair, words in PAIRS.items():
        own = [one for one in found if one.case.endswith(f"_{pair}") and any(name in one.answers for name in REPORTED)]
        if not own:
            continue
        figure = new_page(f"{TITLE}: {words}", ", ".join(REPORTED.values()), CAPTION)
        axes = figure.subplots(len(REPORTED), len(own), squeeze=False)
        for line, (key, answer_words) in zip(axes, REPORTED.items(), strict=True):
            for ax, one in zip(line, own, strict=True):
                if key in one.answers:
                    draw_causes(ax, one, one.answers[key], f"{one.case}, {answer_words}")
                else:
                    ax.set_axis_off()
        add_legend(figure, own)
        yield words, figure


def in_short(answer: Answer) -> str:
    """The words of an answer, without unit, few where there are few."""
    return answer.quantity.short or answer.quantity.words


def draw_causes(ax: Axes, found: Trust, answer: Answer, title: str) -> None:
    """Draw the causes of an answer as bars in % of it, in its unit where it is zero; one that makes it come or go has words."""
    kinds = {cause: kind for kind, cause in found.variations}
    causes = list(answer.main_causes().items())
    if len(causes) > BARS:
        rest = sum(abs(change) for _, change in causes[BARS - 1:])
        causes = [*causes[:BARS - 1], ("others", rest)]
    known = answer.quantity
    relative = bool(answer.value) and np.isfinite(answer.value)
    scale = 100/abs(answer.value) if relative else known.scale
    sizes = [scale*change if np.isfinite(change) else 0.0 for _, change in causes]
    places = np.arange(len(causes))
    bars = ax.barh(places, sizes, color=[COLOURS[kinds.get(cause, "others")] for cause, _ in causes], height=0.72)
    named_bars(bars, [f"{found.case}, {cause}" for cause, _ in causes],
               x=name(f"change of {answer.name}", "%" if relative else known.unit))
    for place, (_, change) in zip(places, causes, strict=True):
        if not np.isfinite(change):
            ax.text(0, place, " makes it " + ("go" if np.isfinite(answer.value) else "come"), va="center", fontsize=6)
    reach = 1.08*max(map(abs, sizes), default=0.0) or 1.0
    ax.set(yticks=places, yticklabels=[cause for cause, _ in causes], ylim=(max(len(causes), 1) - 0.4, -0.6), xlim=(-reach, reach))
    ax.tick_params(axis="y", labelsize=6, length=0)
    ax.tick_params(axis="x", labelsize=6)
    decoration(ax.axvline(0, color="black", linewidth=0.6))
    ax.grid(axis="y", visible=False)
    ax.set_xlabel("change [%]" if relative else f"change [{known.unit}]", fontsize=6.5)
    value = f"{known.text(answer.value)} {known.unit}, {known.text(answer.low)} to {known.text(answer.high)}"
    ax.set_title(f"{title}\n{value}{', chaotic' if answer.chaotic else ''}", loc="left", fontsize=7, pad=3)


def add_legend(figure: Figure, found: Sequence[Trust]) -> None:
    """Add the colours of the kinds of causes that there are."""
    used = {COLOURS[kind] for one in found for kind, _ in one.variations} | {GREY}
    legend_of_page(figure, [Patch(color=colour, label=words) for words, colour in WORDS.items() if colour in used])
