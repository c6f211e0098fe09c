#!/usr/bin/env bash
# What `./dev recipes` runs: check_recipes.sh CHECKOUT RELEASE_BUILD VENV
# Builds the Conan package and the vcpkg port, and holds the project tests/package against each. VENV has conan. What the recipes
# require comes from the distribution, xsimd for vcpkg from a wheel that carries a recent one (XSIMD_CARRIER).
set -euo pipefail

root=$1
release=$2
venv=$3
work=$root/build/recipes
consumer=$root/tests/package
XSIMD_CARRIER=pythran==0.19.0

check=recipes
# shellcheck source=tests/check.sh
. "$root/tests/check.sh"

# --- Conan --------------------------------------------------------------------------------------------------------------

export CONAN_HOME=$work/conan-home
[[ -e $CONAN_HOME/profiles/default ]] || quietly "$venv/bin/conan" profile detect

# create_package CONAN_ARGUMENT...: also runs the recipe's test_package.
create_package() {
  say "Conan: create $*"
  quietly "$venv/bin/conan" create "$root/packaging/conan" --no-remote --profile:all "$root/packaging/conan/system.profile" \
    --conf tools.cmake.cmaketoolchain:generator=Ninja --conf tools.cmake.cmaketoolchain:user_presets= \
    --conf tools.cmake.cmake_layout:test_folder="$work/conan-test" "$@"
}

quietly "$venv/bin/conan" remove --confirm 'consimd/*'
create_package --options '&:kernels_only=True'
create_package --options '&:shared=True'
create_package --options '&:studies=True'  # last: it leaves the programs of which one is run below

# --- vcpkg --------------------------------------------------------------------------------------------------------------

carrier=$work/${XSIMD_CARRIER//==/-}
if [[ ! -d $carrier ]]; then
  quietly "$venv/bin/pip" download --quiet --no-deps --dest "$work/wheels" "$XSIMD_CARRIER"
  quietly "$venv/bin/python" -m zipfile --extract "$work"/wheels/pythran-*.whl "$carrier"
fi
random123=$(sed -nE 's/^RANDOM123_INCLUDE_DIR:PATH=(.*)/\1/p' "$release/CMakeCache.txt")

# install_port NAME FEATURES LINKAGE: in $work/NAME/installed, as vcpkg does.
install_port() {
  local installed=$work/$1/installed
  say "vcpkg: install consimd[${2//;/,}], $3"
  rm -rf "$installed" && mkdir -p "$installed/include"
  ln -s "$carrier/pythran/xsimd" "$installed/include/xsimd"
  ln -s "$random123/Random123" "$installed/include/Random123"
  quietly cmake -DCURRENT_PORT_DIR="$root/packaging/vcpkg/consimd" -DCURRENT_INSTALLED_DIR="$installed" -DWORK="$work/$1" \
    -DFEATURES="$2" -DVCPKG_LIBRARY_LINKAGE="$3" -P "$root/tests/packaging/install_port.cmake"
}

# consume NAME BUILD_TYPE CMAKE_ARGUMENT...: the project on the installed port.
consume() {
  local build=$work/$1/consumer-$2
  say "project: $1, $2"
  quietly cmake -S "$consumer" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE="$2" -DCMAKE_PREFIX_PATH="$work/$1/installed" \
    -DSTRICT=OFF "${@:3}"
  quietly cmake --build "$build"
  quietly ctest --test-dir "$build" --output-on-failure --no-tests=error
}

# pkg_config NAME FOLDER PROGRAM PACKAGE...: the same without CMake.
pkg_config() {
  local flags
  read -r -a flags < <(PKG_CONFIG_PATH=$work/$1/installed/$2/pkgconfig pkg-config --cflags --libs "${@:4}")
  quietly g++ -std=c++20 -O1 -o "$work/$1/program" "$consumer/$3.cpp" "${flags[@]}"
  quietly "$work/$1/program"
}

install_port vcpkg-static "core;solvers;studies" static
consume vcpkg-static Release
consume vcpkg-static Debug
grep -q vcpkg-static/installed/debug/lib/libconsimd_solvers.a "$work/vcpkg-static/consumer-Debug/build.ninja" ||
  fail "a debug build does not link the debug libraries"
say "pkg-config"
pkg_config vcpkg-static lib register_synthetic consimd-solvers consimd-synth
pkg_config vcpkg-static debug/lib register_synthetic consimd-solvers consimd-synth
pkg_config vcpkg-static lib run_sweep consimd-studies

install_port vcpkg-core core dynamic
consume vcpkg-core Release -DKERNELS_ONLY=ON -DCMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON -DCMAKE_DISABLE_FIND_PACKAGE_TBB=ON

# --- The same bits ------------------------------------------------------------------------------------------------------

say "the same bits as from Conan, with another xsimd"
diff <("$(find "$work/conan-test" -name pose_bits -print -quit)") <("$work/vcpkg-static/consumer-Release/pose_bits") >&2 ||
  fail "the two packages differ in their results"

say "the kernels' tests with that xsimd"
quietly cmake -S "$root" -B "$work/xsimd" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCONSIMD_KERNELS_ONLY=ON \
  -DXSIMD_INCLUDE_DIR="$work/vcpkg-core/installed/include"
quietly cmake --build "$work/xsimd" --target consimd_kernels_tests
quietly ctest --test-dir "$work/xsimd/tests/kernels" --output-on-failure --no-tests=error --parallel "$(nproc)"
say "all held"
