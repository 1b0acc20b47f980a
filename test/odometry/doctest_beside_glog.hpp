// SPDX-License-Identifier: MIT
// Ceres brings glog, whose CHECK macros have doctest's names. Include this after everything else.
#pragma once

#undef CHECK
#undef CHECK_EQ
#undef CHECK_NE
#undef CHECK_GT
#undef CHECK_LT
#undef CHECK_GE
#undef CHECK_LE
#include "doctest/doctest.h"
