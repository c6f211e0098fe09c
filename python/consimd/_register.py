"""Registration, and what it returns."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, overload

from consimd import _core
from consimd._core import Correspondences

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from consimd.features import CloudVerdict, Refinement


class Status(str, enum.Enum):
    """Why a solver stopped. Members are strings: `result.status == "success"`."""

    SUCCESS = "success"
    """A pose with significant support."""
    TOO_FEW_CORRESPONDENCES = "too_few_correspondences"
    """Fewer than three."""
    NO_CONSENSUS = "no_consensus"
    """No pose has more support than chance gives."""
    DEGENERATE_GEOMETRY = "degenerate_geometry"
    """The supporters do not determine a pose: they coincide or lie on a line."""
    AMBIGUOUS = "ambiguous"
    """Another motion has about as much support, or the clouds agree at it as well: see `Registration.runner_up`. Of
    solvers that refine nothing also: a pose near theirs has more."""
    BUDGET_EXHAUSTED = "budget_exhausted"
    """The iteration budget ended before the wanted confidence; the best pose so far is given."""

    __str__ = str.__str__
    __format__ = str.__format__


@dataclass(frozen=True)
class Stage:
    """One stage of a solver."""

    name: str
    input: int
    """Correspondences given to the stage."""
    output: int
    """Correspondences it kept."""
    iterations: int
    """Hypotheses drawn, or rounds."""
    seconds: float


@dataclass(frozen=True, eq=False)
class RunnerUp:
    """A pose that is not the one returned."""

    pose: NDArray[np.float64]
    """(4, 4), source to target."""
    support: int
    """Correspondences within the noise bound of it."""
    log10_false_poses: float
    """As in `Registration`."""
    scale: float
    """As in `Registration`."""


@dataclass(frozen=True, eq=False, repr=False)
class Registration:
    """What `register` found. Lengths are in the unit of the points."""

    status: Status
    pose: NDArray[np.float64] | None
    """(4, 4), T_target_source, rigid: takes source points to the target frame, p -> scale * pose[:3, :3] @ p +
    pose[:3, 3]. None unless `has_pose`."""
    scale: float
    """Of the source. 1, unless a solver with estimate_scale=True found it."""
    scale_deviation: float
    """Standard deviation of `scale`; 0 where that was not estimated."""
    inliers: NDArray[np.int64]
    """(K,) positions in the input, from 0, of the rows within `noise_bound` of the pose, ascending: of a DataFrame,
    what `iloc` takes. Empty without a pose."""
    covariance: NDArray[np.float64]
    """(6, 6), of the pose's error: rotation (rad) before translation, along the axes of the target frame,
    R_true = Exp(theta) R. At the origin of the source frame, so lever arms count. Zero without a pose, and from
    `tcf-published` and `teaser` with refine=False, which do not estimate it."""
    log10_false_poses: float
    """log10 of an upper bound on the number of equally supported poses that chance lets expect. Success needs it below
    -3; below -4.5 a quick look may have told it, and `log10_false_poses(...)` tells it closely."""
    runner_up: RunnerUp | None
    refused: RunnerUp | None
    """Without a pose: the most significant one that was met, which chance or structure gives as well; for those who have
    other evidence."""
    stages: tuple[Stage, ...]
    seconds: float
    """Wall time of the registration in the library."""
    correspondences: int
    """Rows of the input."""
    solver: str
    filter: str
    seed: int
    isa: str
    """The instruction set that the kernels ran on."""
    threads: int
    noise_bound: float
    """What was used: given, or estimated; larger than that where it was below what the coordinates resolve. With
    `assume_inliers` the largest residual."""
    noise_bound_asked: float
    """What was given, or estimated."""
    consistency_bound: float
    """Bound on differences of lengths, twice the noise bound."""
    mirrored: bool
    """Whether, without a pose, the rows agree on a mirror image, which no motion brings into place; with
    `assume_inliers` whether one leaves less than a tenth of the residuals' deviation."""
    stopped: bool
    """Whether the time limit ended the search: a pose is the best until then, and none may yet have been found."""
    residuals: NDArray[np.float64] | None = None
    """(N,), of each row under the pose. With `assume_inliers` only."""
    sigma: float | None = None
    """Standard deviation of a residual per axis, with 3 N - 6 degrees of freedom. With `assume_inliers` only."""
    geometry: str | None = None
    """"determined"; "contradictory" where no motion fits the rows; "collinear" or "coincident" where the points of a
    cloud leave a rotation free. With `assume_inliers` only."""
    other_scale: float | None = None
    """The scale of the sources with which less than a tenth of the residuals' deviation is left, if there is one. With
    `assume_inliers` only."""
    odd_row: int | None = None
    """The row (`iloc`) without which less than a tenth of the residuals' deviation is left, likely a wrong one, if there
    is one. With `assume_inliers` of five rows or more only."""
    refinement: Refinement | None = None
    """Of `register_clouds`, where it was asked for and there was a pose to start from."""
    verdict: CloudVerdict | None = None
    """Of `register_clouds`, where the clouds were to decide."""
    attempts: int = 1
    """Of `register_clouds`: of the front end; all else is of the one whose pose is least likely by chance, or where none is
    borne out of the first, or of one that shows that the scene repeats itself or that the clouds are of two scales."""

    @property
    def has_pose(self) -> bool:
        """Whether `pose` is an estimate: the status is success, ambiguous or budget_exhausted."""
        return self.status in (Status.SUCCESS, Status.AMBIGUOUS, Status.BUDGET_EXHAUSTED)

    def edge_information(self, library: Literal["gtsam", "g2o", "open3d"]) -> NDArray[np.float64]:
        """(6, 6), the information matrix of a pose graph's edge: the inverse of the covariance of the error that the
        library takes for it, first order in the rotation. The edge leads from the target's pose to the source's and
        measures `pose`; the error is of D = inverse(pose) @ inverse(X_target) @ X_source, on the right side of the
        measurement, so along the axes of the source frame.

        "gtsam": BetweenFactorPose3(target, source, Pose3(pose), noiseModel.Gaussian.Information(...)): Pose3.Logmap(D),
            rotation vector (rad) before translation.
        "g2o": EDGE_SE3:QUAT target source: translation before the vector part of the unit quaternion of D, half the
            rotation vector. The file has its upper triangle, row by row.
        "open3d": PoseGraphEdge(source, target, pose, information): the sine of the rotation before the translation of
            D, as its global optimisation computes it. (Open3D's get_information_matrix_from_point_clouds counts points
            about the target's origin instead.)

        ValueError where `covariance` is not positive definite: there is no pose, it was not estimated, or the sources
        are so far from their origin that lever arms leave no digits.
        """
        if self.pose is None:
            raise ValueError(f"there is no pose, so no edge: the status is {self.status}")
        return _core.edge_information(self.pose, self.covariance, library)

    def __repr__(self) -> str:
        found = (
            f"{len(self.inliers)} of {self.correspondences} correspondences within {self.noise_bound:.4g} of the pose, "
            f"by chance at most 10^{self.log10_false_poses:.1f} such poses"
            if self.has_pose
            else f"no pose for {self.correspondences} correspondences and noise bound {self.noise_bound:.4g}"
        )
        return f"<consimd.Registration: {self.status} by {self.solver}, {found}, {1e3 * self.seconds:.3g} ms>"


class NoiseBoundEstimate(NamedTuple):
    """What `estimate_noise_bound` returns."""

    noise_bound: float
    """Three times the estimated standard deviation of inliers' residuals per axis, in the unit of the points."""
    log10_false_poses: float
    """Of the pose that the estimate rests on; near or above 0 there may be none."""
    bounds_tried: int


@overload
def register(
    source: Correspondences,
    target: None = None,
    noise_bound: float | None = None,
    solver: str = "tcf",
    seed: int = 1,
    *,
    filter: str = "none",
    threads: int | None = None,
    time_limit: float | None = None,
    assume_inliers: bool = False,
    **options: Any,
) -> Registration: ...
@overload
def register(
    source: ArrayLike,
    target: ArrayLike,
    noise_bound: float | None = None,
    solver: str = "tcf",
    seed: int = 1,
    *,
    filter: str = "none",
    threads: int | None = None,
    time_limit: float | None = None,
    assume_inliers: bool = False,
    source_viewpoint: Sequence[float] | None = None,
    **options: Any,
) -> Registration: ...
def register(
    source: ArrayLike | Correspondences,
    target: ArrayLike | None = None,
    noise_bound: float | None = None,
    solver: str = "tcf",
    seed: int = 1,
    *,
    filter: str = "none",
    threads: int | None = None,
    time_limit: float | None = None,
    assume_inliers: bool = False,
    source_viewpoint: Sequence[float] | None = None,
    **options: Any,
) -> Registration:
    """Finds the rigid motion that correspondences agree on, most of which may be wrong.

    source, target: (N, 3), one unit of length; row k of source may be the same point as row k of target. float32 and
        float64 arrays are read in place, whatever their strides. Or `source` is a `Correspondences` and no target is
        given, which saves the preparation where the same rows are registered again.
    noise_bound: largest distance of a true correspondence's target from the moved source, in that unit; about three
        times the noise's standard deviation per axis. None: estimated from the correspondences, which takes some
        milliseconds more, tens of them at times (docs/statistical_model.md, "Noise bound").
    solver: one of `solvers()`, or a solver with options as the command takes it: "ransac:max_iterations=1000".
    seed: of the random samples; the same seed gives the same bits, on any number of threads and any processor.
    filter: "tcf" gives the solver only what the two filters of TCF keep; "none" gives it all.
    threads: at most so many; None: all that the process may use.
    time_limit: seconds after which the search ends; the best pose until then is judged and given, as budget_exhausted,
        and `stopped` tells. Results then depend on the machine. None: no search is ended.
    assume_inliers: takes every row as right, three or more: the least-squares pose with the residual of each row, for
        targets that somebody has checked. Nothing is searched or tested: neither noise bound, solver, filter nor option
        is taken.
    source_viewpoint: (3,), where the source was scanned from, in its own frame; None: at its origin. Matches tend to
        keep the range about the sensor, and poses that this explains are no success; where nearly all rows keep ranges
        far better about another point it takes that. `Correspondences` have theirs.
    options: the solver's own, see `describe_options(solver)`. `estimate_scale=True` of `pcr99`
        and `teaser` finds the scale of the source as well; it needs a noise bound and no filter.

    Never raises for want of a pose: the status says so. ValueError on a bad shape or value, TypeError on an unknown
    option. Other Python threads run meanwhile. Ctrl-C raises KeyboardInterrupt at once and ends the search; what is left
    of the call runs on unseen for some milliseconds. Only `tcf` with a noise bound and up to 20 000 rows, a matter of
    milliseconds itself, is let finish first.
    """
    if isinstance(source, Correspondences):
        if target is not None:
            raise TypeError("register() takes no target beside a Correspondences")
        if source_viewpoint is not None:
            raise TypeError("register() takes no source_viewpoint beside a Correspondences, which has its own")
        rows = source
    elif target is None:
        raise TypeError("register() needs a target, (N, 3)")
    else:
        viewpoint = (0.0, 0.0, 0.0) if source_viewpoint is None else source_viewpoint
        rows = Correspondences(source, target, source_viewpoint=viewpoint)
    import numpy as np

    if assume_inliers:
        if noise_bound is not None or time_limit is not None or filter != "none" or solver != "tcf" or options:
            raise TypeError("register(assume_inliers=True) takes no noise_bound, time_limit, solver, filter or option")
        solver = "least_squares"
        fields = _core.run_assumed_inliers(rows)
        fields["residuals"] = np.frombuffer(fields["residuals"], np.float64)
    else:
        fields = _core.run_solver(rows, solver, noise_bound, seed, filter, threads, time_limit, options)
    return _registration(fields, correspondences=len(rows), solver=solver, filter=filter)


def _registration(fields: dict[str, Any], **known: Any) -> Registration:
    import numpy as np

    if fields["pose"] is not None:
        fields["pose"] = np.frombuffer(fields["pose"], np.float64).reshape(4, 4)
    fields["covariance"] = np.frombuffer(fields["covariance"], np.float64).reshape(6, 6)
    fields["inliers"] = np.frombuffer(fields["inliers"], np.int64)
    fields["status"] = Status(fields["status"])
    fields["stages"] = tuple(Stage(*stage) for stage in fields["stages"])
    for name in ("runner_up", "refused"):
        if fields[name] is not None:
            fields[name] = RunnerUp(*fields[name])
    return Registration(**known, **fields)


def estimate_noise_bound(
    source: ArrayLike | Correspondences, target: ArrayLike | None = None, seed: int = 1, threads: int | None = None
) -> NoiseBoundEstimate:
    """Estimates what `register` is given as the noise bound, as it does itself without one.

    Arguments as those of `register`. Keeps the bound whose best pose is least likely by chance and measures the
    residuals around it.
    """
    if not isinstance(source, Correspondences):
        if target is None:
            raise TypeError("estimate_noise_bound() needs a target, (N, 3)")
        source = Correspondences(source, target)
    return NoiseBoundEstimate(*_core.estimate_noise_bound(source, seed, threads))


def log10_false_poses(
    source: ArrayLike | Correspondences, target: ArrayLike | None = None, *, pose: ArrayLike, noise_bound: float
) -> float:
    """log10 of how many poses with the support of this one chance would give: what a close look tells of any pose.

    source, target: as of `register`. pose: (4, 4), source to target. noise_bound: in the points' unit. Where
    `Registration.log10_false_poses` is an upper bound, which a glance may have told, this is a close look; it takes some
    milliseconds. It knows no scale, and no factor of bounds that were tried. 0 where there are fewer than three rows.
    ValueError on a bad shape or value.
    """
    if not isinstance(source, Correspondences):
        if target is None:
            raise TypeError("log10_false_poses() needs a target, (N, 3)")
        source = Correspondences(source, target)
    elif target is not None:
        raise TypeError("log10_false_poses() takes no target beside a Correspondences")
    return _core.log10_false_poses(source, pose, noise_bound)


def solvers() -> dict[str, str]:
    """Names and one-line descriptions of all solvers, the default first."""
    return _core.solvers()


class OptionDescription(NamedTuple):
    """An option of a solver."""

    default: bool | int | float | str | None
    unit: str
    """Empty where there is none."""
    expected: str
    """The values that it may have, in words."""
    meaning: str


def solver_options(solver: str = "tcf") -> dict[str, Any]:
    """The options that `register` takes for a solver beside its own arguments, with their default values."""
    return {name: option.default for name, option in describe_options(solver).items()}


def describe_options(solver: str = "tcf") -> dict[str, OptionDescription]:
    """The options that `register` takes for a solver beside its own arguments: default, unit, range and meaning."""
    return {name: OptionDescription(*option) for name, option in _core.describe_options(solver).items()}
