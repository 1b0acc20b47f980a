# Five packages: the headers and what builds against them, the shared library, the presets, the command with the modules, and
# the API reference if there is Doxygen.
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL development library data runtime)
if(TARGET reference)
  list(APPEND CPACK_COMPONENTS_ALL documentation)
endif()
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE
    WORLD_READ WORLD_EXECUTE)

set(library_package libdynfilter-facade${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
set(same "(= ${PROJECT_VERSION})")
set(toolkit "dynfilter judges, once per frame, which features of a visual SLAM front end\nlie on something that moves.\n")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libdynfilter-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
  "${library_package} ${same}, libeigen3-dev (>= ${DYNFILTER_Eigen3_MINIMUM}), libopencv-dev (>= ${DYNFILTER_OpenCV_MINIMUM}), libflann-dev, liblz4-dev, libpng-dev, libjpeg-dev")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_RECOMMENDS "dynfilter-data ${same}")
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION
  "${toolkit}.\nThis package contains the C++17 headers, the static libraries, and the\nfiles for find_package and pkg-config.")

set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME ${library_package})
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA "${PROJECT_BINARY_DIR}/debian/shlibs;${PROJECT_BINARY_DIR}/debian/triggers")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_STRICT_PERMISSION ON)
file(WRITE "${PROJECT_BINARY_DIR}/debian/shlibs"
  "libdynfilter_facade ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR} ${library_package} (>= ${PROJECT_VERSION})\n")
file(WRITE "${PROJECT_BINARY_DIR}/debian/triggers" "activate-noawait ldconfig\n")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_RECOMMENDS "dynfilter-data ${same}")
set(CPACK_DEBIAN_LIBRARY_DESCRIPTION
  "${toolkit}.\nThis package contains the shared library with an interface for C++11 and C.")

set(CPACK_DEBIAN_DATA_PACKAGE_NAME dynfilter-data)
set(CPACK_DEBIAN_DATA_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_DATA_DESCRIPTION
  "${toolkit}.\nThis package contains the pipelines and detectors that come with dynfilter.")

set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME dynfilter)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_DEPENDS "dynfilter-data ${same}")
set(CPACK_DEBIAN_RUNTIME_DESCRIPTION
  "${toolkit}.\nThis package contains the command that runs, compares and explains pipelines on\nrecorded sequences, and every rejector as a loadable module.")

set(CPACK_DEBIAN_DOCUMENTATION_PACKAGE_NAME dynfilter-doc)
set(CPACK_DEBIAN_DOCUMENTATION_PACKAGE_SECTION doc)
set(CPACK_DEBIAN_DOCUMENTATION_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_DOCUMENTATION_DESCRIPTION
  "${toolkit}.\nThis package contains the API reference as pages for a browser:\n/usr/share/doc/dynfilter-doc/html/index.html")

if(NOT DYNFILTER_DEBIAN OR NOT DYNFILTER_INSTALL)
  return()
endif()
find_program(DYNFILTER_GZIP gzip REQUIRED)
file(STRINGS "${PROJECT_SOURCE_DIR}/LICENSE" holder REGEX "^Copyright")
string(REGEX REPLACE "^Copyright [(]c[)] " "" holder "${holder}")
file(READ "${PROJECT_SOURCE_DIR}/LICENSE" license)
string(REGEX REPLACE "^.*(Permission is hereby)" "\\1" license "${license}")
string(STRIP "${license}" license)
string(REGEX REPLACE "\n\n" "\n.\n" license "${license}")
string(REPLACE "\n" "\n " license "${license}")
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
set(files "${PROJECT_BINARY_DIR}/debian")
set(third_party_of_development eigen)
set(third_party_of_library eigen)
set(third_party_of_runtime eigen command)
set(third_party_of_documentation documentation)
foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  string(TOUPPER ${component} upper)
  set(package ${CPACK_DEBIAN_${upper}_PACKAGE_NAME})
  set(third_party "")
  foreach(part IN LISTS third_party_of_${component})
    file(READ cmake/debian/third_party_${part} text)
    string(CONFIGURE "${text}" text @ONLY)
    string(APPEND third_party "${text}")
  endforeach()
  configure_file(cmake/debian/copyright.in "${files}/${package}/copyright" @ONLY)
  configure_file(THIRD_PARTY.md "${files}/${package}/THIRD_PARTY.md" COPYONLY)
  configure_file(cmake/debian/changelog.in "${files}/${package}/changelog" @ONLY)
  execute_process(COMMAND "${DYNFILTER_GZIP}" -9nf "${files}/${package}/changelog")
  install(DIRECTORY "${files}/${package}" DESTINATION ${CMAKE_INSTALL_DATADIR}/doc COMPONENT ${component})
endforeach()
