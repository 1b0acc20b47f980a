// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/detectors/decoded_image.hpp>

namespace dynfilter::io::detail {

/// Reads binary PGM (P5) and PPM (P6) of 8 or 16 bits. Values are not scaled by the largest value.
/// Throws ImageFault and what `accept` throws.
DecodedImage decode_pnm(const Bytes& bytes, ImageAs as, const AcceptHeader& accept);

}  // namespace dynfilter::io::detail
