# Fails if the facade's library exports a function that is not of its interface: a host may use the headers beside it.
#   cmake -DNM=nm -DLIBRARY=libdynfilter_facade.so -P check_symbols.cmake
execute_process(COMMAND "${NM}" -D --defined-only "${LIBRARY}" OUTPUT_VARIABLE symbols RESULT_VARIABLE failed)
if(failed)
  message(FATAL_ERROR "${NM} cannot read ${LIBRARY}")
endif()
string(REGEX MATCHALL "[0-9a-f]+ T [^\n]+" functions "${symbols}")
set(ours "")
foreach(function IN LISTS functions)
  if(function MATCHES " T (dynfilter_|_ZNK?9dynfilter6facade)")
    list(APPEND ours "${function}")
  else()
    message(SEND_ERROR "exported, but not of the interface:${function}")
  endif()
endforeach()
list(LENGTH ours count)
if(count LESS 20)  # the C functions alone are 12
  message(FATAL_ERROR "only ${count} functions of the interface are exported")
endif()
