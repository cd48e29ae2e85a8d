#include "haptics/contact/packing/tool_spheres.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/packing.h"

namespace typodont::haptics::packing {

namespace {

constexpr double kSamples = 48;  // number of samples along the longest side of a tool given as a solid
// distance of neighbouring spheres in a chain divided by their radius; notches between them: 2 % of the radius deep
constexpr double kChainStep = 0.4;
// kCells: grid nodes across the head's radius. kRingStep: distance of neighbouring spheres in a ring divided by their
// radius. kMinCovered: a ring is added only if (volume that it newly covers / head's volume) is at least this.
constexpr int kCells = 25;
constexpr double kRingStep = 0.8, kMinCovered = 2e-4;

/// Represents a part that never cuts by a chain of inscribed spheres along the axis.
void add_chain(const NonCuttingPart& part, ToolSpheres& to) {
  const double half = part.shape.half();
  const auto depth = [&](double z) { return -part.shape.distance(dvec3(0, 0, z)); };
  const double least = 0.1 * part.shape.radius();
  for (double z = -half + least; z <= half - least;) {
    const double r = depth(z);
    to.add_non_cutting(dvec3(0, 0, part.z + z), r);
    z += std::max(kChainStep * r, 0.5 * least);
  }
}

/// Fills a head with rings (around the axis) of overlapping inscribed spheres. Each step adds the ring that newly
/// covers the most volume per sphere. The result is smoother than a packing.
class Rings {
 public:
  explicit Rings(const Tool& tool)
      : side_(tool.radius() / kCells),
        levels_(static_cast<int>(std::floor(2 * tool.half() / side_)) + 1),
        bottom_(-tool.half()),
        depth_(kCells * static_cast<std::size_t>(levels_)),
        covered_(depth_.size()),
        open_((kCells + 1) * static_cast<std::size_t>(levels_)) {
    for (int j = 0; j < levels_; ++j) {
      for (int i = 0; i < kCells; ++i) {
        depth_[node(i, j)] = -tool.distance(dvec3(rho(i), 0, z(j)));
        covered_[node(i, j)] = !(depth_[node(i, j)] > 0);
      }
      add_up(j);
      enough_ += kMinCovered * open_[sum(kCells, j)];
    }
  }

  ToolSpheres choose(std::size_t most) {
    std::vector<dvec3> centers;
    std::vector<double> radii;
    while (true) {
      int best_i = -1, best_j = 0;
      double max_gain = 0;  // largest (volume that a new ring would cover / number of spheres in the ring)
      for (int j = 0; j < levels_; ++j) {
        for (int i = 0; i < kCells; ++i) {
          const std::size_t count = in_ring(i, j);
          if (count == 0 || centers.size() + count > most) continue;
          const double gain = covers(i, j);
          if (gain < enough_ || gain <= max_gain * static_cast<double>(count)) continue;
          max_gain = gain / static_cast<double>(count);
          best_i = i, best_j = j;
        }
      }
      if (best_i < 0) {
        ToolSpheres head(std::move(centers), std::move(radii));
        for (std::size_t k = 0; k < head.head; ++k) head.curve[k] += glm::length(glm::dvec2(head.center_T[k]));
        return head;
      }
      const std::size_t count = in_ring(best_i, best_j);
      for (std::size_t k = 0; k < count; ++k) {
        const double angle = 2 * kPi * static_cast<double>(k) / static_cast<double>(count);
        centers.emplace_back(rho(best_i) * std::cos(angle), rho(best_i) * std::sin(angle), z(best_j));
        radii.push_back(depth_[node(best_i, best_j)]);
      }
      cover(best_i, best_j);
    }
  }

 private:
  std::size_t node(int i, int j) const { return static_cast<std::size_t>(j * kCells + i); }
  std::size_t sum(int i, int j) const { return static_cast<std::size_t>(j * (kCells + 1) + i); }
  double rho(int i) const { return i * side_; }
  double z(int j) const { return bottom_ + j * side_; }
  /// Volume of the ring-shaped grid cell at the distance i · side_ from the axis, in units of 2π side_³.
  static double weight(int i) { return i > 0 ? i : 0.125; }
  void add_up(int level) {
    for (int i = 0; i < kCells; ++i) {
      open_[sum(i + 1, level)] = open_[sum(i, level)] + (covered_[node(i, level)] ? 0 : weight(i));
    }
  }
  /// Number of spheres of the ring through node (i, j); 0: the node is outside the head.
  std::size_t in_ring(int i, int j) const {
    const double r = depth_[node(i, j)];
    if (!(r > 0)) return 0;
    return i > 0 ? std::max<std::size_t>(3, static_cast<std::size_t>(std::ceil(2 * kPi * rho(i) / (kRingStep * r))))
                 : 1;
  }
  /// Calls f(level, first, end) for the grid nodes that a ring of spheres covers in every direction around the axis.
  template <class F>
  void each_level(int i, int j, F&& f) const {
    const double half = kPi * rho(i) / static_cast<double>(in_ring(i, j)), r = depth_[node(i, j)];
    const double thick2 = (r * r - half * half) / (side_ * side_);
    if (!(thick2 > 0)) return;
    const int most = static_cast<int>(std::sqrt(thick2));
    for (int dj = -std::min(most, j); dj <= most && j + dj < levels_; ++dj) {
      const int di = static_cast<int>(std::sqrt(std::max(0.0, thick2 - dj * dj)));
      f(j + dj, std::max(0, i - di), std::min(kCells, i + di + 1));
    }
  }
  /// Volume that the ring of spheres through node (i, j) covers and no earlier ring does.
  double covers(int i, int j) const {
    double gain = 0;
    each_level(i, j, [&](int level, int from, int to) { gain += open_[sum(to, level)] - open_[sum(from, level)]; });
    return gain;
  }
  void cover(int i, int j) {
    each_level(i, j, [&](int level, int from, int to) {
      for (int k = from; k < to; ++k) covered_[node(k, level)] = 1;
      add_up(level);
    });
  }

  double side_;                        // m, distance between grid nodes
  int levels_;                         // number of levels (planes of grid nodes perpendicular to the axis)
  double bottom_;                      // m along the axis, height of the lowest level
  std::vector<double> depth_;          // for each node: its depth below the surface, m
  std::vector<std::uint8_t> covered_;  // for each node: true if outside the head, or inside a ring of spheres
  std::vector<double> open_;           // for each node: uncovered volume at its level between axis and node
  double enough_ = 0;
};

}  // namespace

ToolSpheres::ToolSpheres(std::vector<dvec3> centers_T, std::vector<double> radii)
    : center_T(std::move(centers_T)), radius(std::move(radii)), curve(radius), head(radius.size()) {
  for (std::size_t i = 0; i < head; ++i) head_reach = std::max(head_reach, glm::length(center_T[i]) + radius[i]);
  reach = head_reach;
}

void ToolSpheres::add_non_cutting(const dvec3& p_T, double r) {
  center_T.push_back(p_T);
  radius.push_back(r);
  reach = std::max(reach, glm::length(p_T) + r);
}

ToolSpheres tool_spheres(const Tool& tool, std::size_t spheres) {
  ToolSpheres result =
      tool.shape == HeadShape::kSphere ? ToolSpheres({dvec3(0)}, {tool.radius()}) : Rings(tool).choose(spheres);
  for (const auto& part : {shank_of(tool), safe_end_of(tool)}) {
    if (part) add_chain(*part, result);
  }
  return result;
}

ToolSpheres tool_spheres(const Solid& solid_T, std::size_t spheres, std::uint64_t seed) {
  dvec3 lo, hi;
  solid_T.bounds(lo, hi);
  if (!is_finite(lo) || !is_finite(hi)) throw Error("tool", "", "an unbounded solid", "a closed one");
  const dvec3 extent = hi - lo;
  DenseTissue field;
  field.frame.voxel = std::max({extent.x, extent.y, extent.z}) / kSamples;
  field.frame.origin = lo - 2 * field.frame.voxel;
  field.size = glm::ivec3(glm::ceil(extent / field.frame.voxel)) + 5;
  field.band = glm::length(extent);
  const std::size_t count = voxel_count(field.size);
  field.distance.resize(count);
  field.tissue.assign(count, Tissue::kEnamel);  // any label, because a tool consists of one material
  for_each_voxel(field.size, [&](int x, int y, int z) {
    field.distance[field.at(x, y, z)] = static_cast<float>(solid_T.distance(field.frame.to_world(dvec3(x, y, z))));
  });
  PackOptions options;
  options.spheres = spheres;
  options.seed = seed;
  // no limit of the spheres' radius: this length is larger than the tool
  options.max_radius = field.band;
  const SpherePacking packing = pack_spheres(field, options);
  return {packing.center, packing.radius};
}

}  // namespace typodont::haptics::packing
