// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/votes.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

namespace dynfilter::command {

/// One feature with its verdict.
struct MarkedFeature {
  cv::Point2f pixel;
  Vote decision = Vote::Unknown;
  bool restored = false;      ///< dynamic, restored by the floor
  std::uint64_t reasons = 0;  ///< bit k: stage k of `OverlayFrame::stages` voted dynamic
  float weight = 1;           ///< for an optimiser
  cv::Point2f edge{};         ///< direction of the edge that it slides along; 0: a corner

  bool slides() const { return edge.dot(edge) > 0; }
};

struct OverlayFrame {
  cv::Mat colour;                   ///< CV_8UC3
  std::string title;                ///< one line above the picture
  std::vector<std::string> stages;  ///< stage of each reason bit
  std::vector<MarkedFeature> features;
  std::vector<Detection> detections;
  cv::Mat mask;  ///< CV_8UC1, potentially dynamic pixels; empty: no mask
};

/// Draws verdicts: static green, unknown grey, dynamic red with a symbol and shade per stage.
/// A feature with several stages has several symbols. What slides along an edge is a dash along it, if kept.
/// The darker a dot, the smaller its weight.
/// Also draws boxes and masks, and a legend with counts below the picture.
/// `most_width_px`: of the picture; without it one and a half times the image's.
class Overlay {
 public:
  explicit Overlay(int most_width_px = 0) : most_width_px_(most_width_px) {}

  cv::Mat draw(const OverlayFrame& frame) const {
    const float scale = scale_of(frame.colour);
    const cv::Size size = size_of(frame.colour, scale);
    const auto legend = frame.features.empty() ? std::vector<LegendEntry>() : legend_of(frame);
    const int rows = layout(legend, size.width, nullptr);
    cv::Mat canvas(size.height + kTitle_px + rows * kRow_px + 8, size.width, CV_8UC3, kPaper);
    cv::Mat picture = canvas(cv::Rect(0, kTitle_px, size.width, size.height));
    paint(frame, scale, picture);
    cv::putText(canvas, frame.title, {8, 19}, cv::FONT_HERSHEY_SIMPLEX, 0.5, kInk, 1, cv::LINE_AA);
    cv::Mat strip = canvas(cv::Rect(0, kTitle_px + size.height, size.width, rows * kRow_px + 8));
    layout(legend, size.width, &strip);
    return canvas;
  }

  /// The picture alone, without title and legend.
  cv::Mat draw_bare(const OverlayFrame& frame) const {
    const float scale = scale_of(frame.colour);
    cv::Mat picture(size_of(frame.colour, scale), CV_8UC3);
    paint(frame, scale, picture);
    return picture;
  }

 private:
  static constexpr float kScale = 1.5F;
  static constexpr int kTitle_px = 28, kRow_px = 24;
  static inline const cv::Scalar kPaper{28, 28, 28}, kInk{235, 235, 235}, kGreen{80, 220, 60},
      kGrey{150, 150, 150}, kAmber{60, 200, 255}, kBox{255, 220, 140};

  struct LegendEntry {
    MarkedFeature example;
    std::string text;
  };

  static void paint(const OverlayFrame& frame, float scale, cv::Mat& picture) {
    paint_background(frame, picture);
    for (const Detection& d : frame.detections)
      cv::rectangle(picture, scaled(d.box, scale), kBox, 1, cv::LINE_AA);
    for (const Vote layer : {Vote::Unknown, Vote::Static, Vote::Dynamic}) {
      for (const MarkedFeature& f : frame.features) {
        if (f.decision == layer) mark(f, f.pixel * scale, picture);
      }
    }
    for (const Detection& d : frame.detections) paint_label(d, scale, picture);
  }

  float scale_of(const cv::Mat& image) const {
    if (most_width_px_ == 0) return kScale;
    return std::min(kScale, static_cast<float>(most_width_px_) / static_cast<float>(image.cols));
  }
  static cv::Size size_of(const cv::Mat& image, float scale) {
    if (scale == kScale) return {image.cols * 3 / 2, image.rows * 3 / 2};
    return {std::max(1, cvRound(static_cast<float>(image.cols) * scale)),
            std::max(1, cvRound(static_cast<float>(image.rows) * scale))};
  }

  static cv::Scalar shade(std::size_t stage) {
    static const cv::Scalar kShades[] = {
        {50, 50, 255}, {40, 120, 255}, {150, 60, 255}, {90, 90, 200}, {200, 120, 255}};
    return kShades[stage % 5];
  }

  static void paint_background(const OverlayFrame& frame, cv::Mat& picture) {
    cv::resize(frame.colour, picture, picture.size(), 0, 0,
               picture.cols < frame.colour.cols ? cv::INTER_AREA : cv::INTER_LINEAR);
    picture *= 0.72;
    if (frame.mask.empty() || frame.mask.size() != frame.colour.size()) return;
    cv::Mat tinted, mask;
    cv::resize(frame.mask, mask, picture.size(), 0, 0, cv::INTER_NEAREST);
    cv::addWeighted(picture, 0.6, cv::Mat(picture.size(), picture.type(), cv::Scalar(160, 60, 30)), 0.4, 0,
                    tinted);
    tinted.copyTo(picture, mask);
  }

  static cv::Rect scaled(const cv::Rect2f& box, float scale) {
    return {cvRound(box.x * scale), cvRound(box.y * scale), cvRound(box.width * scale),
            cvRound(box.height * scale)};
  }

  static void paint_label(const Detection& d, float scale, cv::Mat& picture) {
    const cv::Rect box = scaled(d.box, scale);
    const std::string text = d.class_name + " " + std::to_string(cvRound(100 * d.score)) + "%";
    const cv::Size ink = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, 0.42, 1, nullptr);
    const cv::Point at(std::max(box.x, 0), std::max(box.y, ink.height + 6));
    cv::rectangle(picture, cv::Rect(at.x, at.y - ink.height - 6, ink.width + 6, ink.height + 6), kBox,
                  cv::FILLED);
    cv::putText(picture, text, {at.x + 3, at.y - 3}, cv::FONT_HERSHEY_SIMPLEX, 0.42, {40, 30, 10}, 1,
                cv::LINE_AA);
  }

  static void mark(const MarkedFeature& f, cv::Point2f at, cv::Mat& picture) {
    const cv::Point p(cvRound(at.x), cvRound(at.y));
    if (f.decision != Vote::Dynamic) {
      const cv::Scalar colour = f.decision == Vote::Static ? kGreen : f.restored ? kAmber : kGrey;
      if (f.slides()) return dash(at, f.edge, colour, picture);
      cv::circle(picture, p, 4, {0, 0, 0}, cv::FILLED, cv::LINE_AA);
      cv::circle(picture, p, 3, colour * brightness(f.weight), cv::FILLED, cv::LINE_AA);
      return;
    }
    bool any = false;
    for (std::size_t k = 0; k < 64; ++k) {
      if ((f.reasons >> k & 1U) == 0) continue;
      symbol(k, p, shade(k), picture);
      any = true;
    }
    if (!any) symbol(0, p, shade(0), picture);
  }

  static double brightness(float weight) { return 0.35 + 0.65 * std::sqrt(static_cast<double>(weight)); }

  static void dash(cv::Point2f at, cv::Point2f edge, const cv::Scalar& colour, cv::Mat& picture) {
    constexpr float kHalf_px = 7;
    const cv::Point a = at - kHalf_px * edge, b = at + kHalf_px * edge;
    cv::line(picture, a, b, {0, 0, 0}, 4, cv::LINE_AA);
    cv::line(picture, a, b, colour, 2, cv::LINE_AA);
  }

  // Cross, circle, square, diamond and plus differ without colour and are readable when superposed.
  static void symbol(std::size_t stage, cv::Point p, const cv::Scalar& colour, cv::Mat& picture) {
    for (const auto& [ink, width] : {std::pair<cv::Scalar, int>{{0, 0, 0}, 4}, {colour, 2}}) {
      switch (stage % 5) {
        case 0:
          cv::drawMarker(picture, p, ink, cv::MARKER_TILTED_CROSS, 9, width, cv::LINE_AA);
          break;
        case 1:
          cv::circle(picture, p, 6, ink, width, cv::LINE_AA);
          break;
        case 2:
          cv::drawMarker(picture, p, ink, cv::MARKER_SQUARE, 15, width, cv::LINE_AA);
          break;
        case 3:
          cv::drawMarker(picture, p, ink, cv::MARKER_DIAMOND, 15, width, cv::LINE_AA);
          break;
        default:
          cv::drawMarker(picture, p, ink, cv::MARKER_CROSS, 15, width, cv::LINE_AA);
      }
    }
  }

  static std::vector<LegendEntry> legend_of(const OverlayFrame& frame) {
    std::size_t of_static = 0, of_unknown = 0, of_restored = 0, dynamic = 0, slides = 0;
    std::vector<std::size_t> of_stage(frame.stages.size(), 0);
    for (const MarkedFeature& f : frame.features) {
      of_static += f.decision == Vote::Static;
      of_restored += f.decision == Vote::Unknown && f.restored;
      of_unknown += f.decision == Vote::Unknown && !f.restored;
      dynamic += f.decision == Vote::Dynamic;
      slides += f.decision != Vote::Dynamic && f.slides();
      for (std::size_t k = 0; f.decision == Vote::Dynamic && k < of_stage.size(); ++k)
        of_stage[k] += f.reasons >> k & 1U;
    }
    std::vector<LegendEntry> legend{{{{}, Vote::Static, false, 0}, "static " + std::to_string(of_static)},
                                    {{{}, Vote::Unknown, false, 0}, "unknown " + std::to_string(of_unknown)}};
    if (of_restored > 0)
      legend.push_back({{{}, Vote::Unknown, true, 0}, "kept by the floor " + std::to_string(of_restored)});
    if (slides > 0)
      legend.push_back(
          {{{}, Vote::Unknown, false, 0, 1, {1, 0}}, "of them along an edge " + std::to_string(slides)});
    legend.push_back({{{-1, -1}, Vote::Unknown, false, 0},
                      "dynamic " + std::to_string(dynamic) + (dynamic > 0 ? ", by" : "")});
    for (std::size_t k = 0; k < of_stage.size(); ++k) {
      if (of_stage[k] == 0) continue;
      legend.push_back({{{}, Vote::Dynamic, false, std::uint64_t{1} << k},
                        frame.stages[k] + " " + std::to_string(of_stage[k])});
    }
    return legend;
  }

  // Returns the number of rows. Draws them if `strip` is given.
  static int layout(const std::vector<LegendEntry>& legend, int width, cv::Mat* strip) {
    int x = 12, row = 0;
    for (const LegendEntry& entry : legend) {
      const int ink_px = cv::getTextSize(entry.text, cv::FONT_HERSHEY_SIMPLEX, 0.5, 1, nullptr).width;
      const bool with_symbol = entry.example.pixel.x >= 0;
      if (x > 12 && x + ink_px + 20 > width) x = 12, ++row;
      if (strip) {
        const int y = row * kRow_px + kRow_px / 2 + 4;
        if (with_symbol)
          mark(entry.example, cv::Point2f(static_cast<float>(x), static_cast<float>(y)), *strip);
        cv::putText(*strip, entry.text, {x + (with_symbol ? 14 : -4), y + 5}, cv::FONT_HERSHEY_SIMPLEX, 0.5,
                    kInk, 1, cv::LINE_AA);
      }
      x += ink_px + 40;
    }
    return legend.empty() ? 0 : row + 1;
  }

  int most_width_px_;
};

}  // namespace dynfilter::command
