#include "haptics/contact/contact_planes.h"

#include <algorithm>
#include <cmath>

#include "engine/base/units.h"

namespace typodont::haptics {

namespace {

constexpr double kNear = 1.5;                     // voxels: samples closer than this to the surface are looked at
const double kDistinct = std::cos(20 * kDegree);  // contacts with closer normals count as one

}  // namespace

ContactFinder::ContactFinder(const Tool& tool, double voxel)
    : tool_(tool),
      voxel_(voxel),
      sphere_(tool.shape == HeadShape::kSphere),
      radius_(tool.radius() / voxel),
      reach_(tool.reach() / voxel) {
  samples_ = sample_head(tool, 256);
  for (HeadSample& sample : samples_) {
    sample.p_TQ /= voxel;
    sample.area /= voxel * voxel;
  }
  candidates_.reserve(samples_.size());
}

double ContactFinder::head_distance(const Pose& X_VT, const dvec3& x) const noexcept {
  if (sphere_) return glm::length(x - X_VT.p) - radius_;
  return tool_.distance(glm::conjugate(X_VT.R) * (x - X_VT.p) * voxel_) / voxel_;
}

dvec3 ContactFinder::head_normal(const Pose& X_VT, const dvec3& x) const noexcept {
  if (sphere_) {
    const dvec3 d = x - X_VT.p;
    const double length = glm::length(d);
    return length > 1e-9 ? d / length : dvec3(0, 0, -1);
  }
  constexpr double e = 0.02;  // voxels
  const dvec3 g(head_distance(X_VT, x + dvec3(e, 0, 0)) - head_distance(X_VT, x - dvec3(e, 0, 0)),
                head_distance(X_VT, x + dvec3(0, e, 0)) - head_distance(X_VT, x - dvec3(0, e, 0)),
                head_distance(X_VT, x + dvec3(0, 0, e)) - head_distance(X_VT, x - dvec3(0, 0, e)));
  const double length = glm::length(g);
  return length > 1e-9 ? g / length : dvec3(0, 0, -1);
}

/// Offset surface (Kim & Park 2006, sec. 3.2): one query at the sphere's centre. Exact where the field outside the
/// tissue is a true distance and smooth; a gradient shorter than 1 betrays a medial axis within the stencil.
bool ContactFinder::find_by_offset(const SurfacePatch& patch, const dvec3& c, ContactSet& set) const noexcept {
  const FieldSample at = sample_cubic(patch, c);
  const double length = glm::length(at.gradient);
  if (std::abs(length - 1) > 1e-3) return false;
  if (at.value < 0.5) return false;  // the centre is inside: the field there is not what the offset needs
  const dvec3 n = at.gradient / length;
  set.planes[0] = {c - at.value * n, n, at.value - radius_};
  set.count = 1;
  return true;
}

void ContactFinder::find(const SurfacePatch& patch, const Pose& X_VT, ContactSet& set) const noexcept {
  set.count = 0;
  set.engaged_area = 0;
  set.engaged_normal = dvec3(0);
  if (sphere_ && patch.exact_outside && find_by_offset(patch, X_VT.p, set)) return;

  // Look around with samples on the head.
  candidates_.clear();
  const glm::dmat3 R(X_VT.R);
  for (const HeadSample& sample : samples_) {
    const dvec3 q = X_VT.p + R * sample.p_TQ;
    const double value = sample_linear(patch, q);
    if (value > kNear) continue;
    const double engaged = std::clamp(1 - value, 0.0, 1.0);  // fades over one voxel, so that area changes smoothly
    set.engaged_area += sample.area * engaged;
    set.engaged_normal -= sample.area * engaged * (R * sample.n_T);
    const FieldSample field = sample_linear_gradient(patch, q);
    const double length = glm::length(field.gradient);
    if (length < 0.1) continue;
    const dvec3 x = q - field.value / length * (field.gradient / length);
    candidates_.push_back({x, head_distance(X_VT, x)});
  }
  if (candidates_.empty()) return;
  std::sort(candidates_.begin(), candidates_.end(), [](const Candidate& a, const Candidate& b) { return a.gap < b.gap; });

  // Of the deepest with distinct directions, slide each to where head and surface are closest: there the head's normal
  // is opposite to the surface's.
  for (const Candidate& candidate : candidates_) {
    if (set.count == ContactSet::kMax) break;
    const dvec3 rough = -head_normal(X_VT, candidate.x);
    bool known = false;
    for (int i = 0; i < set.count && !known; ++i) known = glm::dot(set.planes[static_cast<std::size_t>(i)].n, rough) > kDistinct;
    if (known) continue;

    dvec3 x = candidate.x, best = x;
    double gap = 1e300;
    for (int step = 0; step < 4; ++step) {
      if (!patch.holds(x, 0)) break;
      FieldSample field = sample_cubic(patch, x);
      double length = std::max(0.1, glm::length(field.gradient));
      x -= field.value / (length * length) * field.gradient;  // onto the surface
      const double d = head_distance(X_VT, x);
      if (d > gap - 1e-7) break;
      const double gained = gap - d;
      gap = d;
      best = x;
      if (gained < 1e-5) break;
      const dvec3 n = field.gradient / length, m = head_normal(X_VT, x);
      x -= (radius_ + d) * (m - glm::dot(m, n) * n);
    }
    if (gap > kNear) continue;
    const dvec3 n = -head_normal(X_VT, best);
    known = false;
    for (int i = 0; i < set.count && !known; ++i) {
      ContactPlane& plane = set.planes[static_cast<std::size_t>(i)];
      known = glm::dot(plane.n, n) > kDistinct;
      if (known && gap < plane.gap) plane = {best, n, gap};
    }
    if (!known) set.planes[static_cast<std::size_t>(set.count++)] = {best, n, gap};
  }
}

// Projection onto a polyhedron in three dimensions by the dual active-set method (Goldfarb & Idnani 1983): starts at the
// unconstrained answer and adds the most violated plane until none is; at most three are active at once.
bool nearest_allowed(const ContactSet& set, const dvec3& c, double slack, const dvec3& target, dvec3& p,
                     std::array<double, ContactSet::kMax>& multipliers) noexcept {
  multipliers.fill(0);
  p = target;
  int active[3] = {};
  double u[4] = {};
  int k = 0;
  const auto plane = [&](int i) -> const ContactPlane& { return set.planes[static_cast<std::size_t>(i)]; };
  const auto excess = [&](int i) { return glm::dot(plane(i).n, p - c) + plane(i).gap + slack; };

  for (int round = 0; round < 64; ++round) {
    int worst = -1;
    double least = -1e-9;
    for (int i = 0; i < set.count; ++i) {
      const double e = excess(i);
      if (e < least) least = e, worst = i;
    }
    if (worst < 0) {
      for (int j = 0; j < k; ++j) multipliers[static_cast<std::size_t>(active[j])] = u[j];
      return true;
    }
    double added = 0;
    for (int guard = 0; guard < 8; ++guard) {
      // z: what is left of the new normal beside the active ones; r: its coordinates in them.
      const dvec3 n = plane(worst).n;
      double r[3] = {};
      dvec3 z = n;
      if (k > 0) {
        double gram[3][4];
        for (int i = 0; i < k; ++i) {
          for (int j = 0; j < k; ++j) gram[i][j] = glm::dot(plane(active[i]).n, plane(active[j]).n);
          gram[i][k] = glm::dot(plane(active[i]).n, n);
        }
        for (int i = 0; i < k; ++i) {  // Gauss without pivoting: a Gram matrix of distinct normals
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
        for (int i = 0; i < k; ++i) z -= r[i] * plane(active[i]).n;
      }
      const double z2 = glm::dot(z, z);
      double partial = 1e300;
      int leaving = -1;
      for (int i = 0; i < k; ++i) {
        if (r[i] > 1e-12 && u[i] / r[i] < partial) partial = u[i] / r[i], leaving = i;
      }
      const double full = (k < 3 && z2 > 1e-10) ? -excess(worst) / z2 : 1e300;
      const double t = std::min(partial, full);
      if (t >= 1e299) {
        p = c;
        return false;
      }
      if (full < 1e299) p += t * z;
      for (int i = 0; i < k; ++i) u[i] -= t * r[i];
      added += t;
      if (full <= partial) {
        active[k] = worst;
        u[k++] = added;
        break;
      }
      for (int i = leaving; i + 1 < k; ++i) active[i] = active[i + 1], u[i] = u[i + 1];
      --k;
    }
  }
  p = c;
  return false;
}

}  // namespace typodont::haptics
