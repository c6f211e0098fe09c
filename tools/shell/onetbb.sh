# Sourced by building.sh: oneTBB where the system's does not serve, from the packages of Debian or Ubuntu, in the build folder. The
# lists of apt-get are own ones, so that nothing of the system changes and nobody must be root.
# shellcheck shell=bash

. "$(dirname "${BASH_SOURCE[0]}")/packages.sh"

# apt_get_apart FOLDER ARGUMENT...
apt_get_apart() {
  local folder=$1
  mkdir -p "$folder"/{lists,cache}/partial
  (cd "$folder" && apt-get -qq -o Dir::State::Lists="$folder/lists" -o Dir::Cache="$folder/cache" -o APT::Sandbox::User=root "${@:2}")
}

# oneTBB of 64-bit ARM, in build/neon-tbb/usr, which the preset neon-solvers names.
fetch_arm64_tbb() {
  local into=$root/build/neon-tbb package arm64
  [[ ! -e $into/done ]] || return 0
  rm -rf "$into" && mkdir -p "$into/apt"
  : >"$into/apt/status"
  arm64=(-o APT::Architecture=arm64 -o APT::Architectures=arm64 -o Dir::State::status="$into/apt/status")
  say "fetching oneTBB of 64-bit ARM"
  apt_get_apart "$into/apt" "${arm64[@]}" update >/dev/null &&
    apt_get_apart "$into/apt" "${arm64[@]}" download libtbb-dev libtbb12 libtbbmalloc2 libtbbbind-2-5 >/dev/null || return 1
  for package in "$into"/apt/*.deb; do dpkg-deb --extract "$package" "$into" || return 1; done
  rm -rf "$into/apt"
  touch "$into/done"
}
