"""Sizes of pages, how soon they are up and how fast they play, by Chromium's own tracing; nothing is judged.

Each page is opened once, is shown when its mark `ready` says so, and plays for some seconds. Frames are those that the
compositor drew (DrawFrame) meanwhile; a step is an animation callback of the page (FireAnimationFrame). Processor times
of a step, and of all that the page's thread does per step, hold on a loaded machine too: 16.7 ms are 60 in a second.

    python tests/support/view_speed.py
"""
from __future__ import annotations

import json
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from tqdm import tqdm

import ldbench
from browser import Browser, find_browser, started

CATEGORIES = ("blink.user_timing,devtools.timeline,disabled-by-default-devtools.timeline,"
              "disabled-by-default-devtools.timeline.frame")
SECONDS = 5
PAGES = {"ex1_aw": ["ex1_aw"], "ex3_aw and ex3_sw": ["ex3_aw", "ex3_sw"], "ex5_aw": ["ex5_aw"]}


def trace(browser: Browser) -> list[dict]:
    """The browser's measurements; it gives them once."""
    entries = (json.loads(entry["message"])["message"] for entry in browser.driver.get_log("performance"))
    return [entry["params"] for entry in entries if entry["method"] == "Tracing.dataCollected"]


def measure(page: Path, view: str) -> str:
    """One line about a page."""
    with tempfile.TemporaryDirectory() as profile, started(Path(profile), CATEGORIES) as browser:
        browser.size(1366, 860)
        browser.driver.get(f"{page.as_uri()}#view={view}")
        browser.wait(lambda: browser.run("return document.documentElement.dataset.ready") == "yes")
        up = browser.run("return performance.getEntriesByName('ready')[0].startTime")
        browser.run("ldbench.go(ldbench.start); ldbench.player.play(); performance.mark('from')")
        time.sleep(SECONDS)
        browser.run("performance.mark('to'); ldbench.pause()")
        events = trace(browser)
        first, last = (next(event for event in events if event["name"] == mark) for mark in ("from", "to"))
        played = [event for event in events if event.get("pid") == first["pid"]
                  and first["ts"] <= event.get("ts", 0) <= last["ts"]]
        spans = [event for event in played if event["name"] == "FireAnimationFrame" and event.get("ph") == "X"]
        drawn = [event["ts"] for event in played if event["name"] == "DrawFrame"]
        gaps = np.diff(np.sort(drawn))/1e3
        rate = 1e6*len(spans)/(last["ts"] - first["ts"])
        callback = np.mean([e.get("tdur", e["dur"]) for e in spans])/1e3
        tasks = [e for e in played if e["name"] == "RunTask" and e.get("ph") == "X" and e["tid"] == spans[0]["tid"]]
        busy = sum(e.get("tdur", e["dur"]) for e in tasks)/1e3/len(spans)
        return (f"{page.stat().st_size/1e6:8.2f} {up/1e3:10.2f} {rate:12.1f} {1e3/np.mean(gaps):12.1f} "
                f"{np.percentile(gaps, 99):14.1f} {callback:12.2f} {busy:12.2f}")


def run_files(folder: Path, names: Sequence[str]) -> dict[str, Path]:
    """Column files of shipped cases."""
    found = {}
    for name in tqdm(names, desc="runs", disable=None, leave=False):
        case = ldbench.Case.exercise(int(name[2]), name[4:])
        found[name] = Path(ldbench.run(case.replace(table_file="")).write(folder/f"{name}.txt"))
    return found


def main() -> int:
    if not find_browser():
        print("view_speed: no chromium with chromedriver, nothing measured: ./bootstrap --browser")
        return 0
    print(f"{'page':20} {'view':6} {'MB':>8} {'up [s]':>10} {'steps/s':>12} {'frames/s':>12} {'99 % gap [ms]':>14} "
          f"{'step [ms]':>12} {'thread [ms]':>12}")
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        files = run_files(folder, sorted({name for names in PAGES.values() for name in names}))
        for title, names in PAGES.items():
            page = ldbench.view(*(files[name] for name in names)).write(folder/"page.html")
            for view in ("whole", "left"):
                print(f"{title:20} {view:6} {measure(page, view)}", flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
