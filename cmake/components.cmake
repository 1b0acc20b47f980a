# One interface target per component: dynfilter::core, dynfilter::io, ... A component is a folder of headers under
# include/dynfilter, and links what its headers include. The order is the direction in which data flows.
#   dynfilter_component(NAME [COMPONENTS others...] [OPENCV modules...] [LINK targets...])
# Eigen and opencv_core come with core. What is found here is found again by dynfilterConfig.cmake, and there only for
# the components that were asked for.
set(DYNFILTER_COMPONENTS "")

# Warnings in our headers do not reach the log of a project that takes the source in.
set(DYNFILTER_SYSTEM SYSTEM)
if(top_level)
  set(DYNFILTER_SYSTEM "")
endif()

function(dynfilter_component name)
  cmake_parse_arguments(arg "" "" "COMPONENTS;OPENCV;LINK" ${ARGN})
  add_library(dynfilter_${name} INTERFACE)
  add_library(dynfilter::${name} ALIAS dynfilter_${name})
  set_target_properties(dynfilter_${name} PROPERTIES EXPORT_NAME ${name})
  target_compile_features(dynfilter_${name} INTERFACE cxx_std_17)
  target_include_directories(dynfilter_${name} ${DYNFILTER_SYSTEM} INTERFACE
    "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>" "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>")
  list(TRANSFORM arg_COMPONENTS PREPEND dynfilter_ OUTPUT_VARIABLE others)
  list(TRANSFORM arg_OPENCV PREPEND opencv_ OUTPUT_VARIABLE modules)
  target_link_libraries(dynfilter_${name} INTERFACE ${others} ${modules} ${arg_LINK})
  set(DYNFILTER_COMPONENTS ${DYNFILTER_COMPONENTS} ${name} PARENT_SCOPE)
  set(DYNFILTER_${name}_COMPONENTS ${arg_COMPONENTS} PARENT_SCOPE)
  set(DYNFILTER_${name}_OPENCV ${arg_OPENCV} PARENT_SCOPE)
endfunction()

# Both accept only requests for their own major version, and more than one is supported: the oldest is checked here.
set(DYNFILTER_Eigen3_MINIMUM 3.3)
set(DYNFILTER_OpenCV_MINIMUM 4.2)
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(OpenCV REQUIRED COMPONENTS core imgproc video imgcodecs)
foreach(package Eigen3 OpenCV)
  if(${package}_VERSION VERSION_LESS DYNFILTER_${package}_MINIMUM)
    message(FATAL_ERROR "dynfilter: ${package} ${${package}_VERSION} in ${${package}_DIR} is older than "
      "${DYNFILTER_${package}_MINIMUM}. Choose another one by -D${package}_DIR=<folder of ${package}Config.cmake>")
  endif()
endforeach()
find_package(Threads REQUIRED)
list(APPEND CMAKE_MODULE_PATH "${CMAKE_CURRENT_LIST_DIR}")
find_package(FLANN QUIET)
if(NOT FLANN_FOUND AND DYNFILTER_BUILD_TESTS)
  find_package(FLANN REQUIRED)
endif()

dynfilter_component(core OPENCV core LINK Eigen3::Eigen)
dynfilter_component(correspondence COMPONENTS core OPENCV imgproc video)
dynfilter_component(geometry COMPONENTS core)
# Only cluster/flann_neighbours.hpp needs FLANN, and no filter includes it: filters do without this component.
if(FLANN_FOUND)
  dynfilter_component(cluster COMPONENTS core LINK FLANN::FLANN)
endif()
dynfilter_component(context COMPONENTS correspondence geometry)
dynfilter_component(filters COMPONENTS context)
dynfilter_component(pipeline COMPONENTS filters)
# Pipelines that come with dynfilter are found by their names. Programs of a build tree find those of the source tree.
# Packaged programs must not name a folder of the machine that built them.
set(DYNFILTER_BUILD_DATA "${PROJECT_SOURCE_DIR}/examples")
if(DYNFILTER_DEBIAN)
  set(DYNFILTER_BUILD_DATA "${CMAKE_INSTALL_PREFIX}/${DYNFILTER_DATA_DESTINATION}")
endif()
target_compile_definitions(dynfilter_pipeline INTERFACE
  "$<BUILD_INTERFACE:DYNFILTER_PIPELINES_DIR=\"${DYNFILTER_BUILD_DATA}/pipelines\">"
  "$<INSTALL_INTERFACE:DYNFILTER_PIPELINES_DIR=\"$<INSTALL_PREFIX>/${DYNFILTER_DATA_DESTINATION}/pipelines\">")
dynfilter_component(keyframe COMPONENTS core)
dynfilter_component(plugin COMPONENTS filters LINK ${CMAKE_DL_LIBS})
dynfilter_component(io COMPONENTS core OPENCV imgcodecs imgproc)
set(corner_modules imgproc)
if(OpenCV_VERSION VERSION_GREATER_EQUAL 5)  # where goodFeaturesToTrack has moved to
  find_package(OpenCV QUIET OPTIONAL_COMPONENTS features)
  if(TARGET opencv_features)
    list(APPEND corner_modules features)
  endif()
endif()
dynfilter_component(semantic COMPONENTS pipeline io OPENCV imgproc LINK Threads::Threads)
dynfilter_component(adapters COMPONENTS semantic plugin OPENCV ${corner_modules})
# Only semantic/dnn_network.hpp and what includes it need OpenCV's dnn module: found only where it is asked for.
find_package(OpenCV QUIET OPTIONAL_COMPONENTS dnn)
if(TARGET opencv_dnn)
  dynfilter_component(dnn COMPONENTS semantic OPENCV dnn)
  target_compile_definitions(dynfilter_dnn INTERFACE DYNFILTER_HAS_DNN)  # then hosts' settings may name networks
endif()
dynfilter_component(mapping COMPONENTS geometry io OPENCV imgproc LINK Threads::Threads)
dynfilter_component(eval COMPONENTS io)
dynfilter_component(synth COMPONENTS context io OPENCV imgproc)
