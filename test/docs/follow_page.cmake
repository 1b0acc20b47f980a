# Installs the libraries of BUILD and follows PAGE with them. See write_a_filter.sh.
foreach(component development library)
  execute_process(COMMAND ${CMAKE_COMMAND} --install "${BUILD}" --prefix "${WORK}/prefix" --component ${component}
                  OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
endforeach()
set(ENV{CXX} "${COMPILER}")
execute_process(COMMAND bash "${CMAKE_CURRENT_LIST_DIR}/write_a_filter.sh" "${PAGE}" "${WORK}/prefix" "${COMMAND}" "${WORK}/run"
                COMMAND_ERROR_IS_FATAL ANY)
