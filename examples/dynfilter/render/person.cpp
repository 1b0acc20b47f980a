// SPDX-License-Identifier: MIT
#include "render/person.hpp"

#include <utility>

namespace dynfilter::render {

std::vector<Model> PersonBuilder::build() {
  trunk();
  head();
  for (int side = 0; side < 2; ++side) {
    const float sign = side == 0 ? -1.0F : 1.0F;
    arm(side);
    hand(side, sign);
    leg(side);
    foot(side);
  }
  for (Model& part : parts_) part.finish();
  return std::move(parts_);
}

inline void PersonBuilder::loft(int part, const std::vector<Section>& sections, int material, float around,
                                float along, float exponent, int segments) {
  std::vector<Ring> rings;
  for (const Section& s : sections)
    rings.push_back({k_ * s.z, 0, k_ * s.ahead, k_ * s.half_x, k_ * s.half_y});
  add_loft(model_of(part), Eigen::Isometry3f::Identity(), rings,
           {material, around, along, segments, exponent, instance_});
}

inline void PersonBuilder::trunk() {
  loft(kPelvis,
       {{0.13F, 0.01F, 0.01F},
        {0.125F, 0.135F, 0.095F},
        {0.08F, 0.15F, 0.105F},
        {0.02F, 0.165F, 0.118F, -0.012F},
        {-0.04F, 0.168F, 0.12F, -0.018F},
        {-0.09F, 0.15F, 0.105F, -0.01F},
        {-0.13F, 0.01F, 0.01F}},
       outfit_.trousers, 2, 0.6F);
  loft(
      kPelvis,
      {{0.112F, 0.142F, 0.101F}, {0.108F, 0.148F, 0.107F}, {0.078F, 0.155F, 0.11F}, {0.074F, 0.149F, 0.104F}},
      outfit_.belt, 1, 1);
  loft(kChest,
       {{0.465F, 0.05F, 0.045F},
        {0.45F, 0.075F, 0.06F},
        {0.438F, 0.138F, 0.075F},
        {0.41F, 0.182F, 0.086F},
        {0.36F, 0.2F, 0.105F},
        {0.29F, 0.186F, 0.12F, 0.008F},
        {0.2F, 0.168F, 0.118F, 0.006F},
        {0.1F, 0.153F, 0.108F, 0.004F},
        {0.02F, 0.155F, 0.11F},
        {-0.05F, 0.162F, 0.118F},
        {-0.09F, 0.166F, 0.121F},
        {-0.085F, 0.14F, 0.1F}},
       outfit_.shirt, 2, 1.1F, 2.5F, 28);
  loft(kChest, {{0.53F, 0.052F, 0.056F, 0.012F}, {0.47F, 0.056F, 0.058F, 0.006F}, {0.42F, 0.07F, 0.06F}},
       outfit_.skin, 1, 1);
}

inline void PersonBuilder::head() {
  loft(kHead,
       {{0.245F, 0.005F, 0.005F, 0.005F},
        {0.24F, 0.03F, 0.038F, 0.005F},
        {0.225F, 0.055F, 0.07F, 0.006F},
        {0.2F, 0.07F, 0.09F, 0.008F},
        {0.165F, 0.078F, 0.1F, 0.01F},
        {0.125F, 0.078F, 0.1F, 0.012F},
        {0.09F, 0.074F, 0.095F, 0.016F},
        {0.055F, 0.066F, 0.086F, 0.022F},
        {0.025F, 0.054F, 0.07F, 0.03F},
        {0.005F, 0.038F, 0.048F, 0.04F},
        {-0.004F, 0.005F, 0.005F, 0.04F}},
       outfit_.face, 1, 1, 2.1F, 28);
  loft(kHead,
       {{0.262F, 0.005F, 0.005F, -0.005F},
        {0.255F, 0.045F, 0.055F, -0.004F},
        {0.235F, 0.072F, 0.085F, -0.004F},
        {0.2F, 0.085F, 0.094F, -0.008F},
        {0.16F, 0.089F, 0.083F, -0.028F},
        {0.11F, 0.086F, 0.066F, -0.045F},
        {0.065F, 0.07F, 0.045F, -0.05F},
        {0.04F, 0.05F, 0.02F, -0.05F}},
       outfit_.hair, 2, 1, 2.1F, 22);
  ellipsoid(kHead, {0, 0.118F, 0.1F}, {0.013F, 0.017F, 0.026F}, outfit_.skin);
  for (float sign : {-1.0F, 1.0F})
    ellipsoid(kHead, {sign * 0.08F, 0.0F, 0.115F}, {0.013F, 0.022F, 0.034F}, outfit_.skin);
}

inline void PersonBuilder::arm(int side) {
  const int upper = kLeftUpperArm + side, lower = kLeftForearm + side;
  const int sleeve = outfit_.long_sleeves ? outfit_.shirt : outfit_.skin;
  loft(upper,
       {{0.05F, 0.008F, 0.01F},
        {0.045F, 0.026F, 0.032F},
        {0.025F, 0.043F, 0.05F},
        {-0.02F, 0.054F, 0.06F},
        {-0.1F, 0.055F, 0.059F},
        {-0.16F, 0.055F, 0.057F},
        {-0.185F, 0.056F, 0.058F},
        {-0.18F, 0.04F, 0.042F}},
       outfit_.shirt, 1, 0.6F);
  loft(upper,
       {{-0.12F, 0.03F, 0.03F},
        {-0.15F, 0.046F, 0.049F},
        {-0.24F, 0.042F, 0.044F},
        {-0.29F, 0.04F, 0.042F},
        {-0.32F, 0.03F, 0.03F},
        {-0.33F, 0.005F, 0.005F}},
       sleeve, 1, 0.5F);
  loft(lower,
       {{0.035F, 0.005F, 0.005F},
        {0.03F, 0.028F, 0.03F},
        {0, 0.042F, 0.042F},
        {-0.06F, 0.044F, 0.044F},
        {-0.15F, 0.037F, 0.036F},
        {-0.25F, outfit_.long_sleeves ? 0.035F : 0.026F, outfit_.long_sleeves ? 0.034F : 0.022F},
        {-0.262F, 0.01F, 0.01F}},
       sleeve, 1, 0.6F);
}

inline void PersonBuilder::hand(int side, float sign) {
  const int part = kLeftHand + side;
  loft(part,
       {{0.03F, 0.02F, 0.024F},
        {0, 0.02F, 0.028F},
        {-0.04F, 0.018F, 0.04F},
        {-0.09F, 0.016F, 0.042F},
        {-0.1F, 0.012F, 0.038F},
        {-0.102F, 0.003F, 0.01F}},
       outfit_.skin, 1, 0.6F, 2.6F, 12);
  for (int finger = 0; finger < 4; ++finger) {
    const float y = 0.031F - 0.0205F * static_cast<float>(finger), longer = finger == 0 || finger == 2
                                                                                ? 0.072F
                                                                            : finger == 1 ? 0.08F
                                                                                          : 0.058F;
    Eigen::Isometry3f frame = Eigen::Isometry3f::Identity();
    frame.linear() = Eigen::AngleAxisf(-sign * 0.25F, Eigen::Vector3f::UnitY()).toRotationMatrix();
    frame.translation() = k_ * Eigen::Vector3f(0, y, -0.088F);
    add_loft(model_of(part), frame,
             {{0, 0, 0, k_ * 0.009F, k_ * 0.0095F},
              {-k_ * longer * 0.7F, 0, 0, k_ * 0.008F, k_ * 0.0085F},
              {-k_ * longer, 0, 0, 0.002F, 0.002F}},
             {outfit_.skin, 0.4F, 0.4F, 8, 2, instance_});
  }
  Eigen::Isometry3f thumb = Eigen::Isometry3f::Identity();
  thumb.linear() = Eigen::AngleAxisf(0.6F, Eigen::Vector3f::UnitX()).toRotationMatrix();
  thumb.translation() = k_ * Eigen::Vector3f(0, 0.03F, -0.03F);
  add_loft(model_of(part), thumb,
           {{0, 0, 0, k_ * 0.012F, k_ * 0.012F},
            {-k_ * 0.06F, 0, 0, k_ * 0.009F, k_ * 0.009F},
            {-k_ * 0.07F, 0, 0, 0.002F, 0.002F}},
           {outfit_.skin, 0.4F, 0.4F, 8, 2, instance_});
}

inline void PersonBuilder::leg(int side) {
  loft(kLeftThigh + side,
       {{0.1F, 0.01F, 0.01F},
        {0.08F, 0.06F, 0.07F},
        {0.02F, 0.088F, 0.098F, -0.005F},
        {-0.08F, 0.086F, 0.094F},
        {-0.2F, 0.077F, 0.082F},
        {-0.32F, 0.066F, 0.068F},
        {-0.42F, 0.059F, 0.061F},
        {-0.465F, 0.04F, 0.045F},
        {-0.48F, 0.01F, 0.01F}},
       outfit_.trousers, 1, 1.0F);
  loft(kLeftShin + side,
       {{0.05F, 0.01F, 0.01F},
        {0.04F, 0.04F, 0.045F},
        {0, 0.059F, 0.061F},
        {-0.1F, 0.06F, 0.066F, -0.012F},
        {-0.2F, 0.058F, 0.06F, -0.01F},
        {-0.3F, 0.056F, 0.058F},
        {-0.39F, 0.062F, 0.068F, 0.005F},
        {-0.415F, 0.062F, 0.07F, 0.005F},
        {-0.41F, 0.03F, 0.03F}},
       outfit_.trousers, 1, 1.0F);
}

inline void PersonBuilder::foot(int side) {
  const Eigen::Matrix3f lying =
      Eigen::AngleAxisf(static_cast<float>(-CV_PI / 2), Eigen::Vector3f::UnitX()).toRotationMatrix();
  Eigen::Isometry3f frame = Eigen::Isometry3f::Identity();
  frame.linear() = lying;  // the loft's z runs along the foot, its y downwards
  const auto ring = [&](float along, float half_width, float top) {
    const float bottom = -0.08F, half = (top - bottom) / 2;
    return Ring{k_ * along, 0, -k_ * (top + bottom) / 2, k_ * half_width, k_ * half};
  };
  add_loft(model_of(kLeftFoot + side), frame,
           {ring(0.195F, 0.006F, -0.06F), ring(0.185F, 0.034F, -0.045F), ring(0.15F, 0.046F, -0.035F),
            ring(0.1F, 0.048F, -0.018F), ring(0.04F, 0.04F, 0.015F), ring(0, 0.038F, 0.025F),
            ring(-0.05F, 0.037F, 0.01F), ring(-0.07F, 0.03F, -0.02F), ring(-0.075F, 0.005F, -0.05F)},
           {outfit_.shoe, 1, 1, 16, 3, instance_});
}

}  // namespace dynfilter::render
