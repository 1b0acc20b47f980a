// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/correspondence/coarse_flow.hpp>
#include <dynfilter/correspondence/correspondence_params.hpp>
#include <dynfilter/correspondence/image_pyramid.hpp>
#include <dynfilter/correspondence/small_patch_kernels.hpp>
#include <dynfilter/correspondence/small_window.hpp>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter {

/// What makes a tracked point reliable.
struct FlowLimits {
  /// Smallest eigenvalue of the gradient matrix; patches with less texture are not tracked.
  static constexpr double kMinEigenvalue = 1e-4;
  /// Largest 1 - normalised cross-correlation of the patches, for any check except none; 2 disables it.
  static constexpr double kMaxResidual = 0.3;
  /// Largest distance from the start after tracking back, for check forward_backward.
  static constexpr double kMaxForwardBackward_px = 1.0;
};

/// Lucas-Kanade that starts each point next to its result. A grid of patches is tracked down to level 1
/// (coarse_flow.hpp), and each point is tracked on level 0 only. It starts from its guess or from one of the
/// four grid nodes around it, whichever makes the patches most alike. So a point on a mover is not drawn to
/// the background's flow, nor the reverse. Tracking back starts from the point itself. It detects occlusion:
/// there the reference patch has another motion than the current one. A corner that looks much the same is
/// not tracked back: what hides a part of it changes it.
class GuidedFlow {
 public:
  bool wide = true;  ///< use 256-bit instructions where available, with identical results

  /// Whether windows of this width [px] can be tracked.
  static constexpr bool supports(int window_px) {
    return window_px >= kMinWindow && window_px <= detail::SmallPatch::kMaxWindow;
  }

  /// Uses at most `threads` of OpenCV's threads. Results are the same for any number.
  GuidedFlow(const FlowParams& params, int threads) : params_(params), threads_(threads) {}

  /// Tracks the grid, which needs no points. Until forget_prepared(), track() of these pyramids takes it.
  void prepare(const ImagePyramid& from, const ImagePyramid& to);
  void forget_prepared() { prepared_ = {}; }  ///< the images of the pyramids have changed

  /// Both pyramids have a border of one window. `px` contains the guesses on entry and the results on return.
  /// Cost: about 0.18 ms at 640 x 480 and 0.57 ms for 1000 points, checked both ways, on one core with AVX2.
  void track(const ImagePyramid& from, const ImagePyramid& to, FlowCheck check,
             const std::vector<cv::Point2f>& from_px, std::vector<cv::Point2f>& px,
             std::vector<std::uint8_t>& status, std::vector<MatchSpread>& spread);

 private:
  static constexpr int kMinWindow = 12;  ///< With fewer pixels, the checks accept chance.
  static constexpr int kBackIterations = 3;
  static constexpr float kBackEpsilon_px = 0.3F;  ///< far less than the way back may miss
  static constexpr double kSureResidual = 0.1;    ///< Chance hardly reaches it.

  using Images = std::vector<cv::Mat>;
  using Pixels = std::array<const std::uint8_t*, 2>;
  static Pixels pixels(const ImagePyramid& from, const ImagePyramid& to) {
    return {from.image().data, to.image().data};
  }
  bool is_wide() const { return wide && uses_avx2(); }
  template <class Kernels>
  void track_grid(const ImagePyramid& from, const ImagePyramid& to) {
    coarse_.compute<Kernels>(from.levels(), to.levels(), params_.window_px, FlowLimits::kMinEigenvalue,
                             threads_);
  }
  template <class Kernels>
  void track_with(const ImagePyramid& from, const ImagePyramid& to, FlowCheck check,
                  const std::vector<cv::Point2f>& from_px, std::vector<cv::Point2f>& px,
                  std::vector<std::uint8_t>& status, std::vector<MatchSpread>& spread);
  template <class Kernels>
  bool track_point(const Images& from, const Images& to, FlowCheck check, const cv::Point2f& from_px,
                   detail::SmallWindow<Kernels>& window, cv::Point2f& px, MatchSpread& spread) const;
  template <class Kernels>
  bool returns(const Images& from, const Images& to, const cv::Point2f& from_px, const cv::Point2f& px,
               detail::SmallWindow<Kernels>& window) const;

  float epsilon_px() const { return static_cast<float>(params_.epsilon_px); }

  FlowParams params_;
  int threads_;
  detail::CoarseFlow coarse_;
  Pixels prepared_{};  ///< whose grid coarse_ has
};

inline void GuidedFlow::prepare(const ImagePyramid& from, const ImagePyramid& to) {
  if (prepared_ == pixels(from, to)) return;
  forget_prepared();
  if (!from.fits(to) || !supports(params_.window_px)) return;
  is_wide() ? track_grid<detail::SmallPatchKernels<16>>(from, to)
            : track_grid<detail::SmallPatchKernels<8>>(from, to);
  prepared_ = pixels(from, to);
}

inline void GuidedFlow::track(const ImagePyramid& from, const ImagePyramid& to, FlowCheck check,
                              const std::vector<cv::Point2f>& from_px, std::vector<cv::Point2f>& px,
                              std::vector<std::uint8_t>& status, std::vector<MatchSpread>& spread) {
  status.assign(from_px.size(), 0);
  spread.assign(from_px.size(), {});
  if (!from.fits(to) || !supports(params_.window_px)) return;
  if (is_wide())
    track_with<detail::SmallPatchKernels<16>>(from, to, check, from_px, px, status, spread);
  else
    track_with<detail::SmallPatchKernels<8>>(from, to, check, from_px, px, status, spread);
}

template <class Kernels>
void GuidedFlow::track_with(const ImagePyramid& from, const ImagePyramid& to, FlowCheck check,
                            const std::vector<cv::Point2f>& from_px, std::vector<cv::Point2f>& px,
                            std::vector<std::uint8_t>& status, std::vector<MatchSpread>& spread) {
  if (prepared_ != pixels(from, to)) {
    forget_prepared();
    track_grid<Kernels>(from, to);
  }
  detail::in_ranges(static_cast<int>(from_px.size()), threads_, [&](int begin, int end) {
    detail::SmallWindow<Kernels> window(params_.window_px);
    for (auto k = static_cast<std::size_t>(begin); k < static_cast<std::size_t>(end); ++k)
      status[k] =
          track_point(from.levels(), to.levels(), check, from_px[k], window, px[k], spread[k]) ? 1 : 0;
  });
}

template <class Kernels>
bool GuidedFlow::track_point(const Images& from, const Images& to, FlowCheck check,
                             const cv::Point2f& from_px, detail::SmallWindow<Kernels>& window,
                             cv::Point2f& px, MatchSpread& spread) const {
  if (!window.cut(from[0], from_px) || !window.textured(FlowLimits::kMinEigenvalue)) return false;
  spread = window.spread();
  const detail::CoarseFlow::Around around = coarse_.around(from_px);
  const std::array<cv::Point2f, 5> flows{px - from_px, around[0], around[1], around[2], around[3]};
  px = from_px + most_alike(window, to[0], from_px, flows, 1);
  if (!window.refine(to[0], params_.max_iterations, epsilon_px(), px)) return false;
  if (check == FlowCheck::None) return true;
  const double residual = window.residual(to[0], px);
  if (residual > FlowLimits::kMaxResidual) return false;
  const bool sure = residual <= kSureResidual;
  // Patches that hardly look alike do so on level 1, too: so few pixels may resemble each other by chance.
  if (!sure && from.size() > 1 &&
      !(window.cut(from[1], from_px / 2) && window.residual(to[1], px / 2) <= FlowLimits::kMaxResidual))
    return false;
  const bool slides = spread.along > 1;
  return check == FlowCheck::Residual || (sure && !slides) || returns(from, to, from_px, px, window);
}

template <class Kernels>
bool GuidedFlow::returns(const Images& from, const Images& to, const cv::Point2f& from_px,
                         const cv::Point2f& px, detail::SmallWindow<Kernels>& window) const {
  cv::Point2f back = from_px;
  return window.cut(to[0], px) && window.textured(FlowLimits::kMinEigenvalue) &&
         window.refine(from[0], kBackIterations, kBackEpsilon_px, back) &&
         portable::hypot(back.x - from_px.x, back.y - from_px.y) <=
             static_cast<float>(FlowLimits::kMaxForwardBackward_px);
}

}  // namespace dynfilter
