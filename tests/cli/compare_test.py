"""consimd compare."""

import csv
import json
import re
import signal
import time
import unittest

from command import PLOTTER, CommandTest

SMALL = ["compare", "--synthetic", "facade,noise", "--trials", 2, "--outliers", "0.5", "--sigma", "1", "--points", 200]
SMALL += ["--solver", "tcf,ransac", "--out", "c"]


class Compare(CommandTest):
    def rows(self, name):
        with open(self.folder / name, newline="") as file:
            return list(csv.DictReader(file))

    def timeless(self, name):
        return [{key: value for key, value in row.items() if key != "seconds"} for row in self.rows(name)]

    def case(self, name, **changes):
        """A case of the folder 'cases', written as its reader wants it."""
        self.run_command("generate", "--points", 200, "--outliers", 0.5, "--sigma", 0.1, "--out", f"cases/{name}")
        path = self.folder / "cases" / name / "case.json"
        path.write_text(json.dumps({**json.loads(path.read_text()), **changes}))

    def test_files_and_table(self):
        out = self.run_command(*SMALL)
        files = {path.name for path in (self.folder / "c").iterdir()}
        self.assertEqual(files, {"runs.csv", "comparison.json", "tables.md", "table_solvers.csv", "table_pairs.csv",
                                 "table_quantiles.csv", "pairs.csv", "solvers.csv", "curves.csv", "drawn"})
        tables = (self.folder / "c/tables.md").read_text()
        for text in ("synthetic stand-in for ETH Facade, not its data", "thresholds `case`", "facade: 5 deg, 0.5 m",
                     "noise 50 %", "RMSE of the true inliers below the noise bound", "| recall % |"):
            self.assertIn(text, tables)
            self.assertIn(text, out)
        runs = self.rows("c/runs.csv")
        self.assertEqual(
            ",".join(runs[0]),
            "group,case,method,seed,status,success,rotation_error_deg,translation_error,rows,inliers,kept,"
            "kept_inliers,seconds,scale_error,limit_ratio,oracle_rotation_error_deg,oracle_translation_error",
        )
        self.assertEqual([(run["group"], run["method"]) for run in runs],
                         [(group, method) for group in ("facade", "noise 50 %") for _ in range(2)
                          for method in ("tcf", "ransac")])
        table = self.rows("c/table_solvers.csv")
        self.assertEqual([row["recall %"] for row in table], ["100.0"] * 4)
        summary = json.loads((self.folder / "c/comparison.json").read_text())
        self.assertEqual((summary["complete"], summary["runs_done"]), (True, 8))
        self.assertIn("stand-in", summary["data"][0]["provenance"])

    def test_solvers_beside_each_other(self):
        """plain RANSAC of ten samples fails where tcf does not; two seeds of a case are one case."""
        out = self.run_command(
            "compare", "--synthetic", "facade,trees", "--trials", 8, "--seeds", 2, "--solver",
            "tcf,ransac:max_iterations=10:confidence=none", "--out", "c")  # fmt: skip
        (pair,) = self.rows("c/table_pairs.csv")
        self.assertEqual((pair["A"], pair["B"].split(":")[0]), ("tcf", "ransac"))
        self.assertEqual((pair["better"], pair["cases"], pair["B alone"]), ("tcf", "16", "0"))
        self.assertIn("trees", pair["in"])
        self.assertIn("### Solvers on the same cases", out)
        self.assertIn("c/pairs.csv, c/solvers.csv, c/curves.csv", out)
        runs = self.rows("c/runs.csv")
        wins = {(run["group"], run["case"]): 0 for run in runs}
        for run in runs:
            wins[run["group"], run["case"]] += int(run["success"]) * (1 if run["method"] == "tcf" else -1)
        rows = {row["group"]: row for row in self.rows("c/pairs.csv")}
        self.assertEqual(list(rows), ["facade", "trees", "all groups"])
        for group, row in rows.items():
            mine = [count for (of, _), count in wins.items() if group in (of, "all groups")]
            self.assertEqual((int(row["trials"]), int(row["only_a"]), int(row["only_b"])),
                             (len(mine), sum(count > 0 for count in mine), sum(count < 0 for count in mine)))
            self.assertAlmostEqual(float(row["recall_difference"]), sum(mine) / (2 * len(mine)))
            self.assertLessEqual(float(row["p_value"]), float(row["p_value_holm"]))
        for row in self.rows("c/curves.csv"):
            if row["threshold"] != "1":
                continue
            mine = [run["success"] for run in runs
                    if run["method"] == row["solver"] and row["group"] in (run["group"], "all groups")]
            self.assertAlmostEqual(float(row["recall"]), mine.count("1") / len(mine))
        # One solver: quantiles alone.
        self.run_command("compare", "--synthetic", "facade", "--trials", 2, "--solver", "tcf", "--out", "c", "--fresh")
        self.assertEqual({path.name for path in (self.folder / "c").glob("*.*")},
                         {"runs.csv", "comparison.json", "tables.md", "table_solvers.csv", "table_quantiles.csv"})
        self.assert_error("compare", "--solver", "tcf", "--table", "pairs", "--out", "d", says="table pairs: it needs two")

    def test_every_table(self):
        out = self.run_command(
            "compare", "--synthetic", "facade", "--trials", 1, "--solver", "tcf", "--iterations", "10,1000",
            "--iteration-problems", 2, "--table", "iterations,poses,stages,boost,solvers", "--thresholds", "paper",
        )
        titles = re.findall("^### (.*)$", out, re.MULTILINE)
        self.assertEqual(len(titles), 5)
        self.assertEqual(titles[0], "Recall, errors and time")
        self.assertIn("| tcf+tcf ", out)
        self.assertIn("| 1R+2R+3R+IRLS ", out)
        stages = self.rows("consimd-compare/table_stages.csv")
        self.assertEqual([row["stages"] for row in stages],
                         ["none", "1R", "2R", "3R", "1R+2R", "1R+3R", "2R+3R", "1R+2R+3R"])
        self.assertGreater(float(stages[-1]["IR %"]), 3 * float(stages[0]["IR %"]))
        iterations = self.rows("consimd-compare/table_iterations.csv")
        self.assertEqual([(row["solver"], row["iterations"]) for row in iterations],
                         [("plain ransac", "10"), ("plain ransac", "1000"), ("tcf", "-")])
        self.assertEqual(iterations[2]["recall %"], "100.0")
        self.assertTrue((self.folder / "consimd-compare/drawn").exists())

    @unittest.skipIf(PLOTTER is None, "no Python with matplotlib")
    def test_figure(self):
        self.draw_for_real()
        iterations = ["compare", "--table", "iterations", "--iteration-problems", 1, "--out", "c"]
        out = self.run_command(*iterations, "--iterations", "1000,10,100")
        self.assertIn("figure: c/iterations.svg (and .png)", out)
        files = {f"iterations.{kind}" for kind in ("svg", "png")}
        self.assertEqual(files & {path.name for path in (self.folder / "c").iterdir()}, files)
        self.assertIn(b"<svg", (self.folder / "c/iterations.svg").read_bytes())
        self.run_command(*iterations, "--fresh", "--iterations", 5)  # one point makes no curve, but a figure
        self.run_command(*SMALL, "--fresh")  # removes what it does not draw anew
        self.assertEqual(files & {path.name for path in (self.folder / "c").iterdir()}, set())
        drawn = (self.folder / "c/comparison.svg").read_text()
        for text in ("tcf − ransac, all groups", "facade", "noise 50 %", "difference of recall"):
            self.assertIn(text, drawn)

    def test_unknown_scale(self):
        out = self.run_command("compare", "--table", "scales", "--scales", "0.2,5", "--trials", 1, "--out", "c")
        self.assertIn("largest scale error %", out)
        rows = self.rows("c/table_scales.csv")
        self.assertEqual([(row["data"], row["solver"]) for row in rows],
                         [(f"scale {scale}", solver) for scale in ("0.2", "5") for solver in ("pcr99", "teaser")])
        for row in rows:
            self.assertEqual(row["recall %"], "100.0")
            self.assertLess(float(row["largest scale error %"]), 1.0)
        self.assert_error("compare", "--table", "scales", "--solver", "tcf,mac", "--out", "d",
                          says="solver 'tcf, mac' needs a known scale, expected one of: pcr99, teaser")

    def test_cases_from_files(self):
        self.case("b", dataset="KITTI", sequence="01")
        self.case("a", dataset="KITTI", sequence="01")
        self.case("c")
        out = self.run_command("compare", "--cases", "cases", "--solver", "tcf", "--seeds", 3, "--out", "c")
        self.assertIn("files of the folder cases", out)
        runs = self.rows("c/runs.csv")
        self.assertEqual([(run["group"], run["case"], run["seed"]) for run in runs],
                         [("KITTI 01", case, seed) for case in "ab" for seed in "123"]
                         + [("consimd synth", "c", seed) for seed in "123"])
        labels = (self.folder / "cases/a/labels.txt").read_text().count("1")
        self.assertLess(abs(int(runs[0]["inliers"]) - labels), 10)
        # By the solver itself, with the same result.
        run = json.loads(self.run_command(
            "register", "cases/a/correspondences.txt", "--noise-bound", 0.3, "--seed", 2, "--truth", "cases/a/pose.txt",
            "--json", "-",
        ))["runs"][0]
        self.assertEqual(float(runs[1]["rotation_error_deg"]), run["rotation_error_deg"])
        self.assertEqual(float(runs[1]["translation_error"]), run["translation_error"])

    def test_thresholds_decide(self):
        self.case("a", dataset="KITTI", max_rotation_error_deg=1e-9)
        compare = ["compare", "--cases", "cases", "--solver", "tcf", "--out"]
        self.run_command(*compare, "c")
        self.run_command(*compare, "d", "--thresholds", "paper")
        self.assertEqual([self.rows(f"{out}/runs.csv")[0]["success"] for out in "cd"], ["0", "1"])
        self.assertIn("thresholds `paper`): KITTI: 5 deg, 1 m", (self.folder / "d/tables.md").read_text())

    def test_filter(self):
        self.run_command(*SMALL, "--filter", "tcf")
        self.assertEqual({run["method"] for run in self.rows("c/runs.csv")}, {"tcf+tcf", "tcf+ransac"})
        self.assertIn("after TCF's filter", (self.folder / "c/tables.md").read_text())
        self.assert_error(*SMALL, "--fresh", "--filter", "tcf", "--table", "poses", says="filter: it is for")

    def test_same_results_for_any_threads_and_isa(self):
        self.run_command(*SMALL)
        expected = self.timeless("c/runs.csv")
        for threads in (1, 3):
            self.run_command(*SMALL[:-1], f"t{threads}", "--threads", threads)
            self.assertEqual(self.timeless(f"t{threads}/runs.csv"), expected)
        for isa in self.isas():
            self.run_command(*SMALL[:-1], isa, CONSIMD_ISA=isa)
            self.assertEqual(self.timeless(f"{isa}/runs.csv"), expected)

    def test_interrupted_comparison_resumes(self):
        long = ["compare", "--synthetic", "facade", "--trials", 40, "--solver", "tcf,ransac-10k"]
        self.run_command(*long, "--out", "whole")
        process = self.start(*long, "--out", "c")
        runs = self.folder / "c/runs.csv"
        while not (runs.exists() and runs.read_bytes().count(b"\n") > 5):
            self.assertIsNone(process.poll(), "ended before it could be stopped")
            time.sleep(0.002)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130, err)
        self.assertRegex(err.splitlines()[-1], r"^consimd: stopped after \d+ of 80 runs; the same command resumes$")
        self.assertRegex((self.folder / "c/tables.md").read_text(), r"Unfinished: \d+ of 80 runs")
        done = len(self.rows("c/runs.csv"))
        self.assertTrue(5 <= done < 80, done)
        self.assertIn(f"{done} done before", self.run_command(*long, "--out", "c"))
        self.assertEqual(self.timeless("c/runs.csv"), self.timeless("whole/runs.csv"))
        self.assertEqual((self.folder / "c/curves.csv").read_text(), (self.folder / "whole/curves.csv").read_text())
        self.assert_error(*long, "--out", "c", "--seed", 2, says="c holds another comparison: it has seed 1, not 2")

    def test_one_process_at_a_time(self):
        process = self.start("compare", "--synthetic", "facade", "--trials", 500, "--solver", "ransac-50k", "--out", "c")
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        self.assertIn("500 runs", process.stdout.readline())
        again = self.start("compare", "--synthetic", "facade", "--trials", 500, "--solver", "ransac-50k", "--out", "c")
        _, err = again.communicate(timeout=60)
        self.assertEqual((again.returncode, err), (2, "consimd: c: another process is writing to this folder\n"))
        process.stdout.close()
        process.stderr.close()

    def test_resuming_refuses_what_has_changed(self):
        self.case("a", dataset="KITTI")
        self.case("b", dataset="KITTI")
        compare = ["compare", "--cases", "cases", "--solver", "tcf", "--out", "c"]
        self.run_command(*compare)
        self.run_command(*compare)
        pose = self.folder / "cases/b/pose.txt"
        good = pose.read_text()
        pose.write_text(good + "# seen again\n")
        self.assert_error(*compare, says="c holds another comparison: case b of KITTI has changed")
        pose.write_text(good)
        self.run_command(*compare)
        self.case("d", dataset="KITTI")
        self.assert_error(*compare, says="c holds another comparison: case d of KITTI is new")
        for path in ("d", "b"):
            (self.folder / "cases" / path).rename(self.folder / path)
        self.assert_error(*compare, says="c holds another comparison: case b of KITTI is gone")
        (self.folder / "b").rename(self.folder / "cases/b")
        summary = self.folder / "c/comparison.json"
        text = summary.read_text()
        for old, new, says in ((r'"version": "[^"]*"', '"version": "0.0.9"', "it has version 0.0.9"),
                               (r'"tcf": "[^"]*"', '"tcf": "0"', "tcf had other options"),
                               (r'"solver_options": {', '"others": {', "tcf had other options"),
                               (r'"digests": {', '"others": {', "case a of KITTI is new")):
            summary.write_text(re.sub(old, new, text))
            self.assert_error(*compare, says=says)
        summary.write_text(text)
        self.run_command(*compare)

    def test_bad_options(self):
        for option, values in {
            "--synthetic": ["magic", "arch,magic", "Arch"],
            "--table": ["magic", "solvers,solvers"],
            "--solver": ["magic", "tcf,tcf"],
            "--thresholds": ["magic"],
            "--filter": ["magic"],
            "--trials": ["0", "-1", "x"],
            "--seeds": ["0", "x"],
            "--seed": ["-1"],
            "--iterations": ["0", "x", "5,5"],
            "--scales": ["0", "-1", "x", "inf", "2,2"],
            "--outliers": ["x", "1"],
            "--sigma": ["0", "x"],
            "--points": ["2"],
        }.items():
            for value in values:
                base = [] if option == "--synthetic" else ["--synthetic", "noise"]
                self.assert_error("compare", *base, "--out", "c", option, value, says=option.strip("-"))

    def test_bad_cases(self):
        self.assert_error("compare", "--cases", "cases", "--out", "c", says="cases: cannot read")
        (self.folder / "cases").mkdir()
        self.assert_error("compare", "--cases", "cases", "--out", "c", says="cases: no sub-folder holds a corr")
        self.case("a", dataset="other")
        compare = ["compare", "--cases", "cases", "--solver", "tcf", "--out", "c"]
        self.assert_error(*compare, "--thresholds", "paper", says="the paper has none for data set 'other'")
        json_path = self.folder / "cases/a/case.json"
        good = json_path.read_text()
        for bad, says in (
            ("nonsense", "case.json: not JSON"),
            ("[]", "case.json: expected a JSON object"),
            ("{}", "case.json: expected a number above 0 as noise_bound"),
            ('{"noise_bound": -1}', "case.json: expected a number above 0 as noise_bound"),
            ('{"noise_bound": 1}', "case.json: expected a number above 0 as max_rotation_error_deg"),
            ('{"noise_bound": 1, "dataset": 5}', "case.json: expected a text as dataset"),
            ('{"noise_bound": 1, "dataset": "a,b", "max_rotation_error_deg": 1, "max_translation_error_m": 1}',
             "expected a name without commas"),
        ):
            json_path.write_text(bad)
            self.assert_error(*compare, says=says)
        json_path.write_text(good)
        (self.folder / "cases/a/pose.txt").unlink()
        self.assert_error(*compare, says="pose.txt: is missing")


if __name__ == "__main__":
    unittest.main()
