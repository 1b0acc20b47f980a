// SPDX-License-Identifier: MIT
#pragma once

#include <list>

namespace dynfilter::detail {

/// An unused entry, or a new one. T has a flag `valid`, which this sets.
/// A list keeps references to its entries valid while it grows.
template <class T>
T& next_slot(std::list<T>& slots) {
  for (T& slot : slots)
    if (!slot.valid) {
      slot.valid = true;
      return slot;
    }
  slots.emplace_back();
  slots.back().valid = true;
  return slots.back();
}

template <class T>
void free_slots(std::list<T>& slots) {
  for (T& slot : slots) slot.valid = false;
}

}  // namespace dynfilter::detail
