#!/usr/bin/env bash
#: package             install, then build and run the consumer project tests/package against the installed tree, in all ways:
#:                     find_package, add_subdirectory, FetchContent, pkg-config; static, shared; with and without -march=native
set -euo pipefail

. "$(dirname "${BASH_SOURCE[0]}")/shell/building.sh"

build release
"$root/tests/package/check_package.sh" "$root" "$root/build/release"
