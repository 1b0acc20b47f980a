// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <dynfilter/core/random.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/camera_model.hpp"
#include "render/camera_path.hpp"
#include "render/car.hpp"
#include "render/cart.hpp"
#include "render/furniture.hpp"
#include "render/mesh.hpp"
#include "render/motion.hpp"
#include "render/room.hpp"
#include "render/skeleton.hpp"
#include "render/texture.hpp"

namespace dynfilter::render {

/// Rigid part of a mover with its own label. A person and a carried box are two movers.
struct MoverPart {
  Model model;
  std::uint8_t label;
  bool person;
};

struct Mover {
  std::vector<MoverPart> parts;
  std::shared_ptr<const Animation> animation;  ///< one pose per part
};

/// Everything that a sequence is rendered from.
struct Scene {
  MaterialSet materials;
  std::optional<Surroundings> surroundings;
  std::vector<Mover> movers;
  std::vector<Detectable> objects;  ///< entry i is instance i + 1
  std::optional<CameraMotion> camera;
  /// Of its camera, unless the options replace them; 0: no motion blur, no rolling shutter.
  double exposure_ms = 0, readout_ms = 0;
  CameraModel camera_model;
};

/// Adds movers to a scene. Used by the scripts below.
class SceneBuilder {
 public:
  SceneBuilder(Scene& scene, std::uint64_t seed) : scene_(scene), random_(seed, 0x5C) {}

  double start_s = kAlways;  ///< time at which the movers begin to move
  CameraMotion::Options camera;
  std::vector<Eigen::Vector3f> chairs;  ///< x, y, yaw of chairs for sitting people
  RoomLook look = RoomLook::Furnished;
  double exposure_ms = 0, readout_ms = 0;
  CameraModel camera_model;
  /// Makes what does not move, with instances from `first_instance` + 1; empty: the office.
  std::function<Surroundings(MaterialSet&, Random&, int first_instance)> surroundings;

  using Points = std::vector<Eigen::Vector2d>;

  /// An oval path, counter-clockwise, centred at `middle`.
  static Points oval(const Eigen::Vector2d& middle, double half_x, double half_y);

  std::shared_ptr<const Walking> walker(const Points& points, double speed_mps, double offset_share,
                                        bool carries_box = false);

  void gesturer(const Eigen::Vector2d& place, double yaw_rad, bool sits, double liveliness = 1);

  void rolling_cart(const Points& points, double speed_mps, double offset_share, float wide_m, float high_m);

  void sliding(Model model, Sliding::Options options);

  /// A car, seldom a van, of a colour of its own.
  void car(std::shared_ptr<const Driving> driving);
  void bus(std::shared_ptr<const Driving> driving);

  Model cart_model(float wide_m, float high_m) { return cargo_cart(cargo(), wide_m, high_m, random_); }
  Model box_model(const Eigen::Vector3f& size) { return cargo_box(cargo(), size, random_); }
  Random& random() { return random_; }

 private:
  BodyShape somebody();

  std::uint8_t next_label() { return ++labels_; }

  const CargoMaterials& cargo();

  Mover person(const BodyShape& shape);

  void thing(Model model, std::shared_ptr<const Animation> animation);

  Scene& scene_;
  Random random_;
  std::uint8_t labels_ = 0;
  std::optional<CargoMaterials> cargo_;
  std::vector<CarPaint> paints_;
};

/// Scripts: positions of people, and motion of the camera.
namespace script {

using Builder = SceneBuilder;

/// Three people walk past the camera, one of them optionally with a box.
/// A fourth walks behind the desks.
void walkers(Builder& b, bool with_box);

void static_desk(Builder& b);

void walking(Builder& b, CameraStyle style);

constexpr double kIndoorExposure_ms = 12;

/// A hand-held camera near the desks in a static scene.
void turn_at_desk(Builder& b, double peak_deg_s);

/// The same one metre from the desk, as in freiburg1_rpy: near objects and many depth steps.
void near_turn(Builder& b, double peak_deg_s);

void walking_turn(Builder& b, double peak_deg_s);

/// Long straight edges and few corners, and nothing moves: joints, panels, blinds.
void static_edges(Builder& b);

/// A shaken camera with a rolling shutter near a desk, where nothing moves.
void static_jerk(Builder& b);

void shake(Builder& b);

void walking_shake(Builder& b);

/// A camera on a tripod. People walk close by and fill more than half of the view.
void standing_camera(Builder& b);

void sitting_static(Builder& b);

void moving_box(Builder& b);

void along_epipolar(Builder& b);

void person_tracking(Builder& b);

void crowd(Builder& b);

/// Three people walk in step on parallel paths.
void synchronous(Builder& b);

/// People and carts fill most of the view, and nearly all move in one direction.
void majority(Builder& b);

/// Plain walls and furniture. One person walks in front of the camera, one behind the desks.
void low_texture(Builder& b);

struct Entry {
  const char* name;
  std::function<void(Builder&)> run;
};

const std::vector<Entry>& all();

}  // namespace script

/// Names that make_scene() accepts.
std::vector<std::string> scene_names();

/// Throws ConfigError for an unknown name.
Scene make_scene(const std::string& name, std::uint64_t seed);

}  // namespace dynfilter::render
