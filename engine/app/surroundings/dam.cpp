#include "engine/app/surroundings/dam.h"

#include <algorithm>
#include <cmath>

#include "engine/app/tissue/blend.h"
#include "engine/base/nearest.h"

namespace typodont {

namespace {

constexpr double kOverGum = 0.25e-3;  // m, height of the dam's sheet above the gum's edge
constexpr double kSheet = 0.7e-3;     // m, thickness of the rubber dam's sheet over the teeth
constexpr double kTension = 6e-3;     // m; the sheet does not follow hollows narrower than this
// Distance from the curve through the teeth to the edge of the sheet, inside the cheek, m.
constexpr double kSheetTo = 13.5e-3;
// Height by which the frame pulls the sheet up, m.
constexpr double kLift = 3.2e-3;
constexpr dvec3 kPlate{2.2e-3, 0.75e-3, 0.15e-3};  // m, half the edge lengths of a clamp's jaw
constexpr double kPlateHeight = 0.75e-3;           // m, height of the clamp's jaws above the gum's edge
constexpr double kBow = 0.75e-3;                   // m, radius of the bow's wire
constexpr double kPlateRound = 0.35e-3;            // m, radius of the edges of the clamp's jaws
// Number of rounds of corner cutting (Chaikin 1974).
constexpr int kSmooth = 3;

}  // namespace

double dam_sheet(const Jaw& jaw, const Jaw::Place& at, double teeth, double own, double gap) {
  // The frame pulls the sheet up, away from the teeth.
  const double lift = kLift * smooth_step(6e-3, 16e-3, std::abs(at.beside));
  const double level = -at.depth - kOverGum - lift;
  const double covered = smooth_min(teeth - kSheet, level, kTension);
  const double sheet = smooth_max(covered, jaw.from_curve(at) - kSheetTo, 1e-3);
  return std::max(std::max(sheet, gap - own), at.depth - jaw.depth());
}

DamClamp::DamClamp(const dvec3& middle, double edge, double half_width)
    : middle_(middle.x, middle.y, edge), side_(half_width + 0.55e-3) {
  const double s = side_ + 0.7e-3;
  for (const double side : {1.0, -1.0}) {
    std::vector<dvec3> half{{-0.5e-3, side * s, 0.9e-3},
                            {-2.6e-3, side * (s + 0.8e-3), 2.2e-3},
                            {-4.6e-3, side * (s + 1.0e-3), 4.8e-3},
                            {-6.4e-3, side * (s + 0.2e-3), 7.6e-3},
                            {-8.0e-3, side * (s - 1.8e-3), 9.6e-3}};
    if (side < 0) std::reverse(half.begin(), half.end());
    for (const dvec3& p : half) bow_.push_back(middle_ + p);
    if (side > 0) bow_.push_back(middle_ + dvec3(-9.0e-3, 0, 10.4e-3));
  }
  for (int i = 0; i < kSmooth; ++i) {
    std::vector<dvec3> cut{bow_.front()};
    for (std::size_t k = 0; k + 1 < bow_.size(); ++k) {
      cut.push_back(0.75 * bow_[k] + 0.25 * bow_[k + 1]);
      cut.push_back(0.25 * bow_[k] + 0.75 * bow_[k + 1]);
    }
    cut.push_back(bow_.back());
    bow_ = std::move(cut);
  }
  low_ = dvec3(1e9);
  high_ = dvec3(-1e9);
  const auto grow = [&](const dvec3& p) {
    low_ = glm::min(low_, p - 2e-3);
    high_ = glm::max(high_, p + 2e-3);
  };
  for (const dvec3& p : bow_) grow(p);
  for (const double side : {-1.0, 1.0}) grow(middle_ + dvec3(kPlate.x, side * (side_ + 2 * kPlate.y), 0));
}

double DamClamp::distance(const dvec3& p_row) const {
  double bow = 1;
  for (std::size_t i = 0; i + 1 < bow_.size(); ++i)
    bow = smooth_min(bow, distance_to_segment(bow_[i], bow_[i + 1], p_row) - kBow, 0.15e-3);
  const dvec3 p = p_row - middle_;
  const dvec3 plate = glm::abs(dvec3(p.x, std::abs(p.y) - side_ - kPlate.y + 0.3e-3, p.z - kPlateHeight)) - kPlate;
  const double flat = glm::length(glm::max(plate, dvec3(0))) + std::min(std::max({plate.x, plate.y, plate.z}), 0.0);
  return smooth_min(bow, flat - kPlateRound, 0.8e-3);
}

}  // namespace typodont
