// A synthetic part of a jaw that is known exactly, in which the root of one tooth lies inside the outer plate of bone.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

#include "engine/contract/tissue.h"
#include "tests/support/import_phantom.h"

namespace typodont::test {

/// Lengths in mm, grey values in Hounsfield units.
struct PlateRootPhantom {
  double voxel = 0.25, blur = 0.2, noise = 60;
  unsigned seed = 1;
  double deeper = 0;      // displacement of both teeth away from the outer surface
  double root = 2.4;      // largest radius of the roots
  double apex = 12;       // height of the roots' ends
  double ligament = 0.3;  // width of the ligament
  double dentin = 1650, cortical = 1500;
  double turn = 0;  // rad, rotation of the jaw about the vertical axis

  Tissue tissue(const glm::dvec3& p) const {
    const glm::dvec3 q = before_rotation(p);
    // The first tooth leans into the outer plate, the second one stands in the middle of the bone.
    for (const bool first : {true, false}) {
      const glm::dvec3 c = q - glm::dvec3(first ? 9.5 : 20.5, first ? 7.2 + deeper : 12, 26.5);
      if (q.z >= kNeck) {
        const glm::dvec3 s = c / glm::dvec3(3.8, 3.6, 4.4);
        if (glm::dot(s, s) >= 1) continue;
        const auto within = [&](double wide, double high, double up) {
          return (c.x * c.x + c.y * c.y) / (wide * wide) + (c.z - up) * (c.z - up) / (high * high) < 1;
        };
        if (within(1.1, 1.9, -1) || (std::hypot(c.x, c.y) < kCanal && c.z < -1)) return Tissue::kPulp;
        return within(2.5, 3.2, -0.4) ? Tissue::kDentin : Tissue::kEnamel;
      }
      const double out = from_axis(q, first);
      if (out < radius(q.z)) return out < kCanal && q.z > apex + 1.5 ? Tissue::kPulp : Tissue::kDentin;
    }
    if (!in_bone(q, 0)) return Tissue::kAir;
    for (const bool first : {true, false}) {
      if (from_axis(q, first) < radius(q.z + ligament) + ligament) return Tissue::kAir;
      if (from_axis(q, first) < radius(q.z + ligament + 0.5) + ligament + 0.5) return Tissue::kCorticalBone;
    }
    return in_bone(q, 2) ? Tissue::kCancellousBone : Tissue::kCorticalBone;
  }

  /// Returns true if q lies in the root that leans into the outer plate, and the height is below the crest of the bone.
  bool in_leaning_root(const glm::dvec3& p) const {
    const glm::dvec3 q = before_rotation(p);
    return q.z < kNeck - 1.5 && from_axis(q, true) < radius(q.z) - 0.5 * voxel && tissue(p) == Tissue::kDentin;
  }

  double hounsfield(const glm::dvec3& q) const {
    switch (tissue(q)) {
      case Tissue::kEnamel:
        return 2700;
      case Tissue::kDentin:
        return dentin;
      case Tissue::kCorticalBone:
        return cortical;
      case Tissue::kCancellousBone:
        return 450;
      case Tissue::kPulp:
        return 60;
      default:
        return q.z < kNeck + 1 ? 50 : -1000;
    }
  }

  Phantom phantom() const {
    Phantom p;
    p.size = glm::ivec3(glm::round(glm::dvec3(30, 24, 33) / voxel));
    p.spacing = glm::dvec3(voxel);
    p.blur = blur;
    p.noise = noise;
    p.fine = 3;
    p.grey = [this](const glm::dvec3& q) { return hounsfield(q); };
    return p;
  }

 private:
  static constexpr double kNeck = 23.5, kCanal = 0.45;  // mm
  /// Returns the position of the point p before the jaw was rotated.
  glm::dvec3 before_rotation(const glm::dvec3& p) const {
    const glm::dvec2 r = glm::dvec2(p) - glm::dvec2(15, 12);
    return {15 + std::cos(turn) * r.x - std::sin(turn) * r.y, 12 + std::sin(turn) * r.x + std::cos(turn) * r.y, p.z};
  }
  double radius(double z) const {
    return z <= apex ? -1 : root * std::sqrt(std::min(1.0, (z - apex) / (kNeck - apex)));
  }
  double from_axis(const glm::dvec3& q, bool first) const {
    const double lean = first ? 1.8 * std::clamp((kNeck - q.z) / 11.5, 0.0, 1.0) : 0;
    return std::hypot(q.x - (first ? 9.5 : 20.5), q.y - (first ? 7.2 + deeper - lean : 12));
  }
  static bool in_bone(const glm::dvec3& q, double shell) {
    const glm::dvec3 r = (q - glm::dvec3(15, 12, 12.5)) / (glm::dvec3(13, 8, 10.5) - shell);
    return std::pow(std::abs(r.x), 4) + std::pow(std::abs(r.y), 4) + std::pow(std::abs(r.z), 4) < 1;
  }
};

}  // namespace typodont::test
