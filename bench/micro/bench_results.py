"""Reads what consimd_bench wrote (--benchmark_out=FILE.json), or what is kept of it beside docs/performance.md."""

import json
import sys

# The name of the machine and the path of the program stay behind.
CONTEXT = (
    "date",
    "num_cpus",
    "caches",
    "cpu",
    "system",
    *(f"consimd_{key}" for key in ("version", "commit", "compiler", "build_type", "flags", "threads", "isas")),
)


class Results:
    """context: what ran where. values: by benchmark, in the order of registration, its medians over the repetitions."""

    def __init__(self, path):
        with open(path, encoding="utf-8") as file:
            run = json.load(file)
        self.context = context_of(run)
        self.values = run["results"] if "results" in run else medians(run["benchmarks"])

    def isas(self):
        """Names of the instruction sets that the machine has, narrowest first."""
        return self.context.get("consimd_isas", "").split(", ")

    def keep(self, path):
        """One line a benchmark."""
        lines = (f"  {json.dumps(name)}: {json.dumps(values)}" for name, values in self.values.items())
        with open(path, "w", encoding="utf-8") as file:
            file.write(f'{{"context": {json.dumps(self.context)},\n "results": {{\n' + ",\n".join(lines) + "\n}}\n")

    def under(self, prefix):
        """(parts of the name after the prefix, values) of the benchmarks that have it."""
        for name, values in self.values.items():
            if name.startswith(prefix):
                yield name.removeprefix(prefix).split("/"), values

    def spreads(self):
        """Coefficients of variation over the repetitions, ascending; none without repetitions."""
        return sorted(values["cv"] for values in self.values.values() if "cv" in values)


class PortBounds:
    """What the execution ports of a processor allow, from a file such as port_bounds_zen4.json: operations of a kernel's
    loop by kind of pipe, as counted in its disassembly, and the cycles that they take at least."""

    def __init__(self, path):
        with open(path, encoding="utf-8") as file:
            bounds = json.load(file)
        self.processor, self.isa, self.loops = bounds["processor"], bounds["isa"], bounds["loops"]
        self.correspondences = bounds["correspondences"]  # that a loop's counts are for

    def rate(self, loop, clock):
        """Items a second at a clock in cycles a second."""
        return self.correspondences * clock / loop["cycles"]


def context_of(run):
    return {key: run["context"][key] for key in CONTEXT if key in run["context"]}


def name_of(entry):
    return entry["run_name"].split("/iterations:")[0]


def speed(values):
    """Items a second, or calls where nothing is counted."""
    if "items_per_second" in values:
        return values["items_per_second"]
    return 1e3 / next(values[key] for key in ("median_ms", "mean_ms", "real_time") if key in values)


def speeds(run):
    """Of every benchmark, in all repetitions; of what is kept, the median alone."""
    if "results" in run:
        return {name: [speed(values)] for name, values in run["results"].items()}
    found = {}
    for entry in run["benchmarks"]:
        if entry["run_type"] == "iteration" and not entry.get("error_occurred"):
            found.setdefault(name_of(entry), []).append(speed(entry))
    if not found:
        found = {name: [speed(values)] for name, values in medians(run["benchmarks"]).items()}
    return found


def medians(benchmarks):
    chosen, spreads = {}, {}
    for entry in benchmarks:
        name = name_of(entry)
        if entry.get("error_occurred"):
            print(f"left out, {entry['error_message']}: {name}", file=sys.stderr)
        elif entry["run_type"] == "iteration":
            chosen.setdefault(name, entry)
        elif entry["aggregate_name"] == "median":
            chosen[name] = entry
        elif entry["aggregate_name"] == "cv":
            spreads[name] = entry
    # With random interleaving the order of the file is another.
    ordered = sorted(chosen.items(), key=lambda item: item[1]["family_index"])
    return {name: kept_values(entry, spreads.get(name)) for name, entry in ordered}


def kept_values(entry, spread):
    if "items_per_second" in entry:
        quoted, values = "items_per_second", {"items": entry.get("label", "")}
    else:
        quoted, values = "median_ms", {"mean_ms": entry["real_time"]}
    values |= {k: v for k, v in entry.items() if k.endswith("_ms") or k in ("items_per_second", "recall", "peak_mib")}
    if spread and quoted in spread:
        values["cv"] = spread[quoted]
    return {k: float(f"{v:.4g}") if isinstance(v, float) else v for k, v in values.items()}
