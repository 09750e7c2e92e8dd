"""Pages of runs, in a real browser, and films."""
from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import ldbench
from browser import Browser, facts, go
from invented import COARSE
from ldbench.__main__ import main
from ldbench.results.header import read_header
from ldbench.results.quantities import CONTACTS
from ldbench.results.run_data import read_data
from ldbench.results.summary import CHAOTIC_NOTE
from ldbench.viewer import film, results
from ldbench.viewer.pack import BINS, FINE_LEVELS, LEVELS
from ldbench.viewer.page import Page
from running import CASES, Run

HOSTILE = ('<img src=x onerror="document.title=1;window.harmed=1">', "</script><script>window.harmed=2</script>",
           "\"quoted' {{data}} ${1} `", "Größe 力 \u2028 ñ", "__proto__", "</title><h1>")


def printed_rows(file: Path) -> tuple[list[str], dict[float, str]]:
    """Names of columns, and the rows by their times, as they stand in a file."""
    names, *rest = file.read_text().splitlines()
    return names.split(), {float(line.split(None, 1)[0]): line for line in rest if not line.startswith("#")}


def shown_time(browser: Browser) -> float:
    return float(browser.text("#clock").split()[0])


def is_quiet(browser: Browser, page: Path) -> None:
    """Nothing was said, and nothing but the page was asked for."""
    assert browser.log() == []
    assert {url.partition("#")[0] for url in browser.requests() if not url.startswith("data:")} == {page.as_uri()}


def values_are_the_files(browser: Browser, file: Path, times: list[float], run: str) -> None:
    """The table shows every number of the row at ten times as the file has it."""
    names, rows = printed_rows(file)
    browser.run("document.querySelector('#digits').checked || document.querySelector('#digits').click()")
    for t in times:
        go(browser, t)
        assert float(browser.text("#values tbody tr td")) == pytest.approx(t, abs=5.1e-7)
        cells = browser.run("return [...document.querySelectorAll('#values td[data-run]')].filter(cell => "
                            "cell.dataset.run === arguments[0]).map(cell => [cell.dataset.column, cell.textContent])",
                            run)
        assert len(cells) == len(names) - 1
        row = rows[t].split()
        for column, text in cells:
            expected = row[names.index(column)]
            assert text == expected.replace("-0.00000000E+00", "0.00000000E+00"), f"{column} at {t}"


def test_page_of_exercise_5(browser: Browser, shipped: dict[str, Run], ex5: Path):
    """The largest file: values where rows are kept, bands elsewhere, and at most 6 MB."""
    run = shipped["ex5_aw"]
    assert run.file.stat().st_size > 90e6 and ex5.stat().st_size < 6e6
    browser.open(ex5)
    is_quiet(browser, ex5)
    kept, times = np.array(browser.run("return [...ldbench.runs[0].t]")), run.columns["time"]
    peaks = [times[np.argmax(run.columns[f"N_{c}"])] for c in ("LT", "LF", "RT")]
    assert np.isin(kept, times).all() and np.isin(peaks, kept).all()
    # Round every event that the file lists, all rows.
    for event in read_header(run.file).events:
        k = np.searchsorted(times, event.t)
        assert np.isin(times[k - 10:k + 10], kept).all(), event
    values_are_the_files(browser, run.file, [*peaks, *kept[np.linspace(0, len(kept) - 1, 5).astype(int)]], "ex5_aw")
    # Between: all rows of what the scene needs, a band of the rest.
    bands = browser.run("""const run = ldbench.runs[0];
      return {Y: [...run.tracks.Y], N_LF: [...run.tracks.N_LF], low: [...run.bands.aY.low], high: [...run.bands.aY.high]}""")
    for name in "Y", "N_LF":
        x = run.columns[name]
        assert np.abs(np.array(bands[name]) - x).max() <= 0.501*np.ptp(x)/FINE_LEVELS
    edges, x = np.arange(0, len(times), -(-len(times)//BINS)), run.columns["aY"]
    level = np.ptp(x)/LEVELS
    for name, shift, extreme in ("low", level/2, np.minimum), ("high", -level/2, np.maximum):
        assert np.all(np.abs(np.array(bands[name]) + shift - extreme.reduceat(x, edges)) < 0.501*level)


def test_two_runs_and_their_difference(browser: Browser, two: Path, shipped: dict[str, Run]):
    """Every number is that of a file; the table and the chart of differences have their difference."""
    browser.open(two, "#t=0.0213")
    is_quiet(browser, two)
    a, b = (shipped[case].columns for case in ("ex2_aw", "ex2_sw"))
    for k, columns in enumerate((a, b)):
        found = browser.run("const run = ldbench.runs[arguments[0]]; return {time: [...run.t], ...Object.fromEntries("
                            "Object.entries(run.exact).map(([name, x]) => [name, [...x]]))}", k)
        for name, x in found.items():
            np.testing.assert_array_equal(np.array([np.nan if v is None else v for v in x], float), columns[name], err_msg=name)
    row = browser.run("""const row = [...document.querySelectorAll('#values tr')].find(row =>
      row.firstChild.title === 'Y'); return [...row.children].map(cell => cell.textContent)""")
    y, other = (np.interp(0.0213, c["time"], c["Y"]) for c in (a, b))
    numbers = [float(text.replace("−", "-")) for text in row[1:4]]
    np.testing.assert_allclose(numbers, 1e3*np.array([y, other, other - y]), rtol=2e-6)
    d = browser.run("""const [a, b] = ldbench.runs, d = ldbench.difference(a, b, 'Y', 0, 1);
      return [[...d.t], [...d.x]]""")
    t, x = (np.array([np.nan if v is None else v for v in part], float) for part in d)
    inside = t <= b["time"][-1]
    np.testing.assert_allclose(x[inside], (np.interp(t, b["time"], b["Y"]) - a["Y"])[inside], atol=1e-15)
    # One run less: its column goes.
    browser.click("#runs label:nth-child(2) input")
    browser.wait(lambda: browser.run("return ldbench.runs.length") == 1)
    browser.wait(lambda: "run=ex2_aw" in browser.driver.current_url)


def scene_pixels(browser: Browser) -> str:
    return browser.run("return document.querySelector('#scene').toDataURL()")


def test_play_moves_the_wheelset(browser: Browser, one: Path):
    """By a clock of the test's own: 51 frames, of which fifty are 10 ms after the one before."""
    browser.open(one)
    pose, pixels = browser.text("#pose"), scene_pixels(browser)
    browser.run("""let left = 51, now = 0;
        performance.now = () => now;
        window.requestAnimationFrame = frame => left-- > 0 && setTimeout(() => { frame(now); now += 10; });""")
    browser.press(" ")
    assert browser.run("return document.querySelector('#play').getAttribute('aria-label')") == "pause"
    end = 0.5*float(browser.run("return document.querySelector('#speed').value"))
    browser.wait(lambda: browser.run("return ldbench.t") > 0.999*end)
    browser.press(" ")
    stopped = browser.run("return ldbench.t")
    assert stopped == pytest.approx(end, rel=1e-9) and browser.text("#pose") != pose and scene_pixels(browser) != pixels
    y = float(re.match(r"Y (\S+) mm", browser.text("#pose").replace("−", "-"))[1])
    assert y == pytest.approx(1e3*0.1*stopped, rel=0.01, abs=1e-3)      # at 0.1 m/s, before it meets the flange
    browser.wait(lambda: (link := re.search(r"#t=([^&]+)", browser.driver.current_url))
                 and float(link[1]) == pytest.approx(stopped, rel=1e-8))


def test_events_and_rows_by_key(browser: Browser, one: Path, shipped: dict[str, Run]):
    browser.open(one)
    run = read_data(shipped["ex1_aw"].file)
    events = sorted({*(event.t for event in run.events), *(run.peak(c)[1] for c in CONTACTS if run.peak(c))})
    found = []
    for _ in events[:8]:
        browser.press("e")
        found.append(shown_time(browser))
    np.testing.assert_allclose(found, events[:8], atol=1e-6)
    browser.press("E")
    assert shown_time(browser) == pytest.approx(events[6], abs=1e-6)
    assert browser.text("#said").startswith(f"{events[6]:.6f} s, ")
    times = run.time
    browser.press("\ue014")                             # arrow to the right
    k = np.searchsorted(times, events[6], "right")
    assert shown_time(browser) == pytest.approx(times[k], abs=1e-6)
    browser.press("\ue012", "\ue012")
    assert shown_time(browser) == pytest.approx(times[k - 2], abs=1e-6)
    browser.press("\ue010")                             # end
    assert shown_time(browser) == pytest.approx(times[-1], abs=1e-6)
    browser.press("2")
    assert browser.run("return ldbench.scene.view") == "left"
    before = browser.run("return ldbench.window")
    browser.press("+")
    after = browser.run("return ldbench.window")
    assert after[1] - after[0] == pytest.approx((before[1] - before[0])/2)
    assert browser.log() == []


def test_pointer_scrubs_and_zooms(browser: Browser, one: Path):
    browser.open(one)
    browser.run("document.querySelector('#charts canvas').scrollIntoView()")
    x, y, width = browser.run("""const box = document.querySelector('#charts canvas').getBoundingClientRect();
      return [box.x, box.y + 80, box.width]""")

    def mouse(kind: str, at: float, **more: object) -> None:
        browser.driver.execute_cdp_cmd("Input.dispatchMouseEvent", {
            "type": kind, "x": at, "y": y, "button": "left", "buttons": 1, "clickCount": 1, **more})

    mouse("mousePressed", x + width/3)
    mouse("mouseMoved", x + width/2)
    mouse("mouseReleased", x + width/2)
    end = browser.run("return ldbench.end")
    expected = end*(width/2 - 62)/(width - 74)
    browser.wait(lambda: abs(browser.run("return ldbench.t") - expected) < 2e-4)
    mouse("mouseWheel", x + width/2, deltaX=0, deltaY=-120, button="none", buttons=0)
    browser.wait(lambda: browser.run("return ldbench.window[1] - ldbench.window[0]") < 0.8*end)


def test_sizes(all_runs: Path):
    """The page of each run is small, and so is the page of all of them."""
    page = all_runs.read_text(encoding="utf-8")
    bodies = re.findall(r'<script type="text/plain" id="run(\d+)">([^<]*)<', page)
    assert len(bodies) == len(CASES)
    rest = len(page.encode()) - sum(len(body) for _, body in bodies)
    for (_, body), case in zip(bodies, CASES, strict=True):
        assert len(body) + rest < (6e6 if case.startswith("ex5") else 1.5e6), case
    assert all_runs.stat().st_size < 15e6


def test_summary_opens_moments(browser: Browser, all_runs: Path, shipped: dict[str, Run]):
    browser.open(all_runs)
    is_quiet(browser, all_runs)
    table = browser.run("""return [...document.querySelectorAll('#summary tbody tr')].map(row =>
      [...row.children].map(cell => cell.textContent))""")
    words = [row[0] for row in table]
    assert len(table[0]) == 1 + len(CASES)
    run = read_data(shipped["ex3_sw"].file)
    line, column = words.index("peak N, left flange [kN]"), 1 + CASES.index("ex3_sw")
    force, t = run.peak("LF")
    assert table[line][column] == f"{1e-3*force:.0f}"
    browser.run("document.querySelectorAll('#summary tbody tr')[arguments[0]].children[arguments[1]].firstChild.click()",
                line, column)
    browser.wait(lambda: browser.text("#clock") == f"{t:.6f} s")
    assert browser.run("return ldbench.runs.map(run => run.name)") == ["ex3_sw"]
    browser.click("#runs label:nth-child(5) input")     # and the other profiles over it
    browser.wait(lambda: browser.run("return ldbench.runs.map(run => run.name)") == ["ex3_aw", "ex3_sw"])
    assert browser.log() == []


def test_variants_are_shown_side_by_side(browser: Browser, shipped: dict[str, Run], tmp_path: Path):
    """A run with another contact law that lies beside a case's file is found, and a link lays it over the case."""
    for name, text in (("ex2_aw.txt", "halfspace"), ("ex2_aw_hertz.txt", "hertz"), ("ex2_sw.txt", "halfspace")):
        source = shipped[name[:6]].file.read_text()
        (tmp_path/name).write_text(source.replace("model = 'halfspace'", f"model = '{text}'"))
    files = [tmp_path/"ex2_aw.txt", tmp_path/"ex2_sw.txt"]
    variants = results.find_variants(files)
    assert variants == [tmp_path/"ex2_aw_hertz.txt"]
    runs, chaotic = [read_data(file) for file in files], {"ex2_sw": {"peak_N_LF": 2e3}}
    browser.open(results.results_page(runs, variants, chaotic).write(tmp_path/"results.html"))
    assert browser.texts("#summary .leaning") == [f"{1e-3*runs[1].peak('LF')[0]:.0f}"]
    assert browser.run("return getComputedStyle(document.querySelector('#summary .leaning')).fontStyle") == "italic"
    assert browser.text("#summary p") == CHAOTIC_NOTE
    assert browser.texts("#summary tbody tr:last-child > *") == ["side by side with", "hertz", "–"]
    browser.click("#summary tbody tr:last-child a")
    browser.wait(lambda: browser.run("return ldbench.runs.map(run => run.name)") == ["ex2_aw", "ex2_aw_hertz"])


def foreign(folder: Path, names: list[str], rows: int = 300) -> Path:
    file = folder/"other code.csv"
    t = np.linspace(0, 0.3, rows)
    columns = [t, *(np.sin((k + 1)*t) for k in range(len(names)))]
    lines = [",".join(["time", *names]), *(",".join(f"{x:.6e}" for x in row) for row in zip(*columns, strict=True))]
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return file


@pytest.mark.parametrize("names", [["Y"], ["N_LF"], ["something"], ["Y", "Z", "roll", "N_LF", "N_RT", "y_LF"]])
def test_missing_columns_give_what_there_is(names: list[str], browser: Browser, tmp_path: Path):
    file = foreign(tmp_path, names)
    page = ldbench.view(file).write(tmp_path/"page.html")
    browser.open(page, "#t=0.15")
    is_quiet(browser, page)
    shown = browser.run("return [...document.querySelectorAll('#values td[data-column]')].map(c => c.dataset.column)")
    assert sorted(shown) == sorted(names)
    assert "drawn are awprof.yz and arprof.yz" in browser.text("#about")
    browser.press(" ")
    browser.wait(lambda: browser.run("return ldbench.t") > 0.15)
    browser.press(" ", "2", "l")
    assert browser.log() == []


def test_foreign_file_over_ours(browser: Browser, shipped: dict[str, Run], tmp_path: Path):
    """With a map of names and units, in the page of the command."""
    ours = shipped["ex2_sw"]
    t, y = ours.columns["time"], ours.columns["Y"]
    other = tmp_path/"other.csv"
    other.write_text("t [ms],ylat [mm]\n" + "".join(f"{1e3*a:.9g},{-1e3*b:.9g}\n" for a, b in zip(t, y, strict=True)))
    (tmp_path/"map.toml").write_text('time = "t"\nY = { column = "ylat", factor = -1 }\n')
    page = tmp_path/"both.html"
    assert main(["view", str(ours.file), str(other), "--map", str(tmp_path/"map.toml"), "-o", str(page)]) == 0
    browser.open(page, "#t=0.05")
    is_quiet(browser, page)
    assert "drawn are swprof.yz and srprof.yz" in browser.text("#about")
    d = browser.run("const [a, b] = ldbench.runs; return [...ldbench.difference(a, b, 'Y', 0, 1).x]")
    assert np.nanmax(np.abs(np.array(d, float))) < 1e-10


def test_hostile_names_are_text(browser: Browser, shipped: dict[str, Run], tmp_path: Path):
    file = foreign(tmp_path, [*(name.replace(",", ".") for name in HOSTILE), "Y"])
    run = read_data(file)
    assert list(run.data)[1:-1] == list(HOSTILE) or len(run.data.columns) == len(HOSTILE) + 2
    text = shipped["ex4_aw"].file.read_text()
    for what in ("title", "name"):
        text = re.sub(rf"(# +{what} = )'[^']*'", lambda found: f"{found[1]}'{HOSTILE[0]}'", text)
    text = re.sub(r"# case [^\n]*", lambda _: f"# case {HOSTILE[1]}: {HOSTILE[0]}{HOSTILE[5]}", text)
    text = re.sub(r"left flange contact", lambda _: HOSTILE[0], text, count=1)
    ours = tmp_path/"<b>ours.txt"
    ours.write_text(text, encoding="utf-8")
    page = ldbench.view(file, ours, title=HOSTILE[5] + HOSTILE[1]).write(tmp_path/"page.html")
    browser.open(page)
    is_quiet(browser, page)
    assert browser.text("#title") == HOSTILE[5] + HOSTILE[1]
    assert browser.run("return document.title") == HOSTILE[5] + HOSTILE[1]
    words = browser.texts("#values tbody th")
    for name in run.data:
        if name not in ("time", "Y"):
            assert name in words
    browser.press("e", "e", " ")
    browser.click("#charts button[aria-label='choose columns']")
    assert browser.run("return [window.harmed ?? 0, document.images.length, document.querySelectorAll('script').length,"
                       " document.querySelectorAll('h1').length]") == [0, 0, 2, 1]      # facts and script; data are read
    # Even where a script is put into the page, the policy does not let it run.
    browser.run("""const script = document.createElement('script'); script.textContent = 'window.harmed = 3';
      document.body.append(script); const image = new Image(); image.setAttribute('onerror', 'window.harmed = 4');
      image.src = 'x'; document.body.append(image)""")
    assert browser.wait(lambda: [line for line in browser.log() if "Content Security Policy" in line])
    assert browser.run("return window.harmed ?? 0") == 0


@pytest.fixture(scope="module")
def short_run() -> ldbench.Run:
    case = ldbench.Case.exercise(2, "aw").replace(**COARSE, t_end=0.03, stop_at="t_end", title='<b>"bold"</b> & more')
    return ldbench.run(case)


def test_a_run_is_shown_as_its_file(short_run: ldbench.Run, tmp_path: Path):
    """The page of a run in memory says what the page of its column file says."""
    file = short_run.write(tmp_path/short_run.file.name)
    a, b = (facts(page.write(tmp_path/"page.html"))["runs"][0] for page in (short_run.view(), ldbench.view(file)))
    assert a == b


def test_notebook_shows_the_page_in_a_frame(browser: Browser, short_run: ldbench.Run, tmp_path: Path):
    notebook = tmp_path/"notebook.html"
    page = ldbench.view(short_run, short_run)
    assert isinstance(page, Page)
    notebook.write_text(f"<!DOCTYPE html><meta charset=utf-8>{page._repr_html_()}", encoding="utf-8")
    browser.driver.get(notebook.as_uri())
    browser.driver.switch_to.frame(browser.driver.find_element("tag name", "iframe"))
    browser.wait(lambda: browser.run("return document.documentElement.dataset.ready") == "yes")
    assert browser.texts("#runs label span:last-child") == ["ex2_aw (1)", "ex2_aw (2)"]
    browser.click("#row-on")
    browser.wait(lambda: shown_time(browser) > 0)
    browser.driver.switch_to.default_content()
    assert [line for line in browser.log() if "SEVERE" in line] == []


def test_tables_for_a_notebook(short_run: ldbench.Run):
    case = short_run.case._repr_html_()
    assert "&lt;b&gt;" in case and "<b>\"bold" not in case and "vY" in case and "0.03" in case
    run = short_run._repr_html_()
    assert "left flange contact" in run and f"{1e-3*short_run.results['peak_N_LF']:.3f} kN" in run
    table = short_run.table._repr_html_()
    assert f"{1e3*short_run.table.clearance:.3f}" in table and "90.000 kN" in table
    assert all(html.startswith("<table>") and html.endswith("</table>") for html in (case, run, table))


@pytest.mark.parametrize("ending", ["gif", "mp4"])
def test_film(ending: str, shipped: dict[str, Run], tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    target = tmp_path/f"film.{ending}"
    files = [str(shipped[case].file) for case in ("ex2_aw", "ex2_sw")]
    rate = film.RATES[f".{ending}"]
    assert main(["view", *files, "-o", str(target), "--from", "0.02", "--to", "0.024", "--speed", str(0.004/7*rate)]) == 0
    assert "film." in capsys.readouterr().out
    if ending == "gif":
        from PIL import Image, ImageSequence

        frames = [np.array(frame.convert("RGB")) for frame in ImageSequence.Iterator(Image.open(target))]
    else:
        import imageio_ffmpeg

        reader = imageio_ffmpeg.read_frames(str(target))
        about = next(reader)
        assert about["codec"] == "h264" and about["fps"] == rate
        frames = [np.frombuffer(frame, np.uint8) for frame in reader]
    assert len(frames) == 8
    assert all(np.any(a != b) for a, b in pairwise(frames))
