"""--report of sweep, merge and compare: the page holds the numbers of the files, and a browser shows them."""

import csv
import html
import json
import re
import shlex
import sys
import unittest

from browser import BROWSER, MISSING, count, document, screenshot
from command import CommandTest

SWEEP = ("sweep", "--points", 200, "--outliers", "0.2,0.9", "--sigma", "0.5,1,5", "--trials", 4, "--solver", "tcf,ransac")
COMPARE = ("compare", "--synthetic", "trees,arch", "--trials", 2, "--solver", "tcf,ransac")


# A program that finds no pose.
CLIENT = r"""
import sys
print("ready 1", flush=True)
while head := sys.stdin.readline():
    for _ in range(int(head.split()[0])):
        sys.stdin.readline()
    print("none", flush=True)
"""


# Colours of the first two series, by day and by night.
def blue(r, g, b):
    return r < 110 and b > 150 and b > 1.3 * g


def orange(r, g, b):
    return r > 190 and 70 < g < 160 and b < 90


def pale(r, g, b):
    return min(r, g, b) > 240


def light(r, g, b):
    return min(r, g, b) > 200


def dark(r, g, b):
    return max(r, g, b) < 60


class Report(CommandTest):
    def page(self, *arguments, code=0):
        self.run_command(*arguments, "--report", "report.html", code=code)
        return (self.folder / "report.html").read_text(encoding="utf-8")

    def data_of(self, text):
        return json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.S).group(1))

    def rows_of(self, text, name):
        (table,) = (table for table in self.data_of(text)["tables"] if table["name"] == name)
        return table["rows"]

    def assert_rows(self, rows, file):
        """The rows have the numbers of a CSV file."""
        with open(self.folder / file, newline="", encoding="utf-8") as lines:
            expected = list(csv.DictReader(lines))
        self.assertEqual(len(rows), len(expected))
        for row, wanted in zip(rows, expected):
            self.assertEqual(list(row.keys() - wanted.keys()), [])
            for column, text in wanted.items():
                value = row[column] if isinstance(row[column], str) else float(row[column])
                self.assertEqual(value, text if isinstance(value, str) else float(text), (column, row))

    def test_page_of_a_sweep(self):
        text = self.page(*SWEEP, "--out", "study")
        rows = self.rows_of(text, "cells")
        self.assert_rows(rows, "study/cells.csv")
        (tcf, ransac) = self.rows_of(text, "solvers")
        self.assertEqual((tcf["solver"], tcf["cells"], tcf["trials"], ransac["solver"]), ("tcf", 6, 24, "ransac"))
        for table, file in (("pairs", "pairs.csv"), ("precision", "solvers.csv"), ("curves", "curves.csv")):
            self.assert_rows(self.rows_of(text, table), f"study/{file}")
        self.assertEqual(tcf["successes"], round(sum(4 * row["recall"] for row in rows if row["solver"] == "tcf")))
        self.assertIn("--solver tcf,ransac --out study --report report.html</pre>", text)
        cpu = json.loads((self.folder / "study/summary.json").read_text(encoding="utf-8"))["machine"]["cpu"]
        self.assertIn(f"<th>machine cpu</th><td>{cpu}</td>", text)
        self.assertIn("<th>complete</th><td>true</td>", text)
        # Nothing is fetched from anywhere.
        self.assertEqual(re.findall(r'(?:src|href)="(?!data:)[^"]*"|@import|url\(', text), [])
        self.assertEqual(self.page(*SWEEP, "--out", "study"), text)

    def test_page_of_shards(self):
        for shard in ("1/2", "2/2"):
            self.run_command(*SWEEP, "--out", "study", "--shard", shard)
        text = self.page("merge", "study")
        self.assert_rows(self.rows_of(text, "cells"), "study/cells.csv")
        self.assert_error(*SWEEP, "--shard", "1/2", "--report", "r.html", says="--report: a shard has no cells")

    def test_page_of_a_comparison(self):
        text = self.page(*COMPARE, "--out", "runs")
        rows = self.rows_of(text, "methods")
        self.assertEqual({(row["group"], row["method"], row["runs"]) for row in rows},
                         {(group, method, 2) for group in ("trees", "arch") for method in ("tcf", "ransac")})
        for table, file in (("table_solvers", "table_solvers.csv"), ("table_pairs", "table_pairs.csv"),
                            ("pairs", "pairs.csv"), ("precision", "solvers.csv"), ("curves", "curves.csv")):
            self.assert_rows(self.rows_of(text, table), f"runs/{file}")
        self.assertIn("--synthetic trees,arch --trials 2 --solver tcf,ransac --out runs --report report.html</pre>", text)

    def test_in_the_output_folder(self):
        self.run_command(*SWEEP, "--out", "new", "--report", "new/report.html")
        self.assertTrue((self.folder / "new/report.html").exists())

    def test_names_are_only_text(self):
        """The command of a program may hold what ends a script; the page shows it as a shell takes it."""
        self.write("none.py", CLIENT)
        solver = f"mine=exec:{sys.executable} none.py '</script><b>&'"
        text = self.page(*SWEEP[:-2], "--solver", solver, "--out", "study")
        self.assertEqual(text.count("</script>"), 2)
        self.assertEqual(shlex.split(html.unescape(re.search(r'<pre id="command">(.*?)</pre>', text, re.S)[1]))[-5], solver)

    def test_errors_come_before_the_study(self):
        for command in (SWEEP, COMPARE, ("merge", "study")):
            if command[0] == "merge":
                self.run_command(*SWEEP, "--out", "study", "--shard", "1/1")
            out = () if command[0] == "merge" else ("--out", "never")
            self.assert_error(*command, *out, "--report", "no/report.html", says="no/report.html: cannot write")
            says = "r.pdf: expected a name that ends in .html"
            self.assert_error(*command, *out, "--report", "r.pdf", says=says)

    def shown(self, text, script):
        page = self.folder / "shown.html"
        page.write_text(text.replace("</body>", f"<script>{script}</script></body>"), encoding="utf-8")
        return page

    HOVER = """
      const svg = document.querySelector(".panel svg"), box = svg.getBoundingClientRect();
      svg.dispatchEvent(new PointerEvent("pointermove", { clientX: box.left + 0.5 * box.width, clientY: box.top + 2 }));"""

    @unittest.skipUnless(BROWSER, MISSING)
    def test_hover_tells_the_cell(self):
        text = self.page(*SWEEP, "--out", "study")
        shown, console = document(self.shown(text, self.HOVER))
        self.assertEqual(console, [])
        told = dict(re.findall(r"<tr><th>([^<]*)</th><td>([^<]*)</td></tr>", shown[shown.index('<div id="tip"'):]))
        keys = ("solver", "outlier_ratio", "sigma")
        spelt = lambda value: value if isinstance(value, str) else f"{value:.4g}"
        (row,) = (
            row for row in self.rows_of(text, "cells")
            if all(spelt(row[key]) == told[key.replace("_", " ")] for key in keys)
        )  # fmt: skip
        for column, value in row.items():
            found = told[column.replace("_", " ")]
            self.assertEqual(found if isinstance(value, str) else f"{float(found):.4g}", spelt(value), column)

    @unittest.skipUnless(BROWSER, MISSING)
    def test_tables_sort(self):
        text = self.page(*SWEEP, "--out", "study")
        times = [row["seconds_median"] for row in self.rows_of(text, "cells")]
        click = """
          const ths = document.querySelectorAll('[aria-label="All cells"] th');
          for (let i = 0; i < CLICKS; ++i) ths[ths.length - 1].click();"""
        for clicks, wanted in ((0, times), (1, sorted(times)), (2, sorted(times, reverse=True))):
            shown, console = document(self.shown(text, click.replace("CLICKS", str(clicks))))
            self.assertEqual(console, [])
            table = re.search(r'aria-label="All cells">.*?<tbody>(.*?)</tbody>', shown, re.S)[1]
            lines = (re.findall(r"<td[^>]*>([^<]*)</td>", line) for line in table.split("</tr>"))
            found = [float(cells[-1]) for cells in lines if cells]
            self.assertEqual(found, [float(f"{value:.4g}") for value in wanted])

    @unittest.skipUnless(BROWSER, MISSING)
    def test_by_day_and_by_night(self):
        """Lines of both solvers are there, and the tip over them."""
        text = self.page(*SWEEP, "--out", "study")
        for options, ground, ink in (((), pale, dark), (("--force-dark-mode",), dark, light)):
            rows, console = screenshot(self.shown(text, ""), height=1400, options=options)
            self.assertEqual(console, [])
            self.assertGreater(count(rows, ground), 1_000_000)
            self.assertGreater(count(rows, blue), 300)
            self.assertGreater(count(rows, orange), 300)
            hovered, _ = screenshot(self.shown(text, self.HOVER), options=options)
            self.assertGreater(count(hovered, ink), 30_000)

    @unittest.skipUnless(BROWSER, MISSING)
    def test_comparison_in_a_browser(self):
        text = self.page(*COMPARE, "--out", "runs")
        shown, console = document(self.shown(text, self.HOVER))
        self.assertEqual(console, [])
        self.assertEqual(re.findall(r"<h3>([^<]*)</h3>", shown), 2 * ["arch", "trees"] + ["group arch", "group trees", "group all groups"])
        self.assertIn("<tr><th>method</th><td>tcf</td></tr>", shown)


if __name__ == "__main__":
    unittest.main()
