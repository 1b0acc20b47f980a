// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

namespace dynfilter {

template <class P>
struct Field;

/// The parameters of a plain struct P, as core/parameters.hpp describes them.
template <class P>
using FieldTable = std::vector<Field<P>>;

}  // namespace dynfilter
