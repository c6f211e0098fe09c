#!/usr/bin/env bash
#: fuzz [TARGET [SECONDS]]
#:                     run a fuzz target of fuzz/, or all (default), for 60 or as many seconds each, from the seeds in the
#:                     repository and what earlier runs found, build/fuzz/corpus/TARGET; needs clang
set -euo pipefail

. "$(dirname "${BASH_SOURCE[0]}")/shell/building.sh"

mapfile -t known < <(sed -nE 's/^fuzz_target\((\w+) .*/\1/p' "$root/fuzz/CMakeLists.txt")
wanted=${1:-all}
seconds=${2:-60}
[[ $seconds =~ ^[1-9][0-9]*$ ]] || fail "fuzz: '$seconds' is no number of seconds"
if [[ $wanted == all ]]; then
  targets=("${known[@]}")
elif printf '%s\n' "${known[@]}" | grep -qxF -e "$wanted"; then
  targets=("$wanted")
else
  fail "fuzz: unknown target '$wanted'; known: all ${known[*]}"
fi

need build fuzz
build fuzz "${targets[@]/#/fuzz_}"
# Memory that is asked for and not there is an error that the libraries pass on, no finding.
export ASAN_OPTIONS=allocator_may_return_null=1
for target in "${targets[@]}"; do
  corpus=$root/build/fuzz/corpus/$target
  findings=$root/build/fuzz/findings/$target
  mkdir -p "$corpus" "$findings"
  log=$(mktemp)
  say "fuzz: $target, $seconds s"
  "$root/build/fuzz/fuzz/fuzz_$target" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=3000 -print_final_stats=1 \
    -artifact_prefix="$findings/" "$corpus" "$root/fuzz/seeds/$target" >"$log" 2>&1 ||
    { tail -n 60 "$log" >&2 && rm -f "$log" && fail "fuzz: $target has a finding, kept in $findings"; }
  say "fuzz: $target: $(sed -nE 's/^stat::number_of_executed_units: *//p' "$log") executions, nothing found"
  rm -f "$log"
done
