# The installed tree: libraries, public headers, the command, and packages for find_package(consimd) and pkg-config.
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/consimd)
set(pkgconfig_dir ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
file(RELATIVE_PATH pkgconfig_to_prefix /prefix/${pkgconfig_dir} /prefix)
if(IS_ABSOLUTE ${CMAKE_INSTALL_LIBDIR})
  file(RELATIVE_PATH pkgconfig_to_prefix ${pkgconfig_dir} ${CMAKE_INSTALL_PREFIX})
endif()
cmake_path(APPEND pkgconfig_libdir "\${prefix}" ${CMAKE_INSTALL_LIBDIR})
cmake_path(APPEND pkgconfig_includedir "\${prefix}" ${CMAKE_INSTALL_INCLUDEDIR})

# consimd_install(LIBRARY DESCRIPTION [REQUIREMENT...]): the requirements are other packages' names for pkg-config.
function(consimd_install library description)
  install(TARGETS consimd_${library} EXPORT consimd-${library})
  install(EXPORT consimd-${library} NAMESPACE consimd:: FILE consimd-${library}-targets.cmake DESTINATION ${package_dir})
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${library}/include/ TYPE INCLUDE FILES_MATCHING PATTERN "*.hpp")
  list(JOIN ARGN ", " requirements)
  configure_file(${PROJECT_SOURCE_DIR}/cmake/consimd.pc.in ${PROJECT_BINARY_DIR}/consimd-${library}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/consimd-${library}.pc DESTINATION ${pkgconfig_dir})
endfunction()

# Static libraries leave linking oneTBB, zlib and fmt to their user.
set(solvers_requirements consimd-poses)
set(features_requirements consimd-solvers)
set(studies_requirements consimd-features consimd-solvers consimd-synth)
set(CONSIMD_STATIC OFF)
if(NOT BUILD_SHARED_LIBS)
  set(CONSIMD_STATIC ON)
  list(APPEND solvers_requirements tbb)
  list(APPEND features_requirements tbb zlib)
  list(APPEND studies_requirements fmt)
endif()

set(CONSIMD_COMPONENTS kernels)
consimd_install(kernels "SIMD consensus kernels for 3D registration")
install(FILES ${PROJECT_BINARY_DIR}/include/consimd/version.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/consimd)
if(NOT CONSIMD_KERNELS_ONLY)
  list(APPEND CONSIMD_COMPONENTS poses solvers features synth)
  consimd_install(poses "Rigid fits and poses in Eigen's types for consimd" consimd-kernels eigen3)
  consimd_install(solvers "Solvers for 3D registration from feature correspondences" ${solvers_requirements})
  consimd_install(features "From scans to correspondences: voxels, normals, FPFH, matches" ${features_requirements})
  consimd_install(synth "Synthetic registration problems with ground truth" consimd-poses)
endif()
if(TARGET consimd_studies)
  list(APPEND CONSIMD_COMPONENTS studies)
  consimd_install(studies "Noise studies and comparisons of solvers for 3D registration" ${studies_requirements})
endif()

if(TARGET consimd_cli)
  install(TARGETS consimd_cli)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/studies/src/figures/ DESTINATION ${CMAKE_INSTALL_DATADIR}/consimd
    FILES_MATCHING PATTERN "*.py")
endif()

configure_package_config_file(
  ${PROJECT_SOURCE_DIR}/cmake/consimd-config.cmake.in ${PROJECT_BINARY_DIR}/consimd-config.cmake
  INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/consimd-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/consimd-config.cmake ${PROJECT_BINARY_DIR}/consimd-config-version.cmake
  DESTINATION ${package_dir})
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
