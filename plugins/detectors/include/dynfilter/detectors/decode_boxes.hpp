// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/detectors/network_boxes.hpp>
#include <opencv2/core/mat.hpp>
#include <vector>

/// Decoders from a network's output tensors to boxes. They need no network.
/// Each appends to `boxes` and throws Error if the output has another layout.
/// The caller adds the network's name to the error.
namespace dynfilter {

/// Output of a Darknet [yolo] or [region] layer in cv::dnn: N x (5 + classes), or 1 x that.
/// Each row is cx cy w h as shares of the input, objectness, and per class objectness x probability.
void decode_yolo_regions(const cv::Mat& output, const BoxLayout& layout, std::vector<NetworkBox>& boxes);

/// Output of a YOLOv5 export: 1 x N x (5 + classes + coefficients).
/// Each row is cx cy w h in pixels of the input, objectness, a probability per class, and mask coefficients.
/// The score is objectness x best probability.
void decode_yolov5(const cv::Mat& output, const BoxLayout& layout, std::vector<NetworkBox>& boxes);

/// Output of a YOLOv8, v9 or v11 export: 1 x (4 + classes + coefficients) x N.
/// Each column is cx cy w h in pixels of the input, a probability per class and mask coefficients.
void decode_yolov8(const cv::Mat& output, const BoxLayout& layout, std::vector<NetworkBox>& boxes);

/// Output of a DetectionOutput layer (SSD; Caffe and TensorFlow): 1 x 1 x N x 7.
/// Each row is image, label, score, x0 y0 x1 y1 as shares of the input.
/// A negative image number ends the list.
void decode_ssd(const cv::Mat& output, const BoxLayout& layout, std::vector<NetworkBox>& boxes);

}  // namespace dynfilter
