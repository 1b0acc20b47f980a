# The installed command finds the module that reads videos: it says what it thinks of one.
#   cmake -DBUILD=build -DWORK=folder -P check_install.cmake
file(REMOVE_RECURSE "${WORK}")
execute_process(COMMAND "${CMAKE_COMMAND}" --install "${BUILD}" --component runtime --prefix "${WORK}" OUTPUT_QUIET
                COMMAND_ERROR_IS_FATAL ANY)
file(WRITE "${WORK}/clip.mp4" "no video")
execute_process(COMMAND "${WORK}/bin/dynfilter" run "${WORK}/clip.mp4" RESULT_VARIABLE code ERROR_VARIABLE said OUTPUT_QUIET)
if(NOT code EQUAL 2 OR NOT said MATCHES "is no video that OpenCV can read")
  message(FATAL_ERROR "exit code ${code}, and: ${said}")
endif()
