#!/usr/bin/env bash
#: lint [FILE...]      formatting, project rules, scripts, prose and clang-tidy, the latter on all or the given sources
set -euo pipefail

. "$(dirname "${BASH_SOURCE[0]}")/shell/building.sh"
. "$(dirname "${BASH_SOURCE[0]}")/shell/cxx_sources.sh"

# Fails when a line of the given files, comments aside, matches: reject REASON PATTERN FILE...
reject() {
  local reason=$1 pattern=$2 hits
  shift 2
  hits=$(grep -nHE "$pattern" "$@" | grep -vE '^[^:]+:[0-9]+:\s*(//|#)' || true)
  [[ -z $hits ]] || fail "$reason:"$'\n'"$hits"
}

# What the compiler cannot check: flags and operations that would cost equal bits, what other compilers cannot take, and
# the direction of includes.
check_rules() {
  local cxx build_files
  mapfile -t cxx < <(cxx_sources)
  # The baselines in bench/micro, which kernels are measured against, are given every advantage of the machine.
  mapfile -t build_files < <(find "$root" \( -path "$root/build" -o -path "$root/bench/micro" \) -prune -o \
    \( -name CMakeLists.txt -o -name '*.cmake' -o -name CMakePresets.json \) -print)
  reject "flags that make results depend on the machine" 'march=native|ffast-math' "${build_files[@]}" "${cxx[@]}"
  reject "xsimd operations that differ between instruction sets" 'xsimd::(fma|fms|fnma|rsqrt|reciprocal)\b' "${cxx[@]}"
  reject "ranges that clang before 16 cannot take from libstdc++" \
    'std::ranges::(unique|remove|remove_if|partition|stable_partition|rotate|search|find_end|equal_range|subrange)\b|std::(ranges::)?views::' "${cxx[@]}"
  python3 "$root/tools/check_includes.py" || fail "includes that the layers or rooms forbid"
  python3 -I "$root/tools/check_using.py" "${cxx[@]}" || fail "names that are brought in for nothing"
}

check_scripts() {
  shellcheck "$root"/{dev,.ci/run} "$root"/{tools,tests}/*.sh "$root"/{tools,tests}/*/*.sh
  find "$root"/{bench,cli,docs,studies,packaging,python,tests,tools} -name '*.py' -print0 |
    xargs -0 python3 -I -c 'import ast, sys; [ast.parse(open(f).read(), f) for f in sys.argv[1:]]'
}

check_prose() {
  find "$root" \( -path "$root/build" -o -name '.*' \) -prune -o -name '*.md' -print0 | xargs -0 python3 "$root/tools/check_prose.py"
}

# clang-tidy of PyPI, in build/lint-venv: it leaves the headers of the system alone, which makes it four times as fast as
# that of Debian 12.
tidy_program() {
  local venv=$root/build/lint-venv
  [[ -x $venv/bin/python ]] || python3 -m venv --clear "$venv" || fail "cannot make $venv"
  "$venv/bin/pip" install --quiet --disable-pip-version-check 'clang-tidy>=23.1,<23.2' || fail "cannot install clang-tidy"
}

# What clang-tidy reads, in build/tidy: the release build as it is configured, with the Python module where ./dev python has left
# nanobind.
tidy_database() {
  local python=$root/build/python-venv/bin/python module=()
  if "$python" -I -c 'import nanobind' 2>/dev/null; then
    module=(-DCONSIMD_BUILD_PYTHON=ON -DPython_EXECUTABLE="$python")
  else
    say "python/src is left out until ./dev python has run"
  fi
  (cd "$root" && cmake --preset release -B build/tidy -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON "${module[@]}" >/dev/null) ||
    fail "cannot configure build/tidy"
  sed -i 's/ -fno-gnu-unique//' "$root/build/tidy/compile_commands.json"  # which clang does not know
}

# The files of build/NAME/compile_commands.json: compiled_files NAME.
compiled_files() {
  local files
  files=$(sed -nE 's/^ *"file": "(.*)",?$/\1/p' "$root/build/$1/compile_commands.json" | sort -u)
  [[ -n $files ]] || fail "build/$1 compiles no file"
  printf '%s\n' "$files"
}

# clang_tidy NAME [ARGUMENT...]: on each of the files read, as build/NAME compiles it. Writes findings to the standard error and the
# files that have any to the standard output. Clean files print nothing: clang-tidy reports the number of suppressed warnings even when told to be quiet.
clang_tidy() {
  # shellcheck disable=SC2016  # expanded by the inner shell
  tr '\n' '\0' | xargs -0 -r -P "$(nproc)" -I '{}' bash -c \
    'report=$("$1/lint-venv/bin/clang-tidy" --quiet -p "$1/$2" "${@:4}" "$3" 2>&1) || { printf "%s\n" "$report" >&2; printf "%s\n" "$3"; }' \
    _ "$root/build" "$1" '{}' "${@:2}"
}

# The sources with findings. Most of the time goes into headers, so that up to eight sources are read at once first, and alone
# those of which a batch complains. What clang-tidy finds in main files alone, check_using.py does; vectors that could reserve
# are reported in some batches of sources that are clean alone.
sources_with_findings() {
  local batches batch sources
  python3 -I "$root/tools/tidy_batches.py" "$root/build/tidy" "$root/build/tidy-batches" || fail "sources cannot be put together"
  batches=$(compiled_files tidy-batches |
    clang_tidy tidy-batches --checks=-bugprone-suspicious-include,-performance-inefficient-vector-operation 2>/dev/null) ||
    fail "clang-tidy cannot be run"
  for batch in $batches; do
    sources=$(sed -nE 's/^#include "(.*)"$/\1/p' "$batch")
    [[ -n $sources ]] || fail "$batch has findings, but no sources"
    printf '%s\n' "$sources"
  done | clang_tidy tidy
}

need build lint
say "checking the format"
"$root/tools/format.sh" --check
say "checking the project's rules"
check_rules
check_scripts
check_prose || fail "the pages have faults"
say "running clang-tidy"
tidy_program
tidy_database
if (($#)); then
  found=$(printf '%s\n' "$@" | clang_tidy tidy) || fail "clang-tidy cannot be run"
else
  found=$(sources_with_findings) || fail "clang-tidy cannot be run"
fi
[[ -z $found ]] || fail "clang-tidy has findings in:"$'\n'"$found"
say "lint: nothing found"
