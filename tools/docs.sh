#!/usr/bin/env bash
#: docs                write the API reference of the public headers to build/reference/html; any warning fails
set -euo pipefail

. "$(dirname "${BASH_SOURCE[0]}")/shell/building.sh"

need docs
reference=$root/build/reference
headers=$(cd "$root" && find . -path './[a-z]*/include' -not -path './build/*' | sed 's,^\./,,' | sort)
rm -rf "$reference" && mkdir -p "$reference"
(cd "$root" && CONSIMD_VERSION=$(project_version) CONSIMD_REFERENCE=$reference CONSIMD_HEADERS=${headers//$'\n'/ } \
  doxygen docs/Doxyfile) || fail "the comments of the public headers have faults"
say "wrote $reference/html/index.html"
