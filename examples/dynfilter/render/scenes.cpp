// SPDX-License-Identifier: MIT
#include "render/scenes.hpp"

#include <cmath>
#include <cstddef>
#include <dynfilter/config/near_miss.hpp>
#include <dynfilter/core/error.hpp>
#include <utility>

#include "render/person.hpp"
#include "render/person_materials.hpp"
#include "render/road_scripts.hpp"
#include "render/walk_path.hpp"

namespace dynfilter::render {

SceneBuilder::Points SceneBuilder::oval(const Eigen::Vector2d& middle, double half_x, double half_y) {
  return {middle + Eigen::Vector2d(-half_x, 0), middle + Eigen::Vector2d(-0.72 * half_x, -half_y),
          middle + Eigen::Vector2d(0, -half_y), middle + Eigen::Vector2d(0.72 * half_x, -half_y),
          middle + Eigen::Vector2d(half_x, 0),  middle + Eigen::Vector2d(0.72 * half_x, half_y),
          middle + Eigen::Vector2d(0, half_y),  middle + Eigen::Vector2d(-0.72 * half_x, half_y)};
}

std::shared_ptr<const Walking> SceneBuilder::walker(const Points& points, double speed_mps,
                                                    double offset_share, bool carries_box) {
  const BodyShape shape = somebody();
  Walking::Options options;
  const WalkPath path(points);
  options.speed_mps = speed_mps;
  options.offset_m = offset_share * path.length_m();
  options.start_s = start_s;
  options.carries_box = carries_box;
  Mover mover = person(shape);
  if (carries_box)
    mover.parts.push_back({cargo_box(cargo(), {0.4F, 0.3F, 0.3F}, random_), next_label(), false});
  auto animation = std::make_shared<const Walking>(shape, path, options);
  mover.animation = animation;
  scene_.movers.push_back(std::move(mover));
  return animation;
}

void SceneBuilder::gesturer(const Eigen::Vector2d& place, double yaw_rad, bool sits, double liveliness) {
  const BodyShape shape = somebody();
  Gesturing::Options options;
  options.place = place;
  options.yaw_rad = yaw_rad;
  options.sits = sits;
  options.liveliness = liveliness;
  options.start_s = start_s;
  options.tempo = random_.uniform(0.9, 1.15);
  options.offset_s = random_.uniform(0, 9);
  Mover mover = person(shape);
  mover.animation = std::make_shared<const Gesturing>(shape, options);
  scene_.movers.push_back(std::move(mover));
  // A chair faces -y at yaw 0, a person +y.
  if (sits)
    chairs.push_back(
        {static_cast<float>(place.x()), static_cast<float>(place.y()), static_cast<float>(yaw_rad + M_PI)});
}

void SceneBuilder::rolling_cart(const Points& points, double speed_mps, double offset_share, float wide_m,
                                float high_m) {
  const WalkPath path(points);
  thing(cargo_cart(cargo(), wide_m, high_m, random_),
        std::make_shared<const Rolling>(path, speed_mps, offset_share * path.length_m(), start_s));
}

void SceneBuilder::sliding(Model model, Sliding::Options options) {
  options.start_s = start_s;
  thing(std::move(model), std::make_shared<const Sliding>(options));
}

void SceneBuilder::car(std::shared_ptr<const Driving> driving) {
  constexpr std::size_t kPaints = 6;  // several cars share one
  if (paints_.size() < kPaints) paints_.emplace_back(scene_.materials, random_);
  const CarPaint paint = paints_[static_cast<std::size_t>(random_.below(static_cast<int>(paints_.size())))];
  const CarKind kind = random_.chance(0.25)  ? CarKind::Van
                       : random_.chance(0.5) ? CarKind::Saloon
                                             : CarKind::Hatchback;
  scene_.objects.push_back({2, "car"});
  thing(car_model(paint, kind, static_cast<int>(scene_.objects.size())), std::move(driving));
}

void SceneBuilder::bus(std::shared_ptr<const Driving> driving) {
  scene_.objects.push_back({5, "bus"});
  thing(bus_model(scene_.materials, random_, static_cast<int>(scene_.objects.size())), std::move(driving));
}

inline BodyShape SceneBuilder::somebody() {
  BodyShape shape;
  shape.scale = random_.uniform(0.95, 1.07);
  return shape;
}

const CargoMaterials& SceneBuilder::cargo() {
  if (!cargo_) cargo_.emplace(scene_.materials, random_);
  return *cargo_;
}

Mover SceneBuilder::person(const BodyShape& shape) {
  scene_.objects.push_back({0, "person"});
  const Outfit outfit(scene_.materials, random_);
  Mover mover;
  const std::uint8_t label = next_label();
  for (Model& part : PersonBuilder(shape, outfit, static_cast<int>(scene_.objects.size())).build()) {
    mover.parts.push_back({std::move(part), label, true});
  }
  return mover;
}

inline void SceneBuilder::thing(Model model, std::shared_ptr<const Animation> animation) {
  Mover mover;
  mover.parts.push_back({std::move(model), next_label(), false});
  mover.animation = std::move(animation);
  scene_.movers.push_back(std::move(mover));
}

namespace script {

void walkers(Builder& b, bool with_box) {
  const double shift = b.random().uniform();
  b.walker(Builder::oval({-0.05, -0.7}, 0.95, 0.26), 1.0, shift, with_box);
  b.walker(Builder::oval({0.1, -0.72}, 0.9, 0.25), 0.85, shift + 0.36);
  b.walker(Builder::oval({0, -0.3}, 1.15, 0.25), 0.95, shift + 0.65);
  b.walker(Builder::oval({0, 1.42}, 1.9, 0.12), 0.8, shift);
}

void static_desk(Builder& b) {
  b.camera.style = CameraStyle::Xyz;
  b.camera.eye_m = {0.1, -1.15, 1.5};
  b.camera.target_m = {0, 0.85, 0.8};
}

void walking(Builder& b, CameraStyle style) {
  b.camera.style = style;
  walkers(b, style == CameraStyle::Static);
}

void turn_at_desk(Builder& b, double peak_deg_s) {
  static_desk(b);
  b.camera.style = CameraStyle::Turn;
  b.camera.peak_deg_s = peak_deg_s;
  b.exposure_ms = kIndoorExposure_ms;
}

void near_turn(Builder& b, double peak_deg_s) {
  turn_at_desk(b, peak_deg_s);
  b.camera.eye_m = {0.15, -0.15, 1.35};
  b.camera.target_m = {0.05, 0.85, 0.85};
}

void walking_turn(Builder& b, double peak_deg_s) {
  walking(b, CameraStyle::Turn);
  b.camera.peak_deg_s = peak_deg_s;
  b.exposure_ms = kIndoorExposure_ms;
}

void static_edges(Builder& b) {
  static_desk(b);
  b.look = RoomLook::Edges;
}

void static_jerk(Builder& b) {
  constexpr double kReadout_ms = 30;  // of a colour camera of 2010
  near_turn(b, 0);
  b.camera.style = CameraStyle::Shake;
  b.readout_ms = kReadout_ms;
}

void shake(Builder& b) {
  static_desk(b);
  b.camera.style = CameraStyle::Shake;
  b.exposure_ms = kIndoorExposure_ms;
}

void walking_shake(Builder& b) {
  walking(b, CameraStyle::Shake);
  b.exposure_ms = kIndoorExposure_ms;
}

void standing_camera(Builder& b) {
  b.camera.style = CameraStyle::Tripod;
  b.camera.eye_m = {0, -2.15, 1.4};
  const double shift = b.random().uniform();
  b.walker(Builder::oval({-0.4, -0.95}, 0.55, 0.2), 0.9, shift);
  b.walker(Builder::oval({0.4, -0.9}, 0.55, 0.2), 0.8, shift + 0.3);
  b.walker(Builder::oval({0.0, -0.85}, 0.8, 0.22), 0.85, shift + 0.75);
  b.walker(Builder::oval({0.0, -0.4}, 0.95, 0.22), 1.0, shift + 0.55);
  b.walker(Builder::oval({0.1, -0.15}, 1.1, 0.22), 0.9, shift + 0.1);
  b.walker(Builder::oval({-0.1, -0.15}, 1.1, 0.22), 0.9, shift + 0.6);
}

void sitting_static(Builder& b) {
  b.gesturer({-0.72, -0.25}, -0.9, true);
  b.gesturer({0.75, -0.2}, 0.8, true);
  b.camera.eye_m = {0, -2.15, 1.4};
}

void moving_box(Builder& b) {
  b.camera.style = CameraStyle::Xyz;
  b.rolling_cart(Builder::oval({0, -0.45}, 0.85, 0.25), 0.6, b.random().uniform(), 1.0F, 1.35F);
  Sliding::Options slide;
  slide.middle = {0.1, 0.42, 0.9};
  slide.swing_m = {0.75, 0, 0};
  slide.offset_s = b.random().uniform(0, 4);
  b.sliding(b.box_model({0.36F, 0.26F, 0.3F}), slide);
}

void along_epipolar(Builder& b) {
  b.camera.style = CameraStyle::Sideways;
  b.camera.target_m = {0, 0.8, 1.1};
  Sliding::Options slide;
  slide.middle = {0, -0.4, 0};
  slide.swing_m = {0.7, 0, 0};
  slide.period_s = 5.3;
  slide.offset_s = b.random().uniform(0, 5);
  b.sliding(b.cart_model(1.05F, 1.45F), slide);
  slide.middle = {0.2, 1.4, 0.0};
  slide.swing_m = {1.2, 0, 0};
  slide.period_s = 6.1;
  b.sliding(b.cart_model(0.8F, 1.6F), slide);
}

void person_tracking(Builder& b) {
  b.camera.tracked = b.walker({{-1.4, -0.6}, {0, -0.2}, {1.3, -0.5}, {1.5, -1.1}, {0.3, -0.9}, {-1.2, -1.2}},
                              0.85, b.random().uniform(), true);
  b.camera.style = CameraStyle::Tracking;
  b.camera.eye_m = {0.1, -2.4, 1.45};
  b.camera.target_m = {0.1, -0.75, 1.1};
}

void crowd(Builder& b) {
  b.camera.style = CameraStyle::Xyz;
  walkers(b, true);
  b.walker(Builder::oval({-0.3, -0.1}, 1.4, 0.22), 1.15, b.random().uniform());
  b.gesturer({1.75, -0.05}, 0.9, false);
}

void synchronous(Builder& b) {
  b.camera.style = CameraStyle::Xyz;
  const double speed = b.random().uniform(0.75, 0.95), share = b.random().uniform(0.3, 0.5);
  for (const Eigen::Vector2d& at :
       {Eigen::Vector2d(-0.8, -0.55), Eigen::Vector2d(0.05, -0.4), Eigen::Vector2d(0.85, -0.6)}) {
    b.walker(Builder::oval(at, 0.75, 0.2), speed, share);
  }
}

void majority(Builder& b) {
  b.camera.style = CameraStyle::Xyz;
  b.camera.eye_m = {0, -2.75, 1.4};
  Sliding::Options slide;
  slide.swing_m = {0.42, 0.05, 0};
  slide.period_s = 4.6;
  slide.middle = {-0.7, -0.55, 0};
  b.sliding(b.cart_model(1.15F, 1.55F), slide);
  slide.middle = {0.7, -0.55, 0};
  b.sliding(b.cart_model(1.15F, 1.45F), slide);
  b.walker(Builder::oval({-0.55, -1.05}, 0.5, 0.12), 0.8, 0.4);
  b.walker(Builder::oval({0.6, -1.08}, 0.5, 0.12), 0.8, 0.4);
}

void low_texture(Builder& b) {
  b.look = RoomLook::Plain;
  b.camera.style = CameraStyle::Xyz;
  const double shift = b.random().uniform();
  b.walker(Builder::oval({0, -0.45}, 1.15, 0.26), 0.95, shift);
  b.walker(Builder::oval({0, 1.42}, 1.9, 0.12), 0.8, shift);
}

const std::vector<Entry>& all() {
  constexpr double kHalfSecond = 0.5;  // 15 frames
  static const std::vector<Entry> entries{
      {"static_desk", static_desk},
      {"static_edges", static_edges},
      {"static_jerk", static_jerk},
      {"walking_xyz", [](Builder& b) { walking(b, CameraStyle::Xyz); }},
      {"walking_static", [](Builder& b) { walking(b, CameraStyle::Static); }},
      {"walking_rpy", [](Builder& b) { walking(b, CameraStyle::Rpy); }},
      {"walking_halfsphere", [](Builder& b) { walking(b, CameraStyle::Halfsphere); }},
      {"sitting_static", sitting_static},
      {"moving_box", moving_box},
      {"along_epipolar", along_epipolar},
      {"person_tracking", person_tracking},
      {"crowd", crowd},
      {"synchronous",
       [](Builder& b) {
         b.start_s = kHalfSecond;
         synchronous(b);
       }},
      {"synchronous_cold", synchronous},
      {"majority",
       [](Builder& b) {
         b.start_s = kHalfSecond;
         majority(b);
       }},
      {"majority_cold", majority},
      {"low_texture", low_texture},
      {"turn_30", [](Builder& b) { turn_at_desk(b, 30); }},
      {"turn_60", [](Builder& b) { turn_at_desk(b, 60); }},
      {"turn_100", [](Builder& b) { turn_at_desk(b, 100); }},
      {"turn_150", [](Builder& b) { turn_at_desk(b, 150); }},
      {"near_turn_60", [](Builder& b) { near_turn(b, 60); }},
      {"near_turn_100", [](Builder& b) { near_turn(b, 100); }},
      {"walking_turn_30", [](Builder& b) { walking_turn(b, 30); }},
      {"walking_turn_60", [](Builder& b) { walking_turn(b, 60); }},
      {"walking_turn_100", [](Builder& b) { walking_turn(b, 100); }},
      {"walking_turn_150", [](Builder& b) { walking_turn(b, 150); }},
      {"shake", shake},
      {"walking_shake", walking_shake},
      {"standing_camera", standing_camera},
      {"street", street},
      {"street_traffic", street_traffic},
      {"street_follow", street_follow},
      {"street_oncoming", street_oncoming},
      {"junction", junction},
      {"street_turn", street_turn},
      {"hall", hall},
      {"hall_people", hall_people},
  };
  return entries;
}

}  // namespace script

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  for (const script::Entry& entry : script::all()) names.emplace_back(entry.name);
  return names;
}

Scene make_scene(const std::string& name, std::uint64_t seed) {
  for (const script::Entry& entry : script::all()) {
    if (entry.name != name) continue;
    Scene scene;
    SceneBuilder builder(scene, seed);
    entry.run(builder);
    Random random(seed, 0xA1);
    const std::size_t movers = scene.objects.size();
    scene.surroundings =
        builder.surroundings
            ? builder.surroundings(scene.materials, random, static_cast<int>(movers))
            : Room(scene.materials, random, builder.look, builder.chairs, static_cast<int>(movers));
    const std::vector<Detectable>& objects = scene.surroundings->objects;
    scene.objects.insert(scene.objects.end(), objects.begin(), objects.end());
    scene.camera.emplace(builder.camera, random);
    scene.exposure_ms = builder.exposure_ms;
    scene.readout_ms = builder.readout_ms;
    scene.camera_model = builder.camera_model;
    return scene;
  }
  throw ConfigError("scene", unknown_name("scene", name, scene_names()));
}

}  // namespace dynfilter::render
