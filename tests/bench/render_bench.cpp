// Measures the time of a frame for each step of the quality ladder. The scene is the molar with its gum and neighbours
// in stereo, with 1280×1024 pixels per eye. It is measured while drilling (the tool moves, bricks change), and with a
// moving head, when everything is drawn again. Prints rows of CSV on standard output. The time is CPU time, so that
// other work on the machine does not count. The frame rate on two cores assumes that they share lavapipe's CPU time
// evenly.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <ctime>
#include <glm/gtc/matrix_transform.hpp>

#include "engine/app/assets.h"
#include "engine/app/picture/picture_stage.h"
#include "engine/app/picture/tissue_view.h"
#include "engine/app/recording/resume.h"
#include "engine/app/scene.h"
#include "tests/support/stage.h"

namespace typodont::test {
namespace {

TEST(Bench, StereoFrameOfTheMolarIsDrawnInTime) {
  const Scene scene = read_scene(assets_folder() / "scenes/molar-caries.json");
  haptics::TissueVolume volume = load_tissue(scene);
  const display::DisplayRig rig = display::load_rig(assets_folder() / "rigs/closeup.json");
  const auto around = make_surroundings(scene.surroundings);
  const dvec3 at(6.8e-3, 5.5e-3, 19e-3);
  fmt::print("step,triangles,share_redrawn,drilling_ms,head_moving_ms,frames_per_second_on_2_cores,of_a_moving_head\n");
  double best = 0;
  for (const render::Quality& quality : render::kQualityLadder) {
    const auto bricks = TissueView(surface_tolerance(rig, volume.frame().voxel, quality)).update(volume);
    // the bricks that a bur of this size touches at this position
    std::vector<render::MeshUpdate> touched;
    for (const render::MeshUpdate& b : bricks) {
      if (b.vertices.empty()) continue;
      glm::vec3 middle(0);
      for (const render::Vertex& v : b.vertices) middle += v.p / static_cast<float>(b.vertices.size());
      if (glm::length(dvec3(middle) + volume.frame().origin - at) < 1.5e-3) touched.push_back(b);
    }
    Stage stage({1280, 1024}, quality, Passes::kBest, /*validation=*/false);
    surround(*stage.renderer, around, quality.surface_error > 1);
    stage.renderer->update(0, bricks);
    stage.renderer->place(0, {volume.frame().origin, {1, 0, 0, 0}});
    stage.renderer->set_tool(round_bur(1.2e-3));
    render::Frame frame = frame_of(rig);
    frame.tool = {.visible = true, .X_WG = {at, {1, 0, 0, 0}}, .spindle = 36000};
    const auto whole = stage.draw(frame);
    constexpr int kFrames = 8;
    render::FrameStats stats;
    const auto took = [&](const auto& change) {
      const std::clock_t start = std::clock();
      for (int i = 0; i < kFrames; ++i) {
        change(i);
        stats = stage.draw(frame);
        EXPECT_TRUE(stats.drawn);
      }
      return 1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC / kFrames;
    };
    const auto drill = [&](int) {
      frame.tool.X_WG.p.x += 1e-5;
      stage.renderer->update(0, touched);
    };
    took(drill);
    const double drilling = took(drill);
    const double redrawn = stats.redrawn;
    const double head = took([&](int i) {
      drill(i);
      for (render::Eye& eye : frame.eyes) {
        eye.view = eye.view * glm::translate(glm::dmat4(1), dvec3(1e-6, 0, 0));
        eye.position.x -= 1e-6;
      }
    });
    best = std::max(best, 2000 / drilling);
    fmt::print("{},{},{:.2f},{:.1f},{:.1f},{:.1f},{:.1f}\n", quality.name, whole.triangles, redrawn, drilling, head,
               2000 / drilling, 2000 / head);
  }
  RecordProperty("frames_per_second_on_2_cores", static_cast<int>(best));
}

}  // namespace
}  // namespace typodont::test
