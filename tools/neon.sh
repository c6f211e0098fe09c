#!/usr/bin/env bash
#: neon [ARG...]       cross-compile kernels and generators for 64-bit ARM and run their tests under qemu
set -euo pipefail

. "$(dirname "${BASH_SOURCE[0]}")/shell/building.sh"

need build neon
build neon
run_tests neon "$@"
