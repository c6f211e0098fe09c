#!/usr/bin/env bash
#: bench [ARG...]      run the micro-benchmarks; arguments as for Google Benchmark (--benchmark_filter=avx2)
#: bench --report DIR [ARG...]
#:                     run them three times, interleaved; results, tables and figures of docs/performance.md in DIR
set -euo pipefail

. "$(dirname "${BASH_SOURCE[0]}")/shell/building.sh"

program=$root/build/release/bin/consimd_bench
# The Python in the path may be another than the one that has the distribution's matplotlib.
plotting_python() {
  local python
  for python in ${CONSIMD_PYTHON:-} python3 /usr/bin/python3; do
    "$python" -I -c 'import matplotlib' 2>/dev/null && echo "$python" && return
  done
  fail "no Python with matplotlib found: set CONSIMD_PYTHON to one"
}

if [[ ${1:-} != --report ]]; then
  build release consimd_bench
  exec "$program" "$@"
fi
(($# > 1)) || fail "bench: --report needs a folder"
folder=$2
need build figures
python=$(plotting_python)
build release consimd_bench
mkdir -p "$folder"
"$program" --benchmark_repetitions=3 --benchmark_enable_random_interleaving=true \
  --benchmark_report_aggregates_only=true --benchmark_out="$folder/bench.json" "${@:3}"
python3 -B "$root/bench/micro/report.py" "$folder/bench.json" "$folder/performance.json" >"$folder/tables.md"
"$python" -B "$root/bench/micro/plot_performance.py" "$folder/performance.json" "$folder"
say "wrote performance.json, tables.md and figures to $folder"
