"""consimd.view: the pages and drawings of the command."""

import sys

import numpy as np
import pytest

import consimd


@pytest.fixture(scope="module")
def problem():
    return consimd.synth.noise_study_problem(correspondences=400, outlier_ratio=0.6, sigma=0.2)


def test_pages_are_those_of_the_command(problem, command, tmp_path):
    np.savetxt(tmp_path / "pair.txt", np.c_[problem.source, problem.target], fmt="%.17g")
    result = consimd.register(problem.source, problem.target, 0.6)
    for option, name in (("--view", "view.html"), ("--picture", "view.svg")):
        command("register", tmp_path / "pair.txt", "--noise-bound", "0.6", option, tmp_path / name)
        consimd.view(tmp_path / f"own_{name}", result, problem.source, problem.target, names=(f"{tmp_path}/pair.txt", ""))
        assert (tmp_path / f"own_{name}").read_bytes() == (tmp_path / name).read_bytes()


def test_clouds_and_their_matches(tmp_path):
    draw = np.random.default_rng(1)
    source = draw.uniform(-5, 5, (3000, 3)) * (1, 1, 0.2)
    registration, matches = consimd.register_clouds(source, source + (1, 2, 0), voxel=0.5)
    consimd.view(tmp_path / "view.html", registration, source, source + (1, 2, 0), matches, names=("first <1>", "second"))
    page = (tmp_path / "view.html").read_text()
    assert "<tr><th>source</th><td>first &lt;1&gt;</td></tr>" in page
    assert '"size":3000,' in page
    assert f"<tr><th>correspondences</th><td>{len(matches.distances):,}</td></tr>".replace(",", "\u202f") in page


def test_without_a_pose(problem, tmp_path):
    nothing = consimd.register(problem.source, problem.target[::-1], 0.01)
    assert not nothing.has_pose
    consimd.view(tmp_path / "view.svg", nothing, problem.source, problem.target[::-1])
    assert f"{nothing.status}: no pose" in (tmp_path / "view.svg").read_text()


def test_png_is_that_of_the_command(problem, command, tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    monkeypatch.setenv("CONSIMD_PYTHON", sys.executable)
    np.savetxt(tmp_path / "pair.txt", np.c_[problem.source, problem.target], fmt="%.17g")
    command("register", tmp_path / "pair.txt", "--noise-bound", "0.6", "--picture", tmp_path / "view.png")
    result = consimd.register(problem.source, problem.target, 0.6)
    (tmp_path / "own").mkdir()
    consimd.view(tmp_path / "own/view.png", result, problem.source, problem.target, names=(f"{tmp_path}/pair.txt", ""))
    assert (tmp_path / "own/view.png").read_bytes() == (tmp_path / "view.png").read_bytes()
    assert [path.name for path in (tmp_path / "own").iterdir()] == ["view.png"]


def test_png_without_matplotlib_leaves_nothing(problem, tmp_path, monkeypatch):
    (tmp_path / "matplotlib.py").write_text("raise ImportError('not this one')")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    result = consimd.register(problem.source, problem.target, 0.6)
    (tmp_path / "own").mkdir()
    with pytest.raises(RuntimeError, match=r"view\.png not drawn: ImportError: not this one"):
        consimd.view(tmp_path / "own/view.png", result, problem.source, problem.target)
    assert not list((tmp_path / "own").iterdir())
    with pytest.raises(OSError, match="nowhere"):
        consimd.view(tmp_path / "nowhere/view.png", result, problem.source, problem.target)


def test_errors_name_what_is_wrong(problem, tmp_path):
    result = consimd.register(problem.source, problem.target, 0.6)
    with pytest.raises(ValueError, match=r"ends with \.html, \.htm, \.svg or \.png, got 'view\.jpg'"):
        consimd.view("view.jpg", result, problem.source, problem.target)
    with pytest.raises(RuntimeError, match="no/view.html: cannot write"):
        consimd.view(tmp_path / "no/view.html", result, problem.source, problem.target)
    with pytest.raises(ValueError, match="is none of the picture's 3 correspondences"):
        consimd.view(tmp_path / "view.html", result, problem.source[:3], problem.target[:3])
