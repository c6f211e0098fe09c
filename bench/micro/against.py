#!/usr/bin/env python3
"""Compares this build's benchmarks with another build's, or with results that are kept, as a Markdown table.

usage: against.py PROGRAM OTHER [--rounds N] [ARGUMENT...]    OTHER: a consimd_bench, or results of one, FILE.json
       against.py FILE.json OTHER.json                        results of two machines, nothing is run

Two programs run in turn, N rounds each (9), the first one first in every other round, so that a slow minute hits both.
The ratio of a benchmark is the median over the rounds of PROGRAM's speed over OTHER's in the same round; above 1
PROGRAM is the faster. Its interval holds the median of all rounds that there could be with 95 % or more: it goes from the
k-th smallest ratio to the k-th largest, by the binomial distribution. Kept results are not interleaved, and the
interval follows from those of both medians; without repetitions there (--benchmark_repetitions=9) there is none.
ARGUMENTs are those of consimd_bench: --benchmark_filter, --sizes, --isas, ...
"""

import json
import math
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from bench_results import context_of, speeds
from report import digits, table

ROUNDS = 9
LEVEL = 0.95


def median_interval(values):
    """The order statistics between which the median lies with probability LEVEL or more, whatever the distribution; None
    where there are too few values."""
    values, n = sorted(values), len(values)
    outside, k = 0.0, 0
    while k < n / 2:
        outside += 2 * math.comb(n, k) / 2**n  # of k values below the median, or above it
        if outside > 1 - LEVEL:
            break
        k += 1
    return (values[k - 1], values[n - k]) if k else None


class Measured:
    """Speeds of the benchmarks by name, a list each: of the rounds, or of the repetitions in a file."""

    def __init__(self, what):
        self.what = what
        self.context = {}
        self.speeds = {}

    def add(self, run):
        self.context = context_of(run)
        for name, values in speeds(run).items():
            self.speeds.setdefault(name, []).extend(values)

    def describe(self):
        keys = ("cpu", "consimd_commit", "consimd_compiler", "consimd_flags", "date")
        return f"{self.what}: " + "; ".join(str(self.context.get(key, "unknown")) for key in keys)


def is_results(path):
    return Path(path).suffix == ".json"


def read(path):
    measured = Measured(path)
    try:
        measured.add(json.loads(Path(path).read_text(encoding="utf-8")))
    except (OSError, KeyError, TypeError, ValueError) as error:
        sys.exit(f"against: {path}: no results of consimd_bench: {error}")
    return measured


def run(program, arguments):
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "bench.json"
        output = [f"--benchmark_out={file}", "--benchmark_out_format=json", "--benchmark_repetitions=1"]
        ran = subprocess.run([program, *arguments, *output], capture_output=True, text=True, check=False)
        if ran.returncode != 0 or not file.exists():
            sys.exit(f"against: {program} failed: {ran.stderr.strip().splitlines()[-1:] or [ran.returncode]}")
        return json.loads(file.read_text(encoding="utf-8"))


def interleave(programs, rounds, arguments):
    measured = [Measured(program) for program in programs]
    for number in range(rounds):
        # Whoever runs second finds a machine that the first one has warmed.
        for one in measured if number % 2 == 0 else reversed(measured):
            one.add(run(one.what, arguments))
        print(f"round {number + 1} of {rounds}", file=sys.stderr)
    return measured


def paired(ours, theirs):
    """Ratio and interval of rounds that stand beside each other."""
    ratios = [a / b for a, b in zip(ours, theirs)]
    return statistics.median(ratios), median_interval(ratios)


def unpaired(ours, theirs):
    ratio = statistics.median(ours) / statistics.median(theirs)
    a, b = median_interval(ours), median_interval(theirs)
    return ratio, (a[0] / b[1], a[1] / b[0]) if a and b else None


def verdict(interval):
    if interval is None:
        return ""
    return "faster" if interval[0] > 1 else "slower" if interval[1] < 1 else "same"


def rate(speed):
    """Items or calls a second."""
    unit, prefix = next((unit, prefix) for unit, prefix in ((1e9, "G"), (1e6, "M"), (1e3, "k"), (0, "")) if speed >= unit)
    return f"{digits(speed / (unit or 1))} {prefix}/s"


def comparison_table(ours, theirs, compare):
    rows = []
    for name in (name for name in ours.speeds if name in theirs.speeds):
        a, b = ours.speeds[name], theirs.speeds[name]
        ratio, interval = compare(a, b)
        between = f"{interval[0]:.3f} to {interval[1]:.3f}" if interval else ""
        speeds_shown = [rate(statistics.median(a)), rate(statistics.median(b))]
        rows.append([f"`{name}`", *speeds_shown, f"{ratio:.3f}", between, verdict(interval)])
    return table(["benchmark", "this", "other", "this / other", "95 % interval", ""], rows) if rows else ""


def main(arguments):
    if len(arguments) < 2 or arguments[0] in ("-h", "--help"):
        sys.exit(__doc__.strip())
    first, other, *rest = arguments
    rounds = ROUNDS
    if "--rounds" in rest:
        at = rest.index("--rounds")
        if at + 1 == len(rest) or not rest[at + 1].isdigit() or int(rest[at + 1]) == 0:
            sys.exit("against: --rounds: expected a whole number from 1")
        rounds = int(rest[at + 1])
        del rest[at : at + 2]
    for path in (first, other):
        if not Path(path).is_file():
            sys.exit(f"against: {path}: no such file")
    if is_results(first):
        if not is_results(other) or rest:
            sys.exit("against: results are compared with results, and nothing is run")
        ours, theirs = read(first), read(other)
    elif is_results(other):
        theirs = read(other)
        (ours,) = interleave([first], rounds, rest)
    else:
        ours, theirs = interleave([first, other], rounds, rest)
    compare = unpaired if is_results(other) else paired
    lines = comparison_table(ours, theirs, compare)
    if not lines:
        sys.exit("against: the two have no benchmark in common")
    print(f"{ours.describe()}\n\n{theirs.describe()}\n\n{lines}", end="")
    for one, more in ((ours, theirs), (theirs, ours)):
        alone = [name for name in one.speeds if name not in more.speeds]
        # A file holds what was run then; the filter of today leaves much of it out.
        if alone and not is_results(one.what):
            print(f"\nOnly in {one.what}: {', '.join(alone)}.")


if __name__ == "__main__":
    main(sys.argv[1:])
