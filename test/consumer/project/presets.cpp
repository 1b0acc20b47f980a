// SPDX-License-Identifier: MIT
// A preset is found by its name, in the folder that is given.
#include <cstdio>
#include <dynfilter/pipeline/presets.hpp>

int main(int, char** argv) {
  const std::filesystem::path found = dynfilter::find_preset("dynfilter"), wanted = argv[1];
  std::printf("%s\n", found.c_str());
  return std::filesystem::equivalent(found, wanted / "pipelines/dynfilter.yaml") ? 0 : 1;
}
