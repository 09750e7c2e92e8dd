"""How far answers are to be trusted: changes are those of plain runs, and what is printed and drawn is what they say."""
from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

import ldbench
import shapes
from ldbench import Case, Profile, Trust, bodies
from ldbench.__main__ import main
from ldbench.ensembles.members import table_keys
from ldbench.report.trusted import kept_trusts
from ldbench.results.twins import TWINS, is_chaotic, twin_cases
from ldbench.table import ContactTable
from ldbench.trust.page import report_pages
from ldbench.trust.variations import variations
from named_artists import shown
from running import with_kept_table
from specimen import World
from table import RESULTS
from walk import walk

COARSE = {"model": "hertz", "accuracy": 2e-2}
THROWN = with_kept_table(Case.exercise(2, "aw").replace(**COARSE))
PEAK = "first_peak_N_LF"


@pytest.fixture(scope="module")
def found() -> Trust:
    return THROWN.trust()


@pytest.mark.parametrize(("cause", "changes", "exact"), [
    ("mass + 1 %", {"mass": 1.01*1568.0}, True),
    ("vY + 1 %", {"vY": 1.01*0.5}, True),
    ("gauge + 0.1 mm", {"gauge": 1.4352}, True),
    ("table accuracy 0.04", {"accuracy": 4e-2}, True),
    ("youngs_modulus + 1 %", {"youngs_modulus": 1.01*2.1e11}, False),
    ("poisson + 1 %", {"poisson": 1.01*0.28}, False),
], ids=lambda x: x if isinstance(x, str) else "")
def test_a_change_is_that_of_two_plain_runs(cause: str, changes: dict[str, float], exact: bool, found: Trust):
    """A modulus changes by way of masses and loads: its own contact table gives the same, up to rounding."""
    before, after = ldbench.run(THROWN), ldbench.run(with_kept_table(THROWN.replace(**changes)))
    for name in PEAK, "first_duration_LF", "t_first_RF", "first_peak_N_RF", "farthest_left", "F_limit_left":
        one = found.answers[name]
        assert one.value == before.results[name]
        expected = after.results[name] - before.results[name]
        near = (0.0, 0.0) if exact else (1e-3, 1e-7*abs(one.value))
        assert one.causes.get(cause, 0.0) == pytest.approx(expected, rel=near[0], abs=near[1])


def test_inputs_that_matter(found: Trust):
    """Every input that is not zero is varied; those are named that change nothing."""
    varied = {cause.partition(" ")[0] for kind, cause in found.variations if kind == "input"}
    assert varied == {"mass", "roll_inertia", "rolling_radius", "back_to_back", "vertical_load", "gauge", "gauge_depth",
                      "youngs_modulus", "poisson", "vY", "roll_rate"}
    assert found.without_effect == ("pitch_inertia + 1 %", "shear_modulus + 1 %", "vX + 1 %", "pitch_rate + 1 %")
    same = ldbench.run(THROWN.replace(pitch_inertia=2*THROWN.pitch_inertia, shear_modulus=7e10)).results
    assert same[PEAK] == found.answers[PEAK].value


def test_twins(found: Trust):
    """Eight starts to either side; the largest of their changes is one cause."""
    assert len(TWINS) == 8 and sorted(TWINS) == sorted(-x for x in TWINS)
    assert (min(map(abs, TWINS)), max(map(abs, TWINS))) == (1e-9, 3e-6)
    assert [twin.initial_Y for twin in twin_cases(THROWN.replace(initial_Y=1e-3))] == [1e-3 + shift for shift in TWINS]
    one = found.answers["t_first_LF"]
    own = [ldbench.run(twin).results["t_first_LF"] for twin in twin_cases(THROWN)]
    assert list(one.twins) == own
    assert abs(one.causes["start, within 3 µm"]) == max(abs(x - one.value) for x in own)


def made(own: dict[str, list[float]], kinds: list[str]) -> Trust:
    """A finding with these values of the case and its variations; a twin is called so, another cause by its place."""
    named = tuple((kind, kind if kind == "twin" else f"{kind} {k}") for k, kind in enumerate(kinds, 1))
    return Trust("made", "", named, {name: tuple(values) for name, values in own.items()}, {}, (), ())


def test_statistics():
    """By hand: medians and ranges, inputs to either side, causes in order."""
    kinds = ["twin", "twin", "accuracy", "influence", "input", "input", "smoothing"]
    one = made({PEAK: [100.0, 100.02, 99.99, 101.0, 97.0, 110.0, 99.0, 104.0]}, kinds).answers[PEAK]
    assert (one.value, one.median, one.low, one.high) == (100, 100, 97, 101)
    assert (one.low_inputs, one.high_inputs, one.chaotic) == (90, 110, False)
    assert list(one.causes) == ["input 5", "smoothing 7", "influence 4", "accuracy 3", "input 6", "twin"]
    assert one.causes["twin"] == pytest.approx(0.02) and one.causes["influence 4"] == -3
    assert one.main_causes() == {name: change for name, change in one.causes.items() if name != "twin"} | {
        "others": pytest.approx(0.02)}
    assert "    causes: input 5: +10 %; smoothing 7: +4 %; influence 4: −3 %; accuracy 3: +1 %; input 6: −1 %;" in [*one.lines()]


def test_a_chaotic_answer_says_so():
    kinds = ["twin", "twin", "twin", "input"]
    one = made({"t_return": [1.0, 1.2, 0.9, 0.8, 1.5]}, kinds).answers["t_return"]
    assert one.chaotic and one.causes["twin"] == pytest.approx(0.2)
    assert (one.low_inputs, one.high_inputs) == (0.8, 1.5), "an input counts to one side where nothing is in proportion"
    first, _, twins, *_ = one.lines()
    assert first == "return to the centre after turning back on both sides: 1.000000 s, chaotic: one sample"
    assert twins == "    run and twins: median 0.950000, 0.800000 to 1.200000; 4 of 4 have it"


def test_an_answer_that_comes_or_goes():
    """It stands before all others; numbers are those of the runs that have it."""
    nan = np.nan
    found = made({"t_return": [1.0, 1.0, nan, 1.5], PEAK: [nan, nan, 5.0, nan]}, ["twin", "input", "input"])
    goes, comes = found.answers["t_return"], found.answers[PEAK]
    assert goes.causes == {"input 2": np.inf, "input 3": 0.5} and not goes.chaotic and goes.high_inputs == 1.5
    assert comes.causes == {"input 2": np.inf} and np.isnan(comes.median)
    assert any("input 2: makes it go; input 3: +50 %" in line for line in goes.lines())
    assert any("input 2: makes it come" in line for line in comes.lines())
    assert [one.name for one in found.shown()] == ["t_return"]
    assert not is_chaotic(PEAK, nan, [nan, nan]) and is_chaotic(PEAK, 1.0, [1.0, nan]) and is_chaotic(PEAK, nan, [1.0, nan])
    assert not is_chaotic("farthest_left", 0.0, [3e-6]) and is_chaotic("t", 0.0, [3e-6])


def test_a_ramp_is_chaotic():
    """Exercise 5, pushed fast: bounces until it derails, at another force from every start, below a limit that all share."""
    case = with_kept_table(Case.exercise(5, "aw").replace(**COARSE, lateral_ramp=5e5, t_end=2.0, interval=1e-3))
    found = case.trust()
    one = found.answers["F_derailment"]
    assert one.chaotic and one.name in [shown.name for shown in found.shown()]
    forces = [ldbench.run(twin).results["F_derailment"] for twin in twin_cases(case)]
    assert list(one.twins) == forces and max(forces) > 1.002*min(forces)
    assert "9 of 9 have it" in " ".join(found.lines())
    told = np.median([one.value, *forces])
    assert any(f"run and twins: median {1e-3*told:.1f}, " in line for line in one.lines())
    assert not found.answers["F_limit_left"].chaotic and not found.answers["t_first_LF"].chaotic
    assert "lateral_ramp + 1 %" in [cause for _, cause in found.variations]


def test_rigid_contacts():
    """They have no table, no influences and no modulus; a restitution of 1 is lowered."""
    case = THROWN.replace(formulation="unilateral", t_end=0.1, stop_at="t_end")
    found = case.trust(laws=True)
    assert {kind for kind, _ in found.variations} == {"twin", "input"}
    assert "restitution − 1 %" in [cause for _, cause in found.variations]
    assert {"youngs_modulus + 1 %", "poisson + 1 %"} <= set(found.without_effect)
    assert found.notes == ("laws: contacts are unilateral, which have none",)
    lower = ldbench.run(case.replace(restitution=0.99)).results["turn_impulse_LF"]
    one = found.answers["turn_impulse_LF"]
    assert one.causes["restitution − 1 %"] == lower - one.value != 0


def test_half_spaces_vary_influence_and_asked_law(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("ldbench.bodies.kept", lambda case, support, folder: folder/f"{support}.bodies")
    case = THROWN.replace(model="halfspace", influence="flat", accuracy=3e-3, table_folder="")
    listed, notes = variations(case, True, tmp_path)
    cases = {one.name: one.case for one in listed}
    assert {name: one.influence for name, one in cases.items() if name.startswith("influence")} == {
        "influence local": "local", "influence apart": "apart"}
    assert {name: one.model for name, one in cases.items() if name.startswith("law")} == {
        "law strip": "strip", "law hertz": "hertz"}
    assert [cases[f"table accuracy {x}"].accuracy for x in ("0.0015", "0.006")] == [1.5e-3, 6e-3] and notes == []
    # Apart from the cause, each is the case itself.
    for name, one in cases.items():
        changed = [x for x, y in zip(one.values, case.values, strict=True) if x != y]
        assert len(changed) == 1 or name.startswith(("youngs_modulus", "poisson", "infinite", "clamped")), name
    assert not any(one.kind in ("influence", "law") for one in variations(THROWN, False, tmp_path)[0])


def test_half_spaces(world: World, tmp_path: Path):
    """Influence, bodies, pressures and static limit: changes are those of plain runs; a modulus by way of masses scales pressures,
    too."""
    case = Case.from_namelist(world.folder/"inputs/ex2_aw.nml")
    found, = map(Trust.of_facts, json.loads((world.outputs/".ldbench/trust.json").read_text()))
    before = ldbench.run(case).results
    clamped = {"influence": "bodies", "bodies": bodies.kept(case, "clamped", tmp_path)}
    for cause, changes in {"influence flat": {"influence": "flat"}, "youngs_modulus + 1 %": {"youngs_modulus": 1.01*2.1e11},
                           "rolling_radius + 1 %": {"rolling_radius": 1.01*0.457}, "clamped bodies": clamped}.items():
        after = ldbench.run(case.replace(**changes)).results
        for name in "pmax_LF", PEAK, "patch_LF", "approach_LF", "F_limit_left", "F_limit_right":
            one = found.answers[name]
            assert one.value == before[name]
            assert one.causes.get(cause, 0.0) == pytest.approx(after[name] - before[name], rel=2e-3, abs=1e-7*abs(one.value)), cause
    assert found.answers["pmax_LF"].causes["youngs_modulus + 1 %"] > 0.005*found.answers["pmax_LF"].value


def test_measured_profiles(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """A noisy wheel is smoothed by half and by twice as much; a file that was written smoothed names what is missing."""
    monkeypatch.chdir(tmp_path)
    noisy = shapes.noisy(shapes.with_faces(shapes.shape("awprof")), 0.01, 3)
    Path("wheel.whl").write_text(shapes.old_miniprof(noisy, "wheel"))
    case = with_kept_table(THROWN.replace(wheel_profile="wheel.whl", t_end=0.03, stop_at="t_end"))
    found = case.trust()
    smoothing = Profile("wheel.whl").smoothing
    # The curve leaves the noise of 0.01 mm to the points, but for the few that determine each piece.
    assert smoothing == pytest.approx(0.01, rel=0.1)
    causes = [cause for kind, cause in found.variations if kind == "smoothing"]
    assert causes == [f"smoothing of the wheel wheel.whl {1e3*factor*smoothing:.2g} µm" for factor in (0.5, 2)]
    Profile("wheel.whl", smoothing=2*smoothing).write("smoother.yz")
    twice = ldbench.run(with_kept_table(case.replace(wheel_profile="smoother.yz"))).results[PEAK]
    one = found.answers[PEAK]
    assert one.causes[causes[1]] == twice - one.value != 0
    assert one.low <= one.value <= one.high and one.low_inputs <= twice <= one.high_inputs
    Profile("wheel.whl").write("written.yz")
    listed, notes = variations(case.replace(wheel_profile="written.yz"), False, tmp_path)
    assert not any(one.kind == "smoothing" for one in listed)
    assert len(notes) == 1 and f"smoothing of written.yz: {smoothing:.4f} mm" in notes[0]


def test_tables_are_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """In the folder of the case: a second call solves nothing."""
    monkeypatch.chdir(tmp_path)
    case = THROWN.replace(table_folder="outputs/tables", t_end=0.01, stop_at="t_end")
    tables: list[ContactTable] = []
    own = ContactTable._own

    def noting(table: ContactTable, *given: object) -> None:
        own(table, *given)      # type: ignore[arg-type]
        tables.append(table)

    monkeypatch.setattr(ContactTable, "_own", noting)
    once = case.trust()
    built = [table for table in tables if table.solutions[1] == 0]
    assert len(list(Path("outputs/tables").iterdir())) == len({table_keys()(table.case) for table in built}) > 5
    tables.clear()
    assert case.trust() == once and all(table.solutions[0] == table.solutions[1] > 0 for table in tables)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["outputs"]


def test_json_is_the_whole(found: Trust, tmp_path: Path):
    """What is read from it says the same, whatever happens in the runs; something else is refused."""
    for one in found, made({"t_return": [1.0, np.nan, 2.0]}, ["twin", "input"]):
        text = one.json(tmp_path/"trust.json")
        assert (tmp_path/"trust.json").read_text(encoding="utf-8") == text + "\n"
        again = Trust.of_facts(json.loads(text))
        assert again.facts() == one.facts() and again.lines(True) == one.lines(True)
    told = json.loads(found.json())["answers"][PEAK]
    assert (told["value"], told["unit"]) == (found.answers[PEAK].value, "N") and told["causes"] == dict(found.answers[PEAK].causes)
    for damaged in {}, {"answers": 3}, [], {"answers": {"t": {"value": "x", "values": []}}}:
        with pytest.raises(ldbench.Error, match="expected the JSON"):
            Trust.of_facts(damaged)


def test_frame(found: Trust):
    frame = found.to_frame()
    assert list(frame.index) == [one.name for one in found.shown()] and PEAK in frame.index
    assert frame.loc[PEAK, "mass + 1 %"] == found.answers[PEAK].causes["mass + 1 %"]
    assert frame.loc[PEAK, "value"] == found.answers[PEAK].value and frame.loc[PEAK, "unit"] == "N"
    assert len(found.to_frame(True)) > len(frame)
    assert "peak N, first contact, left flange" in found._repr_html_()


WORDS = {"program": "program leaves open", "input": "inputs", "smoothing": "smoothing of profiles", "law": "contact law",
         "others": "the others' sum"}
REPORTED = {PEAK: "first peak of the left flange", "t_return": "return to the centre"}


def walk_causes(figure: Figure, told: dict[str, dict]) -> int:
    """Walk bars of causes: each as long as the change of the JSON of its case in %, of zero in its unit; the largest at the top,
    the sum of the others below; in the colour that the legend has for its kind."""
    heads: dict[str, list[float]] = {}

    def compare_bar(source: object, ax: Axes, bar: Rectangle) -> None:
        case, _, cause = shown(bar).of.partition(", ")
        name, _, unit = shown(bar).x.removeprefix("change of ").removesuffix("]").partition(" [")
        answer, known = told[case]["answers"][name], RESULTS[name]
        heads_of = {words.partition(" [")[0] for words in (known.words, known.short, known.brief)} | {REPORTED.get(name, "")} - {""}
        causes = {words: change for words, change in answer["causes"].items() if change is not None}
        names = [label.get_text() for label in ax.get_yticklabels()]
        row = round(bar.get_y() + bar.get_height()/2)
        assert names[row] == cause and ax.yaxis_inverted() and len(names) <= 9
        assert ax.get_title(loc="left").splitlines()[0].removeprefix(f"{case}, ") in heads_of
        factor = 100/abs(answer["value"]) if answer["value"] else known.scale
        assert unit == ("%" if answer["value"] else known.words.partition(" [")[2].removesuffix("]"))
        change = sum(abs(x) for words, x in causes.items() if words not in names) if cause == "others" else causes.get(cause, 0.0)
        assert bar.get_width() == pytest.approx(factor*change), shown(bar)
        heads.setdefault(ax.get_title(loc="left"), []).append(abs(bar.get_width()) if cause != "others" else 0.0)

    def kind_of(bar: Artist) -> str:
        """The kind of a cause, in words."""
        case, _, cause = shown(bar).of.partition(", ")
        kinds = {one["cause"]: one["kind"] for one in told[case]["variations"]} if case else {}
        return WORDS.get(kinds.get(cause, "others"), WORDS["program"]) if case else ""

    count = walk(figure, {"bar": compare_bar}, None, label=kind_of)
    assert all(sizes == sorted(sizes, reverse=True) for sizes in heads.values())
    return count


def test_bars_are_the_causes(found: Trust):
    figure, = found.plot()
    assert walk_causes(figure, {found.case: json.loads(found.json())}) > 40
    for one in found.shown():
        assert any(ax.get_title(loc="left").startswith(one.quantity.short or one.quantity.words) for ax in figure.axes)


def test_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], undrawn: None, found: Trust):
    """It prints what `lines` says, or JSON alone, and names the files that it writes."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("ldbench.commands.trust.trust", lambda case, **how: found)
    THROWN.to_namelist("case.nml")
    assert main(["trust", "case.nml", "--json", "found.json", "--picture", "found.png"]) == 0
    assert capsys.readouterr().out == "\n".join([*found.lines(), "found.json", "found.png"]) + "\n"
    assert Path("found.json").read_text(encoding="utf-8") == found.json() + "\n" and Path("found.png").is_file()
    assert main(["trust", "case.nml", "--json", "-", "-q"]) == 0
    assert capsys.readouterr() == (found.json() + "\n", "")
    assert max(len(line) for line in found.lines(True)) <= 100


def test_refusals(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    monkeypatch.chdir(tmp_path)
    THROWN.replace(dt=1e-4, t_end=0.01).to_namelist("case.nml")
    for words, said in ((["none.nml"], "none.nml"), (["case.nml", "--picture", "a.txt"], "or a picture .svg or .png, found .txt"),
                        (["case.nml", "--json", "case.nml"], "a file of its own"), (["case.nml", "-j", "0"], "a number from 1"),
                        (["case.nml", "--json", "nowhere/a.json"], "a folder that is there"),
                        (["case.nml", "--set", "wheel_profile=none.yz"], "none.yz")):
        assert main(["trust", *words]) in (1, 2)
        told = capsys.readouterr()
        assert told.out == "" and told.err.startswith("ldbench: error: ") and told.err.count("\n") == 1 and said in told.err
    with pytest.raises(ValueError, match="at least one thread, found 0"):
        THROWN.trust(jobs=0)


def test_pages_of_a_report(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, found: Trust):
    """A page for each pair, with first peak and return of each exercise that may return, by its bars; kept for next time."""
    monkeypatch.chdir(tmp_path)
    Path("inputs").mkdir()
    for number in 1, 2, 5:
        Case.exercise(number, "aw").to_namelist(f"inputs/ex{number}_aw.nml")
    without = {name: values for name, values in found.values.items() if name != "t_return"}
    given = {"ex1_aw": replace(found, case="ex1_aw", values=without), "ex2_aw": found}
    monkeypatch.setattr("ldbench.report.trusted.trust", lambda case, jobs: given[case.case_name])
    trusted = kept_trusts(Path("inputs"), Path("outputs"), 2)
    assert [one.case for one in trusted] == ["ex1_aw", "ex2_aw"]
    (words, page), = report_pages(trusted)
    assert words == "actual profiles"
    drawn = {ax.get_title(loc="left").partition("\n")[0]: ax for ax in page.axes if ax.axison}
    assert set(drawn) == {"ex1_aw, first peak of the left flange", "ex2_aw, first peak of the left flange",
                          "ex2_aw, return to the centre"}, "exercise 1 does not return here"
    assert walk_causes(page, {one.case: json.loads(one.json()) for one in trusted}) > 15
    monkeypatch.setattr("ldbench.report.trusted.trust", None)
    assert [one.facts() for one in kept_trusts(Path("inputs"), Path("outputs"), 2)] == [one.facts() for one in trusted]


def test_progress_and_a_stop():
    """The share grows to 1; what `progress` raises ends the work."""
    case = THROWN.replace(t_end=0.01, stop_at="t_end")
    told: list[float] = []
    case.trust(progress=lambda stage, share: told.append(share))
    assert told == sorted(told) and told[-1] == 1 and len(told) > 20

    def stop(stage: str, share: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        case.trust(progress=stop)


def test_a_variation_that_cannot_run_is_named():
    """A start whose flange is pressed nearly as deep as the table goes: 1 % further is too deep, and fails alone."""
    case = THROWN.replace(Y=0.01255, t_end=2e-3, stop_at="t_end")
    found = case.trust()
    assert list(found.failed) == ["Y + 1 %"] and "expected penetrations that the contact table covers" in found.failed["Y + 1 %"]
    assert any(line.startswith("failed: Y + 1 %: ") for line in found.lines())
    assert "Y + 1 %" not in [cause for _, cause in found.variations] and PEAK in found.answers
    with pytest.raises(ldbench.Error, match="expected penetrations that the contact table covers"):
        case.replace(Y=1.01*0.01255).trust()
