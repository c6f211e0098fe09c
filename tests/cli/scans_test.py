"""consimd compare --scans: data sets of scans in their layouts, and shards of comparisons."""

import csv
import json
import math
import os
import pathlib
import random
import re
import shutil
import signal
import struct
import time
import unittest

from command import PLOTTER, CommandTest

DATA = os.environ.get("CONSIMD_TEST_DATA")
# How KITTI's cameras look: x to the right, y down, z ahead; the scanner is above and behind.
CAMERA = [[0, -1, 0, 0], [0, 0, -1, -0.08], [1, 0, 0, -0.27], [0, 0, 0, 1]]


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(4)) for j in range(4)] for i in range(4)]


def inverse(pose):
    turned = [[pose[j][i] for j in range(3)] for i in range(3)]
    back = [-sum(turned[i][k] * pose[k][3] for k in range(3)) for i in range(3)]
    return [[*turned[i], back[i]] for i in range(3)] + [[0, 0, 0, 1]]


def place(frame):
    """Where the scanner was: three metres from one frame to the next."""
    c, s = math.cos(0.05 * frame), math.sin(0.05 * frame)
    return [[c, -s, 0, 3 * frame - 3], [s, c, 0, 0.2 * frame], [0, 0, 1, 1.5], [0, 0, 0, 1]]


def room(seed, scanner, count=6000):
    """Points of a room with boxes in which no two corners are alike, as the scanner sees them."""
    draw, boxes = random.Random(seed), random.Random(1)
    corners = [[boxes.uniform(-4, 4), boxes.uniform(-4, 4), 0] for _ in range(12)]
    sizes = [[boxes.uniform(0.3, 1.2), boxes.uniform(0.3, 1.2), boxes.uniform(0.5, 2)] for _ in range(12)]
    world = inverse(scanner)
    points = []
    for _ in range(count):
        u, v, kind = draw.random(), draw.random(), draw.randrange(5)
        if kind == 0:
            p = [10 * u - 5, 10 * v - 5, 0]
        elif kind == 1:
            p = [5, 10 * u - 5, 3 * v]
        elif kind == 2:
            p = [4 * u - 4, 5, 3 * v]
        else:
            box, side = draw.randrange(12), draw.randrange(3)
            share = [u, v, u]
            share[side], share[(side + 1) % 3], share[(side + 2) % 3] = 1, u, v
            p = [corners[box][c] + sizes[box][c] * share[c] for c in range(3)]
        p = [x + draw.uniform(-0.01, 0.01) for x in p] + [1]
        points.append([sum(world[i][k] * p[k] for k in range(4)) for i in range(3)])
    return points


def numbers(pose, rows=3):
    return " ".join(f"{x:.15g}" for row in pose[:rows] for x in row)


class Scans(CommandTest):
    def rows(self, name):
        with open(self.folder / name, newline="") as file:
            return list(csv.DictReader(file))

    def timeless(self, name):
        return [{key: value for key, value in row.items() if key != "seconds"} for row in self.rows(name)]

    def kitti(self, root, frames, sequence="03"):
        """frames: paths or points, with the scanner's pose in the world, by their numbers."""
        folder = self.folder / root / "sequences" / sequence
        (folder / "velodyne").mkdir(parents=True)
        (self.folder / root / "poses").mkdir(exist_ok=True)
        (folder / "calib.txt").write_text(f"P0: {numbers(place(0))}\nTr: {numbers(CAMERA)}\n")
        poses = []
        for frame in range(max(frames) + 1):
            scan, pose = frames.get(frame, (None, place(0)))
            poses.append(numbers(product(pose, inverse(CAMERA))))
            file = folder / f"velodyne/{frame:06}.bin"
            if isinstance(scan, pathlib.Path):
                file.symlink_to(scan)
            elif scan is not None:
                file.write_bytes(b"".join(struct.pack("<4f", *p, 0.5) for p in scan))
        (self.folder / f"{root}/poses/{sequence}.txt").write_text("\n".join(poses) + "\n")

    def small_kitti(self):
        self.kitti("k", {frame: (room(10 + frame, place(frame)), place(frame)) for frame in range(3)})
        return ["compare", "--scans", "k", "--layout", "kitti", "--distance", 3, "--voxel", 0.25]

    def test_kitti(self):
        compare = self.small_kitti()
        tables = ["--table", "data,solvers,pipeline", "--solver", "tcf,ransac", "--out", "c"]
        out = self.run_command(*compare, *tables)
        self.assertIn("Success (thresholds `case`): KITTI 03: 5 deg, 1 m.", out)
        self.assertIn("scans of KITTI odometry, drawn at 3 m by seed 1", out)
        self.assertIn("\nsequence 03 has 2 pairs at 3 m, not 200\n", out)
        self.assertEqual([row["case"] for row in self.rows("c/runs.csv")][::5], ["000001-000000", "000002-000001"])
        (data,) = self.rows("c/table_data.csv")
        self.assertEqual((data["cases"], data["distance m"]), ("2", "3.01"))
        self.assertEqual([row["solver"] for row in self.rows("c/table_pipeline.csv")], ["tcf", "ransac"])
        found = self.rows("c/table_solvers.csv")[0]
        self.assertEqual((found["recall %"], found["95 % interval"]), ("100.0", "34.2 - 100.0"))
        # The correspondences are kept, and serve as cases.
        kept = self.run_command("compare", "--cases", "c/correspondences", "--solver", "tcf", "--thresholds", "1e-9,1e-9",
                                "--out", "d")  # fmt: skip
        self.assertIn("1e-09 deg, 1e-09 m", kept)
        keys = ("case", "rotation_error_deg", "inliers", "kept")
        of = lambda name: [[row[key] for key in keys] for row in self.rows(name) if row["method"] == "tcf"]
        for one, other in zip(of("d/runs.csv"), of("c/runs.csv"), strict=True):
            self.assertEqual((one[0], one[2:]), ("KITTI_03_" + other[0], other[2:]))
            self.assertAlmostEqual(float(one[1]), float(other[1]), places=9)  # the pose went through a file
        self.assertEqual({row["success"] for row in self.rows("d/runs.csv")}, {"0"})

    @unittest.skipIf(PLOTTER is None, "no Python with matplotlib")
    def test_figure(self):
        self.draw_for_real()
        tables = ["--table", "solvers,pipeline", "--solver", "tcf,ransac", "--out", "c"]
        self.assertIn("figure: c/comparison.svg (and .png)", self.run_command(*self.small_kitti(), *tables))
        drawn = (self.folder / "c/comparison.svg").read_text()
        # Two of two: 34.2 to 100 %. Both solvers, from correspondences and from the scans, on the one group.
        self.assertEqual(drawn.count("<!-- 100 % -->"), 4)
        for text in ("recall (%) with its 95 % interval (Wilson)", "KITTI 03", "scans+tcf", "scans+ransac",
                     "tcf − scans+tcf"):  # fmt: skip
            self.assertIn(text, drawn)
        self.assertTrue((self.folder / "c/comparison.png").read_bytes().startswith(b"\x89PNG"))

    def test_same_results_for_any_threads(self):
        compare = [*self.small_kitti(), "--table", "solvers,pipeline", "--solver", "tcf"]
        for threads in (1, 3):
            self.run_command(*compare, "--threads", threads, "--out", f"t{threads}")
        self.assertEqual(self.timeless("t1/runs.csv"), self.timeless("t3/runs.csv"))

    def test_a_killed_comparison_resumes(self):
        compare = [*self.small_kitti(), "--table", "solvers,pipeline", "--solver", "tcf,ransac", "--seeds", 20]
        self.run_command(*compare, "--out", "whole")
        for number in (signal.SIGKILL, signal.SIGINT):
            process = self.start(*compare, "--out", "c")
            runs = self.folder / "c/runs.csv"
            had = runs.read_bytes().count(b"\n") if runs.exists() else 0
            while not (runs.exists() and runs.read_bytes().count(b"\n") > had + 5):
                self.assertIsNone(process.poll(), "ended before it could be stopped")
                time.sleep(0.002)
            process.send_signal(number)
            _, err = process.communicate(timeout=60)
            self.assertEqual(process.returncode, 130 if number == signal.SIGINT else -number, err)
        self.assertRegex(err, r"stopped after \d+ of 160 runs; the same command resumes")
        self.assertRegex(self.run_command(*compare, "--out", "c"), r", [1-9]\d* done before")
        self.assertEqual(self.timeless("c/runs.csv"), self.timeless("whole/runs.csv"))
        self.assert_error(*compare[:-4], "--out", "c", says="holds another comparison")

    def test_a_changed_option_or_scan_does_not_mix(self):
        compare = [*self.small_kitti(), "--solver", "tcf"]
        self.run_command(*compare, "--out", "c")
        for option, value, says in (("--keypoints", "random:900", "keypoints 5000, not 900"),
                                    ("--matches", "mutual:2", "matches mutual 3, not mutual 2"),
                                    ("--noise-bound", 0.5, "noise_bound from the resolution, not 0.5"),
                                    ("--pairs", 1, "pairs the layout's, not 1"),
                                    ("--seed", 2, "seed 1, not 2")):  # fmt: skip
            self.assert_error(*compare, option, value, "--out", "c", says=f"c holds another comparison: it has {says}")
        scan = self.folder / "k/sequences/03/velodyne/000000.bin"
        scan.write_bytes(scan.read_bytes()[16:])
        self.assert_error(*compare, "--out", "c", says="case 000001-000000 of KITTI 03 has changed")
        before = self.timeless("c/runs.csv")
        self.run_command(*compare, "--out", "c", "--fresh")
        self.assertNotEqual(self.timeless("c/runs.csv"), before)

    def test_shards_merged_equal_the_whole(self):
        compare = [*self.small_kitti(), "--table", "data,solvers,pipeline", "--solver", "tcf", "--threads", 1]
        self.run_command(*compare, "--out", "whole")
        for index in (1, 2):
            self.assert_error("merge", "s", says="s: " if index == 1 else "missing: 2/2")
            out = self.run_command(*compare, "--out", "s", "--shard", f"{index}/2")
            self.assertIn(f"3 runs of shard {index}/2 on 1 group of cases", out)
            self.assertIn(f"shard {index}/2 is complete; when all are: consimd merge s\n", out)
        self.assert_error(*compare, "--out", "s/shard-1-of-2", says="it is shard 1/2, not the whole comparison")
        self.assert_error(*compare, "--out", "s", "--shard", "3/2", says="--shard")
        shutil.rmtree(self.folder / "k")
        out = self.run_command("merge", "s", "--out", "m")
        self.assertIn("6 runs, merged from 2 shards, writing to m\n", out)
        self.assertIn("### From scans to a verified pose", out)
        self.assertEqual(self.timeless("m/runs.csv"), self.timeless("whole/runs.csv"))
        for name in ("table_data.csv", "comparison.json"):
            self.assertEqual((self.folder / "m" / name).read_bytes(), (self.folder / "whole" / name).read_bytes())
        without_times = lambda text: re.sub(r" +[\d.]+ \|\n", "|\n", text)
        texts = [without_times((self.folder / name / "tables.md").read_text()) for name in ("m", "whole")]
        self.assertEqual(*[re.sub(r"-+:?\|\n|time ms", "", text).replace(" ", "") for text in texts])
        self.run_command("merge", "s")  # into the folder that holds them
        self.assertEqual(self.timeless("s/runs.csv"), self.timeless("whole/runs.csv"))
        self.assert_error("merge", "s", "--map", says="--map: it is for shards of 'consimd sweep'")

    def test_shards_of_stand_ins(self):
        compare = ["compare", "--synthetic", "facade,noise", "--trials", 3, "--points", 200, "--solver", "tcf",
                   "--outliers", 0.5, "--sigma", 1, "--table", "solvers,iterations,scales", "--iterations", "10,100",
                   "--iteration-problems", 3, "--scales", "0.5,2"]  # fmt: skip
        compare[compare.index("tcf")] = "tcf,pcr99"
        self.run_command(*compare, "--out", "whole")
        for index in (1, 2, 3):
            self.run_command(*compare, "--out", "s", "--shard", f"{index}/3")
        self.run_command("merge", "s")
        self.assertEqual(self.timeless("s/runs.csv"), self.timeless("whole/runs.csv"))
        for name in ("pairs.csv", "solvers.csv", "curves.csv"):
            mine, wanted = (
                [{key: value for key, value in row.items() if not key.startswith(("time_", "seconds"))}
                 for row in self.rows(f"{folder}/{name}")] for folder in ("s", "whole"))  # fmt: skip
            self.assertEqual(mine, wanted, name)
        self.assertEqual({row["group"] for row in self.rows("s/pairs.csv")},
                         {"facade", "noise 50 %", "2 % inliers", "all groups"})  # scales has one solver
        self.assertEqual(self.rows("s/table_iterations.csv")[0]["recall %"],
                         self.rows("whole/table_iterations.csv")[0]["recall %"])  # fmt: skip

    def test_bad_options(self):
        compare = self.small_kitti()
        out = ["--solver", "tcf", "--out", "c"]
        for options, says in (
            (["--scans", "none", "--layout", "kitti"], "none: no such folder"),
            (["--scans", "k"], "layout: of scans it is needed: one of kitti, eth, 3dmatch, pairs"),
            (["--scans", "k", "--layout", "moon"], "layout: 'moon' is none of kitti"),
            (["--scans", "k", "--layout", "eth"], "k: holds no scene"),
            (["--layout", "kitti"], "--layout: it is for --scans, which is not given"),
            (["--voxel", 0.3], "--voxel: it is for --scans, which is not given"),
            (["--synthetic", "facade", "--table", "pipeline"], "table pipeline: it is made of scans"),
            (["--synthetic", "facade", "--thresholds", "3dmatch-rmse"], "3dmatch-rmse needs the gt.info"),
        ):
            self.assert_error("compare", *options, *out, says=says)
        for options, says in (
            (["--sequences", "04"], "k: has no sequence, scene or group '04'"),
            (["--pairs", 0], "--pairs"),
            (["--overlap", "0.1:0.3"], "overlap: it is for the layout 3dmatch, not kitti"),
            (["--overlap", "0.1"], "--overlap: expected LEAST:MOST, as 0.1:0.3, got '0.1'"),
            (["--skip-consecutive"], "skip consecutive: it is for the layout 3dmatch"),
            (["--keypoints", "many"], "--keypoints: expected all"),
            (["--matches", "x"], "--matches: expected mutual:K"),
            (["--noise-bound", 0], "noise bound: expected a length above 0, got 0"),
            (["--thresholds", "5"], "unknown thresholds '5'"),
            (["--thresholds", "5,-1"], "unknown thresholds '5,-1'"),
            (["--pair-list", "none.txt"], "distance: a pair list tells which pairs there are"),
        ):
            self.assert_error(*compare, *out, *options, says=says)
        self.assert_error(*compare[:-4], *out, "--pair-list", "none.txt", says="none.txt: cannot")
        self.assert_error(*compare[:-4], *out, says="no two of its 3 scans are 17 m apart, within a tenth; they are 3.0 to")
        self.assert_error(*compare, *out, "--table", "pipeline", "--solver", "mine=exec:true", says="mine")
        process = self.start(*compare[:-1], 100, *out)  # a voxel larger than the scans
        _, err = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 2)
        self.assertRegex(err, r"000001\.bin and k/.*/000000\.bin: voxel is 100, expected a length above 0 and below")

    def test_missing_and_damaged_files_are_named(self):
        compare = [*self.small_kitti(), "--solver", "tcf", "--out", "c"]
        listed = [option for option in compare if option not in ("--distance", 3)] + ["--pair-list", "list.txt"]
        self.write("list.txt", "03 1 0\n03 2 0\n")
        folder = self.folder / "k/sequences/03"
        scan = folder / "velodyne/000002.bin"
        whole = scan.read_bytes()
        scan.write_bytes(whole[:-3])
        self.assert_error(*compare, says="k/sequences/03/velodyne/000002.bin: ")
        scan.write_bytes(b"")
        self.assert_error(*compare, says="k/sequences/03/velodyne/000002.bin: ")
        scan.unlink()
        self.assert_error(*listed, says="list.txt:2: k/sequences/03/velodyne/000002.bin: is missing")
        scan.write_bytes(whole)
        for name, says in (("sequences/03/calib.txt", "calib.txt: is missing"), ("poses/03.txt", "poses/03.txt: is missing")):
            file = self.folder / "k" / name
            text = file.read_text()
            file.unlink()
            self.assert_error(*compare, says=says)
            file.write_text("1 2 3\n")
            self.assert_error(*compare, says=name)
            file.write_text(text)
        self.run_command(*listed)

    @unittest.skipUnless(DATA and (pathlib.Path(DATA) / "scans/pairs.json").exists(), "CONSIMD_TEST_DATA has no scans")
    def test_real_scans_in_every_layout(self):
        data = pathlib.Path(DATA).resolve() / "scans"
        pairs = {pair["name"]: pair for pair in json.loads((data / "pairs.json").read_text())}
        pose = lambda name: pairs[name]["T_target_source"]
        frames = {0: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
                  20: pose("kitti_00_20_0"), 30: pose("kitti_00_30_0")}  # fmt: skip
        self.kitti("kitti", {n: (data / f"kitti00_{n:06}.bin", T) for n, T in frames.items()}, "00")

        scene = self.folder / "3dmatch/redkitchen"
        scene.mkdir(parents=True)
        log = info = ""
        for number in (0, 1, 5):
            (scene / f"cloud_bin_{number}.ply").symlink_to(data / f"redkitchen_{number}.ply")
        for target, source in ((0, 1), (0, 5), (1, 5)):
            matrix = pose(f"3dmatch_redkitchen_{source}_{target}")
            log += f"{target}\t{source}\t3\n" + "".join(numbers([row], 1) + "\n" for row in matrix)
            info += f"{target}\t{source}\t3\n"
            info += "".join(" ".join(str(1000 * (i == j)) for j in range(6)) + "\n" for i in range(6))
        (scene / "gt.log").write_text(log)
        (scene / "gt.info").write_text(info)

        # Scans of others in ETH's form.
        hall = self.folder / "eth/park"
        hall.mkdir(parents=True)
        for end in ("source", "target"):
            (hall / f"{end}.ply").symlink_to(data / f"smallgicp_{end}.ply")
        (hall / "source-target.pose").write_text("".join(numbers([row], 1) + "\n" for row in pose("smallgicp")))

        lines = ["source,target,pose,name"]
        for name in ("3dmatch_redkitchen_1_0", "smallgicp"):
            pair = pairs[name]
            lines.append(f"{data / pair['source']},{data / pair['target']},{numbers(pose(name), 4)},{name}")
        self.write("mine.csv", "\n".join(lines) + "\n")

        tcf = ["--solver", "tcf", "--table", "solvers,pipeline"]
        for arguments, count in ((["kitti", "kitti"], 1), (["3dmatch", "3dmatch"], 3), (["eth", "eth", "--voxel", 0.3], 1),
                                 (["mine.csv", "pairs"], 2)):  # fmt: skip
            folder, layout, *more = arguments
            self.run_command("compare", "--scans", folder, "--layout", layout, *more, *tcf, "--out", f"c-{layout}")
            runs = self.rows(f"c-{layout}/runs.csv")
            self.assertEqual(len(runs), 2 * count, layout)
            for run in runs:
                if run["method"] == "scans+tcf":
                    self.assertEqual((run["success"], run["status"]), ("1", "success"), run)
        out = self.run_command("compare", "--scans", "3dmatch", "--layout", "3dmatch", "--solver", "tcf", "--thresholds",
                               "3dmatch-rmse", "--out", "rmse")  # fmt: skip
        self.assertIn("RMSE of the overlap's points at most 0.2 m", out)
        self.assertEqual({run["success"] for run in self.rows("rmse/runs.csv")}, {"1"})


if __name__ == "__main__":
    unittest.main()
