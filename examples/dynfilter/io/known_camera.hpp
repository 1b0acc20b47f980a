// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/camera.hpp>
#include <optional>
#include <string>

#include "io/known_camera.hpp"

namespace dynfilter::io {

/// Published intrinsics for the name of a TUM (freiburg1-3 or fr1-3) or Bonn sequence.
/// nullopt for any other name.
std::optional<Camera> known_camera(const std::string& name);

}  // namespace dynfilter::io
