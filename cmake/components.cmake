# One interface target per component: dynfilter::core, dynfilter::io, ... A component is a folder of headers under
# include/dynfilter, and links what its headers include. The order is the direction in which data flows.
find_package(Eigen3 3.3 REQUIRED NO_MODULE)
find_package(OpenCV 4.2 REQUIRED COMPONENTS core imgproc video calib3d features2d imgcodecs)
find_package(Threads REQUIRED)

set(DYNFILTER_COMPONENTS "")
function(dynfilter_component name)
  add_library(dynfilter_${name} INTERFACE)
  add_library(dynfilter::${name} ALIAS dynfilter_${name})
  set_target_properties(dynfilter_${name} PROPERTIES EXPORT_NAME ${name})
  target_compile_features(dynfilter_${name} INTERFACE cxx_std_17)
  target_include_directories(dynfilter_${name} INTERFACE
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:include>)
  target_link_libraries(dynfilter_${name} INTERFACE ${ARGN})
  set(DYNFILTER_COMPONENTS ${DYNFILTER_COMPONENTS} ${name} PARENT_SCOPE)
endfunction()

dynfilter_component(core Eigen3::Eigen opencv_core)
dynfilter_component(correspondence dynfilter_core opencv_imgproc opencv_video)
dynfilter_component(geometry dynfilter_core opencv_calib3d)
dynfilter_component(context dynfilter_correspondence dynfilter_geometry)
dynfilter_component(filters dynfilter_context)
dynfilter_component(pipeline dynfilter_filters)
dynfilter_component(plugin dynfilter_filters ${CMAKE_DL_LIBS})
dynfilter_component(adapters dynfilter_pipeline opencv_imgproc)
dynfilter_component(io dynfilter_core opencv_imgcodecs opencv_imgproc)
dynfilter_component(eval dynfilter_io)
dynfilter_component(synth dynfilter_context dynfilter_io opencv_imgproc)
