#include "haptics/contact/proxy/sharp_edge.h"

#include <algorithm>
#include <cmath>

#include "engine/base/units.h"
#include "haptics/contact/proxy/parameters.h"

namespace typodont::haptics {

namespace {

using E = SharpEdgeParameters;
constexpr int kMostFaces = FlatWalls::kMost;

struct Face {
  dvec3 x{0}, n{0};    // x: point on the face; n: outward normal of the face
  bool clean = false;  // true if no other face is near this face
};

/// Moves `x` onto the nearest face. Returns false if the field there does not belong to a plane.
bool face_from(const SurfacePatch& patch, dvec3 x, const dvec3& foot, Face& face) noexcept {
  const auto is_below = [&](const dvec3& p, const dvec3& n, double depth) {
    const dvec3 q = p - depth * n;
    return patch.holds(q, -2) && std::abs(sample_linear(patch, q) + depth) < E::depth_tolerance;
  };
  for (int step = 0; step < E::steps; ++step) {
    if (!patch.holds(x, 0)) return false;
    const FieldSample at = sample_cubic(patch, x);
    const double slope = glm::length(at.gradient);
    if (slope < 0.5) return false;
    const dvec3 n = at.gradient / slope;
    if (std::abs(at.value) < E::on_face) {
      face = {x - at.value * n, n, is_below(x - at.value * n, n, E::depth_clean)};
      return std::abs(slope - 1) < E::gradient_tolerance && glm::length(face.x - foot) > E::least_aside &&
             is_below(face.x, n, E::depth_least);
    }
    x -= at.value * n;
  }
  return false;
}

/// Returns true if the wall `face` of a groove lies in the same plane at a second point. The second point is so far
/// from the bottom of the groove that the other wall does not influence the field there.
bool face_continues(const SurfacePatch& patch, const Face& face, const dvec3& foot) noexcept {
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
      if (!more.clean && glm::dot(face[i].n, more.n) > E::alike) return true;
      if (1 - glm::dot(face[i].n, more.n) < E::same_face &&
          std::abs(glm::dot(face[i].n, more.x - face[i].x)) < E::on_face) {
        return true;
      }
    }
    if (count == kMostFaces) return false;
    face[count++] = more;
    return true;
  }
  bool convex() const noexcept {
    for (int i = 0; i < count; ++i) {
      for (int j = 0; j < count; ++j) {
        if (glm::dot(face[j].n, face[i].x - face[j].x) > E::convex) return false;
      }
    }
    return true;
  }
  bool concave() const noexcept {
    for (int i = 0; i < count; ++i) {
      for (int j = 0; j < count; ++j) {
        if (glm::dot(face[j].n, face[i].x - face[j].x) < -E::convex) return false;
      }
    }
    return true;
  }
  double above(int i, const dvec3& p) const noexcept { return glm::dot(face[i].n, p - face[i].x); }

  /// Computes the point nearest to c of the solid that the faces enclose. It lies on a face, on the line where two
  /// faces meet, or at the point where three faces meet.
  bool nearest(const dvec3& c, dvec3& p) const noexcept {
    double least = 1e300;
    for (unsigned which = 1; which < (1u << count); ++which) {
      int on[kMostFaces], k = 0;
      for (int i = 0; i < count; ++i) {
        if (which >> i & 1u) on[k++] = i;
      }
      double gram[kMostFaces][kMostFaces + 1], push[kMostFaces];
      bool solved = true;
      for (int i = 0; i < k; ++i) {
        for (int j = 0; j < k; ++j) gram[i][j] = glm::dot(face[on[i]].n, face[on[j]].n);
        gram[i][k] = above(on[i], c);
      }
      for (int i = 0; i < k && solved; ++i) {
        solved = gram[i][i] > 1e-4;
        for (int row = i + 1; row < k && solved; ++row) {
          const double f = gram[row][i] / gram[i][i];
          for (int col = i; col <= k; ++col) gram[row][col] -= f * gram[i][col];
        }
      }
      if (!solved) continue;
      dvec3 at = c;
      for (int i = k - 1; i >= 0; --i) {
        push[i] = gram[i][k];
        for (int j = i + 1; j < k; ++j) push[i] -= gram[i][j] * push[j];
        push[i] /= gram[i][i];
        solved = solved && push[i] >= 0;
        at -= push[i] * face[on[i]].n;
      }
      for (int i = 0; i < count; ++i) solved = solved && above(i, at) < E::on_face;
      const double distance = glm::length(c - at);
      if (solved && distance < least) least = distance, p = at;
    }
    return least < 1e299;
  }
};

}  // namespace

bool nearest_on_edge(const SurfacePatch& patch, const dvec3& c, const dvec3& foot, double distance,
                     dvec3& nearest) noexcept {
  const dvec3 n = (c - foot) / distance;
  const auto face_along = [&](const dvec3& u, Face& face) {
    // Searches a face beside the foot point. If that place is in air, it lies beyond the edge, and a second search
    // starts below it.
    return face_from(patch, foot + E::aside * u, foot, face) || face_from(patch, foot + E::down * (u - n), foot, face);
  };
  const dvec3 aside = std::abs(n.x) < 0.6 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
  const dvec3 u = glm::normalize(glm::cross(n, aside)), v = glm::cross(n, u);
  Faces faces;
  bool few = true;
  Face most[2];  // the two faces with the most different normals
  double cosine = 2;
  Face found[E::directions];
  int count = 0;
  for (int i = 0; i < E::directions; ++i) {
    const double a = 2 * kPi * i / E::directions;
    Face face;
    if (!face_along(std::cos(a) * u + std::sin(a) * v, face)) continue;
    for (int j = 0; j < count; ++j) {
      if (glm::dot(found[j].n, face.n) < cosine)
        cosine = glm::dot(found[j].n, face.n), most[0] = found[j], most[1] = face;
    }
    found[count++] = face;
  }
  for (const bool clean : {true, false}) {
    for (int i = 0; i < count; ++i) {
      if (found[i].clean == clean) few = faces.add(found[i]) && few;
    }
  }
  if (faces.count < 2) return false;
  // At a curved rim, more faces are found than a corner can have. Then only the two faces in the cross-section through
  // the rim are used.
  for (int turn = 0; !few && turn < 3; ++turn) {
    const dvec3 across = glm::cross(glm::cross(most[0].n, most[1].n), n);
    if (!(glm::length(across) > 1e-6)) return false;
    const dvec3 w = glm::normalize(across);
    if (!face_along(w, most[0]) || !face_along(-w, most[1])) return false;
    faces.count = 0;
    faces.add(most[0]), faces.add(most[1]);
  }
  if (!faces.convex() || !faces.nearest(c, nearest)) return false;
  // Compares the result with the field. Near a true edge, the value of the field is the distance to the edge. If the
  // tissue was made by an intersection of solids, the field is the distance to the farthest face instead.
  double farthest = -1e300;
  for (int i = 0; i < faces.count; ++i) farthest = std::max(farthest, faces.above(i, c));
  return std::min(std::abs(glm::length(c - nearest) - distance), std::abs(farthest - distance)) < E::agrees;
}

bool walls_of_crease(const SurfacePatch& patch, const dvec3& c, const FieldSample& at, FlatWalls& walls) noexcept {
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
      face.clean = true;
      if (!faces.add(face)) return false;
    } else if (++misses > E::misses) {
      return false;
    }
  }
  if (faces.count < 2 || !faces.concave()) return false;
  double least = 1e300, most_apart = 0;
  for (int i = 0; i < faces.count; ++i) {
    walls.n[i] = faces.face[i].n, walls.height[i] = faces.above(i, c);
    least = std::min(least, walls.height[i]);
    for (int j = 0; j < i; ++j) most_apart = std::max(most_apart, glm::length(walls.n[i] - walls.n[j]));
  }
  walls.count = faces.count;
  return std::abs(at.value - least) < E::agrees + E::filled * most_apart;
}

}  // namespace typodont::haptics
