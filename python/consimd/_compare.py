"""Comparisons of solvers."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from consimd import _core
from consimd._outside import named_solvers
from consimd._tables import structured

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from consimd._outside import Solvers


class ComparisonTable(NamedTuple):
    """A table of a comparison, as people read it: numbers are text, "-" where there is none."""

    title: str
    caption: list[str]
    """What the data are, what a success is, what the columns mean."""
    columns: list[str]
    rows: list[list[str]]
    markdown: str
    """All of it."""


class CompareResult(NamedTuple):
    """The runs of a comparison and the tables made of them."""

    runs: NDArray[np.void]
    """A structured array with the columns of the command's runs.csv, see `table_columns`: one row per run."""
    tables: dict[str, ComparisonTable]
    """By name, in the order of the command."""


def _names(names: str | Sequence[str]) -> list[str]:
    return [names] if isinstance(names, str) else list(names)


def _floats(values: Iterable[float] | None) -> list[float] | None:
    return None if values is None else [float(value) for value in values]


def compare(
    cases: str | os.PathLike[str] | None = None,
    synthetic: str | Sequence[str] = (),
    *,
    tables: str | Sequence[str] = ("solvers",),
    solvers: Solvers | None = None,
    versions: Mapping[str, str] | None = None,
    time_limit: float = 60.0,
    filter: str = "none",
    thresholds: str = "case",
    trials: int = 20,
    points: int = 3000,
    outliers: Iterable[float] | None = None,
    sigma: Iterable[float] | None = None,
    iterations: Iterable[int] | None = None,
    iteration_problems: int = 200,
    scales: Iterable[float] | None = None,
    seed: int = 1,
    seeds: int = 1,
    threads: int | None = None,
    out: str | os.PathLike[str] | None = None,
    fresh: bool = False,
    progress: Callable[[int, int], object] | None = None,
) -> CompareResult:
    """Runs solvers on the same problems with the same seeds and makes the tables of the TCF paper's evaluation.

    cases: a folder whose sub-folders hold correspondences.txt, pose.txt and case.json.
    synthetic: names of stand-ins (see `consimd.synth.stand_ins()`), "stand-ins" (all of them), "eth", "kitti", or
        "noise", cells of the noise study. Nothing: all stand-ins, unless there are cases.
    tables: "solvers", "boost", "stages", "poses", "iterations", "scales".
    solvers, versions, time_limit: as those of `consimd.sweep`, of the tables; solvers None: all of consimd's.
    filter: "tcf" runs the table "solvers" after TCF's filter.
    thresholds: limits of a success: "case" (what each case states), "paper", "eth", "kitti", "kitti06", "3dmatch".
    trials: problems of each stand-in, noise cell, and scale with its noise.
    points, outliers, sigma: of the noise cells; None: 0.1 to 0.99 and 0.1 to 5 m.
    iterations, iteration_problems: samples of plain RANSAC, and the problems, of the table "iterations"; None: 1000 to
        1 000 000.
    scales: of the source, for the table "scales"; None: 0.2 to 5.
    seed: of the data; synthetic problem k starts its solvers with seed + k.
    seeds: runs of a solver on each case, with seeds one after the other.
    threads: as that of `consimd.register`. Runs go one at a time, each on all threads.
    out: a folder that gets runs.csv as runs end, then tables.md, a table_*.csv a table, and comparison.json. The same
        call takes up a comparison that was stopped; RuntimeError if the folder holds another one, unless `fresh` drops
        that, or if another process writes to it.
    progress: called with the numbers of runs done and of all, some ten times a second.

    The same runs as `consimd compare`, but for the times. ValueError on a bad argument, RuntimeError on a bad file.
    RuntimeError that names solver and case if a function raises, or an answer is wrong.
    Ctrl-C ends the comparison with KeyboardInterrupt once the running registration is done; a folder keeps the runs.
    """
    names, outside = (None, []) if solvers is None else named_solvers(solvers, versions or {})
    run_columns, text_tables = _core.run_comparison(
        None if cases is None else os.fspath(cases),
        _names(synthetic),
        trials,
        points,
        _floats(outliers),
        _floats(sigma),
        _names(tables),
        names,
        outside,
        time_limit,
        filter,
        thresholds,
        None if iterations is None else [int(count) for count in iterations],
        iteration_problems,
        _floats(scales),
        seed,
        seeds,
        threads,
        None if out is None else os.fspath(out),
        fresh,
        progress,
    )
    return CompareResult(structured(run_columns), {name: ComparisonTable(*table) for name, *table in text_tables})
