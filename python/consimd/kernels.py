"""The consensus kernels on NumPy arrays: who agrees with a hypothesis, and which pose a set of rows gives.

They work on `Correspondences`, made once of two (N, 3) arrays. Lengths such as noise bounds are in the caller's unit;
poses are in the working frame of the correspondences, (3, 4) float32 [R | t], and `to_caller_frame` brings a fit back.
Sets of rows are bits in uint64 words, row j at bit j % 64 of word j // 64: `unpack_bits` makes masks of them.

    c = Correspondences(source, target)
    poses = three_point_fits(c, triples)
    counts, scores = alignment_scores(c, poses, noise_bound)
    pose = to_caller_frame(from_working_pose(poses[scores.argmax()]), c)
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from consimd._core import (
    ConsistencyMatrix,
    Correspondences,
    RigidFit,
    RigidMoments,
    active_isa,
    alignment_bits,
    alignment_counts,
    alignment_residuals,
    alignment_scores,
    and_popcount,
    and_popcount_rows,
    angle_consistency_bits,
    angle_consistency_counts,
    from_working_pose,
    known_isas,
    length_consistency_bits,
    length_consistency_counts,
    length_disagreement,
    masked_row_sums,
    mismatched_counts,
    mismatched_pairs,
    popcount,
    rigid_fit,
    robust_moments,
    scale_intervals,
    set_active_isa,
    subset_moments,
    supported_isas,
    three_point_fits,
    to_caller_frame,
    to_working_frame,
    to_working_pose,
    weighted_moments,
)

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

__all__ = [
    "ConsistencyMatrix",
    "Correspondences",
    "RigidFit",
    "RigidMoments",
    "active_isa",
    "alignment_bits",
    "alignment_counts",
    "alignment_residuals",
    "alignment_scores",
    "and_popcount",
    "and_popcount_rows",
    "angle_consistency_bits",
    "angle_consistency_counts",
    "from_working_pose",
    "known_isas",
    "length_consistency_bits",
    "length_consistency_counts",
    "length_disagreement",
    "masked_row_sums",
    "mismatched_counts",
    "mismatched_pairs",
    "pack_bits",
    "popcount",
    "rigid_fit",
    "robust_moments",
    "scale_intervals",
    "set_active_isa",
    "subset_moments",
    "supported_isas",
    "three_point_fits",
    "to_caller_frame",
    "to_working_frame",
    "to_working_pose",
    "unpack_bits",
    "weighted_moments",
]


def unpack_bits(bits: NDArray[np.uint64], size: int) -> NDArray[np.bool_]:
    """Masks of bit sets: (..., words) uint64 to (..., size) bool, size the number of correspondences."""
    import numpy as np

    words = np.ascontiguousarray(bits)
    if words.dtype != np.uint64:
        raise TypeError(f"bits has dtype {words.dtype}, expected uint64")
    if words.ndim == 0 or not 0 <= size <= 64 * words.shape[-1]:
        raise ValueError(f"size is {size}, expected at most the {64 * words.shape[-1] if words.ndim else 0} bits given")
    octets = words.astype("<u8", copy=False).view(np.uint8)
    return np.unpackbits(octets, axis=-1, bitorder="little", count=size).view(np.bool_)


def pack_bits(mask: ArrayLike) -> NDArray[np.uint64]:
    """Bit sets of masks, the inverse of `unpack_bits`: (..., N) truth values to (..., words) uint64."""
    import numpy as np

    values = np.asarray(mask, dtype=np.bool_)
    if values.ndim == 0:
        raise ValueError("mask has no axis, expected (..., N)")
    padding = [(0, 0)] * (values.ndim - 1) + [(0, -values.shape[-1] % 64)]
    octets = np.packbits(np.pad(values, padding), axis=-1, bitorder="little")
    return octets.view("<u8").astype(np.uint64, copy=False)
