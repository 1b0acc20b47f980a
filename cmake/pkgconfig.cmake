# pkg-config files for builds without CMake. They find their folders from their own place, so an installation may be moved.
#   dynfilter          the default components     dynfilter-header-only   the headers with their bodies
#   dynfilter-facade   the shared library for C++11 and C
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

# Static libraries are linked in the order in which they call each other.
set(libraries "")
foreach(component IN LISTS DYNFILTER_DEFAULT_COMPONENTS)
  get_target_property(type dynfilter_${component} TYPE)
  if(type STREQUAL "STATIC_LIBRARY")
    string(PREPEND libraries "-ldynfilter_${component} ")
  endif()
endforeach()
set(mode "")
set(simd "")
if(DYNFILTER_HEADER_ONLY)
  set(mode " -DDYNFILTER_HEADER_ONLY")
endif()
if(NOT DYNFILTER_AVX2)
  set(simd " -DDYNFILTER_WITHOUT_AVX2")
endif()
set(hidden "")
if(DYNFILTER_HIDE_INLINE)
  set(hidden "-Wl,--version-script=\${libdir}/cmake/dynfilter/hidden_symbols.map ")
endif()
dynfilter_pkgconfig(dynfilter "${PROJECT_DESCRIPTION}" "eigen3 ${opencv_package}"
  "-L\${libdir} ${libraries}${hidden}-llz4 -ldl -pthread" "-pthread${mode}${simd}")
dynfilter_pkgconfig(dynfilter-header-only "${PROJECT_DESCRIPTION} (headers only)" "eigen3 ${opencv_package}"
  "${hidden}-llz4 -ldl -pthread" "-pthread -DDYNFILTER_HEADER_ONLY${simd}")
if(TARGET dynfilter_facade)
  dynfilter_pkgconfig(dynfilter-facade "${PROJECT_DESCRIPTION} (C++11 and C)" "${opencv_package}"
    "-L\${libdir} -ldynfilter_facade" "")
endif()
