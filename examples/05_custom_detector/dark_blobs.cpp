// SPDX-License-Identifier: MIT
#include "dark_blobs.hpp"

#include <dynfilter/plugin/export.hpp>

DYNFILTER_EXPORT_PROVIDERS(mine::DarkBlobs);
