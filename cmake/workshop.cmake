# What surrounds the toolkit: readers and writers of recordings, evaluation, rendered sequences. Ordinary sources, linked by the
# command, the Python package and the tests. Not installed: nothing under include/ needs it. A library per folder, since the
# fuzz targets need the readers alone.
find_package(OpenCV QUIET OPTIONAL_COMPONENTS videoio highgui)  # without: no videos, no window
set(workshop_dir "${PROJECT_SOURCE_DIR}/examples/dynfilter")
function(dynfilter_workshop_folder name)
  file(GLOB sources CONFIGURE_DEPENDS "${workshop_dir}/${name}/*.cpp")
  add_library(dynfilter_${name} STATIC ${sources})
  set_target_properties(dynfilter_${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0
    POSITION_INDEPENDENT_CODE ON)  # the Python package links it
  target_include_directories(dynfilter_${name} PUBLIC "${workshop_dir}")
  target_link_libraries(dynfilter_${name} PUBLIC ${ARGN} PRIVATE dynfilter_compile_options)
endfunction()
dynfilter_workshop_folder(io dynfilter::detectors dynfilter::mapping dynfilter::inertial opencv_imgproc ${CMAKE_DL_LIBS})
dynfilter_workshop_folder(eval dynfilter_io)
dynfilter_workshop_folder(render dynfilter_io)
add_library(dynfilter_workshop INTERFACE)
target_link_libraries(dynfilter_workshop INTERFACE dynfilter_eval dynfilter_render)

# Videos and windows are a module, which is loaded when one is asked for.
# dynfilter_reads_videos(TARGET): finds it in the build tree. An installation has paths of its own.
function(dynfilter_reads_videos name)
  if(TARGET dynfilter_media)
    set_target_properties(${name} PROPERTIES BUILD_RPATH "${PROJECT_BINARY_DIR}/media")
  endif()
endfunction()
if(TARGET opencv_videoio)
  add_library(dynfilter_media MODULE "${workshop_dir}/media/module.cpp" "${workshop_dir}/media/video.cpp")
  target_link_libraries(dynfilter_media PRIVATE dynfilter::core dynfilter_compile_options opencv_imgproc opencv_videoio)
  if(TARGET opencv_highgui)
    target_sources(dynfilter_media PRIVATE "${workshop_dir}/media/window.cpp")
    target_link_libraries(dynfilter_media PRIVATE opencv_highgui)
    target_compile_definitions(dynfilter_media PRIVATE DYNFILTER_HAS_HIGHGUI)
  endif()
  target_include_directories(dynfilter_media PRIVATE "${workshop_dir}")
  set_target_properties(dynfilter_media PROPERTIES LIBRARY_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/media" UNITY_BUILD ON
    CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
  target_compile_definitions(dynfilter_io PRIVATE DYNFILTER_HAS_VIDEOIO)
  add_dependencies(dynfilter_io dynfilter_media)
else()
  message(STATUS "dynfilter: this OpenCV has no videoio: the command and Python read folders of images, and no videos")
endif()

# The commit that results are of. A library of its own, so that a commit links the command and Python anew, and no test.
set(commit_source "${CMAKE_CURRENT_BINARY_DIR}/commit.cpp")
add_custom_target(dynfilter_commit_source BYPRODUCTS "${commit_source}"
  COMMAND "${CMAKE_COMMAND}" "-DSOURCE=${PROJECT_SOURCE_DIR}" "-DOUTPUT=${commit_source}" -P "${PROJECT_SOURCE_DIR}/cmake/commit.cmake" VERBATIM)
add_library(dynfilter_commit STATIC "${commit_source}")
add_dependencies(dynfilter_commit dynfilter_commit_source)
set_target_properties(dynfilter_commit PROPERTIES POSITION_INDEPENDENT_CODE ON)
target_include_directories(dynfilter_commit PUBLIC "${workshop_dir}")
