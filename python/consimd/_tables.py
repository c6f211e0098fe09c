"""Tables of studies as structured arrays."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from consimd import _core

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_SHORTEST_TEXT = 32


def structured(columns: dict[str, Any]) -> NDArray[np.void]:
    """A structured array of columns by name: arrays, or lists of str."""
    import numpy as np

    fields: list[tuple[str, Any]] = []
    for name, values in columns.items():
        if isinstance(values, list):
            fields.append((name, f"U{max([_SHORTEST_TEXT, *map(len, values)])}"))
        else:
            fields.append((name, values.dtype))
    table = np.empty(len(next(iter(columns.values()))), dtype=fields)
    for name, values in columns.items():
        table[name] = values
    return table


def table_columns() -> dict[str, dict[str, str]]:
    """What the columns of `sweep` (trials, cells, pairs, solvers, curves) and `compare` (runs, and group_pairs,
    group_solvers and group_curves for its pairs, solvers and curves) mean, by table and name, in their order.

    trial_conditions and cell_conditions stand before those of trials and cells where a sweep goes beyond the paper's.
    """
    return {
        "trials": _core.trial_columns(),
        "cells": _core.cell_columns(),
        "trial_conditions": _core.trial_condition_columns(),
        "cell_conditions": _core.cell_condition_columns(),
        "runs": _core.run_columns(),
        "pairs": _core.pair_columns(),
        "solvers": _core.solver_columns(),
        "curves": _core.curve_columns(),
        "group_pairs": _core.group_pair_columns(),
        "group_solvers": _core.group_solver_columns(),
        "group_curves": _core.group_curve_columns(),
    }
