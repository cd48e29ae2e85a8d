#include "haptics/contact/proxy/contact_planes.h"

#include <algorithm>
#include <cmath>

#include "haptics/contact/proxy/head_samples.h"
#include "haptics/contact/proxy/parameters.h"
#include "haptics/contact/proxy/sharp_edge.h"

namespace typodont::haptics {

namespace {

using O = OffsetQueryParameters;
using S = WallSeatParameters;
using R = RefineParameters;
using Rim = RimParameters;

}  // namespace

ContactFinder::ContactFinder(const Tool& tool, double voxel)
    : head_(tool, voxel),
      sphere_(tool.shape == HeadShape::kSphere),
      radius_(tool.radius() / voxel),
      reach_(tool.reach() / voxel),
      samples_(std::make_unique<HeadSamples>(tool, head_, voxel)) {}

ContactFinder::~ContactFinder() = default;
ContactFinder::ContactFinder(ContactFinder&&) noexcept = default;
ContactFinder& ContactFinder::operator=(ContactFinder&&) noexcept = default;

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

/// Finds the contact of a ball by one field query at its centre c (offset surface: Kim & Park 2006, sec. 3.2). The foot
/// point is the nearest point of the surface, computed from the value and gradient at c. The result is exact where the
/// field outside the tissue is smooth. Elsewhere the field may be smaller than the true distance, but never larger, and
/// it is not zero at the foot point. Samples of the field on the line through c and the foot point detect two cases.
/// Near an edge, a sample below the foot point is less deep than below a flat surface; the edge is then computed from
/// its two faces. Near a second wall, a sample above c is smaller than its distance from the foot point.
bool ContactFinder::find_by_offset(const SurfacePatch& patch, const dvec3& c, ContactSet& set) const noexcept {
  const FieldSample at = sample_cubic(patch, c);
  const double length = glm::length(at.gradient);
  if (at.value < 0.5 || length < 0.5)
    // The head's centre is inside tissue. There, the field cannot be used as the distance to the offset surface.
    return false;
  dvec3 n = at.gradient / length;
  double distance = at.value;
  const dvec3 below = c - (distance + O::depth_below) * n;
  const dvec3 above = c + O::height_above * n;
  if (!patch.holds(above, 0) ||
      sample_linear(patch, above) < std::min(distance + O::height_above, patch.band) - O::foot_tolerance)
    return false;
  if (std::abs(length - 1) > O::gradient_tolerance || !patch.holds(below, 0) ||
      std::abs(sample_linear(patch, below) + O::depth_below) > O::foot_tolerance) {
    dvec3 foot = c - distance * n;
    if (nearest_on_edge(patch, c, foot, distance, foot)) {
      distance = glm::length(c - foot);
      n = (c - foot) / distance;
    } else {
      // If the gradient does not have length 1, or the foot point is not on the surface, the field there depends on two
      // walls.
      if (std::abs(length - 1) > O::gradient_tolerance || !patch.holds(foot, 0)) return false;
      if (std::abs(sample_linear(patch, foot)) > O::foot_tolerance) return false;
    }
  }
  set.origin_ = c;
  set.put(0, c, {c - distance * n, n, distance - radius_, 1});
  set.count_ = 1;
  set.deepest_ = std::max(0.0, radius_ - distance);
  return true;
}

/// Finds the contacts of a ball in a crease, which is a concave edge between flat walls. The computed plane of each
/// wall is exact, even near the crease.
bool ContactFinder::find_in_crease(const SurfacePatch& patch, const dvec3& c, double near,
                                   ContactSet& set) const noexcept {
  const FieldSample at = sample_cubic(patch, c);
  FlatWalls walls;
  if (at.value < 0.5 || glm::length(at.gradient) < 0.1 || !walls_of_crease(patch, c, at, walls)) return false;
  set.origin_ = c;
  for (int i = 0; i < walls.count; ++i) {
    const double gap = walls.height[i] - radius_;
    if (gap >= near) continue;
    set.put(set.count_++, c, {c - walls.height[i] * walls.n[i], walls.n[i], gap, 1, true});
    set.deepest_ = std::max(set.deepest_, -gap);
  }
  set.flat_ = true;
  return true;
}

bool ContactFinder::seat(const SurfacePatch& patch, const dvec3& target, const dvec3& c, dvec3& seated, ContactSet& set,
                         bool& alone) const noexcept {
  if (!sphere_ || !patch.holds(target, O::depth_below + S::hand_depth)) return false;
  FieldSample at = sample_cubic(patch, target);
  double slope = glm::length(at.gradient);
  if (at.value < -S::hand_depth || at.value > radius_ || slope < 0.5 ||
      !is_true_around(patch, target, std::abs(at.value)))
    return false;
  // First moves x from the hand's position onto the wall. Then moves x along the wall until it is the foot point of the
  // hand, which means that the wall's normal at x goes through the hand's position.
  dvec3 x = target, n;
  double height = 0, uneven = 0;
  for (int step = 0;; ++step) {
    n = at.gradient / slope;
    x -= at.value * n;
    if (!patch.holds(x, 0)) return false;
    height = glm::dot(target - x, n);
    const dvec3 aside = target - x - height * n;
    if (step > 0 && glm::dot(aside, aside) < S::aligned) break;
    if (step == S::iterations) return false;
    x += aside;
    at = sample_cubic(patch, x);
    slope = glm::length(at.gradient);
    uneven = std::abs(slope - 1);
    if (uneven > S::gradient_tolerance) return false;
  }
  const double deep = std::max(O::depth_below, 1 - height);
  const dvec3 below = x - deep * n, on = target + (radius_ - height) * n;
  if (std::abs(sample_linear(patch, below) + deep) > O::foot_tolerance) return false;
  if (height > radius_ || glm::length(on - c) > kMostSeated || !patch.holds(on, 0)) return false;
  seated = on;
  const dvec3 above = on + O::height_above * n;
  alone = uneven < S::gradient_tolerance_alone && patch.holds(above, 0) &&
          sample_linear(patch, above) >= std::min(radius_ + O::height_above, patch.band) - O::foot_tolerance;
  if (!alone) return true;
  set.clear();
  set.origin_ = on;
  set.put(0, on, {on - radius_ * n, n, 0, 1});
  set.count_ = 1;
  return true;
}

void ContactFinder::find(const SurfacePatch& patch, const Pose& X_VT, double near, ContactSet& set) const noexcept {
  set.clear();
  const bool uncut = patch.cut_lo.x > patch.cut_hi.x ? patch.exact_outside
                                                     : is_true_around(patch, X_VT.p, sample_linear(patch, X_VT.p));
  if (sphere_ && uncut && (find_by_offset(patch, X_VT.p, set) || find_in_crease(patch, X_VT.p, near, set))) return;

  const Found found = samples_->look_around(patch, X_VT, static_cast<float>(near), set.rough_);
  set.origin_ = X_VT.p;
  set.count_ = found.count;
  set.deepest_ = static_cast<double>(found.deepest);
  set.engaged_area_ = static_cast<double>(found.area);
  const dvec3 out(found.area_x, found.area_y, found.area_z);
  set.engaged_normal_ = sphere_ ? -out : -(X_VT.R * out);
  std::fill_n(set.rough_.yields, found.count, 1.0f);
}

void ContactFinder::project_out(const Pose& X_VE, const Pose& X_VT, ContactSet& set) const noexcept {
  // Exact contacts exist only where no cut has changed the tissue, so their surface points need no correction.
  if (set.sunk_ || set.exact_count_ > 0) return;
  set.projects_out_ = true;
  set.emptied_ = X_VE;
  if (same(X_VE, X_VT)) {
    samples_->push_out_here(set.rough_, set.count_);
    set.deepest_ = 0;
  } else {
    samples_->push_out_at(X_VE.R, glm::vec3(X_VE.p - set.origin_), set.rough_, set.count_);
    relinearize(X_VT, set);
  }
}

void ContactFinder::find_way_out(const SurfacePatch& patch, const Pose& X_VT, ContactSet& set) const noexcept {
  set.count_ = set.exact_count_ = set.added_ = 0;
  set.deepest_ = 0;
  set.origin_ = X_VT.p;
  set.sunk_ = true;
  RoughPlanes& planes = set.rough_;
  const auto add = [&](const dvec3& p, double beyond) {
    const FieldSample at = sample_linear_gradient(patch, X_VT.p + p);
    const double slope = glm::length(at.gradient), gap = at.value - beyond;
    if (gap >= 0 || slope < 0.5 || set.count_ == ContactSet::kMax) return;
    const glm::vec3 n(at.gradient / slope), x(p - at.value * dvec3(n));
    const int i = set.count_++;
    planes.x[i] = x.x, planes.y[i] = x.y, planes.z[i] = x.z;
    planes.nx[i] = n.x, planes.ny[i] = n.y, planes.nz[i] = n.z;
    planes.gap[i] = static_cast<float>(gap), planes.yields[i] = 1;
    set.deepest_ = std::max(set.deepest_, -gap);
  };
  if (sample_linear(patch, X_VT.p) < 0) add(dvec3(0), sphere_ ? radius_ : 0);
  for (int i = 0; i < ContactSet::kMax; ++i) add(X_VT.R * dvec3(samples_->px[i], samples_->py[i], samples_->pz[i]), 0);
}

void ContactFinder::relinearize(const Pose& X_VT, ContactSet& set) const noexcept {
  set.deepest_ =
      static_cast<double>(samples_->update_planes(X_VT.R, glm::vec3(X_VT.p - set.origin_), set.rough_, set.count_));
  for (int k = 0; k < set.exact_count_; ++k) {
    update_contact(X_VT, set.exact_[static_cast<std::size_t>(k)].plane);
  }
}

void ContactFinder::update_contact(const Pose& X_VT, ContactPlane& plane) const noexcept {
  if (plane.rim) {
    plane.gap = glm::dot(plane.n, farthest(X_VT, -plane.n) - plane.x);
    return;
  }
  plane.gap = head_distance(X_VT, plane.x, plane.n);
  plane.n = -plane.n;
}

bool ContactFinder::refine(const SurfacePatch& patch, const Pose& X_VT, ContactSet& set, int i,
                           bool fine) const noexcept {
  if (set.sunk_ || set.flat_ || i >= set.own()) return false;
  const ContactSet::Exact* known = set.exact(i);
  const double stays = fine ? R::stays_exact_fine : sphere_ ? R::stays_exact : R::stays_exact_edged;
  if (known && glm::length(known->c - X_VT.p) < stays) return false;
  const ContactPlane rough = set.plane(i);
  if (!patch.holds(rough.x, 0)) return false;
  // Moves the contact point onto the surface. Then moves it along the surface towards the head while the gap decreases.
  // On a surface of constant curvature, each displacement is a constant fraction of the previous one. So the fine
  // refinement extrapolates all remaining displacements in one step (secant method).
  ContactPlane best;
  best.gap = 1e300;
  dvec3 x = rough.x, last_slide(0);
  double gain = 1;
  for (int step = 0; step < (fine ? R::iterations_fine : R::iterations); ++step) {
    if (step > 0 && !patch.holds(x, 0)) break;
    const FieldSample field = sample_cubic(patch, x);
    const double length = glm::length(field.gradient);
    if (length < 0.1) break;
    const dvec3 n = field.gradient / length;
    x -= field.value * n;
    if (std::abs(field.value) > static_cast<double>(HeadSampleParameters::on_surface)) continue;
    dvec3 m;
    const double gap = head_distance(X_VT, x, m), gained = best.gap - gap;
    if (!(gained > 0)) break;
    best = {x, -m, gap, rough.yields};
    if (gained < (fine ? R::gained_fine : R::gained)) break;
    const dvec3 slide = -(radius_ + gap) * (m - glm::dot(m, n) * n);
    if (fine) {
      const double before2 = glm::dot(last_slide, last_slide);
      const double fraction = before2 > 0 ? glm::dot(slide, last_slide) / before2 : 0;
      gain =
          fraction != 0 && std::abs(fraction) < R::still_converges ? std::min(gain / (1 - fraction), R::most_gain) : 1;
      last_slide = slide;
    }
    x += gain * slide;
  }
  if (best.gap >= rough.gap + 0.5) best = rough;
  if (set.projects_out_ && best.gap < 0 && same(set.emptied_, X_VT)) {
    best.x += best.gap * best.n;
    best.gap = 0;
  } else if (set.projects_out_ && best.gap < 0) {
    dvec3 n;
    const double off = head_distance(set.emptied_, best.x, n);
    if (off < 0) {
      best.x -= off * n;
      update_contact(X_VT, best);
    }
  }
  const bool rim = fine && touch_with_rim(patch, X_VT, best);
  set.put(i, X_VT.p, best);
  if (rim) set.put_beside(best, Rim::near_rim + 2 * std::abs(best.gap));
  return true;
}

/// Returns the point of the head that is farthest in a given direction (unit vector): an end of a piece of the
/// meridian, or a point of an arc.
dvec3 ContactFinder::farthest(const Pose& X_VT, const dvec3& along) const noexcept {
  const dvec3 d = glm::conjugate(X_VT.R) * along;
  const double out = std::hypot(d.x, d.y);
  glm::dvec2 best(0);
  double most = -1e300;
  const auto try_point = [&](double rho, double z) {
    if (const double reach = out * rho + d.z * z; reach > most) most = reach, best = {rho, z};
  };
  for (int i = 0; i < head_.count; ++i) {
    const HeadField::Piece& piece = head_.pieces[i];
    try_point(piece.ax, piece.az);
    try_point(piece.bx, piece.bz);
    if (piece.radius == 0) continue;
    const double ux = piece.ax - piece.cx, uz = piece.az - piece.cz, wx = piece.bx - piece.cx, wz = piece.bz - piece.cz;
    if (ux * d.z - uz * out >= 0 && out * wz - d.z * wx >= 0)
      try_point(piece.cx + piece.radius * out, piece.cz + piece.radius * d.z);
  }
  const dvec3 side = out > 1e-12 ? dvec3(d.x, d.y, 0) / out : dvec3(1, 0, 0);
  return X_VT.p + X_VT.R * (best.x * side + dvec3(0, 0, best.y));
}

/// If a sharp rim of the head is inside smooth tissue, the two sides of the rim push in different directions, and
/// neither points out of the tissue. The correct direction is the tissue's normal at the deepest point of the rim.
bool ContactFinder::touch_with_rim(const SurfacePatch& patch, const Pose& X_VT, ContactPlane& plane) const noexcept {
  if (sphere_ || !patch.holds(plane.x, 0)) return false;
  FieldSample field = sample_cubic(patch, plane.x);
  double slope = glm::length(field.gradient);
  if (std::abs(slope - 1) > Rim::gradient_tolerance) return false;
  const dvec3 wall = field.gradient / slope;
  if (glm::dot(plane.n, wall) > Rim::askew) return false;
  dvec3 n = wall, q;
  for (int step = 0; step < 2; ++step) {
    q = farthest(X_VT, -n);
    if (!patch.holds(q, 0)) return false;
    field = sample_cubic(patch, q);
    slope = glm::length(field.gradient);
    if (std::abs(slope - 1) > Rim::gradient_tolerance) return false;
    n = field.gradient / slope;
  }
  const double gap = field.value / slope;
  if (glm::dot(n, wall) < Rim::same_wall || glm::length(q - plane.x) > Rim::near_rim + 2 * std::abs(gap)) return false;
  plane = {q - gap * n, n, gap, plane.yields, true};
  return true;
}

}  // namespace typodont::haptics
