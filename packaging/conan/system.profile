# Takes what consimd needs from the distribution (Debian 12: libeigen3-dev, libfmt-dev, libtbb-dev, libxsimd-dev, nlohmann-json3-dev, zlib1g-dev) instead of building it.
include(default)

[settings]
compiler.cppstd=20

[platform_requires]
eigen/3.4.0
fmt/9.1.0
nlohmann_json/3.11.2
onetbb/2021.8.0
xsimd/8.1.0
zlib/1.2.13
