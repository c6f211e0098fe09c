"""Registers two point clouds from putative correspondences and draws them before and after.

    python register_pair.py                                  a synthetic pair of scans
    python register_pair.py correspondences.txt              your own: N x 6, source xyz and target xyz
    python register_pair.py correspondences.txt --noise-bound 0.2 --out pair.png

Needs consimd and matplotlib. Written to be read from top to bottom, like a notebook.
"""

from __future__ import annotations

import argparse
import pathlib

import matplotlib

matplotlib.use("Agg")  # draws to a file, with or without a screen

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from numpy.typing import NDArray

import consimd

Points = NDArray[np.float64]

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("file", nargs="?", type=pathlib.Path, help="correspondences; without it a synthetic pair is made")
parser.add_argument("--noise-bound", type=float, help="in the file's unit; estimated when not given")
parser.add_argument("--solver", default="tcf", choices=list(consimd.solvers()))
parser.add_argument("--seed", type=int, default=0)
parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("register_pair.png"))
arguments = parser.parse_args()

# --- The correspondences: row k of one cloud may be the same point as row k of the other --------------------------------

if arguments.file:
    rows = np.loadtxt(arguments.file, delimiter="," if "," in arguments.file.read_text() else None)
    source, target = rows[:, :3], rows[:, 3:6]
    title = arguments.file.parent.name or arguments.file.name
    truth = None
else:
    problem = consimd.synth.stand_in_problem("facade", seed=1)
    source, target = problem.source, problem.target
    title = "synthetic scans of a facade"
    truth = problem.pose

# --- The registration -------------------------------------------------------------------------------------------------

result = consimd.register(source, target, arguments.noise_bound, arguments.solver, arguments.seed)
print(result)
for stage in result.stages:
    print(f"  {stage.name:<24} {stage.input:>7} -> {stage.output:<7} {1e3 * stage.seconds:8.3f} ms")
pose = result.pose
if pose is None:
    raise SystemExit(f"no pose: {result.status}")
print(np.array_str(pose, precision=4, suppress_small=True))
if truth is not None:
    rotation = consimd.synth.rotation_error_deg(pose, truth)
    translation = consimd.synth.translation_error(pose, truth)
    print(f"errors: rotation {rotation:.3f} deg, translation {translation:.3f} m")

moved = source @ pose[:3, :3].T + pose[:3, 3]
is_inlier = np.zeros(len(source), dtype=bool)
is_inlier[result.inliers] = True

# --- The picture: seen along the direction in which the target cloud is thinnest ----------------------------------------

centre = target.mean(axis=0)
axes = np.linalg.svd(target - centre, full_matrices=False)[2][:2]
GREEN, RED, BLUE, GREY = "#1a9641", "#d7191c", "#2c7bb6", "#9a9a9a"


def seen(points: Points) -> Points:
    flat: Points = (points - centre) @ axes.T
    return flat


def draw(panel: Axes, cloud: Points, heading: str) -> None:
    """The source cloud as it is, or moved, on the target, with what joins them."""
    lines = np.stack([seen(cloud), seen(target)], axis=1)
    # Of thousands of wrong pairs a few hundred show as much.
    wrong = np.flatnonzero(~is_inlier)
    wrong = wrong[:: max(1, len(wrong) // 300)]
    panel.add_collection(LineCollection(list(lines[wrong]), colors=RED, linewidths=0.4, alpha=0.25, zorder=1))
    for points, color, label, size in (
        (target, GREY, "target", 4),
        (cloud, BLUE, "source", 4),
        (cloud[is_inlier], GREEN, None, 10),
    ):
        x, y = seen(points).T
        panel.scatter(x, y, s=size, color=color, linewidths=0, zorder=size, label=label)
    panel.add_collection(LineCollection(list(lines[is_inlier]), colors=GREEN, linewidths=0.9, alpha=0.8, zorder=5))
    panel.plot([], [], color=GREEN, label=f"inliers: {is_inlier.sum()}")
    panel.plot([], [], color=RED, label=f"outliers: {(~is_inlier).sum()} (some are drawn)")
    panel.set_title(heading)
    panel.set_aspect("equal")
    panel.grid(color="0.92", linewidth=0.6)
    panel.set_axisbelow(True)


# Within the middle 99 % of both clouds: single points far away would shrink all the rest.
shown = np.concatenate([seen(source), seen(target), seen(moved)])
low, high = np.percentile(shown, [0.5, 99.5], axis=0)
margin = 0.04 * (high - low).max()
width, height = high - low + 2 * margin
figure, (before, after) = plt.subplots(
    1, 2, figsize=(14, 1.4 + 6.7 * height / width), sharex=True, sharey=True, layout="constrained"
)
draw(before, source, "before")
draw(after, moved, f"after: {result.status}, {1e3 * result.seconds:.1f} ms")
before.set_xlim(low[0] - margin, high[0] + margin)
before.set_ylim(low[1] - margin, high[1] + margin)
figure.suptitle(f"{title}: {len(source)} correspondences, noise bound {result.noise_bound:.3g}")
figure.legend(*before.get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False, markerscale=3)
figure.savefig(arguments.out, dpi=110)
print(f"drawn: {arguments.out}")
