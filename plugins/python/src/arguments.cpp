// SPDX-License-Identifier: MIT
#include "arguments.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <dynfilter/config/near_miss.hpp>
#include <limits>
#include <type_traits>

#include "keypoint_objects.hpp"

namespace dynfilter::python {
namespace {

std::string shape_text(const py::array& array) {
  return py::str(array.attr("shape")).cast<std::string>();
}

std::string described(py::handle value) {
  if (value.is_none()) return "None";
  if (py::isinstance<py::array>(value)) {
    const auto array = py::reinterpret_borrow<py::array>(value);
    return "an array of shape " + shape_text(array) + " and type " +
           py::str(array.dtype()).cast<std::string>();
  }
  return "a " + py::str(py::type::handle_of(value).attr("__name__")).cast<std::string>();
}

template <class T>
const char* kind_text() {
  if (std::is_same<T, std::uint8_t>::value) return "uint8";
  return std::is_floating_point<T>::value ? "numbers" : "integers";
}

template <class T>
bool kind_fits(char kind) {
  const bool integer = kind == 'i' || kind == 'u' || kind == 'b';
  return integer || (std::is_floating_point<T>::value && kind == 'f');
}

std::string shape_wanted(py::ssize_t rows, py::ssize_t columns) {
  const std::string n = rows < 0 ? "n" : std::to_string(rows);
  return columns == 0 ? "(" + n + ",)" : "(" + n + ", " + std::to_string(columns) + ")";
}

bool shape_fits(const py::array& array, py::ssize_t rows, py::ssize_t columns) {
  if (array.ndim() != (columns == 0 ? 1 : 2)) return false;
  return (rows < 0 || array.shape(0) == rows) && (columns == 0 || array.shape(1) == columns);
}

/// Integers of another type, none of which may change.
template <class T>
py::array_t<T> integers_of(const std::string& argument, const py::array& any, const std::string& wanted) {
  const auto wide = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>::ensure(any);
  if (!wide) throw py::error_already_set();
  const std::int64_t lowest = any.dtype().kind() == 'u' ? 0 : std::numeric_limits<T>::min();
  py::array_t<T> out(std::vector<py::ssize_t>(wide.shape(), wide.shape() + wide.ndim()));
  for (py::ssize_t i = 0; i < wide.size(); ++i) {
    const std::int64_t number = wide.data()[i];
    if (number < lowest || number > std::numeric_limits<T>::max())
      throw py::value_error(argument + ": expected " + wanted + " of at most " +
                            std::to_string(8 * sizeof(T)) + " bits, got one that is larger");
    out.mutable_data()[i] = static_cast<T>(number);
  }
  return out;
}

bool has_type(py::handle value, int depth) {
  if (depth == CV_8U) return py::isinstance<py::array_t<std::uint8_t>>(value);
  if (depth == CV_16U) return py::isinstance<py::array_t<std::uint16_t>>(value);
  return py::isinstance<py::array_t<float>>(value);
}

/// Objects with `__array__` as arrays, everything else as it is.
py::object as_array(const std::string& argument, py::handle value) {
  const bool converts = !py::isinstance<py::array>(value) && py::hasattr(value, "__array__");
  const py::array array = converts ? any_array(argument, value) : py::array();
  return converts && array ? py::object(array) : py::reinterpret_borrow<py::object>(value);
}

/// OpenCV wants the pixels of a row side by side.
bool rows_are_dense(const py::array& image, py::ssize_t channels) {
  const py::ssize_t pixel = image.itemsize() * channels;
  if (image.ndim() == 3 && image.strides(2) != image.itemsize()) return false;
  return image.strides(1) == pixel && image.strides(0) >= pixel * image.shape(1);
}

bool is_dense_keypoints(const py::array& array) {
  return array.dtype().kind() == 'V' && array.ndim() == 1 && array.dtype().equal(keypoint_type()) &&
         (array.flags() & py::array::c_style) != 0;
}

template <class Point, py::ssize_t kColumns>
py::array points_copied(const std::vector<Point>& points) {
  static_assert(sizeof(Point) == kColumns * sizeof(float), "points are dense");
  py::array_t<float> out({static_cast<py::ssize_t>(points.size()), kColumns});
  std::memcpy(out.mutable_data(), points.data(), points.size() * sizeof(Point));
  return std::move(out);
}

}  // namespace

std::string number_text(double number) {
  return py::str(py::float_(number)).cast<std::string>();
}

py::array any_array(const std::string& argument, py::handle value) {
  const py::array any = py::array::ensure(value);
  if (!any) {
    PyErr_Clear();
    return any;
  }
  const bool converted = !py::type::handle_of(value).is(py::type::handle_of(any));
  if (converted && py::hasattr(value, "mask") && py::hasattr(value, "filled"))
    refuse(argument, "an array without masked values (call .filled())", value);
  return any;
}

void refuse(const std::string& argument, const std::string& expected, py::handle got) {
  throw py::value_error(argument + ": expected " + expected + ", got " + described(got));
}

double number_of(const std::string& argument, py::handle value) {
  const double number = PyFloat_AsDouble(value.ptr());
  if (PyErr_Occurred() == nullptr) return number;
  PyErr_Clear();
  refuse(argument, "a number", value);
}

double positive_of(const std::string& argument, py::handle value) {
  const double number = number_of(argument, value);
  if (std::isfinite(number) && number > 0) return number;
  throw py::value_error(argument + ": expected a finite number above 0, got " + number_text(number));
}

void refuse_name(const std::string& argument, const std::vector<std::string>& known, const std::string& got) {
  throw py::value_error(argument + ": " + expected_one_of(known, got));
}

std::int64_t integer_of(const std::string& argument, py::handle value) {
  const auto index = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
  const std::int64_t number = index ? PyLong_AsLongLong(index.ptr()) : 0;
  if (PyErr_Occurred() == nullptr) return number;
  PyErr_Clear();
  refuse(argument, "an integer", value);
}

template <class T>
py::array_t<T> array_of(const std::string& argument, py::handle value, py::ssize_t rows,
                        py::ssize_t columns) {
  const std::string wanted = std::string(kind_text<T>()) + " of shape " + shape_wanted(rows, columns);
  const py::array any = any_array(argument, value);
  if (!any) refuse(argument, wanted, value);
  const bool empty = any.size() == 0 && rows <= 0;
  if (empty && (any.ndim() < 2 || columns == any.shape(1)))
    return py::array_t<T>(columns == 0 ? std::vector<py::ssize_t>{0} : std::vector<py::ssize_t>{0, columns});
  const bool exact = std::is_same<T, std::uint8_t>::value;
  const bool fits = exact ? has_type(any, CV_8U) : kind_fits<T>(any.dtype().kind());
  if (!fits || !shape_fits(any, rows, columns)) refuse(argument, wanted, any);
  if constexpr (std::is_integral_v<T>)
    if (!py::isinstance<py::array_t<T>>(any)) return integers_of<T>(argument, any, wanted);
  return py::array_t<T, py::array::c_style | py::array::forcecast>::ensure(any);
}

template py::array_t<float> array_of(const std::string&, py::handle, py::ssize_t, py::ssize_t);
template py::array_t<double> array_of(const std::string&, py::handle, py::ssize_t, py::ssize_t);
template py::array_t<std::int32_t> array_of(const std::string&, py::handle, py::ssize_t, py::ssize_t);
template py::array_t<std::int64_t> array_of(const std::string&, py::handle, py::ssize_t, py::ssize_t);
template py::array_t<std::uint8_t> array_of(const std::string&, py::handle, py::ssize_t, py::ssize_t);

// ---- images

cv::Mat Images::share(const std::string& argument, py::handle value, int depth, int most_channels,
                      const std::string& expected) {
  if (value.is_none()) return {};
  const py::object object = as_array(argument, value);
  if (!py::isinstance<py::array>(object) || !has_type(object, depth)) refuse(argument, expected, value);
  auto array = any_array(argument, object);
  const bool coloured = most_channels == 3 && array.ndim() == 3 && array.shape(2) == 3;
  if (!coloured && array.ndim() != 2) refuse(argument, expected, value);
  const int channels = coloured ? 3 : 1;
  if (!rows_are_dense(array, channels)) array = py::module_::import("numpy").attr("ascontiguousarray")(array);
  kept_.push_back(array);
  return {static_cast<int>(array.shape(0)), static_cast<int>(array.shape(1)), CV_MAKETYPE(depth, channels),
          const_cast<void*>(array.data()),  // NOLINT: nothing writes to a frame's images
          static_cast<std::size_t>(array.strides(0))};
}

cv::Mat Images::grey(const std::string& argument, py::handle value) {
  return share(argument, value, CV_8U, 1, "a uint8 image of shape (height, width)");
}

cv::Mat Images::colour(const std::string& argument, py::handle value) {
  return share(argument, value, CV_8U, 3, "a uint8 image of shape (height, width) or (height, width, 3)");
}

cv::Mat Images::mask(const std::string& argument, py::handle value) {
  const char* expected = "a uint8 or bool image of shape (height, width)";
  const py::object array = as_array(argument, value);
  if (!py::isinstance<py::array_t<bool>>(array)) return share(argument, array, CV_8U, 1, expected);
  const py::object bytes = array.attr("view")(py::dtype::of<std::uint8_t>());
  return share(argument, bytes, CV_8U, 1, expected);
}

cv::Mat Images::depth(const std::string& argument, py::handle value) {
  const py::object array = as_array(argument, value);
  const int depth = has_type(array, CV_32F) ? CV_32F : CV_16U;
  return share(argument, array, depth, 1, "a float32 or uint16 image of shape (height, width)");
}

py::object Images::array_of(const cv::Mat& image) const {
  for (const py::object& object : kept_) {
    const auto array = py::reinterpret_borrow<py::array>(object);
    if (array.data() == image.data && array.ndim() >= 2 && array.shape(0) == image.rows) return object;
  }
  return {};
}

// ---- keypoints

py::dtype keypoint_type() {
  static_assert(sizeof(cv::KeyPoint) == 28, "the layout below");
  static const auto* const type = [] {
    const char* const floats[] = {"x", "y", "size", "angle", "response"};
    py::list fields;
    for (const char* name : floats) fields.append(py::make_tuple(name, "<f4"));
    fields.append(py::make_tuple("octave", "<i4"));
    fields.append(py::make_tuple("class_id", "<i4"));
    return new py::dtype(py::dtype::from_args(fields));  // lives as long as the interpreter
  }();
  return *type;
}

void Keypoints::assign(const std::string& argument, py::handle value, py::handle octaves, py::ssize_t rows) {
  kept_ = py::object();
  const bool is_array = py::isinstance<py::array>(value);
  if (is_array && is_dense_keypoints(py::reinterpret_borrow<py::array>(value))) {
    const auto array = py::reinterpret_borrow<py::array>(value);
    kept_ = array;
    data_ = static_cast<const cv::KeyPoint*>(array.data());
    size_ = static_cast<std::size_t>(array.shape(0));
  } else {
    const bool objects = !is_array && py::isinstance<py::sequence>(value) && py::len(value) > 0 &&
                         py::hasattr(value[py::int_(0)], "pt");
    objects ? read_keypoint_objects(argument, value, own_) : from_points(argument, value, rows);
    data_ = own_.data();
    size_ = own_.size();
  }
  if (rows >= 0 && size_ != static_cast<std::size_t>(rows))
    refuse(argument, std::to_string(rows) + " keypoints", value);
  if (octaves.is_none()) return;
  const auto given = array_of<std::int32_t>("octaves", octaves, static_cast<py::ssize_t>(size_));
  if (data_ != own_.data()) own_.assign(data_, data_ + size_);
  for (std::size_t i = 0; i < size_; ++i) own_[i].octave = given.data()[i];
  data_ = own_.data();
}

void Keypoints::from_points(const std::string& argument, py::handle value, py::ssize_t rows) {
  const auto points = array_of<float>(argument, value, rows, 2);
  const auto n = static_cast<std::size_t>(points.shape(0));
  const float* p = points.data();
  own_.resize(n);
  for (std::size_t i = 0; i < n; ++i) own_[i] = cv::KeyPoint(p[2 * i], p[2 * i + 1], 1.0F);
}

// ---- small things

Pose pose_of(const std::string& argument, py::handle value) {
  const auto matrix = array_of<double>(argument, value, 4, 4);
  Pose pose;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column)
      pose.rotation[3 * row + column] = matrix.data()[4 * row + column];
    pose.translation_m[row] = matrix.data()[4 * row + 3];
  }
  if (!is_rigid(pose)) throw py::value_error(argument + ": expected a rigid motion, got another 4x4 matrix");
  return pose;
}

std::vector<Detection> detections_of(const std::string& argument, py::handle value) {
  const char* expected = "a list of dynfilter.Detection";
  if (!py::isinstance<py::sequence>(value) || py::isinstance<py::str>(value))
    refuse(argument, expected, value);
  std::vector<Detection> detections;
  for (const py::handle item : value) {
    if (!py::isinstance<Detection>(item)) refuse(argument, expected, item);
    detections.push_back(item.cast<const Detection&>());
  }
  return detections;
}

py::array matrix_of(const Pose& pose) {
  py::array_t<double> matrix({4, 4});
  double* m = matrix.mutable_data();
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) m[4 * row + column] = pose.rotation[3 * row + column];
    m[4 * row + 3] = pose.translation_m[row];
  }
  m[12] = m[13] = m[14] = 0, m[15] = 1;
  return std::move(matrix);
}

py::array array_of(const cv::Mat& image) {
  std::vector<py::ssize_t> shape{image.rows, image.cols};
  if (image.channels() > 1) shape.push_back(image.channels());
  py::dtype type = image.depth() == CV_8U    ? py::dtype::of<std::uint8_t>()
                   : image.depth() == CV_16U ? py::dtype::of<std::uint16_t>()
                                             : py::dtype::of<float>();
  std::vector<py::ssize_t> strides{static_cast<py::ssize_t>(image.step[0]),
                                   static_cast<py::ssize_t>(image.elemSize())};
  if (image.channels() > 1) strides.push_back(static_cast<py::ssize_t>(image.elemSize1()));
  if (image.u == nullptr) return py::array(type, shape, strides, image.data);
  const py::capsule owner(new cv::Mat(image), [](void* mat) { delete static_cast<cv::Mat*>(mat); });
  return py::array(type, shape, strides, image.data, owner);
}

py::array copy_of(const std::vector<cv::Point2f>& points) {
  return points_copied<cv::Point2f, 2>(points);
}
py::array copy_of(const std::vector<cv::Point3f>& points) {
  return points_copied<cv::Point3f, 3>(points);
}

py::array points_of(const cv::KeyPoint* keypoints, std::size_t n) {
  py::array_t<float> out({static_cast<py::ssize_t>(n), py::ssize_t{2}});
  float* p = out.mutable_data();
  for (std::size_t i = 0; i < n; ++i) p[2 * i] = keypoints[i].pt.x, p[2 * i + 1] = keypoints[i].pt.y;
  return std::move(out);
}

py::array shown(py::dtype type, const void* data, std::size_t n, py::handle owner) {
  py::array array(std::move(type), {static_cast<py::ssize_t>(n)}, {}, data, owner);
  make_read_only(array);
  return array;
}

void make_read_only(py::array& array) {
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
}

}  // namespace dynfilter::python
