#!/usr/bin/env bash
#: tarball             write the committed sources to build/consimd-VERSION.tar.gz, the same bytes for the same commit, then
#:                     configure what it holds, and build and install the libraries from it
set -euo pipefail

. "$(dirname "${BASH_SOURCE[0]}")/shell/building.sh"

version=$(project_version)
file=$root/build/consimd-$version.tar.gz
need build
[[ -z $(git -C "$root" status --porcelain) ]] || say "uncommitted changes are not in the tarball"
mkdir -p "$root/build"
archive() { git -C "$root" archive --format=tar --prefix="consimd-$version/" HEAD | gzip -n9; }
archive >"$file"
archive | cmp - "$file" || fail "two archives of one commit differ"
# Below a fixed folder, so that ccache knows the sources again.
rm -rf "$root/build/tarball" && mkdir "$root/build/tarball"
tar -xzf "$file" -C "$root/build/tarball"
use_ccache
cmake -S "$root/build/tarball/consimd-$version" -B "$root/build/tarball/build" -G Ninja \
  -DCONSIMD_BUILD_CLI=OFF -DCONSIMD_BUILD_TESTS=OFF -DCONSIMD_BUILD_BENCHMARKS=OFF >/dev/null
cmake --build "$root/build/tarball/build"
cmake --install "$root/build/tarball/build" --prefix "$root/build/tarball/prefix" >/dev/null
say "wrote $file"
sha256sum "$file"
