# What every target of the project is built with. Only the language standard reaches its users.
function(consimd_configure target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ON)
  target_compile_options(${target} PRIVATE
    -ffp-contract=off  # contracted multiply-adds round differently from one instruction set to another
    -Wall -Wextra -Wshadow -Wconversion -Wsign-conversion
    $<$<BOOL:${CONSIMD_WERROR}>:-Werror>)
endfunction()
