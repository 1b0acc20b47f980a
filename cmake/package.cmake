# `cpack --config build/CPackSourceConfig.cmake`: the source package of a release. It contains the copied doctest.h,
# so that a release builds its tests where no doctest is installed.
set(CPACK_PACKAGE_NAME dynfilter)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_SOURCE_GENERATOR TGZ)
set(CPACK_SOURCE_PACKAGE_FILE_NAME dynfilter-${PROJECT_VERSION})
set(CPACK_SOURCE_IGNORE_FILES "/\\\\.git/" "/\\\\.git$" "/build[^/]*/" "^${PROJECT_SOURCE_DIR}/out/" "\\\\.swp$"
    "/compile_commands\\\\.json$")
set(CPACK_RESOURCE_FILE_LICENSE "${PROJECT_SOURCE_DIR}/LICENSE")
include(CPack)
