# dynfilter_add_plugin(NAME SOURCE...): a loadable module that `dynfilter run --plugin NAME.so` accepts. Nothing but
# the two functions of DYNFILTER_EXPORT_FILTERS is visible, so that two plugins with a class of the same name never
# see each other's code or tables (GNU "unique" symbols would be shared even by RTLD_LOCAL modules).
function(dynfilter_add_plugin name)
  add_library(${name} MODULE ${ARGN})
  if(TARGET dynfilter::plugin)
    target_link_libraries(${name} PRIVATE dynfilter::plugin)
  else()
    target_link_libraries(${name} PRIVATE dynfilter::header_only)
  endif()
  set_target_properties(${name} PROPERTIES
    PREFIX "" SUFFIX ".so" CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
  if(UNIX AND NOT APPLE)  # of the static libraries, only what is called, and hidden too
    target_link_options(${name} PRIVATE -Wl,--gc-sections -Wl,--exclude-libs,ALL)
  endif()
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(${name} PRIVATE -fno-gnu-unique)
  endif()
endfunction()
