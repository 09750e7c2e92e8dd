"""Sizes of pages, how soon they are up and how fast they play in Chromium; nothing is judged.

    python tests/support/view_speed.py
"""
from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numpy as np

import ldbench
from browser import find_browser, started

SECONDS = 5         # of playing
PAGES = ["ex1_aw"], ["ex3_aw", "ex3_sw"], ["ex5_aw"]
WATCH = """window.frames_at = []; const watch = now => { frames_at.push(now); requestAnimationFrame(watch); };
  ldbench.go(ldbench.start); ldbench.player.play(); requestAnimationFrame(watch)"""


def measure(page: Path, view: str) -> str:
    """One line about a page: its size, the time until its mark `ready`, frames, and the longest gaps between them."""
    with tempfile.TemporaryDirectory() as profile, started(Path(profile)) as browser:
        browser.size(1366, 860)
        browser.open(page, f"#view={view}")
        up = browser.run("return performance.getEntriesByName('ready')[0].startTime")
        browser.run(WATCH)
        time.sleep(SECONDS)
        gaps = np.diff(browser.run("ldbench.pause(); return frames_at"))
        return f"{page.stat().st_size/1e6:8.2f} {up/1e3:10.2f} {1e3/gaps.mean():12.1f} {np.percentile(gaps, 99):14.1f}"


def main() -> int:
    if not find_browser():
        print("view_speed: no chromium with chromedriver, nothing measured: ./bootstrap --browser")
        return 0
    print(f"{'page':20} {'view':6} {'MB':>8} {'up [s]':>10} {'frames/s':>12} {'99 % gap [ms]':>14}")
    with tempfile.TemporaryDirectory() as scratch:
        for names in PAGES:
            cases = [ldbench.Case.exercise(int(name[2]), name[4:]).replace(table_folder="") for name in names]
            page = ldbench.view(*map(ldbench.run, cases)).write(Path(scratch)/"page.html")
            for view in ("whole", "left"):
                print(f"{' and '.join(names):20} {view:6} {measure(page, view)}", flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
