# Writes the commit of the sources as C++, at each build. The file changes only with the commit.
#   cmake -DSOURCE=DIR -DOUTPUT=FILE.cpp -P commit.cmake
set(commit "")
find_program(git_program git)
if(git_program AND EXISTS "${SOURCE}/.git")  # not that of a repository which holds an unpacked archive
  execute_process(COMMAND "${git_program}" -C "${SOURCE}" describe --always --dirty=+ --exclude=* --abbrev=10
    OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
set(code "#include \"running/commit.hpp\"\n\nnamespace dynfilter::command {\n\nconst char* source_commit() {\n  return \"${commit}\";\n}\n\n}  // namespace dynfilter::command\n")
set(old "")
if(EXISTS "${OUTPUT}")
  file(READ "${OUTPUT}" old)
endif()
if(NOT code STREQUAL old)
  file(WRITE "${OUTPUT}" "${code}")
endif()
