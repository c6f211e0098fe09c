"""consimd.features and consimd.register_clouds."""

import json

import numpy as np
import pytest

import consimd
from consimd import features


def room(seed, count=20000):
    """Points on the floor, two walls and boxes of a room; no two corners are alike."""
    draw = np.random.default_rng(seed)
    boxes = np.random.default_rng(1)
    corners = np.c_[boxes.uniform(-4, 4, (12, 2)), np.zeros(12)]
    sizes = boxes.uniform((0.3, 0.3, 0.5), (1.2, 1.2, 2), (12, 3))
    u, v = draw.random((2, count, 1))
    zero, one = np.zeros_like(u), np.ones_like(u)
    box = draw.integers(12, size=count)
    sides = np.stack([np.c_[one, u, v], np.c_[v, one, u], np.c_[u, v, one]])[draw.integers(3, size=count), np.arange(count)]
    kinds = np.stack([np.c_[10 * u - 5, 10 * v - 5, zero], np.c_[5 * one, 10 * u - 5, 3 * v], np.c_[4 * u - 4, 5 * one, 3 * v],
                      corners[box] + sizes[box] * sides, corners[box] + sizes[box] * sides])  # fmt: skip
    return kinds[draw.integers(5, size=count), np.arange(count)] + draw.uniform(-0.01, 0.01, (count, 3))


POSE = np.array([[np.cos(0.3), -np.sin(0.3), 0, 1], [np.sin(0.3), np.cos(0.3), 0, -0.5], [0, 0, 1, 0], [0, 0, 0, 1]])


@pytest.fixture(scope="module")
def scans():
    return room(1), room(2) @ POSE[:3, :3].T + POSE[:3, 3]


def test_register_clouds_finds_the_pose(scans):
    registration, matches = consimd.register_clouds(*scans)
    assert registration.status == "success"
    np.testing.assert_allclose(registration.pose, POSE, atol=0.05)
    assert registration.noise_bound == matches.noise_bound == 3 * (matches.source.resolution + matches.target.resolution) / 2
    assert matches.source_points.shape == matches.target_points.shape == (registration.correspondences, 3)
    assert [stage.name for stage in matches.stages] == ["choose_voxel", "voxel_grid", "normals", "fpfh", "matches"]


def test_register_clouds_is_that_of_the_command(scans, command, tmp_path):
    for name, points in zip(("a.npy", "b.npy"), scans):
        np.save(tmp_path / name, points)
    said = json.loads(command("register", tmp_path / "a.npy", tmp_path / "b.npy", "--voxel", 0.15, "--json", "-"))
    registration, matches = consimd.register_clouds(*scans, voxel=0.15, threads=1)
    assert registration.pose.tolist() == said["runs"][0]["T_target_source"]
    assert matches.noise_bound == said["noise_bound"]
    assert len(matches.distances) == said["correspondences"]
    evidence, verdict = registration.verdict.pose, said["runs"][0]["verification"]
    assert registration.verdict.of_correspondences == verdict["of_correspondences"] == "success"
    assert evidence.log10_chance == verdict["pose"]["log10_chance"] and evidence.agreement == verdict["pose"]["agreement"]
    assert (evidence.scale, evidence.gain_by_scale) == (verdict["pose"]["scale"], verdict["pose"]["gain_by_scale"])
    rival, other = evidence.rival, verdict["pose"]["rival"]
    assert (rival is None) == (other is None)
    if rival is not None:
        other["pose"] = other.pop("T_target_source")
        assert rival._replace(pose=rival.pose.tolist())._asdict() == other
    assert registration.attempts == said["runs"][0]["attempts"]
    alone = consimd.register_clouds(*scans, voxel=0.15, verify=False)
    assert alone.registration.verdict is None and alone.registration.stages[-1].name != "verification"


def test_clouds_refuse_what_is_no_pose():
    draw = np.random.default_rng(3)
    registration, _ = consimd.register_clouds(draw.uniform(-5, 5, (3000, 3)), draw.uniform(-5, 5, (3000, 3)))
    assert registration.pose is None and registration.attempts == 4


def test_refined_registration_is_that_of_the_command(scans, command, tmp_path):
    for name, points in zip(("a.npy", "b.npy"), scans):
        np.save(tmp_path / name, points)
    said = json.loads(command("register", tmp_path / "a.npy", tmp_path / "b.npy", "--voxel", 0.15, "--refine", "plane", "--json", "-"))
    registration, matches = consimd.register_clouds(*scans, voxel=0.15, refine="plane")
    refinement = registration.refinement
    plain = consimd.register_clouds(*scans, voxel=0.15)
    assert plain.registration.refinement is None
    assert registration.pose.tolist() == said["runs"][0]["T_target_source"]
    assert registration.covariance.tolist() == said["runs"][0]["covariance"]
    assert refinement.status == said["runs"][0]["refinement"]["status"] == "converged"
    assert registration.inliers.tolist() == plain.registration.inliers.tolist()
    assert registration.stages[-1].name == "refine" and registration.stages[-1].output == refinement.pairs
    np.testing.assert_allclose(registration.pose, POSE, atol=0.005)
    # Without attempts at coarser voxels, whose poses are refined, it is that of the correspondences.
    rough, _ = consimd.register_clouds(*scans, voxel=0.15, verify=False)
    assert np.abs(registration.pose - POSE).max() < np.abs(rough.pose - POSE).max()


@pytest.mark.parametrize("method", ["point", "plane", "gicp"])
def test_refine_comes_near_the_truth(scans, method):
    start = POSE.copy()
    start[:3, 3] += 0.05
    refined = features.refine(*scans, start, method, voxel=0.15, max_distance=0.3)
    assert refined.has_pose and refined.status == "converged"
    np.testing.assert_allclose(refined.pose, POSE, atol=0.02 if method == "point" else 0.005)
    assert refined.covariance.shape == (6, 6) and refined.max_distance == 0.3
    assert 0 < refined.inlier_share <= 1 and refined.pairs > 1000
    assert features.refine(*scans, start, method, voxel=0.15, max_distance=0.3, threads=1).pose.tolist() == refined.pose.tolist()


def test_refinement_without_overlap_has_a_status(scans):
    away = np.eye(4)
    away[0, 3] = 1000
    refined = features.refine(*scans, away)
    assert refined.status == "too_few_pairs" and not refined.has_pose
    assert features.refine(np.zeros((0, 3)), scans[1], np.eye(4)).status == "too_few_pairs"
    with pytest.raises(ValueError, match="expected one of point, plane, gicp"):
        features.refine(*scans, away, "icp")


def test_nearest_neighbours_are_the_nearest():
    draw = np.random.default_rng(3)
    points, queries = draw.random((500, 3)), draw.random((60, 3)) * 1.4 - 0.2
    points[7] = np.nan
    rows, distances = features.nearest_neighbours(points, queries, 5, radius=0.2)
    every = np.linalg.norm(points[None] - queries[:, None], axis=2)
    for query in range(60):
        near = [row for row in np.argsort(every[query]) if every[query, row] <= 0.2][:5]
        assert rows[query].tolist() == near + [-1] * (5 - len(near))
        np.testing.assert_allclose(distances[query, : len(near)], every[query, near], atol=1e-6)
        assert np.isinf(distances[query, len(near) :]).all()


def test_the_stages_are_those_of_the_call(scans):
    voxels = [features.voxel_grid(scan, 0.3) for scan in scans]
    (source, source_rows), (target, target_rows) = (features.fpfh(v, 1.5, normal_radius=0.6) for v in voxels)
    pairs, distances = features.match(source, target)
    whole = features.match_clouds(*scans, voxel=0.3, keypoints=None)
    assert len(voxels[0]) == whole.source.voxels
    found = {(*a, *b) for a, b in zip(voxels[0][source_rows[pairs[:, 0]]].round(4), voxels[1][target_rows[pairs[:, 1]]].round(4))}
    expected = {(*a, *b) for a, b in zip(whole.source_points.round(4), whole.target_points.round(4))}
    assert len(found & expected) > 0.98 * len(expected)  # the frame of the voxels is another one, which rounds elsewhere
    assert len(distances) == len(pairs)
    few, rows = features.fpfh(voxels[0], 1.5, normal_radius=0.6, rows=source_rows[5:8])
    assert rows.tolist() == source_rows[5:8].tolist()
    assert np.array_equal(few, source[5:8])


def test_iss_keypoints_are_those_of_the_call(scans):
    whole = features.match_clouds(*scans, voxel=0.15, keypoints=None, iss=True)
    voxels = features.voxel_grid(scans[0], 0.15)
    rows = features.iss_keypoints(voxels, 0.45, 0.3)
    assert rows.dtype == np.int64 and (np.diff(rows) > 0).all()
    # The frame of the voxels is another one, which rounds elsewhere.
    assert abs(len(rows) - whole.source.descriptors) <= 0.02 * len(rows)
    few = features.iss_keypoints(voxels, 0.45, 0.3, fewest_neighbours=20)
    assert 0 < len(few) < len(rows)
    padded = np.insert(voxels, [0, 5, 5], np.nan, axis=0)
    np.testing.assert_array_equal(padded[features.iss_keypoints(padded, 0.45, 0.3)], voxels[rows])
    assert [stage.name for stage in whole.stages] == ["voxel_grid", "normals", "iss", "fpfh", "matches"]
    with pytest.raises(ValueError, match="second_to_first is 2"):
        features.iss_keypoints(voxels, 0.45, 0.3, second_to_first=2)


def test_normals_keep_the_rows_of_the_input():
    points = np.array([[x, y, 0.0] for x in range(5) for y in range(5)], dtype=np.float32)
    points[7] = np.nan
    normals = features.normals(points, 1.5, viewpoint=(0, 0, -3))
    assert np.isnan(normals[7]).all()
    np.testing.assert_allclose(np.delete(normals, 7, axis=0), np.tile([0, 0, -1], (24, 1)), atol=1e-6)


def test_farthest_subset_spreads():
    points = np.r_[np.random.default_rng(1).random((5000, 3)) * 0.1, [[0, 0, 9], [np.nan, 0, 0], [0, 9, 0], [9, 0, 0]]]
    rows = features.farthest_subset(points, 4)
    assert set(rows[1:]) == {5000, 5002, 5003} and rows[0] < 5000
    assert features.farthest_subset(points, 4, seed=2)[0] != rows[0]
    assert len(features.farthest_subset(points, 10**6)) == 5003
    with pytest.raises(ValueError, match="threads"):
        features.farthest_subset(points, 4, threads=0)


def test_stray_points_change_nothing(scans):
    expected = consimd.register_clouds(*scans)
    found = consimd.register_clouds(np.r_[[[1e7, 0, 0]], scans[0]], scans[1])
    np.testing.assert_array_equal(found.registration.pose, expected.registration.pose)
    assert found.matches.source.left_out == 1


def test_bad_input_is_named(scans):
    with pytest.raises(ValueError, match="the source cloud is empty"):
        consimd.register_clouds(np.zeros((0, 3)), scans[1])
    with pytest.raises(ValueError, match="voxel is 500"):
        consimd.register_clouds(*scans, voxel=500)
    with pytest.raises(ValueError, match="radius is -1.0"):
        features.normals(scans[0], -1)
    with pytest.raises(ValueError, match="best is 9"):
        features.match(np.ones((3, 4)), np.ones((3, 4)), best=9)
    with pytest.raises(ValueError, match="different lengths"):
        features.match(np.ones((3, 4)), np.ones((3, 5)))
    with pytest.raises(IndexError, match="row 9 of 4"):
        features.fpfh(np.zeros((4, 3)), 1, normal_radius=1, rows=[9])
