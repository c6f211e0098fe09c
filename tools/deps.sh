#!/usr/bin/env bash
#: deps [GROUP...]     install what is missing: build, docs, figures, lint, neon, python (default: all)
set -euo pipefail

. "$(dirname "${BASH_SOURCE[0]}")/shell/packages.sh"

need "${@:-${!packages_of[@]}}"
