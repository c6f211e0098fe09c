"""Comparisons of solvers."""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from consimd import _core
from consimd._outside import named_solvers
from consimd._report import call_text
from consimd._tables import structured
from consimd.features import match_clouds

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
    pairs: NDArray[np.void]
    """Of several methods on the same cases, as the command's pairs.csv: a row per pair and group, with McNemar's p-values
    and paired intervals, then one of all groups together. No rows of one method."""
    solvers: NDArray[np.void]
    """Quantiles of errors with failures counted, efficiency, and time to reach a recall, likewise, as its solvers.csv."""
    curves: NDArray[np.void]
    """Recall over the limit of success, as its curves.csv."""


def _names(names: str | Sequence[str]) -> list[str]:
    return [names] if isinstance(names, str) else list(names)


def _floats(values: Iterable[float] | None) -> list[float] | None:
    return None if values is None else [float(value) for value in values]


def _front_end(options: Mapping[str, Any]) -> dict[str, Any]:
    """Those of `features.match_clouds` that were given; TypeError on a name that it does not have."""
    for name in ("source", "target", "seed", "threads"):
        if name in options:
            raise TypeError(f"front_end: {name} is no option of it")
    inspect.signature(match_clouds).bind_partial(**options)
    return dict(options)


def compare(
    cases: str | os.PathLike[str] | None = None,
    synthetic: str | Sequence[str] = (),
    *,
    scans: str | os.PathLike[str] | None = None,
    layout: Literal["kitti", "eth", "3dmatch", "pairs"] | None = None,
    sequences: str | Sequence[str] = (),
    pairs: int | None = None,
    distance: float = 17.0,
    pair_list: str | os.PathLike[str] | None = None,
    ground_truth: str | os.PathLike[str] | None = None,
    overlap: tuple[float, float] | None = None,
    skip_consecutive: bool = False,
    front_end: Mapping[str, Any] | None = None,
    noise_bound: float | None = None,
    tables: str | Sequence[str] = ("solvers", "pairs", "quantiles"),
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
    report: str | os.PathLike[str] | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> CompareResult:
    """Runs solvers on the same problems with the same seeds and makes the tables of the TCF paper's evaluation.

    cases: a folder whose sub-folders hold correspondences.txt, pose.txt and case.json.
    synthetic: names of stand-ins (see `consimd.synth.stand_ins()`), "stand-ins" (all of them), "eth", "kitti", or
        "noise", cells of the noise study. Nothing: all stand-ins, unless there are cases or scans.
    scans, layout: the folder of a data set of scans with poses, and how it lies there: "kitti", "eth", "3dmatch", "pairs",
        as the command's help describes them. Every scan is read before anything runs.
    sequences, pairs: of scans: which sequences, scenes or groups (nothing: all), and the most pairs of each, drawn by the
        seed; None: 200 of KITTI, all of the others.
    distance, pair_list: of "kitti": metres between the scans of a pair that is drawn, or a file of pairs.
    ground_truth, overlap, skip_consecutive: of "3dmatch": another folder with SCENE/gt.log; only pairs whose overlap in
        gt_overlap.log is above the first and at most the second share; no fragments that follow one another.
    front_end: of scans: options of `features.match_clouds` by name, but for seed and threads, in place of those that the
        users of the data set take.
    noise_bound: of all pairs of scans; None: three times a pair's resolution.
    tables: "data", "solvers", "pairs", "quantiles", "pipeline" (of scans), "boost", "stages", "poses", "iterations", "scales".
    solvers, versions, time_limit: as those of `consimd.sweep`, of the tables; solvers None: all of consimd's.
    filter: "tcf" runs the tables "solvers", "pairs" and "quantiles" after TCF's filter.
    thresholds: limits of a success: "case" (what each case states), "paper", "eth", "kitti", "kitti06", "3dmatch",
        "3dmatch-rmse", or degrees and metres as a text, "5,0.6".
    trials: problems of each stand-in, noise cell, and scale with its noise.
    points, outliers, sigma: of the noise cells; None: 0.1 to 0.99 and 0.1 to 5 m.
    iterations, iteration_problems: samples of plain RANSAC, and the problems, of the table "iterations"; None: 1000 to
        1 000 000.
    scales: of the source, for the table "scales"; None: 0.2 to 5.
    seed: of the data; synthetic problem k starts its solvers with seed + k.
    seeds: runs of a solver on each case, with seeds one after the other.
    threads: as that of `consimd.register`. Runs go one at a time, each on all threads.
    out: a folder that gets runs.csv as runs end, then tables.md, a table_*.csv a table, comparison.json, and of several
        methods pairs.csv, solvers.csv and curves.csv;
        correspondences of scans are kept in it. The same
        call takes up a comparison that was stopped; RuntimeError if the folder holds another one, unless `fresh` drops
        that, or if another process writes to it.
    report: a file that gets a page to look at the comparison in a browser, without network: figures that tell their numbers,
        tables to sort and save, the machine and this call. Before anything is run: ValueError unless it is named
        *.html, RuntimeError if it cannot be written.
    progress: called with the numbers of runs done and of all, some ten times a second.

    The same runs as `consimd compare`, but for the times. ValueError on a bad argument, RuntimeError on a bad file.
    RuntimeError that names solver and case if a function raises, or an answer is wrong.
    Ctrl-C ends the comparison with KeyboardInterrupt once the running registration is done; a folder keeps the runs.
    """
    command = call_text(compare, locals())
    names, outside = (None, []) if solvers is None else named_solvers(solvers, versions or {})
    of_scans: dict[str, Any] = {
        "layout": layout or "",
        "sequences": _names(sequences),
        "pairs": pairs,
        "distance": float(distance),
        "pair_list": "" if pair_list is None else os.fspath(pair_list),
        "ground_truth": "" if ground_truth is None else os.fspath(ground_truth),
        "overlap": None if overlap is None else (float(overlap[0]), float(overlap[1])),
        "skip_consecutive": skip_consecutive,
        "noise_bound": None if noise_bound is None else float(noise_bound),
        "front_end": _front_end(front_end or {}),
    }
    if scans is None:
        defaults = inspect.signature(compare).parameters
        own = {**of_scans, "layout": layout, "sequences": sequences, "pair_list": pair_list, "ground_truth": ground_truth}
        own["front_end"] = front_end
        for name, value in own.items():
            if value != defaults[name].default:
                raise ValueError(f"{name}: it is for scans, which are not given")
    run_columns, text_tables, compared = _core.run_comparison(
        None if cases is None else os.fspath(cases),
        _names(synthetic),
        None if scans is None else {"folder": os.fspath(scans), **of_scans},
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
        None if report is None else os.fspath(report),
        command,
        progress,
    )
    named_tables = {name: ComparisonTable(*table) for name, *table in text_tables}
    return CompareResult(structured(run_columns), named_tables, *map(structured, compared))
