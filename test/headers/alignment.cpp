// SPDX-License-Identifier: MIT
// Compiled with -mavx. A program with this flag and a library without it agree on public types, because Eigen
// aligns none of their members more strictly.
#include <cstddef>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/filters/background_motion.hpp>
#include <dynfilter/filters/epipolar.hpp>
#include <dynfilter/filters/flow_consistency.hpp>
#include <dynfilter/filters/trajectory_consistency.hpp>
#include <dynfilter/geometry/rigid_motion.hpp>
#include <dynfilter/geometry/rigid_residual.hpp>
#include <dynfilter/geometry/two_view.hpp>
#include <dynfilter/hosts/masked_host.hpp>
#include <dynfilter/hosts/orb_slam.hpp>
#include <dynfilter/keyframe/vertex_cover_selector.hpp>
#include <dynfilter/mapping/point_block.hpp>
#include <dynfilter/mapping/static_map.hpp>
#include <dynfilter/motion/free_space.hpp>
#include <dynfilter/motion/rigid_background.hpp>
#include <dynfilter/motion/static_miss.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/testing/exact_scene.hpp>

static_assert(EIGEN_MAX_ALIGN_BYTES == 32, "this file is compiled with -mavx");

template <class... T>
constexpr bool any_is_aligned_by_eigen() {
  return ((alignof(T) > alignof(std::max_align_t)) || ...);
}

static_assert(!any_is_aligned_by_eigen<
              dynfilter::BackgroundMotionFilter, dynfilter::EpipolarFilter, dynfilter::FlowConsistencyFilter,
              dynfilter::FrameEvidence, dynfilter::FrameView, dynfilter::FreeSpaceView, dynfilter::Pipeline,
              dynfilter::RigidBackgroundEstimator, dynfilter::RigidMotion, dynfilter::RigidResidualModel,
              dynfilter::StaticMissModel, dynfilter::TrajectoryConsistencyFilter, dynfilter::TwoViewModel,
              dynfilter::Verdict, dynfilter::Votes, dynfilter::MaskedHost, dynfilter::OrbSlam,
              dynfilter::VertexCoverSelector, dynfilter::testing::ExactScene>());
// Of its blocks, which say their alignment themselves.
static_assert(alignof(dynfilter::mapping::StaticMap) == alignof(dynfilter::mapping::detail::PointBlock));
