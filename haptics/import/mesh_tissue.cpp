#include "haptics/import/mesh_tissue.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <set>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "haptics/import/distance.h"
#include "haptics/import/import.h"
#include "haptics/import/import_scan.h"
#include "haptics/import/mesh.h"

namespace typodont::haptics {

using importing::Grid;
using importing::Mask;
using importing::Triangle;

namespace {

constexpr std::size_t kMostTriangles = 10'000'000;
constexpr double kLeastVoxel = 0.1e-3;                      // m, where nothing else is asked for
constexpr double kUsualVoxels = 12e6;                       // that a volume has at most where nothing else is asked for
constexpr double kVoxelStep = 0.01e-3;                      // m, to which the voxel is rounded up
constexpr double kBand = 1.5e-3;                            // m
constexpr double kLeastLength = 0.5e-3, kMostLength = 0.6;  // m, of a mesh
constexpr int kInside = 3;                                  // sixths of a turn from which on a sample is inside

/// Six times the volume that the triangles enclose, as seen from the first vertex.
double six_volumes(const TissueMesh& mesh) {
  const dvec3 from = mesh.vertices.front();
  double sum = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    sum += glm::dot(mesh.vertices[t.x] - from, glm::cross(mesh.vertices[t.y] - from, mesh.vertices[t.z] - from));
  }
  return sum;
}

/// Whether every edge lies between two triangles that run along it in opposite directions.
bool is_closed(const TissueMesh& mesh) {
  std::vector<std::array<unsigned, 3>> edges;  // both ends, ordered, and the direction
  for (const glm::uvec3& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const unsigned a = t[k], b = t[(k + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), a < b});
    }
  }
  std::ranges::sort(edges);
  for (std::size_t first = 0; first < edges.size();) {
    std::size_t end = first, up = 0;
    for (; end < edges.size() && edges[end][0] == edges[first][0] && edges[end][1] == edges[first][1]; ++end)
      up += edges[end][2];
    if (2 * up != end - first) return false;
    first = end;
  }
  return true;
}

std::size_t drop_copies(std::vector<glm::uvec3>& triangles) {
  std::set<std::array<unsigned, 3>> known;
  return std::erase_if(triangles, [&](const glm::uvec3& t) {
    std::array<unsigned, 3> turned{t.x, t.y, t.z};
    std::ranges::rotate(turned, std::ranges::min_element(turned));
    return !known.insert(turned).second;
  });
}

}  // namespace

MeshTissueOptions read_mesh_tissue_options(const Json& json) {
  json.allow_only({"file", "unit_mm", "tissue", "voxel_mm"});
  MeshTissueOptions options;
  options.file = json["file"].string();
  options.unit = json.number_or("unit_mm", 1, 1e-6, 1e6) * kMillimetre;
  const Json named = json["tissue"];
  const auto tissue = tissue_named(named.string());
  if (!tissue || *tissue == Tissue::kAir) named.fail("the name of a tissue");
  options.tissue = *tissue;
  if (const auto voxel = json.find("voxel_mm")) options.voxel = voxel->number(5e-3, 2) * kMillimetre;
  return options;
}

ReadTissueMesh read_tissue_mesh(const std::filesystem::path& file, double unit, Tissue tissue) {
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (std::ranges::find(mesh_endings(), ending) == mesh_endings().end() && ending != ".gltf" && ending != ".glb") {
    throw Error(file.string(), "file", fmt::format("\"{}\"", ending), "a mesh: .stl, .ply, .obj, .gltf or .glb");
  }
  std::size_t collapsed = 0;
  const importing::Mesh read = importing::read_surface(file, unit, collapsed);
  if (read.corners.size() > kMostTriangles) {
    throw Error(file.string(), "mesh", fmt::format("{} triangles", read.corners.size()),
                fmt::format("at most {}", kMostTriangles));
  }
  ReadTissueMesh result;
  TissueMesh& mesh = result.mesh;
  mesh.vertices = read.points;
  for (const auto& c : read.corners) mesh.triangles.emplace_back(c[0], c[1], c[2]);
  const std::size_t copies = drop_copies(mesh.triangles);
  mesh.tissue.assign(mesh.triangles.size(), tissue);

  dvec3 lo(1e300), hi(-1e300);
  for (const dvec3& p : mesh.vertices) lo = glm::min(lo, p), hi = glm::max(hi, p);
  const dvec3 extent = hi - lo;
  const double longest = std::max({extent.x, extent.y, extent.z});
  if (!(longest >= kLeastLength && longest <= kMostLength)) {
    throw Error(file.string(), "size",
                fmt::format("a mesh {:.4g} mm long at {:g} mm a unit", longest / kMillimetre, unit / kMillimetre),
                fmt::format("{:g} to {:g} mm; say what its unit is (\"unit_mm\")", kLeastLength / kMillimetre,
                            kMostLength / kMillimetre));
  }
  if (six_volumes(mesh) < 0 && is_closed(mesh)) {
    for (glm::uvec3& t : mesh.triangles) std::swap(t.y, t.z);
    result.repairs.emplace_back("turned inside out: its triangles enclosed a negative volume");
  }
  if (collapsed > 0) result.repairs.push_back(fmt::format("{} triangles with two equal corners left out", collapsed));
  if (copies > 0) result.repairs.push_back(fmt::format("{} second copies of triangles left out", copies));
  return result;
}

DenseTissue rasterize(const TissueMesh& mesh, const MeshTissueOptions& options) {
  dvec3 lo(1e300), hi(-1e300);
  for (const dvec3& p : mesh.vertices) lo = glm::min(lo, p), hi = glm::max(hi, p);
  const dvec3 around = hi - lo + 2 * kBand;
  double voxel = options.voxel.value_or(kLeastVoxel);
  if (!options.voxel) {
    const double needed = std::cbrt(around.x * around.y * around.z / kUsualVoxels);
    voxel = std::max(voxel, kVoxelStep * std::ceil(needed / kVoxelStep));
  }
  importing::check_result_size(around + 6 * voxel, voxel);
  DenseTissue out;
  out.band = kBand;
  out.frame.voxel = voxel;
  const double margin = kBand + 2 * voxel;
  out.frame.origin = voxel * glm::floor((lo - margin) / voxel);
  out.size = glm::ivec3(glm::ceil((hi + margin - out.frame.origin) / voxel)) + 1;
  std::vector<Triangle> triangles;
  for (const glm::uvec3& t : mesh.triangles) {
    triangles.push_back({out.frame.to_voxels(mesh.vertices[t.x]), out.frame.to_voxels(mesh.vertices[t.y]),
                         out.frame.to_voxels(mesh.vertices[t.z])});
  }

  const double band = kBand / voxel;
  const Grid<std::int16_t> sixths = importing::winding_sixths(triangles, out.size);
  const auto inside = [&](std::size_t i) { return sixths.v[i] >= kInside; };
  // Triangles within the tissue (where parts of the mesh overlap) bound nothing.
  constexpr double kBeside = 1.5;  // voxels
  std::vector<Triangle> skin;
  for (const Triangle& t : triangles) {
    const dvec3 normal = glm::cross(t.b - t.a, t.c - t.a), center = (t.a + t.b + t.c) / 3.0;
    const double size = glm::length(normal);
    const auto is_inside = [&](double side) {
      const glm::ivec3 p(glm::round(center + side * kBeside / size * normal));
      return sixths.holds(p) && inside(sixths.index(p));
    };
    if (!(size > 0) || !is_inside(1) || !is_inside(-1)) skin.push_back(t);
  }
  Grid<float> distance = importing::unsigned_distance(skin, out.size, band);

  std::size_t within = 0;
  for (std::size_t i = 0; i < sixths.v.size(); ++i) within += inside(i);
  const bool sheet = within < 8;
  // Where inside and outside meet away from the mesh, there is the cap of an opening.
  Mask cap(out.size, 0);
  bool capped = false;
  if (!sheet) {
    constexpr float kOnMesh = 1;  // voxels
    const glm::ivec3 steps[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (std::size_t i = 0; i < distance.v.size(); ++i) {
      if (distance.v[i] <= kOnMesh) continue;
      const glm::ivec3 p = distance.place(i);
      for (const glm::ivec3& step : steps) {
        if (!distance.holds(p + step)) continue;
        const std::size_t j = distance.index(p + step);
        if (distance.v[j] <= kOnMesh || inside(i) == inside(j)) continue;
        cap.v[i] = cap.v[j] = 1;
        capped = true;
      }
    }
  }
  const Grid<float> to_cap = capped ? importing::distance_squared_to(cap) : Grid<float>();
  out.exact_outside = !capped && !sheet;
  out.distance.resize(distance.v.size());
  out.tissue.assign(distance.v.size(), Tissue::kAir);
  constexpr double kShell = 1, kLabelled = 2.5;  // voxels: half a sheet's thickness; how far outside labels are kept
  for (std::size_t i = 0; i < distance.v.size(); ++i) {
    double d = static_cast<double>(distance.v[i]);
    if (capped) d = std::min(d, std::sqrt(static_cast<double>(to_cap.v[i])) + 0.5);
    if (sheet) d -= kShell;
    if (inside(i) && !sheet) d = -d;
    out.distance[i] = static_cast<float>(std::clamp(d * voxel, -kBand, kBand));
    if (d <= kLabelled) out.tissue[i] = options.tissue;
  }
  return out;
}

}  // namespace typodont::haptics
