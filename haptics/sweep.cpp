#include "haptics/sweep.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "haptics/cutting/block.h"
#include "haptics/cutting/cut_front.h"

namespace typodont::haptics {

namespace {

// Longest path of a short sweep, voxels. A short sweep cuts at its end pose, then searches for samples that were deeper
// in the head earlier on the path.
constexpr double kShort = 3;
// Largest sideways motion of a drill "along its axis" per step, voxels. Over the depth of a whole implant bed, the sum
// stays far below kTop (5e-4 voxels), the tolerance of depths.
constexpr double kAlongAxis = 1e-9;

/// Returns true for a cylinder with a flat end. The fast code for the rim is exact only for this shape.
bool has_rim(const MeridianPiece& end, const MeridianPiece& flank) {
  return end.nax == 0 && end.naz == -1 && flank.nax == 1 && flank.naz == 0 && end.length == flank.ax &&
         end.bz == flank.az;
}

/// Returns true if the drill moves from A to B (voxels) along its axis, with the free end ahead.
bool moves_along_axis(const Tool& tool, const Pose& A, const Pose& B, double reach) {
  if (!tool.implant || tool.implant->kind != ImplantToolKind::kDrill) return false;
  // The head must be at least as long as wide. With a shorter head, the upper end could change samples that the lower
  // end cuts.
  if (tool.shape != HeadShape::kCylinder || tool.length < tool.diameter) return false;
  const dvec3 axis = A.R * dvec3(0, 0, -1), travel = B.p - A.p;
  const double along = glm::dot(travel, axis);
  const double turned = reach * glm::length(B.R * dvec3(0, 0, -1) - axis);
  return along >= 0 && glm::length(travel - along * axis) + turned <= kAlongAxis;
}

// Largest distance of a sample's curved path from the straight segments that replace it, voxels.
constexpr double kBend = 0.01;
// voxels; replaces kBend for a head with a round end, whose error Straight::bend_turn makes much smaller
constexpr double kMaxBend = 0.03;

}  // namespace

Sweep::Sweep(const Tool& tool, const Pose& X_WA, const Pose& X_WB, const VoxelFrame& frame, bool continues)
    : sphere_(tool.shape == HeadShape::kSphere), continues_(continues) {
  const dvec3 a = frame.to_voxels(X_WA.p), b = frame.to_voxels(X_WB.p);
  base_ = glm::ivec3(glm::floor(a));
  a_ = glm::vec3(a - dvec3(base_));
  ab_ = glm::vec3(b - a);
  const float length2 = glm::dot(ab_, ab_);
  inverse_length2_ = length2 > 1e-12f ? 1 / length2 : 0;
  radius_ = static_cast<float>(tool.radius() / frame.voxel);
  X_VA_ = {a, X_WA.R};
  X_VB_ = {b, X_WB.R};

  const double reach = reach_ = tool.reach() / frame.voxel;
  half_length_ = tool.length / 2 / frame.voxel;
  travel_ = sphere_ ? glm::length(b - a) : displacement_bound(X_VA_, X_VB_, reach);
  if (!sphere_) {
    // In the frame of a rotating head, a sample's path is curved. It deviates from a straight line by an eighth of the
    // change of its direction vector.
    turn_ = rotation_angle(X_VA_.R, X_VB_.R);
    const double bend = turn_ * (turn_ * (reach + kMargin) + 2 * glm::length(b - a)) / 8;
    const HeadField head(tool, frame.voxel);
    flatten(head, pieces_);
    bends_ = turn_ > 0 && head.count > 1 && has_round_end(pieces_, 1);
    const double most = bends_ ? kMaxBend : kBend;
    straights_ = std::clamp(static_cast<int>(std::ceil(std::sqrt(bend / most))), 1, 512);
    if (straights_ == 1 && travel_ <= kShort && bend <= kBend) straights_ = 0;
    back_ = straight_path(X_VB_, X_VA_, pieces_, head.count, reach);
    along_axis_ =
        continues && straights_ == 0 && has_rim(pieces_[0], pieces_[1]) && moves_along_axis(tool, X_VA_, X_VB_, reach);
    if (along_axis_) {
      // If a drill moves along its axis, samples that were nearest to its flank at the start pose A do not change.
      const MeridianPiece& end = pieces_[0];  // from the axis to the rim
      const auto moved = static_cast<float>(glm::length(b - a));
      back_.still_above = end.bz + moved, back_.still_beyond = end.bx + end.bz + moved;
    }
  }

  // The enclosing ball of a slender head is mostly empty. So for a short path, the box encloses the cylinders at both
  // poses.
  const auto extent = [&](const Pose& X) {
    if (sphere_ || straights_ > 0) return dvec3(reach + kMargin);
    const dvec3 axis = X.R * dvec3(0, 0, 1);
    const dvec3 across = glm::sqrt(glm::max(dvec3(1) - axis * axis, dvec3(0)));
    const double half = along_axis_ ? 0 : tool.length / 2;
    return (half * glm::abs(axis) + tool.radius() * across) / frame.voxel + (kMargin + 1e-6);
  };
  // A drill that moves along its axis cuts only near its end face.
  const dvec3 to_end = along_axis_ ? X_WA.R * dvec3(0, 0, -tool.length / 2 / frame.voxel) : dvec3(0);
  const dvec3 extent_a = extent(X_WA), extent_b = extent(X_WB);
  lo_ = glm::ivec3(glm::ceil(to_end + glm::min(a - extent_a, b - extent_b)));
  hi_ = glm::ivec3(glm::floor(to_end + glm::max(a + extent_a, b + extent_b)));
}

bool Sweep::carve(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x,
                  std::size_t stride_y, const Tissue* tissue, RemovedVolume* removed) const noexcept {
  if (straights_ > 0) {
    return carve_path(
        {lo, size, distance, static_cast<std::ptrdiff_t>(stride_x), static_cast<std::ptrdiff_t>(stride_y), tissue},
        removed, nullptr);
  }
  return sphere_ ? carve_ball(lo, size, distance, stride_x, stride_y, tissue, removed)
                 : carve_head(lo, size, distance, stride_x, stride_y, tissue, removed);
}

void Sweep::carve(std::span<Leaf> leaves, float path) const noexcept {
  if (!sphere_ && straights_ == 0) {
    carve_head_leaves(leaves, path);
    return;
  }
  for (Leaf& leaf : leaves) {
    const LeafCut cut = sphere_ ? carve_leaf_ball(leaf.lo, leaf.distance) : carve_leaf_path(leaf.lo, leaf.distance);
    leaf.changed = cut.changed, leaf.emptied = cut.emptied;
    std::fill_n(leaf.due, Leaf::kBlocks, path + cut.safe_travel);
  }
}

Sweep::LeafCut Sweep::carve_leaf_path(const glm::ivec3& lo, float* distance) const noexcept {
  LeafCut cut;
  constexpr std::size_t n = kLeaf;
  float safe_travel[Leaf::kBlocks] = {};
  const DueBlocks blocks{safe_travel, lo / glm::ivec3(kRows, kRows, kRowLength), {2, 2, 1}, 0, rounding_of_depth()};
  cut.changed = cut.emptied = carve_path({lo, glm::ivec3(kLeaf), distance, n * n, n, nullptr}, nullptr, &blocks);
  cut.safe_travel = *std::min_element(safe_travel, safe_travel + Leaf::kBlocks);
  return cut;
}

bool Sweep::same_head(const Sweep& other) const noexcept {
  if (sphere_ != other.sphere_ || radius_ != other.radius_ || reach_ != other.reach_) return false;
  return sphere_ || (half_length_ == other.half_length_ && back_.count == other.back_.count &&
                     std::memcmp(pieces_, other.pieces_, sizeof *pieces_ * static_cast<std::size_t>(back_.count)) == 0);
}

double Sweep::path_from(const Sweep& before) const noexcept {
  return travel_ + (sphere_ ? glm::length(X_VA_.p - before.X_VB_.p) : displacement_bound(before.X_VB_, X_VA_, reach_));
}

bool Sweep::holds_listed(const glm::ivec3& patch_lo, int n) const noexcept {
  // Largest distance of a listed sample from the sweep's box, voxels: listed path + later motion + rounding.
  constexpr int kListedBeyond = 3;
  const glm::ivec3 lo = lo_ - patch_lo, hi = patch_lo + n - 1 - hi_;
  return std::min({lo.x, lo.y, lo.z, hi.x, hi.y, hi.z}) > kListedBeyond;
}

bool Sweep::carve(CutFront& front, const glm::ivec3& patch_lo, int n, float* distance, const Tissue* tissue,
                  RemovedVolume* removed) const noexcept {
  front.begin_sweep(along_axis_);
  // The path length also includes motion through air since the last sweep.
  const double travel = sphere_ ? glm::length(X_VA_.p - front.X_V_.p) : displacement_bound(front.X_V_, X_VA_, reach_);
  front.advance_to(X_VB_, (front.known_ ? travel : 0) + travel_);
  // The lists contain samples up to a voxel beyond the sweep's box, so the tissue patch must contain them too.
  const glm::ivec3 room_lo = lo_ - patch_lo, room_hi = patch_lo + n - 1 - hi_;
  const bool inside = std::min({room_lo.x, room_lo.y, room_lo.z, room_hi.x, room_hi.y, room_hi.z}) > 1;
  if (!inside || !front.holds(lo_ - 1, hi_ + 1)) {
    const glm::ivec3 lo = glm::max(lo_, patch_lo), size = glm::min(hi_, patch_lo + n - 1) - lo + 1;
    if (size.x <= 0 || size.y <= 0 || size.z <= 0) return false;
    const glm::ivec3 at = lo - patch_lo;
    const auto edge = static_cast<std::size_t>(n), start = (at.x * edge + at.y) * edge + at.z;
    return carve(lo, size, distance + start, edge * edge, edge, tissue + start, removed);
  }
  front.move_around(lo_ - 1, hi_ + 1);
  if (straights_ > 0) {
    const DueBlocks blocks{front.due_.data(), front.first_, front.size_, static_cast<float>(front.path_length_),
                           rounding_of_depth()};
    return carve_path({patch_lo, glm::ivec3(n), distance, n * n, n, tissue}, removed, &blocks);
  }
  return sphere_ ? carve_ball(front, patch_lo, n, distance, tissue, removed)
                 : carve_head(front, patch_lo, n, distance, tissue, removed);
}

}  // namespace typodont::haptics
