# Sourced by the scripts in tools/: the root and the version of the checkout, and how they speak and fail.
# shellcheck shell=bash

# shellcheck disable=SC2034  # used by the scripts that source this one
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)

project_version() { sed -nE 's/^project\(consimd VERSION ([0-9.]+).*/\1/p' "$root/CMakeLists.txt"; }

say() { printf 'consimd: %s\n' "$*" >&2; }

fail() {
  say "$*"
  exit 1
}
