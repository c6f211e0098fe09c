"""consimd_bench: what its own options choose, and errors in one line."""

import json
import os
import pathlib
import subprocess
import tempfile
import unittest

BENCH = os.environ["CONSIMD_BENCH"]
QUICK = ("--benchmark_min_time=0.001", "--isas", "scalar", "--sizes", "70,130")


class BenchOptions(unittest.TestCase):
    def run_bench(self, *arguments, code=0):
        ran = subprocess.run([BENCH, *arguments], capture_output=True, text=True, check=False)
        self.assertEqual(ran.returncode, code, ran.stderr)
        return ran.stdout if code == 0 else ran.stderr.splitlines()[-1]

    def names(self, *arguments):
        return self.run_bench("--benchmark_list_tests", *arguments).splitlines()

    def test_sizes_batches_and_instruction_sets(self):
        names = self.names("--benchmark_filter=alignment_counts", "--sizes=500,2500", "--batch", "64,16", "--isas", "scalar")
        variants = ("scalar", "loop", "textbook", "eigen")
        self.assertEqual(names, [f"alignment_counts/{size}/{variant}{batch}"
                                 for size in (500, 2500) for batch in ("", "/batch:16") for variant in variants])
        # What takes no batch is there once.
        moments = self.names("--benchmark_filter=subset_moments", "--sizes", "500", "--batch", "8,16", "--isas", "scalar")
        self.assertEqual(moments, ["subset_moments/500/scalar", "subset_moments/500/eigen"])

    def test_results_are_those_of_the_reference(self):
        """Every kernel and baseline passes its check at sizes and batches that nobody thought of."""
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "bench.json"
            self.run_bench(*QUICK, "--batch", "3", "--benchmark_filter=^(length|angle|alignment|weighted|consistency)",
                           f"--benchmark_out={file}")  # fmt: skip
            benchmarks = json.loads(file.read_text(encoding="utf-8"))["benchmarks"]
        self.assertGreater(len(benchmarks), 50)
        self.assertEqual([entry["name"] for entry in benchmarks if entry.get("error_occurred")], [])

    def test_errors(self):
        for arguments, says in (
            (("--benchmark_filter=nothing_of_it",), "no benchmark matches the filter"),
            (("--sizes", "2"), "--sizes: expected whole numbers from 3 to 10000000, separated by commas, got '2'"),
            (("--sizes=500,x"), "--sizes: expected whole numbers"),
            (("--batch", "0"), "--batch: expected whole numbers from 1"),
            (("--isas", "sse9"), "which this machine has, got 'sse9'"),
            (("--isas",), "--isas: expected a value"),
        ):
            arguments = (arguments,) if isinstance(arguments, str) else arguments
            self.assertIn(says, self.run_bench(*arguments, code=2))

    def test_help_and_the_warning_about_debug(self):
        self.assertIn("--sizes N[,N...]", self.run_bench("--help"))
        ran = subprocess.run([BENCH, *QUICK, "--benchmark_filter=^clock$"], capture_output=True, text=True, check=True)
        self.assertIn('"Library was built as DEBUG" below is about Google Benchmark alone', ran.stderr)


if __name__ == "__main__":
    unittest.main()
