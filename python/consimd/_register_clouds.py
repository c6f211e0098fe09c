"""Registration of two clouds in one call."""

from __future__ import annotations

import inspect
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from consimd import _core
from consimd._register import Registration, Status, _registration
from consimd.features import CloudMatches, CloudVerdict, _evidence, _matches, _refinement, match_clouds

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
    verify: bool = True,
    refine: Literal["point", "plane", "gicp"] | None = None,
    threads: int | None = None,
    time_limit: float | None = None,
    **options: Any,
) -> CloudRegistration:
    """Finds the rigid motion between two scans, (N, 3) and (M, 3).

    noise_bound, solver, seed, threads, time_limit: as in `register`, the limit being that of the search among the matches;
    None: the noise bound is three times the clouds' resolution.
    verify: lets the clouds decide over the pose of their correspondences: their surfaces must agree better than at
    displaced poses, and neither scan may have seen through what the other has; a pose is ambiguous where the clouds agree
    at another one as well, since a scene repeats itself. Where they leave it in doubt the front end is tried once more
    with coarser voxels, and up to three times where they bear no pose out. A pose of coarser voxels is refined on them.
    refine: refines the pose on the voxels of the clouds, within the noise bound, by a method of `features.refine`. Where
    that converges the registration has the refined pose and its covariance; inliers and status stay as they were. Its
    `refinement` tells how it went, its `verdict` what the clouds said.
    voxel, seed, threads and options: as in `features.match_clouds`.

    Never raises for want of a pose: the status says so. Ctrl-C raises KeyboardInterrupt at once.
    """
    matching = inspect.signature(match_clouds).bind(source, target, voxel, seed=seed, threads=threads, **options)
    matching.apply_defaults()
    fields = _core.register_clouds(
        **matching.arguments,
        noise_bound=noise_bound,
        solver=solver,
        verify=verify,
        refine=refine,
        time_limit=time_limit,
    )
    matches = _matches(fields["matches"])
    verdict = None
    if fields["verdict"] is not None:
        pose, runner_up, log10_of_both, by_clouds, status = fields["verdict"]
        verdict = CloudVerdict(_evidence(pose), _evidence(runner_up), log10_of_both, by_clouds, Status(status))
    refinement = None if fields["refinement"] is None else _refinement(fields["refinement"])
    registration = _registration(
        fields["registration"],
        correspondences=len(matches.source_points),
        solver=solver,
        filter="none",
        refinement=refinement,
        verdict=verdict,
        attempts=fields["attempts"],
    )
    return CloudRegistration(registration, matches)
