// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/pipeline/pipeline.hpp>
#include <memory>
#include <running/oracle_filter.hpp>
#include <string>

#include "arguments.hpp"
#include "python_filter.hpp"

namespace dynfilter::python {

/// A pipeline from a preset's name, a file or YAML text, or of one filter with its default parameters.
PipelineConfig config_of(const std::string& source, const Registry& registry);
/// A pipeline from a preset's name, a filter's name, a file, YAML text or an object of dynfilter.Filter.
/// With `labels` also the filter `oracle`, which reads them.
PipelineConfig config_of(py::handle source, const std::shared_ptr<FilterLink>& link,
                         const std::shared_ptr<const command::OracleLabels>& labels = nullptr);

}  // namespace dynfilter::python
