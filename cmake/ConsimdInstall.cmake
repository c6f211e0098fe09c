# The installed tree: libraries, public headers, the command, and a config package so that find_package(consimd) works.
include(CMakePackageConfigHelpers)

set(libraries kernels)
if(NOT CONSIMD_KERNELS_ONLY)
  list(APPEND libraries solvers synth)
endif()

foreach(library IN LISTS libraries)
  set_target_properties(consimd_${library} PROPERTIES
    EXPORT_NAME ${library}
    VERSION ${PROJECT_VERSION}
    SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
    INSTALL_RPATH "$ORIGIN")
  install(TARGETS consimd_${library} EXPORT consimd)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${library}/include/ TYPE INCLUDE FILES_MATCHING PATTERN "*.hpp")
endforeach()

if(TARGET consimd_cli)
  file(RELATIVE_PATH bin_to_lib ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
  set_target_properties(consimd_cli PROPERTIES INSTALL_RPATH "$ORIGIN/${bin_to_lib}")
  install(TARGETS consimd_cli)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/bench/study/ DESTINATION ${CMAKE_INSTALL_DATADIR}/consimd
    FILES_MATCHING PATTERN "*.py")
endif()

# A static consimd::solvers leaves linking oneTBB to its user.
get_target_property(library_type consimd_kernels TYPE)
if(library_type STREQUAL STATIC_LIBRARY AND NOT CONSIMD_KERNELS_ONLY)
  set(CONSIMD_USER_LINKS_TBB ON)
else()
  set(CONSIMD_USER_LINKS_TBB OFF)
endif()

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/consimd)
configure_package_config_file(
  ${PROJECT_SOURCE_DIR}/cmake/consimd-config.cmake.in ${PROJECT_BINARY_DIR}/consimd-config.cmake
  INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/consimd-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/consimd-config.cmake ${PROJECT_BINARY_DIR}/consimd-config-version.cmake
  DESTINATION ${package_dir})
install(EXPORT consimd NAMESPACE consimd:: FILE consimd-targets.cmake DESTINATION ${package_dir})
