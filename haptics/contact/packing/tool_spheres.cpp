#include "haptics/contact/packing/tool_spheres.h"

#include <algorithm>
#include <cmath>

#include "engine/base/error.h"
#include "haptics/sphere_packer.h"

namespace typodont::haptics::packing {

namespace {

constexpr double kSamples = 48;  // of the field, along the longest side of the tool

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
  field.tissue.assign(count, Tissue::kEnamel);  // any: a tool is of one kind
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
  options.max_radius = field.band;  // large spheres are no loss: nothing cuts a tool
  const SpherePacking packing = pack_spheres(field, options);

  ToolSpheres result{packing.center, packing.radius, dvec3(0), 0};
  double volume = 0;
  for (std::size_t i = 0; i < packing.size(); ++i) {
    const double v = std::pow(packing.radius[i], 3);
    result.com_T += v * packing.center[i];
    volume += v;
    result.reach = std::max(result.reach, glm::length(packing.center[i]) + packing.radius[i]);
  }
  result.com_T /= volume;
  return result;
}

}  // namespace

ToolSpheres tool_spheres(const Tool& tool, std::size_t spheres, std::uint64_t seed) {
  if (tool.shape == HeadShape::kSphere) return {{dvec3(0)}, {tool.radius()}, dvec3(0), tool.radius()};
  const dvec3 half(tool.radius(), tool.radius(), tool.half());
  return packed(-half, half, spheres, seed, [&](const dvec3& p) { return tool.distance(p); });
}

ToolSpheres tool_spheres(const Solid& solid_T, std::size_t spheres, std::uint64_t seed) {
  dvec3 lo, hi;
  solid_T.bounds(lo, hi);
  if (!is_finite(lo) || !is_finite(hi)) throw Error("tool", "", "an unbounded solid", "a closed one");
  return packed(lo, hi, spheres, seed, [&](const dvec3& p) { return solid_T.distance(p); });
}

}  // namespace typodont::haptics::packing
