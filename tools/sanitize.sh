#!/usr/bin/env bash
#: sanitize [PRESET [FOLDER [ARG...]]]
#:                     run all tests, or those of a folder of tests/ alone (kernels, cli, ...), with the sanitizers: asan
#:                     (default, with UBSan) or tsan, whose oneTBB is compiled for it
set -euo pipefail

. "$(dirname "${BASH_SOURCE[0]}")/shell/building.sh"

# Under the thread sanitizer GCC 12 warns of what it makes of strings and optionals itself: the preset turns that off.
preset=${1:-asan}
folder=${2:-}
[[ $preset == asan || $preset == tsan ]] || fail "sanitize: '$preset' is neither asan nor tsan"
need build figures
export CONSIMD_TEST_SECONDS=3600
if [[ -z $folder ]]; then
  build "$preset"
  run_tests "$preset" --timeout 7200
else
  build "$preset" "tests/$folder/all"
  find_test_data
  # What is built names no folder of libraries. Tests with the system's oneTBB would report races that are none.
  if [[ $preset == tsan ]]; then export LD_LIBRARY_PATH=$root/build/tsan-tbb/prefix/lib; fi
  ctest --test-dir "$root/build/$preset/tests/$folder" --output-on-failure --no-tests=error --timeout 7200 --parallel "$(nproc)" \
    "${@:3}"
fi
