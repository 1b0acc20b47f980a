# `cpack --config CPackSourceConfig.cmake`: the source package of a release. It contains the copied doctest.h, so that a
# release builds its tests where no doctest is installed.
# `cpack -G DEB` in a build of the preset `deb`: Debian packages, one per component of the installation.
set(CPACK_PACKAGE_NAME dynfilter)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
# Debian's own tools read these two variables. A package must name somebody who answers.
if(NOT CPACK_PACKAGE_CONTACT AND DEFINED ENV{DEBFULLNAME} AND DEFINED ENV{DEBEMAIL})
  set(CPACK_PACKAGE_CONTACT "$ENV{DEBFULLNAME} <$ENV{DEBEMAIL}>")
endif()
if(DYNFILTER_DEBIAN AND NOT CPACK_PACKAGE_CONTACT)
  message(FATAL_ERROR "dynfilter: the packages need a maintainer. Set the environment variables DEBFULLNAME and DEBEMAIL, "
    "or give -DCPACK_PACKAGE_CONTACT=\"Name <address>\"")
endif()
set(CPACK_SOURCE_GENERATOR TGZ)
set(CPACK_SOURCE_PACKAGE_FILE_NAME dynfilter-${PROJECT_VERSION})
set(CPACK_SOURCE_IGNORE_FILES "/\\\\.git/" "/\\\\.git$" "/build[^/]*/" "^${PROJECT_SOURCE_DIR}/out/" "\\\\.swp$"
    "/compile_commands\\\\.json$")
# The tests copy doctest.h when they are configured. The preset `deb` has no tests.
if(DYNFILTER_DEBIAN AND NOT EXISTS "${PROJECT_SOURCE_DIR}/test/doctest/doctest.h")
  find_path(DOCTEST_INCLUDE_DIR doctest.h PATH_SUFFIXES doctest)
  if(DOCTEST_INCLUDE_DIR)
    file(COPY "${DOCTEST_INCLUDE_DIR}/doctest.h" DESTINATION "${PROJECT_SOURCE_DIR}/test/doctest")
  else()
    message(WARNING "dynfilter: the source package will not contain doctest (Debian: apt-get install doctest-dev)")
  endif()
endif()
set(CPACK_RESOURCE_FILE_LICENSE "${PROJECT_SOURCE_DIR}/LICENSE")

include(cmake/debian.cmake)
include(CPack)
