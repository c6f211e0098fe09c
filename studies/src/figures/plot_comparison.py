"""Who solves what others do not, and how recall grows with the limit of success: comparison.svg of a study."""

import csv

from figure_style import PAGE_WIDTH, plt, save

CONDITIONS = ("family", "scale", "points", "bound_factor")
COLOURS = ["#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9", "#000000"]
ROW = 0.17  # inches of a pair
CURVES = 1.9  # inches of a row of curves
MOST_CURVES = 4  # panels in a row


def read(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def labels_of(rows):
    """What tells the cells of rows from each other, by condition and outlier ratio."""
    cells = list(dict.fromkeys((*(row[name] for name in CONDITIONS), row["outlier_ratio"]) for row in rows))
    varied = [len(set(values)) > 1 for values in zip(*cells)]
    words = ["{}", "scale {}", "{} points", "bound × {}"]
    labels = {}
    for cell in cells:
        parts = [text.format(value) for text, value, shown in zip(words, cell, varied) if shown]
        labels[cell] = ", ".join([*parts, f"{100 * float(cell[-1]):.4g} % outliers"])
    return labels


def cell_of(row):
    return (*(row[name] for name in CONDITIONS), row["outlier_ratio"])


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


def draw_curves(axes, curves, labels):
    for ax, (cell, label) in zip(axes.flat, labels.items()):
        rows = [row for row in curves if cell_of(row) == cell]
        for colour, solver in zip(COLOURS, dict.fromkeys(row["solver"] for row in rows)):
            mine = [row for row in rows if row["solver"] == solver]
            x = [float(row["threshold"]) for row in mine]
            recall, low, high = ([100 * float(row[name]) for row in mine] for name in ("recall", "recall_low", "recall_high"))
            ax.fill_between(x, low, high, color=colour, alpha=0.12, linewidth=0)
            ax.plot(x, recall, color=colour, label=solver)
        ax.axvline(1, color="0.5", linewidth=0.8, linestyle=(0, (4, 3)))
        ax.set_title(label, fontsize=7)
        ax.set_ylim(0, 102)
    for ax in list(axes.flat)[len(labels) :]:
        ax.set_axis_off()
    for ax in axes[:, 0]:
        ax.set_ylabel("recall (%)")
    for ax in axes[-1]:
        ax.set_xlabel("limit of RMSE / study's", fontsize=7)
    axes[0, 0].legend(fontsize=6, loc="lower right")


def draw_comparison(folder):
    pairs = [row for row in read(folder / "pairs.csv") if row["sigma"] == "nan"]
    curves = read(folder / "curves.csv")
    labels = labels_of(curves)
    columns = min(MOST_CURVES, len(labels))
    rows = -(-len(labels) // columns)
    heights = [ROW * len(pairs) + 0.5, CURVES * rows]
    figure = plt.figure(figsize=(PAGE_WIDTH, sum(heights)), layout="constrained")
    above, below = figure.subfigures(2, 1, height_ratios=heights)
    draw_differences(above.subplots(), pairs, labels)
    draw_curves(below.subplots(rows, columns, squeeze=False, sharex=True, sharey=True), curves, labels)
    save(figure, folder, "comparison")
