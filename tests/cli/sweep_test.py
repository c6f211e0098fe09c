"""consimd sweep."""

import csv
import json
import os
import pty
import signal
import time
import unittest

from command import CONSIMD, PLOTTER, CommandTest

SMALL = ["sweep", "--points", 200, "--outliers", "0.5,0.8", "--sigma", "0.1:1:2", "--trials", 3, "--out", "s"]
# Long enough to be stopped half-way.
LONG = ["sweep", "--points", 1000, "--outliers", "0.5,0.9", "--sigma", "0.1,1", "--trials", 150]


class Sweep(CommandTest):
    def rows(self, name):
        with open(self.folder / name, newline="") as file:
            return list(csv.DictReader(file))

    def timeless(self, name):
        return [{key: value for key, value in row.items() if key != "seconds"} for row in self.rows(name)]

    def test_files_and_table(self):
        out = self.run_command(*SMALL)
        for text in ("noise bound 3 sigma", "recall", "oracle", "50 %", "80 %", "tcf"):
            self.assertIn(text, out)
        files = {path.name for path in (self.folder / "s").iterdir()}
        self.assertEqual(files, {"trials.csv", "cells.csv", "summary.json", "drawn"})
        trials = self.rows("s/trials.csv")
        self.assertEqual(
            ",".join(trials[0]),
            "solver,outlier_ratio,sigma,trial,seed,status,success,rmse_true_inliers,rotation_error_deg,"
            "translation_error,oracle_rotation_error_deg,oracle_translation_error,"
            "inlier_precision,inlier_recall,seconds",
        )
        self.assertEqual(
            [(row["outlier_ratio"], row["sigma"], row["trial"]) for row in trials],
            [(ratio, sigma, trial) for ratio in ("0.5", "0.8") for sigma in ("0.1", "1") for trial in ("0", "1", "2")],
        )
        cells = self.rows("s/cells.csv")
        self.assertEqual(
            ",".join(cells[0]),
            "solver,outlier_ratio,sigma,trials,recall,recall_low,recall_high,rotation_error_deg_mean,"
            "translation_error_mean,oracle_rotation_error_deg_mean,oracle_translation_error_mean,seconds_median",
        )
        self.assertEqual(len(cells), 4)
        for i, cell in enumerate(cells):
            mine = trials[3 * i : 3 * i + 3]
            self.assertAlmostEqual(float(cell["recall"]), sum(int(row["success"]) for row in mine) / 3)
            self.assertAlmostEqual(
                float(cell["rotation_error_deg_mean"]), sum(float(row["rotation_error_deg"]) for row in mine) / 3
            )
        summary = json.loads((self.folder / "s/summary.json").read_text())
        for key in ("version", "commit", "compiler", "machine", "isa", "threads", "options"):
            self.assertIn(key, summary)
        self.assertEqual((summary["complete"], summary["trials_done"]), (True, 12))

    def test_default_folder(self):
        self.run_command(*SMALL[:-2])
        self.assertTrue((self.folder / "consimd-sweep/trials.csv").exists())

    def test_same_results_for_any_threads_and_isa(self):
        self.run_command(*SMALL)
        expected = self.timeless("s/trials.csv")
        for threads in (1, 2, 5):
            self.run_command(*SMALL[:-1], f"t{threads}", "--threads", threads)
            self.assertEqual(self.timeless(f"t{threads}/trials.csv"), expected)
        for isa in self.isas():
            self.run_command(*SMALL[:-1], isa, CONSIMD_ISA=isa)
            self.assertEqual(self.timeless(f"{isa}/trials.csv"), expected)

    def test_filter(self):
        self.run_command(*SMALL, "--filter", "tcf")
        self.assertTrue(all(row["success"] == "1" for row in self.rows("s/trials.csv")))
        self.assertEqual(json.loads((self.folder / "s/summary.json").read_text())["options"]["filter"], "tcf")
        self.assert_error(*SMALL, says="s holds another study: it has filter tcf, not none")
        self.assert_error(*SMALL, "--filter", "magic", says="expected one of: none, tcf")

    def test_trial_can_be_repeated_by_hand(self):
        self.run_command(*SMALL)
        row = self.rows("s/trials.csv")[10]
        self.run_command(
            "generate", "--points", 200, "--outliers", row["outlier_ratio"], "--sigma", row["sigma"],
            "--trial", row["trial"], "--out", "p",
        )
        out = self.run_command(
            "register", "p/correspondences.txt", "--noise-bound", 3 * float(row["sigma"]), "--seed", row["seed"],
            "--truth", "p/pose.txt", "--json", "-",
        )
        run = json.loads(out)["runs"][0]
        self.assertEqual(run["status"], row["status"])
        # The true rotation went through a text file and was made orthonormal again.
        self.assertAlmostEqual(run["rotation_error_deg"], float(row["rotation_error_deg"]), places=9)
        self.assertAlmostEqual(run["translation_error"], float(row["translation_error"]), places=9)

    def interrupt(self, number, folder):
        process = self.start(*LONG, "--out", folder, "--threads", 2)
        trials = self.folder / folder / "trials.csv"
        while not (trials.exists() and trials.read_bytes().count(b"\n") > 20):
            self.assertIsNone(process.poll(), "ended before it could be stopped")
            time.sleep(0.002)
        process.send_signal(number)
        _, err = process.communicate(timeout=60)
        return process.returncode, err

    def test_interrupted_sweep_resumes(self):
        self.run_command(*LONG, "--out", "whole")
        for number in (signal.SIGINT, signal.SIGTERM):
            folder = number.name
            code, err = self.interrupt(number, folder)
            self.assertEqual(code, 130)
            self.assertRegex(
                err.splitlines()[-1], r"^consimd: stopped after \d+ of 600 trials; the same command resumes$"
            )
            done = len(self.rows(f"{folder}/trials.csv"))
            self.assertTrue(20 <= done < 600, done)
            out = self.run_command(*LONG, "--out", folder)
            self.assertIn(f"{done} done before", out)
            self.assertEqual(self.timeless(f"{folder}/trials.csv"), self.timeless("whole/trials.csv"))
            self.assertIn("600 done before", self.run_command(*LONG, "--out", folder))

    def test_killed_sweep_resumes(self):
        self.run_command(*LONG, "--out", "whole")
        code, _ = self.interrupt(signal.SIGKILL, "killed")
        self.assertEqual(code, -signal.SIGKILL)
        self.run_command(*LONG, "--out", "killed")
        self.assertEqual(self.timeless("killed/trials.csv"), self.timeless("whole/trials.csv"))

    def test_other_options_in_the_same_folder(self):
        self.run_command(*SMALL)
        self.assert_error(*SMALL, "--seed", 2, says="s holds another study: it has seed 1, not 2")
        self.run_command(*SMALL, "--seed", 2, "--fresh")
        self.assertEqual(self.rows("s/trials.csv")[0]["seed"], "2")

    def test_progress_bar_on_a_terminal(self):
        terminal, child = pty.openpty()
        pid = os.fork()
        if pid == 0:
            os.dup2(child, 1)
            os.dup2(child, 2)
            os.chdir(self.folder)
            os.execve(CONSIMD, [CONSIMD, *map(str, SMALL)], self.environment)
        os.close(child)
        output = b""
        try:
            while chunk := os.read(terminal, 4096):
                output += chunk
        except OSError:  # the other end is closed
            pass
        os.close(terminal)
        self.assertEqual(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]), 0)
        self.assertIn(b"\r[", output)
        self.assertIn(b"100 % 12/12 trials", output)

    def test_without_matplotlib_the_data_are_kept(self):
        self.plotter.write_text("#!/bin/sh\nexit 1\n")
        process = self.start(*SMALL)
        _, err = process.communicate()
        self.assertEqual(process.returncode, 0)
        self.assertRegex(err.splitlines()[-1], "figures not drawn: no Python with matplotlib.*python3-matplotlib")
        self.assertEqual(len(self.rows("s/cells.csv")), 4)

    def test_drawing_imports_nothing_from_the_current_folder(self):
        if PLOTTER is None:
            self.skipTest("no Python with matplotlib")
        for name in ("matplotlib", "figure_style", "csv", "plot_map"):
            self.write(f"{name}.py", "open('foreign', 'w')\n")
        self.draw_for_real()
        self.run_command(*SMALL, PYTHONPATH=str(self.folder))
        self.assertFalse((self.folder / "foreign").exists())
        self.assertTrue((self.folder / "s/recall.svg").exists())

    def test_failing_plot_script(self):
        self.script.write_text("raise SystemExit(3)\n")
        process = self.start(*SMALL)
        _, err = process.communicate()
        self.assertEqual(process.returncode, 0)
        self.assertRegex(err.splitlines()[-1], "figures not drawn: .*exit status 3")

    def test_bad_options(self):
        for option, values in {
            "--sigma": ["", "x", "0", "-1", "nan", "inf", "1:2", "1:2:1", "2:1:5", "1:2:3:4", "1,,2", "1,1", "1:5:50x"],
            "--outliers": ["1", "-0.1", "nan", "x", "0.9999", "0.5,0.5", "0:1:3"],
            "--trials": ["0", "-1", "x", "1.5"],
            "--points": ["0", "2", "-5", "x"],
            "--threads": ["0", "-1", "x"],
            "--solver": ["magic", "tcf,magic", "tcf,tcf"],
            "--seed": ["-1", "x"],
        }.items():
            for value in values:
                self.assert_error("sweep", "--out", "s", option, value, says=option.strip("-"))
        self.assert_error("sweep", "--out", "s", "--solver", "magic", says="expected one of: tcf")

    def test_unwritable_folder(self):
        self.write("file", "")
        for folder in ("file", "file/s"):
            self.assert_error("sweep", "--out", folder, says="cannot write")


if __name__ == "__main__":
    unittest.main()
