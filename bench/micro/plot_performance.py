#!/usr/bin/env python3
"""Draws time and memory over size, and recall over time, from the results of consimd_bench.

Usage: plot_performance.py FILE.json DIR      writes DIR/time_over_size.{svg,png} and DIR/recall_over_time.{svg,png}
"""

import sys
from pathlib import Path

from bench_results import Results

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "studies/src/figures"))
from figure_style import COLUMN_WIDTH, PAGE_WIDTH, STYLE, plt, save  # noqa: E402
from plot_sweep import COLOURS, MARKERS  # noqa: E402

REFERENCE = {"color": "0.35", "linewidth": 0.8, "linestyle": (0, (4, 3))}
NOTE = {"textcoords": "offset points", "fontsize": 6.5, "color": "0.35"}
BYTES = 24  # of a correspondence: six floats
LEAST_MEMORY = 10_000  # correspondences; what fewer need hides in pages that the process has anyway


def style(i):
    return {"color": COLOURS[i], "marker": MARKERS[i]}


def curve(results, prefix, value):
    """Sizes and values of the benchmarks that have it."""
    points = [(float(size), values[value]) for (size,), values in results.under(prefix) if value in values]
    return list(zip(*points)) or [(), ()]


def draw_growth(results, folder):
    figure, (time, memory) = plt.subplots(1, 2, figsize=(PAGE_WIDTH, 2.5), layout="constrained")
    sizes, milliseconds = curve(results, "register_tcf/size:", "median_ms")
    time.plot(sizes, milliseconds, label="tcf", **style(0))
    time.plot(*curve(results, "register_eigen/size:", "median_ms"), label="plain Eigen", **style(1))
    middle = len(sizes) // 2
    per_correspondence = milliseconds[middle] / sizes[middle]
    time.plot(sizes, [per_correspondence * size for size in sizes], label="proportional to size", **REFERENCE)
    time.set_ylabel("median time (ms)")
    needed = zip(*curve(results, "register_tcf/size:", "peak_mib"))
    seen = [(size, mib) for size, mib in needed if size >= LEAST_MEMORY]
    if seen:
        memory.plot(*zip(*seen), label="tcf, at its peak", **style(0))
    memory.plot(sizes, [BYTES * size / 2**20 for size in sizes], label="the correspondences", **REFERENCE)
    memory.set_ylabel("memory (MiB)")
    for ax in (time, memory):
        ax.set(xscale="log", yscale="log", xlabel="correspondences")
        ax.legend(loc="upper left")
    save(figure, folder, "time_over_size")


def draw_recall(results, folder):
    cells = {}
    for (outliers, sigma, seeds), values in results.under("register_tcf/budget/"):
        label = f"{100 * float(outliers.split(':')[1]):g} %, {sigma.split(':')[1]} m"
        cells.setdefault(label, []).append((values["mean_ms"], 100 * values["recall"], int(seeds.split(":")[1])))
    figure, ax = plt.subplots(figsize=(1.35 * COLUMN_WIDTH, 3.0), layout="constrained")
    for i, (label, points) in enumerate(cells.items()):
        times, recalls, seeds = zip(*points)
        ax.plot(times, recalls, label=label, clip_on=False, **style(i))
        if i == 0:  # the others start at as many
            ax.annotate(f"{seeds[0]} seeds", (times[0], recalls[0]), xytext=(-14, -11), **NOTE)
    ax.set(xscale="log", ylim=(0, 100), xlabel="mean time (ms)", ylabel="recall (%)")
    ax.set_xlim(0.6 * min(times for points in cells.values() for times, *_ in points))  # room for the first note
    ax.xaxis.set_major_formatter("{x:g}")
    ax.set_xticks([0.2, 0.5, 1, 2, 5, 10])
    ax.minorticks_off()
    ax.legend(loc="lower right", title="outliers, σ", title_fontsize=8)
    save(figure, folder, "recall_over_time")


def main(arguments):
    if len(arguments) != 2:
        sys.exit(__doc__.strip())
    results, folder = Results(arguments[0]), Path(arguments[1])
    with plt.rc_context(STYLE):
        if any(results.under("register_tcf/size:")):
            draw_growth(results, folder)
        if any(results.under("register_tcf/budget/")):
            draw_recall(results, folder)


if __name__ == "__main__":
    main(sys.argv[1:])
