#!/usr/bin/env python3
"""Draws the pictures of docs/problem_families.md, of what `consimd generate --family` writes.

Usage: families.py CONSIMD     writes families_noise.png, families_outliers.png and families_scenes.png beside itself
CONSIMD: the command, as build/release/bin/consimd. Needs NumPy and matplotlib.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

HERE = Path(__file__).resolve().parent
INLIER, OUTLIER = "#0072B2", "#E69F00"  # of Okabe and Ito's colours
SIGMA = 1.0

# What each picture shows, family by family: how the targets are drawn, and along which of the principal axes of the
# scene one looks.
FIGURES = {
    "families_noise": {
        name: ("residuals", 2) for name in ("gaussian", "heavy_tails", "range_dependent", "anisotropic", "quantised")
    },
    "families_outliers": {
        name: ("targets", 2)
        for name in (
            *("permuted", "clustered", "one_to_many", "many_to_many", "decoy", "symmetric"),
            *("kept_range", "kept_ring", "kept_height", "repeated_structure", "lattice"),
            *("copies", "far_rows", "no_depth"),
        )
    },
    "families_scenes": {
        "planar": ("targets", 1),
        "linear": ("targets", 2),
        "street": ("targets", 0),
        "indoor": ("targets", 2),
    },
}


def generate(consimd, family):
    """(source, target moved back by the true pose, labels) of a problem."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(
            [consimd, "generate", "--family", family, "--points", "700", "--outliers", "0.5", "--sigma", str(SIGMA)]
            + ["--seed", "4", "--out", folder],
            check=True,
            stdout=subprocess.DEVNULL,
        )
        rows = np.loadtxt(Path(folder) / "correspondences.txt")
        pose = np.loadtxt(Path(folder) / "pose.txt")
        labels = np.loadtxt(Path(folder) / "labels.txt") > 0
    return rows[:, :3], (rows[:, 3:] - pose[:3, 3]) @ pose[:3, :3], labels


def draw_cloud(ax, points, labels, reach, log):
    for of, colour in ((~labels, OUTLIER), (labels, INLIER)):
        ax.scatter(*points[of].T, s=3, color=colour, linewidths=0, rasterized=True)
    if log:
        ax.set_xscale("symlog", linthresh=reach)
        ax.set_yscale("symlog", linthresh=reach)
        ax.set_xticks([-1e6, 0, 1e6])
        ax.set_yticks([-1e6, 0, 1e6])
    else:
        ax.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")


def draw_residuals(ax, source, moved, labels):
    """Along the ray from the sensor, and across it, in sigma."""
    residual = (moved - source)[labels] / SIGMA
    ray = source[labels] / np.linalg.norm(source[labels], axis=1)[:, None]
    across = np.cross(ray, [0.0, 0.0, 1.0])
    across /= np.linalg.norm(across, axis=1)[:, None]
    ax.scatter((residual * ray).sum(1), (residual * across).sum(1), s=3, color=INLIER, linewidths=0)
    ax.add_patch(plt.Circle((0, 0), 3, fill=False, color="0.5", linewidth=0.8))
    ax.set(xlim=(-6, 6), ylim=(-6, 6), aspect="equal")


def draw(consimd, name, families):
    columns = 3 if len(families) > 4 else 2
    rows = -(-len(families) // columns)
    figure, axes = plt.subplots(rows, 2 * columns, figsize=(3.6 * columns, 1.95 * rows + 0.35), layout="constrained")
    for ax in axes.flat:
        ax.set_axis_off()
    for k, (family, (kind, view)) in enumerate(families.items()):
        left, right = axes[k // columns, 2 * (k % columns) : 2 * (k % columns) + 2]
        source, moved, labels = generate(consimd, family)
        axes_of_scene = np.linalg.svd(source[labels] - source[labels].mean(0), full_matrices=False)[2]
        plane = np.delete(axes_of_scene, view, axis=0).T
        reach = 1.05 * np.abs(source[labels] @ plane).max()
        for ax in (left, right):
            ax.set_axis_on()
            ax.tick_params(labelsize=6, length=2)
        draw_cloud(left, source @ plane, labels, reach, family == "far_rows")
        left.set_title(f"{family}: sources", fontsize=7, loc="left")
        if kind == "residuals":
            draw_residuals(right, source, moved, labels)
            right.set_title("residuals: ray, across (σ)", fontsize=7, loc="left")
        else:
            reach = max(reach, 1.3 * np.quantile(np.abs(moved @ plane), 0.95))
            draw_cloud(right, moved @ plane, labels, reach, family == "far_rows")
            right.set_title("targets, moved back", fontsize=7, loc="left")
    figure.savefig(HERE / f"{name}.png", dpi=110, metadata={"Software": None})
    plt.close(figure)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip())
    for name, families in FIGURES.items():
        draw(str(Path(sys.argv[1]).resolve()), name, families)


if __name__ == "__main__":
    main()
