#include <fmt/format.h>

#include <algorithm>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/import/import_scan.h"

namespace typodont::haptics {

namespace {

constexpr double kBytesPerVoxel = sizeof(float) + sizeof(Tissue);

/// Index of a volume's first voxel in the grid that all volumes share.
glm::ivec3 first_voxel(const DenseTissue& tissue) {
  return glm::ivec3(glm::round(tissue.frame.origin / tissue.frame.voxel));
}

/// Joins the volumes of single meshes, and reports their overlap (m³). `kept`: memory of the volumes, bytes.
DenseTissue joined(const std::vector<DenseTissue>& volumes, double kept, const ImportOptions& options,
                   ImportReport& report) {
  glm::ivec3 lo = first_voxel(volumes[0]), hi = lo + volumes[0].size;
  for (const DenseTissue& v : volumes) lo = glm::min(lo, first_voxel(v)), hi = glm::max(hi, first_voxel(v) + v.size);
  DenseTissue out;
  out.band = volumes[0].band;
  out.frame = volumes[0].frame;
  out.frame.origin = out.frame.voxel * dvec3(lo);
  out.size = hi - lo;
  const dvec3 size(out.size);
  importing::require_memory(kept + kBytesPerVoxel * size.x * size.y * size.z, options, report);
  out.distance.assign(voxel_count(out.size), static_cast<float>(out.band));
  out.tissue.assign(out.distance.size(), Tissue::kAir);
  std::size_t shared = 0;
  for (const DenseTissue& v : volumes) {
    out.exact_outside = out.exact_outside && v.exact_outside;
    const glm::ivec3 shift = first_voxel(v) - lo;
    for_each_voxel(v.size, [&](int x, int y, int z) {
      const std::size_t from = v.at(x, y, z), to = out.at(x + shift.x, y + shift.y, z + shift.z);
      shared += v.distance[from] < 0 && out.distance[to] < 0;
      if (v.distance[from] >= out.distance[to]) return;
      out.distance[to] = v.distance[from];
      out.tissue[to] = v.tissue[from];
    });
  }
  const double h = out.frame.voxel;
  report.overlap = static_cast<double>(shared) * h * h * h;
  return out;
}

}  // namespace

Imported import_meshes(const std::vector<PlacedMesh>& meshes, const ImportOptions& options) {
  if (meshes.empty()) throw Error("INPUT", "", "no mesh", "one mesh or more");
  Imported all;
  ImportReport& report = all.report;
  // Bounding box of all meshes in the imported volume, found first, because all meshes share one volume.
  ImportRegion bounds;
  const auto in_result = [&](const PlacedMesh& mesh) {
    ImportOptions own = options;
    own.mesh_pose = mesh.X_WF;
    return own;
  };
  for (const PlacedMesh& mesh : meshes) {
    const ImportRegion of_mesh = importing::mesh_bounds(mesh.file, in_result(mesh));
    bounds = &mesh == &meshes.front() ? of_mesh : importing::around(bounds, of_mesh);
  }
  const double voxel = importing::voxel_of_meshes(bounds, options, report.notes);
  std::vector<DenseTissue> volumes;
  ImportRegion first;  // bounding box of the first mesh
  double kept = 0;     // total memory of the volumes, bytes
  for (std::size_t k = 0; k < meshes.size(); ++k) {
    ImportOptions own = in_result(meshes[k]);
    own.voxel = voxel;
    if (options.memory) own.memory = *options.memory - kept;
    own.turn = glm::dmat3(1);
    if (options.progress) {
      own.progress = [&, k](double done) {
        options.progress(0.9 * (static_cast<double>(k) + done) / static_cast<double>(meshes.size()));
      };
    }
    Imported one = import_tissue(meshes[k].file, own);
    const std::string name = meshes[k].file.filename().string();
    for (const std::string& repair : one.report.repairs) report.repairs.push_back(name + ": " + repair);
    report.repaired.insert(report.repaired.end(), one.report.repaired.begin(), one.report.repaired.end());
    for (const std::string& note : one.report.notes) report.notes.push_back(name + ": " + note);
    if (report.format.find(one.report.format) == std::string::npos)
      report.format += (report.format.empty() ? "" : ", ") + one.report.format;
    const ImportRegion box{one.report.lo, one.report.hi};
    if (k == 0)
      first = box;
    else if (glm::any(glm::lessThan(first.hi, box.lo)) || glm::any(glm::lessThan(box.hi, first.lo)))
      report.others.push_back(box);
    else
      report.notes.push_back(name + ": its box meets that of the first mesh, so cuts in it are not counted as damage");
    report.bodies_found += one.report.bodies_found, report.bodies_kept += one.report.bodies_kept;
    report.pulp_parts += one.report.pulp_parts;
    report.memory = std::max(report.memory, kept + one.report.memory);
    kept += kBytesPerVoxel * static_cast<double>(one.tissue.distance.size());
    volumes.push_back(std::move(one.tissue));
  }
  all.tissue = joined(volumes, kept, options, report);
  // Not kTooth: this would also measure the dentin on the crown's surface, which is possible only for a single tooth.
  importing::measure(all, ImportPreset::kBone);
  turn(all, options.turn);
  if (options.progress) options.progress(1);
  return all;
}

}  // namespace typodont::haptics
