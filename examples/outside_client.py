#!/usr/bin/env python3
"""A solver for studies: consimd sweep --solver 'mine=exec:python3 outside_client.py'. Put your own in `solve`."""
import sys

import numpy as np


def fit(p, q):
    """4 x 4 rigid motion of (N, 3) points p to q, least squares (Umeyama 1991, eq. 40 to 42 without scale)."""
    a, b = p.mean(0), q.mean(0)
    u, _, vt = np.linalg.svd((q - b).T @ (p - a))
    r = u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt
    return np.vstack([np.c_[r, b - r @ a], [0.0, 0.0, 0.0, 1.0]])


def solve(source, target, noise_bound, seed):
    """A pose, 4 x 4, or None: here RANSAC on three points."""
    random, best = np.random.default_rng(seed), np.zeros(len(source), bool)
    for _ in range(200 if len(source) >= 3 else 0):
        rows = random.integers(len(source), size=3)
        pose = fit(source[rows], target[rows])
        near = np.linalg.norm(source @ pose[:3, :3].T + pose[:3, 3] - target, axis=1) <= noise_bound
        best = near if near.sum() > best.sum() else best
    return fit(source[best], target[best]) if best.sum() > 3 else None


print("ready 1.0", flush=True)
for header in sys.stdin:
    n, noise_bound, seed = header.split()
    rows = np.array([sys.stdin.readline().split() for _ in range(int(n))], float).reshape(-1, 6)
    pose = solve(rows[:, :3], rows[:, 3:], float(noise_bound), int(seed))
    print("none" if pose is None else " ".join(map(repr, pose.ravel().tolist())), flush=True)
