"""Points, indices and bits in whatever form Python has them."""

import numpy as np
import pytest

import consimd
from consimd import kernels


def same_rows(a, b):
    return (
        np.array_equal(a.source, b.source)
        and np.array_equal(a.target, b.target)
        and a.scale == b.scale
        and a.source_centroid == b.source_centroid
    )


def layouts(points):
    """The same numbers in memory of other shapes."""
    wide = np.full((2 * len(points), 5), np.nan)
    wide[::2, 1:4] = points
    record = np.zeros(len(points), dtype=[("intensity", "u1"), ("xyz", "f8", 3)])
    record["xyz"] = points
    read_only = points.copy()
    read_only.flags.writeable = False
    return {
        "fortran": np.asfortranarray(points),
        "strided": wide[::2, 1:4],
        "reversed": points[::-1].copy()[::-1],
        "packed record": record["xyz"],
        "big endian": points.astype(">f8"),
        "read-only": read_only,
        "list": points.tolist(),
        "memoryview": memoryview(points),
    }


@pytest.mark.parametrize("layout", layouts(np.zeros((2, 3))))
def test_any_layout_gives_the_same_rows(problem, layout):
    expected = consimd.Correspondences(problem.source, problem.target)
    source = layouts(np.array(problem.source))[layout]
    assert same_rows(consimd.Correspondences(source, problem.target), expected)


def test_float32_is_read_as_it_is(problem):
    source, target = (np.asarray(points, np.float32) for points in (problem.source, problem.target))
    single = consimd.Correspondences(source, target)
    assert same_rows(single, consimd.Correspondences(source.astype(float), target.astype(float)))
    # One of each: both become float64.
    assert same_rows(single, consimd.Correspondences(source, target.astype(float)))


def test_other_numbers_become_float64():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    expected = consimd.Correspondences(points.astype(float), points.astype(float))
    for dtype in ("i4", "u1", "f2", "i8"):
        assert same_rows(consimd.Correspondences(points.astype(dtype), points), expected)


def test_arrays_are_not_copied_on_the_way_in():
    tracemalloc = pytest.importorskip("tracemalloc")
    points = np.random.default_rng(1).normal(size=(400_000, 3))
    points = points[::2]
    tracemalloc.start()
    consimd.Correspondences(points, points)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < points.nbytes / 100  # NumPy reports its allocations to tracemalloc


@pytest.mark.parametrize(
    ("points", "remedy"),
    [
        (np.zeros((3, 100)), r"source has shape \(3, 100\), expected \(N, 3\), a point a row: pass source.T"),
        (np.zeros((100, 4)), r"shape \(100, 4\).*pass source\[:, :3\]"),
        (np.zeros(300), r"shape \(300,\).*pass source.reshape\(-1, 3\)"),
        (np.zeros((100, 2)), r"shape \(100, 2\), expected \(N, 3\), a point a row$"),
        (np.zeros((1, 100, 3)), r"shape \(1, 100, 3\)"),
        (np.float64(1), r"shape \(\)"),
    ],
)
def test_other_shapes_are_refused_with_a_remedy(points, remedy):
    with pytest.raises(ValueError, match=remedy):
        consimd.register(points, np.zeros((100, 3)), 1.0)


def test_bad_points_are_refused():
    points = np.zeros((4, 3))
    with pytest.raises(ValueError, match="source has 4.*target.*3|4.*3"):
        consimd.Correspondences(points, points[:3])
    with pytest.raises(TypeError, match="target has dtype complex128, expected real numbers"):
        consimd.Correspondences(points, points.astype(complex))
    with pytest.raises(TypeError, match="dtype <U1|dtype object"):
        consimd.Correspondences([["a", "b", "c"]], points[:1])
    bad = points.copy()
    bad[2, 1] = np.nan
    with pytest.raises(ValueError, match="2"):
        consimd.Correspondences(points, bad)


def test_no_points():
    nothing = consimd.Correspondences(np.zeros((0, 3)), np.zeros((0, 3)))
    assert len(nothing) == 0
    assert nothing.source.shape == (0, 3)
    result = consimd.register(nothing, noise_bound=1.0)
    assert result.status == "too_few_correspondences"


def test_views_keep_their_owner_and_cannot_be_written(problem):
    source = consimd.Correspondences(problem.source, problem.target).source
    assert np.isfinite(source).all()
    assert np.abs(source).max() <= 1
    with pytest.raises(ValueError, match="read-only"):
        source[0] = 1


def test_indices(problem):
    c = problem.correspondences()
    expected = kernels.length_consistency_counts(c, [1, 5, 9], 2.0)
    for dtype in ("i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8"):
        rows = np.array([1, 0, 5, 0, 9], dtype)[::2]
        assert np.array_equal(kernels.length_consistency_counts(c, rows, 2.0), expected)
    assert kernels.length_consistency_counts(c, [], 2.0).shape == (0,)
    with pytest.raises(ValueError, match=r"seeds holds -1 \(element 1\)"):
        kernels.length_consistency_counts(c, [3, -1], 2.0)
    with pytest.raises(TypeError, match="seeds has dtype float64, expected whole numbers"):
        kernels.length_consistency_counts(c, [1.5], 2.0)
    with pytest.raises(TypeError, match="flatnonzero"):
        kernels.length_consistency_counts(c, problem.is_inlier, 2.0)
    with pytest.raises(ValueError, match=r"seeds has shape \(1, 2\), expected \(M,\)"):
        kernels.length_consistency_counts(c, [[1, 2]], 2.0)
    with pytest.raises(ValueError, match=r"pairs has shape \(3,\), expected \(M, 2\)"):
        kernels.angle_consistency_counts(c, [1, 2, 3], 2.0)
    with pytest.raises(IndexError, match="1000"):
        kernels.length_consistency_counts(c, [1000], 2.0)


@pytest.mark.parametrize("size", [0, 1, 63, 64, 65, 200])
def test_bits_are_packed_and_unpacked(size):
    mask = np.random.default_rng(size).random((4, size)) < 0.3
    bits = kernels.pack_bits(mask)
    assert bits.shape == (4, -(-size // 64))
    assert bits.dtype == np.uint64
    assert np.array_equal(kernels.unpack_bits(bits, size), mask)
    for row, words in zip(mask, bits):
        assert kernels.popcount(words) == row.sum()
        assert all(row[j] == bool(int(words[j // 64]) >> (j % 64) & 1) for j in range(size))


def test_bad_bits_are_refused():
    with pytest.raises(TypeError, match="uint64"):
        kernels.unpack_bits(np.zeros(2, np.int64), 5)
    with pytest.raises(ValueError, match="at most the 128 bits"):
        kernels.unpack_bits(np.zeros(2, np.uint64), 129)
    with pytest.raises(TypeError, match="bits has dtype int64, expected uint64 words"):
        kernels.popcount(np.zeros(2, np.int64))
    with pytest.raises(ValueError, match=r"b has shape \(3,\), expected \(2,\)"):
        kernels.and_popcount(np.zeros(2, np.uint64), np.zeros(3, np.uint64))


def test_poses_must_be_rigid(problem):
    c = problem.correspondences()
    with pytest.raises(ValueError, match="pose is not a rigid motion"):
        kernels.to_working_frame(2 * np.eye(4), c)
    with pytest.raises(ValueError, match="pose is not a rigid motion"):
        kernels.to_working_frame(np.diag([1.0, 1, -1, 1]), c)
    with pytest.raises(ValueError, match=r"pose has shape \(3, 3\), expected \(4, 4\) or \(3, 4\)"):
        kernels.to_working_frame(np.eye(3), c)
    with pytest.raises(ValueError, match=r"poses has shape \(3, 4\), expected \(H, 3, 4\)"):
        kernels.alignment_counts(c, np.eye(4)[:3], 1.0)
