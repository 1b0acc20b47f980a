# One target per component: dynfilter::core, dynfilter::filters, ... A component is a folder of headers under include/dynfilter,
# and links what its headers include. The order is the direction in which data flows.
#   dynfilter_component(NAME [COMPONENTS others...] [OPENCV modules...] [LINK targets...]
#                       [HEADERS names...] [WITHOUT names...] [PARTS n])
# A component with bodies (detail/NAME-inl.hpp) is a static library of one source, which includes all of them, or of PARTS
# sources. With DYNFILTER_HEADER_ONLY, and without bodies, it is an interface target.
# HEADERS: these instead of the folder of the component's name. WITHOUT: all of the folder but these.
# Eigen and opencv_core come with core. What is found here is found again by dynfilterConfig.cmake, and there only for
# the components that were asked for.
set(DYNFILTER_COMPONENTS "")

# Warnings in our headers do not reach the log of a project that takes the source in.
set(DYNFILTER_SYSTEM SYSTEM)
if(top_level)
  set(DYNFILTER_SYSTEM "")
endif()

# dynfilter_bodies(OUTPUT NAME HEADERS WITHOUT): the bodies of a component, relative to include/.
function(dynfilter_bodies output name headers without)
  set(root "${PROJECT_SOURCE_DIR}/include")
  file(GLOB_RECURSE bodies CONFIGURE_DEPENDS RELATIVE "${root}" "${root}/dynfilter/${name}/*-inl.hpp")
  foreach(list headers without)
    list(TRANSFORM ${list} REPLACE "([^/]+)$" "detail/\\1-inl.hpp")
    list(TRANSFORM ${list} PREPEND dynfilter/)
  endforeach()
  if(headers)
    set(bodies "")
    foreach(body IN LISTS headers)
      if(EXISTS "${root}/${body}")
        list(APPEND bodies ${body})
      endif()
    endforeach()
  elseif(without)
    list(REMOVE_ITEM bodies ${without})
  endif()
  list(SORT bodies)
  set(${output} "${bodies}" PARENT_SCOPE)
endfunction()

# Sources that include the bodies, in the build tree.
function(dynfilter_library_sources output name parts)
  list(LENGTH ARGN count)
  set(part 0)
  foreach(body IN LISTS ARGN)
    string(APPEND text_${part} "#include <${body}>\n")
    math(EXPR part "(${part} + 1) % ${parts}")
  endforeach()
  set(sources "")
  math(EXPR last "${parts} - 1")
  foreach(part RANGE ${last})
    set(source "${PROJECT_BINARY_DIR}/library/${name}_${part}.cpp")
    file(GENERATE OUTPUT "${source}" CONTENT "#define DYNFILTER_LIBRARY\n${text_${part}}")
    list(APPEND sources "${source}")
  endforeach()
  set(${output} "${sources}" PARENT_SCOPE)
endfunction()

function(dynfilter_component name)
  cmake_parse_arguments(arg "" "PARTS" "COMPONENTS;OPENCV;LINK;HEADERS;WITHOUT" ${ARGN})
  dynfilter_bodies(bodies ${name} "${arg_HEADERS}" "${arg_WITHOUT}")
  set(scope INTERFACE)
  if(bodies AND NOT DYNFILTER_HEADER_ONLY)
    set(scope PUBLIC)
    if(NOT arg_PARTS)
      set(arg_PARTS 1)
    endif()
    dynfilter_library_sources(sources ${name} ${arg_PARTS} ${bodies})
    add_library(dynfilter_${name} STATIC ${sources})
    set_target_properties(dynfilter_${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)  # plugins link it
    # A project that takes the source in compiles only the components that it links.
    if(NOT top_level AND NOT DYNFILTER_INSTALL)
      set_target_properties(dynfilter_${name} PROPERTIES EXCLUDE_FROM_ALL ON)
    endif()
    target_link_libraries(dynfilter_${name} PRIVATE $<BUILD_INTERFACE:dynfilter_library_options>)
  else()
    add_library(dynfilter_${name} INTERFACE)
  endif()
  if(DYNFILTER_HEADER_ONLY)
    target_compile_definitions(dynfilter_${name} INTERFACE DYNFILTER_HEADER_ONLY)
  endif()
  add_library(dynfilter::${name} ALIAS dynfilter_${name})
  set_target_properties(dynfilter_${name} PROPERTIES EXPORT_NAME ${name})
  target_compile_features(dynfilter_${name} ${scope} cxx_std_17)
  target_include_directories(dynfilter_${name} ${DYNFILTER_SYSTEM} ${scope}
    "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>" "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>")
  list(TRANSFORM arg_COMPONENTS PREPEND dynfilter_ OUTPUT_VARIABLE others)
  list(TRANSFORM arg_OPENCV PREPEND opencv_ OUTPUT_VARIABLE modules)
  target_link_libraries(dynfilter_${name} ${scope} ${others} ${modules} ${arg_LINK})
  set(DYNFILTER_COMPONENTS ${DYNFILTER_COMPONENTS} ${name} PARENT_SCOPE)
  set(DYNFILTER_${name}_COMPONENTS ${arg_COMPONENTS} PARENT_SCOPE)
  set(DYNFILTER_${name}_OPENCV ${arg_OPENCV} PARENT_SCOPE)
endfunction()

# Ordinary sources below plugins/FOLDER: a program that uses them links them.
#   dynfilter_source_library(NAME FOLDER SOURCES... COMPONENTS ... OPENCV ... LINK ...)
function(dynfilter_source_library name folder)
  cmake_parse_arguments(arg "" "" "SOURCES;COMPONENTS;OPENCV;LINK" ${ARGN})
  set(source_dir "${PROJECT_SOURCE_DIR}/plugins/${folder}")
  list(TRANSFORM arg_SOURCES REPLACE "(.+)" "${source_dir}/src/\\1.cpp")
  add_library(dynfilter_${name} STATIC ${arg_SOURCES})
  add_library(dynfilter::${name} ALIAS dynfilter_${name})
  set_target_properties(dynfilter_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON
    UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0)
  if(NOT top_level AND NOT DYNFILTER_INSTALL)
    set_target_properties(dynfilter_${name} PROPERTIES EXCLUDE_FROM_ALL ON)
  endif()
  target_compile_features(dynfilter_${name} PUBLIC cxx_std_17)
  target_include_directories(dynfilter_${name} ${DYNFILTER_SYSTEM} PUBLIC
    "$<BUILD_INTERFACE:${source_dir}/include>" "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>")
  list(TRANSFORM arg_COMPONENTS PREPEND dynfilter_ OUTPUT_VARIABLE others)
  list(TRANSFORM arg_OPENCV PREPEND opencv_ OUTPUT_VARIABLE modules)
  target_link_libraries(dynfilter_${name} PUBLIC ${others} ${modules} ${arg_LINK}
    PRIVATE $<BUILD_INTERFACE:dynfilter_library_options>)
  set(DYNFILTER_COMPONENTS ${DYNFILTER_COMPONENTS} ${name} PARENT_SCOPE)
  set(DYNFILTER_${name}_COMPONENTS ${arg_COMPONENTS} PARENT_SCOPE)
  set(DYNFILTER_${name}_OPENCV ${arg_OPENCV} PARENT_SCOPE)
endfunction()

# Both accept only requests for their own major version, and more than one is supported: the oldest is checked here.
set(DYNFILTER_Eigen3_MINIMUM 3.3)
set(DYNFILTER_OpenCV_MINIMUM 4.2)
set(DYNFILTER_OpenCV_TRIED 4.6)
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(OpenCV REQUIRED COMPONENTS core imgproc video)
foreach(package Eigen3 OpenCV)
  if(${package}_VERSION VERSION_LESS DYNFILTER_${package}_MINIMUM)
    message(FATAL_ERROR "dynfilter: ${package} ${${package}_VERSION} in ${${package}_DIR} is older than "
      "${DYNFILTER_${package}_MINIMUM}. Choose another one by -D${package}_DIR=<folder of ${package}Config.cmake>")
  endif()
endforeach()
if(NOT OpenCV_VERSION VERSION_GREATER_EQUAL DYNFILTER_OpenCV_TRIED OR OpenCV_VERSION VERSION_GREATER_EQUAL 5)
  message(STATUS "dynfilter: OpenCV ${OpenCV_VERSION} should do, but only ${DYNFILTER_OpenCV_TRIED} was compiled and tested")
endif()
find_package(Threads REQUIRED)
list(APPEND CMAKE_MODULE_PATH "${CMAKE_CURRENT_LIST_DIR}")
find_package(FLANN REQUIRED)

dynfilter_component(core OPENCV core LINK Eigen3::Eigen)
if(NOT DYNFILTER_AVX2)
  set(scope INTERFACE)
  get_target_property(type dynfilter_core TYPE)
  if(type STREQUAL "STATIC_LIBRARY")
    set(scope PUBLIC)
  endif()
  target_compile_definitions(dynfilter_core ${scope} DYNFILTER_WITHOUT_AVX2)
endif()
dynfilter_component(config COMPONENTS core)
dynfilter_component(correspondence COMPONENTS config OPENCV video)
dynfilter_component(geometry COMPONENTS core)
dynfilter_component(cluster COMPONENTS core)
dynfilter_component(late COMPONENTS correspondence geometry)
dynfilter_component(evidence COMPONENTS late cluster)
dynfilter_component(motion COMPONENTS geometry cluster)
# Only the rejector dbscan needs FLANN.
dynfilter_component(filters COMPONENTS evidence motion LINK FLANN::FLANN)
dynfilter_component(pipeline COMPONENTS filters)
# Pipelines that come with dynfilter are found by their names. Programs of a build tree find those of the source tree.
# Packaged programs must not name a folder of the machine that built them.
set(DYNFILTER_BUILD_DATA "${PROJECT_SOURCE_DIR}/examples")
if(DYNFILTER_DEBIAN)
  set(DYNFILTER_BUILD_DATA "${CMAKE_INSTALL_PREFIX}/${DYNFILTER_DATA_DESTINATION}")
endif()
set(DYNFILTER_PIPELINES_DEFINITION
  "$<BUILD_INTERFACE:DYNFILTER_PIPELINES_DIR=\"${DYNFILTER_BUILD_DATA}/pipelines\">"
  "$<INSTALL_INTERFACE:DYNFILTER_PIPELINES_DIR=\"$<INSTALL_PREFIX>/${DYNFILTER_DATA_DESTINATION}/pipelines\">")
target_compile_definitions(dynfilter_pipeline INTERFACE ${DYNFILTER_PIPELINES_DEFINITION})
dynfilter_component(keyframe COMPONENTS config)
dynfilter_component(plugin COMPONENTS evidence LINK ${CMAKE_DL_LIBS})
set(corner_modules imgproc)
if(OpenCV_VERSION VERSION_GREATER_EQUAL 5)  # where goodFeaturesToTrack has moved to
  find_package(OpenCV QUIET OPTIONAL_COMPONENTS features)
  if(TARGET opencv_features)
    list(APPEND corner_modules features)
  endif()
endif()
dynfilter_component(semantic COMPONENTS config cluster OPENCV imgproc LINK Threads::Threads)
# The flight recorder, with the lz4 that FLANN::FLANN brings.
dynfilter_source_library(recorder recorder COMPONENTS pipeline LINK FLANN::FLANN Threads::Threads
  SOURCES flight_recorder image_writer record_file recording_reader verdict_difference)
target_compile_definitions(dynfilter_recorder PUBLIC DYNFILTER_HAS_RECORDER)  # for headers alone
dynfilter_component(hosts COMPONENTS pipeline semantic plugin OPENCV ${corner_modules} LINK dynfilter_recorder)
list(APPEND DYNFILTER_hosts_COMPONENTS recorder)
dynfilter_component(mapping COMPONENTS config cluster geometry OPENCV imgproc LINK Threads::Threads)
dynfilter_component(testing COMPONENTS evidence)

include(cmake/detectors.cmake)

# What find_package(dynfilter) makes without COMPONENTS, and dynfilter::dynfilter links: all that needs nothing optional.
set(DYNFILTER_DEFAULT_COMPONENTS ${DYNFILTER_COMPONENTS})
list(REMOVE_ITEM DYNFILTER_DEFAULT_COMPONENTS detectors dnn)
add_library(dynfilter_dynfilter INTERFACE)
add_library(dynfilter::dynfilter ALIAS dynfilter_dynfilter)
set_target_properties(dynfilter_dynfilter PROPERTIES EXPORT_NAME dynfilter)
list(TRANSFORM DYNFILTER_DEFAULT_COMPONENTS PREPEND dynfilter_ OUTPUT_VARIABLE default_targets)
target_link_libraries(dynfilter_dynfilter INTERFACE ${default_targets})
set(DYNFILTER_dynfilter_COMPONENTS ${DYNFILTER_DEFAULT_COMPONENTS})

# The same headers with their bodies, instead of the libraries. Never both in one program.
add_library(dynfilter_header_only INTERFACE)
add_library(dynfilter::header_only ALIAS dynfilter_header_only)
set_target_properties(dynfilter_header_only PROPERTIES EXPORT_NAME header_only)
target_compile_features(dynfilter_header_only INTERFACE cxx_std_17)
target_compile_definitions(dynfilter_header_only INTERFACE DYNFILTER_HEADER_ONLY ${DYNFILTER_PIPELINES_DEFINITION})
if(NOT DYNFILTER_AVX2)
  target_compile_definitions(dynfilter_header_only INTERFACE DYNFILTER_WITHOUT_AVX2)
endif()
target_include_directories(dynfilter_header_only ${DYNFILTER_SYSTEM} INTERFACE
  "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>" "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>")
set(DYNFILTER_header_only_COMPONENTS "")
set(DYNFILTER_header_only_OPENCV core imgproc video ${corner_modules})
list(REMOVE_DUPLICATES DYNFILTER_header_only_OPENCV)
list(TRANSFORM DYNFILTER_header_only_OPENCV PREPEND opencv_ OUTPUT_VARIABLE modules)
target_link_libraries(dynfilter_header_only INTERFACE Eigen3::Eigen ${modules} FLANN::FLANN Threads::Threads
  ${CMAKE_DL_LIBS})
list(APPEND DYNFILTER_COMPONENTS header_only dynfilter)
