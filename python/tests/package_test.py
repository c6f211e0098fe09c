"""The package as a whole: import, documentation, example."""

import importlib.metadata
import inspect
import pathlib
import subprocess
import sys

import pytest

import consimd

EXAMPLES = pathlib.Path(__file__).parents[1] / "examples"


def test_import_waits_for_nothing_heavy():
    """NumPy is imported when first needed."""
    loaded = "import sys, consimd; sys.exit('numpy' in sys.modules)"
    subprocess.run([sys.executable, "-c", loaded], check=True)


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


def test_the_example_draws(tmp_path):
    pytest.importorskip("matplotlib")
    subprocess.run([sys.executable, EXAMPLES / "register_pair.py", "--out", tmp_path / "pair.png"], check=True)
    assert (tmp_path / "pair.png").read_bytes()[:4] == b"\x89PNG"
