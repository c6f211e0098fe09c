"""consimd register --view and --picture: the files, and what a browser shows of the page."""

import random
import unittest
import xml.etree.ElementTree

from browser import BROWSER, MISSING, count, pixels, screenshot
from command import PLOTTER, CommandTest

LEGEND = 360  # columns that the legend covers


# Colours by what they look like: points are shaded, lines shine through.
def amber(r, g, b):
    return r > 110 and r > 1.2 * g and g > 1.5 * b


def blue(r, g, b):
    return b > 110 and b > 1.25 * g and g > 1.25 * r


def green(r, g, b):
    return g > 110 and g > 1.4 * r and g > 1.25 * b


def red(r, g, b):
    return r > 70 and r > 1.8 * g and r > 1.5 * b


def grey(r, g, b):
    return min(r, g, b) > 80 and max(r, g, b) < 1.5 * min(r, g, b)


class View(CommandTest):
    def pair(self):
        self.run_command("generate", "--out", "pair", "--points", 400, "--outliers", 0.6, "--sigma", 0.2)
        return "pair/correspondences.txt"

    def test_files(self):
        pair = self.pair()
        first = self.run_command("register", pair, "--noise-bound", 0.6, "--view", "view.html", "--picture", "view.svg")
        self.assertIn("status        success", first)
        page, drawing = self.folder / "view.html", self.folder / "view.svg"
        bytes_before = page.read_bytes(), drawing.read_bytes()
        self.run_command("register", pair, "--noise-bound", 0.6, "--threads", 1, "--view", "view.html", "--picture", "view.svg")
        self.assertEqual((page.read_bytes(), drawing.read_bytes()), bytes_before)
        self.assertIn(b"pair/correspondences.txt", bytes_before[0])
        root = xml.etree.ElementTree.fromstring(bytes_before[1])
        self.assertEqual(root.tag, "{http://www.w3.org/2000/svg}svg")
        self.assertEqual(len(root.findall(".//*[@class='placement']")), 2)

    def test_errors(self):
        pair = self.pair()
        self.assert_error("register", pair, "--view", "no/view.html", says="no/view.html: cannot write")
        self.assert_error("register", pair, "--picture", "view.gif", says="--picture: draws SVG or PNG, so expected a FILE.svg or FILE.png, got 'view.gif'")
        self.assert_error("register", pair, "--repeat", 2, "--view", "view.html", says="--view: writes one run, not --repeat of them")

    @unittest.skipIf(PLOTTER is None, "no Python with matplotlib")
    def test_png(self):
        """The colours of the drawing, in its place: before on the left, after on the right."""
        self.draw_for_real()
        pair = self.pair()
        self.run_command("register", pair, "--noise-bound", 0.6, "--picture", "view.png")
        rows = pixels((self.folder / "view.png").read_bytes())
        self.assertEqual((len(rows[0]), len(rows)), (1920, 948))
        left, right = ([row[:960] for row in rows], [row[960:] for row in rows])
        for half in (left, right):
            for colour in (amber, blue, green, red):
                self.assertGreater(count(half, colour), 300, colour)
        self.assertGreater(count(left, green), 3 * count(right, green))
        self.environment["CONSIMD_PYTHON"] = "/nowhere"
        self.run_command("register", pair, "--noise-bound", 0.6, "--picture", "none.png", code=2)
        self.assertFalse((self.folder / "none.png").exists())

    def shown(self, fragment="", keys="", script=""):
        """Counts of pixels by colour, and the columns between amber ones, after keys were pressed and a script ran."""
        page = self.folder / "view.html"
        press = f'for (const key of "{keys}") window.dispatchEvent(new KeyboardEvent("keydown", {{ key }}));'
        moved = self.folder / "moved.html"
        moved.write_text(page.read_text().replace("</body>", f"<script>{press}{script}</script></body>"))
        rows, console = screenshot(moved, fragment)
        self.assertEqual(console, [])
        counts = {colour.__name__: count(rows, colour, LEGEND) for colour in (amber, blue, green, red, grey)}
        columns = [x for row in rows for x in range(LEGEND, len(row)) if amber(*row[x])]
        return {**counts, "width": max(columns) - min(columns) if columns else 0}

    @unittest.skipUnless(BROWSER, MISSING)
    def test_before_and_after(self):
        """Before, long lines of inliers cross the picture; after, they are dots and the outliers' stay."""
        self.run_command("register", self.pair(), "--noise-bound", 0.6, "--view", "view.html")
        before, after = self.shown("#before"), self.shown("#after")
        for pixels in (before, after):
            for colour in ("amber", "blue", "green"):
                self.assertGreater(pixels[colour], 300, pixels)
            self.assertGreater(pixels["red"], 3000, pixels)
        self.assertGreater(before["green"], 3 * after["green"])

    @unittest.skipUnless(BROWSER, MISSING)
    def test_keys_and_mouse(self):
        """Space goes on to the next placement, O and S hide; the wheel zooms."""
        self.run_command("register", self.pair(), "--noise-bound", 0.6, "--view", "view.html")
        before = self.shown("#before")
        again = self.shown(keys=" os")  # from after
        self.assertLess(again["red"], 100, again)
        self.assertLess(again["amber"], before["amber"] / 3, again)
        self.assertGreater(again["green"], before["green"] / 2, again)
        wheel = 'document.getElementById("scene").dispatchEvent(new WheelEvent("wheel", { deltaY: 900 }));'
        farther = self.shown("#before", script=wheel)
        self.assertLess(farther["width"], before["width"] / 2, (farther, before))

    @unittest.skipUnless(BROWSER, MISSING)
    def test_without_a_pose(self):
        draw = random.Random(1)
        rows = (" ".join(str(draw.uniform(-100, 100)) for _ in range(6)) for _ in range(200))
        self.write("noise.txt", "\n".join(rows) + "\n")
        self.run_command("register", "noise.txt", "--noise-bound", 0.6, "--view", "view.html", code=1)
        pixels = self.shown()
        self.assertGreater(pixels["amber"], 300, pixels)
        self.assertGreater(pixels["blue"], 300, pixels)
        self.assertGreater(pixels["grey"], 3000, pixels)
        self.assertLess(pixels["green"] + pixels["red"], 100, pixels)


if __name__ == "__main__":
    unittest.main()
