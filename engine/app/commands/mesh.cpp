// `typodont mesh`: writes the drawn surface to a file.
#include <fmt/format.h>

#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/app/picture/tissue_view.h"
#include "engine/app/recording/resume.h"
#include "engine/base/error.h"
#include "engine/base/progress.h"
#include "engine/base/units.h"
#include "engine/surface/mesh_export.h"
#include "haptics/tissue_volume.h"

namespace typodont {

namespace {

struct MeshOptions {
  std::string input, out;
  double tolerance_mm = -1;
  bool file_space = false, json = false;
};

/// Moves the mesh to the coordinates of the file from which the tissue was imported.
void place(surface::WholeMesh& mesh, VoxelFrame& frame, const haptics::FilePlace& place) {
  for (auto& v : mesh.vertices) {
    v.position = glm::vec3(place.X_FW.rotate(glm::dvec3(v.position)));
    v.normal = glm::vec3(place.X_FW.rotate(glm::dvec3(v.normal)));
  }
  frame.origin = place.X_FW * frame.origin;
}

void run(const MeshOptions& options) {
  surface::require_mesh_format(options.out);
  Progress progress("mesh");
  const StoredTissue stored = stored_tissue(options.input, [&](double fraction) { progress.at(0.3 * fraction); });
  const haptics::TissueVolume& volume = stored.volume;
  VoxelFrame frame = volume.frame();
  const double tolerance =
      options.tolerance_mm < 0 ? surface::MesherOptions{}.tolerance : options.tolerance_mm * kMillimetre / frame.voxel;
  surface::WholeMesh mesh = whole_surface(volume, stored.draws_own, static_cast<float>(tolerance),
                                          [&](double fraction) { progress.at(0.3 + 0.5 * fraction); });
  if (mesh.triangles.empty()) throw Error(options.input, "", "no surface", "tissue");
  if (options.file_space) place(mesh, frame, volume.place());
  surface::write_mesh(options.out, mesh, frame, stored.materials);
  progress.at(1);

  glm::vec3 low(std::numeric_limits<float>::max()), high(-low);
  for (const auto& v : mesh.vertices) {
    low = glm::min(low, v.position);
    high = glm::max(high, v.position);
  }
  const glm::dvec3 size = glm::dvec3(high - low) * frame.voxel / kMillimetre;
  if (options.json) {
    const nlohmann::ordered_json json = {{"triangles", mesh.triangles.size()},
                                         {"vertices", mesh.vertices.size()},
                                         {"size_mm", {size.x, size.y, size.z}},
                                         {"voxel_mm", frame.voxel / kMillimetre},
                                         {"tolerance_mm", tolerance * frame.voxel / kMillimetre},
                                         {"out", options.out}};
    fmt::print("{}\n", json.dump(2));
  } else {
    fmt::print("{} triangles, {} vertices, {:.2f} x {:.2f} x {:.2f} mm, within {:.4f} mm of the surface\nwrote {}\n",
               mesh.triangles.size(), mesh.vertices.size(), size.x, size.y, size.z,
               tolerance * frame.voxel / kMillimetre, options.out);
  }
}

}  // namespace

void add_mesh_command(cli::Command& app) {
  auto options = std::make_shared<MeshOptions>();
  cli::Command* command = app.add_command("mesh", "Write the surface of a scene, volume or session as triangles");
  command->footer("Example:\n  typodont mesh assets/scenes/molar-caries.json --out molar.ply --tolerance-mm 0.02");
  command->add_option("input", options->input, "scene (JSON), volume (.vdb), or session (.h5) at its end")->required();
  command
      ->add_option("--out", options->out,
                   "mesh to write: .ply (with tissue colours), .stl, .obj, .glb or .gltf (metres)",
                   cli::writes({FileKind::kPly, FileKind::kStl, FileKind::kObj}))
      ->required();
  command->add_option("--tolerance-mm", options->tolerance_mm,
                      "how far triangles may lie from the surface (default: a tenth of a voxel)",
                      cli::range(0.0, 100.0));
  command->add_flag("--file-space", options->file_space,
                    "coordinates of the file from which the tissue was imported, instead of the workbench's");
  command->add_flag("--json", options->json, "print the summary as JSON");
  command->callback([options] { run(*options); });
}

}  // namespace typodont
