"""Solvers of others in studies: functions and programs under names."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Union

from consimd._register import Registration, Status

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Solvers = Union[str, Sequence[str], Mapping[str, Union[None, str, Callable[..., object]]]]
    Entry = tuple[str, Union[None, Callable[..., object]], str, str]


def named_solvers(solvers: Solvers, versions: Mapping[str, str]) -> tuple[list[str], list[Entry]]:
    """Names of all solvers in order, and what is needed to call those that are not consimd's own."""
    if isinstance(solvers, str):
        solvers = [solvers]
    if not isinstance(solvers, Mapping):
        solvers = dict.fromkeys(_distinct(solvers))
    outside: list[Entry] = []
    for name, solver in solvers.items():
        if callable(solver):
            command = f"python:{getattr(solver, '__module__', '')}.{getattr(solver, '__qualname__', type(solver).__name__)}"
            version = versions.get(name, getattr(solver, "version", ""))
            outside.append((name, _checked(name, solver), command, str(version)))
        elif isinstance(solver, str):
            outside.append((name, None, solver, versions.get(name, "")))
        elif solver is not None:
            raise ValueError(f"solver {name}: expected a function, 'exec:COMMAND' or None, got {type(solver).__name__}")
    for name in versions:
        if name not in {entry[0] for entry in outside}:
            raise ValueError(f"versions: {name!r} is no function or program in solvers")
    return list(solvers), outside


def _distinct(names: Sequence[str]) -> list[str]:
    names = list(names)
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"solver: {name} is given twice")
    return names


def _checked(name: str, function: Callable[..., object]) -> Callable[..., object]:
    """The function with what it returns as the extension takes it, pose, inliers and status, and errors that name it.

    The last argument names the problem.
    """

    def call(source: Any, target: Any, noise_bound: float, seed: int, problem: str) -> object:
        try:
            result = function(source, target, noise_bound, seed)
        except Exception as error:
            raise RuntimeError(f"solver {name} on {problem}: {type(error).__name__}: {error}") from error
        try:
            return taken(result, len(source))
        except (TypeError, ValueError) as error:
            raise RuntimeError(f"solver {name} on {problem}: wrong reply: {error}") from error

    def taken(result: Any, size: int) -> object:
        if result is None:
            return None, None, ""
        if not hasattr(result, "pose"):
            return _pose_rows(result), None, ""
        pose, inliers = result.pose, getattr(result, "inliers", None)
        status = getattr(result, "status", "")
        if isinstance(result, Registration) and not result.has_pose:
            pose = None
        status = status.value if isinstance(status, Status) else str(status or "")
        if pose is None:
            return None, None, status
        return _pose_rows(pose), None if inliers is None else _rows(inliers, size), status

    return call


def _pose_rows(pose: object) -> NDArray[np.float64]:
    import numpy as np

    matrix = np.asarray(pose, dtype=np.float64)
    if matrix.shape not in ((3, 4), (4, 4)):
        raise ValueError(f"expected a 4 x 4 pose, got shape {matrix.shape}")
    if len(matrix) == 4 and not np.allclose(matrix[3], (0, 0, 0, 1), rtol=0, atol=1e-6):
        raise ValueError(f"the last row must be 0 0 0 1, got {matrix[3].tolist()}")
    return np.ascontiguousarray(matrix[:3])


def _rows(inliers: object, size: int) -> list[int]:
    import numpy as np

    rows = np.asarray(inliers)
    if rows.dtype == bool and rows.shape == (size,):
        rows = np.flatnonzero(rows)
    if rows.ndim != 1 or (rows.size and not np.issubdtype(rows.dtype, np.integer)):
        raise ValueError(f"expected inliers as row numbers, got {rows.dtype} of shape {rows.shape}")
    if rows.size and not 0 <= rows.min() <= rows.max() < size:
        raise ValueError(f"inliers from {rows.min()} to {rows.max()} are no rows of {size}")
    return [int(row) for row in rows]
