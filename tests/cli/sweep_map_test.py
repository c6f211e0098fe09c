"""consimd sweep --map."""

import csv
import math
import signal
import statistics
import time
import unittest

from command import PLOTTER, CommandTest

SMALL = ["sweep", "--points", 200, "--outliers", "0.5,0.8", "--sigma", "0.1:1:2", "--trials", 3, "--out", "s"]


class SweepMap(CommandTest):
    def rows(self, name):
        with open(self.folder / name, newline="") as file:
            return list(csv.DictReader(file))

    def test_limits(self):
        out = self.run_command(*SMALL, "--map")
        files = {path.name for path in (self.folder / "s").iterdir()}
        self.assertEqual(files, {"trials.csv", "cells.csv", "limits.csv", "summary.json", "drawn"})
        limits = self.rows("s/limits.csv")
        self.assertEqual(
            ",".join(limits[0]),
            "sigma,problems,chance_support_mean,chance_support_max,fixed_support_mean,limit_outlier_ratio",
        )
        self.assertEqual([(row["sigma"], row["problems"]) for row in limits], [("0.1", "10"), ("1", "10")])
        # The share of inliers within 3 sigma, by numerical integration of the density of their errors' length.
        within = statistics.fmean(
            3 * math.sqrt(2 / math.pi) * x * x * math.exp(-x * x / 2) for x in ((k + 0.5) * 3e-4 for k in range(10000))
        )
        for row in limits:
            chance, most, fixed, limit = (float(value) for value in list(row.values())[2:])
            self.assertTrue(0 <= fixed <= chance <= most < 10, row)
            self.assertAlmostEqual(200 * (1 - limit) * within + limit * fixed, max(chance, 3), places=5)
            inliers = 200 * (1 - limit)
            self.assertRegex(out, rf"{row['sigma']} +{chance:.1f} +{most:.0f} +{100 * limit:.2f} +{inliers:.1f}\n")
        self.assertIn("s/limits.csv", out)

    def test_added_to_a_finished_study(self):
        self.run_command(*SMALL)
        trials = (self.folder / "s/trials.csv").read_bytes()
        self.run_command(*SMALL, "--map")
        self.assertEqual((self.folder / "s/trials.csv").read_bytes(), trials)
        limits = self.folder / "s/limits.csv"
        head, _, second = limits.read_text().splitlines()
        # A level that is there is taken as it is, the other one measured.
        marked = "0.1,10,3.25,4,0,0.9"
        limits.write_text(f"{head}\n{marked}\n")
        for arguments in (["--map"], ["--map"], []):
            self.run_command(*SMALL, *arguments)
            self.assertEqual(limits.read_text().splitlines(), [head, marked, second])
        self.write("s/map.svg", "<svg>")
        self.run_command(*SMALL, "--fresh")
        self.assertFalse(limits.exists() or (self.folder / "s/map.svg").exists())

    def test_interrupted_limits_resume(self):
        command = ["sweep", "--points", 200, "--outliers", 0.5, "--sigma", "0.3:0.6:30", "--trials", 1, "--map"]
        self.run_command(*command, "--out", "whole")
        process = self.start(*command, "--out", "s")
        limits = self.folder / "s/limits.csv"
        while not (limits.exists() and len(self.rows("s/limits.csv")) > 2):
            self.assertIsNone(process.poll(), "ended before it could be stopped")
            time.sleep(0.002)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130)
        self.assertRegex(
            err.splitlines()[-1],
            r"^consimd: stopped after the limits of \d+ of 30 noise levels; the same command resumes$",
        )
        before = limits.read_text()
        self.assertTrue(2 < before.count("\n") - 1 < 30)
        self.run_command(*command, "--out", "s")
        self.assertEqual(self.rows("s/limits.csv"), self.rows("whole/limits.csv"))
        self.assertTrue(limits.read_text().startswith(before))

    def test_foreign_limits(self):
        self.run_command(*SMALL)
        self.write("s/limits.csv", "my,own,table\n")
        self.assert_error(*SMALL, "--map", says="s/limits.csv:1: not the header of this table; --fresh starts over")
        self.assertEqual((self.folder / "s/limits.csv").read_text(), "my,own,table\n")

    @unittest.skipIf(PLOTTER is None, "no Python with matplotlib")
    def test_figures(self):
        figures = {f"{name}.{kind}" for name in ("recall", "errors", "map") for kind in ("svg", "png")}
        self.draw_for_real()
        # A grid, and lists neither evenly spaced nor in order, with two solvers and a cell beyond the limit.
        uneven = ["sweep", "--points", 100, "--outliers", "0.97,0,0.5", "--sigma", "2,0.1,90", "--trials", 1]
        for folder, command in {"grid": SMALL[:-2], "uneven": [*uneven, "--solver", "tcf,tcf-published"]}.items():
            out = self.run_command(*command, "--map", "--out", folder)
            self.assertIn(f"{folder}/map.svg", out)
            present = {path.name for path in (self.folder / folder).iterdir()}
            self.assertEqual(present & figures, figures)
            self.assertIn(b"<svg", (self.folder / folder / "map.svg").read_bytes())


if __name__ == "__main__":
    unittest.main()
