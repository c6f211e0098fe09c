"""From two clouds of points to correspondences: the front end of the TCF paper, and its stages one by one.

Clouds are (N, 3) arrays, float32 and float64 ones read as they are. Rows with NaN or infinity are no points, nor are
those whose three coordinates are `missing`, as depth cameras write it, nor a tenth of them or fewer that are more than 1024
times as far from the middle as the median point. Lengths are in the unit of the points. A
viewpoint is where a scan was taken from, in its own frame; normals point towards it; None: they point up. Results have
the same bits on any number of threads and any instruction set. threads: at most so many; None: all that the process may
use. Ctrl-C raises KeyboardInterrupt at once.

    m = match_clouds(source, target, voxel=0.3)
    result = consimd.register(m.source_points, m.target_points, noise_bound=m.noise_bound)
"""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from consimd import _core
from consimd._register import Stage, Status

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

__all__ = [
    "CloudMatches",
    "CloudSummary",
    "CloudVerdict",
    "PoseEvidence",
    "Refinement",
    "RefinementStatus",
    "RivalPose",
    "farthest_subset",
    "fpfh",
    "iss_keypoints",
    "match",
    "match_clouds",
    "nearest_neighbours",
    "normals",
    "refine",
    "voxel_grid",
]

Viewpoint = tuple[float, float, float]
_ORIGIN = (0.0, 0.0, 0.0)


class CloudSummary(NamedTuple):
    """What became of one cloud."""

    points: int
    left_out: int
    """Rows that are no points."""
    voxels: int
    descriptors: int
    resolution: float
    """Median distance of a voxel to its nearest neighbour."""


@dataclass(frozen=True, eq=False)
class CloudMatches:
    """What `match_clouds` found. Row k of `source_points` may be the same point as row k of `target_points`."""

    source_points: NDArray[np.float64]
    """(K, 3)."""
    target_points: NDArray[np.float64]
    """(K, 3)."""
    distances: NDArray[np.float32]
    """(K,), between the descriptors."""
    source: CloudSummary
    target: CloudSummary
    voxel: float
    """What was used: given, or chosen."""
    noise_bound: float
    """For `register`: three times the mean resolution of the two clouds."""
    hint: str
    """A sentence on what looks like a mistake, such as different units; empty as a rule."""
    stages: tuple[Stage, ...]


class RefinementStatus(str, enum.Enum):
    """Why a refinement stopped. Members are strings: `refined.status == "converged"`."""

    CONVERGED = "converged"
    """The last step was too small to matter."""
    ITERATION_LIMIT = "iteration_limit"
    """Steps were still larger after `max_iterations`."""
    DEGENERATE_GEOMETRY = "degenerate_geometry"
    """The pairs leave a motion free: one plane, a cylinder, a line."""
    TOO_FEW_PAIRS = "too_few_pairs"
    """Fewer than six source points have a target point within `max_distance`: no overlap."""

    __str__ = str.__str__
    __format__ = str.__format__


@dataclass(frozen=True, eq=False)
class Refinement:
    """What `refine` found."""

    status: RefinementStatus
    pose: NDArray[np.float64]
    """(4, 4), T_target_source; along directions that degenerate pairs leave free as it was at the start."""
    covariance: NDArray[np.float64]
    """(6, 6), as that of `Registration`. Zero unless converged."""
    iterations: int
    pairs: int
    """Source voxels with a target voxel within `max_distance`, at the end."""
    inlier_share: float
    """Of the source's voxels."""
    rmse: float
    """Root mean square of the pairs' distances: to planes with "plane", else between points."""
    residual_scale: float
    """Robust deviation of what is made small."""
    shared_errors: float
    """By how much errors shared among neighbours enlarge the covariance."""
    max_distance: float
    """What was used: given, or chosen."""
    seconds: float

    @property
    def has_pose(self) -> bool:
        """Whether `pose` is better than the start: the status is converged."""
        return self.status is RefinementStatus.CONVERGED


class RivalPose(NamedTuple):
    """Another pose at which two clouds agree."""

    pose: NDArray[np.float64]
    """T_target_source, (4, 4)."""
    share_of_score: float
    """Of the pose's score: the samples that agree, each by how rarely it does, less those seen through."""
    share_of_agreement: float
    """The samples that agree at the rival over those that agree at the pose, both fitted to the surfaces."""
    agreement: float
    """As in `PoseEvidence`."""
    seen_through: float
    """As in `PoseEvidence`."""


class PoseEvidence(NamedTuple):
    """How well two clouds agree at a pose. A sample is a surface point of one of them, brought into the other's frame."""

    log10_chance: float
    """log10 of the chance that clouds which have nothing in common but what every displacement keeps agree as well."""
    agreement: float
    """Share of samples that lie on a surface of the other cloud, of like orientation."""
    seen_through: float
    """Share of samples where the other scan saw nothing but what is farther away."""
    samples: int
    """0: a cloud has no surfaces, and nothing is known."""
    displacements: int
    """Poses that the chance comes from."""
    displaced_agreement: float
    """As `agreement`, mean of the displaced poses."""
    displaced_seen_through: float
    """As `seen_through`, mean of the displaced poses."""
    fitted_agreement: float
    """As `agreement`, with the pose fitted to the surfaces near it, where its chance is below 1 in 20; 0 elsewhere."""
    fitted_seen_through: float
    """As `seen_through`, with the pose fitted likewise."""
    scale: float
    """Of the source, at which the clouds agree best near the pose; 1 where it was not looked for."""
    gain_by_scale: float
    """What they agree in at that scale, over what they do at scale 1: 1.1 and more at a scale 0.03 from 1 is another scale."""
    rival: RivalPose | None
    """The best other pose: where a scene repeats itself, or about an axis of symmetry. None where there is none, or the
    pose's own chance is above 1 in 20."""


class CloudVerdict(NamedTuple):
    """What two clouds made of a registration of their correspondences."""

    pose: PoseEvidence | None
    """Of the correspondences' pose, or of the one that they were too few for; None where there is neither."""
    runner_up: PoseEvidence | None
    """Of the runner-up, where there was or is one."""
    log10_of_both: float
    """log10 of the chance of the pose that stands: that of the clouds' agreement times the number of such poses that the
    correspondences give by chance. 0 where none stands."""
    found_by_clouds: bool
    """The pose is none that the correspondences gave, but one that the clouds led to from there."""
    of_correspondences: Status
    """The status that the correspondences alone gave."""


def voxel_grid(
    points: ArrayLike, voxel: float, *, missing: float | None = None, threads: int | None = None
) -> NDArray[np.float64]:
    """The mean of the points in each occupied cube of side `voxel`, (M, 3), by cube."""
    return _core.voxel_grid(points, voxel, missing, threads)


def farthest_subset(
    points: ArrayLike, count: int, *, seed: int = 1, missing: float | None = None, threads: int | None = None
) -> NDArray[np.int64]:
    """Rows of at most `count` points in the order of their choice, (K,): evenly spread, however dense the cloud is.

    The first is drawn by the seed, each of the others is the point whose nearest chosen one is furthest away (Eldar 1997).
    """
    return _core.farthest_subset(points, count, seed, missing, threads)


def normals(
    points: ArrayLike,
    radius: float,
    *,
    viewpoint: Viewpoint | None = _ORIGIN,
    missing: float | None = None,
    threads: int | None = None,
) -> NDArray[np.float32]:
    """Unit normals of the points, (N, 3): the direction in which those within `radius` spread least.

    NaN of rows that are no points, or have fewer than two neighbours.
    """
    return _core.normals(points, radius, viewpoint, missing, threads)


def iss_keypoints(
    points: ArrayLike,
    radius: float,
    suppression_radius: float,
    *,
    second_to_first: float = 0.975,
    third_to_second: float = 0.975,
    fewest_neighbours: int = 5,
    missing: float | None = None,
    threads: int | None = None,
) -> NDArray[np.int64]:
    """Rows of the points, (K,), ascending, that are ISS keypoints (Zhong 2009): most salient within `suppression_radius`.

    The saliency is the smallest eigenvalue of the covariance of the points within `radius`, of which there are at least
    `fewest_neighbours` beside the point. second_to_first, third_to_second: largest ratios of the eigenvalues in
    descending order, above 0, at most 1. Thin the cloud out with `voxel_grid` before: all points weigh the same.
    """
    return _core.iss_keypoints(
        points, radius, suppression_radius, second_to_first, third_to_second, fewest_neighbours, missing, threads
    )


def fpfh(
    points: ArrayLike,
    radius: float,
    *,
    normal_radius: float,
    rows: ArrayLike | None = None,
    viewpoint: Viewpoint | None = _ORIGIN,
    missing: float | None = None,
    threads: int | None = None,
) -> tuple[NDArray[np.float32], NDArray[np.int64]]:
    """FPFH descriptors of neighbourhoods of `radius`, (K, 33), and the rows of `points` that have one, (K,), ascending.

    rows: only of these; None: of all. normal_radius: that of `normals`, at most `radius`. A row without neighbours has no
    descriptor.
    """
    return _core.fpfh(points, radius, normal_radius, rows, viewpoint, missing, threads)


def match(
    source: ArrayLike,
    target: ArrayLike,
    *,
    best: int = 3,
    mutual: bool = True,
    ratio: float = 1.0,
    threads: int | None = None,
) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Matches of descriptors of any length by Euclidean distance: pairs of rows, (K, 2), and distances, (K,).

    best: each descriptor's nearest that are considered, 1 to 8. mutual: keep a pair only where each is among the best of
    the other. ratio: keep a source's matches only where the nearest is nearer than this share of the second's distance.
    """
    import numpy as np

    rows = [np.ascontiguousarray(descriptors, dtype=np.float32) for descriptors in (source, target)]
    return _core.match(rows[0], rows[1], best, mutual, ratio, threads)


def nearest_neighbours(
    points: ArrayLike,
    queries: ArrayLike,
    most: int = 1,
    *,
    radius: float,
    missing: float | None = None,
    threads: int | None = None,
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """The at most `most` (1 to 64) nearest points within `radius` of each query: rows and distances, both (N, most).

    Ascending by distance. Where there are fewer the rest are -1 and infinity. Rows count `points`.
    """
    return _core.nearest_neighbours(points, queries, most, radius, missing, threads)


def refine(
    source: ArrayLike,
    target: ArrayLike,
    pose: ArrayLike,
    method: Literal["point", "plane", "gicp"] = "plane",
    *,
    voxel: float | None = None,
    normal_radius: float = 2.0,
    max_distance: float | None = None,
    max_iterations: int = 50,
    missing: float | None = None,
    threads: int | None = None,
) -> Refinement:
    """Makes a pose, (4, 4), as exact as the clouds allow, by iterative closest points with Cauchy weights.

    method: "point" makes distances between points small, "plane" those to the target's planes, "gicp" those between
    planes (Segal 2009). voxel, normal_radius: as in `match_clouds`. max_distance: points whose nearest one is further away
    are no pair; None: three times the mean resolution of the voxels. The start must bring most of the overlap to within
    about that.

    Never raises for want of a pose: the status says so. ValueError on a bad value.
    """
    return _refinement(
        _core.refine(
            source, target, pose, method, voxel, normal_radius, normal_radius, max_distance, max_iterations, missing, threads
        )
    )


def _refinement(fields: dict[str, Any]) -> Refinement:
    fields["status"] = RefinementStatus(fields["status"])
    return Refinement(**fields)


def match_clouds(
    source: ArrayLike,
    target: ArrayLike,
    voxel: float | None = None,
    *,
    keypoints: int | None = 5000,
    farthest: bool = False,
    iss: bool = False,
    iss_radius: float = 3.0,
    iss_suppression_radius: float = 2.0,
    best: int = 3,
    mutual: bool = True,
    ratio: float = 1.0,
    normal_radius: float = 2.0,
    descriptor_radius: float = 5.0,
    source_viewpoint: Viewpoint | None = _ORIGIN,
    target_viewpoint: Viewpoint | None = _ORIGIN,
    missing: float | None = None,
    seed: int = 1,
    threads: int | None = None,
) -> CloudMatches:
    """Voxel grid, normals, random points, FPFH and matches of two clouds.

    voxel: side of the voxels that both are thinned out with; None: chosen, for about 12 000 of them. keypoints: points of
    each cloud that are described, drawn at random by the seed; None: all. farthest: choose them as far from each other as can
    be (see `farthest_subset`). iss: draw only from the ISS keypoints, whose
    radii are in voxels (see `iss_keypoints`). normal_radius, descriptor_radius: in voxels.
    best, mutual, ratio: as in `match`. ValueError on an empty cloud or a bad value.
    """
    return _matches(_core.match_clouds(**locals()))


def _evidence(fields: dict[str, Any] | None) -> PoseEvidence | None:
    if fields is None:
        return None
    if fields["rival"] is not None:
        fields["rival"] = RivalPose(*fields["rival"])
    return PoseEvidence(**fields)


def _matches(fields: dict[str, Any]) -> CloudMatches:
    for side in ("source", "target"):
        fields[side] = CloudSummary(*fields[side])
    fields["stages"] = tuple(Stage(*stage) for stage in fields["stages"])
    return CloudMatches(**fields)
