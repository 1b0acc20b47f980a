// SPDX-License-Identifier: MIT
// The loop of a front end around a pipeline from YAML.
//   02_yaml_pipeline PIPELINE.yaml SEQUENCE
// SEQUENCE is a TUM RGB-D folder. Boxes are read from its detections.txt, if it exists.
#include <cstdio>
#include <dynfilter/detectors/detections.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <exception>
#include <filesystem>
#include <opencv2/features2d.hpp>

#include "io/sequence.hpp"

namespace {

void run(const char* pipeline_file, const std::filesystem::path& folder) {
  using namespace dynfilter;
  Pipeline pipeline(pipeline_from_file(pipeline_file, builtin_filters()));
  const io::Sequence sequence = io::Sequence::open(folder);
  std::optional<io::DetectionTrack> detections;
  if (std::filesystem::exists(folder / "detections.txt"))
    detections = io::read_detections(folder / "detections.txt");
  const cv::Ptr<cv::ORB> orb = cv::ORB::create(1000);

  for (std::size_t i = 0; i < sequence.size(); ++i) {
    const io::SequenceFrame image = sequence.load(i);
    std::vector<cv::KeyPoint> keypoints;
    orb->detect(image.grey, keypoints);

    FrameView frame;  // all fields except the keypoints are optional
    frame.id = static_cast<std::int64_t>(i);
    frame.timestamp_s = image.timestamp_s;
    frame.keypoints = keypoints;
    frame.grey = image.grey;
    frame.depth = image.depth;
    frame.depth_unit_m = image.depth_unit_m;
    frame.camera = sequence.camera();
    if (detections)
      if (const auto* boxes = detections->at(image.timestamp_s))
        frame.detections = DetectionInput{-1, *boxes};

    const Verdict& verdict = pipeline.before_pose(frame);
    // A front end now tracks with the features for which verdict.keep(i) is true.
    std::printf("frame %zu: %zu of %zu features kept\n", i, verdict.kept(), verdict.size());
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: 02_yaml_pipeline PIPELINE.yaml SEQUENCE\n");
    return 2;
  }
  try {
    run(argv[1], argv[2]);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "02_yaml_pipeline: %s\n", error.what());
    return 2;
  }
}
