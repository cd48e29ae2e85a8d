// Measures the cost of a frame, and the difference of its picture from the best quality.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>

#include "engine/app/assets.h"
#include "engine/app/bench/parts.h"
#include "engine/app/picture/picture_stage.h"
#include "engine/app/picture/tissue_view.h"
#include "engine/app/recording/resume.h"
#include "engine/app/scene.h"
#include "engine/base/measure.h"

namespace typodont {

namespace {

constexpr glm::ivec2 kEye{1280, 1024};

display::DisplayRig closeup(const glm::ivec2& eye) {
  display::DisplayRig rig = display::load_rig(assets_folder() / "rigs/closeup.json");
  rig.screen.pixels = display::screen_pixels(rig.screen.layout, eye);
  return rig;
}

/// Root-mean-square difference of all pixels between `fine` (averaged over 2×2 blocks) and `coarse`, in steps of 0 to
/// 255.
double difference(const render::Picture& fine, const render::Picture& coarse) {
  double sum = 0;
  for (int y = 0; y < coarse.size.y; ++y) {
    for (int x = 0; x < coarse.size.x; ++x) {
      for (int c = 0; c < 3; ++c) {
        double mean = 0;
        for (int k = 0; k < 4; ++k) mean += fine.at(2 * x + (k & 1), 2 * y + k / 2)[c] / 4.0;
        const double d = mean - coarse.at(x, y)[c];
        sum += d * d;
      }
    }
  }
  return std::sqrt(sum / (3.0 * coarse.size.x * coarse.size.y));
}

}  // namespace

std::vector<BenchRow> bench_render(const BenchRun& run) {
  const Scene scene = read_scene(assets_folder() / "scenes/molar-caries.json");
  haptics::TissueVolume volume = load_tissue(scene);
  const dvec3 origin = volume.frame().origin;
  // gum and neighbouring teeth are drawn, as in a session
  const Surroundings around = make_surroundings(scene.surroundings);
  ServoTick tick;
  tick.X_WG.p = dvec3(6.8e-3, 5.5e-3, 19e-3);
  tick.spindle = 36000;

  const auto stage_of = [&](const render::Quality& quality, const glm::ivec2& eye) {
    PictureStage::Options options;
    options.quality = quality;
    options.handpieces = scene.handpieces;
    return std::make_unique<PictureStage>(closeup(eye), scene.servo, options);
  };
  const auto bricks_for = [&](const render::Quality& quality, const glm::ivec2& eye) {
    return TissueView(surface_tolerance(closeup(eye), volume.frame().voxel, quality)).update(volume);
  };
  render::Picture reference;
  {
    const auto stage = stage_of(render::kQualityLadder.front(), 2 * kEye);
    stage->surround(around);
    stage->show(bricks_for(render::kQualityLadder.front(), 2 * kEye), origin);
    stage->draw(tick, {}, 0);
    reference = stage->screen();
  }
  std::vector<BenchRow> rows;
  for (const render::Quality& quality : render::kQualityLadder) {
    const auto stage = stage_of(quality, kEye);
    const auto bricks = bricks_for(quality, kEye);
    stage->surround(around);
    stage->show(bricks, origin);
    const render::FrameStats stats = stage->draw(tick, {}, 0);
    const double error = difference(reference, stage->screen());
    // Simulates drilling: the tool moves and two bricks change. Measures the processor time of all threads, because
    // lavapipe uses several.
    ServoTick moving = tick;
    std::vector<double> times;
    for (int i = 0; i < (run.quick ? 3 : 15); ++i) {
      const std::clock_t start = std::clock();
      moving.X_WG.p.x += 1e-5;
      stage->show(std::span(bricks).subspan(static_cast<std::size_t>(i), 2), origin);
      stage->draw(moving, {}, 1.0 / 60);
      times.push_back(1e9 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
    }
    rows.push_back({.name = "stereo frame, " + stage->device_name(),
                    .knob = fmt::format("{}, {}x{} an eye", quality.name, kEye.x, kEye.y),
                    .error = error,
                    .error_unit = "of 255, rms",
                    .time_ns = quantile(times, 0.5),
                    .per = "frame",
                    .size = static_cast<double>(stats.triangles),
                    .size_unit = "triangles"});
    rows.back().baseline = "a thirtieth of a second on two cores";
    rows.back().ratio = rows.back().time_ns / (2e9 / 30);
  }
  return rows;
}

}  // namespace typodont
