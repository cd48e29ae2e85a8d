// A synthetic part of a lower jaw that is known exactly, and its cone beam CT in Hounsfield units: two teeth in their
// sockets, and a nerve canal below them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <vector>

#include "engine/contract/tissue.h"
#include "tests/support/import_phantom.h"

namespace typodont::test {

/// Errors that the scanner adds, and properties that differ between jaws.
struct JawArtefacts {
  double blur = 0.2;      // mm, standard deviation
  double noise = 50;      // Hounsfield units
  double streaks = 0;     // Hounsfield units beside the metal crown; they decrease over 10 mm
  double motion = 0;      // mm, the scan is the mean of two scans that are displaced by this distance along y
  bool metal = false;     // the second tooth has a crown of metal
  bool lamina = true;     // true: sockets have a bright wall; false: cancellous bone begins behind the ligament
  double second = 20;     // mm, position of the second tooth along x; at less than 17.5 the crowns touch
  std::size_t teeth = 2;  // 1: the second tooth is missing, and its socket is bone
  double fissure = 0;     // mm, depth of a groove across the top of each crown, 0.7 mm wide
  // Hounsfield units by which the middle of the scan is too dark (shading); the error decreases over 10 mm
  double shading = 0;
  double density_slope = 0;  // Hounsfield units per mm by which cancellous bone becomes denser along x; no error
  int fine = 3;              // Phantom::fine
  double texture = 60;       // Hounsfield units, variation of the cancellous bone, with a wavelength of 3 mm
  double voxel = 0.3;        // mm
  double shift = 0;          // mm, displacement of the voxels relative to the jaw, along all axes
  unsigned seed = 1;         // of the noise
  double nerve = 1.3;        // mm, radius of the nerve canal
  double nerve_wall = 0.5;   // mm, thickness of the nerve canal's bright wall
  double chamber = 1;        // size of the pulp chambers, as a factor of the usual size
  double root_canal = 0.5;   // mm, radius of the root canals
};

class JawPhantom {
 public:
  static constexpr double kVoxel = 0.3;  // mm, voxel size of the usual scan
  static constexpr std::array<double, 2> kTeeth{9.5, 20};
  static constexpr double kY = 12, kApex = 12, kNeck = 23.5, kTop = 31;
  static constexpr double kCanal = JawArtefacts{}.nerve;  // mm, radius of the usual nerve canal

  explicit JawPhantom(const JawArtefacts& artefacts) : a_(artefacts) {}

  /// Returns the tissue at q. Soft tissues other than pulp and the nerve are labelled as air.
  Tissue tissue(const glm::dvec3& q) const {
    // Squared distances, because a scan needs the tissue at many millions of positions.
    std::array<double, 2> out2;
    for (std::size_t k = 0; k < a_.teeth; ++k) {
      const glm::dvec3 r = q - glm::dvec3(place(k), kY, 0);
      out2[k] = r.x * r.x + r.y * r.y;
      if (out2[k] > kWidest * kWidest) continue;
      const bool in_canal = out2[k] < a_.root_canal * a_.root_canal;
      if (q.z >= kNeck) {
        if (crown_distance(k, r) >= 0) continue;
        if (inside_ellipsoid(out2[k], r.z - 25.5, 1.2 * a_.chamber, 2 * a_.chamber) || (in_canal && r.z < 25))
          return Tissue::kPulp;
        if (inside_ellipsoid(out2[k], r.z - 26, 2.7, 3.4)) return Tissue::kDentin;
        return a_.metal && k == 1 ? Tissue::kAmalgam : Tissue::kEnamel;
      }
      if (within(out2[k], root_radius(q.z))) return (in_canal && q.z > kApex + 2) ? Tissue::kPulp : Tissue::kDentin;
    }
    if (!inside_bone(q, 0)) return Tissue::kAir;
    for (std::size_t k = 0; k < a_.teeth; ++k) {
      if (out2[k] > kWidest * kWidest) continue;
      if (within(out2[k], root_radius(q.z + kLigament) + kLigament)) return Tissue::kAir;
      if (a_.lamina && within(out2[k], root_radius(q.z + kLigament + kLamina) + kLigament + kLamina))
        return Tissue::kCorticalBone;
    }
    if (inside_bone(q, kShell)) {
      // Most of the bone is so far from the nerve canal that the canal's course there need not be computed.
      if (std::abs(q.z - kCanalHeight) > kCanalSwing + a_.nerve + a_.nerve_wall + 0.01) return Tissue::kCancellousBone;
      const double from_canal = glm::length(q - canal_centre(q.x));
      if (from_canal < a_.nerve) return Tissue::kPulp;
      if (from_canal < a_.nerve + a_.nerve_wall) return Tissue::kCorticalBone;
      return Tissue::kCancellousBone;
    }
    return Tissue::kCorticalBone;
  }

  /// Returns the position (mm) of a tooth along x.
  double place(std::size_t k) const { return k == 0 ? kTeeth[0] : a_.second; }

  /// Returns the signed distance (mm) to the surface of crown k. `r`: mm, position relative to the tooth's axis at z =
  /// 0, above the neck. The distance is accurate to first order; the surface, where it is zero, is exact.
  double crown_distance(std::size_t k, const glm::dvec3& r) const {
    const glm::dvec3 s = glm::dvec3(r.x, r.y, r.z - 26.5) / glm::dvec3(4, 4, 4.5);
    const double g = glm::length(s), slope = glm::length(s / glm::dvec3(4, 4, 4.5));
    const double crown = slope > 0 ? (g - 1) * g / slope : -4;
    if (a_.fissure == 0) return crown;
    // The groove is a prism below the crown's top.
    const double angle = 0.5 + static_cast<double>(k), across = std::abs(r.x * std::cos(angle) + r.y * std::sin(angle));
    const double top = 26.5 + 4.5 * std::sqrt(std::max(0.0, 1 - (r.x * r.x + r.y * r.y) / 16));
    const double wall = a_.fissure / kFissureHalf;
    return std::max(crown, (top - a_.fissure + wall * across - r.z) / -std::hypot(1.0, wall));
  }

  static glm::dvec3 canal_centre(double x) { return {x, 13, kCanalHeight + kCanalSwing * std::sin(x / 6)}; }
  static double root_radius(double z) {
    return z <= kApex ? -1 : 2.7 * std::sqrt(std::min(1.0, (z - kApex) / (kNeck - kApex)));
  }

  double hounsfield(const glm::dvec3& q) const {
    switch (tissue(q)) {
      case Tissue::kEnamel:
        return 2800;
      case Tissue::kDentin:
        return 1650;
      case Tissue::kAmalgam:
        return 7000;
      case Tissue::kCorticalBone:
        return 1500;
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
    p.size = glm::ivec3(glm::round(glm::dvec3(100, 80, 112) * (kVoxel / a_.voxel)));
    p.spacing = glm::dvec3(a_.voxel);
    p.blur = a_.blur;
    p.noise = a_.noise;
    p.fine = a_.fine;
    p.grey = [this](const glm::dvec3& from_first) {
      const glm::dvec3 q = from_first + a_.shift;
      if (a_.motion == 0) return hounsfield(q);
      return 0.5 *
             (hounsfield(q - glm::dvec3(0, 0.5 * a_.motion, 0)) + hounsfield(q + glm::dvec3(0, 0.5 * a_.motion, 0)));
    };
    return p;
  }

  /// Returns the grey values of phantom(), with texture and streaks.
  std::vector<double> scan() const {
    const Phantom p = phantom();
    std::vector<double> greys = p.scan(a_.seed);
    std::size_t i = 0;
    for (int z = 0; z < p.size.z; ++z) {
      for (int y = 0; y < p.size.y; ++y) {
        for (int x = 0; x < p.size.x; ++x, ++i) {
          const glm::dvec3 q = glm::dvec3(x, y, z) * a_.voxel + a_.shift;
          if (tissue(q) == Tissue::kCancellousBone) {
            const glm::dvec3 w = q * (2 * M_PI / 3);
            greys[i] += a_.texture * std::sin(w.x) * std::sin(w.y + 1) * std::sin(w.z + 2);
            greys[i] += a_.density_slope * (q.x - 14.75);
          }
          if (a_.shading > 0) {
            const glm::dvec3 r = q - glm::dvec3(14.75, 12, 15);
            greys[i] -= a_.shading * std::exp(-glm::dot(r, r) / 200);
          }
          if (a_.streaks > 0 && q.z > kNeck && q.z < kTop) {
            const double dx = q.x - place(1), dy = q.y - kY, r = std::hypot(dx, dy);
            greys[i] += a_.streaks * std::cos(8 * std::atan2(dy, dx)) * std::exp(-r / 10);
          }
        }
      }
    }
    return greys;
  }

  /// Returns the volume (mm³) of each tissue above the height `from` (mm) along z; 0 for air. Cells at a border between
  /// tissues are sampled finely, because the root canals are only a few cells wide.
  PerTissue volumes(double from = 0) const {
    constexpr double kCell = 0.2;
    constexpr int kFine = 4;
    const auto places = [](double first, double end) {  // of the corners of the cells along an axis
      std::vector<double> at;
      double next = first;
      for (; next < end - kCell / 2; next += kCell) at.push_back(next);
      at.push_back(next);
      return at;
    };
    const std::vector<double> xs = places(0, 30), ys = places(0, 24), zs = places(from, 33);
    const auto corner = [&](std::size_t x, std::size_t y, std::size_t z) {
      return (x * ys.size() + y) * zs.size() + z;
    };
    std::vector<Tissue> corners;  // at the corners, each of which up to eight cells share
    corners.reserve(corner(xs.size(), 0, 0));
    for (const double x : xs) {
      for (const double y : ys) {
        for (const double z : zs) corners.push_back(tissue({x, y, z}));
      }
    }
    PerTissue v{};
    for (std::size_t x = 0; x + 1 < xs.size(); ++x) {
      for (std::size_t y = 0; y + 1 < ys.size(); ++y) {
        for (std::size_t z = 0; z + 1 < zs.size(); ++z) {
          const glm::dvec3 q(xs[x], ys[y], zs[z]);
          const Tissue middle = tissue(q + kCell / 2);
          bool pure = true;
          for (std::size_t k = 0; k < 8 && pure; ++k)
            pure = corners[corner(x + (k & 1), y + (k >> 1 & 1), z + (k >> 2))] == middle;
          if (pure) {
            v[static_cast<std::size_t>(middle)] += std::pow(kCell, 3);
            continue;
          }
          for (int k = 0; k < kFine * kFine * kFine; ++k) {
            const glm::dvec3 at(k % kFine, k / kFine % kFine, k / kFine / kFine);
            v[static_cast<std::size_t>(tissue(q + kCell / kFine * (at + 0.5)))] += std::pow(kCell / kFine, 3);
          }
        }
      }
    }
    v[0] = 0;
    return v;
  }

 private:
  static constexpr double kLigament = 0.3, kLamina = 0.6, kShell = 2, kFissureHalf = 0.35;  // mm
  static constexpr double kCanalHeight = 8.5, kCanalSwing = 0.6;                            // mm

  static constexpr double kWidest = 4.1;  // mm, larger than the radius of a crown and of a socket

  static bool within(double square, double radius) { return radius > 0 && square < radius * radius; }
  static bool inside_ellipsoid(double out2, double up, double radius, double half) {
    return out2 / (radius * radius) + up * up / (half * half) < 1;
  }
  static bool inside_bone(const glm::dvec3& q, double shell) {
    const glm::dvec3 r = (q - glm::dvec3(14.75, 12, 12.5)) / (glm::dvec3(13, 8, 10.5) - shell);
    const glm::dvec3 square = r * r;
    return glm::dot(square, square) < 1;
  }

  JawArtefacts a_;
};

}  // namespace typodont::test
