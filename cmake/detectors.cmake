# Beside the toolkit: masks of every pixel (dynfilter::dense), providers of boxes and masks from files and separate programs
# (dynfilter::detectors), and from networks of OpenCV (dynfilter::dnn).

dynfilter_source_library(dense dense COMPONENTS cluster hosts OPENCV imgproc SOURCES dense_mask)

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
dynfilter_source_library(detectors detectors COMPONENTS semantic OPENCV imgproc LINK PNG::PNG JPEG::JPEG
  SOURCES bmp_image child_process class_list detections exif file_provider image_encoder image_file jpeg_image message_stream png_image pnm_image
    process_protocol process_provider)
find_package(OpenCV QUIET OPTIONAL_COMPONENTS dnn)
if(TARGET opencv_dnn)
  dynfilter_source_library(dnn detectors COMPONENTS detectors OPENCV dnn
    SOURCES decode_boxes decode_masks dnn_network dnn_provider input_fit network_boxes network_files network_input)
  target_compile_definitions(dynfilter_dnn INTERFACE DYNFILTER_HAS_DNN)  # then hosts' settings may name networks
endif()
