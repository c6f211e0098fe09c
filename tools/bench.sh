#!/usr/bin/env bash
#: bench [ARG...]      run the micro-benchmarks; arguments as for Google Benchmark (--benchmark_filter=avx2), and
#:                     --sizes, --batch and --isas of the kernels (bench --help)
#: bench --report DIR [ARG...]
#:                     run them three times, interleaved; results, tables and figures of docs/performance.md in DIR
#: bench --against REV|FILE [--rounds N] [ARG...]
#:                     in turn with those of another revision, which is built, or of a consimd_bench; or compare with kept
#:                     results, FILE.json: a table of ratios with their intervals
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

# The benchmarks of a revision, built in a clone of its own.
build_revision() {
  local commit=$1 source
  source=$root/build/against/${commit:0:12}
  other=$source/build/release/bin/consimd_bench
  if [[ ! -x $other ]]; then
    say "building ${commit:0:12} in $source"
    rm -rf "$source"
    git clone --quiet --shared --no-checkout "$root" "$source"
    git -C "$source" checkout --quiet --detach "$commit"
    # Its paths below its own folder are those of this checkout below this one: ccache knows what did not change.
    (cd "$source" && CCACHE_BASEDIR=$source && export CCACHE_BASEDIR && cmake --preset release &&
      cmake --build build/release --target consimd_bench) >&2
  fi
}

if [[ ${1:-} == --against ]]; then
  (($# > 1)) || fail "bench: --against needs a revision, a consimd_bench, or results FILE.json"
  other=$2
  if [[ ! -f $other ]]; then
    commit=$(git -C "$root" rev-parse --verify --quiet "$2^{commit}") ||
      fail "bench: --against: '$2' is neither a file nor a revision"
  fi
  build release consimd_bench >&2
  [[ -f $other ]] || build_revision "$commit"
  exec python3 -B "$root/bench/micro/against.py" "$program" "$other" "${@:3}"
fi
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
python3 -B "$root/bench/micro/report.py" "$folder/bench.json" --keep "$folder/performance.json" >"$folder/tables.md"
"$python" -B "$root/bench/micro/plot_performance.py" "$folder/performance.json" "$folder"
say "wrote performance.json, tables.md and figures to $folder"
