// Measures the cost of a frame, and the difference of its picture from the picture in the best quality.
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

/// Returns the root-mean-square difference of two pictures over all pixels, in grey levels from 0 to 255. `fine` has
/// twice as many pixels in each direction, so each block of 2×2 pixels is first replaced by its mean.
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

/// Returns the mean of |a − 2 b + c| over all pixels, where a, b, c are the luma values of three consecutive frames, 0
/// to 255. A steady change of brightness gives 0; flicker gives a large value.
double second_difference(const render::Picture& a, const render::Picture& b, const render::Picture& c) {
  const auto luma = [](const std::uint8_t* p) { return 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2]; };
  double sum = 0;
  for (int y = 0; y < b.size.y; ++y)
    for (int x = 0; x < b.size.x; ++x) sum += std::abs(luma(a.at(x, y)) - 2 * luma(b.at(x, y)) + luma(c.at(x, y)));
  return sum / (static_cast<double>(b.size.x) * b.size.y);
}

/// Reduces a picture: each block of `side` × `side` pixels becomes one pixel with the mean colour.
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

/// Shimmer of the picture: the mean of second_difference() over the frames. `view`: measured while the view moves by a
/// quarter of a pixel per frame. `tool`: measured while only the tool moves.
struct Shimmer {
  double view = 0, tool = 0;
};

constexpr glm::ivec2 kShimmerEye{320, 256};

/// Measures the shimmer of one quality level. `size`: pixels of the drawn picture. Before the measurement, the picture
/// is scaled to kShimmerEye pixels, because a screen shows the pictures of all quality levels at the same size.
Shimmer shimmer(const Scene& scene, haptics::TissueVolume& volume, const Surroundings& around,
                const render::Quality& quality, const glm::ivec2& size, int frames) {
  display::DisplayRig rig = display::load_rig(assets_folder() / "rigs/closeup.json");
  rig.screen.layout = display::Layout::kMono;
  rig.screen.pixels = size;
  PictureStage::Options options;
  options.quality = quality;
  options.handpieces = scene.handpieces;
  options.hud = false;
  PictureStage stage(rig, scene.servo, options);
  stage.surround(around);
  stage.show(TissueView(surface_tolerance(rig, volume.frame().voxel, quality)).update(volume), volume.frame().origin);
  ServoTick tick;
  tick.X_WG.p = dvec3(6.8e-3, 5.5e-3, 19e-3);
  const dvec3 right = rig.screen.lower_right - rig.screen.lower_left;
  const dvec3 step = 0.25 * right / static_cast<double>(kShimmerEye.x);
  const auto measure = [&](const auto& move) {
    std::vector<render::Picture> pictures;
    double sum = 0;
    for (int i = 0; i < frames; ++i) {
      move();
      stage.draw(tick, {}, 0);
      const render::Picture drawn = stage.eye(0);
      pictures.push_back(drawn.size.x > kShimmerEye.x ? averaged(drawn, drawn.size.x / kShimmerEye.x)
                                                      : render::scaled_to(drawn, kShimmerEye));
      const auto n = pictures.size();
      if (n >= 3) sum += second_difference(pictures[n - 3], pictures[n - 2], pictures[n - 1]) / (frames - 2);
    }
    return sum;
  };
  Shimmer found;
  found.view = measure([&] {
    for (dvec3* p : {&rig.screen.lower_left, &rig.screen.lower_right, &rig.screen.upper_left, &rig.head.eye_center})
      *p += step;
    stage.look_from(rig);
  });
  found.tool = measure([&] { tick.X_WG.p += step; });
  return found;
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
    // Simulates a frame while drilling: the tool moves and two bricks (mesh blocks) change. The measured time is the
    // processor time of all threads, because lavapipe (software rendering) uses several threads.
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
  // Draws the reference picture: four times as many pixels in each direction, and 4 samples per pixel.
  const int frames = run.quick ? 3 : 6;
  const Shimmer least = shimmer(scene, volume, around, render::kQualityLadder.front(), 4 * kShimmerEye, frames);
  for (const render::Quality& quality : render::kQualityLadder) {
    const Shimmer found = shimmer(scene, volume, around, quality, kShimmerEye, frames);
    for (const bool tool : {false, true})
      rows.push_back({.name = tool ? "shimmer, the tool moves" : "shimmer, the view moves",
                      .knob = fmt::format("{}, {}x{}, 1/4 pixel a frame", quality.name, kShimmerEye.x, kShimmerEye.y),
                      .error = tool ? found.tool / least.tool : found.view / least.view,
                      .error_unit = "of a picture with 64 samples"});
  }
  return rows;
}

}  // namespace typodont
