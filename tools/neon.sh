#!/usr/bin/env bash
#: neon [ARG...]       cross-compile kernels and generators for 64-bit ARM and run their tests under qemu
#: neon solvers [ARG...]
#:                     the same of solvers and front end: the digests of registrations must be those of every other build
set -euo pipefail

. "$(dirname "${BASH_SOURCE[0]}")/shell/building.sh"

need build neon
if [[ ${1:-} == solvers ]]; then
  build neon-solvers consimd_golden_digests
  run_tests neon-solvers -R '^golden\.digests(_of_the_reference)?$' "${@:2}"
else
  build neon
  run_tests neon "$@"
fi
