# Takes what consimd needs from the distribution (Debian 12: libeigen3-dev, libtbb-dev, libxsimd-dev) instead of building it.
include(default)

[settings]
compiler.cppstd=20

[platform_requires]
eigen/3.4.0
onetbb/2021.8.0
xsimd/8.1.0
