# Sourced by the scripts in tools/: the root of the checkout, and how they speak and fail.
# shellcheck shell=bash

# shellcheck disable=SC2034  # used by the scripts that source this one
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)

say() { printf 'consimd: %s\n' "$*" >&2; }

fail() {
  say "$*"
  exit 1
}
