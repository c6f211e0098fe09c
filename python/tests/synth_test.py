"""consimd.synth: the problems of the C++ library, and errors against their truth."""

import numpy as np
import pytest

import consimd
from consimd import synth


def test_same_problem_as_the_command(command, tmp_path):
    command("generate", "--points", 200, "--outliers", 0.75, "--sigma", 0.5, "--seed", 9, "--trial", 4, "--out", tmp_path)
    problem = synth.noise_study_problem(200, 0.75, 0.5, seed=9, trial=4)
    assert np.array_equal(np.loadtxt(tmp_path / "correspondences.txt"), np.hstack([problem.source, problem.target]))
    assert np.array_equal(np.loadtxt(tmp_path / "pose.txt"), problem.pose)
    assert np.array_equal(np.loadtxt(tmp_path / "labels.txt"), problem.is_inlier)
    synth.write_problem(problem, tmp_path / "again")
    for name in ("correspondences.txt", "pose.txt", "labels.txt", "case.json"):
        assert (tmp_path / "again" / name).read_bytes() == (tmp_path / name).read_bytes()


def test_a_problem_is_as_described():
    problem = synth.noise_study_problem(500, outlier_ratio=0.6, sigma=0.2)
    assert len(problem) == 500 and problem.is_inlier.dtype == bool and problem.is_inlier.sum() == 200
    moved = problem.source @ problem.pose[:3, :3].T + problem.pose[:3, 3]
    residuals = np.linalg.norm(moved - problem.target, axis=1)
    assert residuals[problem.is_inlier].max() < 1.5 < np.median(residuals[~problem.is_inlier])
    assert repr(problem) == "<consimd.synth.Problem: 500 correspondences, 200 true>"
    assert synth.noise_study_bound(problem.sigma) == pytest.approx(0.6)


def test_hard_options_do_what_they_say():
    plain = synth.hard_problem(correspondences=300)
    assert np.array_equal(plain.source, synth.hard_problem(correspondences=300).source)
    assert len(synth.hard_problem(correspondences=300, duplicates=50)) == 350
    flat = synth.hard_problem(correspondences=300, scene="planar", thickness=0.0, outlier_ratio=0.0)
    assert np.linalg.svd(flat.source - flat.source.mean(axis=0))[1][2] < 1e-9
    shifted = synth.hard_problem(correspondences=300, source_offset=(1e6, 0, 0), units_per_metre=1000.0)
    assert shifted.source[:, 0].min() > 9e8
    assert not synth.hard_problem(correspondences=300, mirrored=True).is_inlier.any()
    quantised = synth.hard_problem(correspondences=300, quantum=0.5)
    assert np.array_equal(quantised.source % 0.5, np.zeros((300, 3)))
    rings = synth.hard_problem(correspondences=300, scene="rings", parts=5, outliers="alike", outlier_ratio=1, sigma=0)
    assert not rings.is_inlier.any()
    back = (rings.target - rings.decoy_pose[:3, 3]) @ rings.decoy_pose[:3, :3]
    ranges = np.linalg.norm(rings.source, axis=1)
    assert np.allclose(ranges, np.linalg.norm(back, axis=1)) and len(np.unique(ranges.round(6))) == 5
    for options, message in (
        ({"scene": "round"}, "scene is 'round', expected one of: volume, planar, linear, rings, poles, lines, corridor"),
        ({"parts": 0}, "parts = 0: expected 1 to 4294967295"),
        ({"outliers": "many"}, "outliers is 'many'"),
        ({"noise": "pink"}, "noise is 'pink'"),
        ({"outlier_ratio": 1.5}, "outlier_ratio = 1.5"),
    ):
        with pytest.raises(ValueError, match=message):
            synth.hard_problem(**options)
    with pytest.raises(TypeError, match="incompatible function arguments"):
        synth.hard_problem(colour="red")


def test_scale_errors():
    assert synth.scale_error(2.5, 2.0) == pytest.approx(0.25)
    assert synth.scale_error(2.0, 2.0) == 0
    problem = synth.noise_study_problem(200, outlier_ratio=0.5, sigma=0.1)
    rmse = synth.rmse_true_inliers(problem, problem.pose)
    assert rmse == synth.rmse_true_inliers(problem, problem.pose, scale=1.0) < 1
    assert synth.rmse_true_inliers(problem, problem.pose, scale=2.0) > 10


def test_stand_ins():
    names = synth.stand_ins()
    assert list(names)[0] == "arch" and len(names) == 10
    problem = synth.stand_in_problem("arch", seed=2)
    assert 0 < problem.is_inlier.sum() < len(problem)
    with pytest.raises(ValueError, match="'nowhere'"):
        synth.stand_in_problem("nowhere")


def test_metrics(problem):
    turned = problem.pose.copy()
    angle = np.deg2rad(10)
    turned[:3, :3] = problem.pose[:3, :3] @ [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    turned[:3, 3] += [3, 4, 0]
    assert synth.rotation_error_deg(turned, problem.pose) == pytest.approx(10)
    assert synth.translation_error(turned, problem.pose) == pytest.approx(5)
    inliers = np.flatnonzero(problem.is_inlier)
    assert synth.inlier_quality(problem, inliers) == (1, 1)
    outlier = np.flatnonzero(~problem.is_inlier)[:1]
    assert synth.inlier_quality(problem, np.concatenate([inliers[::2], outlier])) == (50 / 51, 0.5)
    assert np.isnan(synth.inlier_quality(problem, [])[0])
    best = synth.oracle(problem)
    assert synth.rmse_true_inliers(problem, best) < synth.rmse_true_inliers(problem, problem.pose)
    with pytest.raises(IndexError):
        synth.inlier_quality(problem, [1000])


def test_a_problem_of_own_data(problem):
    own = synth.Problem(problem.source, problem.target, problem.is_inlier, problem.pose, sigma=problem.sigma)
    assert np.array_equal(own.source, problem.source) and np.array_equal(own.is_inlier, problem.is_inlier)
    assert synth.rmse_true_inliers(own, own.pose) == synth.rmse_true_inliers(problem, problem.pose)
    with pytest.raises(ValueError, match=r"is_inlier has shape \(2,\), expected \(1000,\)"):
        synth.Problem(problem.source, problem.target, [True, False], problem.pose)
    nothing = synth.Problem(problem.source, problem.target, np.zeros(1000, bool), problem.pose)
    assert np.isnan(synth.oracle(nothing)).any()
    assert np.isnan(synth.rotation_error_deg(synth.oracle(nothing), problem.pose))
    assert isinstance(own.correspondences(), consimd.Correspondences)
