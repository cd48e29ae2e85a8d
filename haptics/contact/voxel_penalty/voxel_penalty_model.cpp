#include "haptics/contact/voxel_penalty/voxel_penalty_model.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptics/contact/tool_check.h"
#include "haptics/contact/voxel_penalty/voxel_penalty_method.h"
#include "haptics/cutting/carve.h"
#include "haptics/cutting/voxel_stamp.h"

namespace typodont::haptics::voxel_penalty {

namespace {

/// Returns a factor for the stiffness of all springs. With this factor, a head in a flat wall has the scene's stiffness
/// (mean over directions); otherwise it is too soft. `reach`: head's farthest point, in the samples' unit.
double spring_scale(const std::vector<HeadSample>& samples, double reach, int shared_load) {
  // assumed depth of the head in the flat wall, divided by the smallest distance of a sample from the head's centre
  constexpr double kPressed = 0.5;
  double width = reach;
  for (const HeadSample& s : samples) width = std::min(width, glm::length(s.p_TQ));
  const double depth = kPressed * width;
  double sum = 0;
  for (const HeadSample& side : samples) {
    const dvec3 in = side.n_T;  // unit vector into the flat wall
    double lowest = -reach;
    for (const HeadSample& s : samples) lowest = std::max(lowest, glm::dot(in, s.p_TQ));
    double below = 0;
    int count = 0;
    for (const HeadSample& s : samples) {
      // Depth of the sample below the wall. The spring acts along the sample's normal.
      const double h = depth - (lowest - glm::dot(in, s.p_TQ));
      if (h > 0) below += h, ++count;
    }
    sum += below / std::max(count, shared_load) / depth;
  }
  return static_cast<double>(samples.size()) / sum;
}

}  // namespace

VoxelPenaltyModel::VoxelPenaltyModel(const ServoSettings& settings, const Parameters& parameters)
    : PatchModel(settings), parameters_(parameters) {
  refuse_tools_that_fill(tool_set(settings), kName);
  for (const Tool& tool : tool_set(settings)) {
    Head head{tool, sample_head(tool, parameters.samples), tool.reach() / voxel()};
    for (HeadSample& sample : head.samples) sample.p_TQ /= voxel();
    head.spring_scale = spring_scale(head.samples, head.reach, parameters.shared_load);
    heads_.push_back(std::move(head));
  }
  touching_.resize(static_cast<std::size_t>(parameters.samples));
}

double VoxelPenaltyModel::clearance(const Pose& X_WG) noexcept {
  // voxels, upper bound of the distance from a voxel's centre to its corner (√3/2)
  constexpr double kCorner = 0.9;
  const dvec3 c = settings_.frame.to_voxels(X_WG.p);
  if (!patch_.covers(c, head().reach + 1)) return 0;
  const double clearance = std::min(min_distance(patch_, c) - kCorner, patch_.reach_around(c) - 1) - head().reach - 1;
  return std::max(0.0, clearance) * voxel();
}

bool VoxelPenaltyModel::is_free(std::uint32_t tool, const Pose& X_WG) noexcept {
  const Pose X_VT{settings_.frame.to_voxels(X_WG.p), X_WG.R};
  if (!patch_.covers(X_VT.p, heads_[tool].reach + 1)) return false;
  probe(heads_[tool], X_VT);
  return count_ == 0;
}

bool VoxelPenaltyModel::is_full(const glm::ivec3& v) const noexcept {
  const glm::ivec3 at = v - patch_.lo;
  return patch_.distance[patch_.at(at.x, at.y, at.z)] < 0;
}

/// Depth of the tissue from x along the unit vector `direction`, voxels, at most `most`: steps from voxel to voxel
/// (Amanatides & Woo 1987).
double VoxelPenaltyModel::depth_along(const dvec3& x, const dvec3& direction, double most) const noexcept {
  glm::ivec3 at = glm::ivec3(glm::round(x));
  dvec3 next, step;
  glm::ivec3 sign;
  for (int i = 0; i < 3; ++i) {
    sign[i] = direction[i] > 0 ? 1 : -1;
    const bool moves = std::abs(direction[i]) > 1e-12;
    step[i] = moves ? 1 / std::abs(direction[i]) : std::numeric_limits<double>::infinity();
    next[i] = moves ? (at[i] + 0.5 * sign[i] - x[i]) / direction[i] : std::numeric_limits<double>::infinity();
  }
  double depth = 0;
  while (depth < most && is_full(at)) {
    const int axis = next.x < next.y ? (next.x < next.z ? 0 : 2) : (next.y < next.z ? 1 : 2);
    depth = next[axis];
    next[axis] += step[axis];
    at[axis] += sign[axis];
  }
  return std::min(depth, most);
}

/// Finds the samples of a head at X_VT (voxels) that are inside full voxels.
void VoxelPenaltyModel::probe(const Head& head, const Pose& X_VT) noexcept {
  count_ = 0;
  c_ = X_VT.p;
  for (const HeadSample& sample : head.samples) {
    const dvec3 x = X_VT * sample.p_TQ;
    const glm::ivec3 at = glm::ivec3(glm::round(x));
    if ((patch_.whole && !patch_.holds(x, 0)) || !is_full(at)) continue;
    const dvec3 n = X_VT.R * sample.n_T;
    const glm::ivec3 in_patch = at - patch_.lo;
    const Tissue tissue = shown(patch_.tissue[patch_.at(in_patch.x, in_patch.y, in_patch.z)]);
    touching_[count_++] = {x,           n,      depth_along(x, -n, 2 * head.reach),
                           sample.area, tissue, hardness_at(patch_, dvec3(at))};
  }
}

void VoxelPenaltyModel::constrain(const ContactInput& in, Contact& out) noexcept {
  out.spring.whole = true;
  count_ = 0;
  const Pose X_VT{settings_.frame.to_voxels(in.X_WT.p), in.X_WT.R};
  out.gap.lost = !patch_.covers(X_VT.p, head().reach + 1);
  if (out.gap.lost) return;
  probe(head(), X_VT);
  out.touching = count_ > 0;
  for (std::size_t i = 0; i < count_; ++i) out.area += touching_[i].area;
  sum_springs(in, out);
}

/// Each spring pushes along its sample's normal, in proportion to the sample's depth. Division by the number of samples
/// in contact (at least `shared_load`) keeps the stiffness constant (McNeely, Puterbaugh & Troy 1999, sec. 5.2). The
/// damper acts only on approach.
void VoxelPenaltyModel::sum_springs(const ContactInput& in, Contact& out) const noexcept {
  const double h = voxel();
  const double per_sample =
      head().spring_scale * settings_.stiffness /
      static_cast<double>(std::max<std::size_t>(count_, static_cast<std::size_t>(parameters_.shared_load)));
  for (std::size_t i = 0; i < count_; ++i) {
    const Touching& t = touching_[i];
    const double k = per_sample * settings_.materials[static_cast<std::size_t>(t.tissue)].stiffness / 1000 * t.hardness;
    const dvec3 push = -k * t.depth * h * t.n;
    out.spring.force += push;
    out.spring.torque += glm::cross(h * (t.x - c_), push);
    out.spring.stored += k * t.depth * h * t.depth * h / 2;
    out.spring.depth = std::max(out.spring.depth, t.depth * h);
  }
  const double size = glm::length(out.spring.force);
  if (!(size > 0)) return;
  const dvec3 n = out.spring.force / size;
  const double approach = -glm::dot(in.moved, n) / in.dt;
  if (approach > 0) out.spring.force += settings_.damping * approach * n;
}

/// Moves the head out along the force until it just touches, and back in as far as the energy allows. Removes the
/// voxels whose centres it covers.
bool VoxelPenaltyModel::cut(const ContactInput& in, Contact& contact, Cut& cut, double& energy) noexcept {
  const double size = glm::length(contact.spring.force);
  if (!(in.removal.cuts && count_ > 0 && size > 0 && in.removal.budget > 0 && in.removal.specific_energy > 0))
    return false;
  const double bought = in.removal.budget / in.removal.specific_energy / contact.area;
  const dvec3 out_of = contact.spring.force / size;
  const Pose X_WB{in.X_WT.p + std::max(0.0, contact.spring.depth - bought) * out_of, in.X_WT.R};
  const VoxelStamp stamp(head().tool, X_WB, settings_.frame);
  bool changed;
  PerTissue hardened;
  const PerTissue removed = carve(patch_, stamp, &changed, &hardened);
  if (!changed) return false;
  cut.X_WA = cut.X_WB = X_WB;
  book(removed, hardened, cut, energy);
  log_.add(++cut_count_, stamp.lo(), stamp.hi(), {X_WB, X_WB, tool_, false, 0, removed});
  return true;
}

PerTissue VoxelPenaltyModel::repeat(const CutLog::Made& made, std::uint64_t, TissuePatch& fresh) noexcept {
  return carve(fresh, VoxelStamp(heads_[made.tool].tool, made.X_WB, settings_.frame));
}

void VoxelPenaltyModel::feel(const ContactInput&, Contact&, Felt& out) noexcept {
  double total = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    if (touching_[i].tissue == Tissue::kAir) continue;
    out.tissue[static_cast<std::size_t>(touching_[i].tissue)] += touching_[i].depth;
    out.hardness[static_cast<std::size_t>(touching_[i].tissue)] += touching_[i].depth * touching_[i].hardness;
    total += touching_[i].depth;
  }
  if (total > 0) out.average(total, !patch_.hardness.empty());
}

}  // namespace typodont::haptics::voxel_penalty
