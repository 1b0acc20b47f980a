// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <dynfilter/config/yaml.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <dynfilter/recorder/recording.hpp>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "frame_record.hpp"
#include "parameter_texts.hpp"
#include "record_bytes.hpp"
#include "record_file.hpp"

namespace dynfilter::recorder {

FrameView RecordedFrame::view(std::vector<KeyframeView>& keyframes) const {
  FrameView view;
  view.id = id, view.timestamp_s = timestamp_s;
  view.keypoints = keypoints, view.keypoints_undistorted = keypoints_undistorted;
  view.descriptors = descriptors;
  view.depth_m = depth_m, view.right_u_px = right_u_px;
  view.grey = grey, view.right_grey = right_grey, view.depth = depth;
  view.depth_unit_m = depth_unit_m, view.depth_handed_over = depth_handed_over;
  view.camera = camera;
  view.T_world_camera = T_world_camera, view.pose_provenance = pose_provenance;
  view.motion_prior = motion_prior;
  view.map_point_ids = map_point_ids, view.map_points_world_m = map_points_world_m;
  keyframes.clear();
  for (const RecordedKeyframe& k : covisible_keyframes)
    keyframes.push_back({k.id, k.T_world_camera, k.keypoints_undistorted, k.depth_m, k.map_point_ids});
  view.covisible_keyframes = keyframes;
  if (matches)
    view.matches = HostMatches{matches->reference_frame_id, matches->reference_index, matches->spread};
  if (detections) view.detections = DetectionInput{detections->frame_id, detections->detections};
  view.mask = mask;
  return view;
}

void RecordedEvent::repeat(Pipeline& pipeline) const {
  switch (kind) {
    case Kind::Frame:
      return;
    case Kind::Reset:
      return pipeline.reset();
    case Kind::Lost:
      return pipeline.lost();
    case Kind::Pose:
      return pipeline.update_pose(pose_frame_id, T_world_camera, provenance, tracking.view());
  }
}

PipelineConfig config_of(const RecordedPipeline& recorded, const Registry& registry) {
  if (recorded.yaml.empty())
    throw ConfigError("the recorded pipeline `" + recorded.name + "`",
                      "was made in code, without YAML: name another one");
  PipelineConfig config = pipeline_from_text(recorded.yaml, registry);
  std::map<std::string, std::string> values(recorded.parameters.begin(), recorded.parameters.end());
  for_each_parameter(config, [&](const std::string& name, const auto& field, void* params) {
    const auto value = values.find(name);
    if (value == values.end() || value->second == field.print(params)) return;
    const YamlDocument document = YamlDocument::from_text("value: " + value->second);
    field.read(params, *document.root().find("value"));
  });
  return config;
}

namespace detail {

struct IndexedRecord {
  RecordHeader header;
  std::uint64_t offset = 0;  ///< of what follows the header

  RecordKind kind() const { return static_cast<RecordKind>(header.kind); }
};

/// The newest image of each slot.
class ImageShelf {
 public:
  void put(std::uint64_t call, const std::vector<char>& raw) {
    ByteReader bytes(raw);
    std::vector<char> images;
    constexpr std::size_t kLeastBytes = 20;
    bytes.count(images, kLeastBytes);
    for (std::size_t k = 0; k < images.size(); ++k) {
      std::uint32_t slot = 0;
      bytes.number(slot);
      Shelved& shelved = shelf_[slot];
      shelved.call = call;
      shelved.image = cv::Mat();  // an earlier frame may still have the old one
      bytes.matrix(shelved.image);
    }
    bytes.finish();
  }

  template <class Archive>
  void transfer(Archive& archive, std::uint32_t slot, cv::Mat& image) {
    ImagePlace place;
    place.transfer(archive);
    image.release();
    if (place.kind == ImagePlace::Kind::None) return;
    const auto found = shelf_.find(slot);
    if (place.kind == ImagePlace::Kind::Stored && found != shelf_.end() && found->second.call == place.call)
      image = found->second.image;
    else
      ++left_out;
  }

  std::size_t left_out = 0;  ///< of the frame

 private:
  struct Shelved {
    std::uint64_t call = 0;
    cv::Mat image;
  };
  std::map<std::uint32_t, Shelved> shelf_;
};

}  // namespace detail

class RecordingReader::Impl {
 public:
  using IndexedRecord = detail::IndexedRecord;

  explicit Impl(const std::filesystem::path& path)
      : path_(path.string()), file_(std::fopen(path.c_str(), "rb")) {
    if (!file_ || std::filesystem::is_directory(path)) throw IoError(path_ + ": cannot be opened");
    read_file_header();
    index_records();
    if (records_.empty() || records_.front().kind() != RecordKind::Pipeline)
      throw IoError(path_ + ": the recording ends before its first record");
    read(records_.front(), [&](ByteReader& bytes) { transfer_head(bytes, pipeline_); });
    note_end();
  }

  const RecordedPipeline& pipeline() const { return pipeline_; }
  std::size_t calls() const { return calls_; }
  const std::vector<std::string>& notes() const { return notes_; }

  std::optional<RecordedEvent> next() {
    while (at_ < records_.size()) {
      const IndexedRecord& record = records_[at_++];
      RecordedEvent event;
      switch (record.kind()) {
        case RecordKind::Frame:
          read_frame(record, event);
          return event;
        case RecordKind::Pose:
          event.kind = RecordedEvent::Kind::Pose;
          read(record, [&](ByteReader& bytes) {
            bytes.number(event.pose_frame_id);
            transfer_pose(bytes, event.T_world_camera);
            transfer_choice(bytes, event.provenance, 4);
            transfer_tracking(bytes, event.tracking);
          });
          return event;
        case RecordKind::Reset:
          event.kind = RecordedEvent::Kind::Reset;
          return event;
        case RecordKind::Lost:
          event.kind = RecordedEvent::Kind::Lost;
          return event;
        default:
          break;  // images and verdicts belong to frames
      }
    }
    return std::nullopt;
  }

 private:
  bool get(void* to, std::size_t size) { return std::fread(to, 1, size, file_.get()) == size; }

  void read_file_header() {
    FileHeader header;
    const FileHeader expected;
    if (!get(&header, sizeof header) || std::memcmp(header.magic, expected.magic, sizeof header.magic) != 0)
      throw IoError(path_ + ": is no recording of dynfilter");
    if (header.version != kVersion)
      throw IoError(path_ + ": is a recording of format " + std::to_string(header.version) +
                    ", and this dynfilter reads format " + std::to_string(kVersion));
  }

  [[noreturn]] void fail(std::uint64_t offset, const std::string& why) const {
    throw IoError(path_ + ": the record at byte " + std::to_string(offset) + " is damaged: " + why);
  }

  void index_records() {
    std::uint64_t offset = sizeof(FileHeader);
    std::fseek(file_.get(), 0, SEEK_END);
    const long end = std::ftell(file_.get());
    const std::uint64_t size = end < 0 ? 0 : static_cast<std::uint64_t>(end);
    while (offset < size) {
      IndexedRecord record;
      std::fseek(file_.get(), static_cast<long>(offset), SEEK_SET);
      if (!get(&record.header, sizeof record.header)) break;
      const RecordHeader& h = record.header;
      if (h.check != h.own_check()) fail(offset, "its header's checksum differs");
      if (h.kind == 0 || h.kind > kRecordKinds) fail(offset, "its kind is not known");
      record.offset = offset + sizeof h;
      if (h.packed_bytes > size - record.offset) break;
      offset = record.offset + h.packed_bytes;
      add(record);
    }
    if (offset < size)
      notes_.push_back("the recording was cut off at byte " + std::to_string(offset) +
                       ": what was being written then is lost");
  }
  void add(const IndexedRecord& record) {
    calls_ += record.kind() == RecordKind::Frame ? 1 : 0;
    if (record.kind() == RecordKind::Images)
      images_.push_back(record);
    else
      records_.push_back(record);
  }

  void note_end() {
    if (records_.back().kind() != RecordKind::End) {
      notes_.emplace_back("the recording was not closed: the program ended without it");
      return;
    }
    std::string why;
    std::uint64_t left_out = 0;
    read(records_.back(), [&](ByteReader& bytes) { bytes.text(why), bytes.number(left_out); });
    if (why == "full") notes_.emplace_back("the recording was full and ended before the program did");
    if (left_out > 0)
      notes_.push_back("the images of " + std::to_string(left_out) + (left_out == 1 ? " call" : " calls") +
                       " were left out when recording");
  }

  const std::vector<char>& unpacked(const IndexedRecord& record) {
    constexpr std::uint64_t kMostExpansion = 255;  // of LZ4
    const RecordHeader& h = record.header;
    const std::uint64_t at = record.offset - sizeof h;
    if (h.raw_bytes > kMostExpansion * h.packed_bytes) fail(at, "its size cannot be");
    packed_.resize(h.packed_bytes);
    std::fseek(file_.get(), static_cast<long>(record.offset), SEEK_SET);
    if (!get(packed_.data(), packed_.size())) fail(at, "it cannot be read");
    raw_.resize(h.raw_bytes);
    try {
      unpacker_.unpack(packed_, raw_);
    } catch (const Error& error) {
      fail(at, error.what());
    }
    return raw_;
  }

  template <class Content>
  void read(const IndexedRecord& record, const Content& content) {
    ByteReader bytes(unpacked(record));
    try {
      content(bytes);
      bytes.finish();
    } catch (const Error& error) {
      fail(record.offset - sizeof(RecordHeader), error.what());
    }
  }

  /// Images are written later than the frame that has them first.
  void shelve_images(std::uint64_t call) {
    for (; images_at_ < images_.size() && images_[images_at_].header.call <= call; ++images_at_) {
      const IndexedRecord& record = images_[images_at_];
      try {
        shelf_.put(record.header.call, unpacked(record));
      } catch (const IoError&) {
        throw;
      } catch (const Error& error) {
        fail(record.offset - sizeof(RecordHeader), error.what());
      }
    }
  }

  void read_frame(const IndexedRecord& record, RecordedEvent& event) {
    const std::uint64_t call = record.header.call;
    shelve_images(call);
    shelf_.left_out = 0;
    read(record, [&](ByteReader& bytes) {
      transfer_choice(bytes, event.point, 3);
      std::int32_t min_features = 0;
      bytes.number(min_features);
      event.limits.min_features = min_features;
      transfer_frame(bytes, event.frame, shelf_);
    });
    event.frame.images_left_out = shelf_.left_out;
    if (at_ >= records_.size()) return;
    const IndexedRecord& verdict = records_[at_];
    if (verdict.kind() != RecordKind::Verdict || verdict.header.call != call) return;
    ++at_;
    event.verdict.emplace();
    read(verdict, [&](ByteReader& bytes) { transfer_verdict(bytes, *event.verdict); });
  }

  std::string path_;
  FilePtr file_;
  std::vector<IndexedRecord> records_, images_;
  std::size_t at_ = 0, images_at_ = 0, calls_ = 0;
  RecordedPipeline pipeline_;
  std::vector<std::string> notes_;
  detail::ImageShelf shelf_;
  std::vector<char> packed_, raw_;
  Unpacker unpacker_;
};

RecordingReader::RecordingReader(const std::filesystem::path& file) : impl_(std::make_unique<Impl>(file)) {}
RecordingReader::~RecordingReader() = default;
RecordingReader::RecordingReader(RecordingReader&&) noexcept = default;
RecordingReader& RecordingReader::operator=(RecordingReader&&) noexcept = default;

const RecordedPipeline& RecordingReader::pipeline() const {
  return impl_->pipeline();
}
std::size_t RecordingReader::calls() const {
  return impl_->calls();
}
const std::vector<std::string>& RecordingReader::notes() const {
  return impl_->notes();
}
std::optional<RecordedEvent> RecordingReader::next() {
  return impl_->next();
}

}  // namespace dynfilter::recorder
