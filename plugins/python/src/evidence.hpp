// SPDX-License-Identifier: MIT
#pragma once

#include <pybind11/pybind11.h>

#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <memory>

#include "arguments.hpp"

namespace dynfilter::python {

/// What a Python filter reads and writes. Both are cut off when the filter returns: a frame's evidence is
/// gone then.
struct EvidenceLink {
  const Evidence* evidence = nullptr;
  Votes* votes = nullptr;
  const Images* images = nullptr;  ///< arrays behind the frame's images; null: none

  const Evidence& open() const;
};

/// Opens evidence and votes for one call of a filter.
class OpenEvidence {
 public:
  OpenEvidence(const Evidence& evidence, Votes& votes, const Images* images);
  ~OpenEvidence();
  OpenEvidence(const OpenEvidence&) = delete;
  OpenEvidence& operator=(const OpenEvidence&) = delete;

  py::object evidence() const { return evidence_; }
  py::object votes() const { return votes_; }

 private:
  std::shared_ptr<EvidenceLink> link_;
  py::object evidence_, votes_;
};

}  // namespace dynfilter::python
