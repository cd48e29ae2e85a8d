#include "tests/bench/model_cases.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "engine/app/assets.h"
#include "engine/base/json.h"
#include "engine/base/units.h"
#include "haptics/import/mesh_tissue.h"
#include "tests/bench/bench.h"

namespace typodont::bench {

namespace {

using haptics::TissueMesh;
using haptics::TissueVolume;

TissueMesh read_mesh(const char* file) {
  return haptics::read_tissue_mesh(assets_folder() / file, kMillimetre, Tissue::kDentin).mesh;
}

/// Returns a function that makes a volume from a mesh. It keeps the volumes, because making one takes seconds.
std::function<TissueVolume(double)> volumes_of(const TissueMesh& mesh) {
  const auto shared = std::make_shared<const TissueMesh>(mesh);
  const auto kept = std::make_shared<std::map<double, haptics::DenseTissue>>();
  return [shared, kept](double voxel_mm) {
    if (!kept->contains(voxel_mm)) {
      haptics::MeshTissueOptions options;
      options.tissue = Tissue::kDentin, options.voxel = voxel_mm * kMillimetre;
      kept->emplace(voxel_mm, haptics::rasterize(*shared, options));
    }
    TissueVolume volume(kept->at(voxel_mm));
    volume.set_mesh(shared);
    return volume;
  };
}

}  // namespace

haptics::SharedContactMethod method_of(const std::string& json) {
  return haptics::read_contact_method(Json::parse(json, "bench"));
}

Setting default_setting(const std::string& model) {
  if (model == "packing") return {model, "10000 spheres", method_of(R"({"packing": {"spheres": 10000}})")};
  if (model == "mesh_lod")
    return {model, "8000 vertices", method_of(R"({"mesh_lod": {"vertices": 8000, "levels": [8000]}})")};
  return {model, "voxel 0.1 mm", haptics::contact_method(model, "bench")};
}

std::vector<Setting> settings_of(const std::string& model, const Anatomy* anatomy) {
  if (smoke()) return {default_setting(model)};
  std::vector<Setting> all;
  if (model == "packing") {
    for (const int spheres : anatomy ? std::vector{36'000} : std::vector{10'000, 36'000, 100'000})
      all.push_back({model, fmt::format("{} spheres", spheres),
                     method_of(fmt::format(R"({{"packing": {{"spheres": {}}}}})", spheres)),
                     anatomy ? anatomy->voxels_mm.back() : kDefaultVoxel});
  } else if (anatomy && (model == "mesh_lod" || model == "vertex")) {
    const char* const json = model == "mesh_lod" ? R"({"mesh_lod": {"levels": [2000000]}})" : "\"vertex\"";
    all.push_back({model, "its mesh", method_of(json), anatomy->voxels_mm.back()});
  } else if (model == "mesh_lod") {
    for (const int vertices : {2000, 8000, 33'000})
      all.push_back({model, fmt::format("{} vertices", vertices),
                     method_of(fmt::format(R"({{"mesh_lod": {{"vertices": {0}, "levels": [{0}]}}}})", vertices))});
  } else {
    for (const double voxel_mm : anatomy ? anatomy->voxels_mm : std::vector{0.2, 0.1, 0.05})
      all.push_back({model, fmt::format("voxel {:g} mm", voxel_mm), haptics::contact_method(model, "bench"), voxel_mm});
  }
  return all;
}

std::vector<Anatomy> anatomies() {
  return {{"molar", {0.134}}, {"arch", {0.3, 0.2}}, {"pelvis", {0.5, 0.3}}};
}

test::ModelTissue load_anatomy(const Anatomy& anatomy) {
  const std::string name = anatomy.name;
  const auto top = [](const TissueMesh& mesh) { return *std::ranges::max_element(mesh.vertices, {}, &dvec3::z); };
  if (name == "molar") {
    // The file has voxels and no mesh, so the mesh of its field is the exact surface.
    const auto make = [](double) { return TissueVolume::load(assets_folder() / "teeth/molar.vdb"); };
    const TissueMesh mesh = haptics::surface_mesh(make(0));
    return test::mesh_tissue(name, mesh, make, top(mesh), anatomy.voxels_mm);
  }
  if (name == "arch") {
    const TissueMesh mesh = read_mesh("jaw/lower_arch.ply");
    return test::mesh_tissue(name, mesh, volumes_of(mesh), top(mesh), anatomy.voxels_mm);
  }
  // The hand starts at the floor of the hip's socket, the upper one of two surfaces near the axis.
  const TissueMesh mesh = read_mesh("hip/acetabulum.ply");
  const dvec3 floor = *std::ranges::min_element(mesh.vertices, {}, [](const dvec3& p) {
    return std::hypot(p.x, p.y) < 2 * kMillimetre && p.z <= 0 ? -p.z : 1.0;
  });
  return test::mesh_tissue(name, mesh, volumes_of(mesh), floor, anatomy.voxels_mm);
}

}  // namespace typodont::bench
