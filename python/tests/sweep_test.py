"""consimd.sweep: the tables of the C++ command."""

import json

import numpy as np
import pytest

import consimd

STUDY = dict(points=200, outliers=(0.5, 0.9), sigma=(0.5, 2.0, 4.0), trials=4, solvers=("tcf", "ransac"), seed=3)


def read(path, dtype=None):
    return np.genfromtxt(path, delimiter=",", names=True, dtype=dtype, encoding="utf-8")


def assert_same_but_for_times(table, other):
    assert table.dtype.names == other.dtype.names
    for name in table.dtype.names:
        if name.startswith("seconds"):
            assert (table[name] > 0).all()
        elif table.dtype[name].kind == "f":
            assert np.array_equal(table[name], other[name], equal_nan=True), name
        else:
            assert (table[name] == other[name]).all(), name


def test_same_tables_as_the_command(command, tmp_path):
    command(
        *("sweep", "--points", 200, "--outliers", "0.5,0.9", "--sigma", "0.5,2,4", "--trials", 4),
        *("--solver", "tcf,ransac", "--seed", 3, "--out", tmp_path / "cpp"),
    )
    trials, cells, *_ = consimd.sweep(**STUDY, out=tmp_path / "python")
    assert (len(trials), len(cells)) == (48, 12)
    for name, table in (("trials.csv", trials), ("cells.csv", cells)):
        assert_same_but_for_times(table, read(tmp_path / "cpp" / name))
        # Its own file holds the very same numbers, times included.
        own = read(tmp_path / "python" / name)
        assert all((table[field] == own[field]).all() for field in table.dtype.names if field != "inlier_precision")
    assert json.loads((tmp_path / "python/summary.json").read_text())["complete"]


def test_results_do_not_depend_on_threads():
    one, two = (consimd.sweep(**STUDY, threads=threads) for threads in (1, 2))
    assert_same_but_for_times(one.trials, two.trials)
    assert_same_but_for_times(one.cells, two.cells)


def test_columns(capsys):
    trials, cells, *_ = consimd.sweep(points=100, outliers=[0.2], sigma=[1.0], trials=2, solvers="tcf")
    assert trials["solver"].tolist() == ["tcf", "tcf"]
    assert trials["success"].dtype == bool and trials["success"].all()
    assert trials["seed"].tolist() == [1, 2]
    assert cells["recall"][0] == 1 and 0 < cells["recall_low"][0] < 1
    assert cells["rotation_error_deg_mean"][0] == pytest.approx(trials["rotation_error_deg"].mean())
    assert capsys.readouterr().out == ""


def test_every_column_has_a_meaning():
    trials, cells, *_ = consimd.sweep(points=100, outliers=[0.2], sigma=[1.0], trials=1)
    meanings = consimd.table_columns()
    for name, table in (("trials", trials), ("cells", cells)):
        assert tuple(meanings[name]) == table.dtype.names
        assert all(meanings[name].values())


def test_options_are_part_of_a_solvers_name():
    spelt, label = "confidence=none:max_iterations=0300", "max_iterations=300:confidence=none"
    solvers = [f"ransac:{spelt}:local_optimisation=false", "ransac"]
    trials, cells, *_ = consimd.sweep(points=100, outliers=[0.2], sigma=[1.0], trials=1, solvers=solvers)
    assert trials["solver"].tolist() == [f"ransac:{label}:local_optimisation=false", "ransac"]
    assert cells["solver"].tolist() == trials["solver"].tolist()
    with pytest.raises(ValueError, match="solver 'tcf' has no option 'max_nodes', expected one of: confidence"):
        consimd.sweep(solvers="tcf:max_nodes=3")


def test_the_default_noise_levels_are_the_papers():
    trials, *_ = consimd.sweep(points=50, outliers=[0.1], trials=1)
    assert np.array_equal(trials["sigma"], np.round(np.linspace(0.1, 5, 50), 12))


def test_progress_is_told_and_may_stop_the_study(tmp_path):
    told = []
    consimd.sweep(**STUDY, progress=lambda done, total: told.append((done, total)))
    assert told[-1] == (48, 48)

    def stop(done, total):
        raise LookupError("enough")

    long = {**STUDY, "points": 3000, "trials": 20_000, "solvers": "tcf"}
    with pytest.raises(LookupError, match="enough"):
        consimd.sweep(**long, progress=stop, out=tmp_path)
    assert len((tmp_path / "trials.csv").read_text().splitlines()) > 1


def test_a_folder_is_resumed_and_holds_one_study(tmp_path):
    whole = consimd.sweep(**STUDY, out=tmp_path)
    lines = (tmp_path / "trials.csv").read_text().splitlines(keepends=True)
    (tmp_path / "trials.csv").write_text("".join(lines[:20]))
    again = consimd.sweep(**STUDY, out=tmp_path)
    assert_same_but_for_times(again.trials, whole.trials)
    kept = (again.trials["seconds"] == whole.trials["seconds"]).sum()
    assert 19 <= kept < 48
    with pytest.raises(RuntimeError, match="it has trials 4, not 5"):
        consimd.sweep(**{**STUDY, "trials": 5}, out=tmp_path)
    assert len(consimd.sweep(**{**STUDY, "trials": 5}, out=tmp_path, fresh=True).trials) == 60


def test_bad_arguments_are_named():
    for options, message in (
        ({"points": 2}, "points"),
        ({"outliers": [1.0]}, r"outliers: expected a ratio in \[0, 1\), got 1"),
        ({"outliers": []}, "outliers: at least one"),
        ({"sigma": [-1.0]}, "sigma"),
        ({"solvers": "icp"}, "icp"),
        ({"trials": 0}, "trials"),
        ({"threads": 0}, "threads is 0"),
        ({"filter": "x"}, "filter is 'x'"),
    ):
        with pytest.raises(ValueError, match=message):
            consimd.sweep(**{**STUDY, **options})


def test_beyond_the_papers_study(command, tmp_path):
    command(
        *("sweep", "--points", "80,120", "--outliers", 0.5, "--sigma", 0.5, "--trials", 4, "--no-pose", 0.25),
        *("--family", "gaussian,decoy", "--bound-factor", "1,estimated", "--out", tmp_path / "cpp"),
    )
    study = dict(outliers=[0.5], sigma=[0.5], trials=4)
    trials, cells, *_ = consimd.sweep(
        points=(80, 120), family=("gaussian", "decoy"), bound_factor=(1, "estimated"), no_pose=0.25, **study
    )
    assert (len(trials), len(cells)) == (32, 8)
    for name, table in (("trials.csv", trials), ("cells.csv", cells)):
        # NumPy does not guess a column that starts with numbers and has words, and reads 1 as no truth.
        types = [(column, int if kind == bool else kind) for column, (kind, _) in table.dtype.fields.items()]
        assert_same_but_for_times(table, read(tmp_path / "cpp" / name, types))
    meanings = consimd.table_columns()
    assert trials.dtype.names == (*meanings["trial_conditions"], *meanings["trials"])
    assert cells.dtype.names == (*meanings["cell_conditions"], *meanings["cells"])
    assert trials["true_pose"].tolist() == [True, True, True, False] * 8
    assert cells["without_pose"].tolist() == [1] * 8
    # Every value of a keyword may stand alone.
    trials, *_ = consimd.sweep(points=100, scale="unknown", solvers="pcr99", family="planar", bound_factor=2, **study)
    assert trials["scale"].tolist() == ["unknown"] * 4
    for wrong in (dict(family="magic"), dict(scale="guessed"), dict(bound_factor="x"), dict(no_pose=1.0), dict(points=[])):
        with pytest.raises(ValueError, match=next(iter(wrong))):
            consimd.sweep(**study, **wrong)


def test_families():
    families = consimd.synth.problem_families()
    assert next(iter(families)) == "gaussian"
    for family, sentence in families.items():
        problem = consimd.synth.family_problem(family, correspondences=50, outlier_ratio=0.4, sigma=0.5)
        assert len(problem) == 50 and sentence
    paper = consimd.synth.noise_study_problem(correspondences=50, outlier_ratio=0.4, sigma=0.5)
    again = consimd.synth.family_problem("gaussian", correspondences=50, outlier_ratio=0.4, sigma=0.5)
    assert np.array_equal(paper.target, again.target)
    with pytest.raises(ValueError, match="family 'magic': expected one of: gaussian"):
        consimd.synth.family_problem("magic")


def test_wilson_interval():
    low, high = consimd.wilson_interval(8, 10)
    assert (low, high) == (pytest.approx(0.4901625), pytest.approx(0.9433178))
    assert consimd.wilson_interval(0, 0) == (0, 1)
    _, cells, *_ = consimd.sweep(points=100, outliers=[0.9], sigma=[1.0], trials=3)
    successes = round(3 * cells["recall"][0])
    assert consimd.wilson_interval(successes, 3) == (cells["recall_low"][0], cells["recall_high"][0])
    with pytest.raises(ValueError, match="4 successes of 3 trials"):
        consimd.wilson_interval(4, 3)


def test_plots(tmp_path):
    pytest.importorskip("matplotlib")
    _, cells, *_ = consimd.sweep(points=100, outliers=[0.2, 0.5], sigma=[0.5, 1.0], trials=2, family=("gaussian", "decoy"))
    files = consimd.plot_sweep(cells, tmp_path / "new")
    assert [file.name for file in files] == ["recall.svg", "recall.png", "errors.svg", "errors.png"]
    assert "decoy" in files[0].read_text()
    # Of a file that is there.
    assert consimd.plot_sweep(None, tmp_path / "new") == files
    with pytest.raises(RuntimeError, match="not drawn"):
        consimd.plot_sweep(None, tmp_path / "empty")
