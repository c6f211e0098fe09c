"""The package as a whole: import, documentation, speed, example."""

import importlib.metadata
import inspect
import json
import pathlib
import subprocess
import sys
import time

import numpy as np
import pytest

import consimd

EXAMPLES = pathlib.Path(__file__).parents[1] / "examples"


def test_import_is_quick():
    measure = "import time; start = time.perf_counter(); import consimd; print(time.perf_counter() - start)"
    times = [float(subprocess.check_output([sys.executable, "-c", measure])) for _ in range(5)]
    print(f"import consimd takes {1e3 * min(times):.0f} ms")
    assert min(times) < 0.2


def test_version_and_marker():
    assert consimd.__version__ == importlib.metadata.version("consimd")
    folder = pathlib.Path(consimd.__file__).parent
    assert (folder / "py.typed").exists()
    assert "class Correspondences:" in (folder / "_core.pyi").read_text()


def test_libraries_come_along():
    """What the module needs beside the C library is in the wheel."""
    folder = pathlib.Path(consimd.__file__).parent
    (module,) = folder.glob("_core.*.so")
    loaded = subprocess.check_output(["ldd", module], text=True)
    for line in loaded.splitlines():
        if "libtbb" in line or "libfmt" in line:
            assert str(folder.parent) in line, line
    assert "libtbb" in loaded
    assert "not found" not in loaded


@pytest.mark.parametrize("module", [consimd, consimd.kernels, consimd.synth])
def test_everything_public_is_documented(module):
    assert module.__doc__
    for name in module.__all__:
        thing = getattr(module, name)
        if not inspect.ismodule(thing) and name != "__version__":
            assert inspect.getdoc(thing), name


def test_a_call_costs_little_more_than_the_library(command, eth_pair, tmp_path):
    source, target, bound = eth_pair
    file = tmp_path / "pair.txt"
    np.savetxt(file, np.hstack([source, target]), fmt="%.17g")
    runs = json.loads(command("register", file, "--noise-bound", bound, "--repeat", 300, "--json", "-"))["runs"]
    whole, preparation = [], []
    for seed in range(1, 301):
        start = time.perf_counter()
        consimd.register(source, target, bound, seed=seed)
        whole.append(time.perf_counter() - start)
        start = time.perf_counter()
        consimd.Correspondences(source, target)
        preparation.append(time.perf_counter() - start)
    # `seconds` of the command is the registration alone: a C++ caller prepares the rows as well. The quickest of many
    # calls, since another process may take the processor from any of them.
    cpp = min(run["seconds"] for run in runs) + min(preparation)
    print(f"a call takes {1e3 * min(whole):.3f} ms, {min(whole) / cpp:.2f} times the C++ time")
    assert min(whole) < 1.3 * cpp


def test_the_example_draws(tmp_path):
    pytest.importorskip("matplotlib")
    subprocess.run([sys.executable, EXAMPLES / "register_pair.py", "--out", tmp_path / "pair.png"], check=True)
    assert (tmp_path / "pair.png").read_bytes()[:4] == b"\x89PNG"
