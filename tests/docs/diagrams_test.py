"""The diagrams of the pages can be drawn and are shown."""

import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests"))
from plotter import PLOTTER  # noqa: E402

FIGURES = ROOT / "docs/figures"
DIAGRAMS = ["consensus_sets", "residual_mixture", "tcf_data_flow"]


@unittest.skipUnless(PLOTTER, "no Python with matplotlib")
class Diagrams(unittest.TestCase):
    def test_they_are_drawn_where_they_are_asked_for(self):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([PLOTTER, "-B", FIGURES / "diagrams.py", folder], check=True)
            drawn = sorted(file.name for file in pathlib.Path(folder).iterdir())
        self.assertEqual(drawn, [f"{name}.{kind}" for name in DIAGRAMS for kind in ("png", "svg")])

    def test_every_diagram_is_shown_on_a_page(self):
        pages = "".join(page.read_text(encoding="utf-8") for page in (ROOT / "docs").glob("*.md"))
        for name in DIAGRAMS:
            self.assertTrue((FIGURES / f"{name}.svg").exists())
            self.assertIn(f"(figures/{name}.svg)", pages)


if __name__ == "__main__":
    unittest.main()
