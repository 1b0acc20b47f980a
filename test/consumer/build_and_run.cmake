# Configures, builds and runs PROJECT in an empty folder. See CMakeLists.txt beside this file.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  message("${output}")
  if(NOT result EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "failed (${result}): ${command}")
  endif()
endfunction()

# FetchContent comes second into the folder of add_subdirectory: only what was configured goes.
if(WAY STREQUAL "fetch_content")
  file(REMOVE_RECURSE "${WORK}/build/CMakeCache.txt" "${WORK}/build/CMakeFiles" "${WORK}/build/consumer")
else()
  file(REMOVE_RECURSE "${WORK}")
endif()
set(where -DDYNFILTER_SOURCE=${SOURCE})
# A user's own warnings must not be triggered by our headers.
set(flags "-O0 -Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wshadow -Werror")
if(WAY STREQUAL "package")
  foreach(component development library data)
    run(${CMAKE_COMMAND} --install "${BUILD}" --prefix "${WORK}/prefix" --component ${component})
  endforeach()
  set(where -DCMAKE_PREFIX_PATH=${WORK}/prefix)
endif()
run(${CMAKE_COMMAND} -S "${SOURCE}/${PROJECT}" -B "${WORK}/build" -G ${GENERATOR} -DDYNFILTER_FROM=${WAY} ${where}
    -DCMAKE_CXX_COMPILER=${COMPILER} "-DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}" -DCMAKE_BUILD_TYPE=None "-DCMAKE_CXX_FLAGS=${flags}")
run(${CMAKE_COMMAND} --build "${WORK}/build")
run(${CMAKE_COMMAND} -E chdir "${WORK}/build" ./${RUN})
