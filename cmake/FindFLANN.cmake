# FLANN's headers and the lz4 that they call: FLANN::FLANN. Of FLANN's own library nothing is needed. Debian's pkg-config file
# drags HDF5 and MPI in, and there is no CMake config.
find_path(FLANN_INCLUDE_DIR flann/algorithms/kdtree_single_index.h)
find_library(FLANN_LZ4_LIBRARY lz4)
mark_as_advanced(FLANN_INCLUDE_DIR FLANN_LZ4_LIBRARY)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(FLANN REQUIRED_VARS FLANN_LZ4_LIBRARY FLANN_INCLUDE_DIR
  REASON_FAILURE_MESSAGE "Debian: apt-get install libflann-dev liblz4-dev")

if(FLANN_FOUND AND NOT TARGET FLANN::FLANN)
  add_library(FLANN::FLANN INTERFACE IMPORTED GLOBAL)
  target_include_directories(FLANN::FLANN SYSTEM INTERFACE "${FLANN_INCLUDE_DIR}")
  target_link_libraries(FLANN::FLANN INTERFACE "${FLANN_LZ4_LIBRARY}")
endif()
