// SPDX-License-Identifier: MIT
#include "evidence.hpp"

#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <dynfilter/geometry/rigid_motion.hpp>
#include <dynfilter/geometry/two_view_model.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bindings.hpp"

namespace dynfilter::python {

const Evidence& EvidenceLink::open() const {
  if (evidence == nullptr)
    throw std::runtime_error(
        "evidence and votes are of one frame: copy what you keep before apply() returns");
  return *evidence;
}

namespace {

struct PyEvidence {
  std::shared_ptr<EvidenceLink> link;
  const Evidence& get() const { return link->open(); }
  const FrameView& frame() const { return get().frame(); }
};

struct PyVotes {
  std::shared_ptr<EvidenceLink> link;
  Votes& get() const {
    link->open();
    return *link->votes;
  }
};

struct PyMatch {
  std::shared_ptr<EvidenceLink> link;
  const Match* match;
  const Match& get() const {
    link->open();
    return *match;
  }
};

struct PyTwoView {
  std::string kind, reason;
  py::array_t<double> F, H, distance_px;
};

py::array flags(Span<const std::uint8_t> values) {
  return py::array(py::dtype::of<bool>(), {static_cast<py::ssize_t>(values.size())}, {}, values.data());
}

py::array_t<double> matrix3(const std::array<double, 9>& values) {
  return py::array_t<double>({3, 3}, values.data());
}

py::object image(const PyEvidence& self, const cv::Mat& mat) {
  if (mat.empty()) return py::none();
  py::object array = self.link->images != nullptr ? self.link->images->array_of(mat) : py::object();
  if (!array) array = array_of(mat);
  py::array view = array.attr("view")();
  make_read_only(view);
  return std::move(view);
}

PyMatch match(const PyEvidence& self, int gap_frames, bool keyframe) {
  if (gap_frames < 1) throw py::value_error("gap_frames: expected at least 1");
  return {self.link, &self.get().match({keyframe, gap_frames})};
}

std::vector<int> seeds_of(const Evidence& evidence, const Match& match) {
  std::vector<int> seeds;
  evidence.collect_seeds(match, false, seeds);
  return seeds;
}

PyTwoView two_view(const PyEvidence& self, const PyMatch& match) {
  const Match& m = match.get();
  const TwoViewModel& model = self.get().two_view(m, seeds_of(self.get(), m));
  const std::vector<cv::Point2f>& now = self.get().undistorted_pixels();
  py::array_t<double> distance_px(static_cast<py::ssize_t>(now.size()));
  for (std::size_t i = 0; i < now.size(); ++i)
    distance_px.mutable_data()[i] = dynfilter::distance_px(model, m.reference_undistorted_px[i], now[i]);
  return {to_string(model.kind), to_string(model.reason), matrix3(model.F), matrix3(model.H), distance_px};
}

py::object rigid_motion(const PyEvidence& self, const PyMatch& match) {
  const Match& m = match.get();
  const RigidMotion& motion = self.get().rigid_motion(m, seeds_of(self.get(), m));
  return motion.ok ? py::object(matrix_of(motion.T_current_reference)) : py::object(py::none());
}

py::object host_motion(const PyEvidence& self, const PyMatch& match) {
  const std::optional<Pose> motion = self.get().host_motion(match.get());
  return motion ? py::object(matrix_of(*motion)) : py::object(py::none());
}

/// (n, max_length + 1, 2): undistorted pixels, [:, k] of k frames ago, NaN before the track began.
py::array tracks(const PyEvidence& self, int max_length) {
  if (max_length < 1) throw py::value_error("max_length: expected at least 1");
  TrackOptions options;
  options.max_length = max_length;
  const FeatureTracks& tracks = self.get().tracks(options);
  const py::ssize_t places = max_length + 1, n = static_cast<py::ssize_t>(tracks.size());
  py::array_t<float> out({n, places, py::ssize_t{2}});
  auto to = out.mutable_unchecked<3>();
  for (py::ssize_t i = 0; i < n; ++i)
    for (py::ssize_t k = 0; k < places; ++k) {
      const bool known = k <= tracks.length(static_cast<std::size_t>(i));
      const cv::Point2f p =
          known ? tracks.at(static_cast<std::size_t>(i), static_cast<int>(k)) : cv::Point2f(NAN, NAN);
      to(i, k, 0) = p.x, to(i, k, 1) = p.y;
    }
  return std::move(out);
}

py::object boxes(const PyEvidence& self) {
  if (!self.frame().detections) return py::none();
  py::list list;
  for (const Detection& d : self.frame().detections->detections) list.append(py::cast(d));
  return std::move(list);
}

py::object descriptors(const PyEvidence& self) {
  const cv::Mat& rows = self.frame().descriptors;
  return rows.empty() ? py::object(py::none()) : py::object(array_of(rows.clone()));
}

// ---- votes

/// Calls `use(i)` for each feature of a bool array, or of an array of indices.
template <class Use>
void for_each(const Votes& votes, py::handle where, const Use& use) {
  const auto n = static_cast<py::ssize_t>(votes.size());
  if (py::isinstance<py::array_t<bool>>(where)) {
    const auto flags = py::reinterpret_borrow<py::array_t<bool>>(where);
    if (flags.ndim() != 1 || flags.shape(0) != n) refuse("where", std::to_string(n) + " flags", where);
    for (py::ssize_t i = 0; i < n; ++i)
      if (flags.at(i)) use(static_cast<std::size_t>(i), i);
    return;
  }
  const auto indices = array_of<std::int64_t>("where", where, -1);
  for (py::ssize_t k = 0; k < indices.size(); ++k) {
    const std::int64_t i = indices.at(k);
    if (i < 0 || i >= n)
      throw py::value_error("where: index " + std::to_string(i) + " of " + std::to_string(n));
    use(static_cast<std::size_t>(i), k);
  }
}

/// One suspicion for all, one per feature, or one per index.
void cast(Votes& votes, Vote vote, py::handle where, py::handle suspicion) {
  if (suspicion.is_none())
    return for_each(votes, where, [&](std::size_t i, py::ssize_t) { votes.cast(i, vote); });
  if (py::isinstance<py::float_>(suspicion) || py::isinstance<py::int_>(suspicion)) {
    const auto value = suspicion.cast<float>();
    return for_each(votes, where, [&](std::size_t i, py::ssize_t) { votes.cast(i, vote, value); });
  }
  const bool flagged = py::isinstance<py::array_t<bool>>(where);
  const auto count = static_cast<py::ssize_t>(flagged ? votes.size() : py::len(where));
  const auto values = array_of<float>("suspicion", suspicion, count);
  for_each(votes, where, [&](std::size_t i, py::ssize_t k) { votes.cast(i, vote, values.at(k)); });
}

/// Dynamic beyond the limit, static within, unknown where the distance is NaN.
void by_distance(const PyVotes& self, py::handle distance, py::handle limit) {
  Votes& votes = self.get();
  const auto n = static_cast<py::ssize_t>(votes.size());
  const auto distances = array_of<double>("distance", distance, n);
  const bool one = py::isinstance<py::float_>(limit) || py::isinstance<py::int_>(limit);
  const auto limits = one ? py::array_t<double>() : array_of<double>("limit", limit, n);
  const double common = one ? limit.cast<double>() : 0;
  for (py::ssize_t i = 0; i < n; ++i) {
    const double d = distances.at(i), most = one ? common : limits.at(i);
    if (std::isnan(d) || std::isnan(most)) continue;
    votes.cast(static_cast<std::size_t>(i), d > most ? Vote::Dynamic : Vote::Static, suspicion(d, most));
  }
}

py::array decisions(const PyVotes& self) {
  const Span<const Vote> votes = self.get().votes();
  return py::array(py::dtype::of<std::uint8_t>(), {static_cast<py::ssize_t>(votes.size())}, {}, votes.data());
}

void bind_match(py::module_& module) {
  py::class_<PyMatch>(module, "Match", "Where the features were in an earlier frame.")
      .def_property_readonly(
          "found", [](const PyMatch& m) { return flags(m.get().correspondences.found); }, "(n,) bool")
      .def_property_readonly(
          "pixels", [](const PyMatch& m) { return copy_of(m.get().reference_undistorted_px); },
          "(n, 2) float32, undistorted pixels of the earlier frame; NaN: not found")
      .def_property_readonly(
          "distorted_pixels", [](const PyMatch& m) { return copy_of(m.get().correspondences.reference_px); },
          "(n, 2) float32")
      .def_property_readonly(
          "depths_m", [](const PyMatch& m) { return copy_of(m.get().reference_depth_m); },
          "(n,) float32 [m], in the earlier frame; NaN: none")
      .def_property_readonly(
          "points_m", [](const PyMatch& m) { return copy_of(m.get().reference_points_m); },
          "(n, 3) float32 [m], in the frame of the earlier camera; NaN: none")
      .def_property_readonly(
          "index", [](const PyMatch& m) { return copy_of(m.get().correspondences.reference_index); },
          "(n,) int32, feature of the earlier frame; -1: none (always for optical flow)")
      .def_property_readonly(
          "frame_id",
          [](const PyMatch& m) {
            const PastFrame* past = m.get().reference;
            return past == nullptr ? py::object(py::none()) : py::object(py::int_(past->id));
          },
          "id of the earlier frame; None: there is no such frame");
  py::class_<PyTwoView>(module, "TwoView", "A two-view model, fitted on features that no stage suspects.")
      .def_readonly("kind", &PyTwoView::kind, "fundamental, homography, rotation or none")
      .def_readonly("reason", &PyTwoView::reason, "why this kind was chosen")
      .def_readonly("F", &PyTwoView::F, "(3, 3): x_now F x_then = 0; zeros: no F")
      .def_readonly("H", &PyTwoView::H, "(3, 3): x_now ~ H x_then; zeros: no H")
      .def_readonly("distance_px", &PyTwoView::distance_px,
                    "(n,) float64: distance of each match from the model [px]; NaN: no match or no model");
}

void bind_votes(py::module_& module) {
  const auto cast_as = [](Vote vote) {
    return [vote](const PyVotes& self, py::handle where, py::handle suspicion) {
      cast(self.get(), vote, where, suspicion);
    };
  };
  py::class_<PyVotes>(module, "Votes", "One vote per feature. All are unknown at first, and unknown is kept.")
      .def("__len__", [](const PyVotes& self) { return self.get().size(); })
      .def("dynamic", cast_as(Vote::Dynamic), py::arg("where"), py::arg("suspicion") = py::none(),
           "`where`: (n,) bool, or indices. `suspicion`: in [0, 1], a number, or an array as long as "
           "`where`;\n"
           "1 without it. The floor restores the least suspicious features first.")
      .def("static", cast_as(Vote::Static), py::arg("where"), py::arg("suspicion") = py::none(),
           "As dynamic(); the suspicion is 0 without one.")
      .def(
          "by_distance", &by_distance, py::arg("distance"), py::arg("limit"),
          "Dynamic where the distance is above the limit, static where it is not, unknown where one is NaN.\n"
          "`distance`: (n,). `limit`: a number or (n,). Suspicion: distance / (distance + limit).")
      .def(
          "suspect",
          [](const PyVotes& self, py::handle where) {
            for_each(self.get(), where, [&](std::size_t i, py::ssize_t) { self.get().mark_prior(i); });
          },
          py::arg("where"), "Keeps features out of the fit of models; later stages may judge them strictly.")
      .def(
          "note", [](const PyVotes& self, const std::string& text) { self.get().note(text); },
          py::arg("text"), "A line for the report of this stage.")
      .def_property_readonly("decision", &decisions, "(n,) uint8: 0 unknown, 1 static, 2 dynamic; a copy");
}

}  // namespace

OpenEvidence::OpenEvidence(const Evidence& evidence, Votes& votes, const Images* images)
    : link_(std::make_shared<EvidenceLink>(EvidenceLink{&evidence, &votes, images})),
      evidence_(py::cast(PyEvidence{link_})),
      votes_(py::cast(PyVotes{link_})) {}

OpenEvidence::~OpenEvidence() {
  *link_ = EvidenceLink();
}

void bind_evidence(py::module_& module) {
  bind_match(module);
  bind_votes(module);
  using Self = PyEvidence;
  py::class_<Self>(
      module, "Evidence",
      "What a filter may know of the current frame. Arrays have one entry per feature and are "
      "copies;\nimages are read-only views. Measurements are computed at the first call, once per "
      "frame, for all filters.")
      .def("__len__", [](const Self& e) { return e.get().size(); })
      .def_property_readonly("frame_id", [](const Self& e) { return e.frame().id; })
      .def_property_readonly(
          "timestamp", [](const Self& e) { return e.frame().timestamp_s; }, "[s]")
      .def_property_readonly(
          "call_point", [](const Self& e) { return to_string(e.get().call_point()); },
          "before_pose, after_pose or at_keyframe")
      .def_property_readonly(
          "pixels", [](const Self& e) { return copy_of(e.get().pixels()); },
          "(n, 2) float32, distorted; NaN: in no image")
      .def_property_readonly(
          "undistorted_pixels", [](const Self& e) { return copy_of(e.get().undistorted_pixels()); },
          "(n, 2) float32")
      .def_property_readonly(
          "depths_m", [](const Self& e) { return copy_of(e.get().depths_m()); },
          "(n,) float32 [m] along the optical axis; NaN: none, or at a silhouette")
      .def_property_readonly(
          "points_m", [](const Self& e) { return copy_of(e.get().points_m()); },
          "(n, 3) float32 [m], in the frame of the camera; NaN: no depth")
      .def_property_readonly(
          "octaves",
          [](const Self& e) {
            const Span<const cv::KeyPoint> keypoints = e.frame().keypoints;
            py::array_t<std::int32_t> out(static_cast<py::ssize_t>(keypoints.size()));
            for (std::size_t i = 0; i < keypoints.size(); ++i) out.mutable_data()[i] = keypoints[i].octave;
            return out;
          },
          "(n,) int32")
      .def_property_readonly("descriptors", &descriptors, "(n, bytes) uint8, or None")
      .def_property_readonly(
          "grey", [](const Self& e) { return image(e, e.frame().grey); }, "(height, width) uint8, or None")
      .def_property_readonly(
          "depth", [](const Self& e) { return image(e, e.frame().depth); },
          "(height, width) float32 or uint16, in units of depth_unit_m; or None")
      .def_property_readonly("depth_unit_m", [](const Self& e) { return e.frame().depth_unit_m; })
      .def_property_readonly(
          "mask",
          [](const Self& e) { return e.frame().mask ? image(e, e.frame().mask->labels) : py::none(); },
          "(height, width) uint8, 0: background; or None")
      .def_property_readonly("boxes", &boxes, "list of Detection; None: no result came")
      .def_property_readonly("camera", [](const Self& e) { return e.frame().camera; })
      .def_property_readonly(
          "pose",
          [](const Self& e) {
            const bool known = e.frame().pose_provenance != PoseProvenance::None;
            return known ? py::object(matrix_of(e.frame().T_world_camera)) : py::object(py::none());
          },
          "(4, 4) T_world_camera, or None")
      .def_property_readonly(
          "judged", [](const Self& e) { return flags(e.get().judged()); },
          "(n,) bool: this stage judges the feature")
      .def_property_readonly(
          "prior", [](const Self& e) { return flags(e.get().prior()); },
          "(n,) bool: a semantic stage suspects the feature")
      .def_property_readonly(
          "seed", [](const Self& e) { return flags(e.get().seed()); },
          "(n,) bool: no stage suspects the feature, models may be fitted on it")
      .def_property_readonly(
          "called_dynamic", [](const Self& e) { return flags(e.get().called_dynamic()); },
          "(n,) bool: an earlier stage of the sequence rejected the feature")
      .def("match", &match, py::arg("gap_frames") = 1, py::kw_only(), py::arg("keyframe") = false,
           "Where the features were this many frames ago, or in the last keyframe.\n"
           "Give the class `history_frames` for more than one frame.")
      .def("two_view", &two_view, py::arg("match"), "The two-view model of a match.")
      .def("rigid_motion", &rigid_motion, py::arg("match"),
           "(4, 4) T_now_then of the camera, fitted on 3-D points; None: not determined.")
      .def("host_motion", &host_motion, py::arg("match"),
           "(4, 4) T_now_then of the camera from the host's poses; None: it gave none.")
      .def(
          "motion_prior",
          [](const Self& e, const PyMatch& match) { return e.get().motion_prior(match.get()); },
          py::arg("match"), "MotionPrior that the host gave, if it begins at the match's frame; or None.")
      .def("tracks", &tracks, py::arg("max_length"),
           "(n, max_length + 1, 2) float32: undistorted pixels, [:, k] is k frames ago; NaN: before the "
           "track.\n"
           "Ask for it in every frame.");
}

}  // namespace dynfilter::python
