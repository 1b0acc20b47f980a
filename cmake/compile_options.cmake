# What our own programs, plugins and tests are compiled with. Never attached to the interface targets: users keep
# their own flags.
if(top_level AND NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  message(STATUS "dynfilter: no build type given, our own programs are built as Release")
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()

# The standard is spelt out for tools such as clang-tidy, whose default is an older one.
if(top_level AND NOT CMAKE_CXX_STANDARD)
  set(CMAKE_CXX_STANDARD 17)
  set(CMAKE_CXX_EXTENSIONS OFF)
endif()

add_library(dynfilter_compile_options INTERFACE)
target_compile_options(dynfilter_compile_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion
  -Wno-sign-conversion -Wnon-virtual-dtor -Woverloaded-virtual)
if(DYNFILTER_WARNINGS_AS_ERRORS)
  target_compile_options(dynfilter_compile_options INTERFACE -Werror)
endif()
# GCC looks for memory to free from 128 MB on, and most of our files take 200 to 1000: a seventh of the compile time.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(dynfilter_compile_options INTERFACE --param=ggc-min-expand=100 --param=ggc-min-heapsize=512000)
endif()
set(DYNFILTER_SANITIZERS "")
set(DYNFILTER_LIBFUZZER OFF)  # whether it drives the fuzz targets
if(DYNFILTER_FUZZ OR "${DYNFILTER_SANITIZE}" MATCHES "^(ON|1|TRUE)$")
  set(DYNFILTER_SANITIZERS address,undefined)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    string(APPEND DYNFILTER_SANITIZERS ",float-cast-overflow,implicit-integer-truncation")
    set(DYNFILTER_LIBFUZZER ON)
  endif()
  if(DYNFILTER_FUZZ)
    string(APPEND DYNFILTER_SANITIZERS ",fuzzer-no-link")
  endif()
elseif(DYNFILTER_SANITIZE)
  set(DYNFILTER_SANITIZERS "${DYNFILTER_SANITIZE}")
endif()
if(DYNFILTER_SANITIZERS)
  target_compile_options(dynfilter_compile_options INTERFACE -fsanitize=${DYNFILTER_SANITIZERS} -fno-omit-frame-pointer)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    # What object-size finds is an address that is wrong or an index that is: a seventh of the compile time.
    target_compile_options(dynfilter_compile_options INTERFACE -fno-sanitize-recover=all -fno-sanitize=object-size
      -fsanitize-ignorelist=${PROJECT_SOURCE_DIR}/test/sanitizers/not_ours.txt)
    find_program(DYNFILTER_LLD ld.lld)
    mark_as_advanced(DYNFILTER_LLD)
    if(DYNFILTER_LLD)  # links in less than half of the time
      target_link_options(dynfilter_compile_options INTERFACE -fuse-ld=lld)
    endif()
  else()
    target_compile_options(dynfilter_compile_options INTERFACE -fno-sanitize-recover=undefined
      -Wno-maybe-uninitialized -Wno-tsan)  # GCC's manual: the sanitizers make it see what is not there
  endif()
  target_link_options(dynfilter_compile_options INTERFACE -fsanitize=${DYNFILTER_SANITIZERS})
endif()

# The libraries'. As a part of another project they are compiled with that project's flags. Nothing in them is shared between
# a host and its plugins, and a plugin takes of them only what it calls.
add_library(dynfilter_library_options INTERFACE)
target_compile_options(dynfilter_library_options INTERFACE -ffunction-sections -fdata-sections)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(dynfilter_library_options INTERFACE -fno-gnu-unique)
endif()
if(top_level)
  target_link_libraries(dynfilter_library_options INTERFACE dynfilter_compile_options)
endif()
