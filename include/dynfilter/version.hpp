// SPDX-License-Identifier: MIT
#pragma once

/// The only place of the version. CMake reads it from here.
#define DYNFILTER_VERSION_MAJOR 0
#define DYNFILTER_VERSION_MINOR 1
#define DYNFILTER_VERSION_PATCH 0
#define DYNFILTER_VERSION "0.1.0"
