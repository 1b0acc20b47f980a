// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/pipeline/builtin_filters.hpp>

#include <dynfilter/core/inline.hpp>
#include <dynfilter/filters/background_motion.hpp>
#include <dynfilter/filters/box_blur.hpp>
#include <dynfilter/filters/dbscan.hpp>
#include <dynfilter/filters/depth_consistency.hpp>
#include <dynfilter/filters/descriptor_distance.hpp>
#include <dynfilter/filters/epipolar.hpp>
#include <dynfilter/filters/flow_consistency.hpp>
#include <dynfilter/filters/gms.hpp>
#include <dynfilter/filters/map_point_belief.hpp>
#include <dynfilter/filters/semantic_box.hpp>
#include <dynfilter/filters/semantic_mask.hpp>
#include <dynfilter/filters/trajectory_consistency.hpp>

namespace dynfilter {

DYNFILTER_INLINE Registry builtin_filters() {
  Registry registry;
  registry.add<SemanticBoxFilter>();
  registry.add<SemanticMaskFilter>();
  registry.add<DepthConsistencyFilter>();
  registry.add<EpipolarFilter>();
  registry.add<FlowConsistencyFilter>();
  registry.add<BackgroundMotionFilter>();
  registry.add<TrajectoryConsistencyFilter>();
  registry.add<MapPointBeliefFilter>();
  registry.add<BoxBlurFilter>();
  registry.add<GmsFilter>();
  registry.add<DescriptorDistanceFilter>();
  registry.add<DbscanFilter>();
  return registry;
}

}  // namespace dynfilter
