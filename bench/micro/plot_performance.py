#!/usr/bin/env python3
"""Draws rates of kernels and time and memory over size, and recall over time, from the results of consimd_bench.

Usage: plot_performance.py FILE.json DIR [PORT_BOUNDS.json]
    writes those of DIR/{kernel_rates,time_over_size,recall_over_time}.{svg,png} that FILE.json has results for.
    PORT_BOUNDS.json is port_bounds_zen4.json where FILE.json is of such a processor.
"""

import sys
from pathlib import Path

from bench_results import PortBounds, Results

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


KERNELS = {
    "length_consistency_counts": "length consistency",
    "angle_consistency_counts": "angle consistency",
    "alignment_counts": "alignment",
    "alignment_scores": "alignment scores",
    "consistency_matrix": "consistency matrix",
    "weighted_moments": "weighted moments",
}


def draw_kernels(results, bounds, folder):
    """Rates over size: a panel a kernel, a line an instruction set, and what the ports allow the widest one."""
    rates = {kernel: {} for kernel in KERNELS}
    for kernel in KERNELS:
        for (size, variant, *batch), values in results.under(kernel + "/"):
            if variant in results.isas() and not batch:
                rates[kernel].setdefault(variant, []).append((int(size), values["items_per_second"] / 1e9))
    rates = {kernel: lines for kernel, lines in rates.items() if lines}
    limits = {}
    if bounds and "clock" in results.values:
        clock = results.values["clock"]["items_per_second"]
        limits = {loop["kernel"]: bounds.rate(loop, clock) / 1e9 for loop in bounds.loops}
    figure = plt.figure(figsize=(PAGE_WIDTH, 3.8), layout="constrained")
    grid = figure.add_gridspec(3, 3, height_ratios=(1, 1, 0.09))
    panels = []
    for k in range(len(rates)):
        panels.append(figure.add_subplot(grid[k // 3, k % 3], sharex=panels[0] if panels else None))
    isas = [isa for isa in results.isas() if any(isa in lines for lines in rates.values())]
    for ax, (kernel, lines) in zip(panels, rates.items()):
        for i, isa in enumerate(isas):
            if isa in lines:
                ax.plot(*zip(*sorted(lines[isa])), label=isa, **style(i))
        if kernel in limits:
            ax.axhline(limits[kernel], label=f"bound by the ports, {bounds.isa}", **REFERENCE)
        ax.set_title(KERNELS[kernel], fontsize=8)
        ax.set(xscale="log", ylim=(0, None))
    for k, ax in enumerate(panels):
        if k + 3 >= len(panels):
            ax.set_xlabel("correspondences")
        if k % 3 == 0:
            ax.set_ylabel("10$^9$ a second")
    strip = figure.add_subplot(grid[2, :])
    strip.axis("off")
    entries = {label: handle for ax in panels for handle, label in zip(*ax.get_legend_handles_labels())}
    strip.legend(entries.values(), entries.keys(), loc="center", ncol=len(entries))
    save(figure, folder, "kernel_rates")


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
    if len(arguments) not in (2, 3):
        sys.exit(__doc__.strip())
    results, folder = Results(arguments[0]), Path(arguments[1])
    bounds = PortBounds(arguments[2]) if len(arguments) == 3 else None
    with plt.rc_context(STYLE):
        if any(any(results.under(kernel + "/")) for kernel in KERNELS):
            draw_kernels(results, bounds, folder)
        if any(results.under("register_tcf/size:")):
            draw_growth(results, folder)
        if any(results.under("register_tcf/budget/")):
            draw_recall(results, folder)


if __name__ == "__main__":
    main(sys.argv[1:])
