// SPDX-License-Identifier: MIT
// The loops over pixels at every address that a row may start at: images are often parts of larger ones.
#include <cstdint>
#include <cstring>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/correspondence/patch_kernels.hpp>
#include <dynfilter/correspondence/small_patch_kernels.hpp>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "correspondence/random_texture.hpp"
#include "doctest/doctest.h"

namespace misaligned_images_test {

using namespace dynfilter;

namespace {

constexpr int kRegister = 32;   ///< bytes
constexpr int kMargin_px = 20;  ///< that the kernels may read around a window

struct Found {
  cv::Point2f mismatch;
  float xx, xy, yy;
  bool operator==(const Found& o) const {
    return mismatch == o.mismatch && xx == o.xx && xy == o.xy && yy == o.yy;
  }
};
template <class Kernels>
Found patch_of(const cv::Mat& image, int window_px) {
  const auto patch = std::make_unique<detail::Patch>();
  Kernels::cut(image, detail::Corner({kMargin_px + 0.3F, kMargin_px + 0.6F}), window_px, *patch);
  const detail::Corner to({kMargin_px + 1.9F, kMargin_px + 0.2F});
  return {Kernels::mismatch(image, to, window_px, *patch), patch->xx, patch->xy, patch->yy};
}

template <class Kernels>
std::vector<std::int32_t> small_patch_of(const cv::Mat& image, int window_px) {
  detail::SmallPatch patch;
  Kernels::cut(image, kMargin_px, kMargin_px, window_px, patch);
  const detail::SmallCorner to(cv::Point2f(kMargin_px + 1.4F, kMargin_px - 0.8F));
  const auto mismatch = Kernels::mismatch(image, to, window_px, patch);
  const auto likeness = Kernels::likeness(image, to, window_px, patch);
  const auto difference = Kernels::difference(image, kMargin_px + 1, kMargin_px, window_px, patch);
  return {patch.x,        patch.y,         patch.xx,         patch.xy,       patch.yy,
          mismatch.x,     mismatch.y,      mismatch.sum,     likeness.patch, likeness.patch2,
          likeness.image, likeness.image2, likeness.product, difference.sum, difference.square};
}

}  // namespace

TEST_CASE("patches of images at every address are those of the scalar loop on a copy") {
  constexpr int kSize_px = detail::Patch::kMaxWindow + 2 * kMargin_px;
  const cv::Mat image = test::noise_image({kSize_px, kSize_px}, 3, 1);
  // An odd step, so that the rows of one image have different alignments too.
  constexpr std::size_t kStep = static_cast<std::size_t>(kSize_px) + kRegister + 1;
  std::vector<unsigned char> memory(kStep * kSize_px + 2 * kRegister);
  for (int offset = 0; offset < kRegister; ++offset) {
    CAPTURE(offset);
    const auto past = static_cast<int>(reinterpret_cast<std::uintptr_t>(memory.data()) % kRegister);
    cv::Mat shifted(kSize_px, kSize_px, CV_8UC1, memory.data() + (kRegister - past) + offset, kStep);
    image.copyTo(shifted);
    for (const int window_px : {7, 21, 63}) {
      const Found expected = patch_of<detail::PatchKernels<8>>(image, window_px);
      CHECK(patch_of<detail::PatchKernels<8>>(shifted, window_px) == expected);
      if (uses_avx2()) CHECK(patch_of<detail::PatchKernels<16>>(shifted, window_px) == expected);
    }
    for (const int window_px : {12, 16}) {
      const auto expected = small_patch_of<detail::SmallPatchKernels<8>>(image, window_px);
      CHECK(small_patch_of<detail::SmallPatchKernels<8>>(shifted, window_px) == expected);
      if (uses_avx2()) CHECK(small_patch_of<detail::SmallPatchKernels<16>>(shifted, window_px) == expected);
    }
  }
}

}  // namespace misaligned_images_test
