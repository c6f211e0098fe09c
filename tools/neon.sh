#!/usr/bin/env bash
#: neon [ARG...]       cross-compile kernels and generators for 64-bit ARM and run their tests under qemu; then the digests of
#:                     registrations by every solver
set -euo pipefail

. "$(dirname "${BASH_SOURCE[0]}")/shell/building.sh"

# oneTBB of 64-bit ARM in build/neon-tbb, without adding that architecture to this system: apt-get keeps lists of its own.
fetch_tbb() {
  local into=$root/build/neon-tbb apt package
  [[ ! -e $into/usr/lib/aarch64-linux-gnu/libtbb.so ]] || return 0
  rm -rf "$into"
  mkdir -p "$into"/apt/{lists,cache}/partial
  : >"$into/apt/status"
  apt=(apt-get -qq -o APT::Architecture=arm64 -o APT::Architectures=arm64 -o Dir::State::Lists="$into/apt/lists"
    -o Dir::State::status="$into/apt/status" -o Dir::Cache="$into/apt/cache" -o APT::Sandbox::User=root)
  (cd "$into/apt" && "${apt[@]}" update && "${apt[@]}" download libtbb-dev libtbb12 libtbbmalloc2 libtbbbind-2-5) || return 1
  for package in "$into"/apt/*.deb; do dpkg-deb --extract "$package" "$into"; done
}

need build neon
build neon
run_tests neon "$@"
if fetch_tbb; then
  build neon-solvers consimd_golden_digests
  say "the digests on 64-bit ARM"
  qemu-aarch64 -L /usr/aarch64-linux-gnu -E LD_LIBRARY_PATH="$root/build/neon-tbb/usr/lib/aarch64-linux-gnu" \
    "$root/build/neon-solvers/tests/golden/consimd_golden_digests" "$root/tests/golden/golden_digests.txt"
else
  say "the digests of solvers are left out: oneTBB of 64-bit ARM cannot be fetched here"
fi
