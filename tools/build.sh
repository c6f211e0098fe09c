#!/usr/bin/env bash
#: build [PRESET [TARGET...]]
#:                     build all or the targets of release (default), debug, asan, tsan, fuzz or neon
set -euo pipefail

. "$(dirname "${BASH_SOURCE[0]}")/shell/building.sh"

build "${@:-release}"
