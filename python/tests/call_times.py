"""Prints what importing the package and a call cost. No test: machines are busy. Usage: call_times.py CONSIMD [CASE]

CONSIMD: the C++ command. CASE: folder of a recorded pair; without it a problem of the noise study is registered.
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import time

start = time.perf_counter()
import consimd  # noqa: E402

print(f"import consimd: {1e3 * (time.perf_counter() - start):.0f} ms")

import numpy as np  # noqa: E402

CALLS = 300

if len(sys.argv) > 2:
    case = pathlib.Path(sys.argv[2])
    rows = np.loadtxt(case / "correspondences.txt")
    source, target = rows[:, :3], rows[:, 3:]
    bound = json.loads((case / "case.json").read_text())["noise_bound"]
else:
    problem = consimd.synth.noise_study_problem(3000, outlier_ratio=0.95, sigma=0.1)
    source, target, bound = problem.source, problem.target, 0.3

with tempfile.TemporaryDirectory() as folder:
    file = pathlib.Path(folder) / "pair.txt"
    np.savetxt(file, np.hstack([source, target]), fmt="%.17g")
    report = subprocess.run(
        [sys.argv[1], "register", file, "--noise-bound", str(bound), "--repeat", str(CALLS), "--json", "-"],
        capture_output=True,
    ).stdout
whole, preparation = [], []
for seed in range(1, CALLS + 1):
    start = time.perf_counter()
    consimd.register(source, target, bound, seed=seed)
    whole.append(time.perf_counter() - start)
    start = time.perf_counter()
    consimd.Correspondences(source, target)
    preparation.append(time.perf_counter() - start)
# `seconds` of the command is the registration alone: a C++ caller prepares the rows as well.
cpp = np.median([run["seconds"] for run in json.loads(report)["runs"]]) + np.median(preparation)
python = np.median(whole)
print(f"a call: {1e3 * python:.3f} ms, {python / cpp:.2f} times the C++ time (medians of {CALLS})")
