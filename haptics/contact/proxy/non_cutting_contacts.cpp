#include "haptics/contact/proxy/non_cutting_contacts.h"

#include <algorithm>
#include <cmath>

#include "haptics/contact/proxy/parameters.h"

namespace typodont::haptics {

namespace {

using P = NonCuttingPartParameters;

}  // namespace

CoarseGrid coarse_grid_for(std::span<const Tool> tools, double voxel, double travel) {
  double reach = 0;
  for (const Tool& tool : tools) {
    if (const auto shank = shank_of(tool))
      reach = std::max(reach, shank->z + std::hypot(shank->shape.length / 2, shank->shape.radius()));
  }
  if (reach == 0) return {};
  const int every = std::max(2, static_cast<int>(std::lround(P::spacing / voxel)));
  // Half the edge of the coarse tissue patch in samples. 6: space for the interpolation stencil and for moved samples.
  const double half = (reach / voxel + travel) / every + 6;
  return {every, 2 * static_cast<int>(std::ceil(half)) + 1};
}

NonCuttingContacts::Part::Part(const NonCuttingPart& part, double voxel, double patch_voxel)
    : finder(part.shape, patch_voxel),
      z(part.z / voxel),
      half(part.shape.length / 2 / voxel),
      neck((part.shape.shape == HeadShape::kShaft ? part.shape.neck_diameter : part.shape.diameter) / 2 / voxel),
      radius(part.shape.radius() / voxel),
      taper(std::max(part.shape.neck_length / voxel, 1e-3)) {}

NonCuttingContacts::NonCuttingContacts(const Tool& tool, double voxel) : head_(tool.radius() / voxel) {
  every_ = std::max(2, static_cast<int>(std::lround(P::spacing / voxel)));
  if (const auto part = shank_of(tool)) shank_.emplace(*part, voxel, every_ * voxel);
  if (const auto part = safe_end_of(tool)) safe_end_.emplace(*part, voxel, voxel);
}

Pose NonCuttingContacts::in_part(const Part& part, const Pose& X_VT, int every) const noexcept {
  return {(X_VT.p + X_VT.R * dvec3(0, 0, part.z)) / static_cast<double>(every), X_VT.R};
}

double NonCuttingContacts::clearance(const TissuePatch& patch, const Pose& X_VT) noexcept {
  if (!shank_ || patch.coarse_levels.empty()) return 1e300;
  const Part& shank = *shank_;
  if (known_) {
    // Upper bound of the rotation since the last search: 2 acos |q·q'| ≤ 2.3 √(2 - 2 |q·q'|) for the orientations q and
    // q'.
    const double turned = 2.3 * std::sqrt(std::max(0.0, 2 - 2 * std::abs(glm::dot(X_VT.R, at_.R))));
    const double left = free_ - glm::length(X_VT.p - at_.p) - turned * (shank.z + shank.half);
    if (left > std::max(P::close_room, std::min(P::enough_room, free_ / 2))) return left;
  }
  // Sphere tracing along the shank's axis: each step is as long as the tissue's distance in the field allows.
  const TissuePatch& wide = patch.coarse_levels.front();
  const dvec3 axis = X_VT.R * dvec3(0, 0, 1), from = X_VT.p + (shank.z - shank.half) * axis;
  const double slope = (shank.radius - shank.neck) / shank.taper;
  const double top = 2 * shank.half, min_step = 0.3 * every_;
  double least = 1e300;
  for (double u = 0;;) {
    const dvec3 p = (from + u * axis) / static_cast<double>(every_);
    if (!wide.covers(p, 0)) {
      least = 0;
      break;
    }
    const double radius = shank.radius_at(u);
    const double around = sample_linear(wide, p);
    // Upper bound of the error of linear interpolation. Where all samples have the largest stored distance (the band),
    // it is the sagitta of an arc of radius `band` over the diagonal √3 of a cell.
    const double blurred = around > wide.band - P::at_band ? 3 / (8 * wide.band) : P::overestimate;
    const double clear = (around - blurred) * every_ - radius;
    // Here the shank is at least `clear` from tissue; after a step s along the axis, at least clear - s (1 + slope).
    // This bound is poor for large s, so the step is a third of the s at which the bound is zero.
    const double step = std::max(0.3 * clear / (1 + slope), min_step);
    if (tolerated_overlap(radius, wide, p) < every_) least = std::min(least, clear - step * (1 + slope) / 2);
    if (least <= 0 || u >= top) break;
    u = std::min(u + step, top);
  }
  known_ = true;
  free_ = least;
  at_ = X_VT;
  return least;
}

void NonCuttingContacts::search(const Part& part, const TissuePatch& patch, const Pose& X, double near,
                                bool shank) noexcept {
  if (!patch.covers(X.p, part.finder.reach() + 1)) return;
  set_.forget_creases();  // of another part
  part.finder.find(patch, X, near, set_);
  if (set_.deepest() > ContactFinder::kDeepPenetration || sample_linear(patch, X.p) < -part.finder.reach()) {
    part.finder.find_way_out(patch, X, set_);
  }
  if (shank) search_from_axis(part, patch, X, near);
  // Selects contacts with the smallest gaps. Skips contacts whose direction and position are nearly those of a selected
  // one.
  bool refused[ContactSet::kMax + 8];
  double let[ContactSet::kMax + 8];
  for (int i = 0; i < set_.count(); ++i) {
    let[i] = shank ? tolerated_overlap(part, patch, X, set_.plane(i)) / every_ : 0;
    refused[i] = let[i] >= 1;
  }
  const auto gap = [&](int i) { return set_.approximate().gap[i] + let[i]; };
  for (int taken = 0; taken < kMost && count_ < kCapacity; ++taken) {
    int best = -1;
    for (int i = 0; i < set_.count(); ++i) {
      if (!refused[i] && (best < 0 || gap(i) < gap(best))) best = i;
    }
    if (best < 0) return;
    const ContactPlane plane = set_.plane(best);
    contacts_[static_cast<std::size_t>(count_++)] = {plane, shank, let[best]};
    for (int i = 0; i < set_.count(); ++i) {
      const ContactPlane other = set_.plane(i);
      refused[i] |= i == best ||
                    (glm::dot(other.n, plane.n) > P::same_direction && glm::length(other.x - plane.x) < P::same_place);
    }
  }
}

/// Returns the allowed overlap (voxels) of tissue at x and a part with this `radius`. Near cuts, the coarse field is
/// too inexact for contact of a part that is hardly wider than the head, such as a thin neck in a hole.
double NonCuttingContacts::tolerated_overlap(double radius, const TissuePatch& patch, const dvec3& x) const noexcept {
  if (radius >= head_ + 2 * every_ || patch.cut_lo.x > patch.cut_hi.x) return 0;
  const dvec3 off = glm::max(dvec3(patch.cut_lo) - x, x - dvec3(patch.cut_hi));
  return std::max({off.x, off.y, off.z}) <= 2 ? head_ + 2 * every_ - radius : 0.0;
}

double NonCuttingContacts::tolerated_overlap(const Part& part, const TissuePatch& patch, const Pose& X,
                                             const ContactPlane& plane) const noexcept {
  const double u = std::max(glm::dot(plane.x - X.p, X.R * dvec3(0, 0, 1)) * every_ + part.half, 0.0);
  return tolerated_overlap(part.radius_at(u), patch, plane.x);
}

/// Adds a contact computed from points on the part's axis, where the field is smooth. Needed near an edge of the
/// tissue, which may touch the shank between the samples of the shank's surface.
void NonCuttingContacts::search_from_axis(const Part& part, const TissuePatch& patch, const Pose& X,
                                          double near) noexcept {
  const dvec3 axis = X.R * dvec3(0, 0, 1);
  const double half = part.half / every_, first = part.neck / every_, widest = part.radius / every_;
  ContactPlane best;
  best.gap = near;
  for (double u = -half + first; u <= half; u += 0.7) {
    const dvec3 p = X.p + u * axis;
    const double around = sample_linear(patch, p);
    if (!patch.holds(p, 0) || around > widest + near + P::overestimate || around < 1.5 ||
        !is_true_around(patch, p, around))
      continue;
    const FieldSample field = sample_cubic(patch, p);
    const double slope = glm::length(field.gradient);
    if (std::abs(slope - 1) > 0.05) continue;
    ContactPlane plane;
    plane.x = p - field.value * field.gradient / slope;
    if (!patch.holds(plane.x, 0) || sample_linear(patch, plane.x) > P::edge_distance) continue;
    part.finder.update_contact(X, plane);
    if (plane.gap < best.gap) best = plane;
  }
  if (best.gap < near) contacts_[static_cast<std::size_t>(count_++)] = {best, true, 0};
}

void NonCuttingContacts::append_to(ContactSet& set) const noexcept {
  for (int i = 0; i < count_; ++i) {
    const Known& known = contacts_[static_cast<std::size_t>(i)];
    const double every = known.shank ? every_ : 1;
    ContactPlane plane = known.plane;
    plane.x *= every, plane.gap = std::max((plane.gap + known.let) * every, -P::led_out), plane.yields = 0;
    if (!set.add(plane)) return;
  }
}

void NonCuttingContacts::find(const TissuePatch& patch, const Pose& X_VT, double near, ContactSet& set) noexcept {
  count_ = 0;
  if (shank_ && clearance(patch, X_VT) <= near) {
    search(*shank_, patch.coarse_levels.front(), in_part(*shank_, X_VT, every_), near / every_, true);
  }
  if (safe_end_) search(*safe_end_, patch, in_part(*safe_end_, X_VT, 1), near, false);
  append_to(set);
}

void NonCuttingContacts::relinearize(const Pose& X_VT, ContactSet& set) noexcept {
  for (int i = 0; i < count_; ++i) {
    Known& known = contacts_[static_cast<std::size_t>(i)];
    const Part& part = known.shank ? *shank_ : *safe_end_;
    part.finder.update_contact(in_part(part, X_VT, known.shank ? every_ : 1), known.plane);
  }
  append_to(set);
}

}  // namespace typodont::haptics
