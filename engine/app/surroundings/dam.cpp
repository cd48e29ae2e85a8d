#include "engine/app/surroundings/dam.h"

#include <algorithm>
#include <cmath>

#include "engine/app/surroundings/blend.h"

namespace typodont {

namespace {

constexpr double kOverGum = 0.25e-3;  // m, the sheet above the gum's edge
constexpr double kSheet = 0.3e-3;     // m, thickness over the teeth
constexpr double kTension = 6e-3;     // m, over which the tight sheet bridges hollows
constexpr double kLift = 3.2e-3;      // m, height of the sheet's edge over the gum, where the frame pulls it
constexpr dvec3 kPlate{2.6e-3, 0.95e-3, 0.40e-3};  // m, half sizes of a jaw of the clamp
constexpr double kPlateHeight = 0.75e-3;           // m over the gum's edge
constexpr dvec3 kBand{0.55e-3, 0.40e-3, 0.9e-3};   // m, half sizes of the bow's section

}  // namespace

double dam_sheet(const Jaw& jaw, const Jaw::Place& at, double teeth, double own, double gap) {
  // Away from the teeth the sheet hangs from the frame.
  const double lift = kLift * smooth_step(6e-3, 16e-3, std::abs(at.beside));
  const double level = -at.depth - kOverGum - lift;
  const double covered = smooth_min(teeth - kSheet, level, kTension);
  const double sheet = smooth_max(covered, std::abs(at.beside) - 60e-3, 1e-3);
  return std::max(std::max(sheet, gap - own), at.depth - jaw.depth());
}

DamClamp::DamClamp(const Jaw&, const dvec3& middle, double edge, double half_width)
    : middle_(middle.x, middle.y, edge), side_(half_width + 0.55e-3) {
  const double s = side_ + 0.7e-3;
  for (const double side : {1.0, -1.0}) {
    std::vector<dvec3> half{{-1.0e-3, side * s, 1.0e-3},
                            {-3.5e-3, side * (s + 0.6e-3), 1.5e-3},
                            {-6.0e-3, side * s, 3.2e-3},
                            {-7.8e-3, side * (s - 1.0e-3), 6.0e-3},
                            {-8.8e-3, side * (s - 2.8e-3), 8.2e-3}};
    if (side < 0) std::reverse(half.begin(), half.end());
    for (const dvec3& p : half) bow_.push_back(middle_ + p);
    if (side > 0) bow_.push_back(middle_ + dvec3(-9.2e-3, 0, 8.9e-3));
  }
  low_ = dvec3(1e9);
  high_ = dvec3(-1e9);
  const auto grow = [&](const dvec3& p) {
    low_ = glm::min(low_, p - 2e-3);
    high_ = glm::max(high_, p + 2e-3);
  };
  for (const dvec3& p : bow_) grow(p);
  grow(middle_ + dvec3(kPlate.x, 0, 0));
}

double DamClamp::distance(const dvec3& p_row) const {
  double bow = 1;
  for (std::size_t i = 0; i + 1 < bow_.size(); ++i) {
    const dvec3 d = bow_[i + 1] - bow_[i], r = p_row - bow_[i];
    const double t = std::clamp(glm::dot(r, d) / glm::dot(d, d), 0.0, 1.0);
    const dvec3 q = (r - t * d) / kBand;
    bow = smooth_min(bow, (glm::length(q) - 1) * std::min(kBand.x, kBand.y), 0.5e-3);
  }
  const dvec3 p = p_row - middle_;
  const dvec3 plate = glm::abs(dvec3(p.x, std::abs(p.y) - side_ - kPlate.y + 0.3e-3, p.z - kPlateHeight)) - kPlate;
  const double flat = glm::length(glm::max(plate, dvec3(0))) + std::min(std::max({plate.x, plate.y, plate.z}), 0.0);
  return smooth_min(bow, flat - 0.15e-3, 0.8e-3);
}

}  // namespace typodont
