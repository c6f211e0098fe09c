# Sourced by the scripts in tools/ that configure, build or test.
# shellcheck shell=bash

. "$(dirname "${BASH_SOURCE[0]}")/packages.sh"
. "$(dirname "${BASH_SOURCE[0]}")/libraries.sh"

use_ccache() {
  if command -v ccache >/dev/null; then
    export CMAKE_CXX_COMPILER_LAUNCHER=ccache
    # It knows sources with a precompiled header again only when told that none of them asks for the time of day; and the same
    # object from two build folders only when paths below the checkout do not count. Comments do count: a precompiled header kept
    # from before a comment changed no longer stands for its files, by whose content #pragma once knows them.
    export CCACHE_SLOPPINESS=pch_defines,time_macros CCACHE_BASEDIR=${CCACHE_BASEDIR:-$root} CCACHE_COMMENTS=true
  fi
}

# configure PRESET
configure() {
  local preset=$1
  need build
  use_ccache
  case $preset in
    neon-solvers) fetch_arm64_libraries || fail "oneTBB and zlib of 64-bit ARM cannot be fetched here" ;;
    tsan) build_tsan_tbb || fail "oneTBB cannot be compiled for the thread sanitizer here" ;;
  esac
  (cd "$root" && cmake --preset "$preset" -DCONSIMD_WERROR="${CONSIMD_WERROR:-OFF}" >/dev/null) ||
    fail "cannot configure preset '$preset'"
}

# build PRESET [TARGET...]
build() {
  configure "$1"
  cmake --build "$root/build/$1" ${2+--target "${@:2}"}
}

# Tests on recorded correspondences run where such data are at hand and skip elsewhere.
find_test_data() {
  local data=${CONSIMD_TEST_DATA:-$root/../shared/data}
  if [[ -d $data/correspondences ]]; then
    CONSIMD_TEST_DATA=$(cd "$data" && pwd)
    export CONSIMD_TEST_DATA
  fi
}

# run_tests PRESET [CTEST_ARGUMENT...]
run_tests() {
  local preset=$1
  shift
  find_test_data
  (cd "$root" && ctest --preset "$preset" --parallel "$(nproc)" "$@")
}
