// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/io/decoded_image.hpp>

namespace dynfilter::io::detail {

/// Reads uncompressed images of 8 (palette), 24 or 32 bits for each pixel.
/// Throws ImageFault and what `accept` throws.
DecodedImage decode_bmp(const Bytes& bytes, ImageAs as, const AcceptHeader& accept);

}  // namespace dynfilter::io::detail

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/io/detail/bmp_image-inl.hpp>
#endif
