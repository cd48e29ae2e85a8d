// The cost and the quality of a picture at each quality level: time of a frame, error against the best level at twice
// the size, shimmer of moving pictures, and the difference from a path tracer's pictures (tests/reference).
#include <ctime>
#include <memory>
#include <optional>

#include "engine/app/assets.h"
#include "engine/app/picture/picture_stage.h"
#include "engine/app/picture/tissue_view.h"
#include "engine/app/picture/world.h"
#include "engine/app/recording/resume.h"
#include "engine/app/scene.h"
#include "engine/app/task/task.h"
#include "engine/base/json.h"
#include "engine/base/units.h"
#include "tests/bench/bench.h"
#include "tests/support/picture_difference.h"

namespace typodont::bench {

namespace {

namespace fs = std::filesystem;
constexpr glm::ivec2 kEye{1280, 1024}, kShimmerEye{320, 256};
/// The best level; in a smoke run the quickest, because the best takes a minute.
const render::Quality& best_quality() {
  return smoke() ? render::kQualityLadder.back() : render::kQualityLadder.front();
}

/// The molar with gum and neighbouring teeth, as in a session.
struct Molar {
  Scene scene = read_scene(assets_folder() / "scenes/molar-caries.json");
  haptics::TissueVolume volume = load_tissue(scene);
  Surroundings around = make_surroundings(scene.surroundings);
  ServoTick tick;
  Molar() { tick.X_WG.p = dvec3(6.8e-3, 5.5e-3, 19e-3), tick.spindle = 36000; }
};

/// A stage that shows the molar. `layout`: none for that of the rig.
struct Shown {
  World world;
  display::DisplayRig rig = display::load_rig(assets_folder() / "rigs/closeup.json");
  std::unique_ptr<PictureStage> stage;
  std::vector<render::MeshUpdate> bricks;
  Shown(Molar& molar, const render::Quality& quality, const glm::ivec2& eye, std::optional<display::Layout> layout = {})
      : world(molar.scene) {
    if (layout) rig.screen.layout = *layout;
    rig.screen.pixels = display::screen_pixels(rig.screen.layout, eye);
    PictureStage::Options options;
    options.quality = quality;
    options.handpieces = molar.scene.handpieces;
    options.hud = false;
    stage = std::make_unique<PictureStage>(rig, molar.scene.servo, options);
    stage->surround(molar.around);
    bricks = TissueView(surface_tolerance(rig, molar.volume.frame().voxel, quality)).update(molar.volume);
    stage->show(bricks, molar.volume.frame().origin);
  }
  render::FrameStats draw(const ServoTick& tick) {
    world.place(tick);
    return stage->draw(world, {.debris = false, .mirror = false});
  }
};

/// Returns the picture reduced by `side`: each block of pixels becomes its mean.
render::Picture averaged(const render::Picture& fine, int side) {
  render::Picture out{fine.size / side, {}};
  for (int y = 0; y < out.size.y; ++y)
    for (int x = 0; x < out.size.x; ++x)
      for (int c = 0; c < 4; ++c) {
        int sum = 0;
        for (int k = 0; k < side * side; ++k) sum += fine.at(side * x + k % side, side * y + k / side)[c];
        out.rgba.push_back(static_cast<std::uint8_t>((sum + side * side / 2) / (side * side)));
      }
  return out;
}

/// A stereo frame while drilling: the tool moves, two bricks change. CPU time of all threads, because the software
/// renderer uses several.
void frame(benchmark::State& state, Molar& molar, const render::Quality& quality) {
  static std::map<int, render::Picture> best;  // the best level at twice the size
  if (best.empty()) {
    Shown shown(molar, best_quality(), 2 * kEye);
    shown.draw(molar.tick);
    best[0] = averaged(shown.stage->screen(), 2);
  }
  Shown shown(molar, quality, kEye);
  const render::FrameStats stats = shown.draw(molar.tick);
  const render::Picture picture = shown.stage->screen();
  double squares = 0;
  for (std::size_t i = 0; i < picture.rgba.size(); ++i)
    if (i % 4 < 3) squares += std::pow(picture.rgba[i] - best[0].rgba[i], 2);
  ServoTick moving = molar.tick;
  std::vector<double> times;
  for (int i = 0; i < (smoke() ? 2 : 15); ++i) {
    const std::clock_t start = std::clock();
    moving.X_WG.p.x += 1e-5;
    shown.stage->show(std::span(shown.bricks).subspan(static_cast<std::size_t>(i), 2), molar.volume.frame().origin);
    shown.draw(moving);
    times.push_back(1e9 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  set_time(state, quantile(times, 0.5));
  state.counters["difference_rms_of_255"] = std::sqrt(squares / (0.75 * static_cast<double>(picture.rgba.size())));
  state.counters["triangles"] = static_cast<double>(stats.triangles);
}

/// Mean of |a − 2 b + c| of the luma of three successive frames, while the view (or only the tool) moves by a quarter
/// of a pixel per frame.
double flicker(Molar& molar, const render::Quality& quality, const glm::ivec2& size, bool tool) {
  Shown shown(molar, quality, size, display::Layout::kMono);
  ServoTick tick = molar.tick;
  tick.spindle = 0;
  const dvec3 step = 0.25 * (shown.rig.screen.lower_right - shown.rig.screen.lower_left) / double(kShimmerEye.x);
  const int frames = smoke() ? 3 : 6;
  std::vector<std::vector<double>> luma;
  double sum = 0;
  for (int i = 0; i < frames; ++i) {
    if (tool) {
      tick.X_WG.p += step;
    } else {
      display::Screen& s = shown.rig.screen;
      for (dvec3* p : {&s.lower_left, &s.lower_right, &s.upper_left, &shown.rig.head.eye_center}) *p += step;
      shown.stage->look_from(shown.rig);
    }
    shown.draw(tick);
    const render::Picture drawn = shown.stage->eye(0);
    const render::Picture p = drawn.size.x > kShimmerEye.x ? averaged(drawn, drawn.size.x / kShimmerEye.x)
                                                           : render::scaled_to(drawn, kShimmerEye);
    std::vector<double>& now = luma.emplace_back();
    for (std::size_t k = 0; k < p.rgba.size(); k += 4)
      now.push_back(0.2126 * p.rgba[k] + 0.7152 * p.rgba[k + 1] + 0.0722 * p.rgba[k + 2]);
    if (i < 2) continue;
    for (std::size_t k = 0; k < now.size(); ++k)
      sum += std::abs(luma[luma.size() - 3][k] - 2 * luma[luma.size() - 2][k] + now[k]);
  }
  return sum / (frames - 2);
}

/// Flicker relative to a picture with 64 samples per pixel.
void shimmer(benchmark::State& state, Molar& molar, const render::Quality& quality) {
  for (const bool tool : {false, true}) {
    static std::map<bool, double> least;
    if (!least.contains(tool)) least[tool] = flicker(molar, best_quality(), 4 * kShimmerEye, tool);
    state.counters[tool ? "tool_moves_ratio" : "view_moves_ratio"] =
        flicker(molar, quality, kShimmerEye, tool) / least[tool];
  }
}

/// Differences from the path tracer's picture of a scene in tests/reference/scenes.json.
void looks(benchmark::State& state, const Json& json, const render::Quality& quality) {
  const fs::path folder = "tests/reference", file = json["scene"].string() + ".json";
  const Scene scene = read_scene(fs::exists(folder / file) ? folder / file : assets_folder() / "scenes" / file);
  haptics::TissueVolume volume = load_tissue(scene);
  Surroundings around = make_surroundings(scene.surroundings);
  if (json.boolean_or("finished", false)) {
    volume = ideal_tissue(scene, volume).value();
    around.covered = glm::dvec4(0);  // a finished cavity may show the root
  }
  const render::Picture reference = render::read_png(folder / (json["name"].string() + ".png"));
  display::DisplayRig rig = display::load_rig(assets_folder() / "rigs/closeup.json");
  rig.screen.pixels = display::screen_pixels(rig.screen.layout, reference.size);
  PictureStage::Options options;
  options.quality = quality;
  const bool tool = json.has("tool_mm");
  options.handpieces.shown = false;  // the reference pictures show none
  ServoTick tick;
  if (tool) {
    tick.X_WT.p = tick.X_WG.p = json["tool_mm"].vec3() * kMillimetre;
    tick.spindle = scene.servo.spindle.free_speed;
  }
  PictureStage stage(rig, scene.servo, options);
  stage.surround(around);
  TissueView view(surface_tolerance(rig, volume.frame().voxel, quality), scene.drawn_as);
  stage.show(view.update(volume), volume.frame().origin);
  World world(scene);
  world.place(tick);
  stage.draw(world, {.tool = tool, .debris = false, .mirror = false});
  const render::Picture picture = render::scaled_to(stage.eye(0), reference.size);
  state.counters["flip"] = render::mean_flip(reference, picture);
  state.counters["ciede2000"] = render::mean_ciede2000(reference, picture);
}

}  // namespace

void add_cases() {
  const auto molar = std::make_shared<std::optional<Molar>>();
  const auto with_molar = [molar](const std::string& name,
                                  void (*run)(benchmark::State&, Molar&, const render::Quality&),
                                  const render::Quality& quality) {
    add(fmt::format("{}/{}", name, quality.name), [molar, run, &quality](benchmark::State& state) {
      if (!*molar) molar->emplace();
      run(state, **molar, quality);
    });
  };
  const std::span ladder = std::span(render::kQualityLadder).last(smoke() ? 1 : render::kQualityLadder.size());
  for (const render::Quality& quality : ladder) {
    with_molar("stereo frame of 1280x1024 an eye", frame, quality);
    with_molar("shimmer", shimmer, quality);
  }
  for (const Json& json : Json::load("tests/reference/scenes.json").items()) {
    if (smoke() && json["name"].string() != "molar-caries-finished") continue;
    for (const render::Quality& quality : ladder)
      add(fmt::format("looks/{}/{}", json["name"].string(), quality.name),
          [json, &quality](benchmark::State& state) { looks(state, json, quality); });
  }
}

}  // namespace typodont::bench
