"""Builds and kept results against each other, by programs that claim to be consimd_bench."""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCRIPTS = ROOT / "bench/micro"
sys.path.insert(0, str(SCRIPTS))
from against import median_interval  # noqa: E402

# Writes the speeds of the next round, and its name to the log of all.
PROGRAM = """#!{python}
import json, pathlib, sys
here = pathlib.Path(__file__)
with open(here.parent / "log", "a") as log: log.write(here.name + "\\n")
if "--benchmark_filter=none" in sys.argv: sys.exit("consimd_bench: no benchmark matches the filter")
rounds = json.loads(here.with_suffix(".rounds").read_text())
here.with_suffix(".rounds").write_text(json.dumps(rounds[1:]))
out = next(a.split("=", 1)[1] for a in sys.argv if a.startswith("--benchmark_out="))
entries = [dict(run_name=name, run_type="iteration", family_index=0, **values) for name, values in rounds[0].items()]
pathlib.Path(out).write_text(json.dumps(dict(context=dict(cpu=here.name), benchmarks=entries)))
"""


class Against(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def program(self, name, rounds):
        path = self.folder / name
        path.write_text(PROGRAM.format(python=sys.executable), encoding="utf-8")
        path.chmod(0o700)
        path.with_suffix(".rounds").write_text(json.dumps(rounds), encoding="utf-8")
        return path

    def results(self, name, speeds, **more):
        entries = [
            dict(run_name=benchmark, run_type="iteration", family_index=0, items_per_second=speed)
            for benchmark, repetitions in speeds.items()
            for speed in repetitions
        ]
        path = self.folder / name
        path.write_text(json.dumps({"context": {"cpu": name}, "benchmarks": entries, **more}), encoding="utf-8")
        return path

    def run_script(self, script, *arguments, code=0):
        command = [sys.executable, "-B", SCRIPTS / script, *map(str, arguments)]
        ran = subprocess.run(command, capture_output=True, text=True, check=False)
        self.assertEqual(ran.returncode, code, ran.stderr)
        return ran.stdout if code == 0 else ran.stderr

    def test_interval_of_a_median(self):
        self.assertIsNone(median_interval([1, 2, 3, 4, 5]))  # at most 93.75 %
        self.assertEqual(median_interval([3, 1, 2, 6, 5, 4]), (1, 6))
        self.assertEqual(median_interval(range(9)), (1, 7))
        self.assertEqual(median_interval(range(25)), (7, 17))  # the tables' 8th and 18th

    def test_programs_in_turn(self):
        """A slow round hits both: the ratio stays what it is."""
        slow = [1, 1, 0.3, 1, 0.5, 1, 1, 1, 0.2]
        ours = [{"copy/3000/avx2": {"items_per_second": 4e9 * s}, "register": {"median_ms": 0.5 / s}} for s in slow]
        theirs = [{"copy/3000/avx2": {"items_per_second": 2e9 * s}, "register": {"median_ms": 0.25 / s}} for s in slow]
        text = self.run_script("against.py", self.program("a", ours), self.program("b", theirs), "--sizes", "3000")
        self.assertIn("| `copy/3000/avx2` | 4 G/s | 2 G/s | 2.000 | 2.000 to 2.000 | faster |", text)
        self.assertIn("| `register` | 2 k/s | 4 k/s | 0.500 | 0.500 to 0.500 | slower |", text)
        self.assertEqual((self.folder / "log").read_text().split(), ["a", "b", "b", "a"] * 4 + ["a", "b"])

    def test_kept_results(self):
        now = self.program("a", [{"copy/1/avx2": {"items_per_second": 1e9 * k}} for k in (1, 1.01, 0.99, 1.02, 1, 1)])
        kept = self.folder / "kept.json"
        kept.write_text(json.dumps({"context": {"cpu": "x"}, "results": {"copy/1/avx2": {"items_per_second": 2e9}}}))
        text = self.run_script("against.py", now, kept, "--rounds", 6)
        self.assertIn("| `copy/1/avx2` | 1 G/s | 2 G/s | 0.500 |  |  |", text)

    def test_results_of_two_machines(self):
        a = self.results("a.json", {"copy/1/avx2": [1e9, 1.1e9, 1.2e9, 1e9, 1e9, 1e9], "alone": [1.0]})
        b = self.results("b.json", {"copy/1/avx2": [1e9] * 6})
        before = b.read_bytes()
        text = self.run_script("against.py", a, b)
        self.assertIn("| `copy/1/avx2` | 1 G/s | 1 G/s | 1.000 | 1.000 to 1.200 | same |", text)
        self.assertEqual(b.read_bytes(), before)

    def test_errors(self):
        a = self.results("a.json", {"copy/1/avx2": [1e9]})
        program = self.program("p", [])
        self.assertIn("no such file", self.run_script("against.py", a, self.folder / "no.json", code=1))
        b = self.results("b.json", {"x": [1.0]})
        self.assertIn("no benchmark in common", self.run_script("against.py", a, b, code=1))
        self.assertIn("--rounds: expected", self.run_script("against.py", program, a, "--rounds", "x", code=1))
        self.assertIn("no benchmark matches the filter", self.run_script("against.py", program, a, "--benchmark_filter=none", code=1))
        broken = self.folder / "c.json"
        broken.write_text("{", encoding="utf-8")
        self.assertIn("c.json: no results of consimd_bench", self.run_script("against.py", a, broken, code=1))

    def test_report_overwrites_kept_results_only(self):
        a = self.results("a.json", {"copy/1/avx2": [1e9]})
        b = self.results("b.json", {"copy/1/avx2": [2e9]})
        before = b.read_bytes()
        self.assertIn("usage", self.run_script("report.py", a, b, code=1))
        self.assertIn("not overwritten", self.run_script("report.py", a, "--keep", b, code=1))
        self.assertEqual(b.read_bytes(), before)
        for _ in range(2):
            self.run_script("report.py", a, "--keep", self.folder / "kept.json")


if __name__ == "__main__":
    unittest.main()
