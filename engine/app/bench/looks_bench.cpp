// Compares the pictures of every quality level with reference pictures, which a path tracer has drawn
// (tests/reference).
#include <fmt/format.h>

#include "engine/app/assets.h"
#include "engine/app/bench/parts.h"
#include "engine/app/picture/picture_stage.h"
#include "engine/app/picture/tissue_view.h"
#include "engine/app/recording/resume.h"
#include "engine/app/scene.h"
#include "engine/app/task/task.h"
#include "engine/base/json.h"
#include "engine/base/log.h"
#include "engine/base/units.h"
#include "engine/render/picture_difference.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;

/// A scene for which tests/reference/scenes.json lists a reference picture.
struct ReferenceScene {
  std::string name;
  Scene scene;
  haptics::TissueVolume volume;
  Surroundings around;
  ServoTick tick;
  bool tool = false;
  render::Picture reference;
};

ReferenceScene load(const Json& json, const fs::path& folder) {
  const std::string name = json["name"].string();
  const fs::path picture = folder / (name + ".png");
  const fs::path file = json["scene"].string() + ".json", own = folder / file;
  Scene scene = read_scene(fs::exists(own) ? own : assets_folder() / "scenes" / file);
  haptics::TissueVolume volume = load_tissue(scene);
  if (json.boolean_or("finished", false)) volume = ideal_tissue(scene, volume).value();
  ReferenceScene loaded{name,
                        scene,
                        std::move(volume),
                        make_surroundings(scene.surroundings),
                        {},
                        json.has("tool_mm"),
                        render::read_png(picture)};
  // draws the whole root: a finished cavity may reach below the gum, and then the root is visible through the cavity
  if (json.boolean_or("finished", false)) loaded.around.covered = glm::dvec4(0);
  if (loaded.tool) {
    loaded.tick.X_WT.p = loaded.tick.X_WG.p = json["tool_mm"].vec3() * kMillimetre;
    loaded.tick.spindle = scene.servo.spindle.free_speed;
  }
  return loaded;
}

render::Picture drawn(ReferenceScene& shown, const render::Quality& quality) {
  display::DisplayRig rig = display::load_rig(assets_folder() / "rigs/closeup.json");
  rig.screen.pixels = display::screen_pixels(rig.screen.layout, shown.reference.size);
  PictureStage::Options options;
  options.quality = quality;
  options.tool = shown.tool;
  options.handpieces.shown = false;  // the reference pictures show no handpiece
  PictureStage stage(rig, shown.scene.servo, options);
  stage.surround(shown.around);
  TissueView view(surface_tolerance(rig, shown.volume.frame().voxel, quality), shown.scene.drawn_as);
  stage.show(view.update(shown.volume), shown.volume.frame().origin);
  stage.draw(shown.tick, {}, 0);
  return render::scaled_to(stage.eye(0), shown.reference.size);
}

}  // namespace

std::vector<BenchRow> bench_looks(const BenchRun& run) {
  const fs::path folder = assets_folder().parent_path() / "tests/reference";
  if (!fs::is_directory(folder)) {  // an installed program has no reference pictures
    log::warn("looks: not measured, because {} does not exist", folder.string());
    return {};
  }
  std::vector<BenchRow> rows;
  const auto add = [&](const std::string& name, std::string_view level, double error, const char* unit) {
    rows.push_back({.name = name, .knob = std::string(level), .error = error, .error_unit = unit});
  };
  constexpr const char *kFlip = "FLIP, mean", *kColor = "CIEDE2000, mean";
  std::array<double, render::kQualityLadder.size()> flip{}, color{};
  const std::vector<Json> list = Json::load(folder / "scenes.json").items();
  const std::size_t count = run.quick ? 1 : list.size();
  for (std::size_t s = 0; s < count; ++s) {
    ReferenceScene scene = load(list[s], folder);
    for (std::size_t q = 0; q < render::kQualityLadder.size(); ++q) {
      const render::Quality& quality = render::kQualityLadder[q];
      const render::Picture picture = drawn(scene, quality);
      const double f = render::mean_flip(scene.reference, picture);
      const double c = render::mean_ciede2000(scene.reference, picture);
      add(scene.name, quality.name, f, kFlip);
      add(scene.name, quality.name, c, kColor);
      flip[q] += f / static_cast<double>(count), color[q] += c / static_cast<double>(count);
    }
  }
  for (std::size_t q = 0; q < render::kQualityLadder.size(); ++q) {
    add("all scenes", render::kQualityLadder[q].name, flip[q], kFlip);
    add("all scenes", render::kQualityLadder[q].name, color[q], kColor);
  }
  return rows;
}

}  // namespace typodont
