// SPDX-License-Identifier: MIT
#pragma once

#include <pybind11/pybind11.h>

#include <dynfilter/core/verdict.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter::python {

namespace py = pybind11;

/// A verdict with the features that it is about.
struct PyVerdict {
  Verdict verdict;
  std::vector<std::uint8_t> keep;
  std::vector<float> weight;
  std::vector<cv::KeyPoint> keypoints;
  py::object image = py::none();  ///< weak reference to the frame's image: a verdict does not keep it
};

}  // namespace dynfilter::python
