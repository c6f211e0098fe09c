# Sourced by the scripts in tools/: the distribution's packages, by group, installed where they are missing.
# shellcheck shell=bash

. "$(dirname "${BASH_SOURCE[0]}")/messages.sh"

declare -A packages_of=(
  [browser]="chromium"
  [build]="g++ cmake ninja-build libeigen3-dev libtbb-dev libxsimd-dev librandom123-dev libcli11-dev libfmt-dev
    zlib1g-dev nlohmann-json3-dev libgtest-dev libgmock-dev libbenchmark-dev libigraph-dev ccache python3"
  [docs]="doxygen"
  [figures]="python3-matplotlib"
  [fuzz]="clang"
  [lint]="clang-format python3 python3-venv shellcheck"
  [neon]="g++-aarch64-linux-gnu qemu-user googletest"
  [python]="python3-dev python3-venv"
)

# Installs what is missing of the named package groups.
need() {
  [[ -z ${CONSIMD_NO_INSTALL:-} ]] || return 0
  local group list="" packages missing=() installed package known
  for group in "$@"; do
    known=$(printf '%s\n' "${!packages_of[@]}" | sort | xargs)
    [[ -n ${packages_of[$group]:-} ]] || fail "unknown package group '$group'; known: $known"
    list+=" ${packages_of[$group]}"
  done
  read -r -d '' -a packages <<<"$list" || true
  if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
    say "no apt-get here. Install what your system calls these Debian packages, then set CONSIMD_NO_INSTALL=1:"
    fail "  ${packages[*]}"
  fi
  installed=$(dpkg-query --show --showformat='${db:Status-Status}:${Package}\n' "${packages[@]}" 2>/dev/null || true)
  for package in "${packages[@]}"; do
    grep -qxF "installed:$package" <<<"$installed" || missing+=("$package")
  done
  ((${#missing[@]} == 0)) || install_packages "${missing[@]}"
}

install_packages() {
  local as_root=() log
  if ((EUID != 0)); then
    command -v sudo >/dev/null || fail "missing packages. As root: apt-get install $*"
    as_root=(sudo)
  fi
  log=$(mktemp)
  apt_get() {
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -y -o DPkg::Lock::Timeout=300 "$@" </dev/null >>"$log" 2>&1
  }
  say "installing with apt-get: $*"
  # Package lists are fetched only when the ones at hand turn out to be absent or stale.
  apt_get install --no-install-recommends "$@" ||
    { apt_get update && apt_get install --no-install-recommends "$@"; } ||
    { cat "$log" >&2 && fail "could not install: $*"; }
  rm -f "$log"
}
