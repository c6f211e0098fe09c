#!/usr/bin/env python3
"""KISS-Matcher's registration of given correspondences as a solver of studies, by the protocol of docs/outside_solvers.md:

    consimd sweep --solver tcf --solver 'kiss=exec-binary:python3 bench/peers/kiss_client.py'

Needs a Python with the peer: pip install kiss-matcher==1.0.2 numpy. It prunes by pairwise distances (a k-core of the
consistency graph) and then solves by graduated non-convexity, here on one thread. docs/outside_solvers.md tells how GAIN
was chosen.
"""

import os

os.environ["OMP_NUM_THREADS"] = "1"  # read as the library is loaded

import importlib.metadata  # noqa: E402
import struct  # noqa: E402
import sys  # noqa: E402
import time  # noqa: E402

import kiss_matcher  # noqa: E402
import numpy as np  # noqa: E402

GAIN = 0.5  # its bounds over that of the problem, in pruning and solving; the library wants the second at most the first


def solve(source, target, noise_bound):
    """A pose, 4 x 4, or None, and the seconds of the call."""
    config = kiss_matcher.KISSMatcherConfig(
        noise_bound, robin_noise_bound_gain=GAIN, solver_noise_bound_gain=GAIN, enable_noise_bound_clamping=False
    )
    matcher = kiss_matcher.KISSMatcher(config)
    points = [list(side.astype(np.float32)) for side in (source, target)]
    start = time.perf_counter()
    solution = matcher.prune_and_solve(*points)
    seconds = time.perf_counter() - start
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = solution.rotation, np.ravel(solution.translation)
    return (pose if solution.valid and np.isfinite(pose).all() else None), seconds


print("ready", importlib.metadata.version("kiss-matcher"), flush=True)
while header := sys.stdin.buffer.read(24):
    n, noise_bound, _ = struct.unpack("<QdQ", header)
    rows = np.frombuffer(sys.stdin.buffer.read(48 * n), "<f8").reshape(n, 6)
    pose, seconds = solve(rows[:, :3], rows[:, 3:], noise_bound)
    print("none" if pose is None else " ".join(map(repr, pose.ravel().tolist())), "time", repr(seconds), flush=True)
