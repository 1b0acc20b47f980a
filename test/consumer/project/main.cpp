// SPDX-License-Identifier: MIT
#include <cstdio>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/version.hpp>

int main() {
  dynfilter::Votes votes;
  votes.reset(3);
  votes.cast(1, dynfilter::Vote::Dynamic);
  const auto document = dynfilter::YamlDocument::from_text("limit_px: 2");
  const bool right =
      votes.count(dynfilter::Vote::Dynamic) == 1 && document.root().find("limit_px")->real() == 2;
  std::printf("dynfilter %s: %s\n", DYNFILTER_VERSION, right ? "works" : "is broken");
  return right ? 0 : 1;
}
