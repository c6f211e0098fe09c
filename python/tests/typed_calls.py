"""Calls as a user's typed code makes them: `./dev python` has mypy check this file."""

from __future__ import annotations

from typing import assert_type

import numpy as np
from numpy.typing import NDArray

import consimd
from consimd import features, kernels, synth

points: NDArray[np.float32] = np.zeros((10, 3), np.float32)
problem = synth.hard_problem(correspondences=50, scene="planar")

result = consimd.register(points, [[0.0, 1.0, 2.0]] * 10, 0.2, solver="ransac", max_iterations=100)
assert_type(result, consimd.Registration)
assert_type(result.status, consimd.Status)
assert_type(result.pose, NDArray[np.float64] | None)
assert_type(result.inliers, NDArray[np.int64])
assert_type(result.edge_information("g2o"), NDArray[np.float64])
assert_type(result.stages[0].seconds, float)
if result.runner_up is not None:
    assert_type(result.runner_up.support, int)
    assert_type(result.runner_up.scale, float)

rows = consimd.Correspondences(points, problem.target)
assert_type(consimd.register(rows, noise_bound=1.0).has_pose, bool)
assert_type(consimd.estimate_noise_bound(rows).noise_bound, float)
assert_type(kernels.unpack_bits(kernels.pack_bits([True]), 1), NDArray[np.bool_])
bits, counts = kernels.length_consistency_bits(rows, [1, 2], 0.5)
total: NDArray[np.uint32] = counts
matrix = kernels.ConsistencyMatrix(rows, 0.5, separation=1.0)
degrees: NDArray[np.uint32] = matrix.degrees
if result.pose is not None:
    assert_type(synth.rotation_error_deg(result.pose, problem.pose), float)
assert_type(synth.scale_error(result.scale, 1.0), float)
costs: NDArray[np.float32] = kernels.length_disagreement(rows, [1, 2], 0.5, ratio_bound=0.1)
lows, highs = kernels.scale_intervals(rows, 0, 0.5)
ratios: NDArray[np.float32] = highs / lows
kernels.ConsistencyMatrix(rows, 0.5, ratio_bound=0.1)
assert_type(consimd.describe_options("ransac")["confidence"].meaning, str)

registration, matches = consimd.register_clouds(points, points, 0.1, solver="ransac", keypoints=None, missing=0)
assert_type(registration, consimd.Registration)
consimd.view("view.html", registration, points, points, matches, names=("a", "b"))
assert_type(matches, features.CloudMatches)
assert_type(matches.source.voxels, int)
assert_type(features.normals(features.voxel_grid(points, 1), 2.0), NDArray[np.float32])
assert_type(features.farthest_subset(points, 10, seed=2, threads=1), NDArray[np.int64])
descriptors, described = features.fpfh(points, 2.0, normal_radius=1.0, rows=[1, 2], viewpoint=None)
assert_type(features.match(descriptors, descriptors, ratio=0.9)[0], NDArray[np.int64])

trials, cells, *_ = consimd.sweep(points=100, outliers=[0.5], sigma=[1.0], trials=2, progress=lambda done, total: None)
recalls: NDArray[np.float64] = cells["recall"]
consimd.sweep(solvers={"mine": lambda p, q, bound, seed: None, "yours": "exec:./solver", "tcf": None}, time_limit=2)
runs, tables, *_ = consimd.compare(synthetic="facade", trials=1, solvers=["tcf"], scales=[1, 2.0], out="folder")
assert_type(tables["solvers"].rows, list[list[str]])
assert_type(consimd.compare(synthetic="facade", trials=1).pairs, NDArray[np.void])
assert_type(consimd.table_columns()["runs"]["seed"], str)

consimd.register(points)  # type: ignore[call-overload]  # no target
consimd.register(points, points, noise_bound="0.2")  # type: ignore[call-overload]
consimd.compare(scans="folder", layout="kitti", sequences=["00"], front_end={"voxel": 0.3}, overlap=(0.1, 0.3))
consimd.compare(scans="folder", layout="moon")  # type: ignore[arg-type]
consimd.compare(trials="1")  # type: ignore[arg-type]
features.fpfh(points, 2.0)  # type: ignore[call-arg]  # no normal_radius
kernels.alignment_counts(points, points, 1.0)  # type: ignore[arg-type]  # not a Correspondences
