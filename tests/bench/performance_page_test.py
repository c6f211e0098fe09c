"""The tables of docs/performance.md against the results that are kept beside it."""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCRIPTS = ROOT / "bench/micro"
sys.path[:0] = [str(SCRIPTS), str(ROOT / "tests")]
from bench_results import PortBounds, Results  # noqa: E402
from plotter import PLOTTER  # noqa: E402
from report import tables  # noqa: E402


def entry(name, aggregate, **values):
    return {"run_name": name, "run_type": "aggregate", "aggregate_name": aggregate, "family_index": 0, **values}


BOUNDS = SCRIPTS / "port_bounds_zen4.json"


class PerformancePage(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_tables_are_those_of_the_kept_results(self):
        page = (ROOT / "docs/performance.md").read_text(encoding="utf-8")
        all_tables = list(tables(Results(ROOT / "docs/performance.json"), PortBounds(BOUNDS)))
        shown = [table for table in all_tables if table.splitlines()[0] in page]
        self.assertGreaterEqual(len(shown), 5)
        self.assertIn(all_tables[0], shown)  # of the ports
        for table in shown:
            self.assertIn(table, page)

    def test_keeps_medians_and_no_host(self):
        name = "register_tcf/size:1000/iterations:50/manual_time"
        median = {"real_time": 0.25, "median_ms": 0.212345, "recall": 0.98, "refinement_ms": 0.05, "peak_mib": 1.5}
        run = {
            "context": {"host_name": "somewhere", "executable": "/some/where", "cpu": "a processor", "caches": []},
            "benchmarks": [
                entry("copies/3000/avx2", "mean", items_per_second=5e9),
                entry("copies/3000/avx2", "median", items_per_second=4e9, label="bytes"),
                entry(name, "cv", median_ms=0.03, real_time=0.5),
                entry(name, "median", **median),
            ],
        }
        (self.folder / "bench.json").write_text(json.dumps(run), encoding="utf-8")
        Results(self.folder / "bench.json").keep(self.folder / "kept.json")
        kept = Results(self.folder / "kept.json")
        self.assertNotIn("where", (self.folder / "kept.json").read_text(encoding="utf-8"))
        self.assertEqual(kept.context, {"cpu": "a processor", "caches": []})
        self.assertEqual(kept.values["copies/3000/avx2"], {"items": "bytes", "items_per_second": 4e9})
        self.assertEqual(
            kept.values["register_tcf/size:1000"],
            {"mean_ms": 0.25, "median_ms": 0.2123, "recall": 0.98, "refinement_ms": 0.05, "peak_mib": 1.5, "cv": 0.03},
        )
        self.assertIn("| 1000 | 0.212 (98 %) | 212 | 1.50 | 0.02 |", "".join(tables(kept)))

    @unittest.skipIf(PLOTTER is None, "no Python with matplotlib")
    def test_figures(self):
        script = [PLOTTER, "-B", SCRIPTS / "plot_performance.py", ROOT / "docs/performance.json", self.folder]
        subprocess.run([*script, BOUNDS], check=True)
        self.assertIn("bound by the ports, avx512", (self.folder / "kernel_rates.svg").read_text(encoding="utf-8"))
        for figure in ("kernel_rates", "time_over_size", "recall_over_time"):
            self.assertGreater((self.folder / f"{figure}.svg").stat().st_size, 10_000)


if __name__ == "__main__":
    unittest.main()
