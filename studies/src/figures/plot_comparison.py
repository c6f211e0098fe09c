#!/usr/bin/env python3
"""Draws who solves what others do not, and how recall grows with the limit of success, of the pairs.csv and curves.csv of
a noise study or a comparison; of the latter the recall of each method on each group of cases as well.

Usage: plot_comparison.py DIR      writes DIR/comparison.svg and DIR/comparison.png
"""

import csv
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))  # where an isolated interpreter does not look by itself
from figure_style import PAGE_WIDTH, STYLE, plt, save  # noqa: E402

CONDITIONS = ("family", "scale", "points", "bound_factor")
ALL_GROUPS = "all groups"
# Okabe and Ito's colours; solvers beyond them get other strokes.
COLOURS = ["#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9", "#000000"]
STROKES = ["-", (0, (4, 2)), (0, (1, 1.5))]
ROW = 0.17  # inches of a pair
RECALL_ROW = 0.11  # inches of a group's method
CURVES = 1.9  # inches of a row of curves
MOST_CURVES = 4  # panels in a row
LEGEND_ROW = 0.16  # inches of a row of the legend


def read(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def cell_of(row):
    """What names the problems of a row: its group, or its condition and outlier ratio."""
    if "group" in row:
        return (row["group"],)
    return (*(row[name] for name in CONDITIONS), row["outlier_ratio"])


def labels_of(rows):
    """What tells the cells of rows from each other."""
    cells = list(dict.fromkeys(map(cell_of, rows)))
    if len(cells[0]) == 1:
        return {cell: cell[0] for cell in cells}
    varied = [len(set(values)) > 1 for values in zip(*cells)]
    words = ["{}", "scale {}", "{} points", "bound × {}"]
    labels = {}
    for cell in cells:
        parts = [text.format(value) for text, value, shown in zip(words, cell, varied) if shown]
        labels[cell] = ", ".join([*parts, f"{100 * float(cell[-1]):.4g} % outliers"])
    return labels


def is_together(row):
    """Whether it is of all noise levels, or of all groups."""
    return row["group"] == ALL_GROUPS if "group" in row else row["sigma"] == "nan"


def draw_differences(ax, pairs, labels):
    """A line a pair and cell: the difference of recall with its interval, and the p-value."""
    for k, row in enumerate(pairs):
        value, low, high = (100 * float(row["recall_difference" + end]) for end in ("", "_low", "_high"))
        significant = float(row["p_value_holm"]) <= 0.05
        colour = COLOURS[0] if significant else "0.6"
        ax.plot([low, high], [k, k], color=colour, linewidth=1.2)
        ax.plot([value], [k], "o", color=colour, markersize=3.5)
        p = float(row["p_value_holm"])
        ax.text(1.02, k, f"p = {p:.2g}", transform=ax.get_yaxis_transform(), va="center", fontsize=6, color=colour)
    ax.axvline(0, color="0.3", linewidth=0.8)
    ax.set_yticks(range(len(pairs)), [f"{row['a']} − {row['b']}, {labels[cell_of(row)]}" for row in pairs], fontsize=6)
    ax.set_ylim(len(pairs) - 0.5, -0.5)
    ax.set_xlabel("difference of recall (%) with its 95 % interval; p: McNemar, Holm", fontsize=7)


def style_of(k):
    return {"color": COLOURS[k % len(COLOURS)], "linestyle": STROKES[k // len(COLOURS) % len(STROKES)]}


def draw_recall(ax, curves, labels, solvers):
    """A line a group and solver: its recall with the interval. Curves that lie on one another are told apart here."""
    for g, (cell, label) in enumerate(labels.items()):
        top = g * (len(solvers) + 1)
        for k, solver in enumerate(solvers):
            mine = [row for row in curves if cell_of(row) == cell and row["solver"] == solver]
            if not mine:
                continue  # did not run on this group
            row = min(mine, key=lambda row: abs(float(row["threshold"]) - 1))
            value, low, high = (100 * float(row["recall" + end]) for end in ("", "_low", "_high"))
            ax.plot([low, high], [top + k] * 2, linewidth=1.2, **style_of(k))
            ax.plot([value], [top + k], "o", color=style_of(k)["color"], markersize=3.5)
            ax.text(1.02, top + k, f"{value:.3g} %", transform=ax.get_yaxis_transform(), va="center", fontsize=6)
        ax.text(-0.01, top + (len(solvers) - 1) / 2, label, transform=ax.get_yaxis_transform(), va="center", ha="right",
                fontsize=6)  # fmt: skip
    ax.set_yticks([])
    ax.set_ylim(len(labels) * (len(solvers) + 1) - 1.5, -1)
    ax.set_xlim(-2, 102)
    ax.set_xlabel("recall (%) with its 95 % interval (Wilson)", fontsize=7)


def draw_curves(axes, curves, labels, solvers):
    for ax, (cell, label) in zip(axes.flat, labels.items()):
        rows = [row for row in curves if cell_of(row) == cell]
        for k, solver in enumerate(solvers):
            mine = [row for row in rows if row["solver"] == solver]
            x = [float(row["threshold"]) for row in mine]
            recall, low, high = ([100 * float(row[name]) for row in mine] for name in ("recall", "recall_low", "recall_high"))
            ax.fill_between(x, low, high, color=style_of(k)["color"], alpha=0.12, linewidth=0)
            ax.plot(x, recall, **style_of(k))
        ax.axvline(1, color="0.5", linewidth=0.8, linestyle=(0, (4, 3)))
        ax.set_title(label, fontsize=7)
        ax.set_ylim(0, 102)
    for ax in list(axes.flat)[len(labels) :]:
        ax.set_axis_off()
    for ax in axes[:, 0]:
        ax.set_ylabel("recall (%)")
    for ax in axes[-1]:
        ax.set_xlabel("limit / study's")


def draw_comparison(folder):
    pairs = [row for row in read(folder / "pairs.csv") if is_together(row)]
    curves = read(folder / "curves.csv")
    labels = labels_of(curves)
    if len(labels) == 2:
        labels.pop((ALL_GROUPS,), None)  # all groups are the one
    solvers = list(dict.fromkeys(row["solver"] for row in curves))
    columns = min(MOST_CURVES, len(labels))
    rows = -(-len(labels) // columns)
    keys = min(5, len(solvers))
    heights = [ROW * len(pairs) + 0.5, CURVES * rows, LEGEND_ROW * (-(-len(solvers) // keys) + 1)]
    of_groups = "group" in curves[0]
    if of_groups:
        heights.insert(0, RECALL_ROW * len(labels) * (len(solvers) + 1) + 0.5)
    figure = plt.figure(figsize=(PAGE_WIDTH, sum(heights)), layout="constrained")
    *top, above, below, strip = figure.subfigures(len(heights), 1, height_ratios=heights)
    if of_groups:
        draw_recall(top[0].subplots(), curves, labels, solvers)
    draw_differences(above.subplots(), pairs, {**labels, (ALL_GROUPS,): ALL_GROUPS})
    draw_curves(below.subplots(rows, columns, squeeze=False, sharex=True, sharey=True), curves, labels, solvers)
    handles = [plt.Line2D([], [], label=solver, **style_of(k)) for k, solver in enumerate(solvers)]
    strip.legend(handles=handles, loc="center", ncol=keys, fontsize=6)
    save(figure, folder, "comparison")


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip())
    with plt.rc_context(STYLE):
        draw_comparison(Path(sys.argv[1]))


if __name__ == "__main__":
    main()
