#!/usr/bin/env bash
#: compare [ARG...]    compare the solvers; arguments as for `consimd compare`
#: compare --page [WORD]
#:                     run the commands of docs/comparison.md, or those whose arguments hold the word, and renew their tables
set -euo pipefail

. "$(dirname "${BASH_SOURCE[0]}")/shell/building.sh"

program=$root/build/release/bin/consimd
build release consimd_cli
[[ ${1:-} == --page ]] || exec "$program" compare "$@"
PATH=$(dirname "$program"):$PATH exec python3 -B "$root/studies/src/compare/comparison_page.py" \
  "$root/docs/comparison.md" "${2:-}"
