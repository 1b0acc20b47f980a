// SPDX-License-Identifier: MIT
#include "eval/provenance.hpp"

#include <sys/utsname.h>

#include <fstream>
#include <thread>

namespace dynfilter::eval {
namespace {

/// As Linux names it; "" where it does not.
std::string processor_model() {
  std::ifstream in("/proc/cpuinfo");
  const std::string key = "model name";
  for (std::string line; std::getline(in, line);) {
    const std::size_t colon = line.find(": ");
    if (line.compare(0, key.size(), key) == 0 && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "";
}

void remove_all(std::string& text, const std::string& part) {
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part))
    text.erase(at, part.size());
}

}  // namespace

std::string machine_class() {
  utsname system{};
  std::string machine = uname(&system) == 0 ? system.machine : "unknown processor";
  const unsigned threads = std::thread::hardware_concurrency();
  if (threads > 0) machine += ", " + std::to_string(threads) + (threads == 1 ? " thread" : " threads");
  std::string model = processor_model();
  for (const char* mark : {"(R)", "(TM)"}) remove_all(model, mark);
  return model.empty() ? machine : machine + ", " + model;
}

}  // namespace dynfilter::eval
