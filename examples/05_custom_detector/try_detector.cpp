// SPDX-License-Identifier: MIT
// Loads the plugin and creates the provider of a YAML file.
// Then runs it on a grey image with a dark square.
#include <cstdio>
#include <dynfilter/plugin/loader.hpp>
#include <dynfilter/semantic/detector_yaml.hpp>
#include <exception>

int main(int argc, char** argv) try {
  if (argc != 3) throw dynfilter::Error("usage: try_detector PLUGIN.so DETECTOR.yaml");
  dynfilter::Registry filters;
  dynfilter::ProviderRegistry providers;
  dynfilter::load_plugin(argv[1], filters, providers);
  const auto provider = dynfilter::detector_from_file(argv[2], providers).make();

  dynfilter::SemanticImage image;
  image.pixels = cv::Mat(100, 100, CV_8UC1, cv::Scalar(128));
  image.pixels(cv::Rect(20, 30, 40, 40)).setTo(10);
  const auto result = provider->infer(image);
  for (const dynfilter::Detection& d : *result->detections)
    std::printf("%s at %.0f %.0f, %.0f x %.0f\n", d.class_name.c_str(), static_cast<double>(d.box.x),
                static_cast<double>(d.box.y), static_cast<double>(d.box.width),
                static_cast<double>(d.box.height));
  return result->detections->size() == 1 ? 0 : 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "try_detector: %s\n", error.what());
  return 2;
}
