"""Maps over outlier ratio and noise, with the limit that chance sets, from the cells.csv and limits.csv of a study."""

import csv
import math

from figure_style import PAGE_WIDTH, plt, save
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, LogNorm, Normalize
from matplotlib.lines import Line2D

ROW_HEIGHT = 2.1  # inches
LEGEND_HEIGHT = 0.25
CELL_FONT = 6.0  # points
TICK_FONT = 6.5
MOST_FRAMED = 20  # cells in a row or column that still get a frame
# One hue from light to dark, and orange: told apart with any colour vision. Light is good in every panel.
HIGH_IS_GOOD, LOW_IS_GOOD = "Blues_r", "Blues"
LIMIT = {"color": "#D55E00", "linewidth": 1.6, "marker": ".", "markersize": 4}
QUOTIENTS = [1.03, 1.1, 1.25, 2.0, 10.0]
ERRORS = (("rotation", "rotation_error_deg_mean", "deg"), ("translation", "translation_error_mean", "m"))


def read(path):
    """The rows of a table as dicts of floats, solver names aside."""
    with open(path, newline="") as file:
        return [{k: v if k == "solver" else float(v) for k, v in row.items()} for row in csv.DictReader(file)]


def nines(ratio):
    """Where an outlier ratio stands: 90 % at 1, 99 % at 2. Equal steps divide the inliers by equal factors."""
    return -math.log10(max(1.0 - ratio, 1e-9))


def edges(places):
    """Borders of cells around ascending places: half-way between neighbours, symmetric at the ends."""
    if len(places) == 1:
        return [places[0] - 0.15, places[0] + 0.15]
    middles = [(a + b) / 2 for a, b in zip(places, places[1:])]
    return [2 * places[0] - middles[0], *middles, 2 * places[-1] - middles[-1]]


def short(value):
    """Two digits, or a whole number."""
    return f"{value:.0f}" if value >= 9.95 else f"{float(f'{value:.2g}'):g}"


def quotient(value):
    return f"{value:.0f}" if value >= 9.995 else f"{value:.2f}"


def text_width(text, font):
    """Of a number, in points."""
    return font * sum(0.32 if letter == "." else 0.64 for letter in text)


def spread(labels, places, sizes):
    """The labels without those that would touch the one before; `places` and `sizes` in one unit."""
    kept, free = [], -math.inf
    for label, place, size in zip(labels, places, sizes):
        fits = place - size / 2 >= free
        kept.append(label if fits else "")
        free = place + size / 2 if fits else free
    return kept


def log_norm(values):
    return LogNorm(min(values), max(max(values), 1.01 * min(values)))


class Panel:
    """A grid of values over outlier ratio (to the right) and noise (up), both on logarithmic scales."""

    def __init__(self, ax, title, cells, value, text):
        self.ax, self.text = ax, text
        self.values = {(row["outlier_ratio"], row["sigma"]): value(row) for row in cells}
        self.ratios = sorted({ratio for ratio, _ in self.values})
        self.sigmas = sorted({sigma for _, sigma in self.values})
        self.x = edges([nines(ratio) for ratio in self.ratios])
        self.y = edges([math.log10(sigma) for sigma in self.sigmas])
        ax.set_title(title)
        ax.grid(False)
        ax.tick_params(length=0, labelsize=TICK_FONT)
        self.label_axes()
        for spine in ax.spines.values():
            spine.set_visible(False)

    def label_axes(self, x_points=math.inf, y_points=math.inf):
        """All ratios and noise levels, or those that have room on axes of so many points per unit."""
        places = [nines(ratio) for ratio in self.ratios]
        labels = [f"{100 * ratio:.4g}" for ratio in self.ratios]
        sizes = [(text_width(label, TICK_FONT) + 2) / x_points for label in labels]
        self.ax.set_xticks(places, spread(labels, places, sizes))
        places = [math.log10(sigma) for sigma in self.sigmas]
        labels = [f"{sigma:g}" for sigma in self.sigmas]
        self.ax.set_yticks(places, spread(labels, places, [1.1 * TICK_FONT / y_points] * len(labels)))

    def colour(self, norm, colours, ticks=None):
        self.norm, self.colours = norm, plt.get_cmap(colours)
        grid = [[self.values[ratio, sigma] for ratio in self.ratios] for sigma in self.sigmas]
        cells = self.ax.pcolormesh(self.x, self.y, grid, norm=norm, cmap=self.colours)
        if max(len(self.ratios), len(self.sigmas)) <= MOST_FRAMED:
            cells.set(edgecolor="0.85", linewidth=0.4)
        scale = ScalarMappable(norm, self.colours)
        bar = self.ax.figure.colorbar(scale, ax=self.ax, fraction=0.07, aspect=20, pad=0.0, ticks=ticks, format="{x:g}")
        bar.ax.minorticks_off()
        bar.ax.tick_params(length=2, labelsize=TICK_FONT)
        bar.outline.set_visible(False)

    def draw_limit(self, limits):
        points = sorted((row["sigma"], row["limit_outlier_ratio"]) for row in limits)
        self.ax.plot([nines(limit) for _, limit in points], [math.log10(sigma) for sigma, _ in points], **LIMIT)

    def write(self):
        """Values into the cells, and labels beside the axes, where there is room. The layout must be final."""
        inches = self.ax.get_window_extent().transformed(self.ax.figure.dpi_scale_trans.inverted())
        (left, right), (low, high) = self.ax.get_xlim(), self.ax.get_ylim()
        x_points, y_points = 72 * inches.width / (right - left), 72 * inches.height / (high - low)
        self.label_axes(x_points, y_points)
        for i, sigma in enumerate(self.sigmas):
            height = y_points * (self.y[i + 1] - self.y[i])
            for j, ratio in enumerate(self.ratios):
                width = x_points * (self.x[j + 1] - self.x[j])
                value = self.values[ratio, sigma]
                if height < 1.2 * CELL_FONT or width < text_width(self.text(value), CELL_FONT) + 1:
                    continue
                red, green, blue, _ = self.colours(self.norm(value))
                self.ax.text(
                    (self.x[j] + self.x[j + 1]) / 2,
                    (self.y[i] + self.y[i + 1]) / 2,
                    self.text(value),
                    color="black" if 0.299 * red + 0.587 * green + 0.114 * blue > 0.5 else "white",
                    fontsize=CELL_FONT,
                    ha="center",
                    va="center_baseline",
                    zorder=4,
                )


def draw_solver(axes, cells, name):
    """The panels of one solver's cells on two rows of axes."""
    recall = Panel(axes[0, 0], f"{name}recall (%)", cells, lambda row: 100 * row["recall"], "{:.0f}".format)
    recall.colour(Normalize(0, 100), HIGH_IS_GOOD)
    time = Panel(axes[0, 1], f"{name}median time (ms)", cells, lambda row: 1e3 * row["seconds_median"], short)
    time.colour(log_norm(time.values.values()), LOW_IS_GOOD)
    panels = [recall, time]
    for ax, (what, column, _) in zip(axes[1], ERRORS):
        title = f"{name}{what} error / oracle's"
        panels.append(Panel(ax, title, cells, lambda row, c=column: row[c] / row[f"oracle_{c}"], quotient))
        steps = BoundaryNorm(QUOTIENTS, plt.get_cmap(LOW_IS_GOOD).N, extend="both")
        panels[-1].colour(steps, LOW_IS_GOOD, QUOTIENTS)
    return panels


def draw_oracle(axes, cells):
    panels = []
    for ax, (what, column, unit) in zip(axes, ERRORS):
        title = f"oracle's {what} error ({unit})"
        panels.append(Panel(ax, title, cells, lambda row, c=column: row[f"oracle_{c}"], short))
        panels[-1].colour(log_norm(panels[-1].values.values()), LOW_IS_GOOD)
    return panels


def draw_map(folder):
    cells, limits = read(folder / "cells.csv"), read(folder / "limits.csv")
    by_solver = {}
    for row in cells:
        by_solver.setdefault(row["solver"], []).append(row)

    height = ROW_HEIGHT * (2 * len(by_solver) + 1)
    figure = plt.figure(figsize=(PAGE_WIDTH, height + LEGEND_HEIGHT), layout="constrained")
    above, strip = figure.subfigures(2, 1, height_ratios=[height, LEGEND_HEIGHT])
    axes = above.subplots(2 * len(by_solver) + 1, 2)
    panels = draw_oracle(axes[-1], next(iter(by_solver.values())))
    for i, (solver, its_cells) in enumerate(by_solver.items()):
        panels += draw_solver(axes[2 * i : 2 * i + 2], its_cells, f"{solver}: " if len(by_solver) > 1 else "")
    for ax in axes[-1]:
        ax.set_xlabel("outliers (%)")
    for ax in axes[:, 0]:
        ax.set_ylabel("noise σ (m)")
    for panel in panels:
        panel.draw_limit(limits)
    line = Line2D([], [], label="limit: the best wrong pose has as much support as the true one", **LIMIT)
    strip.legend(handles=[line], loc="center")

    figure.canvas.draw()
    figure.set_layout_engine("none")
    for panel in panels:
        panel.write()
    save(figure, folder, "map")
