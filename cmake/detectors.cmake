# Beside the toolkit: masks of every pixel (dynfilter::dense), providers of boxes and masks from files and separate programs
# (dynfilter::detectors), and from networks of OpenCV (dynfilter::dnn). Ordinary sources: a program that uses them links them.

# dynfilter_beside(NAME FOLDER below plugins/ SOURCES... COMPONENTS ... OPENCV ... LINK ...)
function(dynfilter_beside name folder)
  cmake_parse_arguments(arg "" "" "SOURCES;COMPONENTS;OPENCV;LINK" ${ARGN})
  set(dir "${PROJECT_SOURCE_DIR}/plugins/${folder}")
  list(TRANSFORM arg_SOURCES REPLACE "(.+)" "${dir}/src/\\1.cpp")
  add_library(dynfilter_${name} STATIC ${arg_SOURCES})
  add_library(dynfilter::${name} ALIAS dynfilter_${name})
  set_target_properties(dynfilter_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON
    UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0)
  dynfilter_hide_library(${name})
  if(NOT top_level AND NOT DYNFILTER_INSTALL)
    set_target_properties(dynfilter_${name} PROPERTIES EXCLUDE_FROM_ALL ON)
  endif()
  target_compile_features(dynfilter_${name} PUBLIC cxx_std_17)
  target_include_directories(dynfilter_${name} ${DYNFILTER_SYSTEM} PUBLIC
    "$<BUILD_INTERFACE:${dir}/include>" "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>")
  list(TRANSFORM arg_COMPONENTS PREPEND dynfilter_ OUTPUT_VARIABLE others)
  list(TRANSFORM arg_OPENCV PREPEND opencv_ OUTPUT_VARIABLE modules)
  target_link_libraries(dynfilter_${name} PUBLIC ${others} ${modules} ${arg_LINK}
    PRIVATE $<BUILD_INTERFACE:dynfilter_library_options>)
  set(DYNFILTER_COMPONENTS ${DYNFILTER_COMPONENTS} ${name} PARENT_SCOPE)
  set(DYNFILTER_${name}_COMPONENTS ${arg_COMPONENTS} PARENT_SCOPE)
  set(DYNFILTER_${name}_OPENCV ${arg_OPENCV} PARENT_SCOPE)
endfunction()

dynfilter_beside(dense dense COMPONENTS cluster hosts OPENCV imgproc SOURCES dense_mask)

# Only these read image files, by libpng and libjpeg. Without them there are no detectors, and all else is built.
find_package(PNG QUIET)
find_package(JPEG QUIET)
if(NOT PNG_FOUND OR NOT JPEG_FOUND)
  if(DYNFILTER_BUILD_TESTS OR DYNFILTER_BUILD_EXAMPLES OR DYNFILTER_BUILD_PYTHON)
    find_package(PNG REQUIRED)
    find_package(JPEG REQUIRED)
  endif()
  message(STATUS "dynfilter: no libpng or no libjpeg: the components detectors and dnn are left out")
  return()
endif()
dynfilter_beside(detectors detectors COMPONENTS semantic OPENCV imgproc LINK PNG::PNG JPEG::JPEG
  SOURCES bmp_image child_process class_list detections exif file_provider image_file jpeg_image message_stream png_image pnm_image
    process_protocol process_provider)
find_package(OpenCV QUIET OPTIONAL_COMPONENTS dnn)
if(TARGET opencv_dnn)
  dynfilter_beside(dnn detectors COMPONENTS detectors OPENCV dnn
    SOURCES decode_boxes decode_masks dnn_network dnn_provider input_fit network_boxes network_files network_input)
  target_compile_definitions(dynfilter_dnn INTERFACE DYNFILTER_HAS_DNN)  # then hosts' settings may name networks
endif()
