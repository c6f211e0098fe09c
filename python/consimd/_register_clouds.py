"""Registration of two clouds in one call."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from consimd._register import Registration, Stage, register
from consimd.features import CloudMatches, _refined, match_clouds

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
    refine: Literal["point", "plane", "gicp"] | None = None,
    threads: int | None = None,
    **options: Any,
) -> CloudRegistration:
    """Finds the rigid motion between two scans, (N, 3) and (M, 3).

    noise_bound, solver, seed, threads: as in `register`; None: the noise bound is three times the clouds' resolution.
    refine: refines the pose on the voxels of the clouds, within the noise bound, by a method of `features.refine`. Where
    that converges the registration has the refined pose and its covariance; inliers and status are those of the
    correspondences. Its `refinement` tells how it went.
    voxel, seed, threads and options: as in `features.match_clouds`.
    """
    matches = match_clouds(source, target, voxel, seed=seed, threads=threads, **options)
    bound = matches.noise_bound if noise_bound is None else noise_bound
    registration = register(matches.source_points, matches.target_points, bound, solver, seed, threads=threads)
    if refine is None or registration.pose is None:
        return CloudRegistration(registration, matches)
    refined = _refined(
        source, target, registration.pose, refine, matches.voxel, options.get("normal_radius", 2.0),
        options.get("descriptor_radius", 5.0), registration.noise_bound, 50, options.get("missing"), threads,
    )  # fmt: skip
    voxels = matches.source.voxels
    changed: dict[str, Any] = {
        "refinement": refined,
        "stages": (*registration.stages, Stage("refine", voxels, refined.pairs, refined.iterations, refined.seconds)),
        "seconds": registration.seconds + refined.seconds,
    }
    if refined.has_pose:
        changed |= {"pose": refined.pose, "covariance": refined.covariance}
    return CloudRegistration(dataclasses.replace(registration, **changed), matches)
