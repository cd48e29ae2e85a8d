#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <map>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "haptics/volume/import/import_scan.h"
#include "haptics/volume/import/scan.h"

namespace typodont::haptics::importing {

namespace {

struct Mesh {
  std::vector<dvec3> points;                // m
  std::vector<std::array<int, 3>> corners;  // of each triangle
};

Mesh read_mesh(const std::filesystem::path& file, double unit) {
  if (size_of_file(file) == 0) throw Error(file.string(), "", "an empty file", "a closed mesh");
  Assimp::Importer importer;
  const aiScene* scene =
      importer.ReadFile(file.string(), aiProcess_Triangulate | aiProcess_PreTransformVertices | aiProcess_SortByPType);
  if (!scene || scene->mNumMeshes == 0) {
    std::string why = importer.GetErrorString();
    throw Error(file.string(), "mesh", why.empty() ? "no triangles" : why, "a readable STL, PLY or OBJ file");
  }
  Mesh mesh;
  // Corners at the same place are one point, whatever their normals and texture say.
  std::map<std::array<float, 3>, int> known;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& part = *scene->mMeshes[m];
    if (part.mPrimitiveTypes != aiPrimitiveType_TRIANGLE) continue;
    std::vector<int> index(part.mNumVertices);
    for (unsigned i = 0; i < part.mNumVertices; ++i) {
      const aiVector3D& p = part.mVertices[i];
      if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
        throw Error(file.string(), fmt::format("vertex {}", i), fmt::format("({}, {}, {})", p.x, p.y, p.z), "finite coordinates");
      }
      const auto [it, fresh] = known.try_emplace({p.x + 0.0F, p.y + 0.0F, p.z + 0.0F}, static_cast<int>(mesh.points.size()));
      if (fresh) mesh.points.push_back(unit * dvec3(p.x, p.y, p.z));
      index[i] = it->second;
    }
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      if (face.mNumIndices != 3) continue;
      const std::array<int, 3> c = {index[face.mIndices[0]], index[face.mIndices[1]], index[face.mIndices[2]]};
      if (c[0] != c[1] && c[1] != c[2] && c[2] != c[0]) mesh.corners.push_back(c);
    }
  }
  if (mesh.corners.empty()) throw Error(file.string(), "mesh", "no triangles", "a closed surface");
  std::map<std::pair<int, int>, int> edges;
  for (const auto& c : mesh.corners) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = c[k], b = c[(k + 1) % 3];
      ++edges[{std::min(a, b), std::max(a, b)}];
    }
  }
  std::size_t open = 0;
  dvec3 first(0);
  for (const auto& [edge, times] : edges) {
    if (times % 2 == 0) continue;
    if (open++ == 0) first = mesh.points[static_cast<std::size_t>(edge.first)] / unit;
  }
  if (open > 0) {
    throw Error(file.string(), fmt::format("edge at ({:g}, {:g}, {:g})", first.x, first.y, first.z),
                fmt::format("{} open edges of {}", open, edges.size()), "a closed surface");
  }
  return mesh;
}

}  // namespace

Imported import_mesh(const std::filesystem::path& file, const ImportOptions& options) {
  const bool tooth = options.preset == ImportPreset::kTooth;
  if (!(options.mesh_unit > 0) || !std::isfinite(options.mesh_unit)) {
    throw Error("--unit-mm", "", fmt::format("{:g}", options.mesh_unit / kMillimetre), "millimetres per unit of the mesh, above 0");
  }
  const Mesh mesh = read_mesh(file, options.mesh_unit);
  dvec3 lo(1e300), hi(-1e300);
  for (const dvec3& p : mesh.points) {
    lo = glm::min(lo, p);
    hi = glm::max(hi, p);
  }
  const dvec3 extent = hi - lo;
  const double longest = std::max({extent.x, extent.y, extent.z});
  const double least = tooth ? 1e-3 : 3e-3, most = tooth ? 60e-3 : 0.6;
  if (!(longest >= least && longest <= most)) {
    throw Error(file.string(), "size", fmt::format("a body {:.4g} mm long at {:g} mm a unit", longest / kMillimetre, options.mesh_unit / kMillimetre),
                fmt::format("{} of {:g} to {:g} mm; give the unit with --unit-mm", tooth ? "a tooth" : "a bone", least / kMillimetre, most / kMillimetre));
  }
  const double voxel = options.voxel.value_or(0.1e-3);
  check_result_size(extent + 2 * options.band + 6 * voxel, voxel);

  Imported result;
  result.report.format = file.extension().string().substr(1);
  DenseTissue& out = result.tissue;
  out.band = options.band;
  const double margin = options.band + 2 * voxel;
  out.frame.voxel = voxel;
  out.frame.origin = voxel * glm::floor((lo - margin) / voxel);
  out.size = glm::ivec3(glm::ceil((hi + margin - out.frame.origin) / voxel)) + 1;
  std::vector<Triangle> triangles;
  for (const auto& c : mesh.corners) {
    const auto at = [&](std::size_t k) { return out.frame.to_voxels(mesh.points[static_cast<std::size_t>(c[k])]); };
    triangles.push_back({at(0), at(1), at(2)});
  }
  if (options.progress) options.progress(0.2);

  // A tooth by depth: enamel of `shell` on the crown, thinning out over its lowest 2.5 mm; a pulp chamber where the
  // surface is more than 3 mm away. Bone: a cortical shell.
  constexpr double kPulpDepth = 3e-3, kTaper = 2.5e-3, kCrownShare = 0.42;
  const double shell = options.shell.value_or(tooth ? 1.3e-3 : 1.5e-3);
  if (!(shell >= 0 && shell <= 0.5 * longest)) {
    throw Error("--shell-mm", "", fmt::format("{:g}", shell / kMillimetre), fmt::format("0 to {:.3g} mm", 0.5 * longest / kMillimetre));
  }
  const double deepest = std::max({options.band, shell + 2 * voxel, tooth ? kPulpDepth + 2 * voxel : 0.0});
  const DistanceField field = signed_distance(triangles, out.size, deepest / voxel);
  if (options.progress) options.progress(0.8);

  // The crown lies at that end of the longest axis where the body is wider.
  const int axis = extent.x == longest ? 0 : extent.y == longest ? 1 : 2;
  double below = 0, above = 0;
  const double middle = 0.5 * (lo[axis] + hi[axis]);
  for (std::size_t i = 0; i < field.distance.v.size(); ++i) {
    if (field.distance.v[i] >= 0) continue;
    (out.frame.to_world(dvec3(field.distance.place(i)))[axis] > middle ? above : below) += 1;
  }
  if (above + below < 8) {
    throw Error(file.string(), "size", fmt::format("a body of {:.0f} voxels", above + below), "a body thicker than --voxel-mm");
  }
  const double crown_end = above >= below ? hi[axis] : lo[axis];
  const double margin_of_crown = crown_end + (above >= below ? -1 : 1) * kCrownShare * extent[axis];
  out.distance.resize(field.distance.v.size());
  out.tissue.assign(out.distance.size(), Tissue::kAir);
  for (std::size_t i = 0; i < out.distance.size(); ++i) {
    const double d = static_cast<double>(field.distance.v[i]) * voxel;
    out.distance[i] = static_cast<float>(std::clamp(d, -out.band, out.band));
    if (d > 2.5 * voxel) continue;
    const double depth = std::max(-d, 0.0);
    if (!tooth) {
      out.tissue[i] = depth < shell || shell == 0 ? Tissue::kCorticalBone : Tissue::kCancellousBone;
      continue;
    }
    const double up = (out.frame.to_world(dvec3(field.distance.place(i)))[axis] - margin_of_crown) * (above >= below ? 1 : -1);
    const double enamel = shell * std::clamp(up / kTaper, 0.0, 1.0);
    out.tissue[i] = depth < enamel ? Tissue::kEnamel : depth > kPulpDepth ? Tissue::kPulp : Tissue::kDentin;
  }
  result.report.bodies_kept = result.report.bodies_found = 1;
  Mask solid(out.size, 0), pulp(out.size, 0);
  for (std::size_t i = 0; i < out.distance.size(); ++i) {
    solid.v[i] = out.distance[i] <= 0;
    pulp.v[i] = solid.v[i] && out.tissue[i] == Tissue::kPulp;
  }
  result.report.bodies_kept = result.report.bodies_found = static_cast<int>(components(solid, true).voxels.size()) - 1;
  result.report.pulp_parts = static_cast<int>(components(pulp, true).voxels.size()) - 1;
  if (tooth) result.report.notes.push_back("tissues of a mesh are told by depth below its surface; root canals are not");
  return result;
}

}  // namespace typodont::haptics::importing
