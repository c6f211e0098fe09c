"""Registration of two clouds in one call."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from consimd._register import Registration, register
from consimd.features import CloudMatches, match_clouds

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


class CloudRegistration(NamedTuple):
    """What `register_clouds` returns."""

    registration: Registration
    """Its inliers are rows of the matches."""
    matches: CloudMatches


def register_clouds(
    source: ArrayLike,
    target: ArrayLike,
    voxel: float | None = None,
    noise_bound: float | None = None,
    solver: str = "tcf",
    seed: int = 1,
    *,
    threads: int | None = None,
    **options: Any,
) -> CloudRegistration:
    """Finds the rigid motion between two scans, (N, 3) and (M, 3).

    noise_bound, solver, seed, threads: as in `register`; None: the noise bound is three times the clouds' resolution.
    voxel, seed, threads and options: as in `features.match_clouds`.
    """
    matches = match_clouds(source, target, voxel, seed=seed, threads=threads, **options)
    bound = matches.noise_bound if noise_bound is None else noise_bound
    return CloudRegistration(
        register(matches.source_points, matches.target_points, bound, solver, seed, threads=threads), matches
    )
