"""Exit codes where the standard streams cannot be used, and what is read from damaged files."""

import os
import subprocess
import unittest

from command import CONSIMD, CommandTest

SMALL = ["sweep", "--points", 200, "--outliers", "0.5", "--sigma", "1", "--trials", 3, "--out", "s"]
DEEP = "[" * 300_000 + "]" * 300_000


class Streams(CommandTest):
    def run_in_shell(self, redirections, *arguments):
        """Exit code of a command with the redirections of a shell."""
        words = ["sh", "-c", f'exec "$0" "$@" {redirections}', CONSIMD, *map(str, arguments)]
        return subprocess.run(
            words, cwd=self.folder, env=self.environment, capture_output=True, timeout=300, check=False
        ).returncode

    def files_of_a_study(self, name):
        return {path.name: path.read_text() for path in (self.folder / name).iterdir() if path.suffix == ".csv"}

    def test_a_standard_error_that_cannot_be_written_changes_no_exit_code(self):
        for redirections in ("2>/dev/full", "2>&-"):
            self.assertEqual(self.run_in_shell(redirections, "nonsense"), 2)
            self.assertEqual(self.run_in_shell(redirections, "register", "missing"), 2)
            self.assertEqual(self.run_in_shell(redirections, "info"), 0)
            self.assertEqual(self.run_in_shell(redirections, *SMALL), 0)
            self.assertEqual(self.run_in_shell(redirections, *SMALL, "--fresh"), 0)

    def test_a_lost_output_is_an_error(self):
        self.write("c.txt", "1 2 3 1 2 3\n9 5 4 9 5 4\n5 1 7 5 1 7\n" * 20)
        for redirections in (">/dev/full", ">&-"):
            for arguments in (["info"], ["--help"], ["sweep", "--help"], ["--version"], SMALL,
                              ["register", "c.txt", "--noise-bound", 1, "--json", "-"]):  # fmt: skip
                self.assertEqual(self.run_in_shell(redirections, *arguments), 2, (redirections, arguments))

    def test_the_study_is_whole_though_its_table_was_lost(self):
        self.run_command(*SMALL)
        expected = self.files_of_a_study("s").keys()
        # Lost after the first line was written: a pipe whose reader goes away would end the command by a signal.
        self.assertEqual(self.run_in_shell("| head -n 1; exit 0", *SMALL), 0)
        self.assertEqual(self.files_of_a_study("s").keys(), expected)

    def test_no_report_lands_in_a_file_when_streams_are_closed(self):
        self.run_command(*SMALL)
        for redirections in ("<&- >&- 2>&-", "<&- >&-", ">&- 2>&-", "<&- 2>&-", "<&-"):
            self.assertEqual(
                self.run_in_shell(redirections, *SMALL, "--fresh"), 2 if ">&-" in redirections.split() else 0, redirections
            )
            for name, text in self.files_of_a_study("s").items():
                for line in text.splitlines():
                    self.assertTrue(line.startswith(("solver,", "tcf,")), (redirections, name, line))

    def test_a_reader_that_fails_names_the_file(self):
        os.mkdir(self.folder / "folder")
        self.assert_error("register", "folder", says="folder: is a folder, expected a file")
        self.assert_error("register", "missing", says="missing: cannot read: No such file")
        self.assert_error("register", "/proc/self/mem", says="/proc/self/mem: cannot read: Input/output error")

    def test_json_that_is_nested_too_deep_is_an_error(self):
        self.run_command(*SMALL)
        for text in (DEEP, f'{{"options":{DEEP}}}', f'{{"options":{{"points":{DEEP}}}}}', DEEP[:300_000]):
            self.write("s/summary.json", text)
            self.assert_error(*SMALL, says="s/summary.json: ")
            self.assert_error("merge", "s", says="s/summary.json: ")
        self.run_command("generate", "--points", 50, "--out", "cases/a")
        self.write("cases/a/case.json", f'{{"noise_bound":3,"dataset":{DEEP}}}')
        self.assert_error("compare", "--cases", "cases", "--out", "c", says="cases/a/case.json: JSON nested deeper than")

    def test_runs_that_were_changed_are_an_error_with_its_line(self):
        small = ["compare", "--synthetic", "noise", "--trials", 1, "--outliers", "0.5", "--sigma", "1", "--points", 200,
                 "--solver", "tcf,ransac", "--out", "c"]  # fmt: skip
        self.run_command(*small)
        good = (self.folder / "c/runs.csv").read_text()
        self.assertIn(",success,1,", good)
        for bad in (",splendid,1,", ",success,7,", ",success,1,nan,", ",success,1,-"):
            self.write("c/runs.csv", good.replace(",success,1,", bad))
            self.assert_error(*small, says="c/runs.csv:2: ")

    def test_many_noise_levels(self):
        process = self.start("sweep", "--sigma", "0.1:5:100000", "--outliers", "0.5", "--trials", 1, "--points", 5000,
                             "--out", "many", "--threads", 1)  # fmt: skip
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        self.assertIn("100000 trials in 100000 cells", process.stdout.readline())
        process.stdout.close()
        process.stderr.close()


if __name__ == "__main__":
    unittest.main()
