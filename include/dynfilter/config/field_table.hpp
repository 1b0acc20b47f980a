// SPDX-License-Identifier: MIT
#pragma once

namespace dynfilter {

/// The parameters of a plain struct P, as config/parameters.hpp describes them.
template <class P>
class FieldTable;

}  // namespace dynfilter
