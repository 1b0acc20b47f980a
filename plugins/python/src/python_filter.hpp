// SPDX-License-Identifier: MIT
#pragma once

#include <pybind11/pybind11.h>

#include <dynfilter/config/registry.hpp>
#include <dynfilter/core/filter.hpp>
#include <exception>
#include <memory>
#include <string>
#include <utility>

#include "arguments.hpp"

namespace dynfilter::python {

/// What the filters of one pipeline share with its owner.
struct FilterLink {
  /// The images of the frame that is judged; null: they own their memory.
  const Images* images = nullptr;
  /// The first exception of a filter that the caller has not seen.
  std::exception_ptr error;

  /// Throws it.
  void rethrow_error() {
    if (error) std::rethrow_exception(std::exchange(error, nullptr));
  }
};

/// A filter written in Python. Takes the GIL for each call.
class PythonFilter final : public Filter {
 public:
  /// `object`: of a class derived from dynfilter.Filter.
  PythonFilter(py::object object, std::shared_ptr<FilterLink> link);
  ~PythonFilter() override;

  std::string name() const override { return name_; }
  Needs needs() const override { return needs_; }
  void apply(const Evidence& evidence, Votes& votes) override;
  void reset() override;

 private:
  [[noreturn]] void report(py::error_already_set& error);

  py::object object_;
  std::shared_ptr<FilterLink> link_;
  std::string name_;
  Needs needs_;
};

/// The filters of the toolkit, those of loaded plugins and those written in Python.
Registry registry(const std::shared_ptr<FilterLink>& link);

/// Names of inputs as Python filters write them. Raises ValueError that lists them.
Input inputs_of(py::handle names);

/// What a Python filter's class says of itself.
FilterCard card_of(py::handle filter_class);

}  // namespace dynfilter::python
