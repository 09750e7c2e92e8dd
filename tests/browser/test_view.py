"""Pages of runs, in a real browser: playing, keys, several runs, other codes' files, hostile names, notebooks."""
from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import ldbench
from browser import Browser, facts
from invented import COARSE
from ldbench.__main__ import main
from ldbench.results.run_data import read_data
from ldbench.results.summary import CHAOTIC_NOTE
from ldbench.results.twins import Spread
from ldbench.viewer import results
from specimen import World

HOSTILE = ('<img src=x onerror="document.title=1;window.harmed=1">', "</script><script>window.harmed=2</script>",
           "\"quoted' {{data}} ${1} `", "Größe 力 \u2028 ñ", "__proto__", "</title><h1>")


def shown_time(browser: Browser) -> float:
    return float(browser.text("#clock").split()[0])


def test_two_runs_and_their_difference(browser: Browser, two: Path, world: World):
    """Every number is that of a file; the table and the chart of differences have their difference."""
    t0 = 0.0212         # both have a row there
    browser.open(two, f"#t={t0}")
    browser.is_quiet(two)
    a, b = world.thrown.c, world.faster.c
    for k, columns in enumerate((a, b)):
        found = browser.run("const run = ldbench.runs[arguments[0]]; return {time: [...run.t], ...Object.fromEntries("
                            "Object.entries(run.exact).map(([name, x]) => [name, [...x]]))}", k)
        for name, x in found.items():
            np.testing.assert_array_equal(np.array(x, float), columns[name], err_msg=name)
    row = browser.run("""const row = [...document.querySelectorAll('#values tr')].find(row =>
      row.firstChild.title === 'Y'); return [...row.children].map(cell => cell.textContent)""")
    y, other = (np.interp(t0, c["time"], c["Y"]) for c in (a, b))
    numbers = [float(text.replace("−", "-")) for text in row[1:4]]
    np.testing.assert_allclose(numbers, 1e3*np.array([y, other, other - y]), rtol=2e-6)
    found = browser.run("const [a, b] = ldbench.runs, d = ldbench.difference(a, b, 'Y', 0, 1); return [[...d.t], [...d.x]]")
    t, x = np.array(found, float)
    inside = t <= b["time"][-1]
    np.testing.assert_allclose(x[inside], (np.interp(t, b["time"], b["Y"]) - a["Y"])[inside], atol=1e-15)
    # One run less: its column goes.
    browser.click("#runs label:nth-child(2) input")
    browser.wait(lambda: browser.run("return ldbench.runs.length") == 1)
    browser.wait(lambda: "run=ex2_aw" in browser.driver.current_url)


def test_play_moves_the_wheelset(browser: Browser, report: Path, world: World):
    """By a clock of the test's own: 51 frames, of which fifty are 10 ms after the one before."""
    browser.open(report, "#t=0")
    pixels = "return document.querySelector('#scene').toDataURL()"
    before = browser.run(pixels)
    browser.run("""let left = 51, now = 0;
        performance.now = () => now;
        window.requestAnimationFrame = frame => left-- > 0 && setTimeout(() => { frame(now); now += 10; });""")
    browser.press(" ")
    assert browser.run("return document.querySelector('#play').getAttribute('aria-label')") == "pause"
    end = 0.5*float(browser.run("return document.querySelector('#speed').value"))
    browser.wait(lambda: browser.run("return ldbench.t") > 0.999*end)
    browser.press(" ")
    stopped = browser.run("return ldbench.t")
    assert stopped == pytest.approx(end, rel=1e-9) and browser.run(pixels) != before
    y = float(re.match(r"Y (?:≈ )?(\S+) mm", browser.text("#pose").replace("−", "-"))[1])
    assert y == pytest.approx(1e3*np.interp(stopped, world.thrown.t, world.thrown.c["Y"]), abs=6e-3)
    browser.wait(lambda: (link := re.search(r"#t=([^&]+)", browser.driver.current_url))
                 and float(link[1]) == pytest.approx(stopped, rel=1e-8))


def test_events_and_rows_by_key(browser: Browser, report: Path, world: World):
    raw = world.thrown
    peaks = (raw.peak(contact) for contact in ("LT", "LF", "RT", "RF"))
    events = sorted({*(t for t, *_ in raw.events), *(t for force, t in peaks if force), raw.result("t_pmax")})[:5]
    browser.open(report, "#t=0")
    for t in events:
        browser.press("e")
        assert shown_time(browser) == pytest.approx(t, abs=1e-6)
    browser.press("E")
    assert shown_time(browser) == pytest.approx(events[3], abs=1e-6)
    assert browser.text("#said").startswith(f"{events[3]:.6f} s, ")
    k = np.searchsorted(raw.t, events[3], "right")
    for keys, row in (("\ue014", k), ("\ue012\ue012", k - 2), ("\ue010", -1)):       # right, left twice, end
        browser.press(*keys)
        assert shown_time(browser) == pytest.approx(raw.t[row], abs=1e-6)
    browser.press("2")
    assert browser.run("return ldbench.scene.view") == "left"
    window = browser.run("return ldbench.window[1] - ldbench.window[0]")
    browser.press("+")
    assert browser.run("return ldbench.window[1] - ldbench.window[0]") == pytest.approx(window/2) and browser.log() == []


def test_variants_are_shown_side_by_side(browser: Browser, world: World, tmp_path: Path):
    """A run with another contact law that lies beside a case's file is found, and a link lays it over the case."""
    for name, law in (("ex2_aw", "halfspace"), ("ex2_aw_hertz", "hertz"), ("ex2_sw", "halfspace")):
        text = world.thrown.text.replace("ex2_aw", name[:6]).replace("model = 'halfspace'", f"model = '{law}'")
        (tmp_path/f"{name}.txt").write_text(text)
    files = [tmp_path/"ex2_aw.txt", tmp_path/"ex2_sw.txt"]
    variants = results.find_variants(files)
    assert variants == [tmp_path/"ex2_aw_hertz.txt"]
    chaotic = {"ex2_sw": {"peak_N_LF": Spread(802e3, 790e3, 811e3, 5, 9)}}
    page = results.results_page([read_data(file) for file in files], variants, chaotic, {"ex2_sw": (671e3, 752e3)})
    browser.open(page.write(tmp_path/"results.html"))
    assert [text for text in browser.texts("#summary td") if "(" in text] == ["802 (790 to 811, 5 of 9)"]
    assert "peak N, first contact, left flange [kN], wheel and rail as bodies–671.0 to 752.0" in browser.texts("#summary tr")
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


@pytest.mark.parametrize("names", [["something"], ["Y", "Z", "roll", "N_LF", "N_RT", "y_LF"]], ids=len)
def test_missing_columns_give_what_there_is(names: list[str], browser: Browser, tmp_path: Path):
    page = ldbench.view(foreign(tmp_path, names)).write(tmp_path/"page.html")
    browser.open(page, "#t=0.15")
    browser.is_quiet(page)
    shown = browser.run("return [...document.querySelectorAll('#values td[data-column]')].map(c => c.dataset.column)")
    assert sorted(shown) == sorted(names)
    assert "drawn are awprof.yz and arprof.yz" in browser.text("#about")
    browser.press(" ")
    browser.wait(lambda: browser.run("return ldbench.t") > 0.15)
    browser.press(" ", "2", "l")
    assert browser.log() == []


def test_foreign_file_over_ours(browser: Browser, world: World, tmp_path: Path):
    """With a map of names and units, in the page of the command."""
    other, page = tmp_path/"other.csv", tmp_path/"both.html"
    other.write_text("t [ms],ylat [mm]\n" + "".join(f"{1e3*a:.9g},{-1e3*b:.9g}\n" for a, b in zip(
        world.thrown.t, world.thrown.c["Y"], strict=True)))
    (tmp_path/"map.toml").write_text('time = "t"\nY = { column = "ylat", factor = -1 }\n')
    assert main(["view", str(world.thrown.file), str(other), "--map", str(tmp_path/"map.toml"), "-o", str(page)]) == 0
    browser.open(page, "#t=0.05")
    browser.is_quiet(page)
    d = browser.run("const [a, b] = ldbench.runs; return [...ldbench.difference(a, b, 'Y', 0, 1).x]")
    assert np.nanmax(np.abs(np.array(d, float))) < 1e-10


def test_hostile_names_are_text(browser: Browser, world: World, tmp_path: Path):
    file = foreign(tmp_path, [*(name.replace(",", ".") for name in HOSTILE), "Y"])
    text = world.thrown.text
    for what in "title", "name":
        text = re.sub(rf"(# +{what} = )'[^']*'", lambda found: f"{found[1]}'{HOSTILE[0]}'", text)
    text = re.sub(r"# case [^\n]*", lambda _: f"# case {HOSTILE[1]}: {HOSTILE[0]}{HOSTILE[5]}", text)
    text = re.sub(r"left flange contact", lambda _: HOSTILE[0], text, count=1)
    ours = tmp_path/"<b>ours.txt"
    ours.write_text(text, encoding="utf-8")
    title = HOSTILE[5] + HOSTILE[1]
    page = ldbench.view(file, ours, title=title).write(tmp_path/"page.html")
    browser.open(page)
    browser.is_quiet(page)
    assert browser.text("#title") == title == browser.run("return document.title")
    assert set(read_data(file).data) - {"time", "Y"} <= set(browser.texts("#values tbody th"))
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
    return ldbench.run(ldbench.Case.exercise(2, "aw").replace(**COARSE, t_end=0.03, stop_at="t_end", title='<b>"bold"</b> & more'))


def test_a_run_is_shown_as_its_file(short_run: ldbench.Run, tmp_path: Path):
    """The page of a run in memory says what the page of its column file says."""
    file = short_run.write(tmp_path/short_run.file.name)
    a, b = (facts(page.write(tmp_path/"page.html"))["runs"][0] for page in (short_run.view(), ldbench.view(file)))
    assert a == b


def test_notebook_shows_the_page_in_a_frame(browser: Browser, short_run: ldbench.Run, tmp_path: Path):
    notebook = tmp_path/"notebook.html"
    notebook.write_text(f"<!DOCTYPE html><meta charset=utf-8>{ldbench.view(short_run, short_run)._repr_html_()}", encoding="utf-8")
    browser.driver.get(notebook.as_uri())
    browser.driver.switch_to.frame(browser.driver.find_element("tag name", "iframe"))
    browser.wait(lambda: browser.run("return document.documentElement.dataset.ready") == "yes")
    assert browser.texts("#runs label span:last-child") == ["ex2_aw (1)", "ex2_aw (2)"]
    browser.click("#row-on")
    browser.wait(lambda: shown_time(browser) > 0)
    browser.driver.switch_to.default_content()
    assert [line for line in browser.log() if "SEVERE" in line] == []


def test_tables_for_a_notebook(short_run: ldbench.Run):
    case, run, table = (one._repr_html_() for one in (short_run.case, short_run, short_run.table))
    assert "&lt;b&gt;" in case and "<b>\"bold" not in case and "vY" in case and "0.03" in case
    assert "left flange contact" in run and f"{1e-3*short_run.results['peak_N_LF']:.3f} kN" in run
    assert f"{1e3*short_run.table.clearance:.3f}" in table and "90.000 kN" in table
    assert all(html.startswith("<table>") and html.endswith("</table>") for html in (case, run, table))
