# pkg-config files for builds without CMake. They find their folders from their own place, so an installation may be moved.
#   dynfilter            the headers       dynfilter-compiled   the headers with their slow parts compiled
#   dynfilter-facade     the shared library for C++11 and C
set(pkgconfig_destination ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
set(opencv_package opencv${OpenCV_VERSION_MAJOR})
foreach(place INCLUDEDIR LIBDIR)
  file(RELATIVE_PATH ${place}_from_pkgconfig "${CMAKE_INSTALL_PREFIX}/${pkgconfig_destination}" "${CMAKE_INSTALL_FULL_${place}}")
  string(REGEX REPLACE "/$" "" ${place}_from_pkgconfig "${${place}_from_pkgconfig}")
endforeach()
file(RELATIVE_PATH data_from_pkgconfig "${CMAKE_INSTALL_PREFIX}/${pkgconfig_destination}"
     "${CMAKE_INSTALL_PREFIX}/${DYNFILTER_DATA_DESTINATION}")

# dynfilter_pkgconfig(NAME DESCRIPTION REQUIRES LIBS CFLAGS)
function(dynfilter_pkgconfig name description requires libs cflags)
  set(file "${PROJECT_BINARY_DIR}/${name}.pc")
  configure_file("${PROJECT_SOURCE_DIR}/cmake/pkgconfig.pc.in" "${file}" @ONLY)
  install(FILES "${file}" DESTINATION ${pkgconfig_destination} COMPONENT development)
endfunction()

dynfilter_pkgconfig(dynfilter "${PROJECT_DESCRIPTION}" "eigen3 ${opencv_package}" "-ldl -pthread" "-pthread")
if(TARGET dynfilter_compiled)
  dynfilter_pkgconfig(dynfilter-compiled "${PROJECT_DESCRIPTION} (slow parts compiled)"
    "dynfilter = ${PROJECT_VERSION}" "-L\${libdir} -ldynfilter_compiled" "-DDYNFILTER_COMPILED")
endif()
if(TARGET dynfilter_facade)
  dynfilter_pkgconfig(dynfilter-facade "${PROJECT_DESCRIPTION} (C++11 and C)" "${opencv_package}"
    "-L\${libdir} -ldynfilter_facade" "")
endif()
