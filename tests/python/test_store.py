"""The store of an ensemble is data, which anybody reads and nobody runs: damage is noticed, and nothing goes but by a command."""
from __future__ import annotations

import json
import os
import pickle
import sqlite3
from collections import Counter
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

pytest.importorskip("xarray")
pytest.importorskip("zarr")

import xarray as xr

import ldbench
from invented import COARSE
from ldbench.__main__ import as_called, main
from ldbench.ensembles import members
from ldbench.ensembles.records import SCHEMA, open_records
from running import kept_tables

pytestmark = pytest.mark.usefixtures("few_results")

MASSES = [1300.0, 1500.0]


def short(**changes: object) -> ldbench.Case:
    return ldbench.Case.exercise(3).replace(**COARSE | {"dt": 1e-5, "t_end": 1e-3, "table_folder": kept_tables()} | changes)


@pytest.fixture
def store(tmp_path: Path) -> Path:
    return tmp_path/"sweep.zarr"


@pytest.fixture
def runs(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """Counts the runs of ensembles."""
    counts: Counter[str] = Counter()
    compute = members.compute

    def counting(*arguments):
        counts["runs"] += 1
        return compute(*arguments)

    monkeypatch.setattr(members, "compute", counting)
    return counts


def file_of(store: Path) -> Path:
    return store.parent/".ldbench"/f"{store.name}.sqlite"


def sweep(store: Path, masses: list[float] = MASSES, **options: object) -> xr.Dataset:
    return ldbench.ensemble(short(), {"mass": masses}, store=store, threads=1, **options)


def query(store: Path, command: str, *values: object) -> list[tuple]:
    with closing(sqlite3.connect(file_of(store))) as database, database:
        return database.execute(command, values).fetchall()


class Harmful:
    """What runs a command where it is unpickled."""

    def __init__(self, proof: Path) -> None:
        self.proof = proof

    def __reduce__(self):
        return os.mkdir, (str(self.proof),)


RECORDS = [
    {"error": "mass: expected more"},
    {"peak_N_LF": 0.1 + 0.2, "t_first_LF": np.nan, "least": -np.inf, "success": True, "steps": 1e300, "end": "é \u2028 'quoted'",
     "Y": np.array([0.1, np.nan, -0.0, np.inf]), "event_time": np.arange(6.0).reshape(2, 3), "count": np.arange(3), "error": ""}]


@pytest.mark.parametrize("record", RECORDS, ids=len)
def test_a_record_comes_back_to_the_last_bit(record: dict, store: Path):
    with open_records(store) as records:
        records["key"] = record
        found = records["key"]
    assert list(found) == list(record)
    for name, value in record.items():
        assert type(found[name]) is type(value), name
        assert np.asarray(found[name]).tobytes() == np.asarray(value).tobytes(), name
        assert np.asarray(found[name]).dtype == np.asarray(value).dtype and np.shape(found[name]) == np.shape(value), name


def test_an_earlier_store_is_refused_and_not_run(store: Path, capsys: pytest.CaptureFixture[str]):
    """Earlier stores had pickles, which may hold anything."""
    file_of(store).parent.mkdir()
    proof = store.parent/"proof"
    query(store, "CREATE TABLE records (key TEXT PRIMARY KEY, record BLOB)")
    keys = members.keys_of(members.plan(short(), {"mass": MASSES}, None, 0, "random")[0], members.Wanted())
    for key in keys:
        query(store, "INSERT INTO records VALUES (?, ?)", key, pickle.dumps(Harmful(proof)))
    with pytest.raises(ldbench.Error) as told:
        sweep(store)
    assert str(told.value).startswith(f"{file_of(store)}: expected results in the schema {SCHEMA}, found those of another version")
    assert "--remove all" in str(told.value) and not proof.exists() and len(query(store, "SELECT * FROM records")) == 2
    assert main(["store", str(store)]) == 1
    assert capsys.readouterr().err == as_called(f"ldbench: error: {told.value}\n")
    assert main(["store", str(store), "--remove", "all"]) == 0
    assert not proof.exists() and not file_of(store).exists()
    assert (sweep(store).error == "").all()


def test_no_record_is_a_pickle(store: Path):
    """Numbers are JSON, arrays the bytes of doubles: with neither ldbench nor numpy's pickles."""
    sweep(store, columns=["Y"])
    found = query(store, "SELECT facts, name, data FROM records JOIN arrays USING (key)")
    assert len(found) == 2*4
    for facts, name, data in found:
        assert json.loads(facts)["end"].startswith("t_end")
        assert json.loads(facts)[name]["kind"] == "<f8" and len(data) == 8*np.prod(json.loads(facts)[name]["shape"])
    assert b"\x80\x04\x95" not in file_of(store).read_bytes()      # the head of a pickle


def flip_facts(store: Path) -> None:
    query(store, "UPDATE records SET facts = replace(facts, '\"rows\": 1', '\"rows\": 3') WHERE rowid = 1")


def flip_data(store: Path) -> None:
    data, = query(store, "SELECT data FROM arrays WHERE name = 'Y' ORDER BY rowid LIMIT 1")[0]
    query(store, "UPDATE arrays SET data = ? WHERE data = ?", data[:24] + bytes([data[24] ^ 1]) + data[25:], data)


def exchange_keys(store: Path) -> None:
    one, two = (key for key, in query(store, "SELECT key FROM records"))
    for table in "records", "arrays":
        for new, old in ("-", one), (one, two), (two, "-"):
            query(store, f"UPDATE {table} SET key = ? WHERE key = ?", new, old)


@pytest.mark.parametrize(("damage", "damaged"), [
    (flip_facts, 1), (flip_data, 1), (lambda store: query(store, "DELETE FROM arrays WHERE name = 'Y'"), 2), (exchange_keys, 2)],
    ids=["a bit of facts", "a bit of data", "arrays gone", "keys exchanged"])
def test_damage_is_a_warning_and_its_members_run_again(damage: Callable[[Path], object], damaged: int, store: Path,
                                                       runs: Counter[str]):
    whole = sweep(store, columns=["Y"])
    assert runs["runs"] == 2
    damage(store)
    with pytest.warns(ldbench.Warning) as warned:
        again = sweep(store, columns=["Y"])
    assert runs["runs"] == 2 + damaged and again.identical(whole)
    words = "1 result is damaged and is" if damaged == 1 else "2 results are damaged and are"
    assert [str(one.message) for one in warned] == [f"{file_of(store)}: {words} computed again"]
    assert sweep(store, columns=["Y"]).identical(whole) and runs["runs"] == 2 + damaged      # without a warning, which would fail


def test_flipped_bits_of_the_zarr_directory_are_told(store: Path):
    sweep(store, columns=["Y"])
    chunk = next(file for file in (store/"Y").rglob("*") if file.is_file() and not file.name.startswith("."))
    data = bytearray(chunk.read_bytes())
    data[-5] ^= 1
    chunk.write_bytes(data)
    with pytest.raises(Exception, match=r"(?i)zstd|corrupt|checksum"), xr.open_zarr(store) as stored:
        stored.load()


def test_sweeps_live_side_by_side(store: Path, runs: Counter[str], capsys: pytest.CaptureFixture[str]):
    first = sweep(store)
    second = sweep(store, [1500.0, 1700.0, -1.0])
    assert runs["runs"] == 3
    with xr.open_zarr(store) as stored:
        assert stored.load().identical(second)
    assert sweep(store).identical(first) and runs["runs"] == 3
    assert main(["store", str(store), "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)["sweeps"]
    assert [(one["members"], one["done"], one["failed"]) for one in listed] == [(2, 2, 0), (3, 3, 1)]
    assert [one["about"]["dims"] for one in listed] == [{"mass": 2}, {"mass": 3}]
    assert all(one["about"]["case"] == "ex3_aw" for one in listed)
    assert main(["store", str(store)]) == 0
    said = capsys.readouterr().out
    assert all(one["sweep"] in said for one in listed) and "3 members (3 mass), 3 done, 1 failed" in said
    # What another sweep has as well stays.
    assert main(["store", str(store), "--remove", listed[1]["sweep"]]) == 0
    assert capsys.readouterr().out.startswith("2 results removed\n") and len(query(store, "SELECT * FROM records")) == 2
    assert sweep(store).identical(first) and runs["runs"] == 3
    assert main(["store", str(store), "--remove", "000000"]) == 1
    assert f"expected a sweep among {listed[0]['sweep']}, found 000000" in capsys.readouterr().err
    assert main(["store", str(store.parent/"none.zarr")]) == 1
    assert "none.zarr: expected the store of an ensemble, found none" in capsys.readouterr().err
    assert not (store.parent/".ldbench/none.zarr.sqlite").exists()


def test_pandas_reads_it_without_ldbench(store: Path):
    """The query of docs/ensembles.md."""
    found = sweep(store, [*MASSES, -1.0], columns=["Y"])
    with closing(sqlite3.connect(f"file:{file_of(store)}?mode=ro", uri=True)) as database:
        frame = pd.read_sql("SELECT * FROM results ORDER BY number", database)
        array = pd.read_sql("SELECT data FROM arrays JOIN members USING (key) WHERE name = 'Y' AND number = 1", database)
    values = pd.json_normalize(frame.facts.map(json.loads))
    assert [json.loads(point) for point in frame.point] == [{"mass": mass} for mass in (*MASSES, -1.0)]
    assert np.array_equal(values.peak_N_LT, found.peak_N_LT.values, equal_nan=True)
    assert frame.error.tolist() == found.error.values.tolist() and "expected" in frame.error[2]
    assert np.array_equal(np.frombuffer(array.data[0], values["Y.kind"][1]), found.Y[1])


def test_a_reader_stops_nobody(store: Path, runs: Counter[str]):
    """An open connection, amid a query, and a second one that reads while the ensemble writes."""
    first = sweep(store)
    with closing(sqlite3.connect(file_of(store))) as reader:
        cursor = reader.execute("SELECT * FROM records")
        assert cursor.fetchone()
        seen = []
        more = sweep(store, [*MASSES, 1700.0],
                     progress=lambda *_: seen.append(query(store, "SELECT count(*) FROM records")[0][0]))
        assert cursor.fetchone()
    assert seen == [3] and runs["runs"] == 3 and more.isel(mass=slice(2)).peak_N_LT.identical(first.peak_N_LT)


def test_who_holds_it_for_writing_is_told_of(store: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("ldbench.ensembles.records.BUSY", 0.2)
    sweep(store)
    with closing(sqlite3.connect(file_of(store), isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")
        with pytest.raises(ldbench.Error, match=r"sweep\.zarr: cannot be written completely: database is locked"):
            sweep(store, [1900.0])
    assert (sweep(store, [1900.0]).error == "").all()
