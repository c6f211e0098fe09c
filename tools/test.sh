#!/usr/bin/env bash
#: test [ARG...]       build and run all tests; arguments as for ctest (-R kernels)
set -euo pipefail

. "$(dirname "${BASH_SOURCE[0]}")/shell/building.sh"

need build figures
build release
run_tests release "$@"
