# doctest is bundled: the header of the package doctest-dev is copied beside the tests, where the source package takes
# it along. A release therefore builds its tests with nothing installed.
set(DYNFILTER_DOCTEST_MINIMUM 2.4.9)
set(bundled "${PROJECT_SOURCE_DIR}/test/doctest/doctest.h")
if(NOT EXISTS "${bundled}")
  find_path(DOCTEST_INCLUDE_DIR doctest.h PATH_SUFFIXES doctest)
  if(NOT DOCTEST_INCLUDE_DIR)
    message(FATAL_ERROR "dynfilter: the tests need doctest ${DYNFILTER_DOCTEST_MINIMUM} (Debian: apt-get install "
                        "doctest-dev), or configure with -DDYNFILTER_BUILD_TESTS=OFF")
  endif()
  file(COPY "${DOCTEST_INCLUDE_DIR}/doctest.h" DESTINATION "${PROJECT_SOURCE_DIR}/test/doctest")
endif()
file(STRINGS "${bundled}" numbers REGEX "^#define DOCTEST_VERSION_(MAJOR|MINOR|PATCH) [0-9]+")
string(REGEX MATCHALL "[0-9]+" numbers "${numbers}")
list(JOIN numbers "." doctest_version)
if(doctest_version VERSION_LESS DYNFILTER_DOCTEST_MINIMUM)
  message(FATAL_ERROR "dynfilter: ${bundled} is doctest ${doctest_version}, the tests need "
                      "${DYNFILTER_DOCTEST_MINIMUM}: delete it and install a newer doctest-dev")
endif()
