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
    runs, tables, *compared = consimd.compare(**SMALL, out=tmp_path / "python")
    assert len(runs) == 8
    assert_holds(runs, rows(tmp_path / "cpp/runs.csv"), times=False)
    assert_holds(runs, rows(tmp_path / "python/runs.csv"), times=True)
    for table, name in zip(compared, ("pairs", "solvers", "curves"), strict=True):
        assert list(consimd.table_columns()["group_" + name]) == list(table.dtype.names)
        assert len(table) == len(rows(tmp_path / f"cpp/{name}.csv")) > 0
        for row, line in zip(table, rows(tmp_path / f"python/{name}.csv"), strict=True):
            for column in table.dtype.names:
                text = table.dtype[column].kind == "U"
                assert row[column] == line[column] if text else np.array_equal(row[column], float(line[column]), equal_nan=True)
    options = [json.loads((tmp_path / which / "comparison.json").read_text())["options"] for which in ("cpp", "python")]
    assert options[0] == options[1]
    assert list(tables) == ["solvers", "pairs", "quantiles"]
    assert tables["solvers"].markdown in (tmp_path / "python/tables.md").read_text()


def test_tables_are_text_for_people():
    _, tables, *_ = consimd.compare(synthetic="facade", tables=["stages", "solvers"], trials=1, solvers="tcf")
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
    runs, *_ = consimd.compare(tmp_path / "mine", solvers="tcf", seeds=3)
    assert runs["group"].tolist() == ["mine"] * 3
    assert runs["seed"].tolist() == [1, 2, 3]
    assert runs["success"].dtype == bool and runs["success"].all()
    (tmp_path / "mine/a/pose.txt").write_text("1 0 0 0\n")
    with pytest.raises(RuntimeError, match="pose.txt: expected 3 or 4 rows, got 1"):
        consimd.compare(tmp_path / "mine", solvers="tcf")


def test_a_folder_is_resumed_and_holds_one_comparison(tmp_path):
    whole, *_ = consimd.compare(**SMALL, out=tmp_path)
    lines = (tmp_path / "runs.csv").read_text().splitlines(keepends=True)
    (tmp_path / "runs.csv").write_text("".join(lines[:4]))
    told = []
    again, *_ = consimd.compare(**SMALL, out=tmp_path, progress=lambda done, total: told.append((done, total)))
    assert told[0][0] >= 3 and told[-1] == (8, 8)
    assert (again["seconds"] == whole["seconds"]).sum() >= 3
    with pytest.raises(RuntimeError, match="it has seed 1, not 2"):
        consimd.compare(**SMALL, seed=2, out=tmp_path)
    assert consimd.compare(**SMALL, seed=2, out=tmp_path, fresh=True).runs["seed"].min() == 2


def room(seed, angle, shift):
    """A scan of a room with boxes, from a place of its own, and the pose from the scanner to the room."""
    draw, fixed = np.random.default_rng(seed), np.random.default_rng(1)
    corners, sizes = fixed.uniform([-4, -4, 0], [4, 4, 0.01], (12, 3)), fixed.uniform(0.4, 1.8, (12, 3))
    walls = draw.uniform([-5, -5, 0], [5, 5, 3], (3, 1500, 3))
    for axis, value in enumerate((5, 5, 0)):
        walls[axis, :, axis] = value
    share = draw.uniform(size=(12, 300, 3))
    share[np.arange(12)[:, None], np.arange(300), draw.integers(3, size=(12, 300))] = 1
    points = np.concatenate([walls.reshape(-1, 3), (corners[:, None] + share * sizes[:, None]).reshape(-1, 3)])
    points += draw.uniform(-0.01, 0.01, points.shape)
    pose = np.eye(4)
    pose[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    pose[:3, 3] = shift
    return (points - pose[:3, 3]) @ pose[:3, :3], pose


def scans(folder):
    """A pair of them in the layout pairs."""
    folder.mkdir()
    (source, of_source), (target, of_target) = room(1, 0.3, (1, 0.5, 1.5)), room(2, 0, (-1, 0, 1.5))
    np.save(folder / "a.npy", source)
    np.save(folder / "b.npy", target)
    pose = " ".join(map(repr, (np.linalg.inv(of_target) @ of_source).ravel().tolist()))
    (folder / "pairs.csv").write_text(f"source,target,pose\na.npy,b.npy,{pose}\n")


def test_scans_are_those_of_the_command(command, tmp_path):
    scans(tmp_path / "mine")
    command(
        *("compare", "--scans", tmp_path / "mine", "--layout", "pairs", "--voxel", 0.25, "--keypoints", "iss:2000"),
        *("--matches", "mutual:2", "--table", "data,solvers,pipeline", "--solver", "tcf", "--thresholds", "5,0.5"),
        *("--out", tmp_path / "cpp"),
    )
    told = []
    runs, tables, *_ = consimd.compare(
        scans=tmp_path / "mine", layout="pairs", front_end={"voxel": 0.25, "keypoints": 2000, "iss": True, "best": 2},
        tables=["data", "solvers", "pipeline"], solvers="tcf", thresholds="5,0.5", out=tmp_path / "python",
        progress=lambda done, total: told.append((done, total)),
    )  # fmt: skip
    assert told[-1] == (3, 3)
    assert_holds(runs, rows(tmp_path / "cpp/runs.csv"), times=False)
    assert runs["method"].tolist() == ["1R", "tcf", "scans+tcf"]
    assert list(tables) == ["data", "solvers", "pipeline"]
    options = [json.loads((tmp_path / which / "comparison.json").read_text())["options"] for which in ("cpp", "python")]
    assert options[0] == options[1]
    kept = "correspondences/mine_a-b/correspondences.txt"
    assert (tmp_path / "cpp" / kept).read_bytes() == (tmp_path / "python" / kept).read_bytes()


def test_bad_scans_are_named(tmp_path):
    scans(tmp_path / "mine")
    mine = {"scans": tmp_path / "mine", "layout": "pairs", "solvers": "tcf"}
    for options, error, message in (
        ({"layout": "moon"}, ValueError, "layout: 'moon' is none of"),
        ({"layout": None}, ValueError, "layout: of scans it is needed"),
        ({"distance": 3}, ValueError, "distance: it is for the layout kitti"),
        ({"overlap": (0.1, 0.3)}, ValueError, "overlap: it is for the layout 3dmatch"),
        ({"pairs": 0}, ValueError, "pairs: expected at least 1"),
        ({"front_end": {"voxels": 1}}, TypeError, "voxels"),
        ({"front_end": {"seed": 1}}, TypeError, "front_end: seed is no option of it"),
        ({"front_end": {"voxel": -1.0}}, ValueError, "voxel: expected a length above 0"),
        ({"front_end": {"voxel": "wide"}}, TypeError, "voxel: .wide. is of the wrong type"),
        ({"sequences": "other"}, RuntimeError, "has no sequence, scene or group 'other'"),
        ({"scans": None}, ValueError, "layout: it is for scans, which are not given"),
    ):
        with pytest.raises(error, match=message):
            consimd.compare(**{**mine, **options})
    (tmp_path / "mine/b.npy").unlink()
    with pytest.raises(RuntimeError, match="b.npy: is missing"):
        consimd.compare(**mine)


def test_progress_may_stop_the_comparison(tmp_path):
    def stop(done, total):
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        consimd.compare(synthetic="noise", trials=100_000, solvers="tcf", out=tmp_path, progress=stop)
    assert len((tmp_path / "runs.csv").read_text().splitlines()) > 1


def test_every_column_has_a_meaning():
    runs, *_ = consimd.compare(synthetic="facade", trials=1, solvers="tcf")
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
        ({"filter": "tcf", "tables": "boost"}, "filter: it is for the tables solvers"),
        ({"tables": "scales", "solvers": "tcf"}, "needs a known scale"),
        ({"threads": 0}, "threads is 0"),
    ):
        with pytest.raises(ValueError, match=message):
            consimd.compare(**{**SMALL, **options})
    with pytest.raises(RuntimeError, match="cannot read"):
        consimd.compare(tmp_path / "nothing")
