#!/usr/bin/env python3
"""Turns the results of consimd_bench into the Markdown tables of docs/performance.md.

usage: report.py FILE.json [--keep KEPT.json] [--bounds PORT_BOUNDS.json]

KEPT.json gets what the tables and figures need of FILE.json; it is overwritten only where it holds such results itself.
PORT_BOUNDS.json is port_bounds_zen4.json where FILE.json is of such a processor: how near its kernels come to what its
ports allow. To compare two files: against.py.

Medians over the repetitions where there are any. Ratios compare values of one run on one machine.
"""

import json
import sys
from collections import defaultdict
from pathlib import Path

from bench_results import PortBounds, Results

CONTEXT = ("cpu", "system", *(f"consimd_{key}" for key in ("commit", "compiler", "build_type", "flags", "threads")))
PORT_SIZE = 3000  # correspondences of the table of ports
STAGES = ("one_point", "two_point", "three_point", "refinement")


def table(header, rows):
    lines = [header, ["---"] + ["--:"] * (len(header) - 1), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def ratio(value, base):
    if not (value and base):
        return ""
    return f"{value / base:.0f}" if value >= 99.95 * base else f"{value / base:.1f}"


def digits(value):
    """Three, without an exponent."""
    return f"{value:.0f}" if value >= 99.95 else f"{value:.3g}"


def time_ratio(values, base):
    """Of two solvers' times, where the first finds the pose no less often."""
    if not values or values["recall"] < base["recall"]:
        return ""
    return ratio(values["median_ms"], base["median_ms"])


def median_time(values):
    """Milliseconds, and the recall where it is not all."""
    if not values:
        return ""
    return digits(values["median_ms"]) + ("" if values["recall"] == 1 else f" ({100 * values['recall']:.0f} %)")


def context_lines(results):
    context = "; ".join(f"{key.removeprefix('consimd_')}: {results.context.get(key, 'unknown')}" for key in CONTEXT)
    clock = results.values.get("clock")
    lines = [context + "."] + ([f"Clock: {clock['items_per_second'] / 1e9:.2f} GHz."] if clock else [])
    if spreads := results.spreads():
        middle, most = spreads[len(spreads) // 2], spreads[-1]
        variation = f"{100 * middle:.1f} % in the median, {100 * most:.0f} % at most"
        lines.append(f"Coefficient of variation over the repetitions: {variation}.")
    return "\n".join(lines) + "\n"


def kernel_tables(results):
    by_size = defaultdict(lambda: defaultdict(dict))
    present, items = {}, {}  # ordered: baselines as they were registered
    for (kernel, *where), values in results.under(""):
        if where and where[-1].startswith("batch:"):
            kernel += f", {where.pop().removeprefix('batch:')} at once"
        if len(where) == 2 and where[0].isdigit():
            size, variant = where
            by_size[int(size)][kernel][variant] = values["items_per_second"] / 1e9
            items[kernel] = values["items"]
            present[variant] = True
    isas = [isa for isa in results.isas() if isa in present]
    baselines = [variant for variant in present if variant not in isas]
    widest = isas[-1] if isas else "none"
    for size in sorted(by_size):
        rows = []
        for kernel, rates in by_size[size].items():
            best = rates.get(widest)
            rows.append(
                [f"`{kernel}`, {items[kernel]}"]
                + [digits(rates[v]) if v in rates else "" for v in (*isas, *baselines)]
                + [ratio(best, rates.get(base)) for base in ("scalar", *baselines)]
            )
        header = ["kernel", *isas, *baselines, *(f"{widest} / {base}" for base in ("scalar", *baselines))]
        yield f"### {size} correspondences, in 10^9 a second\n\n" + table(header, rows)


def graph_table(results):
    times = defaultdict(dict)
    for (stage, outliers, isa), values in results.under("graph/"):
        times[stage][100 * float(outliers.split(":")[1]), isa] = values["median_ms"]
    keys = {key for row in times.values() for key in row}
    shares = sorted({share for share, _ in keys})
    isas = [isa for isa in results.isas() if any(isa == other for _, other in keys)]
    if not isas:
        return
    fastest = isas[-1]
    header = ["stage"]
    for share in shares:
        header += [f"{share:g} %, {isa}" for isa in isas] + [f"scalar / {fastest}"]
    rows = []
    for stage, row in times.items():
        cells = [f"`{stage}`"]
        for share in shares:
            cells += [digits(row[share, isa]) if (share, isa) in row else "" for isa in isas]
            cells.append(ratio(row.get((share, "scalar")), row.get((share, fastest))))
        rows.append(cells)
    yield "### Graph stages, 3000 correspondences, sigma 1 m: median ms\n\n" + table(header, rows)


def registration_tables(results):
    baselines = {tuple(parts): values for parts, values in results.under("register_eigen/")}
    pruned = {tuple(parts): values for parts, values in results.under("register_eigen_pruned/")}
    rows = defaultdict(list)
    for (kind, *where), values in results.under("register_tcf/"):
        if kind not in ("noise", "pair"):
            continue
        fields = dict(part.split(":") for part in where) if kind == "noise" else {}
        name = f"{100 * float(fields['outliers']):g} %, {fields['sigma']} m" if fields else where[0]
        plain, slow = (others.get((kind, *where)) for others in (baselines, pruned))
        rows[kind].append(
            [name, median_time(values)]
            + [digits(values[f"{stage}_ms"]) if f"{stage}_ms" in values else "" for stage in STAGES]
            + [median_time(plain), median_time(slow)]
            + [time_ratio(other, values) for other in (plain, slow)]
        )
    for kind, first, title in (("noise", "outliers, sigma", "noise study"), ("pair", "pair", "recorded pairs")):
        if kind in rows:
            stages = [stage.replace("_", "-") for stage in STAGES]
            header = [first, "tcf", *stages, "eigen", "eigen, pruned", "eigen / tcf", "pruned / tcf"]
            heading = f"### Registrations, {title}: median ms, and recall where it is not 100 %\n\n"
            yield heading + table(header, rows[kind])


def growth_table(results):
    baselines = {parts[0]: values for parts, values in results.under("register_eigen/size:")}
    rows = []
    for (size,), values in results.under("register_tcf/size:"):
        plain = baselines.get(size)
        rows.append(
            [size, median_time(values), digits(1e6 * values["median_ms"] / float(size))]
            + [f"{values['peak_mib']:.2f}" if "peak_mib" in values else "", f"{24 * float(size) / 2**20:.2f}"]
            + [median_time(plain), time_ratio(plain, values)]
        )
    if rows:
        memory = ["memory, MiB", "correspondences' own, MiB"]
        header = ["correspondences", "tcf, ms", "ns per correspondence", *memory, "eigen, ms", "eigen / tcf"]
        yield "### Growth, 95 % outliers, sigma 0.1 m\n\n" + table(header, rows)


def budget_table(results):
    cells = defaultdict(dict)
    for (outliers, sigma, seeds), values in results.under("register_tcf/budget/"):
        outliers, sigma, seeds = (part.split(":")[1] for part in (outliers, sigma, seeds))
        text = f"{100 * values['recall']:.0f} %, {values['mean_ms']:.2f}"
        cells[f"{100 * float(outliers):g} %, {sigma} m"][int(seeds)] = text
    if cells:
        budgets = sorted({seeds for row in cells.values() for seeds in row})
        rows = [[str(seeds), *(row.get(seeds, "") for row in cells.values())] for seeds in budgets]
        yield "### Recall and mean ms within max_seeds\n\n" + table(["max_seeds", *cells], rows)


def port_table(results, bounds):
    clock = results.values["clock"]["items_per_second"]
    rows = []
    for loop in bounds.loops:
        measured = results.values.get(f"{loop['kernel']}/{PORT_SIZE}/{bounds.isa}")
        if measured is None:
            continue
        bound = bounds.rate(loop, clock)
        cycles = f"{loop['cycles']:g}" + (f": {loop['by']}" if "by" in loop else "")
        share = f"{100 * measured['items_per_second'] / bound:.0f} %"
        row = [loop["loop"], loop["adders"], loop["multipliers"], cycles, f"{bound / 1e9:.2f}"]
        rows.append([*row, digits(measured["items_per_second"] / 1e9), share])
    if rows:
        header = [f"{bounds.isa} loop", "add, subtract, min, max", "multiply, compare", "bound, cycles"]
        heading = f"### Loops of {bounds.isa} and the ports of {bounds.processor}, {PORT_SIZE} correspondences\n\n"
        yield heading + table([*header, "bound, 10^9 a second", "measured", "of the bound"], rows)


def tables(results, bounds=None):
    if bounds and "clock" in results.values:
        yield from port_table(results, bounds)
    for make in (kernel_tables, graph_table, registration_tables, growth_table, budget_table):
        yield from make(results)


def is_kept(path):
    try:
        return "results" in json.loads(path.read_text(encoding="utf-8"))
    except (TypeError, ValueError):
        return False


def main(arguments):
    options = dict(zip(arguments[1::2], arguments[2::2]))
    if len(arguments) % 2 == 0 or not {"--keep", "--bounds"} >= options.keys():
        sys.exit(__doc__.strip())
    results = Results(arguments[0])
    bounds = PortBounds(options["--bounds"]) if "--bounds" in options else None
    if "--keep" in options:
        kept = Path(options["--keep"])
        if kept.exists() and not is_kept(kept):
            sys.exit(f"report: {kept} is there and holds no kept results: not overwritten")
        results.keep(kept)
    print("\n".join([context_lines(results), *tables(results, bounds)]), end="")


if __name__ == "__main__":
    main(sys.argv[1:])
