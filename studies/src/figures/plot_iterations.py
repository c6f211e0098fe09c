#!/usr/bin/env python3
"""Draws recall over the iterations of plain RANSAC, with that of TCF, from the table_iterations.csv of a comparison.

Usage: plot_iterations.py DIR      writes DIR/iterations.{svg,png}
"""

import csv
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))  # where an isolated interpreter does not look by itself
from figure_style import COLUMN_WIDTH, STYLE, plt, save  # noqa: E402
from matplotlib.patches import Patch  # noqa: E402
from plot_sweep import COLOURS  # noqa: E402


class Recall:
    """A row of the table."""

    def __init__(self, row):
        self.value = float(row["recall %"])
        self.low, self.high = (float(end) for end in row["95 % interval"].split(" - "))
        self.milliseconds = float(row["time ms"])
        self.iterations = None if row["iterations"] == "-" else int(row["iterations"])
        self.expected = None if row["expected %"] == "-" else float(row["expected %"])


def read(path):
    """The rows of plain RANSAC by rising number of iterations, and the other solver's name and row."""
    with open(path, newline="") as file:
        rows = [(row["solver"], Recall(row)) for row in csv.DictReader(file)]
    ransac = sorted((recall for _, recall in rows if recall.iterations), key=lambda recall: recall.iterations)
    ((solver, rival),) = ((solver, recall) for solver, recall in rows if not recall.iterations)
    return ransac, solver, rival


def iterations_in(milliseconds, ransac):
    """How many iterations of plain RANSAC take as long: on the straight line between its neighbours, or beyond the ends
    in proportion to the nearest."""
    for few, many in zip(ransac, ransac[1:]):
        if few.milliseconds <= milliseconds < many.milliseconds:
            share = (milliseconds - few.milliseconds) / (many.milliseconds - few.milliseconds)
            return few.iterations + share * (many.iterations - few.iterations)
    nearest = ransac[0] if milliseconds < ransac[0].milliseconds else ransac[-1]
    return nearest.iterations * milliseconds / nearest.milliseconds


def rounded(number):
    """Two significant digits, thousands apart."""
    return f"{float(f'{number:.1e}'):,.0f}".replace(",", " ")


def draw(ransac, solver, rival, folder):
    figure, ax = plt.subplots(figsize=(COLUMN_WIDTH, 2.6), layout="constrained")
    iterations = [recall.iterations for recall in ransac]
    equal = iterations_in(rival.milliseconds, ransac)
    blue, orange = COLOURS[0], COLOURS[3]

    ax.axhspan(rival.low, rival.high, color=orange, alpha=0.15, linewidth=0)
    ax.axhline(rival.value, color=orange)
    label = f"{solver}: {rival.milliseconds:.2g} ms, as {rounded(equal)} samples"
    ax.plot(equal, rival.value, color=orange, marker="D", clip_on=False, zorder=4, label=label)
    lows, highs = [r.low for r in ransac], [r.high for r in ransac]
    ax.fill_between(iterations, lows, highs, color=blue, alpha=0.15, linewidth=0)
    ax.plot(iterations, [r.value for r in ransac], color=blue, marker="o", clip_on=False, zorder=3, label="plain RANSAC")
    ax.plot(
        iterations,
        [r.expected for r in ransac],
        color="black",
        linewidth=0.8,
        linestyle=(0, (4, 3)),
        label="expected of its samples",
    )
    ax.set_xscale("log")
    ax.set_xlim(min(*iterations, equal), max(*iterations, equal))
    ax.set_ylim(0.0, 102.0)
    ax.set_xlabel("iterations of plain RANSAC")
    ax.set_ylabel("recall (%)")
    band = Patch(color="0.8", linewidth=0, label="95 % interval")
    ax.legend(handles=[*ax.get_legend_handles_labels()[0], band], loc="center left", fontsize=7, bbox_to_anchor=(0.02, 0.75))
    save(figure, folder, "iterations")


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip())
    folder = Path(sys.argv[1])
    with plt.rc_context(STYLE):
        draw(*read(folder / "table_iterations.csv"), folder)


if __name__ == "__main__":
    main()
