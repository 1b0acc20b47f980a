// SPDX-License-Identifier: MIT
#pragma once

namespace dynfilter::command {

/// The commit that this program was built from, "+" if sources were changed. "": not from a Git repository.
const char* source_commit();

}  // namespace dynfilter::command
