# SPDX-License-Identifier: MIT
vcpkg_from_git(OUT_SOURCE_PATH SOURCE_PATH URL <address> REF <commit>)
vcpkg_cmake_configure(SOURCE_PATH "${SOURCE_PATH}" OPTIONS
  -DDYNFILTER_BUILD_TESTS=OFF -DDYNFILTER_BUILD_EXAMPLES=OFF -DDYNFILTER_BUILD_PLUGINS=OFF
  -DDYNFILTER_BUILD_FACADE=OFF -DDYNFILTER_WARNINGS_AS_ERRORS=OFF)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/dynfilter)
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include" "${CURRENT_PACKAGES_DIR}/debug/share")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
