# cmake -DARCHIVE=... -DCOMPILER=... -DNM=... -DOBJCOPY=... -DAR=... -P isolate_archive.cmake
#
# Rewrites a static library as one object in which every inline function and template instance is local. Else the linker would
# merge them with the program's: an Eigen function that the program compiled with -march=native would run inside the library, with
# other rounding and with other ideas of how Eigen's types are aligned, which crashes.
set(object ${ARCHIVE}.isolated.o)
set(symbols ${ARCHIVE}.symbols)

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

run(${COMPILER} -r -nostdlib -Wl,--force-group-allocation -Wl,--whole-archive ${ARCHIVE} -o ${object})

# What stays global: definitions that exist once (T text, D, B and R data), not the weak ones (W, V, u).
execute_process(COMMAND ${NM} --extern-only --defined-only --format=posix ${object}
  OUTPUT_VARIABLE listing COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "[^\n]+ [TDBR] [^\n]*" strong "${listing}")
list(TRANSFORM strong REPLACE " .*" "")
list(JOIN strong "\n" strong)
file(WRITE ${symbols} "${strong}\n")
run(${OBJCOPY} --keep-global-symbols=${symbols} ${object})

file(REMOVE ${ARCHIVE})
run(${AR} qcs ${ARCHIVE} ${object})
file(REMOVE ${object} ${symbols})
