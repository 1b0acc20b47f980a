// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>

#include "io/media.hpp"

namespace dynfilter::media {

std::unique_ptr<io::VideoReader> make_reader(const std::string& address, bool camera);
std::unique_ptr<io::VideoWriter> make_writer();

#ifdef DYNFILTER_HAS_HIGHGUI
std::unique_ptr<io::PictureWindow> make_window(const std::string& title);
bool display_answers();
#endif

}  // namespace dynfilter::media
