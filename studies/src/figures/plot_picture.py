#!/usr/bin/env python3
"""Draws picture.svg of a folder, a drawing of `consimd register --picture`, as picture.png.

Usage: plot_picture.py DIR

It knows what such a drawing has: groups that are moved, rectangles, circles, lines of text, and paths of dots and of
straight lines.
"""

import re
import sys
from pathlib import Path
from xml.etree import ElementTree

sys.path.insert(0, str(Path(__file__).resolve().parent))
from figure_style import plt  # noqa: E402
from matplotlib.collections import LineCollection  # noqa: E402
from matplotlib.patches import Circle, Rectangle  # noqa: E402

UNITS = 100  # of the drawing, an inch
DOTS = 2  # pixels a unit
POINT = 72 / UNITS  # points a unit
SVG = "{http://www.w3.org/2000/svg}"
NUMBER = r"-?[\d.]+"


def numbers(text):
    return [float(number) for number in re.findall(NUMBER, text)]


class Drawing:
    def __init__(self, root):
        _, _, self.width, self.height = numbers(root.get("viewBox"))
        self.ink = root.get("fill")
        self.sizes = {"": float(root.get("font-size"))}
        self.bold = set()
        for name, rules in re.findall(r"\.(\w+) {([^}]*)}", root.findtext(f"{SVG}style")):
            self.sizes[name] = next(iter(numbers(rules.split("font-weight")[0])), self.sizes[""])
            if "font-weight" in rules:
                self.bold.add(name)
        self.figure = plt.figure(figsize=(self.width / UNITS, self.height / UNITS))
        self.axes = self.figure.add_axes((0, 0, 1, 1), xlim=(0, self.width), ylim=(self.height, 0))
        self.axes.axis("off")
        self.order = 0
        self.group(root, 0.0, 0.0)

    def group(self, group, x, y):
        for element in group:
            self.order += 1
            kind = element.tag.removeprefix(SVG)
            if kind == "g":
                dx, dy = numbers(element.get("transform"))
                self.group(element, x + dx, y + dy)
            elif kind != "style":
                getattr(self, kind)(element, x, y)

    def rect(self, element, x, y):
        size = float(element.get("width")), float(element.get("height"))
        self.axes.add_patch(Rectangle((x, y), *size, color=element.get("fill"), linewidth=0, zorder=self.order))

    def circle(self, element, x, y):
        centre = x + float(element.get("cx")), y + float(element.get("cy"))
        self.axes.add_patch(Circle(centre, float(element.get("r")), color=element.get("fill"), linewidth=0, zorder=self.order))

    def text(self, element, x, y):
        kind = element.get("class", "")
        at = x + float(element.get("x", 0)), y + float(element.get("y", 0))
        weight = "bold" if kind in self.bold else "normal"
        self.axes.text(*at, element.text or "", color=self.ink, fontsize=POINT * self.sizes[kind], fontweight=weight,
                       parse_math=False, zorder=self.order)  # fmt: skip

    def path(self, element, x, y):
        colour, width = element.get("stroke"), POINT * float(element.get("stroke-width", 1))
        style = {"alpha": float(element.get("stroke-opacity", 1)), "zorder": self.order}
        steps, dots, lines = element.get("d"), [], []
        for start, end in re.findall(rf"M({NUMBER} {NUMBER})((?:[hHVL]{NUMBER}(?: {NUMBER})?)*)", steps):
            px, py = numbers(start)
            to = numbers(end)
            if end.startswith("h"):
                dots.append((x + px, y + py))
            else:
                # Lines between panels have one coordinate: across or down.
                qx, qy = to if len(to) == 2 else (to[0], py) if end.startswith("H") else (px, to[0])
                lines.append([(x + px, y + py), (x + qx, y + qy)])
        if dots:
            self.axes.scatter(*zip(*dots), s=width**2, color=colour, linewidths=0, **style)
        if lines:
            self.axes.add_collection(LineCollection(lines, colors=colour, linewidths=width, capstyle="round", **style))


def main(arguments):
    if len(arguments) != 1:
        sys.exit(__doc__.strip())
    folder = Path(arguments[0])
    drawing = Drawing(ElementTree.parse(folder / "picture.svg").getroot())
    drawing.figure.savefig(folder / "picture.png", dpi=UNITS * DOTS)


if __name__ == "__main__":
    main(sys.argv[1:])
