#!/usr/bin/env python3
"""Draws recall and errors over the noise level from the cells.csv of a noise study, maps if there is a limits.csv,
and solvers beside each other if there are pairs.csv and curves.csv.

A cells.csv of your own will do. It needs the columns solver, outlier_ratio, sigma, recall, recall_low, recall_high,
rotation_error_deg_mean, translation_error_mean and those of the oracle; others are ignored. Columns family, scale,
points and bound_factor, where they are there and vary, make a row of panels for each combination.

Usage: plot_sweep.py DIR      writes DIR/recall.{svg,png}, DIR/errors.{svg,png}, DIR/map.{svg,png} and
                          DIR/comparison.{svg,png}
"""

import csv
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))  # where an isolated interpreter does not look by itself
from figure_style import COLUMN_WIDTH, PAGE_WIDTH, STYLE, plt, save  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402
from matplotlib.patches import Patch  # noqa: E402
from plot_comparison import draw_comparison  # noqa: E402
from plot_map import draw_map  # noqa: E402

# Okabe and Ito's colours, told apart with any colour vision; the markers tell the lines apart in greyscale.
COLOURS = ["#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9", "#000000"]
MARKERS = ["o", "s", "^", "D", "v", "P", "X"]
LEGEND_HEIGHT = 0.42
ERRORS = ["rotation_error_deg_mean", "translation_error_mean"]
COLUMNS = ["sigma", "recall", "recall_low", "recall_high", *ERRORS, *(f"oracle_{column}" for column in ERRORS)]


# What a study may vary beside outlier ratio and noise, each with the words for a value of it.
CONDITIONS = {"family": "{}", "scale": "scale {}", "points": "{} points", "bound_factor": "bound × {}"}


def condition_labels(rows):
    """What differs between conditions, by their values of CONDITIONS; one without a label if nothing does."""
    conditions = list(dict.fromkeys(tuple(row.get(name, "") for name in CONDITIONS) for row in rows))
    varied = [len(set(values)) > 1 for values in zip(*conditions)]
    labels = {}
    for condition in conditions:
        words = [text.format(value) for text, value, shown in zip(CONDITIONS.values(), condition, varied) if shown]
        labels[condition] = ", ".join(words).replace("bound × estimated", "bound estimated")
    return labels


class Study:
    """Curves over sigma by (condition and solver, outlier ratio): a dict of column name to list of floats."""

    def __init__(self, path):
        self.curves = {}
        with open(path, newline="") as file:
            rows = list(csv.DictReader(file))
        self.conditions = condition_labels(rows)
        for row in rows:
            condition = tuple(row.get(name, "") for name in CONDITIONS)
            curve = self.curves.setdefault(((condition, row["solver"]), float(row["outlier_ratio"])), {})
            for column in COLUMNS:
                curve.setdefault(column, []).append(float(row[column]))
        for curve in self.curves.values():
            order = sorted(range(len(curve["sigma"])), key=curve["sigma"].__getitem__)
            for column, values in curve.items():
                curve[column] = [values[i] for i in order]
        self.solvers = list(dict.fromkeys(solver for (_, solver), _ in self.curves))
        self.ratios = sorted({ratio for _, ratio in self.curves})

    def title(self, condition, solver):
        """What tells a panel from the others."""
        words = [self.conditions[condition], solver if len(self.solvers) > 1 else ""]
        return ": ".join(word for word in words if word)

    def lines(self, condition, solver):
        """(curve, plot style) of every outlier ratio of a solver."""
        for i, ratio in enumerate(self.ratios):
            curve = self.curves[(condition, solver), ratio]
            every = max(1, len(curve["sigma"]) // 10)
            # Markers of neighbouring lines are staggered: lines that coincide stay visible.
            yield curve, {**self.style(i), "markevery": (i * every // len(self.ratios), every)}

    @staticmethod
    def style(i):
        return {"color": COLOURS[i % len(COLOURS)], "marker": MARKERS[i % len(MARKERS)]}

    def ratio_handles(self):
        head = Line2D([], [], linestyle="none", label="outliers:")
        ratios = enumerate(self.ratios)
        return [head] + [Line2D([], [], label=f"{100 * ratio:g} %", **self.style(i)) for i, ratio in ratios]


def panels(rows, columns, width, height, **shared):
    """A figure, its rows x columns axes, and a strip of two lines below them for legends."""
    figure = plt.figure(figsize=(width, height + LEGEND_HEIGHT), layout="constrained")
    above, strip = figure.subfigures(2, 1, height_ratios=[height, LEGEND_HEIGHT])
    return figure, above.subplots(rows, columns, squeeze=False, **shared), strip


def add_legends(strip, study, kinds):
    """The outlier ratios on one line, what kinds of lines there are on the next."""
    handles = study.ratio_handles()
    strip.legend(handles=handles, loc="upper center", ncol=len(handles))
    strip.legend(handles=kinds, loc="lower center", ncol=len(kinds))


def draw_recall(study, folder):
    count = len(study.solvers)
    width = max(COLUMN_WIDTH, 2.4 * count, 0.57 * (1 + len(study.ratios)))
    figure, axes, strip = panels(len(study.conditions), count, width, 2.3 * len(study.conditions), sharey=True)
    lowest = 100.0
    for row, condition in zip(axes, study.conditions):
        for ax, solver in zip(row, study.solvers):
            for curve, style in study.lines(condition, solver):
                low, recall, high = ([100.0 * v for v in curve[c]] for c in ("recall_low", "recall", "recall_high"))
                ax.fill_between(curve["sigma"], low, high, color=style["color"], alpha=0.1, linewidth=0)
                ax.plot(curve["sigma"], recall, clip_on=False, **style)
                lowest = min(lowest, *low)
            ax.set_title(study.title(condition, solver))
        row[0].set_ylabel("recall (%)")
    for ax in axes[-1]:
        ax.set_xlabel("noise σ (m)")
    axes[0, 0].set_ylim(max(0.0, min(90.0, 5.0 * (lowest // 5.0))), 100.0)
    add_legends(strip, study, [Patch(color="0.8", linewidth=0, label="95 % interval (Wilson)")])
    save(figure, folder, "recall")


def draw_errors(study, folder):
    rows = [(condition, solver) for condition in study.conditions for solver in study.solvers]
    figure, axes, strip = panels(len(rows), 2, PAGE_WIDTH, 2.4 * len(rows), sharex=True, sharey="col")
    dashed = {"color": "black", "linewidth": 0.8, "linestyle": (0, (4, 3))}
    for row, (condition, solver) in zip(axes, rows):
        for ax, column, label in (
            (row[0], "rotation_error_deg_mean", "rotation error (deg)"),
            (row[1], "translation_error_mean", "translation error (m)"),
        ):
            for curve, style in study.lines(condition, solver):
                ax.plot(curve["sigma"], curve[column], linewidth=1.8, **style)
                ax.plot(curve["sigma"], curve[f"oracle_{column}"], **dashed)
            ax.set_yscale("log")
            ax.set_ylabel(label)
            ax.set_title(study.title(condition, solver))
    for ax in axes[-1]:
        ax.set_xlabel("noise σ (m)")
    kinds = [
        Line2D([], [], color="0.4", linewidth=1.8, label=f"{', '.join(study.solvers)}: mean of all trials"),
        Line2D([], [], label="oracle: least squares on the true inliers", **dashed),
    ]
    add_legends(strip, study, kinds)
    save(figure, folder, "errors")


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip())
    folder = Path(sys.argv[1])
    study = Study(folder / "cells.csv")
    with plt.rc_context(STYLE):
        draw_recall(study, folder)
        draw_errors(study, folder)
        if (folder / "limits.csv").exists():
            draw_map(folder)
        if (folder / "pairs.csv").exists():
            draw_comparison(folder)


if __name__ == "__main__":
    main()
