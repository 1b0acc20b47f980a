// SPDX-License-Identifier: MIT
#include "keypoint_objects.hpp"

#include <cstring>

#include "arguments.hpp"

namespace dynfilter::python {
namespace {

/// An attribute of many objects of one class, looked up once. cv2.KeyPoint has C descriptors.
class Getter {
 public:
  Getter(const char* name, py::handle first) : name_(name), type_(Py_TYPE(first.ptr())) {
    descriptor_ = py::getattr(py::type::handle_of(first), name, py::none());
    get_ = descriptor_.is_none() ? nullptr : Py_TYPE(descriptor_.ptr())->tp_descr_get;
  }
  /// A new reference; null with a Python error.
  PyObject* operator()(PyObject* object) const {
    if (get_ == nullptr || Py_TYPE(object) != type_) return PyObject_GetAttrString(object, name_);
    return get_(descriptor_.ptr(), object, reinterpret_cast<PyObject*>(type_));
  }

 private:
  const char* name_;
  PyTypeObject* type_;
  py::object descriptor_;
  descrgetfunc get_;
};

/// The cv::KeyPoint right behind the head of an object.
cv::KeyPoint inside(PyObject* object) {
  cv::KeyPoint keypoint;
  std::memcpy(static_cast<void*>(&keypoint), reinterpret_cast<const char*>(object) + sizeof(PyObject),
              sizeof keypoint);
  return keypoint;
}

bool equal(const cv::KeyPoint& a, const cv::KeyPoint& b) {
  return a.pt == b.pt && a.size == b.size && a.angle == b.angle && a.response == b.response &&
         a.octave == b.octave && a.class_id == b.class_id;
}

/// Whether objects of the class hold a cv::KeyPoint, as those of OpenCV's module do. One object with known
/// values shows it.
bool holds_keypoint(PyTypeObject* type) {
  const bool large_enough =
      type->tp_basicsize >= static_cast<py::ssize_t>(sizeof(PyObject) + sizeof(cv::KeyPoint));
  if (std::strcmp(type->tp_name, "cv2.KeyPoint") != 0 || !large_enough) return false;
  const cv::KeyPoint known(1.5F, -2.25F, 3.5F, 4.75F, 5.125F, 6, 7);
  const auto object = py::reinterpret_steal<py::object>(PyObject_CallFunction(
      reinterpret_cast<PyObject*>(type), "dddddii", 1.5, -2.25, 3.5, 4.75, 5.125, 6, 7));
  if (object) return Py_TYPE(object.ptr()) == type && equal(inside(object.ptr()), known);
  PyErr_Clear();
  return false;
}

/// The class whose objects are read directly; null: not met yet. Guarded by the GIL.
PyTypeObject* readable_type(PyTypeObject* type) {
  static PyTypeObject* known = nullptr;
  if (known == nullptr && holds_keypoint(type)) {
    Py_INCREF(type);  // it lives as long as the interpreter
    known = type;
  }
  return known;
}

}  // namespace

void read_keypoint_objects(const std::string& argument, py::handle objects, std::vector<cv::KeyPoint>& out) {
  const auto list = py::reinterpret_steal<py::object>(PySequence_Fast(objects.ptr(), ""));
  if (!list) throw py::error_already_set();
  const auto n = static_cast<std::size_t>(PySequence_Fast_GET_SIZE(list.ptr()));
  out.resize(n);
  if (n == 0) return;
  PyObject** const items = PySequence_Fast_ITEMS(list.ptr());
  const PyTypeObject* const readable = readable_type(Py_TYPE(items[0]));
  const Getter get_pt("pt", items[0]), get_octave("octave", items[0]);
  for (std::size_t i = 0; i < n; ++i) {
    if (Py_TYPE(items[i]) == readable) {
      const cv::KeyPoint keypoint = inside(items[i]);
      out[i] = cv::KeyPoint(keypoint.pt, 1.0F, -1, 0, keypoint.octave);
      continue;
    }
    const auto pt = py::reinterpret_steal<py::object>(get_pt(items[i]));
    const auto octave = py::reinterpret_steal<py::object>(get_octave(items[i]));
    if (!pt || !octave || !PyTuple_Check(pt.ptr()) || PyTuple_GET_SIZE(pt.ptr()) != 2) {
      PyErr_Clear();
      refuse(argument, "only objects of cv2.KeyPoint in the list", items[i]);
    }
    out[i] = cv::KeyPoint(static_cast<float>(PyFloat_AsDouble(PyTuple_GET_ITEM(pt.ptr(), 0))),
                          static_cast<float>(PyFloat_AsDouble(PyTuple_GET_ITEM(pt.ptr(), 1))), 1.0F, -1, 0,
                          static_cast<int>(PyLong_AsLong(octave.ptr())));
    if (PyErr_Occurred() != nullptr) throw py::error_already_set();
  }
}

}  // namespace dynfilter::python
