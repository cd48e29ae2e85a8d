#include "haptics/contact/offset/offset_model.h"

#include <algorithm>
#include <cmath>

namespace typodont::haptics::offset {

namespace {

/// Directions that are evenly distributed over the sphere (Fibonacci lattice).
std::vector<glm::vec3> evenly_around(std::size_t count) {
  std::vector<glm::vec3> all;
  for (std::size_t i = 0; i < count; ++i) {
    const double turn = kPi * (3 - std::sqrt(5.0)) * static_cast<double>(i),
                 z = 1 - (2.0 * static_cast<double>(i) + 1) / static_cast<double>(count);
    const double rho = std::sqrt(1 - z * z);
    all.emplace_back(rho * std::cos(turn), rho * std::sin(turn), z);
  }
  return all;
}

/// Lattice points in the head, frame T, voxels. Spacing: the fewest whole voxels that give at most kMaxInside points.
std::vector<dvec3> lattice_in(const Tool& tool, double voxel) {
  constexpr std::size_t kMaxInside = 2048;
  const HeadField head(tool, voxel);
  const int reach = static_cast<int>(tool.reach() / voxel);
  std::vector<dvec3> points;
  for (int step = 1; points.empty() || points.size() > kMaxInside; ++step) {
    points.clear();
    for (int x = -reach / step * step; x <= reach; x += step)
      for (int y = -reach / step * step; y <= reach; y += step)
        for (int z = -reach / step * step; z <= reach; z += step)
          if (head.distance(dvec3(x, y, z)) <= 0) points.emplace_back(x, y, z);
  }
  return points;
}

}  // namespace

OffsetModel::OffsetModel(const ServoSettings& settings, bool mean_stiffness)
    : PatchModel(settings),
      retreat_{voxel(), 1},
      front_(tool_set(settings), settings.frame.voxel),
      coarse_front_(
          tool_set(settings),
          settings.frame.voxel * std::max(1, coarse_grid_for(tool_set(settings), settings.frame.voxel, 0).every)) {
  const double h = settings.frame.voxel;
  for (const Tool& each : tool_set(settings)) {
    heads_.push_back({each, ContactFinder(each, h), NonCuttingContacts(each, h), near_reach(each) / h,
                      mean_stiffness ? lattice_in(each, h) : std::vector<dvec3>{}});
    if (each.fill != Tissue::kAir && flow_directions_.empty()) {
      flow_directions_ = evenly_around(FillingParameters::directions);
    }
  }
  for (const Material& material : settings.materials) hardest_ = std::max(hardest_, material.specific_energy);
}

double OffsetModel::clearance(const Pose& X_WG) noexcept {
  const Pose X_VT{settings_.frame.to_voxels(X_WG.p), X_WG.R};
  if (!patch_.covers(X_VT.p, reach() + 1)) return 0;
  double clearance = std::min(free_distance(X_VT.p), patch_.reach_around(X_VT.p) - reach() - 1) - 1;
  if (smooth().any()) clearance = std::min(clearance, smooth().clearance(patch_, X_VT) - 1);
  return clearance > 1 ? clearance * voxel() : 0;
}

void OffsetModel::begin_anew() noexcept {
  emptied_ = false;
  overlap_ = 0;
  contacts_.clear();
  retreat_.forget();
}

void OffsetModel::release() noexcept {
  missing_.forget();
  breaking_through_ = emptied_ = false;
  contacts_.clear();
  held_.count = 0;
}

bool OffsetModel::is_free(std::uint32_t which, const Pose& X_WG) noexcept {
  if (which == tool_) return overlap_ == 0;  // its contact force is zero
  const Pose X_VT{settings_.frame.to_voxels(X_WG.p), X_WG.R};
  const ContactFinder& other = heads_[which].finder;
  NonCuttingContacts& parts = heads_[which].smooth;
  const double far = heads_[which].reach;
  if (!patch_.covers(X_VT.p, far + 1)) return false;
  const double distance = min_distance(patch_, X_VT.p);
  parts.forget();
  if (distance > far + 2 && parts.clearance(patch_, X_VT) > SearchParameters::contact_range) return true;
  if (distance <= 0) return false;
  other.find(patch_, X_VT, SearchParameters::contact_range, contacts_);
  if (parts.any()) parts.find(patch_, X_VT, SearchParameters::contact_range, contacts_);
  for (int i = 0; i < contacts_.count(); ++i) {
    if (contacts_.plane(i).gap <= 0) return false;
  }
  return true;
}

void OffsetModel::take_up(std::uint32_t which) noexcept {
  finish_coarse();
  tool_ = which;
  smooth().forget();
  contacts_.clear();
  contacts_.forget_creases();
  front_.forget();
  coarse_front_.forget();
  held_ = {};
}

/// Sets the contact data in `out`, including the mean tissue below the contacts, weighted by their forces.
void OffsetModel::feel(const ContactInput& in, Contact&, Felt& out) noexcept {
  // voxels, depth below the surface at which a contact's tissue is read
  constexpr double kFeltBelow = 0.5;
  const Step& p = step_;
  const double h = voxel();
  out.turns_tool = tool().shape != HeadShape::kSphere || heads_[tool_].smooth.any();
  out.unit = h;
  out.count = contacts_.count();
  out.own = contacts_.own();
  const bool graded = !patch_.hardness.empty(), mean = !heads_[tool_].inside.empty() && feel_mean(in, out);
  double total = 0;
  for (int i = 0; i < p.active.count; ++i) {
    const int which = p.active.index[i];
    const ContactPlane plane = contacts_.plane(which);
    const double weight = p.active.push[i];
    total += weight;
    out.add(weight, plane.x - p.c, plane.n, which < contacts_.own());
    if (mean) continue;
    dvec3 below = plane.x - kFeltBelow * plane.n;
    const TissuePatch* felt_in = &patch_;
    if (!patch_.holds(below, 0)) {
      if (patch_.coarse_levels.empty()) continue;
      felt_in = &patch_.coarse_levels.front();
      below = plane.x / static_cast<double>(felt_in->every) - kFeltBelow * plane.n;
      if (!felt_in->holds(below, 0)) continue;
    }
    const Tissue sole = graded ? Tissue::kAir : sole_tissue(*felt_in, below);
    if (sole != Tissue::kAir) {
      // Usual case: one contact, one tissue with fraction 1.
      out.known_tissue = p.active.count == 1 && weight > 0;
      out.tissue[static_cast<std::size_t>(sole)] += out.known_tissue ? 1 : weight;
      continue;
    }
    const PerTissue here = sample_tissue(*felt_in, below);
    for (std::size_t t = 1; t < here.size(); ++t) out.tissue[t] += weight * here[t];
    if (!graded) continue;
    const PerTissue hardened = sample_hardness(*felt_in, below);
    for (std::size_t t = 1; t < here.size(); ++t) out.hardness[t] += weight * hardened[t];
  }
  double labelled = 0;
  if (!out.known_tissue) {
    for (const double fraction : out.tissue) labelled += fraction;
  }
  if (labelled > 0) out.average(labelled, graded);
  if (total > 0) out.lever /= total;
}

/// Computes the mean tissue over the points of the head that lie in tissue. Returns false if no point does.
bool OffsetModel::feel_mean(const ContactInput& in, Felt& out) const noexcept {
  const Pose X_VT{settings_.frame.to_voxels(in.X_WT.p), in.X_WT.R};
  const bool graded = !patch_.hardness.empty();
  double count = 0;
  for (const dvec3& p : heads_[tool_].inside) {
    const dvec3 at = X_VT * p;
    if (!patch_.holds(at, 0)) continue;
    const glm::ivec3 q(at - dvec3(patch_.lo) + 0.5);
    const std::size_t i = patch_.at(q.x, q.y, q.z);
    const auto tissue = static_cast<std::size_t>(shown(patch_.tissue[i]));
    if (patch_.distance[i] > 0 || tissue == 0) continue;
    ++count;
    ++out.tissue[tissue];
    if (graded) out.hardness[tissue] += hardness_fraction(felt_hardness(patch_, i));
  }
  if (count == 0) return false;
  out.average(count, graded);
  return true;
}

}  // namespace typodont::haptics::offset
