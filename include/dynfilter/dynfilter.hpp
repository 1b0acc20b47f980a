// SPDX-License-Identifier: MIT
#pragma once

/// Everything a front end needs: frame views, filters, pipelines and verdicts.
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/compose.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <dynfilter/pipeline/presets.hpp>
#include <dynfilter/version.hpp>
