#!/usr/bin/env bash
# What `./dev package` runs: check_package.sh CHECKOUT RELEASE_BUILD
# Installs the static libraries, the shared ones and static ones compiled with -march=native, and holds the project beside this script
# against each of them. Everything is written to folders CHECKOUT/build/package-NAME, as deep as
# the release build, so that ccache knows its objects again.
set -euo pipefail

root=$1
release=$2
consumer=$root/tests/package
work=$root/build/package

check=package
# shellcheck source=tests/check.sh
. "$root/tests/check.sh"

# install_library NAME CMAKE_ARGUMENT...: builds and installs to $work-NAME/prefix.
install_library() {
  local build=$work-$1
  say "library: $1"
  quietly cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX="$build/prefix" \
    -DCONSIMD_WERROR="${CONSIMD_WERROR:-OFF}" -DCONSIMD_BUILD_TESTS=OFF -DCONSIMD_BUILD_BENCHMARKS=OFF "${@:2}"
  quietly cmake --build "$build"
  rm -rf "$build/prefix"
  quietly cmake --install "$build"
}

# configure_consumer NAME CMAKE_ARGUMENT...: the consumer project in $work-NAME.
configure_consumer() {
  say "project: $1"
  quietly cmake -S "$consumer" -B "$work-$1" -G Ninja -DCMAKE_BUILD_TYPE=Release "${@:2}"
}

# consume NAME CMAKE_ARGUMENT...: builds the consumer project and runs its programs. Of consimd as a part of it, what they use.
consume() {
  local target=all
  if [[ $* == *CONSIMD_FROM=* ]]; then target=programs; fi
  configure_consumer "$@"
  quietly cmake --build "$work-$1" --target "$target"
  quietly ctest --test-dir "$work-$1" --output-on-failure --no-tests=error
}

# --- The three installations ------------------------------------------------------------------------------------------

static=$work-static
rm -rf "$static"
quietly cmake --install "$release" --prefix "$static/prefix"
install_library shared -DBUILD_SHARED_LIBS=ON
# shellcheck disable=SC2054 # one argument of CMake
install_library native -DCMAKE_CXX_FLAGS=-march=native -DCONSIMD_BUILD_STUDIES=OFF -DCONSIMD_BUILD_CLI=OFF -DCONSIMD_BUILD_EXAMPLES=OFF
install_library kernels -DCONSIMD_KERNELS_ONLY=ON -DCMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON -DCMAKE_DISABLE_FIND_PACKAGE_TBB=ON
for name in static shared; do "$work-$name/prefix/bin/consimd" info >/dev/null || fail "the installed command does not run"; done

# --- Every way to the library -----------------------------------------------------------------------------------------

compilers=(g++)
if command -v clang++ >/dev/null; then compilers+=(clang++); fi
for compiler in "${compilers[@]}"; do
  for name in static shared; do
    # All installations have the same headers: once alone, once together by each compiler.
    case $name-$compiler in
      static-g++) headers=(-DHEADERS_ALONE=ON -DHEADERS_TOGETHER=ON) ;;
      static-*) headers=(-DHEADERS_TOGETHER=ON) ;;
      *) headers=() ;;
    esac
    consume "find_package-$name-$compiler" -DCMAKE_CXX_COMPILER="$compiler" -DCMAKE_PREFIX_PATH="$work-$name/prefix" "${headers[@]}"
  done
done
consume find_package-native -DCMAKE_PREFIX_PATH="$work-native/prefix"
consume find_package-kernels -DKERNELS_ONLY=ON -DCMAKE_PREFIX_PATH="$work-kernels/prefix" \
  -DCMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON -DCMAKE_DISABLE_FIND_PACKAGE_TBB=ON
say "a component that there is not"
mkdir -p "$work-component"
cat >"$work-component/CMakeLists.txt" <<'END'
cmake_minimum_required(VERSION 3.25)
project(component LANGUAGES NONE)
find_package(consimd REQUIRED COMPONENTS solver)
END
said=$(cmake -S "$work-component" -B "$work-component/build" -DCMAKE_PREFIX_PATH="$static/prefix" 2>&1) && fail "find_package finds a component 'solver'"
[[ $(tr -s '[:space:]' ' ' <<<"$said") == *"no component 'solver', expected some of: kernels;"* ]] || fail "find_package names no component: $said"
# With the flags of the release build, so that ccache knows these objects too.
werror=-DCONSIMD_WERROR=${CONSIMD_WERROR:-OFF}
consume add_subdirectory-static -DCONSIMD_FROM=add_subdirectory -DCONSIMD_CHECKOUT="$root" "$werror"
consume FetchContent-shared -DCONSIMD_FROM=FetchContent -DCONSIMD_CHECKOUT="$root" "$werror" -DBUILD_SHARED_LIBS=ON

say "project: examples"
quietly cmake -S "$root/examples" -B "$work/examples" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$static/prefix"
quietly cmake --build "$work/examples"
quietly ctest --test-dir "$work/examples" --output-on-failure --no-tests=error

say "pkg-config"
for name in static shared; do
  pc=$work-$name/prefix/$(cd "$work-$name/prefix" && find . -name pkgconfig)
  for program in "register_synthetic consimd-solvers consimd-synth" "run_sweep consimd-studies" "count_consistent consimd-kernels"; do
    read -r -a words <<<"$program"
    read -r -a flags < <(PKG_CONFIG_PATH=$pc pkg-config --cflags --libs "${words[@]:1}")
    quietly g++ -std=c++20 -O1 -o "$work-${words[0]}" "$consumer/${words[0]}.cpp" "${flags[@]}" "-Wl,-rpath,$pc/.."
    quietly "$work-${words[0]}"
  done
done

# --- Headers and symbols ----------------------------------------------------------------------------------------------

say "what the headers of consimd::kernels include"
include=$work-static/prefix/include
seen=$(for header in "$include"/consimd/kernels/*.hpp; do g++ -std=c++20 -M -x c++ "$header" -I"$include"; done)
! grep -ioE '[^ ]*/(eigen[0-9]*|tbb|oneapi|xsimd|random123)/[^ ]*' <<<"$seen" || fail "consimd::kernels shows these to its users"

say "symbols and names of the shared libraries"
libraries=()
for library in "$work-shared"/prefix/lib*/libconsimd_*.so "$work-shared"/prefix/lib/*/libconsimd_*.so; do
  [[ -e $library ]] || continue
  libraries+=("$library")
  exported=$(nm -DC --defined-only "$library" | cut -d' ' -f3-)
  [[ -n $exported ]] || fail "$library exports nothing"
  ! grep -vE '^consimd::' <<<"$exported" || fail "$library exports what is not consimd's"
  ! grep -E 'consimd::detail::' <<<"$exported" || fail "$library exports internals"
  soname=$(readelf -d "$library" | sed -nE 's/.*SONAME.*\[(.*)\]/\1/p')
  [[ $soname =~ ^libconsimd_[a-z]+\.so\.[0-9]+\.[0-9]+$ ]] || fail "$library has the soname '$soname'"
  [[ -e $(dirname "$library")/$soname ]] || fail "$soname is not installed"
done
((${#libraries[@]} == 6)) || fail "expected six shared libraries, found ${#libraries[@]}"

say "what the installed binaries load and call, and how they are hardened"
quietly python3 -I "$root/tools/check_binaries.py" --hardened --reproducible "$static/prefix" "$work-shared/prefix"

# --- Flags ------------------------------------------------------------------------------------------------------------

# The programs of the projects above, and of projects compiled for this processor, on libraries that are, or are not.
say "the same bits whatever the flags"
bits=$(mktemp)
# shellcheck disable=SC2064 # expands now
trap "rm -f '$bits'" EXIT
"$work-find_package-static-g++/pose_bits" >"$bits"
same_bits() {
  diff "$bits" <("$work-$1/pose_bits") >&2 || fail "$1: other bits than a plain program on the plain static library"
}
for compiler in "${compilers[@]}"; do
  for name in static shared native; do
    configure_consumer "march=native-$name-$compiler" -DCMAKE_CXX_COMPILER="$compiler" \
      -DCMAKE_PREFIX_PATH="$work-$name/prefix" -DCMAKE_CXX_FLAGS=-march=native -DSTRICT=OFF
    quietly cmake --build "$work-march=native-$name-$compiler" --target pose_bits
    same_bits "march=native-$name-$compiler"
    [[ $name == static ]] || continue
    quietly cmake --build "$work-march=native-$name-$compiler" --target golden_digests
    quietly "$work-march=native-$name-$compiler/golden_digests" "$root/tests/golden/golden_digests.txt"
  done
  same_bits "find_package-static-$compiler"
  same_bits "find_package-shared-$compiler"
done
same_bits find_package-native
cat "$bits"
say "all held"
