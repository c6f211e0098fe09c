#!/usr/bin/env python3
"""Draws the diagrams of the pages: consensus_sets.svg, residual_mixture.svg and tcf_data_flow.svg.

Usage: diagrams.py [DIR]      beside this script, or in DIR, there as PNG too

The first two compute what they show from random data with a fixed seed; the third is a drawing of `register_tcf`.
"""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Annulus, Circle, FancyArrowPatch, FancyBboxPatch

PAGE_WIDTH = 7.16  # inches
BLUE, ORANGE, GREEN, GREY = "#0072B2", "#D55E00", "#009E73", "0.6"
STYLE = {
    "font.size": 8,
    "axes.titlesize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "savefig.dpi": 150,
    "svg.hashsalt": "consimd",  # the same data give the same file
}


HERE = Path(__file__).resolve().parent


def save(figure, folder, name):
    figure.savefig(folder / f"{name}.svg", metadata={"Date": None})
    if folder != HERE:
        figure.savefig(folder / f"{name}.png")
    plt.close(figure)


# --- The sets of one, two and three points ----------------------------------------------------------------------------


def planar_problem(rng, size=50, inliers=20, noise=0.12):
    """Sources and targets in the plane: a turned and moved copy, and matches that are wrong."""
    source = rng.uniform(-4, 4, (size, 2))
    angle = np.radians(35)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    target = source @ turn.T + rng.normal(0, noise, (size, 2))
    target[inliers:] = rng.uniform(-5, 5, (size - inliers, 2))
    return source, target, np.arange(size) < inliers


def moved_by_fit(source, target, chosen):
    """All sources, moved as the least-squares fit of the chosen rows tells (Kabsch)."""
    p, q = source[chosen].mean(axis=0), target[chosen].mean(axis=0)
    u, _, v = np.linalg.svd((target[chosen] - q).T @ (source[chosen] - p))
    turn = u @ np.diag([1, np.linalg.det(u @ v)]) @ v
    return (source - p) @ turn.T + q


def draw_sets(folder):
    source, target, inlier = planar_problem(np.random.default_rng(8))
    tau = 0.36  # three deviations of the noise

    def consistent(k):
        lengths = [np.linalg.norm(points - points[k], axis=1) for points in (source, target)]
        return np.abs(lengths[0] - lengths[1]) < 2 * tau

    first, second, third, example = 3, 0, 6, 9
    one = consistent(first)
    two = one & consistent(second)
    chosen = [first, second, third]
    predicted = moved_by_fit(source, target, chosen)
    three = np.linalg.norm(predicted - target, axis=1) < tau
    figure, axes = plt.subplots(1, 4, figsize=(PAGE_WIDTH, 2.2), layout="constrained", sharex=True, sharey=True)

    def name(ax, points, k, text):
        ax.annotate(text, points[k], textcoords="offset points", xytext=(4, 3), fontsize=8, fontweight="bold")

    ax = axes[0]
    ax.scatter(*source.T, s=7, color=GREY, linewidths=0)
    for k in chosen:
        ax.plot(*np.stack([source[k], source[example]]).T, color=BLUE, linewidth=0.8)
    ax.scatter(*source[chosen].T, s=22, color=BLUE, zorder=3)
    ax.scatter(*source[example], s=12, color=ORANGE, marker="D", zorder=3)
    for k, text in zip([*chosen, example], "abcj"):
        name(ax, source, k, text)
    ax.set_title(f"source: {len(source)} matches,\n{inlier.sum()} of them right")

    def ring(ax, k):
        radius = np.linalg.norm(source[k] - source[example])
        ax.add_patch(Annulus(target[k], radius + 2 * tau, 4 * tau, color=ORANGE, alpha=0.22, linewidth=0))

    for ax, members, seeds in zip(axes[1:], (one, two, three), ([first], [first, second], chosen)):
        ax.scatter(*target[~members].T, s=7, color=GREY, linewidths=0)
        wrong = members & ~inlier
        ax.scatter(*target[wrong].T, s=16, color=GREEN, marker="x", linewidths=1)
        ax.scatter(*target[members & inlier].T, s=9, color=GREEN, linewidths=0)
        ax.scatter(*target[seeds].T, s=22, color=BLUE, zorder=3)
        ax.scatter(*target[example], s=12, color=ORANGE, marker="D", zorder=3)
        for k, text in zip([*seeds, example], "abc"[: len(seeds)] + "j"):
            name(ax, target, k, text)
        ax.set_title(f"{len(seeds)}-point set: {members.sum()} members,\n{wrong.sum()} of them wrong")
    ring(axes[1], first)
    ring(axes[2], first)
    ring(axes[2], second)
    axes[3].add_patch(Circle(predicted[example], tau, color=ORANGE, alpha=0.4, linewidth=0))
    for ax in axes:
        ax.set(xlim=(-5.6, 5.6), ylim=(-5.6, 5.6), aspect="equal", xticks=[], yticks=[])
        for side in ax.spines.values():
            side.set(visible=True, color="0.85")
    save(figure, folder, "consensus_sets")


# --- The mixture of residuals -----------------------------------------------------------------------------------------


def draw_mixture(folder):
    """A cell of the noise study, 95 % outliers and 5 m, and the mixture that expectation maximisation fits to it."""
    rng = np.random.default_rng(3)
    sigma, size, inliers, half = 5.0, 3000, 150, 100.0
    tau, bins = 3 * sigma, 24
    cutoff = 2 * tau
    predicted = rng.uniform(-half / 2, half / 2, (size, 3))  # near the middle, where outliers are as dense as in all
    residual = rng.normal(0, sigma, (size, 3))
    residual[inliers:] = rng.uniform(-half, half, (size - inliers, 3)) - predicted[inliers:]
    counts, edges = np.histogram(np.linalg.norm(residual, axis=1), bins=bins, range=(0, cutoff))
    r = (edges[:-1] + edges[1:]) / 2
    shell = 4 * np.pi * r**2 * (cutoff / bins)

    def gaussian(r, n, s):  # the mixture's inliers for the exponent 64
        return n * (2 * np.pi * s**2) ** -1.5 * np.exp(-(r**2) / (2 * s**2))

    n, s, b = 0.5 * counts.sum(), tau / 3, 0.5 * counts.sum() / shell.sum()
    for _ in range(200):
        posterior = gaussian(r, n, s) / (gaussian(r, n, s) + b)
        seen = counts * posterior
        n, s = seen.sum(), np.sqrt((seen * r**2).sum() / (3 * seen.sum()))
        b = (counts - seen).sum() / shell.sum()

    figure, (left, right) = plt.subplots(1, 2, figsize=(PAGE_WIDTH, 2.4), layout="constrained")
    fine = np.linspace(0, cutoff, 400)
    fine_shell = 4 * np.pi * fine**2 * (cutoff / bins)
    left.bar(r, counts, width=0.9 * cutoff / bins, color="0.85", label="residuals of all correspondences")
    left.plot(fine, gaussian(fine, n, s) * fine_shell, color=BLUE, label=f"inliers: n = {n:.0f}, s = {s:.1f} m")
    left.plot(fine, b * fine_shell, color=ORANGE, label=f"outliers: b = {1e4 * b:.1f} per $10^4$ m$^3$")
    left.plot(fine, (gaussian(fine, n, s) + b) * fine_shell, color="black", linewidth=0.9, label="both")
    left.set(xlabel="residual r, m", ylabel="correspondences per bin", xlim=(0, cutoff))
    left.legend(loc="upper left", fontsize=7, bbox_to_anchor=(0.5, 1.04), handlelength=1.2)
    right.plot(fine, gaussian(fine, n, s) / (gaussian(fine, n, s) + b), color=BLUE)
    right.set(xlabel="residual r, m", ylabel="weight in the fit", xlim=(0, cutoff), ylim=(0, 1.05))
    for ax in (left, right):
        ax.axvline(tau, color="0.5", linewidth=0.8, linestyle=(0, (4, 3)))
    left.annotate("noise bound", (tau, left.get_ylim()[1] * 0.5), xytext=(3, 0), textcoords="offset points", color="0.4")
    right.annotate("noise bound", (tau, 0.98), xytext=(3, 0), textcoords="offset points", color="0.4")
    save(figure, folder, "residual_mixture")


# --- The data flow of tcf ---------------------------------------------------------------------------------------------

# Column, row, title, what happens. Rows go down.
BOXES = {
    "input": (0, 0, "correspondences", "N rows of source and target,\ncentred, in single precision"),
    "seeds": (1, 0, "seeds", "4 to 64 rows a round,\nin random order"),
    "one": (2, 0, "one-point sets", "rows of the window whose\nlength to the seed agrees"),
    "two": (2, 1, "two-point sets", "guess the clique of each set;\nkeep the promising ones"),
    "prune": (2, 2, "pruned sets", "members that agree\nwith one another"),
    "three": (1, 2, "three-point fits", "minimal poses within a set;\nthe best scored on all rows"),
    "best": (1, 1, "best pose, runner-up", "enough seeds for\nthe confidence?"),
    "refine": (0, 1, "refinement", "maximum likelihood over all\nrows; how likely by chance?"),
    "verdict": (0, 2, "verdict", "degenerate? mirrored?\nanother motion as likely?"),
}
ARROWS = [
    ("input", "seeds", ""),
    ("seeds", "one", ""),
    ("one", "two", ""),
    ("two", "prune", ""),
    ("prune", "three", ""),
    ("three", "best", ""),
    ("best", "seeds", "no: next round"),
    ("best", "refine", "yes"),
    ("refine", "verdict", ""),
    ("refine", "seeds", "by chance: all seeds\nonce more, with care"),
]


def draw_flow(folder):
    figure, ax = plt.subplots(figsize=(PAGE_WIDTH, 3.3), layout="constrained")
    width, height, step_x, step_y = 2.5, 0.78, 3.4, 1.35
    centre = {key: (step_x * column, -step_y * row) for key, (column, row, _, _) in BOXES.items()}
    for key, (_, _, title, text) in BOXES.items():
        x, y = centre[key]
        colour = GREEN if key in ("refine", "verdict") else "0.5" if key == "input" else BLUE
        ax.add_patch(
            FancyBboxPatch(
                (x - width / 2, y - height / 2), width, height, boxstyle="round,pad=0.03", fc="white", ec=colour, lw=1.2
            )
        )
        ax.text(x, y + 0.22, title, ha="center", va="center", fontweight="bold", color=colour)
        ax.text(x, y - 0.13, text, ha="center", va="center", fontsize=7)
    for start, end, label in ARROWS:
        (x0, y0), (x1, y1) = centre[start], centre[end]
        if x0 != x1 and y0 != y1:  # from corner to corner
            ends = (x0 + width / 2 - 0.2, y0 + height / 2 + 0.05), (x1 - width / 2 + 0.2, y1 - height / 2 - 0.05)
        elif y0 == y1:
            side = np.sign(x1 - x0) * (width / 2 + 0.05)
            ends = (x0 + side, y0), (x1 - side, y1)
        else:
            side = np.sign(y1 - y0) * (height / 2 + 0.05)
            ends = (x0, y0 + side), (x1, y1 - side)
        ax.add_patch(FancyArrowPatch(*ends, arrowstyle="-|>", mutation_scale=9, color="0.3", lw=1))
        if label:
            x, y = np.mean(ends, axis=0)
            offset = (0, 0.1) if y0 == y1 else (0.1, 0) if x0 == x1 else (-0.35, 0.02)
            alignment = ("center", "bottom") if y0 == y1 else ("left" if x0 == x1 else "right", "center")
            ax.text(x + offset[0], y + offset[1], label, ha=alignment[0], va=alignment[1], fontsize=7, color="0.3")
    x, y = centre["verdict"]
    ax.annotate(
        "Registration: status, pose, inliers, covariance, stages",
        (x, y - height / 2 - 0.05), (x, y - height / 2 - 0.5), ha="center", va="center",
        arrowprops={"arrowstyle": "<|-", "color": "0.3"},
    )  # fmt: skip
    ax.set(xlim=(-1.75, 2 * step_x + 1.4), ylim=(-2 * step_y - 1.1, 0.5), aspect="equal")
    ax.axis("off")
    save(figure, folder, "tcf_data_flow")


def main():
    if len(sys.argv) > 2:
        sys.exit(__doc__.strip())
    folder = Path(sys.argv[1]) if len(sys.argv) == 2 else HERE
    folder.mkdir(parents=True, exist_ok=True)
    with plt.rc_context(STYLE):
        draw_sets(folder)
        draw_mixture(folder)
        draw_flow(folder)


if __name__ == "__main__":
    main()
