// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/detectors/decoded_image.hpp>

namespace dynfilter::io::detail {

/// Decodes with libpng, row by row into the image. Chunks but the image, its palette, transparency and Exif
/// data are skipped. Throws ImageFault, also for a warning of libpng, and what `accept` throws.
DecodedImage decode_png(const Bytes& bytes, ImageAs as, const AcceptHeader& accept);

}  // namespace dynfilter::io::detail
