#include "haptics/mesh/spatial_order.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace typodont::haptics::mesh {

namespace {

constexpr int kBits = 21;  // bits per coordinate in a key of 64 bits

/// Inserts two zero bits after each bit of v.
std::uint64_t spread_bits(std::uint64_t v) {
  v = (v | v << 32) & 0x001f00000000ffffU;
  v = (v | v << 16) & 0x001f0000ff0000ffU;
  v = (v | v << 8) & 0x100f00f00f00f00fU;
  v = (v | v << 4) & 0x10c30c30c30c30c3U;
  v = (v | v << 2) & 0x1249249249249249U;
  return v;
}

}  // namespace

TissueMesh in_spatial_order(TissueMesh mesh) {
  if (mesh.triangles.empty()) return mesh;
  std::vector<dvec3> centers;
  centers.reserve(mesh.triangles.size());
  dvec3 lo(1e300), hi(-1e300);
  for (const glm::uvec3& t : mesh.triangles) {
    centers.push_back((mesh.vertices[t.x] + mesh.vertices[t.y] + mesh.vertices[t.z]) / 3.0);
    lo = glm::min(lo, centers.back()), hi = glm::max(hi, centers.back());
  }
  const double extent = std::max({hi.x - lo.x, hi.y - lo.y, hi.z - lo.z, 1e-9});
  const double scale = static_cast<double>((1 << kBits) - 1) / extent;
  std::vector<std::uint64_t> keys;
  keys.reserve(centers.size());
  for (const dvec3& c : centers) {
    const glm::u64vec3 at((c - lo) * scale);
    keys.push_back(spread_bits(at.x) << 2 | spread_bits(at.y) << 1 | spread_bits(at.z));
  }
  std::vector<std::uint32_t> order(keys.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::stable_sort(order, {}, [&](std::uint32_t i) { return keys[i]; });
  std::vector<glm::uvec3> triangles;
  std::vector<Tissue> tissue;
  triangles.reserve(order.size()), tissue.reserve(order.size());
  for (const std::uint32_t i : order) {
    triangles.push_back(mesh.triangles[i]);
    tissue.push_back(mesh.tissue[i]);
  }
  mesh.triangles = std::move(triangles), mesh.tissue = std::move(tissue);
  return mesh;
}

}  // namespace typodont::haptics::mesh
