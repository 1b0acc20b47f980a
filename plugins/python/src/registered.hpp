// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/registry.hpp>
#include <dynfilter/pipeline/presets.hpp>

namespace dynfilter::python {

/// The filters of the toolkit and of the plugins loaded so far. The module's own list: hold the GIL.
Registry& compiled_filters();

/// The pipelines that the package brings.
const PresetFolders& preset_folders();

}  // namespace dynfilter::python
