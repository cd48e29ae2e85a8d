#include "haptics/contact/proxy/contact_planes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/base/dispatch.h"
#include "engine/base/units.h"
#include "haptics/contact/proxy/crease.h"
#include "haptics/contact/proxy/groove.h"
#include "haptics/contact/proxy/head_samples.h"
#include "haptics/contact/proxy/parameters.h"

namespace typodont::haptics {

namespace {

using O = OffsetQueryParameters;
using S = WallSeatParameters;
using R = RefineParameters;
using Rim = RimParameters;
using D = DescentParameters;
using H = HeadSampleParameters;
using L = CreaseContactParameters;

/// Returns true if the tissue has a single smooth surface near x.
bool is_smooth_at(const TissuePatch& patch, const dvec3& x) noexcept {
  if (!patch.holds(x, O::depth_below)) return true;
  const FieldSample at = sample_cubic(patch, x);
  const double slope = glm::length(at.gradient);
  return std::abs(slope - 1) < R::smooth &&
         std::abs(sample_linear(patch, x - O::depth_below * at.gradient) + O::depth_below) < O::foot_tolerance;
}

/// Smallest gap, at most `near`, of the contacts that do not lie on `crease` (an edge, rim or corner of the tissue).
/// `c`: the head's centre. Computed in floats, for SIMD.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
float nearest_off(const Crease* crease, const dvec3* c, const ApproximatePlanes* planes, int count, float near) {
  const auto from_circle = [](float u, float w, float k) {
    const float twice = k * (u * u + w * w) + 2 * w;
    return twice / (1 + std::sqrt(std::max(1 + k * twice, 1e-6f)));
  };
  float above[ContactSet::kMax];
  for (int k = 0; k < crease->count; ++k) {
    const Sheet& sheet = crease->sheet[k];
    const glm::vec3 x(sheet.x - *c), e1(sheet.e1), e2(sheet.e2), n(sheet.n);
    const auto k1 = static_cast<float>(sheet.k1), k2 = static_cast<float>(sheet.k2);
    for (int i = 0; i < count; ++i) {
      const float dx = planes->x[i] - x.x, dy = planes->y[i] - x.y, dz = planes->z[i] - x.z;
      const float u = e1.x * dx + e1.y * dy + e1.z * dz, v = e2.x * dx + e2.y * dy + e2.z * dz;
      const float distance = from_circle(u, from_circle(v, n.x * dx + n.y * dy + n.z * dz, k2), k1);
      above[i] = k == 0 ? distance : std::max(above[i], distance);
    }
  }
  for (int i = 0; i < count; ++i) near = std::min(near, std::abs(above[i]) > S::off_crease ? planes->gap[i] : near);
  return near;
}

/// True if a stored sample below the contact agrees with `crease`; interpolated values are wrong below a crease.
bool agrees_below(const TissuePatch& patch, const Crease& crease, const ContactPlane& contact) noexcept {
  const dvec3 below = glm::floor(contact.x - L::depth * contact.n + 0.5);
  if (!patch.holds(below, 0)) return false;
  const glm::ivec3 q = glm::ivec3(below) - patch.lo;
  return std::abs(patch.distance[patch.at(q.x, q.y, q.z)] - crease.above(below)) < L::agrees;
}

/// Direction of the head's outline at the point p of a piece of the outline.
glm::dvec2 along(const HeadField::Piece& piece, const glm::dvec2& p) noexcept {
  return glm::normalize(piece.radius == 0 ? glm::dvec2(piece.dx, piece.dz)
                                          : glm::dvec2(piece.cz - p.y, p.x - piece.cx));
}

}  // namespace

ContactFinder::ContactFinder(const Tool& tool, double voxel)
    : head_(tool, voxel),
      sphere_(tool.shape == HeadShape::kSphere),
      radius_(tool.radius() / voxel),
      reach_(tool.reach() / voxel),
      samples_(std::make_unique<HeadSamples>(tool, head_, voxel)) {
  if (tool.implant) return;  // an implant's rim contacts would change at the entry of the bed (hole) that guides it
  glm::dvec2 in(1, 0);       // direction of the outline at its start and end, on the axis: perpendicular to the axis
  for (int i = 0; i <= head_.count; ++i) {
    const HeadField::Piece& last = head_.pieces[std::max(i - 1, 0)];
    const HeadField::Piece& next = head_.pieces[std::min(i, head_.count - 1)];
    const glm::dvec2 at = i < head_.count ? glm::dvec2(next.ax, next.az) : glm::dvec2(last.bx, last.bz);
    const glm::dvec2 on = i < head_.count ? along(next, at) : glm::dvec2(-1, 0);
    if (const double c = glm::dot(in, on); c < Rim::sharp)
      rims_[rim_count_++] = {at.x, at.y, c < Rim::blunt ? Rim::near_rim : Rim::near_blunt};
    if (i < head_.count) in = along(next, {next.bx, next.bz});
  }
}

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

/// Finds the contact of a ball by one query of the field at its centre c (offset surface: Kim & Park 2006, sec. 3.2).
/// Exact where the field is smooth. Samples above and below c detect an edge or a second wall.
bool ContactFinder::find_by_offset(const TissuePatch& patch, const dvec3& c, ContactSet& set) const noexcept {
  const FieldSample at = sample_cubic(patch, c);
  const double length = glm::length(at.gradient);
  if (at.value < 0.5 || length < 0.5)
    // The centre is inside tissue, where the field is not the distance to the offset surface.
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
    ContactPlane edge;
    if (patch.holds(foot, 0) && touch_crease(patch, {c, {}}, foot, set.known_, edge) &&
        std::abs(edge.gap + radius_ - distance) < O::foot_tolerance) {
      distance = edge.gap + radius_;
      n = edge.n;
    } else {
      // If one of these tests fails, two walls influence the field at the foot point (surface point nearest to c).
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
bool ContactFinder::find_in_crease(const TissuePatch& patch, const dvec3& c, double near,
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

bool ContactFinder::seat(const TissuePatch& patch, const dvec3& target, const dvec3& c, dvec3& seated, ContactSet& set,
                         bool& alone) const noexcept {
  if (!sphere_ || !patch.holds(target, O::depth_below + S::hand_depth)) return false;
  alone = seat_on_crease(patch, target, c, seated, set);
  return alone || seat_on_wall(patch, target, c, seated, set, alone);
}

/// Computes the position of a ball that the crease of the last contact stops. True only if no other tissue is near.
bool ContactFinder::seat_on_crease(const TissuePatch& patch, const dvec3& target, const dvec3& c, dvec3& seated,
                                   ContactSet& set) const noexcept {
  const Crease* crease = set.known_.last();
  if (!crease || !samples_->cover.empty() || glm::length(set.known_.place() - c) > radius_ + CreaseParameters::followed)
    return false;
  ContactPlane plane;
  const auto touches = [&](const dvec3& x) {
    return crease && crease->above(target) > S::min_height && touch(*crease, {target, {}}, x, plane);
  };
  // In steady sliding, the contact moves on as in the last tick.
  if (!touches(set.known_.touched + std::exchange(set.known_.slid, dvec3(0)))) return false;
  const dvec3 x = plane.x, slid = x - set.known_.touched;
  const bool fitted = glm::length(x - set.known_.place()) > CreaseParameters::reused;
  if (fitted) {
    crease = set.known_.find(patch, x);
    if (!touches(x) || !agrees_below(patch, *crease, plane)) return false;
  }
  const dvec3 on = target - plane.gap * plane.n;
  if (plane.gap > 0 || glm::length(on - c) > kMaxSeated || !patch.holds(on, radius_ + 1)) return false;
  // Checks whether the ball at `on` touches other tissue.
  const bool early = !fitted && glm::dot(slid, slid) <= S::fast * S::fast;
  if (!set.known_.has_room(on, early ? S::used : 1)) {
    constexpr auto kNear = static_cast<float>(S::near + S::ahead);
    const Found found = samples_->search_around(patch, {on, {}}, kNear, set.approximate_);
    const double room = nearest_off(crease, &on, &set.approximate_, found.count, kNear) - S::near;
    if (room <= 0) return false;
    set.known_.add_room(on, room);
  }
  seated = on;
  set.known_.touched = plane.x;
  set.known_.slid = slid;
  plane.gap = 0;
  set.clear();
  set.origin_ = on;
  set.put(0, on, plane);
  set.count_ = 1;
  return true;
}

bool ContactFinder::seat_on_wall(const TissuePatch& patch, const dvec3& target, const dvec3& c, dvec3& seated,
                                 ContactSet& set, bool& alone) const noexcept {
  FieldSample at = sample_cubic(patch, target);
  double slope = glm::length(at.gradient);
  if (at.value < -S::hand_depth || at.value > radius_ || slope < 0.5 ||
      !is_true_around(patch, target, std::abs(at.value)))
    return false;
  // Moves x from the hand onto the wall, and then along the wall, until the wall's normal at x goes through the hand.
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
  if (height > radius_ || glm::length(on - c) > kMaxSeated || !patch.holds(on, 0)) return false;
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

void ContactFinder::find(const TissuePatch& patch, const Pose& X_VT, double near, ContactSet& set,
                         bool fine) const noexcept {
  set.clear();
  set.creases_ = fine;
  const bool uncut = patch.cut_lo.x > patch.cut_hi.x ? patch.exact_outside
                                                     : is_true_around(patch, X_VT.p, sample_linear(patch, X_VT.p));
  const bool held = !patch.whole || patch.holds(X_VT.p, 0);
  if (sphere_ && uncut && held && (find_by_offset(patch, X_VT.p, set) || find_in_crease(patch, X_VT.p, near, set)))
    return;

  const Found found = samples_->search_around(patch, X_VT, static_cast<float>(near), set.approximate_);
  set.origin_ = X_VT.p;
  set.count_ = found.count;
  set.deepest_ = static_cast<double>(found.deepest);
  set.engaged_area_ = static_cast<double>(found.area);
  const dvec3 out(found.area_x, found.area_y, found.area_z);
  set.engaged_normal_ = sphere_ ? -out : -(X_VT.R * out);
  std::fill_n(set.approximate_.yields, found.count, 1.0f);
  if (fine && sphere_ && patch.holds(X_VT.p, 0)) {
    // The contact point may lie between the points of the ball at which the tissue was sampled.
    const FieldSample at = sample_linear_gradient(patch, X_VT.p);
    if (at.value > 0.5 && glm::length(at.gradient) > 0.5)
      find_below(patch, X_VT, X_VT.p - at.value * glm::normalize(at.gradient), near, set);
  }
  if (fine && found.count > 0) find_rims(patch, X_VT, near, set);
  if (!samples_->cover.empty() && (fine || found.count == 0)) find_between_samples(patch, X_VT, near, set);
}

/// Adds the contacts of the head's sharp rims and tip: the points of a rim that are nearest to smooth tissue.
void ContactFinder::find_rims(const TissuePatch& patch, const Pose& X_VT, double near, ContactSet& set) const noexcept {
  const glm::dmat3 axes(X_VT.R);
  const auto add = [&](const dvec3& q, const FieldSample& field, double beside) {
    const double slope = glm::length(field.gradient), gap = field.value / slope;
    if (std::abs(slope - 1) > Rim::gradient_tolerance || gap > near) return;
    const dvec3 n = field.gradient / slope;
    set.put_rim({q - gap * n, n, gap, 1, true}, X_VT.p, beside + 2 * std::abs(gap));
  };
  for (int r = 0; r < rim_count_; ++r) {
    const double radius = rims_[r].radius;
    const dvec3 center = X_VT.p + rims_[r].z * axes[2];
    if (!patch.holds(center, 0) || min_distance(patch, center) > radius + near) continue;
    if (radius == 0) {
      add(center, sample_cubic(patch, center), rims_[r].beside);
      continue;
    }
    const auto out = [&](double angle) { return std::cos(angle) * axes[0] + std::sin(angle) * axes[1]; };
    double value[Rim::max_points];
    const int count = std::clamp(static_cast<int>(2 * kPi * radius / Rim::spacing), 8, Rim::max_points);
    const double turn = 2 * kPi / count;
    for (int i = 0; i < count; ++i) {
      const dvec3 q = center + radius * out(turn * i);
      value[i] = patch.holds(q, 0) ? sample_linear(patch, q) : 1e300;
    }
    for (int i = 0; i < count; ++i) {
      const double last = value[(i + count - 1) % count], next = value[(i + 1) % count];
      if (value[i] > near || value[i] > last || value[i] >= next) continue;
      double bend = (last - 2 * value[i] + next) / (turn * turn), angle = turn * i, slope = 0, moved = 0;
      for (int step = 0; step < Rim::steps; ++step) {
        const dvec3 d = out(angle), q = center + radius * d;
        if (!patch.holds(q, 0)) break;
        const FieldSample field = sample_cubic(patch, q);
        const double before = std::exchange(slope, radius * glm::dot(field.gradient, glm::cross(axes[2], d)));
        if (step > 0 && (slope - before) * moved > 0) bend = (slope - before) / moved;
        moved = std::clamp(-slope / bend, -turn, turn);
        if (std::abs(moved) * radius < Rim::converged) {
          add(q, field, rims_[r].beside);
          break;
        }
        angle += moved;
      }
    }
  }
}

/// Adds the contact that descend() finds from x: the surface point nearest to the head.
void ContactFinder::find_below(const TissuePatch& patch, const Pose& X_VT, const dvec3& x, double near,
                               ContactSet& set) const noexcept {
  ContactPlane plane;
  plane.x = x;
  if (!descend(patch, X_VT, plane.x)) return;
  update_contact(X_VT, plane);
  if (plane.gap >= near) return;
  for (int i = 0; i < set.count_; ++i) {
    if (glm::length(set.plane(i).x - plane.x) < H::same_place) return;
  }
  set.put_own(plane);
}

/// Finds tissue that a large head touches between the samples of its surface.
void ContactFinder::find_between_samples(const TissuePatch& patch, const Pose& X_VT, double near,
                                         ContactSet& set) const noexcept {
  struct Candidate {
    float value;
    dvec3 x;
  };
  Candidate nearest[H::descents] = {};  // sorted by `value`, the distance from tissue
  int count = 0;
  const glm::dmat3 axes(X_VT.R);
  constexpr double kHalfDiagonal = 0.87;  // voxels, half the diagonal of a voxel (√3/2, rounded up)
  const float within = samples_->cover_radius + static_cast<float>(near + kHalfDiagonal);
  for (const glm::vec3& point : samples_->cover) {
    const dvec3 x = X_VT.p + axes * dvec3(point);
    if (patch.whole && !patch.holds(x, 0)) continue;
    const glm::ivec3 q = glm::ivec3(x + 0.5) - patch.lo;
    const float value = patch.distance[patch.at(q.x, q.y, q.z)];
    if (value >= within || (count == H::descents && value >= nearest[count - 1].value)) continue;
    int at = count < H::descents ? count++ : count - 1;
    for (; at > 0 && nearest[at - 1].value > value; --at) nearest[at] = nearest[at - 1];
    nearest[at] = {value, x};
  }
  for (int i = 0; i < count; ++i) find_below(patch, X_VT, nearest[i].x, near, set);
}

void ContactFinder::project_out(const Pose& X_VE, const Pose& X_VT, ContactSet& set) const noexcept {
  // Exact contacts exist only where no cut has changed the tissue, so their surface points need no correction.
  if (set.deep_penetration_ || set.exact_count_ > 0) return;
  set.projects_out_ = true;
  set.emptied_ = X_VE;
  if (same(X_VE, X_VT)) {
    samples_->push_out_here(set.approximate_, set.count_);
    set.deepest_ = 0;
  } else {
    samples_->push_out_at(X_VE.R, glm::vec3(X_VE.p - set.origin_), set.approximate_, set.count_);
    relinearize(X_VT, set);
  }
}

void ContactFinder::find_way_out(const TissuePatch& patch, const Pose& X_VT, ContactSet& set) const noexcept {
  set.count_ = set.exact_count_ = set.added_ = 0;
  set.deepest_ = 0;
  set.origin_ = X_VT.p;
  set.deep_penetration_ = true;
  ApproximatePlanes& planes = set.approximate_;
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
  set.deepest_ = static_cast<double>(
      samples_->update_planes(X_VT.R, glm::vec3(X_VT.p - set.origin_), set.approximate_, set.count_));
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

bool ContactFinder::refine(const TissuePatch& patch, const Pose& X_VT, ContactSet& set, int i,
                           bool fine) const noexcept {
  if (set.deep_penetration_ || set.flat_ || i >= set.own()) return false;
  const ContactSet::Exact* known = set.exact(i);
  const double stays = fine ? R::stays_exact_fine : sphere_ ? R::stays_exact : R::stays_exact_edged;
  if (known && glm::length(known->c - X_VT.p) < stays) return false;
  const ContactPlane rough = set.plane(i);
  if (!patch.holds(rough.x, 0)) return false;
  // Moves the contact point onto the surface, then along it towards the head while the gap decreases. With constant
  // curvature, these steps form a geometric series, so the fine refinement extrapolates its sum (secant method).
  ContactPlane best = rough;
  if (fine && set.creases_ && rough.crease && touch_crease(patch, X_VT, rough.x, set.known_, best)) {
    set.put(i, X_VT.p, best);
    return true;
  }
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
    if (!(gained > 0)) {
      if (!set.creases_ || last_slide == dvec3(0)) break;
      // The step was too long, because the surface is much more curved than the head.
      gain *= R::shortened;
      x = best.x + gain * last_slide;
      continue;
    }
    best = {x, -m, gap, rough.yields};
    if (gained < (fine ? R::gained_fine : R::gained)) break;
    const dvec3 slide = -(radius_ + gap) * (m - glm::dot(m, n) * n);
    if (fine) {
      const double before2 = glm::dot(last_slide, last_slide);
      const double fraction = before2 > 0 ? glm::dot(slide, last_slide) / before2 : 0;
      if (fraction != 0 && fraction < R::still_converges && (set.creases_ || fraction > -R::still_converges))
        gain = std::min(gain / (1 - fraction), R::max_gain);
      else if (!set.creases_)
        gain = 1;
      last_slide = slide;
    }
    x += gain * slide;
  }
  if (best.gap >= rough.gap + 0.5) best = rough;
  if (fine && set.creases_ && !is_smooth_at(patch, best.x)) touch_crease(patch, X_VT, best.x, set.known_, best);
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
  const bool rim = fine && !best.crease && touch_with_rim(patch, X_VT, best);
  set.put(i, X_VT.p, best);
  if (rim) set.put_beside(best, Rim::near_rim + 2 * std::abs(best.gap));
  return true;
}

/// The head's farthest point in the direction `along` (unit vector): an end or an arc of the head's outline.
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

/// If a sharp rim of the head is inside smooth tissue, neither normal of its two sides points out of the tissue.
/// Uses the tissue's normal at the deepest point of the rim instead.
bool ContactFinder::touch_with_rim(const TissuePatch& patch, const Pose& X_VT, ContactPlane& plane) const noexcept {
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

/// Moves x along the interpolated surface to the point nearest to the head, with an error of about half a voxel at a
/// crease. Returns false if the surface is not found.
bool ContactFinder::descend(const TissuePatch& patch, const Pose& X_VT, dvec3& x) const noexcept {
  dvec3 normal, m;
  const auto onto_surface = [&](dvec3& p) {
    for (int step = 0; step < D::surface_steps; ++step) {
      if (!patch.holds(p, 0)) return false;
      const FieldSample at = sample_linear_gradient(patch, p);
      const double slope = glm::length(at.gradient);
      if (slope < D::flat) {  // no direction, for example at a corner
        head_distance(X_VT, p, normal);
        normal = -normal;
        return std::abs(at.value) < D::near_surface;
      }
      normal = at.gradient / slope;
      p -= at.value / std::max(slope, std::min(std::abs(at.value), 1.0)) * normal;
      if (std::abs(at.value) < D::on_surface) return true;
    }
    return patch.holds(p, 0) && std::abs(sample_linear(patch, p)) < D::near_surface;
  };
  if (!onto_surface(x)) return false;
  double gap = head_distance(X_VT, x, m), fraction = 1;
  dvec3 n = normal;
  for (int step = 0; step < D::steps; ++step) {
    const dvec3 slide = -fraction * (radius_ + gap) * (m - glm::dot(m, n) * n);
    if (glm::length(slide) < D::shortest) break;
    dvec3 y = x + slide, my;
    if (!onto_surface(y)) {
      fraction /= 4;
      continue;
    }
    const double next = head_distance(X_VT, y, my);
    if (next < gap) {
      x = y, m = my, n = normal, gap = next;
    } else {
      fraction /= 3;
    }
  }
  return true;
}

/// Finds the point of a sheet (one smooth surface of the tissue) that is nearest to the head.
bool ContactFinder::touch_sheet(const Sheet& sheet, const Pose& X_VT, dvec3 x, ContactPlane& plane) const noexcept {
  dvec3 n, m, last(0);
  if (sphere_) {
    const double height = sheet.distance(X_VT.p, n);
    plane.x = X_VT.p - height * n, plane.n = n, plane.gap = height - radius_;
    return height > 0;
  }
  double gain = 1, gap = 0;
  for (int step = 0;; ++step) {
    x -= sheet.distance(x, n) * n;
    gap = head_distance(X_VT, x, m);
    const dvec3 slide = -(radius_ + gap) * (m - glm::dot(m, n) * n);
    if (glm::dot(slide, slide) < L::slid) break;
    if (step == L::steps) return false;
    const double last2 = glm::dot(last, last), fraction = last2 > 0 ? glm::dot(slide, last) / last2 : 0;
    gain = fraction != 0 && fraction < R::still_converges ? std::min(gain / (1 - fraction), R::max_gain) : 1;
    last = slide;
    x += gain * slide;
  }
  plane.x = x, plane.n = -m, plane.gap = gap;
  return true;
}

/// Finds the point nearest to the head on the line where two smooth surfaces (sheets) meet, by Newton's method. Returns
/// false if the head does not touch the line there, but a smooth surface beside it.
bool ContactFinder::touch_line(const Crease& crease, int i, int j, const Pose& X_VT, dvec3 x,
                               ContactPlane& plane) const noexcept {
  dvec3 n[2], m, slide(0);
  Sheet::Bend bend[2];
  double last = 0, c = 0, step2 = 1e300;
  for (int step = 0; step2 > (sphere_ ? L::last_step : L::slid); ++step) {
    const double above[2] = {crease.sheet[i].distance(x, n[0], bend[0]), crease.sheet[j].distance(x, n[1], bend[1])};
    c = glm::dot(n[0], n[1]);
    const double sine2 = 1 - c * c, inverse2 = 1 / sine2;
    if (step == L::steps || sine2 < CreaseParameters::min_angle) return false;
    // The vector perpendicular to the line that has the components a and b along the normals.
    const auto across = [&](double a, double b) { return inverse2 * ((a - c * b) * n[0] + (b - c * a) * n[1]); };
    const dvec3 t = std::sqrt(inverse2) * glm::cross(n[0], n[1]);
    const dvec3 curvature = -across(bend[0].along(t), bend[1].along(t));
    // first and second derivative of the gap along the line
    const double gap = head_distance(X_VT, x, m), slope = glm::dot(m, t);
    const double straight = (1 - slope * slope) / (radius_ + gap), moved = glm::dot(slide, t);
    const bool secant = !sphere_ && (slope - last) * moved > 0;
    const double rate = secant ? (slope - last) / moved : straight + glm::dot(m, curvature);
    const double way = std::clamp(-slope / (rate > 0 ? rate : straight), -L::longest, L::longest);
    slide = way * t, last = slope;
    const dvec3 by = slide + 0.5 * way * way * curvature - across(above[0], above[1]);
    x += by, step2 = glm::dot(by, by);
  }
  plane.gap = head_distance(X_VT, x, m);
  const double a = -glm::dot(m, n[0]), b = -glm::dot(m, n[1]);
  if (a - c * b < -L::inside_cone || b - c * a < -L::inside_cone) return false;
  plane.x = x, plane.n = -m;
  return true;
}

/// Finds the contact of the head with a convex edge, rim or corner of the tissue near a point. Returns false if there
/// is none.
bool ContactFinder::touch_crease(const TissuePatch& patch, const Pose& X_VT, const dvec3& near, KnownCreases& known,
                                 ContactPlane& plane) const noexcept {
  dvec3 x = near;
  if (!descend(patch, X_VT, x) || !is_sharp_at(patch, x)) return false;
  const auto touches = [&](const Crease& crease) {
    ContactPlane contact = plane;
    if (!touch(crease, X_VT, x, contact) || !agrees_below(patch, crease, contact)) return false;
    plane = contact;
    return true;
  };
  if (const Crease* crease = known.find(patch, x); crease && touches(*crease)) return true;
  dvec3 n;
  head_distance(X_VT, x, n);
  if (known.is_none(x, n)) return false;
  Crease crease;
  if (!find_crease(patch, x, -n, crease)) {
    known.add_none(x, n);
    return false;
  }
  if (!touches(crease)) return false;
  known.add(x, crease);
  return true;
}

/// Finds the contact of the head with a crease near x, a point of the interpolated surface.
bool ContactFinder::touch(const Crease& crease, const Pose& X_VT, const dvec3& x, ContactPlane& plane) const noexcept {
  ContactPlane found = plane;
  found.crease = true;
  const double gap = head_distance(X_VT, x, found.n);
  // The tissue is convex at the crease, so the first point that passes the following tests is nearest to the head.
  const auto is_contact = [&] { return crease.above(found.x) < L::feasible; };
  bool touches = false;
  for (int i = 0; i < crease.count && !touches; ++i) {
    for (int j = 0; j < i && !touches; ++j)
      touches = touch_line(crease, i, j, X_VT, x, found) && (crease.count == 2 || is_contact());
  }
  for (int i = 0; i < crease.count && !touches; ++i)
    touches = touch_sheet(crease.sheet[i], X_VT, x, found) && is_contact();
  if (!touches && crease.count == Crease::kMost) {
    found.x = x;
    dvec3 n[Crease::kMost];
    touches = crease.onto_corner(found.x, n);
    found.gap = head_distance(X_VT, found.x, found.n);
    found.n = -found.n;
  }
  if (!touches || found.gap > gap + L::farther || found.gap < gap - L::nearer) return false;
  plane = found;
  return true;
}

}  // namespace typodont::haptics
