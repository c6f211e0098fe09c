#!/usr/bin/env bash
#: sweep [ARG...]      run the noise study; arguments as for `consimd sweep` (--help lists them)
set -euo pipefail

. "$(dirname "${BASH_SOURCE[0]}")/shell/building.sh"

need build figures
build release consimd_cli
exec "$root/build/release/bin/consimd" sweep "$@"
