option(CONSIMD_CHECK_VERSIONS "Refuse dependencies of versions outside the bounds of cmake/dependencies.txt" ON)

# consimd_check_version(NAME VERSION): what dependencies.txt says of NAME. A package that does not tell its version is taken as it is.
function(consimd_check_version name version)
  file(STRINGS ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/dependencies.txt row REGEX "^${name} ")
  if(NOT row MATCHES "^[^ ]+ +[^ ]+ +([^ ]+) +([^ ]+)")
    message(FATAL_ERROR "cmake/dependencies.txt has no bounds for ${name}")
  endif()
  set(at_least ${CMAKE_MATCH_1})
  set(below ${CMAKE_MATCH_2})
  if(CONSIMD_CHECK_VERSIONS AND NOT version STREQUAL "" AND
     (version VERSION_LESS at_least OR version VERSION_GREATER_EQUAL below))
    message(FATAL_ERROR "${name} ${version} was found, and a version from ${at_least} on and below ${below} is needed. "
      "-DCONSIMD_CHECK_VERSIONS=OFF takes it all the same.")
  endif()
endfunction()

# consimd_find(NAME [ARGUMENT...]): find_package of what the build cannot do without. The bounds are not in the call, since many
# packages refuse a range that spans major versions.
macro(consimd_find name)
  find_package(${name} REQUIRED ${ARGN})
  if("${${name}_VERSION}" STREQUAL "")
    set(${name}_VERSION "${${name}_VERSION_STRING}")  # as FindZLIB calls it before CMake 3.26
  endif()
  consimd_check_version(${name} "${${name}_VERSION}")
endmacro()
