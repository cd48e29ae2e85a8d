#include "haptics/contact/packing/tool_spheres.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/base/error.h"
#include "haptics/sphere_packer.h"

namespace typodont::haptics::packing {

namespace {

constexpr double kSamples = 48;  // number of samples of the field along the longest side of the tool
// Ratio of the distance between two spheres of a chain to their radius: the notch between two spheres is then 2 % of
// the radius deep.
constexpr double kChainStep = 0.4;

/// Adds inscribed spheres along the axis of a part that never cuts.
void add_chain(const NonCuttingPart& part, ToolSpheres& to) {
  const double half = part.shape.half();
  const auto room = [&](double z) { return -part.shape.distance(dvec3(0, 0, z)); };
  const double least = 0.1 * part.shape.radius();
  for (double z = -half + least; z <= half - least;) {
    const double r = room(z);
    to.add_non_cutting(dvec3(0, 0, part.z + z), r);
    z += std::max(kChainStep * r, 0.5 * least);
  }
}

template <class Distance>
ToolSpheres packed(const dvec3& lo, const dvec3& hi, std::size_t spheres, std::uint64_t seed, Distance&& distance) {
  const dvec3 extent = hi - lo;
  DenseTissue field;
  field.frame.voxel = std::max({extent.x, extent.y, extent.z}) / kSamples;
  field.frame.origin = lo - 2 * field.frame.voxel;
  field.size = glm::ivec3(glm::ceil(extent / field.frame.voxel)) + 5;
  field.band = glm::length(extent);
  const std::size_t count = static_cast<std::size_t>(field.size.x) * field.size.y * field.size.z;
  field.distance.resize(count);
  field.tissue.assign(count, Tissue::kEnamel);  // any tissue is possible here, because a tool has only one material
  for (int x = 0; x < field.size.x; ++x) {
    for (int y = 0; y < field.size.y; ++y) {
      for (int z = 0; z < field.size.z; ++z) {
        field.distance[field.at(x, y, z)] = static_cast<float>(distance(field.frame.to_world(dvec3(x, y, z))));
      }
    }
  }
  PackOptions options;
  options.spheres = spheres;
  options.seed = seed;
  options.max_radius = field.band;  // large spheres are allowed, because nothing cuts a tool
  const SpherePacking packing = pack_spheres(field, options);

  return {packing.center, packing.radius};
}

}  // namespace

ToolSpheres::ToolSpheres(std::vector<dvec3> centers_T, std::vector<double> radii)
    : center_T(std::move(centers_T)), radius(std::move(radii)), head(radius.size()) {
  double volume = 0;
  for (std::size_t i = 0; i < head; ++i) {
    const double v = std::pow(radius[i], 3);
    com_T += v * center_T[i];
    volume += v;
    head_reach = std::max(head_reach, glm::length(center_T[i]) + radius[i]);
  }
  com_T /= volume;
  reach = head_reach;
}

void ToolSpheres::add_non_cutting(const dvec3& p_T, double r) {
  center_T.push_back(p_T);
  radius.push_back(r);
  reach = std::max(reach, glm::length(p_T) + r);
}

ToolSpheres tool_spheres(const Tool& tool, std::size_t spheres, std::uint64_t seed) {
  const dvec3 half(tool.radius(), tool.radius(), tool.half());
  ToolSpheres result = tool.shape == HeadShape::kSphere
                           ? ToolSpheres({dvec3(0)}, {tool.radius()})
                           : packed(-half, half, spheres, seed, [&](const dvec3& p) { return tool.distance(p); });
  for (const auto& part : {shank_of(tool), safe_end_of(tool)}) {
    if (part) add_chain(*part, result);
  }
  return result;
}

ToolSpheres tool_spheres(const Solid& solid_T, std::size_t spheres, std::uint64_t seed) {
  dvec3 lo, hi;
  solid_T.bounds(lo, hi);
  if (!is_finite(lo) || !is_finite(hi)) throw Error("tool", "", "an unbounded solid", "a closed one");
  return packed(lo, hi, spheres, seed, [&](const dvec3& p) { return solid_T.distance(p); });
}

}  // namespace typodont::haptics::packing
