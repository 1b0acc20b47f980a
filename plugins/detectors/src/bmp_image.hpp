// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/detectors/decoded_image.hpp>

namespace dynfilter::io::detail {

/// Reads uncompressed images of 8 (palette), 24 or 32 bits for each pixel.
/// Throws ImageFault and what `accept` throws.
DecodedImage decode_bmp(const Bytes& bytes, ImageAs as, const AcceptHeader& accept);

}  // namespace dynfilter::io::detail
