# Headers, targets, find_package and pkg-config support, presets. The command and the modules install themselves.
# Components: development (headers, targets, static libraries), library (shared), data (presets), runtime (command, modules),
# documentation (the API reference, in Debian packages).
if(NOT DYNFILTER_INSTALL)
  return()
endif()
include(CMakePackageConfigHelpers)

install(DIRECTORY "${PROJECT_SOURCE_DIR}/include/dynfilter" "${PROJECT_SOURCE_DIR}/plugins/detectors/include/dynfilter"
        "${PROJECT_SOURCE_DIR}/plugins/dense/include/dynfilter"
        "${PROJECT_SOURCE_DIR}/plugins/recorder/include/dynfilter"
        "${PROJECT_SOURCE_DIR}/plugins/inertial/include/dynfilter"
        DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
        COMPONENT development FILES_MATCHING PATTERN "*.hpp" PATTERN "*.h"
        PATTERN "facade/detail" EXCLUDE)
install(DIRECTORY "${PROJECT_SOURCE_DIR}/examples/pipelines" "${PROJECT_SOURCE_DIR}/examples/detectors"
  "${PROJECT_SOURCE_DIR}/examples/benchmarks" DESTINATION ${DYNFILTER_DATA_DESTINATION}
        COMPONENT data OPTIONAL FILES_MATCHING PATTERN "*.yaml")
if(NOT DYNFILTER_DEBIAN)  # which has a file of its own for it
  install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" "${PROJECT_SOURCE_DIR}/THIRD_PARTY.md" DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT development)
endif()

if(DYNFILTER_DEBIAN AND TARGET reference)
  install(DIRECTORY "${PROJECT_BINARY_DIR}/reference/html" DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/dynfilter-doc COMPONENT documentation)
endif()

# One export per component, so that a user who asks for two components needs what those two need and no more.
foreach(component IN LISTS DYNFILTER_COMPONENTS)
  install(TARGETS dynfilter_${component} EXPORT dynfilter_${component}
          LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library NAMELINK_COMPONENT development
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
  install(EXPORT dynfilter_${component} NAMESPACE dynfilter:: DESTINATION ${DYNFILTER_CONFIG_DESTINATION}
          FILE dynfilter_${component}.cmake COMPONENT development)
  string(APPEND DYNFILTER_COMPONENT_TABLE
    "set(dynfilter_${component}_needs ${DYNFILTER_${component}_COMPONENTS})\n"
    "set(dynfilter_${component}_opencv ${DYNFILTER_${component}_OPENCV})\n")
endforeach()
configure_package_config_file(cmake/dynfilterConfig.cmake.in "${PROJECT_BINARY_DIR}/dynfilterConfig.cmake"
                              INSTALL_DESTINATION ${DYNFILTER_CONFIG_DESTINATION} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file("${PROJECT_BINARY_DIR}/dynfilterConfigVersion.cmake"
                                 COMPATIBILITY SameMinorVersion ARCH_INDEPENDENT)
install(FILES "${PROJECT_BINARY_DIR}/dynfilterConfig.cmake" "${PROJECT_BINARY_DIR}/dynfilterConfigVersion.cmake"
              "${PROJECT_SOURCE_DIR}/cmake/plugin.cmake" "${PROJECT_SOURCE_DIR}/cmake/FindFLANN.cmake"
              "${PROJECT_SOURCE_DIR}/cmake/hidden_symbols.map" "${PROJECT_SOURCE_DIR}/cmake/presets.cpp.in"
        DESTINATION ${DYNFILTER_CONFIG_DESTINATION} COMPONENT development)
include(cmake/pkgconfig.cmake)
