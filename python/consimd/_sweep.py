"""The noise study."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, NamedTuple

from consimd import _core
from consimd._outside import named_solvers
from consimd._report import call_text
from consimd._tables import structured

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from consimd._outside import Solvers

def _list(texts: str | Iterable[str]) -> list[str]:
    return [texts] if isinstance(texts, str) else list(texts)


class SweepResult(NamedTuple):
    """Structured arrays with the columns of the command's files, see `table_columns`."""

    trials: NDArray[np.void]
    """One row per solver and problem."""
    cells: NDArray[np.void]
    """One row per solver, outlier ratio and noise level, and each of what else is varied."""
    pairs: NDArray[np.void]
    """Of several solvers on the same problems: a row per pair and cell, with McNemar's p-values and paired intervals, then
    one for all noise levels together, whose sigma is NaN. No rows, as in the next two, of one solver."""
    solvers: NDArray[np.void]
    """Quantiles of errors with failures counted, efficiency, and time to reach a recall, likewise."""
    curves: NDArray[np.void]
    """Recall over the limit of success, of all noise levels together."""


def sweep(
    points: int | Iterable[int] = 3000,
    outliers: Iterable[float] = (0.1, 0.5, 0.9, 0.95, 0.98),
    sigma: Iterable[float] | None = None,
    trials: int = 100,
    solvers: Solvers = ("tcf",),
    seed: int = 1,
    *,
    versions: Mapping[str, str] | None = None,
    time_limit: float = 60.0,
    filter: str = "none",
    family: str | Iterable[str] = "gaussian",
    scale: str | Iterable[str] = "known",
    bound_factor: float | str | Iterable[float | str] = 1.0,
    no_pose: float = 0.0,
    threads: int | None = None,
    out: str | os.PathLike[str] | None = None,
    fresh: bool = False,
    report: str | os.PathLike[str] | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> SweepResult:
    """Runs the noise study: solvers on synthetic problems over outlier ratio and noise.

    points: correspondences of a problem, a number or several.
    outliers: outlier ratios in [0, 1).
    sigma: standard deviations of the inliers' noise, metres an axis. None: 0.1 to 5 in 50 steps, the paper's.
    trials: problems of a cell: of an outlier ratio, a noise level, and each of what follows that has several values.
        The defaults make the paper's study, 25 000 registrations.
    solvers: one name or several, see `consimd.solvers()`; all see the same problems. Options may follow a name, as in
        "ransac:max_iterations=10000:confidence=none", and are part of it then. A mapping adds solvers of others:
        {"mine": f, "yours": "exec:./solver", "tcf": None}. f(source, target, noise_bound, seed) gets (N, 3) float64
        arrays that it cannot write to and returns a 4 x 4 pose, None where there is no pose, or an object with `pose`
        and `inliers`, as `consimd.register` does. It is called from several threads. A program answers problems on its
        standard streams, see docs/outside_solvers.md.
    versions: of functions and programs by name, in place of the attribute `version` of the function and of what the
        program tells. With name and command it says which solver it is: a folder is taken up with the same only.
    time_limit: seconds that a program has for a problem, and to get ready; a slower one is killed, and its trial
        counts as failed.
    seed: of the data; trial k runs its solvers with seed + k.
    filter, threads: as those of `consimd.register`.
    family: families of problems, see `consimd.synth.problem_families()`.
    scale: "known", "unknown" or both. An unknown scale of the source, from 0.5 to 2, is to be found as well.
    bound_factor: noise bounds that solvers are given, over 3 sigma; "estimated": they are given none.
    no_pose: share of the problems that have no true pose, in [0, 1).
        These four, and several numbers of points, go beyond the paper's study: the tables then have further columns.
    out: a folder that gets trials.csv as trials end, then cells.csv, summary.json and, of several solvers, pairs.csv,
        solvers.csv and curves.csv. The same call takes up a study that was stopped; RuntimeError if the folder holds
        another one, unless `fresh` drops that.
    report: a file that gets a page to look at the study in a browser, without network: figures that tell their numbers,
        tables to sort and save, the machine and this call. Before anything is run: ValueError unless it is named
        *.html, RuntimeError if it cannot be written.
    progress: called with the numbers of trials done and of all, some ten times a second.

    A problem has its points in a cube of 200 m; solvers get the noise bound 3 sigma and succeed when the true inliers'
    RMSE under the pose is below it (where a family's noise is not Gaussian: see docs/problem_families.md). The same
    data and results as `consimd sweep`, but for the times. Ctrl-C ends the study with KeyboardInterrupt once the
    running problems are done; a folder keeps what they gave. RuntimeError that names solver and trial if a function
    raises, or an answer is wrong.
    """
    command = call_text(sweep, locals())
    names, outside = named_solvers(solvers, versions or {})
    trial_columns, cell_columns, compared = _core.run_sweep(
        [points] if isinstance(points, int) else list(points),
        [float(ratio) for ratio in outliers],
        None if sigma is None else [float(level) for level in sigma],
        trials,
        names,
        outside,
        time_limit,
        filter,
        seed,
        _list(family),
        _list(scale),
        [str(factor) for factor in ([bound_factor] if isinstance(bound_factor, (str, float, int)) else bound_factor)],
        no_pose,
        threads,
        None if out is None else os.fspath(out),
        fresh,
        None if report is None else os.fspath(report),
        command,
        progress,
    )
    return SweepResult(structured(trial_columns), structured(cell_columns), *map(structured, compared))
