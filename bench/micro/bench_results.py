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
        self.context = {key: run["context"][key] for key in CONTEXT if key in run["context"]}
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


def medians(benchmarks):
    chosen, spreads = {}, {}
    for entry in benchmarks:
        name = entry["run_name"].split("/iterations:")[0]
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
