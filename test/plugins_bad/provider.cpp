// SPDX-License-Identifier: MIT
// A correct plugin with a provider of boxes and no filter.
#include <dynfilter/plugin/export.hpp>

namespace {

class Corner : public dynfilter::SemanticProvider {
 public:
  struct Params {
    double size_px = 10;
    static const dynfilter::FieldTable<Params>& fields() {
      static const dynfilter::FieldTable<Params> table{
          dynfilter::real("size_px", &Params::size_px, "px", {1, 100}, "of its box")};
      return table;
    }
  };
  static constexpr const char* kName = "corner";
  static constexpr const char* kSummary = "a box in the upper left corner of every image";

  explicit Corner(const Params& params) : params_(params) {}
  std::string name() const override { return kName; }
  std::optional<dynfilter::SemanticResult> infer(const dynfilter::SemanticImage& image) override {
    dynfilter::Detection box;
    box.box = cv::Rect2f(0, 0, static_cast<float>(params_.size_px), static_cast<float>(params_.size_px));
    box.class_name = "person";
    dynfilter::SemanticResult result;
    result.frame_id = image.frame_id;
    result.timestamp_s = image.timestamp_s;
    result.detections = {box};
    return result;
  }

 private:
  Params params_;
};

}  // namespace

DYNFILTER_REGISTER_PROVIDERS(Corner);
