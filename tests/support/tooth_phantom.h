// A synthetic tooth that is known exactly: enamel that becomes thinner towards the neck, dentin, a pulp chamber and
// root canals.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

#include "engine/contract/tissue.h"
#include "tests/support/import_phantom.h"

namespace typodont::test {

/// Lengths in mm.
struct ToothPhantom {
  double voxel = 0.4, blur = 0.2;
  unsigned seed = 1;             // of the noise
  double shift = 0.1;            // displacement of the voxels relative to the tooth, along all axes
  double side = 1.1, top = 1.9;  // thickness of the enamel at the sides and at the top of the crown
  double chamber = 1.1;          // radius of the pulp chamber; it is 1.5 times as large along x, 1.2 along y and z
  double canal = 0.45;           // radius of a root canal at the neck; it is 0.6 times as large at the apex
  double tilt = 0.3;             // rad, rotation about y
  bool two_roots = false;
  double noise = 15;                                              // standard deviation of the grey values
  double outside = 400, pulp = 150, dentin = 830, enamel = 1190;  // grey values

  Tissue tissue(const glm::dvec3& p) const {
    const glm::dvec3 r = p - glm::dvec3(7, 7, 13) + shift;
    const double c = std::cos(tilt), s = std::sin(tilt);
    const glm::dvec3 q(c * r.x + s * r.z, r.y, -s * r.x + c * r.z);
    const double split = two_roots ? std::clamp((-3 - q.z) / 4, 0.0, 1.5) : 0;  // of each root from the middle
    const double from_root = split > 0 ? std::abs(q.x) - split : q.x;
    const double canal_radius = canal * (0.6 + 0.4 * (q.z - kApex) / -kApex);
    const bool in_canal = q.z < 0 && q.z > kApex + 1 && std::hypot(from_root, q.y) < canal_radius;
    const glm::dvec3 of_chamber = q / (chamber * glm::dvec3(1.5, 1.2, 1.2)) + glm::dvec3(0, 0, 0.6);
    const bool in_pulp = in_canal || glm::dot(of_chamber, of_chamber) < 1;
    if (q.z >= kNeck) {
      const double depth = crown_depth(q);
      if (depth <= 0) return Tissue::kAir;
      const double high = std::clamp(q.z / kCrown.z, 0.0, 1.0), from_neck = std::clamp((q.z - kNeck) / 3, 0.0, 1.0);
      const double thickness = (side + (top - side) * high * high) * std::sqrt(from_neck);
      return in_pulp ? Tissue::kPulp : depth < thickness ? Tissue::kEnamel : Tissue::kDentin;
    }
    if (q.z <= kApex) return Tissue::kAir;
    const double at_neck = std::sqrt(1 - std::pow(kNeck / kCrown.z, 2)), along = (q.z - kApex) / (kNeck - kApex);
    const double out = std::hypot(from_root / (kCrown.x * at_neck - split), q.y / (kCrown.y * at_neck));
    if (out * out >= along) return Tissue::kAir;
    return in_pulp ? Tissue::kPulp : Tissue::kDentin;
  }

  double grey(const glm::dvec3& p) const {
    switch (tissue(p)) {
      case Tissue::kEnamel:
        return enamel;
      case Tissue::kDentin:
        return dentin;
      case Tissue::kPulp:
        return pulp;
      default:
        return outside;
    }
  }

  Phantom phantom() const {
    Phantom p;
    p.size = glm::ivec3(glm::ceil(glm::dvec3(15, 14, 20) / voxel));
    p.spacing = glm::dvec3(voxel);
    p.blur = blur, p.noise = noise, p.fine = 5;
    p.grey = [this](const glm::dvec3& q) { return grey(q); };
    return p;
  }

  /// Returns the volume (mm³) of each tissue; 0 for air.
  PerTissue volumes() const {
    constexpr double kStep = 0.07;
    PerTissue v{};
    for (double x = -1; x < 16; x += kStep) {
      for (double y = -1; y < 15; y += kStep) {
        for (double z = -1; z < 21; z += kStep) v[static_cast<std::size_t>(tissue({x, y, z}))] += std::pow(kStep, 3);
      }
    }
    v[0] = 0;
    return v;
  }

 private:
  static constexpr double kNeck = -1.8, kApex = -11;  // heights relative to the middle of the crown
  static constexpr glm::dvec3 kCrown{4.6, 4.0, 4.2};  // semi-axes of the crown's ellipsoid
  /// Returns the depth below the surface of the crown, to first order.
  static double crown_depth(const glm::dvec3& q) {
    const glm::dvec3 s = q / kCrown;
    const double g = glm::length(s), slope = glm::length(s / kCrown);
    return slope > 0 ? (1 - g) * g / slope : kCrown.y;
  }
};

}  // namespace typodont::test
