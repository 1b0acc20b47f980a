// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/detectors/decoded_image.hpp>

namespace dynfilter::io::detail {

/// Decodes with libjpeg: grey and three components, baseline and progressive. Throws ImageFault, also for a
/// warning of libjpeg, and what `accept` throws.
DecodedImage decode_jpeg(const Bytes& bytes, ImageAs as, const AcceptHeader& accept);

}  // namespace dynfilter::io::detail
