// `typodont volume`: exports tissue as volumes for other programs.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/app/recording/resume.h"
#include "engine/app/tissue/tissue_edit.h"
#include "engine/base/error.h"
#include "engine/base/lower_case.h"
#include "engine/base/partial_file.h"
#include "engine/base/progress.h"
#include "engine/base/units.h"
#include "haptics/import/volume_export.h"

namespace typodont {

namespace {

struct VolumeOptions {
  std::string input, labels, distances;
  bool json = false;
};

void run(const VolumeOptions& options) {
  if (options.labels.empty() && options.distances.empty())
    throw Error("volume", "", "nothing to write", "--labels FILE, --distances FILE or both");
  for (const std::string& file : {options.labels, options.distances})
    if (!file.empty()) require_output(file, FileKind::kLabels);
  if (lower_case(options.distances).ends_with(".dcm"))
    throw Error("--distances", "", options.distances, ".nrrd or .nii: a DICOM segmentation contains only labels");
  Progress progress("volume");
  const StoredTissue stored = stored_tissue(options.input, [&](double fraction) { progress.at(0.3 * fraction); });
  const haptics::DenseTissue tissue = dense_tissue(stored.volume, options.input);
  progress.at(0.5);
  if (!options.labels.empty()) haptics::write_labels(tissue, options.labels);
  progress.at(0.8);
  if (!options.distances.empty()) haptics::write_distances(tissue, options.distances);
  progress.at(1);

  const PerTissue volumes = stored.volume.volumes();
  if (options.json) {
    nlohmann::ordered_json json = {{"input", options.input},
                                   {"size", {tissue.size.x, tissue.size.y, tissue.size.z}},
                                   {"voxel_mm", tissue.frame.voxel / kMillimetre},
                                   {"band_mm", tissue.band / kMillimetre},
                                   {"space", name_of(tissue.place.axes)},
                                   {"volume_mm3", nlohmann::ordered_json::object()},
                                   {"labels", options.labels},
                                   {"distances", options.distances}};
    for (std::size_t t = 1; t < volumes.size(); ++t) {
      if (volumes[t] > 0)
        json["volume_mm3"][std::string(name_of(static_cast<Tissue>(t)))] = volumes[t] / kCubicMillimetre;
    }
    fmt::print("{}\n", json.dump(2));
    return;
  }
  fmt::print("{} x {} x {} voxels of {:.4g} mm\n", tissue.size.x, tissue.size.y, tissue.size.z,
             tissue.frame.voxel / kMillimetre);
  for (const std::string& file : {options.labels, options.distances})
    if (!file.empty()) fmt::print("wrote {}\n", file);
}

}  // namespace

void add_volume_command(cli::Command& app) {
  auto options = std::make_shared<VolumeOptions>();
  cli::Command* command =
      app.add_command("volume", "Write the labels and distances of a scene, volume or session for other programs");
  command->footer(
      "Positions are in the coordinates of the scan or mesh from which the tissue was imported, so that other "
      "programs\n"
      "show the result at its place in the scan.\n"
      "Example:\n  typodont volume session.h5 --labels prepared.nrrd --distances prepared_mm.nii");
  command->add_option("input", options->input, "scene (JSON), volume (.vdb), or session (.h5) at its end")->required();
  command->add_option("--labels", options->labels,
                      "label map to write: .nrrd, .nii, or .dcm (a DICOM segmentation); 0 outside the tissue",
                      cli::writes({FileKind::kLabels}));
  command->add_option("--distances", options->distances,
                      "distances to the surface in mm to write, negative inside the tissue: .nrrd or .nii",
                      cli::writes({FileKind::kLabels}));
  command->add_flag("--json", options->json, "print the summary as JSON");
  command->callback([options] { run(*options); });
}

}  // namespace typodont
