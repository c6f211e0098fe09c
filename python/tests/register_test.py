"""consimd.register: the results of the C++ command, errors, options."""

import json
import pickle
import re

import numpy as np
import pytest

import consimd


BAD_VALUES = [  # solver, option, expected, bad values of its type, and of others
    ("ransac", "max_iterations", "a whole number from 1 to 4294967295", [0, -1, 2**32, 2**70], ["7", 1.5, None, True, [1]]),
    ("sc2_pcr", "first_set", "a whole number from 3 to 64", [0, 2, 65], ["", np.nan]),
    ("tcf", "confidence", "a number above 0 and below 1", [0.0, 1.0, 1, -1, np.nan, np.inf], ["high", "", None, True]),
    ("ransac", "confidence", "a number above 0 and below 1, or none", [0.0, 1.0, np.nan], ["none", False]),
    ("ransac", "length_tolerance", "a number above 0, or inf", [0.0, -1.0, np.nan], ["inf", 1j]),
    ("teaser", "refine", "true or false", [], [0, 1, "true", "", None, np.nan]),
    ("sc2_pcr", "ranking", "one of: inlier_count, truncated_score", ["best", "", "Inlier_count"], [0, None, True]),
]


def save(path, source, target):
    np.savetxt(path, np.hstack([source, target]), fmt="%.17g")
    return path


def run_of(command, *arguments):
    return json.loads(command("register", *arguments, "--json", "-"))["runs"][0]


def assert_same(result, run):
    """To the last bit: JSON numbers have the digits that read back as the same double."""
    assert result.status == run["status"]
    assert (None if result.pose is None else result.pose.tolist()) == run["T_target_source"]
    if result.pose is not None:
        assert result.covariance.tolist() == run["covariance"]
    assert result.inliers.tolist() == run["inliers"]
    assert result.noise_bound == run["noise_bound"]
    assert result.log10_false_poses == run["log10_false_poses"]
    assert [(s.name, s.input, s.output, s.iterations) for s in result.stages] == [
        (s["name"], s["input"], s["output"], s["iterations"]) for s in run["stages"]
    ]
    assert (result.runner_up is None) == ("runner_up" not in run)
    if result.runner_up is not None:
        assert result.runner_up.pose.tolist() == run["runner_up"]["T_target_source"]
        assert result.runner_up.support == run["runner_up"]["support"]
        assert result.runner_up.scale == run["runner_up"].get("scale", 1.0)
    assert (result.refused is None) == ("refused" not in run)
    if result.refused is not None:
        assert result.refused.pose.tolist() == run["refused"]["T_target_source"]


@pytest.mark.parametrize("solver", consimd.solvers())
def test_same_bits_as_the_command(command, problem, tmp_path, solver):
    file = save(tmp_path / "pair.txt", problem.source, problem.target)
    run = run_of(command, file, "--noise-bound", 1.5, "--solver", solver, "--seed", 4)
    assert_same(consimd.register(problem.source, problem.target, 1.5, solver, seed=4), run)


@pytest.mark.parametrize("threads", [None, 1, 2])
def test_same_bits_on_a_recorded_pair(command, eth_pair, tmp_path, threads):
    source, target, bound = eth_pair
    file = save(tmp_path / "pair.txt", source, target)
    result = consimd.register(source, target, bound, seed=7, threads=threads)
    assert_same(result, run_of(command, file, "--noise-bound", bound, "--seed", 7))
    assert result.status == "success"
    rows = consimd.Correspondences(source, target)
    assert np.array_equal(consimd.register(rows, noise_bound=bound, seed=7).pose, result.pose)


def test_same_bits_without_a_bound_and_after_the_filter(command, problem, tmp_path):
    file = save(tmp_path / "pair.txt", problem.source, problem.target)
    assert_same(consimd.register(problem.source, problem.target, seed=2), run_of(command, file, "--seed", 2))
    result = consimd.register(problem.source, problem.target, 1.5, "sc2_pcr", seed=2, filter="tcf")
    assert_same(
        result, run_of(command, file, "--noise-bound", 1.5, "--solver", "sc2_pcr", "--filter", "tcf", "--seed", 2)
    )
    assert result.filter == "tcf"
    assert result.stages[0].name == "filter_one_point"


@pytest.mark.parametrize("solver", consimd.solvers())
def test_default_options_change_nothing(problem, solver):
    options = consimd.solver_options(solver)
    assert options
    plain = consimd.register(problem.source, problem.target, None, solver, filter="tcf")
    given = consimd.register(problem.source, problem.target, None, solver, filter="tcf", **options)
    assert np.array_equal(plain.pose, given.pose)
    assert np.array_equal(plain.inliers, given.inliers)
    assert plain.noise_bound == given.noise_bound
    assert [s.name for s in plain.stages] == [s.name for s in given.stages]


def test_options_reach_their_solver(problem):
    register = lambda *args, **options: consimd.register(problem.source, problem.target, 1.5, *args, **options)
    drawn = {n: register("ransac", max_iterations=n, confidence=None).stages[0].iterations for n in (1000, 3000)}
    assert drawn == {1000: 1000, 3000: 3000}
    assert register("tcf", max_seeds=1, seed=3).stages[0].iterations <= 64 < register("tcf").stages[0].iterations or (
        register("tcf", max_seeds=1, seed=3).status != "success"
    )
    assert not register("teaser", refine=False).covariance.any()
    assert register("teaser").covariance.any()
    with pytest.raises(ValueError, match="budget|matrix"):
        register("teaser", matrix_budget_bytes=10)


def test_information_of_an_edge(problem):
    result = consimd.register(problem.source, problem.target, 1.5)
    rotation = result.pose[:3, :3].T
    turn = np.zeros((6, 6))
    turn[:3, :3] = turn[3:, 3:] = rotation
    gtsam = np.linalg.inv(turn @ result.covariance @ turn.T)
    order = [3, 4, 5, 0, 1, 2]
    half = np.diag([1, 1, 1, 2, 2, 2])
    for library, expected in (("gtsam", gtsam), ("open3d", gtsam), ("g2o", half @ gtsam[np.ix_(order, order)] @ half)):
        information = result.edge_information(library)
        assert information.shape == (6, 6) and np.array_equal(information, information.T)
        assert np.linalg.norm(information - expected) < 1e-6 * np.linalg.norm(expected)
    with pytest.raises(ValueError, match="library is 'ceres', expected one of: gtsam, g2o, open3d"):
        result.edge_information("ceres")
    with pytest.raises(ValueError, match="there is no pose"):
        consimd.register(problem.source[:2], problem.target[:2], 1.5).edge_information("gtsam")


def test_unknown_and_bad_options_are_named(problem):
    register = lambda *args, **options: consimd.register(problem.source, problem.target, 1.5, *args, **options)
    with pytest.raises(
        TypeError, match="unexpected keyword argument 'max_nodes'; options of the solver 'tcf': confidence, max_seeds"
    ):
        register("tcf", max_nodes=3)
    for solver, option, expected, values_of_type, values_of_other_type in BAD_VALUES:
        for error, values in ((ValueError, values_of_type), (TypeError, values_of_other_type)):
            for value in values:
                with pytest.raises(error, match=f"^{option} is .*, expected {re.escape(expected)}$"):
                    register(solver, **{option: value})
    with pytest.raises(ValueError, match="second_set is 20, expected no more than first_set, 10"):
        register("sc2_pcr", first_set=10)
    with pytest.raises(ValueError, match="option 'max_seeds' of solver 'tcf' is given twice"):
        register("tcf:max_seeds=5", max_seeds=6)


def test_options_can_be_of_numpy_types(problem):
    register = lambda **options: consimd.register(problem.source, problem.target, 1.5, "ransac", **options)
    plain = register(max_iterations=700, confidence=0.5)
    given = register(max_iterations=np.int32(700), confidence=np.float32(0.5))
    named = consimd.register(problem.source, problem.target, 1.5, "ransac:max_iterations=700:confidence=0.5")
    assert np.array_equal(plain.pose, given.pose) and np.array_equal(plain.pose, named.pose)
    assert np.array_equal(plain.pose, register(max_iterations=700, confidence=0.5, length_tolerance=6).pose)


def test_errors_are_those_of_the_library(problem):
    source, target = problem.source, problem.target
    for bound in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(ValueError, match="noise_bound"):
            consimd.register(source, target, bound)
    for call in (consimd.register, lambda *a, **k: consimd.register(*a, confidence=0.5, **k)):
        with pytest.raises(ValueError, match="solver is 'icp', expected one of: tcf"):
            call(source, target, 1.0, "icp")
    with pytest.raises(ValueError, match="filter is 'x', expected one of: none, tcf"):
        consimd.register(source, target, 1.0, filter="x")
    with pytest.raises(ValueError, match="threads is 0"):
        consimd.register(source, target, 1.0, threads=0)
    with pytest.raises(TypeError, match="needs a target"):
        consimd.register(source)
    with pytest.raises(TypeError, match="no target beside"):
        consimd.register(problem.correspondences(), target)
    with pytest.raises(ValueError, match="solver is 'icp'"):
        consimd.solver_options("icp")


def test_the_result_explains_itself(problem):
    result = consimd.register(problem.source, problem.target, 1.5)
    assert result.status is consimd.Status.SUCCESS
    assert f"{result.status}" == str(result.status) == "success"
    assert result.has_pose
    assert result.pose.shape == (4, 4) and result.pose.dtype == np.float64
    assert result.covariance.shape == (6, 6)
    assert np.linalg.eigvalsh(result.covariance).min() > -1e-12
    moved = problem.source @ result.pose[:3, :3].T + result.pose[:3, 3]
    residuals = np.linalg.norm(moved - problem.target, axis=1)
    assert np.array_equal(result.inliers, np.flatnonzero(residuals < 1.5))
    assert (result.seed, result.noise_bound, result.consistency_bound) == (1, 1.5, 3.0)
    assert (result.solver, result.filter, result.correspondences) == ("tcf", "none", 1000)
    assert result.isa == consimd.kernels.active_isa()
    assert result.threads >= 1 and consimd.register(problem.source, problem.target, 1.5, threads=1).threads == 1
    assert 0 < sum(stage.seconds for stage in result.stages) < 1.1 * result.seconds
    text = repr(result)
    assert "success by tcf" in text and f"{len(result.inliers)} of 1000" in text and "\n" not in text


def test_without_a_pose(problem):
    result = consimd.register(*(np.random.default_rng(1).normal(size=(2, 300, 3))), 0.05)
    assert result.status == "no_consensus"
    assert not result.has_pose
    assert result.pose is None
    assert result.inliers.shape == (0,) and not result.covariance.any()
    assert "no_consensus by tcf, no pose" in repr(result)


def test_assumed_inliers():
    corners = np.array([[0, 0, 0], [4, 0, 0], [4, 3, 0], [0, 3, 0]], float)
    turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]], float)
    result = consimd.register(corners, corners @ turn.T + [1, 2, 3], assume_inliers=True)
    assert (result.status, result.solver, result.geometry) == ("success", "least_squares", "determined")
    assert np.allclose(result.pose, np.block([[turn, np.array([[1], [2], [3]])], [0, 0, 0, 1]]), atol=1e-6)
    assert result.inliers.tolist() == [0, 1, 2, 3]
    assert result.residuals.shape == (4,) and result.residuals.max() < 1e-5 and result.sigma < 1e-5
    line = np.arange(4.0)[:, None] * [1, 2, 3]
    result = consimd.register(line, line, assume_inliers=True)
    assert (result.status, result.geometry, result.pose) == ("degenerate_geometry", "collinear", None)
    assert consimd.register(corners, corners, assume_inliers=True).other_scale is None
    far_off = consimd.register(corners, 1000 * corners @ turn.T, assume_inliers=True)
    assert np.isclose(far_off.other_scale, 1000) and far_off.geometry == "contradictory"
    odd = np.vstack([corners, corners[:2] + [0, 0, 5]])
    assert consimd.register(odd, odd, assume_inliers=True).odd_row is None
    assert consimd.register(odd, odd + 3 * (np.arange(6) == 4)[:, None], assume_inliers=True).odd_row == 4
    with pytest.raises(TypeError, match="assume_inliers"):
        consimd.register(corners, corners, 0.1, assume_inliers=True)


def test_two_motions_are_ambiguous():
    two = consimd.synth.hard_problem(correspondences=600, outlier_ratio=0.8, sigma=0.1, decoy_share=1.0)
    result = consimd.register(two.source, two.target, 0.3)
    assert result.status is consimd.Status.AMBIGUOUS
    assert isinstance(result.runner_up, consimd.RunnerUp)
    errors = sorted(consimd.synth.rotation_error_deg(result.runner_up.pose, pose) for pose in (two.pose, two.decoy_pose))
    assert errors[0] < 0.5 < errors[1]
    assert result.runner_up.support > 50


def test_results_can_be_pickled(problem):
    result = consimd.register(problem.source, problem.target, 1.5)
    copy = pickle.loads(pickle.dumps(result))
    assert copy.status is result.status
    assert np.array_equal(copy.pose, result.pose)
    assert copy.stages == result.stages


def test_map_coordinates_and_millimetres():
    far = consimd.synth.hard_problem(
        outlier_ratio=0.8, sigma=0.1, source_offset=(5e6, -4e6, 100), target_offset=(5e6, -4e6, 0), units_per_metre=1000
    )
    result = consimd.register(far.source, far.target, 300.0)
    assert result.status == "success"
    assert consimd.synth.rmse_true_inliers(far, result.pose) < 300


def test_a_close_look_tells_any_pose(problem):
    result = consimd.register(problem.source, problem.target, 1.5)
    close = consimd.log10_false_poses(problem.source, problem.target, pose=result.pose, noise_bound=1.5)
    assert close < -10
    order = np.random.default_rng(1).permutation(len(problem.source))
    shuffled = consimd.Correspondences(problem.source[order], problem.target[order])
    assert consimd.log10_false_poses(shuffled, pose=result.pose, noise_bound=1.5) == pytest.approx(close, rel=0.2)
    assert consimd.log10_false_poses(shuffled, pose=np.eye(4), noise_bound=1.5) > -3
    with pytest.raises(ValueError, match="noise_bound"):
        consimd.log10_false_poses(shuffled, pose=result.pose, noise_bound=0)
    with pytest.raises(ValueError, match="pose"):
        consimd.log10_false_poses(shuffled, pose=np.ones((4, 4)), noise_bound=1.5)
    with pytest.raises(TypeError, match="target"):
        consimd.log10_false_poses(problem.source, pose=result.pose, noise_bound=1.5)


def test_the_noise_bound_is_estimated(problem):
    estimate = consimd.estimate_noise_bound(problem.source, problem.target)
    assert estimate.noise_bound == pytest.approx(1.5, rel=0.3)
    assert estimate == consimd.estimate_noise_bound(problem.correspondences())
    assert consimd.register(problem.source, problem.target).noise_bound == estimate.noise_bound


@pytest.mark.parametrize("solver", ["pcr99", "teaser"])
def test_an_unknown_scale_is_found(problem, solver):
    source = problem.source / 2.5
    result = consimd.register(source, problem.target, 1.5, solver=solver, estimate_scale=True)
    assert result.has_pose
    assert abs(result.scale / 2.5 - 1) < 0.01
    assert 0 < result.scale_deviation < 0.01 * result.scale
    moved = result.scale * source @ result.pose[:3, :3].T + result.pose[:3, 3]
    residuals = np.linalg.norm(moved - problem.target, axis=1)
    assert (residuals[result.inliers] < 1.5).all()


def test_an_unknown_scale_needs_a_bound_and_all_rows(problem):
    with pytest.raises(ValueError, match="estimate_scale: needs a noise_bound"):
        consimd.register(problem.source, problem.target, solver="pcr99", estimate_scale=True)
    with pytest.raises(ValueError, match="estimate_scale: filter 'tcf'"):
        consimd.register(problem.source, problem.target, 1.5, solver="pcr99", filter="tcf", estimate_scale=True)
    with pytest.raises(TypeError, match="estimate_scale"):
        consimd.register(problem.source, problem.target, 1.5, estimate_scale=True)


def test_a_time_limit_ends_the_search(problem):
    endless = {"solver": "ransac", "max_iterations": 4 * 10**9, "confidence": None}
    result = consimd.register(problem.source, problem.target, 1.5, time_limit=0.05, **endless)
    assert (result.status, result.stopped) == (consimd.Status.BUDGET_EXHAUSTED, True)
    limited = consimd.register(problem.source, problem.target, 1.5, time_limit=1e6)
    free = consimd.register(problem.source, problem.target, 1.5)
    assert not limited.stopped
    assert (limited.pose == free.pose).all()
    nothing = consimd.register(problem.source, problem.target, time_limit=1e-9)
    assert (nothing.pose, nothing.stopped) == (None, True)
    for seconds in (0, -1.0, float("nan")):
        with pytest.raises(ValueError, match="time_limit is .*, expected seconds above 0, or None"):
            consimd.register(problem.source, problem.target, 1.5, time_limit=seconds)
    with pytest.raises(TypeError, match="takes no noise_bound, time_limit"):
        consimd.register(problem.source, problem.target, time_limit=1.0, assume_inliers=True)


def test_solvers_are_listed():
    assert next(iter(consimd.solvers())) == "tcf"
    assert all(consimd.solvers().values())
    assert consimd.solver_options()["confidence"] == 0.99
    assert consimd.solver_options("ransac-10k")["confidence"] is None
    assert consimd.solver_options("teaser")["selection"] == "maximum_clique"
