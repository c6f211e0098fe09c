"""What the tests share: the command to compare with, problems, recorded pairs."""

import json
import os
import pathlib
import signal
import subprocess
import sys

import numpy as np
import pytest

import consimd


def pytest_report_header():
    return f"numpy {np.__version__}, consimd {consimd.__version__} on {consimd.kernels.active_isa()}"


@pytest.fixture(scope="session")
def command():
    """Runs the C++ command and returns what it printed."""
    program = os.environ.get("CONSIMD")
    if not program:
        pytest.skip("set CONSIMD to the consimd command")

    def run(*arguments):
        # 1: it found no pose, which is a result too.
        done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
        assert done.returncode in (0, 1), done.stderr
        return done.stdout

    return run


@pytest.fixture(scope="session")
def problem():
    return consimd.synth.noise_study_problem(1000, outlier_ratio=0.9, sigma=0.5, seed=5)


@pytest.fixture(scope="session")
def eth_pair():
    """Source, target and noise bound of a recorded pair."""
    data = os.environ.get("CONSIMD_TEST_DATA")
    if not data:
        pytest.skip("set CONSIMD_TEST_DATA to the folder with correspondences/<case>/")
    folder = pathlib.Path(data) / "correspondences/eth_s3_s1"
    rows = np.loadtxt(folder / "correspondences.txt")
    return rows[:, :3], rows[:, 3:], json.loads((folder / "case.json").read_text())["noise_bound"]


@pytest.fixture
def script(tmp_path):
    """Starts Python on a script, in a folder of its own."""

    def start(text, **environment):
        return subprocess.Popen(
            [sys.executable, "-c", text],
            cwd=tmp_path,
            env={**os.environ, **environment},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            # A shell that starts the tests in the background has them ignore Ctrl-C.
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        )

    return start
