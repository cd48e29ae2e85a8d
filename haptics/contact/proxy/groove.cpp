#include "haptics/contact/proxy/groove.h"

#include <algorithm>
#include <cmath>

#include "engine/base/units.h"
#include "haptics/contact/proxy/parameters.h"

namespace typodont::haptics {

namespace {

using E = GrooveParameters;
constexpr int kMaxFaces = FlatWalls::kMost;

struct Face {
  dvec3 x{0}, n{0};  // voxels: point of the face; unit vector: its outward normal
};

/// Moves `x` onto the nearest wall of the groove. Returns false if the field there does not belong to a plane.
bool face_from(const TissuePatch& patch, dvec3 x, const dvec3& foot, Face& face) noexcept {
  for (int step = 0; step < E::steps; ++step) {
    if (!patch.holds(x, 0)) return false;
    const FieldSample at = sample_cubic(patch, x);
    const double slope = glm::length(at.gradient);
    if (slope < 0.5) return false;
    const dvec3 n = at.gradient / slope;
    if (std::abs(at.value) < E::on_face) {
      face = {x - at.value * n, n};
      const dvec3 below = face.x - E::depth * n;
      return std::abs(slope - 1) < E::gradient_tolerance && glm::length(face.x - foot) > E::min_aside &&
             patch.holds(below, -2) && std::abs(sample_linear(patch, below) + E::depth) < E::depth_tolerance;
    }
    x -= at.value * n;
  }
  return false;
}

/// Returns true if the wall `face` is flat: it has the same plane at a second point, farther from the bottom, where the
/// other wall does not influence the field.
bool face_continues(const TissuePatch& patch, const Face& face, const dvec3& foot) noexcept {
  const dvec3 away = face.x - foot, along = away - glm::dot(away, face.n) * face.n;
  const dvec3 p = face.x + E::farther * glm::normalize(along);
  if (!patch.holds(p, 0)) return false;
  const FieldSample at = sample_cubic(patch, p);
  return std::abs(at.value) < E::flat_distance &&
         1 - glm::dot(at.gradient, face.n) / glm::length(at.gradient) < E::flat;
}

struct Faces {
  int count = 0;
  Face face[E::directions];

  bool add(const Face& more) noexcept {
    for (int i = 0; i < count; ++i) {
      if (1 - glm::dot(face[i].n, more.n) < E::same_face &&
          std::abs(glm::dot(face[i].n, more.x - face[i].x)) < E::on_face) {
        return true;
      }
    }
    if (count == kMaxFaces) return false;
    face[count++] = more;
    return true;
  }
  bool concave() const noexcept {
    for (int i = 0; i < count; ++i) {
      for (int j = 0; j < count; ++j) {
        if (glm::dot(face[j].n, face[i].x - face[j].x) < -E::concave) return false;
      }
    }
    return true;
  }
  double above(int i, const dvec3& p) const noexcept { return glm::dot(face[i].n, p - face[i].x); }
};

}  // namespace

bool walls_of_crease(const TissuePatch& patch, const dvec3& c, const FieldSample& at, FlatWalls& walls) noexcept {
  const double slope = glm::length(at.gradient);
  const dvec3 n = at.gradient / slope, foot = c - at.value * n;
  const dvec3 aside = std::abs(n.x) < 0.6 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
  const dvec3 u = glm::normalize(glm::cross(n, aside)), v = glm::cross(n, u);
  Faces faces;
  for (int i = 0, misses = 0; i < E::directions; ++i) {
    const double a = 2 * kPi * i / E::directions;
    Face face;
    if (face_from(patch, foot + E::aside * (std::cos(a) * u + std::sin(a) * v), foot, face) &&
        face_continues(patch, face, foot)) {
      if (!faces.add(face)) return false;
    } else if (++misses > E::misses) {
      return false;
    }
  }
  if (faces.count < 2 || !faces.concave()) return false;
  double least = 1e300, max_apart = 0;
  for (int i = 0; i < faces.count; ++i) {
    walls.n[i] = faces.face[i].n, walls.height[i] = faces.above(i, c);
    least = std::min(least, walls.height[i]);
    for (int j = 0; j < i; ++j) max_apart = std::max(max_apart, glm::length(walls.n[i] - walls.n[j]));
  }
  walls.count = faces.count;
  return std::abs(at.value - least) < E::agrees + E::filled * max_apart;
}

}  // namespace typodont::haptics
