// `typodont pack`: fills tissue with spheres and stores these spheres (a sphere packing) in a file.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "engine/app/assets.h"
#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/app/picture/packing_picture.h"
#include "engine/app/recording/resume.h"
#include "engine/app/scene.h"
#include "engine/base/error.h"
#include "engine/base/progress.h"
#include "engine/base/units.h"
#include "engine/session/packing_file.h"
#include "haptics/packing.h"

namespace typodont {

namespace {

constexpr int kPreviewPixels = 900;

struct PackArguments {
  std::string input, out, preview;
  int spheres = 36000;
  std::uint64_t seed = 1;
  double max_radius_mm = 0;
  bool json = false;
};

haptics::TissueVolume load(const std::string& input) {
  return input.ends_with(".vdb") ? haptics::TissueVolume::load(input) : load_tissue(read_scene(input));
}

nlohmann::ordered_json as_json(const SpherePacking& packing, const PackArguments& options) {
  std::vector<double> radii = packing.radius;
  std::sort(radii.begin(), radii.end());
  const PerTissue filled = packing.sphere_volume();
  nlohmann::ordered_json tissues = nlohmann::ordered_json::object();
  for (std::size_t t = 0; t < kTissueCount; ++t) {
    if (!(packing.solid_volume[t] > 0)) continue;
    tissues[std::string(name_of(static_cast<Tissue>(t)))] = {
        {"spheres", std::count(packing.tissue.begin(), packing.tissue.end(), static_cast<Tissue>(t))},
        {"volume_mm3", packing.solid_volume[t] / kCubicMillimetre},
        {"coverage", filled[t] / packing.solid_volume[t]}};
  }
  return {{"spheres", packing.size()},
          {"seed", packing.seed},
          {"coverage", packing.coverage()},
          {"largest_hole_mm", packing.max_hole / kMillimetre},
          {"radius_mm",
           {{"limit", packing.max_radius / kMillimetre},
            {"largest", radii.back() / kMillimetre},
            {"median", radii[radii.size() / 2] / kMillimetre},
            {"smallest", radii.front() / kMillimetre}}},
          {"tissues", tissues},
          {"tissue_hash", fmt::format("{:016x}", packing.tissue_hash)},
          {"out", options.out},
          {"preview", options.preview}};
}

void run(const PackArguments& options) {
  constexpr auto kMost = static_cast<int>(haptics::PackOptions::kMaxSpheres);
  if (options.spheres < 1 || options.spheres > kMost) {
    throw Error("--spheres", "", fmt::format("{}", options.spheres), fmt::format("1 to {}", kMost));
  }
  Progress progress("pack");
  const haptics::TissueVolume volume = load(options.input);
  haptics::PackOptions packing_options;
  packing_options.spheres = static_cast<std::size_t>(options.spheres);
  packing_options.seed = options.seed;
  packing_options.max_radius = options.max_radius_mm * kMillimetre;
  packing_options.progress = [&](double fraction) { progress.at(0.95 * fraction); };
  SpherePacking packing;
  try {
    packing = haptics::pack_spheres(volume, packing_options);
  } catch (const Error& error) {
    throw Error(fmt::format("{}: {}", options.input, error.what()));
  }
  session::save_packing(options.out, packing);
  if (!options.preview.empty()) {
    render::write_png(options.preview, packing_picture(packing, load_materials(), kPreviewPixels));
  }
  progress.at(1);

  const nlohmann::ordered_json json = as_json(packing, options);
  if (options.json) {
    fmt::print("{}\n", json.dump(2));
    return;
  }
  fmt::print(
      "{} spheres fill {:.1f} % of the tissue; radius {:.4f} to {:.4f} mm, median {:.4f} mm; largest hole {:.4f} mm\n",
      packing.size(), 100 * packing.coverage(), json["radius_mm"]["smallest"].get<double>(),
      json["radius_mm"]["largest"].get<double>(), json["radius_mm"]["median"].get<double>(),
      packing.max_hole / kMillimetre);
  for (const auto& [name, tissue] : json["tissues"].items()) {
    fmt::print("{}: {} spheres in {:.2f} mm³, {:.1f} % filled\n", name, tissue["spheres"].get<long long>(),
               tissue["volume_mm3"].get<double>(), 100 * tissue["coverage"].get<double>());
  }
  fmt::print("wrote {}\n", options.out);
}

}  // namespace

void add_pack_command(cli::Command& app) {
  auto options = std::make_shared<PackArguments>();
  cli::Command* command = app.add_command("pack", "Fill a scene's tissue with spheres that do not overlap");
  command->footer(
      "Example:\n  typodont pack assets/scenes/molar-caries.json --spheres 36000 --out molar.h5 --preview molar.png");
  command->add_option("input", options->input, "scene (JSON) or volume (.vdb)")->required();
  command->add_setting("--spheres", options->spheres, "how many");
  command->add_setting("--seed", options->seed, "equal seeds, equal packings");
  command->add_option(
      "--max-radius-mm", options->max_radius_mm,
      "largest radius of a sphere (default: twice the radius at which equal spheres have the tissue's volume)",
      cli::range(1e-4, 1000.0));
  command->add_option("--out", options->out, "packing to write (.h5)", cli::writes({FileKind::kSession}))->required();
  command->add_option("--preview", options->preview, "picture to write (.png): the spheres, whole and cut open",
                      cli::writes({FileKind::kPicture}));
  command->add_flag("--json", options->json, "print the summary as JSON");
  command->callback([options] { run(*options); });
}

}  // namespace typodont
