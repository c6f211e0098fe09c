# shellcheck shell=bash
# What the scripts that check packages share. They set `check`, the word before what they say.

say() { printf '%s: %s\n' "${check:?}" "$*" >&2; }

fail() {
  say "$*"
  exit 1
}

# quietly COMMAND...: its output shows when it fails.
quietly() {
  local log
  log=$(mktemp)
  "$@" >"$log" 2>&1 || { cat "$log" >&2 && rm -f "$log" && fail "failed: $*"; }
  rm -f "$log"
}
