#!/usr/bin/env python3
"""Turns consimd_bench results (--benchmark_out=FILE.json) into the Markdown tables of docs/performance.md.

usage: report.py FILE.json [FILE.json ...]

Medians over the repetitions where there are any. Ratios compare values of one file, so of one run on one machine.
"""

import json
import sys
from collections import defaultdict

ISAS = ("scalar", "sse2", "neon", "avx2", "avx512")  # narrowest first
BASELINES = ("loop", "textbook", "eigen")
CONTEXT = ("cpu", "system", "consimd_commit", "consimd_compiler", "consimd_build_type", "consimd_flags", "consimd_threads")


def results(run):
    """One entry a benchmark: its median where it was repeated, else its only measurement. Failed ones are left out."""
    chosen = {}
    for entry in run["benchmarks"]:
        if entry.get("error_occurred"):
            print(f"left out, {entry['error_message']}: {entry['name']}", file=sys.stderr)
        elif entry["run_type"] == "iteration":
            chosen.setdefault(entry["run_name"], entry)
        elif entry["aggregate_name"] == "median":
            chosen[entry["run_name"]] = entry
    # The order of registration: with random interleaving that of the file is another.
    return dict(sorted(chosen.items(), key=lambda item: item[1]["family_index"]))


def spread(run):
    """Largest coefficient of variation of the CPU times, or None without repetitions."""
    values = [e["cpu_time"] for e in run["benchmarks"] if e.get("aggregate_name") == "cv" and "cpu_time" in e]
    return max(values, default=None)


def table(header, rows):
    lines = [header, ["---"] + ["--:"] * (len(header) - 1), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def ratio(value, base):
    return f"{value / base:.1f}" if value and base else ""


def kernel_tables(entries):
    by_size = defaultdict(lambda: defaultdict(dict))
    present, items = set(), {}
    for name, entry in entries.items():
        kernel, size, variant = name.split("/")
        by_size[int(size)][kernel][variant] = entry["items_per_second"] / 1e9
        items[kernel] = entry["label"]
        present.add(variant)
    isas = [isa for isa in ISAS if isa in present]
    baselines = [baseline for baseline in BASELINES if baseline in present]
    widest = isas[-1] if isas else "none"
    for size in sorted(by_size):
        print(f"### {size} correspondences, in 10^9 a second\n")
        rows = []
        for kernel, rates in by_size[size].items():
            best = rates.get(widest)
            rows.append(
                [f"`{kernel}`, {items[kernel]}"]
                + [f"{rates[v]:.3g}" if v in rates else "" for v in (*isas, *baselines)]
                + [ratio(best, rates.get(base)) for base in ("scalar", *baselines)]
            )
        header = ["kernel", *isas, *baselines, *(f"{widest} / {base}" for base in ("scalar", *baselines))]
        print(table(header, rows))


def registration_tables(entries):
    cells, pairs = defaultdict(dict), []
    for name, entry in entries.items():
        parts = name.removeprefix("register_tcf/").removesuffix("/manual_time").split("/")
        parts = [p for p in parts if not p.startswith("iterations:")]
        text = f"{entry['median_ms']:.2f}" + ("" if entry["recall"] == 1 else f" ({100 * entry['recall']:.0f} %)")
        if parts[0] == "noise":
            outliers, sigma = (float(part.split(":")[1]) for part in parts[1:])
            cells[sigma][outliers] = text
        else:
            pairs.append([parts[1], f"{entry['median_ms']:.2f}", f"{100 * entry['recall']:.0f} %"])
    if cells:
        ratios = sorted({share for row in cells.values() for share in row})
        print("### Whole registrations, noise study: median ms, and the share that succeeded where it is not all\n")
        header = ["sigma", *(f"{100 * r:g} % outliers" for r in ratios)]
        print(table(header, [[f"{s:g} m", *(cells[s].get(r, "") for r in ratios)] for s in sorted(cells)]))
    if pairs:
        print("### Whole registrations, recorded pairs\n")
        print(table(["pair", "median ms", "within the error limits"], pairs))


def main(paths):
    if not paths:
        sys.exit(__doc__.strip())
    for path in paths:
        with open(path, encoding="utf-8") as file:
            run = json.load(file)
        print("; ".join(f"{key.removeprefix('consimd_')}: {run['context'].get(key, 'unknown')}" for key in CONTEXT), end=".\n")
        if (largest := spread(run)) is not None:
            print(f"Largest coefficient of variation of a CPU time over the repetitions: {100 * largest:.1f} %.")
        print()
        entries = results(run)
        kernel_tables({n: e for n, e in entries.items() if not n.startswith("register_tcf/")})
        registration_tables({n: e for n, e in entries.items() if n.startswith("register_tcf/")})


if __name__ == "__main__":
    main(sys.argv[1:])
