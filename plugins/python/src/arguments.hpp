// SPDX-License-Identifier: MIT
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/pose.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <vector>

/// Python values as the toolkit's types. Every function raises ValueError with the argument's name for a
/// value of another shape or type.
namespace dynfilter::python {

namespace py = pybind11;

/// Raises ValueError "keypoints: expected ..., got an array of shape (3, 4) and type float64".
[[noreturn]] void refuse(const std::string& argument, const std::string& expected, py::handle got);

std::string number_text(double number);

/// The value as an array; null: it is none. Objects with `__array__` are converted, such as tensors and
/// pictures.
py::array any_array(const std::string& argument, py::handle value);

double number_of(const std::string& argument, py::handle value);
/// A finite number above 0.
double positive_of(const std::string& argument, py::handle value);
std::int64_t integer_of(const std::string& argument, py::handle value);

/// Raises ValueError "sensor: expected one of rgbd, mono, got `rgb` (did you mean `rgbd`?)".
[[noreturn]] void refuse_name(const std::string& argument, const std::vector<std::string>& known,
                              const std::string& got);

/// Numbers of any type that Python converts to T without loss of meaning: no fractions to integers.
/// `columns` 0: shape (n,), else (n, columns). `rows` < 0: any number of rows. Copies only if layout or type
/// differ.
template <class T>
py::array_t<T> array_of(const std::string& argument, py::handle value, py::ssize_t rows,
                        py::ssize_t columns = 0);

extern template py::array_t<float> array_of(const std::string&, py::handle, py::ssize_t, py::ssize_t);
extern template py::array_t<double> array_of(const std::string&, py::handle, py::ssize_t, py::ssize_t);
extern template py::array_t<std::int32_t> array_of(const std::string&, py::handle, py::ssize_t, py::ssize_t);
extern template py::array_t<std::int64_t> array_of(const std::string&, py::handle, py::ssize_t, py::ssize_t);
extern template py::array_t<std::uint8_t> array_of(const std::string&, py::handle, py::ssize_t, py::ssize_t);

/// Images that share the memory of an array. The arrays are alive while this object is, or until clear().
class Images {
 public:
  /// uint8 of shape (h, w). None: an empty image.
  cv::Mat grey(const std::string& argument, py::handle value);
  /// uint8 of shape (h, w) or (h, w, 3).
  cv::Mat colour(const std::string& argument, py::handle value);
  /// uint8 or bool of shape (h, w).
  cv::Mat mask(const std::string& argument, py::handle value);
  /// uint16 or float32 of shape (h, w).
  cv::Mat depth(const std::string& argument, py::handle value);
  /// The array that an image shares its memory with; null: none.
  py::object array_of(const cv::Mat& image) const;
  void clear() { kept_.clear(); }

 private:
  cv::Mat share(const std::string& argument, py::handle value, int depth, int most_channels,
                const std::string& expected);

  std::vector<py::object> kept_;
};

/// Keypoints of any accepted form: an (n, 2) array, a structured array of `keypoint_type()`, which is not
/// copied, or a sequence of cv2.KeyPoint.
class Keypoints {
 public:
  /// `octaves`: (n,) integers or None. `rows` < 0: any number.
  void assign(const std::string& argument, py::handle value, py::handle octaves, py::ssize_t rows = -1);
  const cv::KeyPoint* data() const { return data_; }
  std::size_t size() const { return size_; }

 private:
  void from_points(const std::string& argument, py::handle value, py::ssize_t rows);

  std::vector<cv::KeyPoint> own_;
  py::object kept_;
  const cv::KeyPoint* data_ = nullptr;
  std::size_t size_ = 0;
};

/// The layout of cv::KeyPoint: x, y, size, angle, response (float32), octave, class_id (int32).
py::dtype keypoint_type();

Pose pose_of(const std::string& argument, py::handle value);  ///< from a (4, 4) matrix
/// The camera unchanged if it is one of a real image. Focal lengths and principal point are above 0, the
/// latter inside the image if its size is known.
const Camera& checked_camera(const std::string& argument, const Camera& camera);
/// A dynfilter.Camera or an upper triangular (3, 3) matrix without skew.
Camera camera_of(const std::string& argument, py::handle value);
/// Zero, four or five finite numbers k1 k2 p1 p2 k3, also of shape (1, n) or (n, 1) as OpenCV returns them.
std::array<double, 5> distortion_of(const std::string& argument, py::handle value);
/// A dynfilter.MotionPrior or None.
std::optional<MotionPrior> motion_prior_of(const std::string& argument, py::handle value);
std::vector<Detection> detections_of(const std::string& argument, py::handle value);

// ---- the other way
py::array matrix_of(const Pose& pose);  ///< (4, 4) float64
/// An array that owns what it shows: a reference to the image's memory, or a copy if the image does not own
/// it.
py::array array_of(const cv::Mat& image);
template <class T>
py::array_t<T> copy_of(const std::vector<T>& values) {
  return py::array_t<T>(static_cast<py::ssize_t>(values.size()), values.data());
}
py::array copy_of(const std::vector<cv::Point2f>& points);          ///< (n, 2)
py::array copy_of(const std::vector<cv::Point3f>& points);          ///< (n, 3)
py::array points_of(const cv::KeyPoint* keypoints, std::size_t n);  ///< (n, 2)
/// Read-only, shares the memory of a member of `owner`.
py::array shown(py::dtype type, const void* data, std::size_t n, py::handle owner);
void make_read_only(py::array& array);

}  // namespace dynfilter::python
