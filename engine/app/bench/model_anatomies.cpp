#include "engine/app/bench/model_anatomies.h"

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <utility>

#include "engine/app/assets.h"
#include "engine/base/units.h"
#include "haptics/import/mesh_tissue.h"
#include "haptics/tissue_mesh.h"

namespace typodont {

namespace {

using haptics::DenseTissue;
using haptics::ModelAnatomy;
using haptics::TissueMesh;
using haptics::TissueVolume;

/// Loads a mesh file as an anatomy. Contact models that need a distance field receive a volume made of the mesh; models
/// that need a mesh receive the mesh itself.
ModelAnatomy of_mesh(const char* file, std::vector<double> voxels_mm) {
  ModelAnatomy anatomy;
  anatomy.mesh = haptics::read_tissue_mesh(assets_folder() / file, kMillimetre, Tissue::kDentin).mesh;
  anatomy.voxels_mm = std::move(voxels_mm);
  const auto mesh = std::make_shared<const TissueMesh>(anatomy.mesh);
  // caches the volume for each voxel size, because making one takes seconds
  const auto kept = std::make_shared<std::map<double, DenseTissue>>();
  anatomy.make = [mesh, kept](double voxel_mm) {
    auto found = kept->find(voxel_mm);
    if (found == kept->end()) {
      haptics::MeshTissueOptions options;
      options.tissue = Tissue::kDentin, options.voxel = voxel_mm * kMillimetre;
      found = kept->emplace(voxel_mm, haptics::rasterize(*mesh, options)).first;
    }
    TissueVolume volume(found->second);
    volume.set_mesh(mesh);
    return volume;
  };
  return anatomy;
}

ModelAnatomy molar() {
  // The file of the molar contains voxels and no mesh. So a mesh of the voxels' surface is used as the exact surface,
  // with which the benchmark compares the contact models.
  ModelAnatomy molar;
  molar.make = [](double) { return TissueVolume::load(assets_folder() / "teeth/molar.vdb"); };
  const TissueVolume volume = molar.make(0);
  molar.mesh = haptics::surface_mesh(volume);
  molar.voxels_mm = {volume.frame().voxel / kMillimetre};
  molar.start = *std::ranges::max_element(molar.mesh.vertices, {}, &dvec3::z);
  return molar;
}

ModelAnatomy arch() {
  ModelAnatomy arch = of_mesh("jaw/lower_arch.ply", {0.3, 0.2});
  arch.start = *std::ranges::max_element(arch.mesh.vertices, {}, &dvec3::z);
  return arch;
}

ModelAnatomy pelvis() {
  // The hand starts at the floor of the hip's socket. The origin is the middle of the socket, and the socket opens
  // towards +z. Near the axis, the bone has two surfaces, and the upper one is the floor. So the highest point near the
  // axis is used.
  ModelAnatomy pelvis = of_mesh("hip/acetabulum.ply", {0.5, 0.3});
  pelvis.start = *std::ranges::min_element(pelvis.mesh.vertices, {}, [](const dvec3& p) {
    return std::hypot(p.x, p.y) < 2 * kMillimetre && p.z <= 0 ? -p.z : 1.0;
  });
  return pelvis;
}

struct Loaded {
  const char* name;
  ModelAnatomy (*load)();
};
constexpr Loaded kAnatomies[] = {{"molar", molar}, {"arch", arch}, {"pelvis", pelvis}};

}  // namespace

std::vector<ModelAnatomy> model_anatomies(const std::vector<std::string>& names) {
  std::vector<ModelAnatomy> all;
  for (const Loaded& anatomy : kAnatomies) {
    if (!names.empty() && std::ranges::find(names, anatomy.name) == names.end()) continue;
    all.push_back(anatomy.load());
    all.back().name = anatomy.name;
  }
  return all;
}

std::vector<std::string> compared_tissues() {
  std::vector<std::string> names = haptics::model_bench_tissues();
  for (const Loaded& anatomy : kAnatomies) names.emplace_back(anatomy.name);
  return names;
}

}  // namespace typodont
