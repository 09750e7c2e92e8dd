"""Run one case many times over lists or ranges of its variables.

Variables go by their names in the namelist. A list, 1,2,4, or a grid, 1:4:7 (seven values), makes a run for
every combination; with -n that many runs are drawn, each variable from its range 1:4.
The summary has the endings, and the range of each peak and first peak. A document .pdf, or a picture .svg or .png, has a page for
each variable with the results over it: -o draws it if the name ends so, --picture beside the Zarr directory that -o names.
Needs xarray, zarr for a Zarr directory and dask[distributed] for --scheduler: pip install ldbench[ensemble].

examples:
  python -m ldbench ensemble inputs/ex3_aw.nml --set roll_link=rails --over mass=1200:2000:9 --over vY=0.5,1,2 -o sweep.zarr
  python -m ldbench ensemble inputs/ex3_aw.nml --set roll_link=rails --over vY=0.5:1:6 -o sweep.pdf
  python -m ldbench ensemble inputs/ex3_aw.nml --over mass=1200:2000 --over gauge=1.43:1.44 -n 50 --seed 1
  python -m ldbench ensemble inputs/ex3_aw.nml --over mass=1200:2000:99 --scheduler tcp://node1:8786
"""
from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .._core.errors import Error, Usage
from .._core.files import check_written
from .._core.wording import counted
from ..case import Case, Value, find_variables
from ..constants import CONTACTS
from ..ensembles.sweep import ensemble
from ..plots.ensemble_pages import ensemble_figures
from ..plots.sheets import ENDINGS, check_sheets, save_sheets
from ..plots.style import ldbench_style
from ..results.quantities import OUTCOME
from .options import add_jobs, add_output, add_set, naming, parse_setting, settings

if TYPE_CHECKING:
    import xarray as xr


def parse_values(setting: str, drawn: bool = False) -> tuple[str, list[Value]]:
    """mass=1,2,4 or mass=1:4:7 as a name and values; where values are drawn, mass=1:4 as a name and the ends of a range."""
    name, words = setting.partition("=")[::2]
    if drawn != bool(re.fullmatch("[^:,]+:[^:,]+", words)):
        raise Usage(expected="a range name=1:4 after --over with -n" if drawn else
                    "name=1,2,4 or name=1:4:7 after --over, or a range with -n", found=setting)
    try:
        if found := re.fullmatch(r"([^:]+):([^:]+):(\d{1,9})", words):
            low, high = float(found[1]), float(found[2])
            if not np.isfinite([low, high]).all():
                raise ValueError
            return name, np.linspace(low, high, int(found[3])).tolist()
        if ":" in words and not drawn:
            raise ValueError
        return name, [parse_setting(f"{name}={word}", "--over")[1] for word in re.split("[,:]", words)]
    except ValueError:
        raise Usage(expected="name=1,2,4 or name=1:4:7 after --over", found=setting) from None


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("namelist", metavar="NAMELIST", help="namelist file")
    parser.add_argument("--over", metavar="NAME=VALUES", action="append", required=True,
                        help="a variable and its values: 1,2,4 or 1:4:7 (from, to, number), or with -n a range 1:4; as often as "
                             "given")
    parser.add_argument("-n", type=int, help="number of draws")
    parser.add_argument("--draw", choices=("random", "even"), default="random", help="how values are drawn (%(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="seed of the draws (%(default)s)")
    add_set(parser)
    add_output(parser, "Zarr directory for the results; what is done is not run again; or the document .pdf or the picture .svg "
                       "or .png of the results", "DIR|FILE")
    parser.add_argument("--picture", type=Path, metavar="FILE", help="draw the results, .pdf, .svg or .png")
    parser.add_argument("--columns", metavar="NAME,NAME", default="", help="keep these columns of every run")
    parser.add_argument("--rows", type=int, help="keep at most so many rows of them (all)")
    add_jobs(parser)
    parser.add_argument("--scheduler", metavar="ADDRESS", help="run on the workers of this Dask scheduler")


def main(args: argparse.Namespace) -> int:
    case = Case.from_namelist(args.namelist).replace(settings(args.set))
    over = [parse_values(setting, args.n is not None) for setting in args.over]
    with naming():
        find_variables(name for name, _ in over)
    columns = [name for name in args.columns.split(",") if name]
    store, picture = args.output, args.picture
    if store and store.suffix.lower() in ENDINGS:
        if picture:
            raise Usage(place="--picture", expected="a Zarr directory -o DIR beside it", found=f"-o {store}")
        store, picture = None, store
    if picture:
        check_sheets(picture)
        check_written([picture], [Path(args.namelist)])
    dataset = ensemble(case, dict(over), args.n, seed=args.seed, draw=args.draw, columns=columns, rows=args.rows, threads=args.jobs,
                       scheduler=args.scheduler, store=store, progress=True)
    print(outcome(dataset))
    if store:
        print(f"{store}: xarray.open_zarr reads it")
    failed = (dataset.error != "").values
    if failed.all():
        raise Error(place="ensemble", expected="a run that succeeds",
                    found=f"{dataset.error.size} that failed, the first one with: {dataset.error.values.flat[0]}")
    if picture:
        save_figures(dataset, picture)
    return int(failed.any())


def save_figures(dataset: xr.Dataset, target: Path) -> None:
    """Draw the results over each variable."""
    with ldbench_style():
        figures = ensemble_figures(dataset)
        save_sheets(figures, target)
    print(f"{target}: {counted(len(figures), 'page')}")


def outcome(dataset: xr.Dataset) -> str:
    """Summarise an ensemble: numbers of runs, endings, and the ranges of results."""
    errors = dataset.error.values.ravel()
    failed = np.flatnonzero(errors != "")
    lines = [" x ".join(f"{size} {name}" for name, size in dataset.sizes.items()
                        if name in dataset.error.dims) + f": {counted(errors.size, 'run')}, {failed.size} failed"]
    if failed.size:
        lines.append(f"first failure: {errors[failed[0]]}")
    if failed.size < errors.size:
        ends, counts = np.unique(dataset.end.values[dataset.error.values == ""], return_counts=True)
        lines += [f"{count} ended with {end}" for end, count in zip(ends, counts, strict=True)]
        for name in (*(f"peak_N_{c}" for c in CONTACTS), *(f"first_peak_N_{c}" for c in ("LF", "RF")), "t"):
            if np.isnan(dataset[name].values).all():        # the flange of no run has touched
                continue
            known, values = OUTCOME[name], OUTCOME[name].scale*dataset[name].values
            lines.append(f"{name} [{known.unit}]: {np.nanmin(values):.6g} to {np.nanmax(values):.6g}, "
                         f"median {np.nanmedian(values):.6g}")
    return "\n".join(lines)
