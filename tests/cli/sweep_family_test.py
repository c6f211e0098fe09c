"""consimd sweep beyond the paper's study: --family, --scale, --points, --bound-factor, --no-pose."""

import csv
import json
import pathlib
import signal
import subprocess
import time
import unittest

from command import PLOTTER, CommandTest

SMALL = ["sweep", "--family", "gaussian,heavy_tails", "--points", "80,120", "--bound-factor", "1,estimated",
         "--no-pose", 0.25, "--outliers", "0.5", "--sigma", "0.5,1", "--trials", 4]
# Long enough to be stopped half-way.
LONG = ["sweep", "--family", "decoy,clustered", "--bound-factor", "1,2", "--no-pose", 0.1, "--points", 1000,
        "--outliers", "0.5", "--sigma", "0.5,1", "--trials", 80]


class SweepFamily(CommandTest):
    def rows(self, name):
        with open(self.folder / name, newline="") as file:
            return list(csv.DictReader(file))

    def timeless(self, name):
        return [{key: value for key, value in row.items() if not key.startswith("seconds")} for row in self.rows(name)]

    def test_tables(self):
        out = self.run_command(*SMALL, "--out", "s")
        for text in ("64 trials in 16 cells, noise bound 3 sigma times 1, estimated, ", "heavy_tails, 120 points, bound "
                     "estimated", "wrong  refused  ambiguous", "problems with a true pose"):
            self.assertIn(text, out)
        trials, cells = self.rows("s/trials.csv"), self.rows("s/cells.csv")
        self.assertEqual((len(trials), len(cells)), (64, 16))
        self.assertEqual(
            [(c["family"], c["points"], c["bound_factor"], c["sigma"]) for c in cells],
            [(family, points, bound, sigma) for family in ("gaussian", "heavy_tails") for points in ("80", "120")
             for bound in ("1", "estimated") for sigma in ("0.5", "1")],
        )
        for k, cell in enumerate(cells):
            mine = trials[4 * k : 4 * k + 4]
            self.assertEqual([row["true_pose"] for row in mine], ["1", "1", "1", "0"])
            self.assertAlmostEqual(float(cell["recall"]), sum(int(row["success"]) for row in mine) / 3)
            for column, outcome in (("success_share", "success"), ("refused_share", "refused"),
                                    ("wrong_success_share", "wrong_success"), ("ambiguous_share", "ambiguous")):
                self.assertEqual(float(cell[column]), sum(row["outcome"] == outcome for row in mine) / 4)
        summary = json.loads((self.folder / "s/summary.json").read_text())
        self.assertEqual(summary["options"]["family"], ["gaussian", "heavy_tails"])
        self.assertEqual(summary["options"]["bound factor"], ["1", "estimated"])
        self.assertEqual(summary["options"]["points"], [80, 120])
        self.assertIn("the oracle's", summary["success"])

    def test_the_papers_study_is_untouched(self):
        paper = ["sweep", "--points", 100, "--outliers", "0.5", "--sigma", "1", "--trials", 2]
        self.run_command(*paper, "--out", "s")
        defaults = ["--family", "gaussian", "--scale", "known", "--bound-factor", "1.0", "--no-pose", "0"]
        self.run_command(*paper, *defaults, "--out", "s")  # the same study: nothing is left to do
        self.assertTrue((self.folder / "s/trials.csv").read_text().startswith("solver,outlier_ratio,sigma,trial,seed,"))
        options = json.loads((self.folder / "s/summary.json").read_text())["options"]
        self.assertEqual(list(options), ["points", "outliers", "sigma", "trials", "solver", "filter", "seed"])
        self.assertEqual(options["points"], 100)
        # The family of that name is the same data.
        self.run_command(*paper, "--family", "gaussian,copies", "--out", "t")
        for mine, other in zip(self.timeless("s/trials.csv"), self.timeless("t/trials.csv")):
            self.assertEqual(mine, {key: other[key] for key in mine})

    def test_a_problem_of_the_study_as_files(self):
        self.run_command("sweep", "--family", "street", "--points", 200, "--outliers", 0.5, "--sigma", 0.5, "--trials",
                         2, "--seed", 4, "--out", "s")
        row = self.rows("s/trials.csv")[1]
        self.run_command("generate", "--family", "street", "--points", 200, "--outliers", 0.5, "--sigma", 0.5, "--seed",
                         4, "--trial", 1, "--out", "p")
        out = self.run_command("register", "p/correspondences.txt", "--noise-bound", row["noise_bound"], "--seed",
                               row["seed"], "--truth", "p/pose.txt", "--json", "-")
        run = json.loads(out)["runs"][0]
        self.assertEqual(run["status"], row["status"])
        self.assertAlmostEqual(run["rotation_error_deg"], float(row["rotation_error_deg"]), places=8)

    def test_same_results_for_any_threads(self):
        for threads in (1, 2):
            self.run_command(*SMALL, "--threads", threads, "--out", f"t{threads}")
        for name in ("trials.csv", "cells.csv"):
            self.assertEqual(self.timeless(f"t1/{name}"), self.timeless(f"t2/{name}"))

    def test_killed_sweep_resumes(self):
        self.run_command(*LONG, "--out", "whole")
        process = self.start(*LONG, "--out", "killed", "--threads", 2)
        trials = self.folder / "killed/trials.csv"
        while not (trials.exists() and trials.read_bytes().count(b"\n") > 20):
            self.assertIsNone(process.poll(), "ended before it could be stopped")
            time.sleep(0.002)
        process.send_signal(signal.SIGKILL)
        process.communicate(timeout=60)
        self.run_command(*LONG, "--out", "killed")
        for name in ("trials.csv", "cells.csv"):
            self.assertEqual(self.timeless(f"killed/{name}"), self.timeless(f"whole/{name}"))

    def test_two_shards_merged_equal_the_whole(self):
        self.run_command(*SMALL, "--out", "whole")
        for index in (1, 2):
            self.run_command(*SMALL, "--out", "s", "--shard", f"{index}/2")
        out = self.run_command("merge", "s")
        self.assertIn("heavy_tails, 120 points, bound estimated", out)
        for name in ("trials.csv", "cells.csv"):
            self.assertEqual(self.timeless(f"s/{name}"), self.timeless(f"whole/{name}"))
        self.assertEqual(
            json.loads((self.folder / "s/summary.json").read_text())["options"],
            json.loads((self.folder / "whole/summary.json").read_text())["options"],
        )

    def test_unknown_scale(self):
        small = ["sweep", "--scale", "known,unknown", "--points", 100, "--outliers", 0.2, "--sigma", 0.1, "--trials", 2]
        self.run_command(*small, "--solver", "pcr99", "--out", "s")
        rows = self.rows("s/trials.csv")
        self.assertEqual([row["success"] for row in rows], ["1"] * 4)
        self.assertEqual([float(row["scale_error"]) > 0 for row in rows], [False, False, True, True])
        self.assert_error(*small, "--out", "t", says="solver 'tcf'")

    def test_other_conditions_in_the_same_folder(self):
        small = ["sweep", "--points", 60, "--outliers", 0.5, "--sigma", 1, "--trials", 1, "--out", "s"]
        self.run_command(*small)
        self.assert_error(*small, "--family", "decoy", says="s holds another study: it has family gaussian, not decoy")
        self.assert_error(*small, "--no-pose", 0.5, says="it has no pose 0.0, not 0.5")
        self.run_command(*small, "--family", "decoy", "--fresh")
        self.assert_error(*small, says="s holds another study: it has family decoy, not gaussian")

    def test_bad_options(self):
        for option, values in {
            "--family": ["", "magic", "decoy,", "decoy,decoy"],
            "--scale": ["", "both", "known,known"],
            "--bound-factor": ["", "0", "-1", "nan", "x", "1,1.0", "1e9", "guessed"],
            "--no-pose": ["1", "-0.1", "nan", "x"],
            "--points": ["100,", "100,100", "100,2", "1e3", "100.5"],
        }.items():
            for value in values:
                self.assert_error("sweep", "--out", "s", option, value, says=option.strip("-").split("-")[-1])
        self.assert_error("sweep", "--out", "s", "--family", "magic", says="expected one of: gaussian, heavy_tails")
        self.assert_error("generate", "--out", "p", "--family", "magic", says="expected one of: gaussian, heavy_tails")
        self.assert_error("sweep", "--out", "s", "--family", "decoy", "--map", says="map: the limit is that of the paper")

    def test_help_tells_of_every_family(self):
        text = self.run_command("sweep", "--help")
        for name in ("gaussian", "heavy_tails", "kept_ring", "no_depth"):
            self.assertRegex(text, rf"\n  {name} +[A-Z]")

    @unittest.skipUnless(PLOTTER, "no Python with matplotlib")
    def test_figures(self):
        """Two conditions: a row of panels takes a second and more to draw."""
        self.draw_for_real()
        self.run_command("sweep", "--family", "gaussian,heavy_tails", "--points", 80, "--no-pose", 0.25, "--outliers", 0.5,
                         "--sigma", "0.5,1", "--trials", 4, "--solver", "tcf,ransac", "--out", "s")  # fmt: skip
        picture = (self.folder / "s/recall.svg").read_text()
        self.assertIn("<!-- heavy_tails: ransac -->", picture)  # what does not vary is not told
        self.assertTrue((self.folder / "s/errors.png").exists())

    @unittest.skipUnless(PLOTTER, "no Python with matplotlib")
    def test_figures_name_what_varies(self):
        self.run_command(*SMALL, "--out", "s")
        show = ("import csv, sys; sys.path.insert(0, sys.argv[1]); import plot_sweep\n"
                "print(*plot_sweep.condition_labels(list(csv.DictReader(open(sys.argv[2])))).values(), sep='\\n')")
        scripts = pathlib.Path(__file__).resolve().parents[2] / "studies/src/figures"
        labels = subprocess.run([PLOTTER, "-B", "-c", show, str(scripts), str(self.folder / "s/cells.csv")],
                                check=True, capture_output=True, encoding="utf-8").stdout.splitlines()  # fmt: skip
        self.assertEqual(labels, [f"{family}, {points} points, bound {bound}" for family in ("gaussian", "heavy_tails")
                                  for points in (80, 120) for bound in ("× 1", "estimated")])  # fmt: skip



if __name__ == "__main__":
    unittest.main()
