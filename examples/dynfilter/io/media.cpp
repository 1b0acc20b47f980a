// SPDX-License-Identifier: MIT
#include "io/media.hpp"

#ifdef DYNFILTER_HAS_VIDEOIO
#include <dlfcn.h>

#include <dynfilter/version.hpp>
#endif

namespace dynfilter::io {

#ifdef DYNFILTER_HAS_VIDEOIO

namespace {

// Found by the run-time path of the program or module that this is linked into. Never unloaded: its libraries
// start threads. Its functions are bound when they are called: there are many.
const Media* load_media() {
  constexpr const char* kFile = "libdynfilter_media.so";
  void* library = ::dlopen(kFile, RTLD_LAZY | RTLD_LOCAL);
  if (library == nullptr) throw NoMedia(::dlerror());
  void* found = ::dlsym(library, "dynfilter_media");
  if (found == nullptr) throw NoMedia(std::string(kFile) + " has no function dynfilter_media");
  const Media* media = reinterpret_cast<const Media* (*)()>(found)();
  if (std::string(media->version) != DYNFILTER_VERSION)
    throw NoMedia(std::string(kFile) + " is of version " + media->version + ", expected " +
                  DYNFILTER_VERSION);
  return media;
}

}  // namespace

const Media& media() {
  static const Media* const loaded = load_media();
  return *loaded;
}

#else

const Media& media() {
  throw NoMedia("it was built without OpenCV's videoio");
}

#endif

}  // namespace dynfilter::io
