# Sourced by the scripts in tools/ that read the C++ sources.
# shellcheck shell=bash

. "$(dirname "${BASH_SOURCE[0]}")/packages.sh"

# Prints the path of every C++ source.
cxx_sources() { find "$root"/{text,kernels,poses,solvers,features,synth,studies,bench,cli,python,examples,fuzz,tests} -name '*.cpp' -o -name '*.hpp'; }
