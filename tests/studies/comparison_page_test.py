"""studies/src/compare/comparison_page.py: tables of a page renewed from the commands above them."""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "studies/src/compare/comparison_page.py"

# Stands for the command: writes its own arguments as the table and as a figure, or fails.
PROGRAM = """#!{python}
import pathlib, sys
if "fail" in sys.argv: sys.exit(3)
folder, text = pathlib.Path(sys.argv[sys.argv.index("--out") + 1]), " ".join(sys.argv[2:-2])
(folder / "tables.md").write_text("| " + text + " |\\n")
(folder / "curve.svg").write_text(text)
"""

BLOCK = "```\nconsimd compare {}\n```\n<!-- tables -->\n{}<!-- end of tables -->\n"


class ComparisonPage(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        program = self.folder / "consimd"
        program.write_text(PROGRAM.format(python=sys.executable))
        program.chmod(0o755)
        self.page = self.folder / "page.md"

    def renew(self, *word, code=0, **environment):
        process = subprocess.run(
            [sys.executable, "-B", SCRIPT, self.page, *word],
            env={"PATH": f"{self.folder}:{os.environ['PATH']}", **environment},
            capture_output=True,
            text=True,
        )
        self.assertEqual(process.returncode, code, process.stderr)
        return process.stderr

    def test_tables_are_those_of_their_commands(self):
        self.page.write_text("# Page\n\n" + BLOCK.format("--table a", "") + "\nText.\n\n" + BLOCK.format("--table b", "old\n"))
        self.renew()
        expected = "# Page\n\n{}\nText.\n\n{}".format(
            BLOCK.format("--table a", "\n| --table a |\n\n"), BLOCK.format("--table b", "\n| --table b |\n\n")
        )
        self.assertEqual(self.page.read_text(), expected)
        self.renew()
        self.assertEqual(self.page.read_text(), expected)

    def test_a_word_chooses(self):
        self.page.write_text(BLOCK.format("--table a", "") + BLOCK.format("--table b", "old\n"))
        self.renew("e a")
        self.assertEqual(
            self.page.read_text(), BLOCK.format("--table a", "\n| --table a |\n\n") + BLOCK.format("--table b", "old\n")
        )
        self.assertIn("no command holds 'c'", self.renew("c", code=1))

    def test_variables(self):
        block = BLOCK.format("--cases $DATA/c", "old\n")
        self.page.write_text(block)
        self.assertIn("left out, DATA not set", self.renew())
        self.assertEqual(self.page.read_text(), block)
        self.renew(DATA="here")
        self.assertIn("| --cases here/c |", self.page.read_text())

    def test_figures_that_the_page_shows(self):
        figures = self.folder / "figures"
        figures.mkdir()
        block = BLOCK.format("--table a", "")
        self.page.write_text(block + "![Other](figures/other.svg)\n")
        self.renew()
        self.assertEqual(list(figures.iterdir()), [])
        self.page.write_text(block + "![Curve](figures/curve.svg)\n")
        self.renew()
        self.assertEqual((figures / "curve.svg").read_text(), "--table a")

    def test_a_failure_keeps_what_is_done(self):
        self.page.write_text(BLOCK.format("a", "") + BLOCK.format("fail", "old\n"))
        self.assertIn("exit status 3", self.renew(code=1))
        self.assertEqual(self.page.read_text(), BLOCK.format("a", "\n| a |\n\n") + BLOCK.format("fail", "old\n"))

    def test_the_projects_page_has_commands_with_tables(self):
        text = (ROOT / "docs/comparison.md").read_text()
        self.assertEqual(text.count("```\nconsimd compare"), text.count("<!-- tables -->"))
        self.assertEqual(text.count("<!-- tables -->"), text.count("<!-- end of tables -->"))
        self.assertGreater(text.count("<!-- tables -->"), 0)


if __name__ == "__main__":
    unittest.main()
