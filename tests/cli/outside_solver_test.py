"""Programs of others as solvers in consimd sweep and consimd compare."""

import csv
import importlib.util
import json
import pathlib
import re
import shutil
import signal
import sys
import time
import unittest

from command import CONSIMD, MOST_SECONDS, CommandTest

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples"

# Reads problems, and does as its argument says on those whose seed is 2; else it answers what `consimd register` finds.
PROGRAM = r"""
import json, os, struct, subprocess, sys, time

mode = sys.argv[1]
binary = mode == "binary"
stream = sys.stdin.buffer

def problem():
    if binary:
        head = stream.read(24)
        if not head:
            sys.exit()
        n, bound, seed = struct.unpack("<QdQ", head)
        numbers = struct.unpack(f"<{6 * n}d", stream.read(48 * n))
        return bound, seed, [numbers[6 * k : 6 * k + 6] for k in range(n)]
    head = stream.readline()
    if not head:
        sys.exit()
    n, bound, seed = head.split()
    return float(bound), int(seed), [list(map(float, stream.readline().split())) for _ in range(int(n))]

def say(text):
    sys.stdout.write(text)
    sys.stdout.flush()

REPLIES = {"few": "1 2 3\n", "garbage": "\x01\x02 no pose here\n", "nan": "nan" + " 0" * 11 + "\n",
           "reflection": "1 0 0 0 0 1 0 0 0 0 -1 0\n", "stretched": "2 0 0 0 0 1 0 0 0 0 1 0\n",
           "far": "1 0 0 1e160 0 1 0 0 0 0 1 0\n", "huge": "7" * 100_000, "two": "none\nnone\n", "row": "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 3\n"}
with open("starts", "a") as file:
    file.write(f"{os.getpid()}\n")
say("ready 1.5\n")
while True:
    bound, seed, rows = problem()
    if seed == 2 and mode in REPLIES:
        say(REPLIES[mode])
        continue
    if seed == 2 and mode == "exit":
        sys.exit(3)
    if seed == 2 and mode == "crash":
        os.kill(os.getpid(), 11)
    if seed == 2 and mode == "partial":
        say("1 0 0")
        os._exit(0)
    if seed == 2 and mode == "hang":
        say("1 0 0")
        time.sleep(1000)
    if mode == "slow":
        time.sleep(0.2)
    text = "".join(" ".join(map(repr, row)) + "\n" for row in rows)
    found = subprocess.run([os.environ["CONSIMD"], "register", "-", "--noise-bound", repr(bound), "--seed", str(seed),
                            "--json", "-"], input=text, capture_output=True, text=True)
    pose = json.loads(found.stdout)["runs"][0]["T_target_source"]
    time_told = " time 0.125" if mode == "timed" else ""
    say((" ".join(repr(x) for row in pose for x in row) if pose else "none") + time_told + "\n")
"""

CELLS = ["--points", 100, "--outliers", "0.2,0.5", "--sigma", "0.1,1", "--trials", 3]
SWEEP = ["sweep", *CELLS, "--threads", 2]
COMPARE = ["compare", "--synthetic", "noise", *CELLS, "--threads", 2]


def runs(number):
    """Whether a process is there, and not only what is left of it until somebody asks how it ended."""
    try:
        return pathlib.Path(f"/proc/{number}/stat").read_text().rsplit(")", 1)[1].split()[0] not in "ZX"
    except (FileNotFoundError, ProcessLookupError):
        return False


def stays(number):
    """Whether a process that was killed is still there after ten seconds: on a busy machine it takes its time to end."""
    deadline = time.monotonic() + 10
    while runs(number) and time.monotonic() < deadline:
        time.sleep(0.01)
    return runs(number)


class OutsideSolver(CommandTest):
    def setUp(self):
        super().setUp()
        self.environment["CONSIMD"] = CONSIMD
        self.write("program.py", PROGRAM)

    def program(self, mode, kind="exec"):
        return f"mine={kind}:{sys.executable} program.py {mode}"

    def rows(self, name):
        with open(self.folder / name, newline="") as file:
            return list(csv.DictReader(file))

    def without_times(self, name, method="solver"):
        """The rows by solver."""
        found = {}
        for row in self.rows(name):
            row.pop("seconds")
            found.setdefault(row.pop(method), []).append(row)
        return found

    def starts(self):
        return (self.folder / "starts").read_text().split()

    def fails(self, *arguments, code=2):
        process = self.start(*arguments)
        _, error = process.communicate(timeout=MOST_SECONDS)
        self.assertEqual(process.returncode, code, error)
        return error

    def test_a_program_is_a_solver_as_others_are(self):
        for mode, kind in (("good", "exec"), ("binary", "exec-binary")):
            out = self.run_command(*SWEEP, "--solver", "tcf", "--solver", self.program(mode, kind), "--out", mode)
            self.assertIn("mine", out)
            found = self.without_times(f"{mode}/trials.csv")
            # Inliers are not told: those within the bound of the pose are taken, in double precision.
            for mine, tcf in zip(found["mine"], found["tcf"]):
                for name in ("outlier_ratio", "sigma", "trial", "seed", "status", "success", "oracle_rotation_error_deg"):
                    self.assertEqual(mine[name], tcf[name], name)
                self.assertAlmostEqual(float(mine["rotation_error_deg"]), float(tcf["rotation_error_deg"]), 9)
            summary = json.loads((self.folder / mode / "summary.json").read_text())
            self.assertEqual(
                summary["options"]["outside"],
                {"mine": {"command": self.program(mode, kind)[5:], "version": "1.5", "time limit": 60.0}},
            )
        # Once per thread, of which there are two, and no more.
        self.assertLessEqual(len(self.starts()), 4)
        self.assertEqual({row["solver"] for row in self.rows("good/cells.csv")}, {"tcf", "mine"})

    def test_the_programs_own_time_counts_where_it_tells_one(self):
        self.run_command(*SWEEP, "--solver", self.program("timed"), "--out", "told")
        self.assertEqual({row["seconds"] for row in self.rows("told/trials.csv")}, {"0.125"})

    def test_a_study_is_resumed_after_a_kill_and_merged(self):
        slow = [*SWEEP, "--solver", "tcf", "--solver", self.program("slow")]
        self.run_command(*slow, "--out", "whole")
        for index in (1, 2):
            options = [*slow, "--out", "s", "--shard", f"{index}/2"]
            process = self.start(*options)
            trials = self.folder / f"s/shard-{index}-of-2/trials.csv"
            deadline = time.monotonic() + 120
            while not (trials.exists() and trials.read_text().count("\n") > 2):
                self.assertLess(time.monotonic(), deadline)
                time.sleep(0.01)
            process.send_signal(signal.SIGKILL)
            process.communicate(timeout=60)
            self.assertIn(" 2 done before", re.sub(r" [2-9] done", " 2 done", self.run_command(*options)))
        self.run_command("merge", "s")
        self.assertEqual(self.without_times("s/trials.csv"), self.without_times("whole/trials.csv"))
        for name in ("options", "complete"):
            summaries = [json.loads((self.folder / folder / "summary.json").read_text())[name] for folder in ("s", "whole")]
            self.assertEqual(*summaries)

    def test_a_comparison_is_resumed_after_a_kill(self):
        slow = [*COMPARE, "--table", "solvers,boost", "--solver", "tcf", "--solver", self.program("slow")]
        self.run_command(*slow, "--out", "whole")
        process = self.start(*slow, "--out", "again")
        runs = self.folder / "again/runs.csv"
        deadline = time.monotonic() + 120
        while not (runs.exists() and runs.read_text().count("\n") > 3):
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.01)
        process.send_signal(signal.SIGKILL)
        process.communicate(timeout=60)
        self.assertNotIn(" 0 done before", self.run_command(*slow, "--out", "again"))
        self.assertEqual(self.without_times("again/runs.csv", "method"), self.without_times("whole/runs.csv", "method"))
        self.assertEqual(set(self.without_times("whole/runs.csv", "method")) - {"1R+2R"}, {"tcf", "mine", "tcf+tcf", "tcf+mine"})
        self.assertRegex((self.folder / "whole/tables.md").read_text(), r"\| mine +\|")

    def test_a_folder_goes_on_with_the_same_program_only(self):
        good = self.program("good")
        study = [*SWEEP, "--solver", good, "--out", "study"]
        self.run_command(*study)
        for more, says in (
            (["--solver-version", "mine=2"], "it has outside mine version 1.5, not 2"),
            (["--time-limit", 5], "it has outside mine time limit 60.0, not 5.0"),
        ):
            self.assertIn(f"study holds another study: {says};", self.fails(*study, *more))
        other = [*SWEEP, "--solver", good + " ", "--out", "study"]
        self.assertIn("it has outside mine command exec:", self.fails(*other))
        comparison = [*COMPARE, "--solver", good, "--out", "comparison"]
        self.run_command(*comparison)
        self.assertIn("mine version 1.5, not 2", self.fails(*comparison, "--solver-version", "mine=2"))

    def test_a_wrong_reply_ends_the_study_and_names_solver_and_trial(self):
        for mode, says in (
            ("few", "expected 12 or 16 numbers or none, got 3 words '1 2 3'"),
            ("garbage", "got 4 words '?? no pose here'"),
            ("nan", "'nan' is not finite"),
            ("reflection", "not a rotation but a reflection"),
            ("stretched", "not a rotation: R R^T is 3 off the identity"),
            ("row", "the last row must be 0 0 0 1"),
            ("far", "the translation has 1e+160, expected 1e+100 at most"),
            ("two", "it wrote more than one line"),
            ("huge", "it has no end: '7777"),
        ):
            error = self.fails("sweep", *CELLS, "--threads", 1, "--solver", self.program(mode), "--out", mode)
            self.assertRegex(error.splitlines()[-1], r"consimd: solver mine on trial 1 at outlier ratio 0\.\d and sigma \d.*: wrong reply: ")
            self.assertIn(says, error)
            # What was done before is kept.
            self.assertGreaterEqual(len(self.rows(f"{mode}/trials.csv")), 4)
        error = self.fails(*COMPARE, "--solver", self.program("nan"), "--out", "compared")
        self.assertIn("solver mine on noise 20 % sigma 0.1 trial 1 with seed 2: wrong reply: 'nan' is not finite", error)

    def test_a_program_that_fails_is_started_again_and_told_at_the_end(self):
        # Where a program hangs its limit is waited for; a busy machine takes its time to start one.
        for mode, limit, status, says in (
            ("exit", 60, "crashed", "it ended with exit code 3"),
            ("crash", 60, "crashed", "signal 11 (Segmentation fault)"),
            ("partial", 60, "crashed", "it ended with exit code 0, in the middle of a line: '1 0 0'"),
            ("hang", 6, "timed_out", "no reply within 6 s, in the middle of a line: '1 0 0'"),
        ):
            (self.folder / "starts").unlink(missing_ok=True)
            process = self.start(*SWEEP, "--solver", self.program(mode), "--time-limit", limit, "--out", mode)
            out, error = process.communicate(timeout=MOST_SECONDS)
            self.assertEqual(process.returncode, 0, error)
            rows = self.rows(f"{mode}/trials.csv")
            self.assertEqual({row["status"] for row in rows if row["seed"] == "2"}, {status})
            self.assertEqual({row["success"] for row in rows if row["seed"] == "2"}, {"0"})
            self.assertEqual({row["status"] for row in rows if row["seed"] != "2"}, {"success"})
            self.assertIn("consimd: programs failed in 4 trials, first mine on trial 1 at outlier ratio", error)
            self.assertIn(says, error)
            self.assertIn(f"Programs failed, which counts as no pose: mine: 4 {status.replace('_', ' ')}.", out)
            # At most two at first, and one after each failure; none is left.
            self.assertLessEqual(len(self.starts()), 6)
            self.assertFalse([number for number in self.starts() if stays(number)], mode)
        self.run_command(*COMPARE, "--solver", self.program("exit"), "--out", "compared")
        self.assertIn("Programs failed, which counts as no pose: mine: 4 crashed.", (self.folder / "compared/tables.md").read_text())

    def test_ctrl_c_ends_a_program_that_hangs_and_leaves_its_problem_undone(self):
        for command, table in ((SWEEP, "trials.csv"), (COMPARE, "runs.csv")):
            out = command[0]
            (self.folder / "starts").unlink(missing_ok=True)
            process = self.start(*command, "--solver", self.program("hang"), "--out", out)
            deadline = time.monotonic() + 120
            while not (self.folder / out / table).exists():
                self.assertLess(time.monotonic(), deadline)
                time.sleep(0.01)
            time.sleep(3)  # it hangs by then, or the study ends as ever
            process.send_signal(signal.SIGINT)
            process.communicate(timeout=30)  # half of the time limit
            self.assertEqual(process.returncode, 130)
            self.assertNotIn("2", [row["seed"] for row in self.rows(f"{out}/{table}")])
            self.assertFalse([number for number in self.starts() if stays(number)])

    def test_a_killed_study_leaves_no_program(self):
        process = self.start(*SWEEP, "--solver", self.program("hang"), "--out", "killed")
        deadline = time.monotonic() + 120
        while not (self.folder / "killed/trials.csv").exists():
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.01)
        time.sleep(3)  # one hangs by then
        process.kill()
        process.communicate(timeout=30)
        left = self.starts()
        self.assertTrue(left)
        while left:
            self.assertLess(time.monotonic(), deadline, left)
            time.sleep(0.1)
            left = [number for number in left if runs(number)]

    def test_a_program_that_does_not_start_is_told_before_anything_is_written(self):
        for command, says in (
            ("./nothing", "ended with exit code 127 without the line 'ready'"),
            ("echo hello", "ended with exit code 0 without the line 'ready', it said 'hello'"),
            ("echo readyset; cat", "ran for 1 s without the line 'ready', it said 'readyset'"),
            (r"printf 'ready\nloaded\n'; cat", "wrote more after the line 'ready'"),
            ("yes '' | tr -d '\\n' ; sleep 100; : ", "ran for 1 s without the line 'ready'"),
        ):
            error = self.fails(*SWEEP, "--time-limit", 1, "--solver", f"mine=exec:{command}", "--out", "none")
            self.assertIn("solver mine: '", error)
            self.assertIn(says, error)
            self.assertFalse((self.folder / "none").exists())

    def test_bad_arguments_are_named(self):
        good = self.program("good")
        for arguments, says in (
            (["--solver", "mine=exec:"], "solver mine: expected a command after exec:"),
            (["--solver", "tcf=exec:true"], "solver tcf: consimd has one of this name"),
            (["--solver", "a b=exec:true"], "solver 'a b': expected a name"),
            (["--solver", good, "--solver", good], "given twice"),
            (["--solver", good, "--time-limit", "0"], "time limit: expected a number of seconds above 0"),
            (["--solver", good, "--solver-version", "yours=2"], "--solver-version: expected NAME=TEXT"),
            (["--solver", good, "--solver-version", "mine=1", "--solver-version", "mine=2"], "mine has two, '1' and '2'"),
            (["--solver", good, "--option", "x=2"], "--option: 'x=2' is of no solver of consimd"),
            (["--solver", good, "--report", ""], "--report: expected the name of a file"),
            (["--solver", "mine=python:x"], "solver is 'mine=python', expected one of"),
        ):
            for command in (SWEEP, COMPARE):
                self.assert_error(*command, *arguments, says=says)
        for command in (SWEEP, COMPARE):
            self.assert_error(*command, "--solver", "tcf", "--time-limit", 60, says="--time-limit: 60 s are for programs")

    def test_commas_belong_to_the_command_of_a_program(self):
        self.run_command(*SWEEP, "--solver", f"tcf,{self.program('good')} a,b", "--out", "commas")
        self.assertEqual(set(self.without_times("commas/trials.csv")), {"tcf", "mine"})

    def assert_client_solves(self, command):
        study = ["sweep", "--points", 200, "--outliers", "0.2,0.5", "--sigma", "0.1,1", "--trials", 2]
        self.run_command(*study, "--solver", f"tcf,mine=exec:{command}", "--out", "client")
        self.assertEqual([row["success"] for row in self.rows("client/trials.csv")], ["1"] * 16)

    @unittest.skipUnless(importlib.util.find_spec("numpy"), "numpy is not installed")
    def test_the_client_in_python_solves(self):
        self.assert_client_solves(f"{sys.executable} {EXAMPLES / 'outside_client.py'}")

    @unittest.skipUnless(shutil.which("octave-cli"), "octave-cli is not installed")
    def test_the_client_in_octave_solves(self):
        self.assert_client_solves(f"octave-cli --quiet --norc --path {EXAMPLES} --eval outside_client")


if __name__ == "__main__":
    unittest.main()
