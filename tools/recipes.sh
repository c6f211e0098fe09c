#!/usr/bin/env bash
#: recipes             build the Conan package and the vcpkg port of packaging/ with what the distribution has, and hold
#:                     tests/package against them
set -euo pipefail

. "$(dirname "${BASH_SOURCE[0]}")/shell/building.sh"

venv=$root/build/recipes/venv
need build python
configure release
[[ -x $venv/bin/conan ]] || { python3 -m venv "$venv" && "$venv/bin/pip" install --quiet 'conan>=2.4'; }
"$root/tests/packaging/check_recipes.sh" "$root" "$root/build/release" "$venv"
