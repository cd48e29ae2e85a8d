#include "haptics/import/mesh_tissue.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/base/error.h"
#include "engine/base/keys.h"
#include "engine/base/lower_case.h"
#include "engine/base/units.h"
#include "haptics/import/import.h"
#include "haptics/import/import_scan.h"
#include "haptics/import/mesh.h"
#include "haptics/import/mesh_fill.h"
#include "haptics/import/mesh_repair.h"
#include "haptics/solid.h"

namespace typodont::haptics {

using importing::Triangle;

namespace {

constexpr std::size_t kMaxTriangles = 10'000'000;
constexpr double kMinVoxel = 0.1e-3;   // m, smallest voxel edge that is chosen automatically
constexpr double kUsualVoxels = 12e6;  // number of voxels, if their edge is chosen automatically
// Automatically chosen edges are multiples of this, m.
constexpr double kVoxelStep = 0.01e-3;
constexpr double kBand = 1.5e-3;                         // m, largest distance from the surface that the volume stores
constexpr double kMinArea = 1e-9;                        // smallest area of a mesh, as a fraction of its squared extent
constexpr double kMinLength = 0.5e-3, kMaxLength = 0.6;  // m, smallest and largest value of a mesh's longest extent

/// Six times the enclosed volume: a sum over tetrahedra whose common corner is the first vertex.
double six_volumes(const TissueMesh& mesh) {
  const dvec3 from = mesh.vertices.front();
  double sum = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    sum += glm::dot(mesh.vertices[t.x] - from, glm::cross(mesh.vertices[t.y] - from, mesh.vertices[t.z] - from));
  }
  return sum;
}

/// Returns true if all edges occur equally in both directions.
bool is_closed(const TissueMesh& mesh) {
  // For each edge: its sorted vertices, and its direction.
  std::vector<std::array<unsigned, 3>> edges;
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

}  // namespace

void describe_mesh_tissue(Keys& keys, MeshTissueOptions& options) {
  keys(must("file"), options.file, "STL, PLY, OBJ, glTF (`.gltf`, `.glb`) or 3MF, at most 10 million triangles");
  keys("unit_mm", options.unit, {1e-6, 1e6, kMillimetre}, "length of one unit of the file in millimetres");
  keys("move_mm", options.move, kMillimetre, "vector that is added to all points");
  if (const auto name = keys(must("tissue"), kName, "tissue of all triangles"))
    options.tissue = read_tissue_name(*name);
  keys("voxel_mm", options.voxel, {5e-3, 2, kMillimetre},
       "voxel size of the volume that is computed from the mesh. Default: 0.1, or more if the volume would otherwise "
       "have "
       "more than 12 million voxels");
}

MeshTissueOptions read_mesh_tissue_options(const Json& json) {
  return read_keys(json, describe_mesh_tissue);
}

ReadTissueMesh read_tissue_mesh(const std::filesystem::path& file, double unit, Tissue tissue) {
  const std::string ending = lower_case(file.extension().string());
  if (std::ranges::find(mesh_endings(), ending) == mesh_endings().end()) {
    throw Error(file.string(), "file", fmt::format("\"{}\"", ending), "a mesh: .stl, .ply, .obj, .gltf, .glb or .3mf");
  }
  importing::MeshRepairs repairs;
  importing::Mesh read = importing::read_surface(file, unit, repairs);
  if (read.corners.size() > kMaxTriangles) {
    throw Error(file.string(), "mesh", fmt::format("{} triangles", read.corners.size()),
                fmt::format("at most {}", kMaxTriangles));
  }
  importing::drop_copies(read, repairs);
  ReadTissueMesh result;
  TissueMesh& mesh = result.mesh;
  mesh.vertices = read.points;
  for (const auto& c : read.corners) mesh.triangles.emplace_back(c[0], c[1], c[2]);
  mesh.tissue.assign(mesh.triangles.size(), tissue);

  dvec3 lo(1e300), hi(-1e300);
  for (const dvec3& p : mesh.vertices) lo = glm::min(lo, p), hi = glm::max(hi, p);
  const dvec3 extent = hi - lo;
  const double longest = std::max({extent.x, extent.y, extent.z});
  if (!(longest >= kMinLength && longest <= kMaxLength)) {
    throw Error(file.string(), "size",
                fmt::format("a mesh {:.4g} mm long at {:g} mm a unit", longest / kMillimetre, unit / kMillimetre),
                fmt::format("{:g} to {:g} mm; say what its unit is (\"unit_mm\")", kMinLength / kMillimetre,
                            kMaxLength / kMillimetre));
  }
  double area = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    area += glm::length(glm::cross(mesh.vertices[t.y] - mesh.vertices[t.x], mesh.vertices[t.z] - mesh.vertices[t.x]));
  }
  if (!(area > kMinArea * longest * longest)) {
    throw Error(file.string(), "mesh", fmt::format("{} triangles without area", mesh.triangles.size()), "a surface");
  }
  if (six_volumes(mesh) < 0 && is_closed(mesh)) {
    for (glm::uvec3& t : mesh.triangles) std::swap(t.y, t.z);
    result.repairs.emplace_back("turned inside out: its triangles enclosed a negative volume");
  }
  for (std::string& words : repairs.in_words()) result.repairs.push_back(std::move(words));
  return result;
}

ReadTissueMesh read_tissue_mesh(const std::filesystem::path& file, const MeshTissueOptions& options) {
  ReadTissueMesh read = read_tissue_mesh(file, options.unit, options.tissue);
  for (dvec3& p : read.mesh.vertices) p += options.move;
  return read;
}

DenseTissue rasterize(const TissueMesh& mesh, const MeshTissueOptions& options) {
  dvec3 lo(1e300), hi(-1e300);
  for (const dvec3& p : mesh.vertices) lo = glm::min(lo, p), hi = glm::max(hi, p);
  const dvec3 around = hi - lo + 2 * kBand;
  double voxel = options.voxel.value_or(kMinVoxel);
  if (!options.voxel) {
    const double needed = std::cbrt(around.x * around.y * around.z / kUsualVoxels);
    voxel = std::max(voxel, kVoxelStep * std::ceil(needed / kVoxelStep));
  }
  importing::check_result_size(around + 6 * voxel, voxel);
  DenseTissue out = importing::volume_around(lo, hi, voxel, kBand);
  std::vector<std::vector<Triangle>> parts(1);
  for (const glm::uvec3& t : mesh.triangles) {
    parts[0].push_back({out.frame.to_voxels(mesh.vertices[t.x]), out.frame.to_voxels(mesh.vertices[t.y]),
                        out.frame.to_voxels(mesh.vertices[t.z])});
  }
  const importing::FilledMesh filled = importing::fill_mesh(parts, out.size, kBand / voxel);
  out.exact_outside = !filled.capped && !filled.sheet;
  importing::store(filled, out, [&](const glm::ivec3&, double) { return options.tissue; });
  return out;
}

}  // namespace typodont::haptics
