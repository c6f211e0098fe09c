#!/usr/bin/env bash
#: build [PRESET]      build: release (default), debug, asan, tsan or neon
set -euo pipefail

. "$(dirname "${BASH_SOURCE[0]}")/shell/building.sh"

build "${1:-release}"
