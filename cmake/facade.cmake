# The shared library dynfilter::facade: pipelines behind a C++11 and a plain C interface, for programs that cannot use the
# headers. Its two sources, in the build tree, include the functions of facade/detail/.
foreach(part facade_library c_library)
  file(GENERATE OUTPUT "${PROJECT_BINARY_DIR}/library/${part}.cpp" CONTENT "#include <dynfilter/facade/detail/${part}.hpp>\n")
  list(APPEND facade_sources "${PROJECT_BINARY_DIR}/library/${part}.cpp")
endforeach()
add_library(dynfilter_facade SHARED ${facade_sources})
add_library(dynfilter::facade ALIAS dynfilter_facade)
target_include_directories(dynfilter_facade ${DYNFILTER_SYSTEM} PUBLIC
  "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>" "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>")
target_compile_features(dynfilter_facade PUBLIC cxx_std_11 PRIVATE cxx_std_17)
# Header-only, it is a test of this mode: a host may do so.
set(facade_from dynfilter_pipeline dynfilter_recorder)
if(DYNFILTER_FACADE_HEADER_ONLY)
  set(facade_from dynfilter_header_only opencv_imgproc opencv_video)
endif()
target_link_libraries(dynfilter_facade PUBLIC opencv_core PRIVATE ${facade_from} dynfilter_compile_options
  ${CMAKE_DL_LIBS})
# Presets are found from the place of the installed library.
file(RELATIVE_PATH data_from_lib "${CMAKE_INSTALL_FULL_LIBDIR}" "${CMAKE_INSTALL_FULL_DATADIR}/dynfilter")
target_compile_definitions(dynfilter_facade PRIVATE DYNFILTER_DATA_FROM_LIB="${data_from_lib}")
# Nothing but the interface is seen from outside, so that a host may use the headers, or another Eigen, beside it.
target_link_options(dynfilter_facade PRIVATE -Wl,--exclude-libs,ALL)  # the components are static libraries
set_target_properties(dynfilter_facade PROPERTIES
  EXPORT_NAME facade VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
  CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)

list(APPEND DYNFILTER_COMPONENTS facade)
set(DYNFILTER_facade_COMPONENTS "")
set(DYNFILTER_facade_OPENCV core)
