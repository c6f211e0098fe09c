#!/usr/bin/env bash
#: format [--check]    format all C++ sources, or tell which are not formatted
set -euo pipefail

. "$(dirname "${BASH_SOURCE[0]}")/shell/cxx_sources.sh"

need lint
case ${1:-} in
  '') cxx_sources | xargs clang-format -i ;;
  --check) cxx_sources | xargs clang-format --dry-run -Werror ;;
  *) fail "format: unknown argument '$1'" ;;
esac
