"""Functions and programs as solvers in studies."""

import csv
import signal
import sys
import time

import numpy as np
import pytest

import consimd

STUDY = {"points": 100, "outliers": [0.2, 0.5], "sigma": [0.1, 1.0], "trials": 3}
# A program that refuses every problem.
REFUSES = """
import sys
print("ready 7", flush=True)
for header in sys.stdin:
    for _ in range(int(header.split()[0])):
        sys.stdin.readline()
    print("none", flush=True)
"""


def tcf(source, target, noise_bound, seed):
    """consimd's default solver as somebody else's."""
    return consimd.register(source, target, noise_bound, seed=seed, threads=1)


def timeless(table):
    return [[row[name] for name in table.dtype.names if name not in ("seconds", "solver", "method")] for row in table]


def of(table, name, column="solver"):
    return timeless(table[table[column] == name])


def assert_same(one, other):
    np.testing.assert_equal(one, other)  # NaN equals NaN


def test_a_function_is_a_solver_as_others_are(tmp_path):
    trials, cells, *_ = consimd.sweep(**STUDY, solvers={"mine": tcf, "tcf": None}, out=tmp_path / "sweep")
    assert set(cells["solver"]) == {"mine", "tcf"}
    assert_same(of(trials, "mine"), of(trials, "tcf"))
    runs, tables, *_ = consimd.compare(
        synthetic="facade", trials=2, tables=["solvers", "boost"], solvers={"mine": tcf, "tcf": None}
    )
    assert_same(of(runs, "mine", "method"), of(runs, "tcf", "method"))
    assert set(runs["method"]) == {"mine", "tcf", "tcf+mine", "tcf+tcf", "1R+2R"}
    assert [row[1] for row in tables["solvers"].rows] == ["mine", "tcf"]


def test_arrays_are_read_only_and_the_problem_itself():
    seen = []

    def look(source, target, noise_bound, seed):
        seen.append((source, target, noise_bound, seed))

    consimd.sweep(100, [0.5], [0.1], 2, {"mine": look}, threads=1)
    for trial, (source, target, noise_bound, seed) in enumerate(seen):
        problem = consimd.synth.noise_study_problem(100, outlier_ratio=0.5, sigma=0.1, trial=trial)
        # They outlive the call.
        assert (source == problem.source).all() and (target == problem.target).all()
        assert source.dtype == np.float64 and source.shape == (100, 3) and not source.flags.writeable
        assert not source.flags.owndata and source.flags.c_contiguous
        assert noise_bound == 0.1 * 3.0 and seed == 1 + trial
        with pytest.raises(ValueError, match="read-only"):
            source[0, 0] = 1.0


def test_answers_may_have_other_forms():
    class Found:
        def __init__(self, pose, inliers):
            self.pose, self.inliers = pose, inliers

    def run(answer):
        trials, *_ = consimd.sweep(100, [0.2], [0.1], 2, {"mine": answer, "tcf": None})
        return trials[trials["solver"] == "mine"], trials[trials["solver"] == "tcf"]

    for answer in (
        lambda p, q, bound, seed: tcf(p, q, bound, seed).pose,
        lambda p, q, bound, seed: tcf(p, q, bound, seed).pose.astype(np.float32).tolist(),
        lambda p, q, bound, seed: tcf(p, q, bound, seed).pose[:3],
        lambda p, q, bound, seed: Found(tcf(p, q, bound, seed).pose, tcf(p, q, bound, seed).inliers[::-1]),
        lambda p, q, bound, seed: Found(tcf(p, q, bound, seed).pose, np.isin(np.arange(100), tcf(p, q, bound, seed).inliers)),
    ):
        mine, own = run(answer)
        assert mine["success"].all() and (mine["status"] == "success").all()
        np.testing.assert_allclose(mine["rotation_error_deg"], own["rotation_error_deg"], atol=1e-4)
        np.testing.assert_allclose(mine["inlier_recall"], own["inlier_recall"], atol=0.05)
    mine, _ = run(lambda *_: None)
    assert not mine["success"].any() and (mine["status"] == "no_consensus").all()


@pytest.mark.parametrize(
    ("answer", "what"),
    [
        (np.eye(3), r"expected a 4 x 4 pose, got shape \(3, 3\)"),
        (np.full((4, 4), np.nan), "last row"),
        (np.full((3, 4), np.nan), "a number that is not finite"),
        (np.diag([1.0, 1.0, -1.0, 1.0]), "not a rotation but a reflection"),
        (np.diag([2.0, 1.0, 1.0, 1.0]), "not a rotation: R R"),
        (np.diag([1.0, 1.0, 1.0, 2.0]), "the last row must be 0 0 0 1"),
        ("pose", "could not convert string to float"),
    ],
)
def test_a_wrong_answer_names_solver_and_trial(answer, what):
    for run in (
        lambda f: consimd.sweep(100, [0.5], [0.1], 2, {"mine": f}),
        lambda f: consimd.compare(synthetic="facade", trials=1, solvers={"mine": f}),
    ):
        with pytest.raises(RuntimeError, match=f"solver mine on .*{what}"):
            run(lambda *_: answer)


@pytest.mark.parametrize("inliers", [[100], [-1], [[1]], [0.5], [3, 3]])
def test_wrong_inliers_name_solver_and_trial(inliers):
    class Found:
        pose = np.eye(4)

    Found.inliers = inliers
    with pytest.raises(RuntimeError, match="solver mine on trial 0 at outlier ratio 0.5 and sigma 0.1: wrong reply: "):
        consimd.sweep(100, [0.5], [0.1], 1, {"mine": lambda *_: Found()})


def test_an_exception_ends_the_study_with_the_trial_named():
    def fail(source, target, noise_bound, seed):
        if seed == 2:
            raise LookupError("lost")
        return np.eye(4)

    with pytest.raises(RuntimeError, match="solver mine on trial 1 at outlier ratio 0.5 and sigma 0.1: LookupError: lost") as caught:
        consimd.sweep(100, [0.5], [0.1], 2, {"mine": fail}, threads=1)
    assert isinstance(caught.value.__cause__, LookupError)


def test_a_folder_is_resumed_with_the_same_solver_only(tmp_path):
    options = {**STUDY, "threads": 1, "out": tmp_path}
    solvers = {"mine": tcf, "tcf": None}
    whole, *_ = consimd.sweep(**{**options, "out": None}, solvers=solvers)

    def stop(done, total):
        if done > 2:
            raise InterruptedError

    def slow(*problem):
        time.sleep(0.05)
        return tcf(*problem)

    slow.__module__, slow.__qualname__ = tcf.__module__, tcf.__qualname__
    with pytest.raises(InterruptedError):
        consimd.sweep(**options, solvers={"mine": slow, "tcf": None}, progress=stop)
    with open(tmp_path / "trials.csv", newline="") as file:
        assert 0 < len(list(csv.reader(file))) - 1 < len(whole)
    resumed, *_ = consimd.sweep(**options, solvers=solvers)
    assert_same(timeless(resumed), timeless(whole))
    with pytest.raises(RuntimeError, match="it has outside mine version , not 2"):
        consimd.sweep(**options, solvers=solvers, versions={"mine": "2"})
    with pytest.raises(RuntimeError, match="it has outside mine command python:.*tcf, not python:.*lambda"):
        consimd.sweep(**options, solvers={"mine": lambda *problem: tcf(*problem), "tcf": None})


def test_a_comparison_is_resumed_with_the_same_solver_only(tmp_path):
    options = {"synthetic": "facade", "trials": 3, "solvers": {"mine": tcf, "tcf": None}}
    whole, *_ = consimd.compare(**options, versions={"mine": "1"}, out=tmp_path)
    lines = (tmp_path / "runs.csv").read_text().splitlines(keepends=True)
    (tmp_path / "runs.csv").write_text("".join(lines[:4]))
    resumed, *_ = consimd.compare(**options, versions={"mine": "1"}, out=tmp_path)
    assert_same(timeless(resumed), timeless(whole))
    with pytest.raises(RuntimeError, match="it has outside mine version 1, not 2"):
        consimd.compare(**options, versions={"mine": "2"}, out=tmp_path)


def test_a_program_is_a_solver(tmp_path):
    (tmp_path / "refuses.py").write_text(REFUSES)
    command = f"exec:{sys.executable} {tmp_path / 'refuses.py'}"
    trials, *_ = consimd.sweep(100, [0.5], [0.1], 2, {"mine": command, "tcf": None})
    assert trials["status"].tolist() == ["no_consensus"] * 2 + ["success"] * 2
    with pytest.raises(RuntimeError, match="solver mine: 'exit 3' ended with exit code 3 without the line 'ready'"):
        consimd.sweep(100, [0.5], [0.1], 2, {"mine": "exec:exit 3"})
    with pytest.raises(ValueError, match="time limit"):
        consimd.sweep(100, [0.5], [0.1], 2, {"mine": command}, time_limit=0.0)
    with pytest.raises(ValueError, match="time_limit: 5 s are for programs"):
        consimd.sweep(100, [0.5], [0.1], 2, {"mine": tcf, "tcf": None}, time_limit=5)


def test_bad_arguments_are_named():
    for solvers, what in (
        ({"tcf": tcf}, "solver tcf: consimd has one of this name"),
        ({"a b": tcf}, "solver 'a b'"),
        ({"mine": 3}, "solver mine: expected a function, 'exec:COMMAND' or None, got int"),
        ({"mine": "run:x"}, "solver mine: expected exec:COMMAND"),
        ({"mine": None}, "mine"),
        (["tcf", "tcf"], "tcf is given twice"),
    ):
        with pytest.raises(ValueError, match=what):
            consimd.sweep(**STUDY, solvers=solvers)
        with pytest.raises(ValueError, match=what):
            consimd.compare(synthetic="facade", trials=1, solvers=solvers)
    with pytest.raises(ValueError, match="versions: 'yours' is no function or program"):
        consimd.sweep(**STUDY, solvers={"mine": tcf}, versions={"yours": "1"})


INTERRUPTED = """
import time, consimd

def slow(source, target, noise_bound, seed):
    print("called", flush=True)
    time.sleep(0.2)

try:
    consimd.sweep(100, [0.5], [0.1], trials=1000, solvers={"mine": slow}, out="study", threads=1)
    print("finished")
except KeyboardInterrupt:
    print("interrupted")
"""


def test_ctrl_c_ends_a_study_of_a_function(script, tmp_path):
    process = script(INTERRUPTED)
    for _ in range(6):
        assert process.stdout.readline() == "called\n"
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=30) == 0
    assert process.stdout.read().endswith("interrupted\n")
    assert len((tmp_path / "study/trials.csv").read_text().splitlines()) > 2


HUNG = """
import sys, time
print("ready", flush=True)
sys.stdin.readline()
print("got", file=sys.stderr, flush=True)
time.sleep(1000)
"""
CALLS_HUNG = """
import sys
import consimd

try:
    consimd.sweep(100, [0.5], [0.1], trials=2, solvers={"mine": f"exec:{sys.executable} hung.py"}, threads=1)
except KeyboardInterrupt:
    print("interrupted")
"""


def test_ctrl_c_ends_a_program_that_hangs(script, tmp_path):
    (tmp_path / "hung.py").write_text(HUNG)
    process = script(CALLS_HUNG)
    assert process.stderr.readline() == "got\n"
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=30) == 0  # half of the time limit
    assert process.stdout.read().endswith("interrupted\n")
