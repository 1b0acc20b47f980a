// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <dynfilter/core/random.hpp>
#include <string>
#include <vector>

#include "render/lighting.hpp"
#include "render/mesh.hpp"
#include "render/room_materials.hpp"

namespace dynfilter::render {

/// An object with a detector class (COCO numbers).
struct Detectable {
  int class_id;
  std::string class_name;
};

Eigen::Isometry3f placed(const Eigen::Vector3f& at, float yaw_rad);

/// Adds furniture to the world.
/// Every piece has its own frame: front towards -y, z up, origin on the floor below its middle.
/// `yaw_rad` rotates it counter-clockwise, viewed from above.
class FurnitureBuilder {
 public:
  std::vector<Model> models;
  std::vector<Occluder> occluders;
  std::vector<Detectable> objects;

  FurnitureBuilder(const RoomMaterials& materials, Random& random, bool plain, int first_instance)
      : m_(materials), random_(random), plain_(plain), first_instance_(first_instance) {}
  const RoomMaterials& materials() const { return m_; }

  Model& begin();

  void box(const Eigen::Vector3f& centre, float yaw_rad, const Eigen::Vector3f& size, const BoxSkin& skin);

  void furnished_desk(const Eigen::Vector3f& at, float yaw_rad);

  void partition(const Eigen::Vector3f& at, float yaw_rad, float width);

  void chair(const Eigen::Vector3f& at, float yaw_rad);

  void bookshelf(const Eigen::Vector3f& at, float yaw_rad, float width, float height);

  void cabinet(const Eigen::Vector3f& at, float yaw_rad);

  void plant(const Eigen::Vector3f& at, float size);

  void bin(const Eigen::Vector3f& at);

  /// A picture with its middle at `at`, about 1 cm in front of the wall.
  void poster(const Eigen::Vector3f& at, float yaw_rad, float width, float height);
  void whiteboard(const Eigen::Vector3f& at, float yaw_rad, float width, float height);
  void window(const Eigen::Vector3f& at, float yaw_rad, float width, float height);
  void door(const Eigen::Vector3f& at, float yaw_rad);

 private:
  static Eigen::Isometry3f sub(const Eigen::Isometry3f& frame, const Eigen::Vector3f& at, float yaw_rad = 0) {
    return frame * placed(at, yaw_rad);
  }
  float uniform(float low, float high) { return static_cast<float>(random_.uniform(low, high)); }
  int pick(const std::vector<int>& list) {
    return list[static_cast<std::size_t>(random_.below(static_cast<int>(list.size())))];
  }

  void occlude(const Eigen::Isometry3f& frame, const Eigen::Vector3f& size) {
    occluders.emplace_back(frame, size);
  }

  int object(int class_id, const char* name);

  void part(const Eigen::Isometry3f& frame, const Eigen::Vector3f& size, const BoxSkin& skin,
            float cell_m = 0.4F, int instance = 0);

  void hang(const Eigen::Vector3f& at, float yaw_rad, float width, float height, int material) {
    part(placed(at, yaw_rad), {width, 0.012F, height}, BoxSkin::all({material}), 0.25F);
  }

  void desk(const Eigen::Isometry3f& f);

  void monitor(const Eigen::Isometry3f& f, const Eigen::Vector3f& at, float yaw_rad);

  void keyboard(const Eigen::Isometry3f& f, const Eigen::Vector3f& at, float yaw_rad);

  void book_pile(const Eigen::Isometry3f& f, const Eigen::Vector3f& at, int count);

  /// One book back from the sheet of backs. Horizontal books show only its upper part.
  Skin back_of_book(bool lying);

  void books_on_shelf(const Eigen::Isometry3f& f, float z, float width, float most_high);

  void sheet(const Eigen::Isometry3f& f, const Eigen::Vector3f& at);

  void mug(const Eigen::Isometry3f& f, const Eigen::Vector3f& at);

  void lamp(const Eigen::Isometry3f& f, const Eigen::Vector3f& at);

  void leaf(Model& model, const Eigen::Isometry3f& f, float size);

  const RoomMaterials& m_;
  Random& random_;
  bool plain_;
  int first_instance_;
  std::size_t windows_ = 0;
};

}  // namespace dynfilter::render
