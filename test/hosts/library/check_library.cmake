# What a host's shared library shows and loads because of dynfilter: nothing of ours is visible, no reader of image files comes
# along, no folder of this machine is named.
#   cmake -DNM=nm -DLIBRARY=libhost.so -DFOLDERS=a;b -P check_library.cmake
execute_process(COMMAND "${NM}" -D --defined-only "${LIBRARY}" OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "[^\n]*9dynfilter[^\n]*" ours "${symbols}")
list(FILTER ours EXCLUDE REGEX " T _ZN9ORB_SLAM2")  # the host's own, which take our types
if(ours)
  message(SEND_ERROR "visible from outside: ${ours}")
endif()
if(NOT symbols MATCHES "_ZN9ORB_SLAM28Tracking9stages_ofERKN9dynfilter7OrbSlamE")
  message(SEND_ERROR "the host's own function is hidden, too")
endif()

file(GET_RUNTIME_DEPENDENCIES LIBRARIES "${LIBRARY}" RESOLVED_DEPENDENCIES_VAR loaded)
list(FILTER loaded INCLUDE REGEX "imgcodecs|videoio|highgui|gdal|libpng|libjpeg")
if(loaded)
  message(SEND_ERROR "loaded, but no host needs it: ${loaded}")
endif()

foreach(folder IN LISTS FOLDERS)
  file(STRINGS "${LIBRARY}" found REGEX "${folder}")
  if(found)
    message(SEND_ERROR "names a folder of this machine: ${found}")
  endif()
endforeach()

set(most_bytes 2300000)  # 1,990,000 with GCC 12 and -O3, 2,290,000 when all was visible
file(SIZE "${LIBRARY}" bytes)
if(bytes GREATER most_bytes)
  message(SEND_ERROR "${bytes} bytes, expected at most ${most_bytes}")
endif()
