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
# fuzz TARGET
fuzz() {
  local target=$1 corpus=$root/build/fuzz/corpus/$1 findings=$root/build/fuzz/findings/$1 log processor
  mkdir -p "$corpus" "$findings"
  log=$(mktemp)
  # Bash tells the processor time of what ran: on a machine that is busy otherwise it says more than the seconds by the clock.
  local TIMEFORMAT='%U %S'
  if processor=$({ time "$root/build/fuzz/fuzz/fuzz_$target" -max_total_time="$seconds" -rss_limit_mb=3000 \
    -print_final_stats=1 -artifact_prefix="$findings/" "$corpus" "$root/fuzz/seeds/$target" >"$log" 2>&1; } 2>&1); then
    say "fuzz: $target: $(sed -nE 's/^stat::number_of_executed_units: *//p' "$log") executions in" \
      "$(awk '{ printf "%.0f", $1 + $2 }' <<<"$processor") s of processor time, nothing found"
    rm -f "$log"
  else
    tail -n 60 "$log" >&2 && rm -f "$log" && fail "fuzz: $target has a finding, kept in $findings"
  fi
}

say "fuzz: ${targets[*]}: $seconds s each, $(nproc) at a time"
export root seconds
export -f fuzz say fail
printf '%s\n' "${targets[@]}" | xargs -P "$(nproc)" -I{} bash -c 'set -euo pipefail; fuzz {}' || fail "fuzz: something was found"
