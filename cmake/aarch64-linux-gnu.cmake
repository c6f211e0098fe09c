# Builds consimd::kernels (CONSIMD_KERNELS_ONLY) and consimd::synth for its tests, or all libraries, for 64-bit ARM with Debian's
# g++-aarch64-linux-gnu; tests run under qemu-user.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64 -L /usr/aarch64-linux-gnu)

# These headers of the host serve any processor, but the folder they are in holds the host's C library as well.
file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/host-headers)
foreach(headers xsimd Random123)
  file(CREATE_LINK /usr/include/${headers} ${CMAKE_BINARY_DIR}/host-headers/${headers} SYMBOLIC)
endforeach()
set(XSIMD_INCLUDE_DIR ${CMAKE_BINARY_DIR}/host-headers CACHE PATH "Folder of xsimd/xsimd.hpp")
set(RANDOM123_INCLUDE_DIR ${CMAKE_BINARY_DIR}/host-headers CACHE PATH "Folder of Random123/philox.h")
