"""consimd register."""

import json
import math
import random
import subprocess
import unittest

from command import CONSIMD, CommandTest


def without_times(result):
    """The JSON of a registration without what may differ between equal results."""
    del result["isa"], result["threads"]
    for run in result["runs"]:
        del run["seconds"]
        for stage in run["stages"]:
            del stage["seconds"]
    return json.dumps(result)


class Register(CommandTest):
    def problem(self):
        self.run_command("generate", "--points", 400, "--outliers", 0.8, "--sigma", 0.1, "--out", "p")
        return "p/correspondences.txt"

    def json(self, *arguments, code=0, **environment):
        return json.loads(self.run_command("register", *arguments, "--json", "-", code=code, **environment))

    def test_filter(self):
        file = self.problem()
        result = self.json(file, "--noise-bound", 0.3, "--solver", "ransac", "--filter", "tcf")
        self.assertEqual((result["solver"], result["filter"]), ("ransac", "tcf"))
        stages = result["runs"][0]["stages"]
        self.assertEqual([stages[k]["name"] for k in (0, 1, -1)], ["filter_one_point", "filter_two_point", "all_rows"])
        self.assertEqual(result["runs"][0]["status"], "success")
        text = self.run_command("register", file, "--noise-bound", 0.3, "--filter", "tcf")
        self.assertIn("tcf after filter tcf", text)
        self.assertNotIn("filter", self.json(file, "--noise-bound", 0.3, "--filter", "none"))
        self.assert_error("register", file, "--noise-bound", 1, "--filter", "magic", says="expected one of: none, tcf")

    def test_scale(self):
        self.run_command("generate", "--points", 600, "--outliers", 0.9, "--sigma", 0.1, "--scale", 0.5, "--out", "s")
        file = "s/correspondences.txt"
        for solver in ("pcr99", "teaser"):
            result = self.json(file, "--noise-bound", 0.3, "--solver", solver, "--estimate-scale", "--truth", "s/pose.txt")
            self.assertIs(result["estimate_scale"], True)
            (run,) = result["runs"]
            self.assertEqual(run["status"], "success")
            self.assertAlmostEqual(run["scale"], 0.5, delta=0.005)
            self.assertLess(run["scale_error"], 0.01)
            self.assertAlmostEqual(run["scale_error"], abs(run["scale"] / 0.5 - 1), delta=1e-9)
            self.assertGreater(run["scale_deviation"], 0)
            self.assertLess(run["rotation_error_deg"], 0.1)
            self.assertLess(run["translation_error"], 0.2)
            text = self.run_command("register", file, "--noise-bound", 0.3, "--solver", solver, "--estimate-scale")
            self.assertRegex(text, r"\nscale +0\.\d+ \+- ")
        known = self.json(self.problem(), "--noise-bound", 0.3, "--solver", "pcr99")
        self.assertNotIn("estimate_scale", known)
        self.assertNotIn("scale", known["runs"][0])
        self.assert_error("register", file, "--noise-bound", 0.3, "--estimate-scale", says="'tcf' needs a known scale")
        self.assert_error("register", file, "--solver", "pcr99", "--estimate-scale", says="needs a noise_bound")
        self.assert_error(
            "register", file, "--noise-bound", 0.3, "--truth", "s/pose.txt", says="not a rotation"
        )
        self.assert_error("generate", "--scale", 0, "--out", "z", says="--scale: expected a finite number > 0, got 0")

    def test_json(self):
        file = self.problem()
        result = self.json(
            file, "--noise-bound", 0.3, "--repeat", 3, "--seed", 7, "--threads", 2, "--truth", "p/pose.txt"
        )
        self.assertEqual(
            list(result), ["file", "correspondences", "isa", "threads", "solver", "noise_bound", "runs"]
        )
        self.assertEqual((result["file"], result["correspondences"], result["threads"]), (file, 400, 2))
        self.assertEqual((result["solver"], result["noise_bound"]), ("tcf", 0.3))
        self.assertEqual([run["seed"] for run in result["runs"]], [7, 8, 9])
        for run in result["runs"]:
            self.assertEqual(
                list(run),
                ["seed", "status", "noise_bound", "log10_false_poses", "T_target_source", "covariance", "inlier_count",
                 "inliers", "seconds", "stopped", "stages", "rotation_error_deg", "translation_error"],
            )
            self.assertEqual(run["status"], "success")
            self.assertEqual(run["noise_bound"], 0.3)
            self.assertLess(run["log10_false_poses"], -3)
            self.assertEqual([len(row) for row in run["T_target_source"]], [4] * 4)
            self.assertEqual(run["T_target_source"][3], [0, 0, 0, 1])
            covariance = run["covariance"]
            self.assertEqual([len(row) for row in covariance], [6] * 6)
            self.assertEqual(covariance, [list(column) for column in zip(*covariance)])
            deviations = [math.sqrt(covariance[k][k]) for k in range(6)]
            self.assertLess(run["rotation_error_deg"], 4 * math.degrees(math.hypot(*deviations[:3])))
            self.assertLess(run["translation_error"], 4 * math.hypot(*deviations[3:]))
            self.assertLess(math.degrees(max(deviations[:3])), 0.1)
            self.assertLess(max(deviations[3:]), 0.1)
            self.assertEqual(run["inlier_count"], len(run["inliers"]))
            self.assertEqual(run["inliers"], sorted(set(run["inliers"])))
            self.assertLess(run["rotation_error_deg"], 0.1)
            self.assertLess(run["translation_error"], 0.1)
            self.assertNotIn("noise_bound", [stage["name"] for stage in run["stages"]])
            for stage in run["stages"]:
                self.assertEqual(list(stage), ["name", "input", "output", "iterations", "seconds"])

    def test_noise_bound_is_estimated(self):
        file = self.problem()
        result = self.json(file, "--repeat", 2, "--truth", "p/pose.txt")
        self.assertIsNone(result["noise_bound"])
        for run in result["runs"]:
            self.assertEqual(run["status"], "success")
            self.assertAlmostEqual(run["noise_bound"], 0.3, delta=0.06)
            self.assertLess(run["rotation_error_deg"], 0.1)
            self.assertLess(run["translation_error"], 0.1)
            stage = run["stages"][0]
            self.assertEqual((stage["name"], stage["input"]), ("noise_bound", 400))
            self.assertGreater(stage["iterations"], 1)
        text = self.run_command("register", file)
        bound = result["runs"][0]["noise_bound"]
        for part in ("noise bound estimated", "success (seed 1)", f"within {bound:.4g} of the pose", "\nnoise_bound "):
            self.assertIn(part, text)

    def two_motions(self):
        """Sixty rows that keep their place but for a lift, sixty that turn by 90 degrees, sixty that do neither."""
        numbers = random.Random(1)
        rows = []
        for k in range(180):
            x, y, z, *anywhere = (numbers.uniform(-100, 100) for _ in range(6))
            target = ([x, y, z + 50], [-y, x, z - 20], anywhere)[k % 3]
            rows.append([x, y, z, *(value + numbers.gauss(0, 0.1) for value in target)])
        return self.write("two.txt", "\n".join(" ".join(map(str, row)) for row in rows))

    def test_two_motions_are_ambiguous(self):
        file = self.two_motions()
        lift = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 50], [0, 0, 0, 1]]
        turn = [[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, -20], [0, 0, 0, 1]]

        def distance(a, b):
            return max(abs(p - q) for row, other in zip(a, b) for p, q in zip(row, other))

        for arguments in (["--noise-bound", 0.3], []):
            run = self.json(file, *arguments, code=1)["runs"][0]
            self.assertEqual(run["status"], "ambiguous")
            self.assertEqual(list(run["runner_up"]), ["support", "log10_false_poses", "T_target_source"])
            poses = [run["T_target_source"], run["runner_up"]["T_target_source"]]
            for motion in (lift, turn):
                self.assertLess(min(distance(pose, motion) for pose in poses), 0.2)
            for support in (run["inlier_count"], run["runner_up"]["support"]):
                self.assertGreaterEqual(support, 48)
                self.assertLessEqual(support, 66)
            self.assertLess(run["runner_up"]["log10_false_poses"], -3)
            text = self.run_command("register", file, *arguments, code=1)
            self.assertIn("ambiguous (seed 1)", text)
            self.assertIn(f"another motion has {run['runner_up']['support']} inliers", text)
            self.assertIn("T_target_source", text)
        several = self.run_command("register", file, "--noise-bound", 0.3, "--repeat", 2, code=1)
        self.assertIn("2 with a pose", several)
        self.assertIn("two poses     seed 2: ambiguous", several)

    def test_no_errors_without_truth(self):
        run = self.json(self.problem(), "--noise-bound", 0.3)["runs"][0]
        self.assertNotIn("rotation_error_deg", run)
        self.assertNotIn("translation_error", run)

    def test_json_file_holds_what_stdout_shows(self):
        file = self.problem()
        self.assertEqual(self.run_command("register", file, "--noise-bound", 0.3, "--json", "r.json"), "")
        written = json.loads((self.folder / "r.json").read_text())
        self.assertEqual(without_times(written), without_times(self.json(file, "--noise-bound", 0.3)))
        self.assertEqual({path.name for path in self.folder.iterdir()}, {"p", "r.json"})

    def test_same_bytes_for_any_threads_and_isa(self):
        file = self.problem()
        for bound in (["--noise-bound", 0.3], []):
            arguments = [file, *bound, "--repeat", 3, "--truth", "p/pose.txt"]
            expected = without_times(self.json(*arguments))
            for threads in (1, 2, 5):
                result = self.json(*arguments, "--threads", threads)
                self.assertEqual(result["threads"], threads)
                self.assertEqual(without_times(result), expected, f"{threads} threads")
            for isa in self.isas():
                result = self.json(*arguments, CONSIMD_ISA=isa)
                self.assertEqual(result["isa"], isa)
                self.assertEqual(without_times(result), expected, isa)

    def test_report(self):
        file = self.problem()
        single = self.run_command("register", file, "--noise-bound", 0.3, "--truth", "p/pose.txt")
        for text in ["success (seed 1)", "deviation", "T_target_source", " deg", " ms", "within 0.3", "stage"]:
            self.assertIn(text, single)
        several = self.run_command("register", file, "--noise-bound", 0.3, "--repeat", 4)
        self.assertIn("4 (seeds 1 to 4), 4 with a pose", several)

    def test_formats_of_the_same_file(self):
        file = self.problem()
        expected = self.json(file, "--noise-bound", 0.3)["runs"][0]["T_target_source"]
        text = (self.folder / file).read_text()
        for variant in (
            text.replace(" ", ","),
            text.replace("\n", "\r\n"),
            "\n# head\n" + text.replace("\n", " # note\n"),
            text.rstrip("\n"),
            text.replace("\n", "\r"),
            ",".join(["x1", "y1", "z1", "x2", "y2", "z2"]) + "\r" + text.replace(" ", ",").replace("\n", "\r"),
            "\n".join(",".join(f'"{word}"' for word in line.split()) for line in text.splitlines()[1:]),
        ):
            run = self.json(self.write("variant.txt", variant), "--noise-bound", 0.3)["runs"][0]
            self.assertEqual(run["T_target_source"], expected)

    def test_no_pose_exits_with_1(self):
        for rows in (["1 1 1 2 2 2"] * 50, [f"{k} {2 * k} 0 {k} 0 {2 * k}" for k in range(50)]):
            file = self.write("degenerate.txt", "\n".join(rows))
            result = self.json(file, "--noise-bound", 0.1, "--repeat", 2, code=1)
            for run in result["runs"]:
                self.assertEqual(run["status"], "degenerate_geometry")
                self.assertIsNone(run["T_target_source"])
                self.assertIsNone(run["covariance"])
                self.assertEqual(run["inliers"], [])
            command = ["register", file, "--noise-bound", 0.1]
            self.assertIn("degenerate_geometry", self.run_command(*command, code=1))
            self.assertIn("0 with a pose", self.run_command(*command, "--repeat", 2, code=1))

    def corners(self):
        """The corners of a rectangle turned by 90 degrees about z and moved: 3 x 4 metres."""
        rows = [(x, y, 0, 1 - y, 1 + x, 2) for x, y in ((0, 0), (4, 0), (4, 3), (0, 3))]
        return self.write("corners.txt", "\n".join(" ".join(map(str, row)) for row in rows))

    def test_assumed_inliers(self):
        file = self.corners()
        pose = [[0, -1, 0, 1], [1, 0, 0, 1], [0, 0, 1, 2], [0, 0, 0, 1]]
        result = self.json(file, "--assume-inliers")
        self.assertIs(result["assume_inliers"], True)
        (run,) = result["runs"]
        self.assertEqual((run["status"], run["inliers"]), ("success", [0, 1, 2, 3]))
        for row, expected in zip(run["T_target_source"], pose):
            for value, number in zip(row, expected):
                self.assertAlmostEqual(value, number, delta=1e-6)
        self.assertEqual(len(run["residuals"]), 4)
        self.assertLess(max(run["residuals"]), 1e-6)
        text = self.run_command("register", file, "--assume-inliers")
        self.assertIn("all rows assumed to be inliers", text)
        self.assertIn("row 3         residual", text)
        alone = self.run_command("register", file, "--noise-bound", 0.01, code=1)
        self.assertIn("too little evidence to tell a pose from chance", alone)
        self.assertIn("use --assume-inliers", alone)
        line = self.write("line.txt", "\n".join(f"{k} 0 0 0 {k} 0" for k in range(5)))
        text = self.run_command("register", line, "--assume-inliers", code=1)
        self.assertIn("degenerate_geometry", text)
        self.assertIn("collinear", text)
        self.assert_error("register", file, "--assume-inliers", "--noise-bound", 1, says="--assume-inliers")

    def test_pose_and_inliers_are_saved(self):
        file = self.problem()
        run = self.json(file, "--noise-bound", 0.3, "--save-pose", "pose.txt", "--save-inliers", "inliers.txt")["runs"][0]
        again = self.json(file, "--noise-bound", 0.3, "--truth", "pose.txt")["runs"][0]
        self.assertLess(again["rotation_error_deg"], 1e-10)
        rows = [int(line) for line in (self.folder / "inliers.txt").read_text().splitlines() if line[0] != "#"]
        self.assertEqual(rows, run["inliers"])
        self.assert_error("register", file, "--noise-bound", 1, "--save-pose", "p/none/x", says="cannot write")
        self.assert_error("register", file, "--repeat", 2, "--save-pose", "x", says="--save-pose: writes one run")

    def test_standard_input(self):
        file = self.problem()
        text = (self.folder / file).read_text()
        done = subprocess.run(
            [CONSIMD, "register", "-", "--noise-bound", "0.3", "--json", "-"],
            cwd=self.folder, input=text, capture_output=True, text=True,
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        expected = self.json(file, "--noise-bound", 0.3)["runs"][0]["T_target_source"]
        self.assertEqual(json.loads(done.stdout)["runs"][0]["T_target_source"], expected)

    def test_notes(self):
        file = self.problem()
        rows = [list(map(float, line.split())) for line in (self.folder / file).read_text().splitlines()[1:]]

        def notes(rows, *arguments, code=1):
            file = self.write("noted.txt", "\n".join(" ".join(map(str, row)) for row in rows))
            result = self.json(file, "--noise-bound", 0.3, *arguments, code=code)
            return " ".join(result.get("notes", []))

        self.assertEqual(notes(rows, code=0), "")
        self.assertIn("scale of 1000: see --estimate-scale", notes([[x / 1000 for x in row[:3]] + row[3:] for row in rows]))
        self.assertIn("a mirror image fits", notes([[-row[0], *row[1:]] for row in rows]))
        far = notes([*rows, [1e9, 0, 0, 1, 2, 3]], code=0)
        self.assertIn("1 row lies far from all others and counts as an outlier: row 400", far)
        inverse = json.loads(self.run_command("register", file, "--noise-bound", 0.3, "--json", "-"))
        rotation = [row[:3] for row in inverse["runs"][0]["T_target_source"][:3]]
        shift = [row[3] for row in inverse["runs"][0]["T_target_source"][:3]]
        lines = []
        for column in range(3):
            turned = [rotation[row][column] for row in range(3)]
            lines.append(" ".join(map(str, [*turned, -sum(a * b for a, b in zip(turned, shift))])))
        self.write("inverse.txt", "\n".join(lines))
        self.assertIn("inverse of --truth", notes(rows, "--truth", "inverse.txt", code=0))

    def test_tiny_noise_bound_is_raised(self):
        rows = [[x, y, z, x + 5, y - 3, z + 1] for x in range(5) for y in (0, 2, 7) for z in (0, 1, 4)]
        file = self.write("exact.txt", "\n".join(" ".join(map(str, row)) for row in rows))
        result = self.json(file, "--noise-bound", 1e-12)
        self.assertEqual(result["noise_bound"], 1e-12)
        self.assertGreater(result["runs"][0]["noise_bound"], 1e-7)
        self.assertEqual(result["runs"][0]["inlier_count"], len(rows))
        self.assertIn("noise bound 1e-12 is below what the coordinates resolve", " ".join(result["notes"]))

    def test_runs_without_a_pose_have_no_errors(self):
        numbers = random.Random(3)
        rows = [[numbers.uniform(-10, 10) for _ in range(6)] for _ in range(30)]
        file = self.write("none.txt", "\n".join(" ".join(map(str, row)) for row in rows))
        self.write("pose.txt", "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 1e-17 1\n")
        result = self.json(file, "--noise-bound", 0.01, "--repeat", 2, "--truth", "pose.txt", code=1)
        for run in result["runs"]:
            self.assertIsNone(run["T_target_source"])
            self.assertIsNone(run["rotation_error_deg"])
            self.assertIsNone(run["translation_error"])
        text = self.run_command("register", file, "--noise-bound", 0.01, "--repeat", 2, "--truth", "pose.txt", code=1)
        self.assertNotIn("  errors", text)

    def test_pose_and_inliers_on_the_standard_output(self):
        file = self.problem()
        self.run_command("register", file, "--noise-bound", 0.3, "--save-pose", "pose.txt", "--save-inliers", "inliers.txt")
        for option, name in (("--save-pose", "pose.txt"), ("--save-inliers", "inliers.txt")):
            expected = (self.folder / name).read_text()
            self.assertEqual(self.run_command("register", file, "--noise-bound", 0.3, option, "-"), expected)
            out = self.run_command("register", file, "--noise-bound", 0.3, option, "-", "--json", "out.json")
            self.assertEqual(out, expected)
            json.loads((self.folder / "out.json").read_text())
        self.assertFalse((self.folder / "-").exists())
        degenerate = self.write("degenerate.txt", "1 1 1 2 2 2\n" * 50)
        process = self.start("register", degenerate, "--noise-bound", 0.3, "--save-pose", "-")
        self.assertEqual(process.communicate(timeout=300), ("", "consimd: no pose: degenerate_geometry\n"))
        self.assertEqual(process.returncode, 1)

    def test_viewpoint(self):
        file = self.problem()
        result = self.json(file, "--noise-bound", 0.3, "--source-viewpoint", "1,-2.5,3e2")
        self.assertEqual(list(result)[6:], ["source_viewpoint", "runs"])
        self.assertEqual(result["source_viewpoint"], [1, -2.5, 300])
        self.assertEqual(self.json(file, "--noise-bound", 0.3, "--source-viewpoint", "0,0,0")["source_viewpoint"], [0, 0, 0])
        help_text = " ".join(self.run_command("register", "--help").split())
        self.assertIn("Of clouds also none, and they are turned up", help_text)
        self.assertEqual(help_text.count("-viewpoint TEXT=0,0,0"), 2)

    def test_full_disk(self):
        file = self.problem()
        with open("/dev/full", "w") as full:
            done = subprocess.run(
                [CONSIMD, "register", file, "--noise-bound", "0.3", "--json", "-"],
                cwd=self.folder, stdout=full, stderr=subprocess.PIPE, text=True,
            )
        self.assertEqual(done.returncode, 2)
        self.assertRegex(done.stderr, r"\Aconsimd: cannot write[^\n]*\n\Z")

    def test_time_limit(self):
        file = self.problem()
        endless = ("--solver", "ransac:max_iterations=4000000000:confidence=none")
        run = self.json(file, "--noise-bound", 0.3, *endless, "--time-limit", 0.05)["runs"][0]
        self.assertEqual((run["status"], run["stopped"]), ("budget_exhausted", True))
        text = self.run_command("register", file, "--noise-bound", 0.3, *endless, "--time-limit", 0.05)
        self.assertIn(" ms, the search was ended by the time limit\n", text)
        for bound in (("--noise-bound", 0.3), ()):
            run = self.json(file, *bound, "--time-limit", 1e-9, code=1)["runs"][0]
            self.assertEqual((run["status"], run["stopped"], run["T_target_source"]), ("no_consensus", True, None))
            free, limited = (self.json(file, *bound, *limit) for limit in ((), ("--time-limit", 1e6)))
            self.assertEqual(without_times(free), without_times(limited))
        for seconds in (0, -1, "nan"):
            self.assert_error("register", file, "--time-limit", seconds, says="--time-limit: expected a number of seconds > 0")


if __name__ == "__main__":
    unittest.main()
