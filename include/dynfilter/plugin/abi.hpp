// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/config/yaml.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/geometry/rigid_motion.hpp>
#include <dynfilter/geometry/two_view.hpp>
#include <dynfilter/semantic/provider_registry.hpp>
#include <opencv2/core/version.hpp>
#include <string>

namespace dynfilter {

/// 1 in 0.1.0, the first release. A release that changes a boundary type or the meaning of a call increments
/// it, even where no size changes.
inline constexpr std::uint32_t kAbiNumber = 1;

/// What the host and a plugin must agree on before they call each other's C++ code. Plain 32-bit numbers are
/// readable regardless of how the other side was built. `tag_bytes` always remains the first field.
struct AbiTag {
  std::uint32_t tag_bytes;
  std::uint32_t abi_number;
  std::uint32_t cxx11_abi;  ///< _GLIBCXX_USE_CXX11_ABI, which selects the std::string type
  std::uint32_t pointer_bytes, string_bytes, vector_bytes;
  std::uint32_t eigen_world, eigen_major, eigen_minor, eigen_max_align_bytes;
  std::uint32_t opencv_major, opencv_minor;
  std::uint32_t mat_bytes, keypoint_bytes;
  std::uint32_t camera_bytes, pose_bytes, detection_bytes, host_matches_bytes, detection_input_bytes;
  std::uint32_t mask_input_bytes, keyframe_view_bytes, frame_view_bytes;
  std::uint32_t votes_bytes, needs_bytes, filter_bytes, yaml_node_bytes, registry_entry_bytes, registry_bytes;
  std::uint32_t semantic_image_bytes, semantic_result_bytes, provider_bytes, provider_files_bytes;
  std::uint32_t provider_entry_bytes, provider_registry_bytes;
  std::uint32_t match_bytes, past_frame_bytes, matched_features_bytes, feature_tracks_bytes;
  std::uint32_t two_view_model_bytes, rigid_motion_bytes;
};

namespace detail {

template <class T>
constexpr std::uint32_t bytes_of() {
  return static_cast<std::uint32_t>(sizeof(T));
}

}  // namespace detail

/// The tag of the code that includes this header.
constexpr AbiTag abi_tag() {
  using detail::bytes_of;
  AbiTag tag{};
  tag.tag_bytes = bytes_of<AbiTag>();
  tag.abi_number = kAbiNumber;
#ifdef _GLIBCXX_USE_CXX11_ABI
  tag.cxx11_abi = _GLIBCXX_USE_CXX11_ABI;
#endif
  tag.pointer_bytes = bytes_of<void*>();
  tag.string_bytes = bytes_of<std::string>();
  tag.vector_bytes = bytes_of<std::vector<int>>();
  tag.eigen_world = EIGEN_WORLD_VERSION;
  tag.eigen_major = EIGEN_MAJOR_VERSION;
  tag.eigen_minor = EIGEN_MINOR_VERSION;
  tag.eigen_max_align_bytes = EIGEN_MAX_ALIGN_BYTES;
  tag.opencv_major = CV_VERSION_MAJOR;
  tag.opencv_minor = CV_VERSION_MINOR;
  tag.mat_bytes = bytes_of<cv::Mat>();
  tag.keypoint_bytes = bytes_of<cv::KeyPoint>();
  tag.camera_bytes = bytes_of<Camera>();
  tag.pose_bytes = bytes_of<Pose>();
  tag.detection_bytes = bytes_of<Detection>();
  tag.host_matches_bytes = bytes_of<HostMatches>();
  tag.detection_input_bytes = bytes_of<DetectionInput>();
  tag.mask_input_bytes = bytes_of<MaskInput>();
  tag.keyframe_view_bytes = bytes_of<KeyframeView>();
  tag.frame_view_bytes = bytes_of<FrameView>();
  tag.votes_bytes = bytes_of<Votes>();
  tag.needs_bytes = bytes_of<Needs>();
  tag.filter_bytes = bytes_of<Filter>();
  tag.yaml_node_bytes = bytes_of<YamlNode>();
  tag.registry_entry_bytes = bytes_of<Registry::Entry>();
  tag.registry_bytes = bytes_of<Registry>();
  tag.semantic_image_bytes = bytes_of<SemanticImage>();
  tag.semantic_result_bytes = bytes_of<SemanticResult>();
  tag.provider_bytes = bytes_of<SemanticProvider>();
  tag.provider_files_bytes = bytes_of<ProviderFiles>();
  tag.provider_entry_bytes = bytes_of<ProviderRegistry::Entry>();
  tag.provider_registry_bytes = bytes_of<ProviderRegistry>();
  tag.match_bytes = bytes_of<Match>();
  tag.past_frame_bytes = bytes_of<PastFrame>();
  tag.matched_features_bytes = bytes_of<MatchedFeatures>();
  tag.feature_tracks_bytes = bytes_of<FeatureTracks>();
  tag.two_view_model_bytes = bytes_of<TwoViewModel>();
  tag.rigid_motion_bytes = bytes_of<RigidMotion>();
  return tag;
}

/// A field of the tag with its name in error messages.
struct AbiField {
  const char* name;
  std::uint32_t AbiTag::*value;
};

/// In order of comparison. Errors report the first difference.
inline constexpr AbiField kAbiFields[] = {
    {"size of the ABI tag", &AbiTag::tag_bytes},
    {"ABI number", &AbiTag::abi_number},
    {"_GLIBCXX_USE_CXX11_ABI", &AbiTag::cxx11_abi},
    {"size of a pointer", &AbiTag::pointer_bytes},
    {"size of std::string", &AbiTag::string_bytes},
    {"size of std::vector", &AbiTag::vector_bytes},
    {"Eigen world version", &AbiTag::eigen_world},
    {"Eigen major version", &AbiTag::eigen_major},
    {"Eigen minor version", &AbiTag::eigen_minor},
    {"EIGEN_MAX_ALIGN_BYTES", &AbiTag::eigen_max_align_bytes},
    {"OpenCV major version", &AbiTag::opencv_major},
    {"OpenCV minor version", &AbiTag::opencv_minor},
    {"size of cv::Mat", &AbiTag::mat_bytes},
    {"size of cv::KeyPoint", &AbiTag::keypoint_bytes},
    {"size of Camera", &AbiTag::camera_bytes},
    {"size of Pose", &AbiTag::pose_bytes},
    {"size of Detection", &AbiTag::detection_bytes},
    {"size of HostMatches", &AbiTag::host_matches_bytes},
    {"size of DetectionInput", &AbiTag::detection_input_bytes},
    {"size of MaskInput", &AbiTag::mask_input_bytes},
    {"size of KeyframeView", &AbiTag::keyframe_view_bytes},
    {"size of FrameView", &AbiTag::frame_view_bytes},
    {"size of Votes", &AbiTag::votes_bytes},
    {"size of Needs", &AbiTag::needs_bytes},
    {"size of Filter", &AbiTag::filter_bytes},
    {"size of YamlNode", &AbiTag::yaml_node_bytes},
    {"size of Registry::Entry", &AbiTag::registry_entry_bytes},
    {"size of Registry", &AbiTag::registry_bytes},
    {"size of SemanticImage", &AbiTag::semantic_image_bytes},
    {"size of SemanticResult", &AbiTag::semantic_result_bytes},
    {"size of SemanticProvider", &AbiTag::provider_bytes},
    {"size of ProviderFiles", &AbiTag::provider_files_bytes},
    {"size of ProviderRegistry::Entry", &AbiTag::provider_entry_bytes},
    {"size of ProviderRegistry", &AbiTag::provider_registry_bytes},
    {"size of Match", &AbiTag::match_bytes},
    {"size of PastFrame", &AbiTag::past_frame_bytes},
    {"size of MatchedFeatures", &AbiTag::matched_features_bytes},
    {"size of FeatureTracks", &AbiTag::feature_tracks_bytes},
    {"size of TwoViewModel", &AbiTag::two_view_model_bytes},
    {"size of RigidMotion", &AbiTag::rigid_motion_bytes},
};
static_assert(sizeof(kAbiFields) / sizeof(kAbiFields[0]) == sizeof(AbiTag) / sizeof(std::uint32_t),
              "every field of the tag is compared");

/// The first field that differs, or nullptr. If the sizes differ, only the first field of `theirs` is read.
inline const AbiField* first_difference(const AbiTag& ours, const AbiTag& theirs) {
  for (const AbiField& field : kAbiFields)
    if (ours.*field.value != theirs.*field.value) return &field;
  return nullptr;
}

/// The functions of a plugin by their C names. The tag function is required, and at least one of the others.
using PluginTagFunction = const AbiTag* (*)();
/// Returns 0, or another number and the reason in `error`.
/// The reason is terminated and at most `error_bytes` long.
using PluginRegisterFunction = int (*)(Registry* registry, char* error, std::size_t error_bytes);
using PluginProvidersFunction = int (*)(ProviderRegistry* registry, char* error, std::size_t error_bytes);
inline constexpr const char* kPluginTagSymbol = "dynfilter_plugin_tag";
inline constexpr const char* kPluginRegisterSymbol = "dynfilter_plugin_register";
inline constexpr const char* kPluginProvidersSymbol = "dynfilter_plugin_register_providers";

}  // namespace dynfilter
