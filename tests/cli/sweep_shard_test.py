"""consimd sweep --shard and consimd merge."""

import csv
import json
import os
import shutil
import signal
import subprocess
import time
import unittest

from command import CONSIMD, CommandTest

SMALL = ["sweep", "--points", 200, "--outliers", "0.5,0.8", "--sigma", "0.1:1:2", "--trials", 3]
# Long enough to be stopped half-way.
LONG = ["sweep", "--points", 1000, "--outliers", "0.5,0.9", "--sigma", "0.1,1", "--trials", 150]
TABLES = ["trials.csv", "cells.csv", "limits.csv", "summary.json"]
# A run of these tests may itself be the task of a launcher.
LAUNCHERS = ("SLURM_", "OMPI_", "PMI_", "PMIX_")


class SweepShard(CommandTest):
    def setUp(self):
        super().setUp()
        self.environment = {k: v for k, v in self.environment.items() if not k.startswith(LAUNCHERS)}

    def table(self, name):
        with open(self.folder / name, newline="") as file:
            return list(csv.reader(file))

    def without_times(self, name):
        head, *rows = self.table(name)
        return [head] + [row[:-1] for row in rows]

    def assert_same_study(self, folder, whole):
        """All but what depends on the time that trials took, the last column of both tables."""
        for name in ("trials.csv", "cells.csv"):
            self.assertEqual(self.without_times(f"{folder}/{name}"), self.without_times(f"{whole}/{name}"))
        if (self.folder / whole / "limits.csv").exists():
            self.assertEqual(
                (self.folder / folder / "limits.csv").read_bytes(), (self.folder / whole / "limits.csv").read_bytes()
            )

    def give_times_of(self, whole, shard):
        """Puts the times of the same trials of another run into a shard's trials.csv."""
        head, *rows = self.table(f"{whole}/trials.csv")
        times = {tuple(row[:5]): row[-1] for row in rows}
        lines = [row[:-1] + [times[tuple(row[:5])]] for row in self.table(f"{shard}/trials.csv")[1:]]
        text = "".join(",".join(line) + "\n" for line in [head, *lines])
        (self.folder / shard / "trials.csv").write_text(text)

    def test_merged_files_equal_those_of_the_whole_study(self):
        options = [*SMALL, "--solver", "tcf,ransac-10k", "--map", "--threads", 1]
        self.run_command(*options, "--out", "whole")
        for count in (3, 4):
            for index in range(1, count + 1):
                out = self.run_command(*options, "--out", "s", "--shard", f"{index}/{count}")
                self.assertIn(f" of shard {index}/{count} in 8 cells", out)
                self.assertIn(f"shard {index}/{count} is complete; when all are: consimd merge s\n", out)
            shards = [f"s/shard-{index}-of-{count}" for index in range(1, count + 1)]
            sizes = [len(self.table(f"{shard}/trials.csv")) - 1 for shard in shards]
            self.assertEqual((sum(sizes), max(sizes) - min(sizes)), (24, 0))
            self.run_command("merge", *shards, "--map", "--out", f"m{count}")
            self.assert_same_study(f"m{count}", "whole")
            # Given the same times, everything is the same, byte for byte.
            for shard in shards:
                self.give_times_of("whole", shard)
            self.run_command("merge", *reversed(shards), "--out", f"m{count}")
            for name in TABLES:
                self.assertEqual(
                    (self.folder / f"m{count}" / name).read_bytes(), (self.folder / "whole" / name).read_bytes(), name
                )
            self.assertTrue((self.folder / f"m{count}" / "drawn").exists())

    def test_default_folders(self):
        for index in (1, 2):
            self.run_command(*SMALL, "--shard", f"{index}/2")
        out = self.run_command("merge")
        self.assertIn("12 trials in 4 cells, merged from 2 shards, writing to consimd-sweep\n", out)
        for text in ("recall", "50 %", "80 %", "data: consimd-sweep/trials.csv"):
            self.assertIn(text, out)
        # The merged study is like any other: there is nothing left to run.
        self.assertIn("12 done before", self.run_command(*SMALL))
        out = self.run_command("merge", "consimd-sweep/shard-1-of-2/", "consimd-sweep/shard-2-of-2")
        self.assertIn("writing to consimd-sweep\n", out)

    def test_environment_counts_only_when_asked_for(self):
        task = {"SLURM_ARRAY_TASK_ID": "2", "SLURM_ARRAY_TASK_COUNT": "4", "SLURM_ARRAY_TASK_MIN": "1"}
        self.assertIn("12 trials in", self.run_command(*SMALL, "--out", "s", **task))
        out = self.run_command(*SMALL, "--out", "t", "--shard", "auto", **task)
        self.assertIn("3 trials of shard 2/4", out)
        self.assertEqual([path.name for path in (self.folder / "t").iterdir()], ["shard-2-of-4"])
        self.assertIn("4 trials of shard 1/3", self.run_command(*SMALL, "--out", "u", "--shard", "1/3", **task))
        ranks = {"OMPI_COMM_WORLD_RANK": "0", "OMPI_COMM_WORLD_SIZE": "2"}
        self.assert_error(*SMALL, "--shard", "auto", says="slurm-array says 2/4", **task, **ranks)
        self.assertIn("shard 1/2", self.run_command(*SMALL, "--out", "v", "--shard", "openmpi", **task, **ranks))

    def test_bad_shards(self):
        for shard in ("", "0/4", "5/4", "2", "x/4", "1/0", "1/2/3"):
            self.assert_error(*SMALL, "--shard", shard, says="--shard: expected K/N")
        self.assert_error(*SMALL, "--shard", "auto", says="the environment names no part")
        self.assert_error(*SMALL, "--shard", "pmi", says="pmi: no PMI_RANK and PMI_SIZE", PMI_ID="1")

    def test_bad_merges(self):
        self.assert_error("merge", says="consimd-sweep: no such folder")
        self.run_command(*SMALL, "--out", "whole")
        self.assert_error("merge", "whole", says="whole: neither a shard of a study nor a folder of shards")
        for index in (1, 3):
            self.run_command(*SMALL, "--out", "s", "--shard", f"{index}/4")
        self.assert_error("merge", "s", says="not all shards are done: missing: 2/4, 4/4")
        for index in (2, 4):
            self.run_command(*SMALL, "--out", "s", "--shard", f"{index}/4")
        self.assert_error("merge", "s", "--map", says="run 1/4, 2/4 with --map")
        self.assert_error("merge", "s", "s/shard-1-of-4", says="shard 1/4 is there twice")
        self.assert_error("merge", "s", "--out", "s/shard-1-of-4", says="is one of the shards")
        self.run_command(*SMALL, "--out", "other", "--seed", 2)
        self.assert_error("merge", "s", "--out", "other", says="other holds another study: it has seed 2, not 1")
        self.run_command("merge", "s", "--out", "other", "--fresh")
        self.assert_same_study("other", "whole")
        shutil.move(self.folder / "s/shard-1-of-4", self.folder / "elsewhere")
        self.assert_error("merge", "s", "elsewhere", says="--out: expected a folder")
        self.run_command("merge", "s", "elsewhere", "--out", "m")
        self.assert_same_study("m", "whole")
        self.run_command(*SMALL, "--out", "s", "--shard", "1/4", "--seed", 3)
        self.assert_error("merge", "s", says="it has seed 1, not 3")

    def test_stopped_shard_resumes(self):
        shard = [*LONG, "--shard", "2/2", "--out", "s"]
        process = self.start(*shard, "--threads", 1)
        trials = self.folder / "s/shard-2-of-2/trials.csv"
        while not (trials.exists() and trials.read_bytes().count(b"\n") > 20):
            self.assertIsNone(process.poll(), "ended before it could be stopped")
            time.sleep(0.002)
        # The folder is taken while the shard runs.
        second = self.start(*shard)
        self.assertIn("another process is writing to this folder", second.communicate(timeout=60)[1])
        self.assertEqual(second.returncode, 2)
        process.send_signal(signal.SIGTERM)
        _, err = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130)
        self.assertRegex(
            err.splitlines()[-1],
            r"^consimd: stopped after \d+ of 300 trials of shard 2/2; the same command resumes$",
        )
        done = len(self.table("s/shard-2-of-2/trials.csv")) - 1
        self.run_command(*LONG, "--shard", "1/2", "--out", "s")
        self.assert_error("merge", "s", says=f"unfinished: 2/2 in s/shard-2-of-2 ({done} of 300 trials)")
        self.assertIn(f"{done} done before", self.run_command(*shard))
        self.run_command("merge", "s")
        self.run_command(*LONG, "--out", "whole")
        self.assert_same_study("s", "whole")

    @unittest.skipIf(shutil.which("mpirun") is None, "no mpirun")
    def test_four_processes_under_mpirun(self):
        environment = {
            **self.environment,
            "OMPI_ALLOW_RUN_AS_ROOT": "1",
            "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
            # More processes than cores, as Open MPI 4 and 5 want it told.
            "OMPI_MCA_rmaps_base_oversubscribe": "1",
            "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
        }
        options = [*map(str, [*SMALL, "--map", "--threads", 1])]
        process = subprocess.run(
            ["mpirun", "-n", "4", CONSIMD, *options, "--out", "s", "--shard", "auto"],
            cwd=self.folder, env=environment, capture_output=True, text=True, timeout=120, check=False,
        )
        self.assertEqual(process.returncode, 0, process.stdout + process.stderr)
        for index in range(1, 5):
            self.assertIn(f"shard {index}/4 is complete", process.stdout)
            summary = json.loads((self.folder / f"s/shard-{index}-of-4/summary.json").read_text())
            self.assertEqual((summary["shard"], summary["trials_done"]), (f"{index}/4", 3))
        self.run_command("merge", "s", "--map")
        self.run_command(*options, "--out", "whole")
        self.assert_same_study("s", "whole")
        self.assertEqual(
            (self.folder / "s/summary.json").read_bytes(), (self.folder / "whole/summary.json").read_bytes()
        )


if __name__ == "__main__":
    unittest.main()
