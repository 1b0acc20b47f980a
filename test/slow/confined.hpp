// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string>

/// Runs a function in a process of its own, which the kernel ends if it takes too long.
namespace confined {

/// What the function itself measured, and what its process took.
struct Outcome {
  enum class End { Done, OutOfTime, Died } end = End::Died;
  double cpu_s = 0;      ///< as the function returned it
  double growth_MB = 0;  ///< largest resident memory minus that at the beginning
};

/// Calls f() in a child. A child that has used `most_cpu_s`, or has waited ten times as long, is ended.
Outcome run(double most_cpu_s, const std::function<double()>& f);

std::string to_string(Outcome::End end);

/// Processor time of this thread [s].
double cpu_s();

}  // namespace confined
