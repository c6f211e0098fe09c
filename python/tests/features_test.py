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
