# What starts quickly loads neither videos, windows nor OpenCV's images: with them the command took 141 instead of 13 ms.
#   cmake -DPROGRAMS=dynfilter -DMODULES=_core.so -P check_start.cmake
file(GET_RUNTIME_DEPENDENCIES EXECUTABLES ${PROGRAMS} MODULES ${MODULES} RESOLVED_DEPENDENCIES_VAR loaded)
list(LENGTH loaded count)
if(count LESS 10)  # the command's own are more
  message(SEND_ERROR "${count} libraries were found, so these are not all")
endif()
list(FILTER loaded INCLUDE REGEX "opencv_imgcodecs|opencv_videoio|opencv_highgui|gdal|avcodec")
if(loaded)
  message(SEND_ERROR "loaded with every start: ${loaded}")
endif()
