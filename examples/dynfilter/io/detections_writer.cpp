// SPDX-License-Identifier: MIT
#include "io/detections_writer.hpp"

#include <iomanip>
#include <ostream>

#include "io/atomic_file.hpp"

namespace dynfilter::io {

void write_detections(const std::filesystem::path& path, const std::vector<StampedDetections>& images) {
  write_file_atomically(path, [&](std::ostream& out) {
    out << "# timestamp class_id class_name score x1 y1 x2 y2\n" << std::fixed;
    for (const StampedDetections& image : images) {
      const auto stamp = [&]() -> std::ostream& { return out << std::setprecision(6) << image.timestamp_s; };
      if (image.detections.empty()) stamp() << " none\n";
      for (const Detection& d : image.detections)
        stamp() << ' ' << d.class_id << ' ' << (d.class_name.empty() ? "object" : d.class_name)
                << std::setprecision(4) << ' ' << d.score << std::setprecision(3) << ' ' << d.box.x << ' '
                << d.box.y << ' ' << d.box.x + d.box.width << ' ' << d.box.y + d.box.height << '\n';
    }
  });
}

}  // namespace dynfilter::io
