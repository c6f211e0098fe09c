# What makes a fault hard to exploit, at no cost that a registration shows (docs/performance.md): a guard on stacks with arrays, checked copies,
# and relocations that are read-only before main. Not in debug builds: checked copies need optimisation, and sanitizers replace them.
option(CONSIMD_HARDEN "Build with stack protector, _FORTIFY_SOURCE and full RELRO" ON)
set(hardening_compile_options -fstack-protector-strong -U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=2)
set(hardening_link_options LINKER:-z,relro LINKER:-z,now)
if(NOT CONSIMD_HARDEN OR NOT CMAKE_SYSTEM_NAME STREQUAL Linux)
  set(hardening_compile_options "")
  set(hardening_link_options "")
endif()

if(WIN32 AND BUILD_SHARED_LIBS)
  message(FATAL_ERROR "On Windows the libraries are static: CONSIMD_EXPORT says nothing there, so that a DLL would export nothing.")
endif()

# What every target of the project is built with. Only the language standard reaches its users.
function(consimd_configure target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR})  # text/
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ON)
  target_compile_options(${target} PRIVATE
    -ffp-contract=off  # contracted multiply-adds round differently from one instruction set to another
    -Wall -Wextra -Wshadow -Wconversion -Wsign-conversion
    $<$<BOOL:${CONSIMD_WERROR}>:-Werror>
    "$<$<NOT:$<CONFIG:Debug>>:${hardening_compile_options}>")
  target_link_options(${target} PRIVATE ${hardening_link_options})
endfunction()

# consimd_find_beside(TARGET ENTRY...): where an installed binary looks for the project's shared libraries, in the build tree too. Where
# the two differ CMake ends the entries of the build tree with empty ones, to edit them in place, and an empty entry is the current
# folder. Dependencies outside the system's folders are found where they were at build time.
function(consimd_find_beside target)
  set_target_properties(${target} PROPERTIES
    BUILD_WITH_INSTALL_RPATH ON INSTALL_RPATH "${ARGN}" INSTALL_RPATH_USE_LINK_PATH ON)
endfunction()

# consimd_precompile(TARGET [<HEADER>...]): what most sources of a target include, read once. Eigen and oneTBB are half of the time
# that a source takes to compile. Clang-tidy reads every source without it, so that no include can be forgotten.
function(consimd_precompile target)
  target_precompile_headers(${target} PRIVATE
    <Eigen/Geometry> <algorithm> <chrono> <cmath> <functional> <optional> <span> <sstream> <string> <variant> <vector> ${ARGN})
endfunction()

# Whether static libraries can be kept apart from the program's copies of inline functions; see isolate_archive.cmake.
include(CheckLinkerFlag)
check_linker_flag(CXX "-r;-nostdlib;-Wl,--force-group-allocation" CONSIMD_LINKER_CAN_ISOLATE)
if(NOT CONSIMD_LINKER_CAN_ISOLATE OR CMAKE_INTERPROCEDURAL_OPTIMIZATION OR CMAKE_CXX_FLAGS MATCHES "-flto")
  set(CONSIMD_ISOLATED OFF)
  if(NOT BUILD_SHARED_LIBS)
    message(WARNING "Without GNU ld, or with link-time optimisation, static libraries share Eigen's inline functions with "
      "the program: compile both with the same -m flags, or set BUILD_SHARED_LIBS.")
  endif()
else()
  set(CONSIMD_ISOLATED ON)
endif()

# consimd_configure_library(TARGET FOLDER): an installed library, public headers in FOLDER/include. Its results and its interface
# do not depend on the flags of the program that uses it, nor on those that its builder adds (-march=native).
function(consimd_configure_library target folder)
  consimd_configure(${target})
  add_library(consimd::${folder} ALIAS ${target})
  target_include_directories(${target} PUBLIC
    $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  set_target_properties(${target} PROPERTIES
    EXPORT_NAME ${folder}
    CXX_VISIBILITY_PRESET hidden
    DEFINE_SYMBOL ""
    VERSION ${PROJECT_VERSION}
    SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
    LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib)
  consimd_find_beside(${target} "$ORIGIN")

  get_target_property(type ${target} TYPE)
  if(type STREQUAL SHARED_LIBRARY)
    set(map ${PROJECT_SOURCE_DIR}/cmake/exported_symbols.map)
    target_link_options(${target} PRIVATE -Wl,--version-script=${map} -Wl,-Bsymbolic-functions)
    set_target_properties(${target} PROPERTIES LINK_DEPENDS ${map})
  elseif(CONSIMD_ISOLATED)
    add_custom_command(TARGET ${target} POST_BUILD VERBATIM
      COMMAND ${CMAKE_COMMAND} -DARCHIVE=$<TARGET_FILE:${target}> -DCOMPILER=${CMAKE_CXX_COMPILER} -DNM=${CMAKE_NM}
        -DOBJCOPY=${CMAKE_OBJCOPY} -DAR=${CMAKE_AR} -P ${PROJECT_SOURCE_DIR}/cmake/isolate_archive.cmake)
  endif()
  # g++ 12 vectorises alternating sums of products with FMA even where contraction is off.
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64|amd64")
    target_compile_options(${target} PRIVATE -mno-fma -mno-avx512f)
  endif()
  # What g++ marks as unique in the process cannot be kept inside a library.
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-fno-gnu-unique>)
  # Eigen's vector code adds in an order, and with FMA rounds in a way, that depends on the instruction set. Where the copies of its
  # functions could be shared with a program that does vectorise, both must agree on the alignment of its types instead.
  if(type STREQUAL SHARED_LIBRARY OR CONSIMD_ISOLATED)
    target_compile_definitions(${target} PRIVATE EIGEN_DONT_VECTORIZE)
  endif()
endfunction()
