"""Ctrl-C, and other Python threads meanwhile."""

import signal
import threading
import time

import numpy as np
import pytest

import consimd
from consimd import features

# More samples than are drawn in an hour.
LONG = """
import consimd
p = consimd.synth.noise_study_problem(3000, outlier_ratio=0.6)
c = p.correspondences()
print("ready", flush=True)
try:
    consimd.register(c, None, 3.0, "ransac", max_iterations=4 * 10**9, confidence=None)
    print("finished", flush=True)
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""


def test_ctrl_c_ends_a_registration_at_once(script):
    process = script(LONG)
    assert process.stdout.readline() == "ready\n"
    time.sleep(0.2)
    process.send_signal(signal.SIGINT)
    assert process.stdout.readline() == "interrupted\n"
    # The search was ended with the call that waited for it, and the process ends in good order.
    assert process.wait(timeout=60) == 0
    assert process.stderr.read() == ""


SWEEP = """
import consimd
try:
    consimd.sweep(500, [0.5, 0.9], [0.5, 1.0], trials=20_000, out="study")
    print("finished")
except KeyboardInterrupt:
    print("interrupted")
"""


def test_ctrl_c_ends_a_sweep_and_keeps_what_is_done(script, tmp_path):
    process = script(SWEEP)
    trials = tmp_path / "study/trials.csv"
    deadline = time.monotonic() + 60
    while not (trials.exists() and trials.read_text().count("\n") > 100):
        assert time.monotonic() < deadline
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=30) == 0
    assert process.stdout.read() == "interrupted\n"
    lines = trials.read_text().splitlines()
    assert 100 < len(lines) < 80_000
    assert {len(line.split(",")) for line in lines} == {15}
    # The same call takes it up.
    seen = []

    def stop(done, total):
        seen.append(done)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        consimd.sweep(500, [0.5, 0.9], [0.5, 1.0], trials=20_000, out=tmp_path / "study", progress=stop)
    assert seen[0] >= len(lines) - 1


def test_a_handler_that_does_not_raise_ends_nothing(problem):
    calls = []
    before = signal.signal(signal.SIGALRM, lambda *_: calls.append(1))
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.02, 0.02)
        trials = consimd.sweep(1000, [0.5, 0.9], [0.5, 1.0], trials=300).trials
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert len(trials) == 1200
    assert calls


POINTS = np.random.default_rng(1).random((40_000, 3))
DESCRIPTORS = np.random.default_rng(1).random((30_000, 64))


# Calls of half a second and more, and one short one.
@pytest.mark.parametrize(
    "call",
    [
        lambda: [features.voxel_grid(POINTS, 0.01) for _ in range(1000)],
        lambda: features.normals(POINTS, 0.5, threads=1),
        lambda: features.iss_keypoints(POINTS, 0.5, 0.5, threads=1),
        lambda: features.fpfh(POINTS, 0.3, normal_radius=0.1, threads=1),
        lambda: features.match(DESCRIPTORS, DESCRIPTORS, threads=1),
        lambda: features.nearest_neighbours(POINTS, POINTS, 64, radius=0.5, threads=1),
    ],
    ids=["voxel_grid", "normals", "iss_keypoints", "fpfh", "match", "nearest_neighbours"],
)
def test_ctrl_c_ends_calls_of_features_at_once(call):
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.1)
        with pytest.raises(KeyboardInterrupt):
            call()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def test_other_threads_run_meanwhile():
    problem = consimd.synth.noise_study_problem(200_000, outlier_ratio=0.5)
    calls = []
    seen = threading.Event()
    deadline = time.monotonic() + 60

    def register():
        while not seen.is_set() and time.monotonic() < deadline:
            calls.append(1)
            consimd.register(problem.source, problem.target, threads=1)
            calls.append(-1)

    thread = threading.Thread(target=register)
    thread.start()
    # Without the release of the lock this loop would stand still inside a call and see each of them at most once, where
    # the interpreter changes threads beside it.
    ticks = last = 0
    while not seen.is_set() and thread.is_alive():
        ticks = ticks + 1 if len(calls) == last and len(calls) % 2 == 1 else 0
        last = len(calls)
        if ticks > 5:
            seen.set()
        time.sleep(0.001)
    thread.join()
    assert seen.is_set()


def test_registrations_in_threads_and_forks_agree(problem):
    expected = consimd.register(problem.source, problem.target, 1.5).pose
    poses = [None] * 8

    def register(k):
        poses[k] = consimd.register(problem.source, problem.target, 1.5).pose

    threads = [threading.Thread(target=register, args=(k,)) for k in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(pose, expected) for pose in poses)


FORKS = """
import multiprocessing, numpy, consimd
p = consimd.synth.noise_study_problem(500, outlier_ratio=0.8)
def register(seed):
    return consimd.register(p.source, p.target, 3.0, seed=seed)
if __name__ == "__main__":
    here = [register(seed).pose for seed in range(6)]
    with multiprocessing.get_context("fork").Pool(2) as pool:
        there = [result.pose for result in pool.map(register, range(6))]
    print(all(map(numpy.array_equal, here, there)))
"""


def test_registrations_in_forked_processes_agree(script):
    process = script(FORKS)
    out, error = process.communicate(timeout=60)
    assert out == "True\n", error
