# Sourced by building.sh: oneTBB and zlib where the system's do not serve, from the packages of Debian or Ubuntu, in the build folder. The
# lists of apt-get are own ones, so that nothing of the system changes and nobody must be root.
# shellcheck shell=bash

. "$(dirname "${BASH_SOURCE[0]}")/packages.sh"

# apt_get_apart FOLDER ARGUMENT...
apt_get_apart() {
  local folder=$1
  mkdir -p "$folder"/{lists,cache}/partial
  (cd "$folder" && apt-get -qq -o Dir::State::Lists="$folder/lists" -o Dir::Cache="$folder/cache" -o APT::Sandbox::User=root "${@:2}")
}

# oneTBB and zlib of 64-bit ARM, in build/neon-libraries/usr, which the preset neon-solvers names.
fetch_arm64_libraries() {
  local into=$root/build/neon-libraries package arm64
  [[ ! -e $into/done ]] || return 0
  rm -rf "$into" && mkdir -p "$into/apt"
  : >"$into/apt/status"
  arm64=(-o APT::Architecture=arm64 -o APT::Architectures=arm64 -o Dir::State::status="$into/apt/status")
  say "fetching oneTBB and zlib of 64-bit ARM"
  apt_get_apart "$into/apt" "${arm64[@]}" update >/dev/null &&
    apt_get_apart "$into/apt" "${arm64[@]}" download libtbb-dev libtbb12 libtbbmalloc2 libtbbbind-2-5 zlib1g-dev >/dev/null || return 1
  for package in "$into"/apt/*.deb; do dpkg-deb --extract "$package" "$into" || return 1; done
  rm -rf "$into/apt"
  touch "$into/done"
}

# The system's oneTBB compiled for the thread sanitizer, in build/tsan-tbb/prefix, which the preset tsan names. The sanitizer cannot see
# that a parallel loop orders what came before it, its bodies and what follows unless the library is instrumented.
build_tsan_tbb() {
  local into=$root/build/tsan-tbb version list
  version=$(dpkg-query --show --showformat='${source:Version}' libtbb-dev 2>/dev/null) || return 1
  [[ ! -e $into/done || $(<"$into/done") != "$version" ]] || return 0
  rm -rf "$into" && mkdir -p "$into"/{apt/sources,source}
  for list in /etc/apt/sources.list /etc/apt/sources.list.d/*; do
    [[ ! -r $list ]] || sed -E 's/^(Types: *)deb *$/\1deb-src/; s/^deb /deb-src /' "$list" >"$into/apt/sources/${list##*/}"
  done
  local sources=(-o Dir::Etc::sourcelist=/dev/null -o Dir::Etc::sourceparts="$into/apt/sources")
  say "fetching and compiling oneTBB $version for the thread sanitizer"
  # A list without sources is an error of update; whether it mattered shows in the next line.
  apt_get_apart "$into/apt" "${sources[@]}" update >/dev/null 2>&1 || true
  apt_get_apart "$into/apt" "${sources[@]}" source --download-only "onetbb=$version" >/dev/null || return 1
  tar --extract --strip-components=1 --directory="$into/source" --file="$(echo "$into"/apt/onetbb_*.orig.tar.*)" || return 1
  # Frame pointers and lines, for reports that name who called.
  cmake -S "$into/source" -B "$into/build" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DTBB_SANITIZE=thread -DTBB_TEST=OFF \
    -DTBB_STRICT=OFF -DTBBMALLOC_BUILD=OFF -DCMAKE_INSTALL_PREFIX="$into/prefix" -DCMAKE_INSTALL_LIBDIR=lib >/dev/null &&
    cmake --build "$into/build" >/dev/null && cmake --install "$into/build" >/dev/null || return 1
  rm -rf "$into"/{apt,source,build}
  echo "$version" >"$into/done"
}
