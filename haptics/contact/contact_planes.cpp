#include "haptics/contact/contact_planes.h"

#include <algorithm>
#include <cmath>

#include "engine/base/dispatch.h"
#include "engine/base/units.h"

namespace typodont::haptics {

namespace {

constexpr double kMedialAxis = 1e-2;  // a gradient shorter by more: walls meeting at over 16°
constexpr double kSunk = 1.2;         // voxels; where head and tissue overlap by more, no hand brought them together
constexpr double kFootOff = 0.05;     // voxels; of a ball of four voxels' radius the linear look alone is off by as much
constexpr double kOnSurface = 0.25;   // voxels
constexpr int kRoughSteps = 2;        // queries a sample may take on its way to the closest point
constexpr double kNear = 1.5;         // voxels: samples closer than this to the surface are looked at

}  // namespace

ContactFinder::ContactFinder(const Tool& tool, double voxel)
    : head_(tool, voxel),
      sphere_(tool.shape == HeadShape::kSphere),
      radius_(tool.radius() / voxel),
      reach_(tool.reach() / voxel) {
  samples_ = sample_head(tool, 256);
  for (HeadSample& sample : samples_) {
    sample.p_TQ /= voxel;
    sample.area /= voxel * voxel;
  }
}

double ContactFinder::head_distance(const Pose& X_VT, const dvec3& x) const noexcept {
  if (sphere_) return glm::length(x - X_VT.p) - radius_;
  return head_.distance(glm::conjugate(X_VT.R) * (x - X_VT.p));
}

double ContactFinder::head_distance(const Pose& X_VT, const dvec3& x, dvec3& n) const noexcept {
  if (sphere_) {
    const dvec3 d = x - X_VT.p;
    const double length = glm::length(d);
    n = length > 1e-9 ? d / length : dvec3(0, 0, -1);
    return length - radius_;
  }
  dvec3 n_T;
  const double distance = head_.distance(glm::conjugate(X_VT.R) * (x - X_VT.p), n_T);
  n = X_VT.R * n_T;
  return distance;
}

/// Offset surface (Kim & Park 2006, sec. 3.2): one query at the sphere's centre. Exact where the field outside the
/// tissue is a true distance and smooth; a gradient shorter than 1 betrays a medial axis within the stencil.
bool ContactFinder::find_by_offset(const SurfacePatch& patch, const dvec3& c, ContactSet& set) const noexcept {
  const FieldSample at = sample_cubic(patch, c);
  const double length = glm::length(at.gradient);
  if (std::abs(length - 1) > kMedialAxis) return false;
  if (at.value < 0.5) return false;  // the centre is inside: the field there is not what the offset needs
  const dvec3 n = at.gradient / length;
  // Near a medial axis the gradient is a mixture of two walls': its foot then hangs in the air between them.
  if (!patch.holds(c - at.value * n, 0) || std::abs(sample_linear(patch, c - at.value * n)) > kFootOff) return false;
  set.planes[0] = {c - at.value * n, n, at.value - radius_, 1};
  set.count = 1;
  return true;
}

void ContactFinder::find(const SurfacePatch& patch, const Pose& X_VT, double near, ContactSet& set) const noexcept {
  set.count = 0;
  set.engaged_area = 0;
  set.engaged_normal = dvec3(0);
  if (sphere_ && patch.exact_outside && find_by_offset(patch, X_VT.p, set)) return;

  // Look around with samples on the head: first a coarse look at the nearest voxel (the field grows by at most one per
  // voxel), then slide those that are near tissue to where head and surface are closest.
  const glm::dmat3 R(X_VT.R);
  const dvec3 c = X_VT.p - dvec3(patch.lo);
  const std::size_t sy = static_cast<std::size_t>(patch.n), sx = sy * sy;
  const float* field = patch.distance.data();
  constexpr float kFar = static_cast<float>(kNear) + 0.87f;
  bool sunk = false;
  for (const HeadSample& sample : samples_) {
    const dvec3 p = sphere_ ? sample.p_TQ : R * sample.p_TQ;
    const dvec3 q = c + p;
    const std::size_t nearest = static_cast<std::size_t>(q.x + 0.5) * sx + static_cast<std::size_t>(q.y + 0.5) * sy +
                                static_cast<std::size_t>(q.z + 0.5);
    if (field[nearest] > kFar) continue;
    const FieldSample at = sample_linear_gradient(patch, X_VT.p + p);
    if (at.value > kNear) continue;
    if (at.value < 1) {  // fades over one voxel, so that area changes smoothly
      const double engaged = sample.area * std::min(1 - at.value, 1.0);
      set.engaged_area += engaged;
      set.engaged_normal -= engaged * (sphere_ ? sample.n_T : R * sample.n_T);
    }
    ContactPlane plane;
    plane.gap = -1e300;
    if (at.value >= -kSunk) plane = slide<sample_linear_gradient>(patch, X_VT, X_VT.p + p, at, kRoughSteps);
    if (plane.gap < -kSunk) {  // the surface passes anywhere through the head: following the head's shape leads astray
      const double slope = glm::length(at.gradient);
      if (slope < 0.5) continue;
      plane = {X_VT.p + p - at.value / slope * at.gradient / slope, at.gradient / slope, at.value, 1, true};
    }
    sunk |= plane.sunk;
    if (plane.gap < near && set.count < ContactSet::kMax) set.planes[static_cast<std::size_t>(set.count++)] = plane;
  }
  if (!sunk) return;
  // Along the rim of the hole that a sunk head makes, planes push it to all sides at once: only the way out counts.
  const auto end = std::remove_if(set.planes.begin(), set.planes.begin() + set.count,
                                  [](const ContactPlane& plane) { return !plane.sunk && plane.gap < 0; });
  set.count = static_cast<int>(end - set.planes.begin());
}

void ContactFinder::relinearize(const Pose& X_VT, ContactSet& set) const noexcept {
  for (int i = 0; i < set.count; ++i) {
    ContactPlane& plane = set.planes[static_cast<std::size_t>(i)];
    if (plane.sunk) continue;
    plane.gap = head_distance(X_VT, plane.x, plane.n);
    plane.n = -plane.n;
  }
}

void ContactFinder::refine(const SurfacePatch& patch, const Pose& X_VT, ContactPlane& plane) const noexcept {
  if (plane.sunk || !patch.holds(plane.x, 0)) return;
  const ContactPlane exact = slide<sample_cubic>(patch, X_VT, plane.x, sample_cubic(patch, plane.x), 5);
  const double yields = plane.yields;
  if (exact.gap < plane.gap + 0.5) plane = exact;
  plane.yields = yields;
}

/// From a point near the surface: onto it, then along it toward the head, as long as that brings them closer.
template <auto sample>
ContactPlane ContactFinder::slide(const SurfacePatch& patch, const Pose& X_VT, dvec3 x, FieldSample field,
                                  int steps) const noexcept {
  ContactPlane best;
  best.gap = 1e300;
  for (int step = 0; step < steps; ++step) {
    if (step > 0) {
      if (!patch.holds(x, 0)) break;
      field = sample(patch, x);
    }
    const double length = glm::length(field.gradient);
    if (length < 0.1) break;
    const dvec3 n = field.gradient / length;
    x -= field.value * n;
    // Only a point that was already nearly on the surface counts: across a ridge the step above may end anywhere.
    if (std::abs(field.value) > kOnSurface) continue;
    dvec3 m;
    const double gap = head_distance(X_VT, x, m);
    const double gained = best.gap - gap;
    if (!(gained > 0)) break;
    best = {x, -m, gap, 1};
    if (gained < 1e-6) break;
    x -= (radius_ + gap) * (m - glm::dot(m, n) * n);
  }
  return best;
}

namespace {

typedef double D4 __attribute__((vector_size(32)));
typedef long long L4 __attribute__((vector_size(32)));

/// The planes side by side, four at a time, for the search through all of them.
struct PlaneRows {
  static constexpr int kRows = ContactSet::kMax / 4;
  alignas(32) D4 nx[kRows], ny[kRows], nz[kRows], room[kRows];
  int rows = 0;
};

/// The plane of least n·d + room if that is below -1e-9, the first of equal ones; else -1.
TYPODONT_DISPATCH("avx2", "default") int most_violated(const PlaneRows* planes, const double* d) {
  D4 least = D4{} - 1e-9;
  L4 index = L4{} - 1, at = {0, 1, 2, 3};
  for (int row = 0; row < planes->rows; ++row, at += 4) {
    const D4 e = planes->nx[row] * d[0] + planes->ny[row] * d[1] + planes->nz[row] * d[2] + planes->room[row];
    const L4 less = e < least;
    least = less ? e : least;
    index = less ? at : index;
  }
  int worst = 0;
  for (int lane = 1; lane < 4; ++lane) {
    if (least[lane] < least[worst] || (least[lane] == least[worst] && index[lane] < index[worst])) worst = lane;
  }
  return static_cast<int>(index[worst]);
}

/// Projection onto a polyhedron in three dimensions by the dual active-set method (Goldfarb & Idnani 1983): starts at
/// the unconstrained answer and adds the most violated plane until none is; at most three are active at once.
bool project(const ContactSet& set, const dvec3& c, double overlap, double slack, bool only_no_deeper, dvec3& p,
             ActivePlanes& active) noexcept {
  active = {};
  const auto normal = [&](int i) -> const dvec3& { return set.planes[static_cast<std::size_t>(i)].n; };
  const auto room_at = [&](int i) {
    const ContactPlane& plane = set.planes[static_cast<std::size_t>(i)];
    const double room = plane.gap + overlap + slack * plane.yields;
    return only_no_deeper ? std::max(room, 0.0) : room;
  };
  const auto excess = [&](int i) { return glm::dot(normal(i), p - c) + room_at(i); };
  PlaneRows planes;
  planes.rows = (set.count + 3) / 4;
  for (int i = 0; i < 4 * planes.rows; ++i) {
    const bool real = i < set.count;
    const dvec3 n = real ? normal(i) : dvec3(0);
    planes.nx[i / 4][i % 4] = n.x, planes.ny[i / 4][i % 4] = n.y, planes.nz[i / 4][i % 4] = n.z;
    planes.room[i / 4][i % 4] = real ? room_at(i) : 1;
  }
  int& k = active.count;
  double* u = active.push;
  for (int round = 0; round < 64; ++round) {
    const double d[3] = {p.x - c.x, p.y - c.y, p.z - c.z};
    const int worst = most_violated(&planes, d);
    if (worst < 0) return true;
    double added = 0;
    for (int guard = 0; guard < 8; ++guard) {
      // z: what is left of the new normal beside the active ones; r: its coordinates in them.
      double r[3] = {};
      dvec3 z = normal(worst);
      if (k > 0) {
        double gram[3][4];
        for (int i = 0; i < k; ++i) {
          for (int j = 0; j < k; ++j) gram[i][j] = glm::dot(normal(active.index[i]), normal(active.index[j]));
          gram[i][k] = glm::dot(normal(active.index[i]), z);
        }
        for (int i = 0; i < k; ++i) {  // Gauss without pivoting: the Gram matrix of independent normals
          for (int row = i + 1; row < k; ++row) {
            const double f = gram[row][i] / gram[i][i];
            for (int col = i; col <= k; ++col) gram[row][col] -= f * gram[i][col];
          }
        }
        for (int i = k - 1; i >= 0; --i) {
          r[i] = gram[i][k];
          for (int j = i + 1; j < k; ++j) r[i] -= gram[i][j] * r[j];
          r[i] /= gram[i][i];
        }
        for (int i = 0; i < k; ++i) z -= r[i] * normal(active.index[i]);
      }
      const double z2 = glm::dot(z, z);
      double partial = 1e300;
      int leaving = -1;
      for (int i = 0; i < k; ++i) {
        if (r[i] > 1e-12 && u[i] / r[i] < partial) partial = u[i] / r[i], leaving = i;
      }
      const double full = (k < 3 && z2 > 1e-8) ? -excess(worst) / z2 : 1e300;
      const double t = std::min(partial, full);
      if (t >= 1e299) return false;
      if (full < 1e299) p += t * z;
      for (int i = 0; i < k; ++i) u[i] -= t * r[i];
      added += t;
      if (full <= partial) {
        active.index[k] = worst;
        u[k++] = added;
        break;
      }
      for (int i = leaving; i + 1 < k; ++i) active.index[i] = active.index[i + 1], u[i] = u[i + 1];
      --k;
    }
  }
  return false;
}

}  // namespace

dvec3 nearest_allowed(const ContactSet& set, const dvec3& c, double overlap, double slack, const dvec3& target,
                      ActivePlanes& active) noexcept {
  dvec3 p = target;
  if (project(set, c, overlap, slack, false, p, active)) return p;
  p = target;
  if (project(set, c, overlap, slack, true, p, active)) return p;
  return c;
}

}  // namespace typodont::haptics
