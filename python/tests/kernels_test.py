"""The kernels return the bits of the C++ library, on every instruction set."""

import os
import subprocess

import numpy as np
import pytest

import consimd
from consimd import kernels

BOUND = 3.0
SEEDS = 7 * np.arange(40)
PAIRS = np.stack([np.arange(40), 300 - np.arange(40)], axis=1)
TRIPLES = np.stack([np.arange(50), 100 + 3 * np.arange(50), 350 - 2 * np.arange(50)], axis=1)


@pytest.fixture(scope="module")
def cpp(tmp_path_factory):
    """Reads what kernel_results.cpp wrote under a name."""
    program = os.environ.get("CONSIMD_KERNEL_RESULTS")
    if not program:
        pytest.skip("set CONSIMD_KERNEL_RESULTS to that program")
    folder = tmp_path_factory.mktemp("results")
    subprocess.run([program, folder], check=True)
    return lambda name: (folder / name).read_bytes()


@pytest.fixture(scope="module")
def problem():
    return consimd.synth.noise_study_problem(421, outlier_ratio=0.7, seed=3, trial=2)


@pytest.fixture(params=kernels.supported_isas())
def isa(request):
    before = kernels.active_isa()
    kernels.set_active_isa(request.param)
    yield request.param
    kernels.set_active_isa(before)


def flat(moments):
    return np.concatenate(
        [[moments.weight], moments.source, moments.target, moments.cross.ravel(), moments.source_scatter]
        + [[moments.residual]]
    )


def test_same_problem(cpp, problem):
    assert problem.source.tobytes() == cpp("source")
    assert problem.target.tobytes() == cpp("target")
    assert problem.pose.tobytes() == cpp("truth")


def test_same_consistency(cpp, problem, isa):
    c = problem.correspondences()
    for function, hypotheses, bound, name in (
        ("length_consistency", SEEDS, 2 * BOUND, "length"),
        ("angle_consistency", PAIRS, BOUND, "angle"),
    ):
        bits, counts = getattr(kernels, function + "_bits")(c, hypotheses, bound)
        assert bits.tobytes() == cpp(name + "_bits")
        assert counts.tobytes() == cpp(name + "_counts")
        assert np.array_equal(getattr(kernels, function + "_counts")(c, hypotheses, bound), counts)
        assert np.array_equal(kernels.unpack_bits(bits, len(c)).sum(axis=1), counts)


def test_same_length_ratios(cpp, problem, isa):
    c = problem.correspondences()
    assert kernels.length_disagreement(c, SEEDS, 2 * BOUND, 0.1).tobytes() == cpp("length_disagreement")
    lows, highs = kernels.scale_intervals(c, 7, BOUND)
    assert lows.tobytes() == cpp("scale_lows")
    assert highs.tobytes() == cpp("scale_highs")
    assert lows.shape == highs.shape == (len(c),)
    assert np.array_equal(np.flatnonzero(~np.isfinite(highs)), [7])


def test_bad_length_ratios_are_named(problem):
    c = problem.correspondences()
    for bad in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(ValueError, match="bound"):
            kernels.length_disagreement(c, SEEDS, bad, 0.1)
        with pytest.raises(ValueError, match="bound"):
            kernels.scale_intervals(c, 0, bad)
    for bad in (0.0, 1.0, np.nan):
        with pytest.raises(ValueError, match="ratio"):
            kernels.length_disagreement(c, SEEDS, BOUND, bad)
        with pytest.raises(ValueError, match="ratio"):
            kernels.ConsistencyMatrix(c, BOUND, ratio_bound=bad)
    with pytest.raises(IndexError):
        kernels.scale_intervals(c, len(c), BOUND)
    with pytest.raises(IndexError):
        kernels.length_disagreement(c, [len(c)], BOUND, 0.1)
    with pytest.raises(ValueError, match="separation and ratio_bound exclude each other"):
        kernels.ConsistencyMatrix(c, BOUND, separation=1.0, ratio_bound=0.1)


def test_same_matrix(cpp, problem, isa):
    c = problem.correspondences()
    matrix = kernels.ConsistencyMatrix(c, 2 * BOUND)
    assert matrix.bits.tobytes() == cpp("matrix")
    assert matrix.degrees.tobytes() == cpp("degrees")
    assert kernels.ConsistencyMatrix(c, BOUND, separation=20.0).bits.tobytes() == cpp("separated_matrix")
    assert kernels.ConsistencyMatrix(c, BOUND, ratio_bound=0.1).bits.tobytes() == cpp("ratio_matrix")
    values = (np.float32(1) / np.arange(1, len(c) + 1, dtype=np.float32)).astype(np.float32)
    assert kernels.masked_row_sums(matrix, values).tobytes() == cpp("row_sums")
    assert kernels.masked_row_sums(matrix, values, 10, 5).tobytes() == cpp("row_sums")[40:60]
    common = kernels.and_popcount_rows(matrix, matrix.bits[5], SEEDS)
    assert common.tobytes() == cpp("common_neighbours")
    assert common[0] == kernels.and_popcount(matrix.bits[5], matrix.bits[0])


def test_same_poses(cpp, problem, isa):
    c = problem.correspondences()
    poses = kernels.three_point_fits(c, TRIPLES)
    assert poses.tobytes() == cpp("three_point_fits")
    truth = kernels.to_working_pose(kernels.to_working_frame(problem.pose, c))
    poses = np.concatenate([poses, truth[None]])
    counts, scores = kernels.alignment_scores(c, poses, BOUND)
    assert counts.tobytes() == cpp("alignment_counts")
    assert scores.tobytes() == cpp("alignment_scores")
    bits, counts_too = kernels.alignment_bits(c, poses, BOUND)
    assert bits.tobytes() == cpp("alignment_bits")
    assert np.array_equal(counts, counts_too)
    assert np.array_equal(counts, kernels.alignment_counts(c, poses, BOUND))
    assert kernels.alignment_residuals(c, truth).tobytes() == cpp("residuals")
    assert kernels.mismatched_counts(c, truth, 50.0, [1, 2, 3]).tobytes() == cpp("mismatched")
    assert [kernels.mismatched_pairs(c, shift) for shift in (1, 7)] == [421 - 64, 0]


def test_same_fits(cpp, problem, isa):
    c = problem.correspondences()
    truth = kernels.to_working_pose(kernels.to_working_frame(problem.pose, c))
    moments = kernels.robust_moments(c, truth, "cauchy", scale=1.0, cutoff=BOUND)
    assert flat(moments).tobytes() == cpp("robust_moments")
    bits = kernels.alignment_bits(c, truth[None], BOUND)[0][0]
    assert flat(kernels.subset_moments(c, bits)).tobytes() == cpp("subset_moments")
    mask = kernels.unpack_bits(bits, len(c))
    assert flat(kernels.weighted_moments(c, mask)).tobytes() == cpp("subset_moments")
    fit = kernels.rigid_fit(moments)
    assert fit.determined
    assert kernels.to_caller_frame(fit.pose, c).tobytes() == cpp("fit")


def test_a_fit_to_the_true_inliers_is_near_the_truth(problem):
    c = problem.correspondences()
    fit = kernels.rigid_fit(kernels.weighted_moments(c, problem.is_inlier))
    assert (np.diff(fit.singular_values) <= 0).all()
    pose = kernels.to_caller_frame(fit.pose, c)
    assert consimd.synth.rotation_error_deg(pose, consimd.synth.oracle(problem)) < 1e-4
    again = kernels.from_working_pose(kernels.to_working_pose(kernels.to_working_frame(pose, c)))
    assert np.allclose(kernels.to_caller_frame(again, c), pose, atol=1e-4)


def test_undetermined_fits_say_so():
    line = np.outer(np.arange(9.0), [1, 2, 3])
    c = consimd.Correspondences(line, line)
    assert not kernels.rigid_fit(kernels.weighted_moments(c, np.ones(9))).determined
    assert np.isnan(kernels.three_point_fits(c, [[0, 1, 2]])).all()


def test_a_subset_stays_in_its_frame(problem):
    c = problem.correspondences()
    rows = [5, 3, 300]
    subset = c.subset(rows)
    assert np.array_equal(subset.source, c.source[rows])
    assert np.array_equal(subset.target, c.target[rows])
    assert subset.scale == c.scale
    with pytest.raises(IndexError):
        c.subset([421])


def test_bad_arguments_are_the_librarys_errors(problem):
    c = problem.correspondences()
    matrix = kernels.ConsistencyMatrix(c, BOUND)
    for bound in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(ValueError, match="expected a finite length above 0"):
            kernels.length_consistency_counts(c, SEEDS, bound)
    with pytest.raises(ValueError, match="function is 'huber', expected one of: truncated, cauchy, student_uniform"):
        kernels.robust_moments(c, np.eye(4)[:3], "huber")
    with pytest.raises(ValueError, match=r"weights has shape \(3,\), expected \(421,\)"):
        kernels.weighted_moments(c, np.ones(3))
    with pytest.raises(IndexError, match="421"):
        kernels.masked_row_sums(matrix, np.ones(421), 400, 22)
    with pytest.raises(IndexError, match="rows holds 421"):
        kernels.and_popcount_rows(matrix, matrix.bits[0], [421])


def test_instruction_sets_have_names():
    assert kernels.supported_isas()[0] == "scalar"
    assert kernels.active_isa() in kernels.supported_isas()
    assert set(kernels.supported_isas()) <= set(kernels.known_isas())
    with pytest.raises(ValueError, match="mmx.*" + ".*".join(kernels.supported_isas())):
        kernels.set_active_isa("mmx")
