// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace dynfilter::eval {

/// What figures are of: a reader can make them again.
struct Provenance {
  std::string version, commit;  ///< commit "": not known
  std::string machine;
};

/// "x86_64, 2 threads, Intel Xeon CPU @ 2.20GHz": what times depend on, and no name of the machine.
std::string machine_class();

}  // namespace dynfilter::eval
