"""consimd.compare: the runs and tables of the C++ command."""

import csv
import json

import numpy as np
import pytest

import consimd

SMALL = dict(synthetic=["facade", "noise"], trials=2, points=200, outliers=[0.5], sigma=[1.0], solvers=["tcf", "ransac"])


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def assert_holds(runs, lines, times):
    """The structured array has what the file's rows say; `times`: the same seconds too."""
    assert len(runs) == len(lines)
    assert runs.dtype.names == tuple(lines[0])
    for run, line in zip(runs, lines):
        for name in runs.dtype.names:
            if runs.dtype[name].kind == "U":
                assert run[name] == line[name]
            elif name == "seconds" and not times:
                assert run[name] > 0
            else:
                assert np.array_equal(run[name], float(line[name]), equal_nan=True), name


def test_same_runs_as_the_command(command, tmp_path):
    command(
        *("compare", "--synthetic", "facade,noise", "--trials", 2, "--points", 200, "--outliers", 0.5, "--sigma", 1),
        *("--solver", "tcf,ransac", "--out", tmp_path / "cpp"),
    )
    runs, tables = consimd.compare(**SMALL, out=tmp_path / "python")
    assert len(runs) == 8
    assert_holds(runs, rows(tmp_path / "cpp/runs.csv"), times=False)
    assert_holds(runs, rows(tmp_path / "python/runs.csv"), times=True)
    options = [json.loads((tmp_path / which / "comparison.json").read_text())["options"] for which in ("cpp", "python")]
    assert options[0] == options[1]
    assert list(tables) == ["solvers"]
    assert tables["solvers"].markdown in (tmp_path / "python/tables.md").read_text()


def test_tables_are_text_for_people():
    _, tables = consimd.compare(synthetic="facade", tables=["stages", "solvers"], trials=1, solvers="tcf")
    assert list(tables) == ["solvers", "stages"]
    table = tables["solvers"]
    assert "recall %" in table.columns
    assert len(table.rows) == 1 and len(table.rows[0]) == len(table.columns)
    assert table.title in table.markdown and all(line in table.markdown for line in table.caption)


def test_files_are_cases(tmp_path):
    problem = consimd.synth.noise_study_problem(200, outlier_ratio=0.5, sigma=0.1)
    consimd.synth.write_problem(problem, tmp_path / "mine/a")
    case = {"noise_bound": 0.3, "max_rotation_error_deg": 1, "max_translation_error_m": 0.5}
    (tmp_path / "mine/a/case.json").write_text(json.dumps(case))
    runs, _ = consimd.compare(tmp_path / "mine", solvers="tcf", seeds=3)
    assert runs["group"].tolist() == ["mine"] * 3
    assert runs["seed"].tolist() == [1, 2, 3]
    assert runs["success"].dtype == bool and runs["success"].all()
    (tmp_path / "mine/a/pose.txt").write_text("1 0 0 0\n")
    with pytest.raises(RuntimeError, match="pose.txt: expected 3 or 4 rows, got 1"):
        consimd.compare(tmp_path / "mine", solvers="tcf")


def test_a_folder_is_resumed_and_holds_one_comparison(tmp_path):
    whole, _ = consimd.compare(**SMALL, out=tmp_path)
    lines = (tmp_path / "runs.csv").read_text().splitlines(keepends=True)
    (tmp_path / "runs.csv").write_text("".join(lines[:4]))
    told = []
    again, _ = consimd.compare(**SMALL, out=tmp_path, progress=lambda done, total: told.append((done, total)))
    assert told[0][0] >= 3 and told[-1] == (8, 8)
    assert (again["seconds"] == whole["seconds"]).sum() >= 3
    with pytest.raises(RuntimeError, match="it has seed 1, not 2"):
        consimd.compare(**SMALL, seed=2, out=tmp_path)
    assert consimd.compare(**SMALL, seed=2, out=tmp_path, fresh=True).runs["seed"].min() == 2


def test_progress_may_stop_the_comparison(tmp_path):
    def stop(done, total):
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        consimd.compare(synthetic="noise", trials=100_000, solvers="tcf", out=tmp_path, progress=stop)
    assert len((tmp_path / "runs.csv").read_text().splitlines()) > 1


def test_every_column_has_a_meaning():
    runs, _ = consimd.compare(synthetic="facade", trials=1, solvers="tcf")
    meanings = consimd.table_columns()["runs"]
    assert tuple(meanings) == runs.dtype.names
    assert all(meanings.values())


def test_bad_arguments_are_named(tmp_path):
    for options, message in (
        ({"synthetic": "moon"}, "moon"),
        ({"trials": 0}, "trials: expected at least 1"),
        ({"seeds": 0}, "seeds: expected at least 1"),
        ({"outliers": [1.0]}, "outliers: expected a ratio"),
        ({"outliers": []}, "outliers"),
        ({"sigma": [-1.0]}, "sigma"),
        ({"solvers": "icp"}, "icp"),
        ({"solvers": []}, "solver: at least one"),
        ({"tables": "magic"}, "unknown table 'magic'"),
        ({"thresholds": "magic"}, "unknown thresholds 'magic'"),
        ({"filter": "x"}, "filter is 'x'"),
        ({"filter": "tcf", "tables": "boost"}, "filter: it is for the table solvers"),
        ({"tables": "scales", "solvers": "tcf"}, "needs a known scale"),
        ({"threads": 0}, "threads is 0"),
    ):
        with pytest.raises(ValueError, match=message):
            consimd.compare(**{**SMALL, **options})
    with pytest.raises(RuntimeError, match="cannot read"):
        consimd.compare(tmp_path / "nothing")
