// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "render/mesh.hpp"
#include "render/person_materials.hpp"
#include "render/skeleton.hpp"

namespace dynfilter::render {

/// The body of a person: one model per BodyPart, each in the frame of its part.
class PersonBuilder {
 public:
  PersonBuilder(const BodyShape& shape, const Outfit& outfit, int instance)
      : k_(static_cast<float>(shape.scale)), outfit_(outfit), instance_(instance), parts_(kBodyPartCount) {}

  std::vector<Model> build();

 private:
  struct Section {
    float z, half_x, half_y, ahead = 0;  // m at scale 1
  };

  Model& model_of(int part) { return parts_[static_cast<std::size_t>(part)]; }

  void loft(int part, const std::vector<Section>& sections, int material, float around, float along,
            float exponent = 2.2F, int segments = 18);

  void ellipsoid(int part, const Eigen::Vector3f& centre, const Eigen::Vector3f& radii, int material,
                 int segments = 10) {
    add_loft(model_of(part), Eigen::Isometry3f::Identity(), ellipsoid_rings(k_ * centre, k_ * radii, 7),
             {material, 1, 1, segments, 2, instance_});
  }

  void trunk();

  void head();

  void arm(int side);

  void hand(int side, float sign);

  void leg(int side);

  void foot(int side);

  float k_;
  Outfit outfit_;
  int instance_;
  std::vector<Model> parts_;
};

}  // namespace dynfilter::render
