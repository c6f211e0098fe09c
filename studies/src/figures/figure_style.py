"""What the figures of a noise study have in common."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

COLUMN_WIDTH = 3.5  # inches: one column of a two-column paper
PAGE_WIDTH = 7.16

STYLE = {
    "font.size": 8,
    "axes.labelsize": 9,
    "axes.titlesize": 9,
    "axes.grid": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": "0.88",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.2,
    "lines.markersize": 4,
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "legend.handletextpad": 0.3,
    "legend.columnspacing": 0.6,
    "legend.borderaxespad": 0.0,
    "savefig.dpi": 300,
    "svg.hashsalt": "consimd",  # the same data give the same file
}


def save(figure, folder, name):
    figure.savefig(folder / f"{name}.svg", metadata={"Date": None})
    figure.savefig(folder / f"{name}.png")
    plt.close(figure)
