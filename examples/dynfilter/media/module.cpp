// SPDX-License-Identifier: MIT
#include <dynfilter/version.hpp>

#include "media/media.hpp"

/// What io::media() looks for.
extern "C" __attribute__((visibility("default"))) const dynfilter::io::Media* dynfilter_media() {
#ifdef DYNFILTER_HAS_HIGHGUI
  constexpr auto window = dynfilter::media::make_window;
  constexpr auto display_answers = dynfilter::media::display_answers;
#else
  constexpr auto window = nullptr;
  constexpr auto display_answers = nullptr;
#endif
  static constexpr dynfilter::io::Media kMedia{DYNFILTER_VERSION, dynfilter::media::make_reader,
                                               dynfilter::media::make_writer, window, display_answers};
  return &kMedia;
}
