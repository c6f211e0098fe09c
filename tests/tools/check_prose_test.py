"""What tools/check_prose.py finds in a page, and what it lets pass."""

import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "tools/check_prose.py"
WIDE = "word " * 20 + "word"  # 104 columns


class CheckProse(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.page = pathlib.Path(folder.name) / "page.md"
        (self.page.parent / "other.md").write_text("# The `other` page\n\n## What, then?\n")

    def faults(self, text):
        self.page.write_text(text)
        run = subprocess.run([sys.executable, SCRIPT, self.page], capture_output=True, text=True, check=False)
        self.assertEqual(run.returncode, 1 if run.stderr else 0)
        return [line.removeprefix(f"{self.page}:") for line in run.stderr.splitlines()]

    def test_prose_is_wrapped(self):
        self.assertEqual(self.faults("x" * 100 + "\n"), [])
        self.assertEqual(self.faults(f"A page\n\n- {WIDE}\n"), ["3: 106 columns, at most 100"])

    def test_tables_code_headings_pictures_and_written_tables_may_be_wide(self):
        self.assertEqual(
            self.faults(
                f"# {WIDE}\n| {WIDE} |\n![{WIDE}](other.md)\n```\n{WIDE}\n```\n"
                f"<!-- tables -->\n{WIDE}\n<!-- end of tables -->\n"
            ),
            [],
        )

    def test_prose_after_code_counts_again(self):
        self.assertEqual(self.faults(f"```\n```\n{WIDE}\n"), ["3: 104 columns, at most 100"])

    def test_links_lead_somewhere(self):
        self.assertEqual(self.faults("[a](other.md) [b](other.md#what-then) [c](other.md#the-other-page)\n"), [])
        self.assertEqual(self.faults("# Here\n[a](#here) [b](https://example.org/#there) `[c](nowhere)`\n"), [])
        self.assertEqual(self.faults("[a](nowhere.md)\n"), ["1: no file nowhere.md"])
        self.assertEqual(self.faults("[a](other.md#why)\n"), ["1: no heading #why in other.md"])
        self.assertEqual(self.faults("[a](#why)\n"), ["1: no heading #why in page.md"])


if __name__ == "__main__":
    unittest.main()
