#!/usr/bin/env bash
#: examples            build the programs of examples/ and run them; the one with PCL only where that is installed (libpcl-dev)
set -euo pipefail

. "$(dirname "${BASH_SOURCE[0]}")/shell/building.sh"

build release consimd_examples
(cd "$root/build/release/examples" && ctest --verbose --no-tests=error)
