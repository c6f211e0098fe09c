#!/usr/bin/env bash
#: deps [GROUP...]     install what is missing: browser, build, docs, figures, fuzz, lint, neon, python (default: all)
#: deps --check        list the dependencies: what is installed, what is taken, what the tests passed with
set -euo pipefail

. "$(dirname "${BASH_SOURCE[0]}")/shell/messages.sh"
. "$(dirname "${BASH_SOURCE[0]}")/shell/packages.sh"

# is_less A B: of two versions
is_less() { [[ $1 != "$2" && $(printf '%s\n' "$1" "$2" | sort --version-sort | head -n 1) == "$1" ]]; }

# installed_version NAME PACKAGE: without Debian's epoch, revision and mark of changed sources; nothing where it is not installed.
installed_version() {
  local name=$1 package=$2 version="" venv
  if [[ $package != pip ]]; then
    version=$(dpkg-query --show --showformat='${Version}\n' "$package" 2>/dev/null | head -n 1) || true
    version=${version#*:}
    version=${version%%[-+~]*}
    version=${version%.dfsg*}
  else
    for venv in "$root"/build/{python,lint}-venv; do
      [[ -n $version ]] || version=$("$venv/bin/python" -I -c \
        'import importlib.metadata, sys; print(importlib.metadata.version(sys.argv[1]))' "$name" 2>/dev/null) || true
    done
  fi
  printf '%s' "$version"
}

# Fails where a version is installed that consimd does not take.
check() {
  local name package at_least below tested installed verdict refused=0
  printf '%-18s %-10s %-18s %-14s %s\n' dependency installed taken tested ''
  while read -r name package at_least below tested; do
    installed=$(installed_version "$name" "$package")
    if [[ -z $installed ]]; then
      verdict="not installed"
    elif is_less "$installed" "$at_least" || ! is_less "$installed" "$below"; then
      verdict="out of bounds"
      refused=1
    elif [[ ,$tested, == *,"$installed",* ]]; then
      verdict="tested"
    else
      verdict="not tested"
    fi
    printf '%-18s %-10s %-18s %-14s %s\n' "$name" "${installed:--}" ">=$at_least,<$below" "$tested" "$verdict"
  done < <(grep -v '^#' "$root/cmake/dependencies.txt")
  ((refused == 0)) || fail "a version is out of bounds"
}

if [[ ${1:-} == --check ]]; then
  (($# == 1)) || fail "deps: --check takes no group"
  command -v dpkg-query >/dev/null || fail "deps: --check asks dpkg-query, which is not here"
  check
else
  need "${@:-${!packages_of[@]}}"
fi
