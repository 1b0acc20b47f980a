// SPDX-License-Identifier: MIT
#include <dynfilter/geometry/rigid_motion_search.hpp>
#include <dynfilter/geometry/two_view_search.hpp>
