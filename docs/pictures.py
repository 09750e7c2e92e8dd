"""Make the pictures of README and of the documentation: `python docs/pictures.py` writes outputs/reference/*.png.

Every picture is made from runs of today's program, and keeps the numbers that its caption tells in the text `numbers` of the
file, so that a test can compare them with a run. Pictures of pages need Chromium (`./bootstrap --browser`).
"""
from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

from matplotlib.figure import Figure
from PIL import Image
from PIL.PngImagePlugin import PngInfo

import ldbench
from browser import Browser, find_browser, started
from ldbench.__main__ import main
from ldbench.constants import KN, MM
from ldbench.geometry.outlines import case_outlines
from ldbench.plots.style import ldbench_style
from ldbench.report.formulations import FORMULATIONS, LINES
from ldbench.viewer.page import view

ROOT = Path(__file__).resolve().parents[1]
REFERENCE = ROOT/"outputs/reference"
CONTACT, IMPACT, BOTH = 0.0219, 0.0213, 0.0113      # moments that are shown [s]
WINDOW = 1200, 760                                  # of the browser [px]
Numbers = dict[str, float]


def row_at(run: ldbench.Run, column: str, t: float) -> float:
    """A column in the row at the time t [s] or the last one before."""
    return float(run.values(column)[run.time.searchsorted(t + 1e-9) - 1])


def keep(source: Path, target: Path, numbers: Numbers) -> None:
    """Write a picture with its numbers."""
    told = PngInfo()
    told.add_text("numbers", json.dumps(numbers))
    with Image.open(source) as picture:
        picture.save(target, pnginfo=told, optimize=True)
    print(target.name, numbers)


@cache
def table(pair: str, model: str) -> ldbench.ContactTable:
    """The contact table of a pair of profiles, prepared once."""
    return ldbench.ContactTable(ldbench.Case.exercise(1, pair).replace(table_folder="", model=model))


def case_run(name: str, **changes: object) -> ldbench.Run:
    """A case of the benchmark, with other values."""
    exercise, pair = int(name[2]), name[-2:]
    case = ldbench.Case.exercise(exercise, pair).replace(table_folder="", **changes)
    return ldbench.run(case, table=table(pair, case.model) if case.formulation == "elastic" else None)


def wheelset(folder: Path) -> Numbers:
    """One moment of exercise 2."""
    run = case_run("ex2_aw")
    run.write(folder/"ex2_aw.txt")
    check(main(["view", str(folder/"ex2_aw.txt"), "-o", str(folder/"picture.png"), "--from", str(CONTACT)]))
    return {"t [s]": CONTACT, "N_LF [N]": row_at(run, "N_LF", CONTACT), "N_LT [N]": row_at(run, "N_LT", CONTACT),
            "N_RT [N]": row_at(run, "N_RT", CONTACT)}


def laws(folder: Path) -> Numbers:
    """Exercise 2 with two contact laws: displacement, flange forces, energy drift."""
    runs = {law: case_run("ex2_aw", model=law) for law in ("halfspace", "hertz")}
    figure = Figure(figsize=(6.4, 4.8), dpi=100)
    axes = figure.subplots(3, 1, sharex=True, gridspec_kw={
        "left": 0.11, "right": 0.985, "top": 0.94, "bottom": 0.1, "hspace": 0.14})
    for (law, run), look in zip(runs.items(), list(LINES.values())[:2], strict=True):
        t = 1e3*run.time
        axes[0].plot(t, MM*run.values("Y"), label=law, **look.kwargs())
        axes[1].plot(t, KN*(run.values("N_LF") + run.values("N_RF")), **look.kwargs())
        axes[2].plot(t, 1e9*run.values("E_drift"), **look.kwargs())
    for ax, words in zip(axes, ("Y [mm]", "flange forces [kN]", "energy drift [nJ]"), strict=True):
        ax.set_ylabel(words)
    axes[0].legend(loc="upper right")
    axes[0].set_title("Exercise 2, actual profiles: half-spaces and Hertz springs", loc="left")
    axes[-1].set_xlabel("time [ms]")
    figure.savefig(folder/"picture.png")
    return {f"{name}.{law}": value for law, run in runs.items() for name, value in (
        ("t_return [s]", float(run.time[-1])), ("drift [J]", run.results["drift"]))}


def formulations(folder: Path) -> Numbers:
    """Exercise 4 in all formulations: lateral and vertical displacement."""
    runs = {name: case_run("ex4_aw", **changes) for name, changes in FORMULATIONS.items()}
    figure = Figure(figsize=(7.04, 3.96), dpi=100)
    axes = figure.subplots(2, 1, sharex=True, gridspec_kw={
        "left": 0.08, "right": 0.985, "top": 0.93, "bottom": 0.11, "hspace": 0.1})
    for name, run in runs.items():
        for ax, column in zip(axes, "YZ", strict=True):
            ax.plot(1e3*run.time, MM*run.values(column), label=name, **LINES[name].kwargs())
    axes[0].set(xlim=(0, 200))
    axes[0].set_title("Exercise 4, actual profiles, by formulation", loc="left")
    axes[0].legend(loc="upper right")
    axes[0].set_ylabel("Y [mm]")
    axes[1].set_ylabel("Z [mm]")
    axes[1].set_xlabel("time [ms]")
    figure.savefig(folder/"picture.png")
    return {f"{what}.{name}": value for name, run in runs.items() for what, value in (
        ("t [s]", float(run.time[-1])), ("derailed", float(run.results["derailed"])))}


def profile(folder: Path) -> Numbers:
    """The page of S1002 on 60E1."""
    files = [str(ROOT/f"profiles/{name}.yz") for name in ("s1002", "60e1")]
    check(main(["profile", *files, "--set", "gauge=1.435", "--set", "back_to_back=1.36", "-o", str(folder/"picture.png")]))
    case = ldbench.Case().replace(wheel_profile=files[0], rail_profile=files[1], gauge=1.435, back_to_back=1.36)
    return {"clearance [m]": case_outlines(case).clearance[0]}


def one_page(folder: Path, browser: Browser) -> Numbers:
    """The page of exercise 2 at the flange."""
    run = case_run("ex2_aw")
    shoot(browser, folder, [run], IMPACT, dark=False, buttons=["left contact"])
    return {"t [s]": IMPACT, "N_LF [N]": row_at(run, "N_LF", IMPACT)}


def two_pages(folder: Path, browser: Browser) -> Numbers:
    """The page of exercise 3 with both pairs of profiles and their difference."""
    runs = [case_run(f"ex3_{pair}") for pair in ("aw", "sw")]
    shoot(browser, folder, runs, BOTH, dark=True, buttons=[])
    return {"t [s]": BOTH, "N_LF [N]": row_at(runs[0], "N_LF", BOTH)}


def shoot(browser: Browser, folder: Path, runs: list[ldbench.Run], t: float, dark: bool, buttons: list[str]) -> None:
    """The page of runs at a moment, after a click on the buttons with these words."""
    file = view(*runs).write(folder/"page.html")
    browser.size(*WINDOW, dark=dark)
    browser.open(file, f"#t={t}")
    for words in buttons:
        browser.run("[...document.querySelectorAll('button')].find(b => b.textContent.trim() === arguments[0]).click()", words)
    twice = "return new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))"
    browser.wait(lambda: browser.run(twice))
    (folder/"picture.png").write_bytes(browser.driver.get_screenshot_as_png())


def check(code: int) -> None:
    """Stop where a command failed; it has said why."""
    if code:
        raise SystemExit(code)


PICTURES: dict[str, Callable[[Path], Numbers]] = {
    "wheelset": wheelset, "ex2_aw": laws, "ex4_formulations": formulations, "profile": profile}
PAGES: dict[str, Callable[[Path, Browser], Numbers]] = {"view_ex2_aw": one_page, "view_ex3": two_pages}


def make_pictures(target: Path) -> None:
    """Make all pictures in a folder."""
    target.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch, ldbench_style():
        folder = Path(scratch)
        for name, draw in PICTURES.items():
            numbers = draw(folder)
            keep(folder/"picture.png", target/f"{name}.png", numbers)
        if not find_browser():
            raise SystemExit(f"pictures: {', '.join(PAGES)} are not made: expected Chromium with chromedriver, found none. "
                             "Run ./bootstrap --browser")
        with started(folder/"profile") as browser:
            for name, show in PAGES.items():
                numbers = show(folder, browser)
                keep(folder/"picture.png", target/f"{name}.png", numbers)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--folder", type=Path, default=REFERENCE, help="folder for the pictures (default: %(default)s)")
    make_pictures(parser.parse_args().folder)
