// Tests that a session, its recording and every way to a moment of it give the same pixels.
#include <gtest/gtest.h>

#include <optional>

#include "engine/app/picture/hud.h"
#include "engine/app/picture/picture_stage.h"
#include "engine/app/picture/teaching_views.h"
#include "engine/app/picture/tissue_view.h"
#include "engine/app/recording.h"
#include "engine/app/recording/resume.h"
#include "engine/app/review/player.h"
#include "engine/app/stepped.h"
#include "engine/base/temporary_folder.h"
#include "engine/base/units.h"
#include "haptics/scripted_hand.h"
#include "tests/support/stage.h"

namespace typodont::test {
namespace {

constexpr int kRounding = 1;    // of 255; a picture that was drawn in parts may round differently
constexpr double kShown = 1.8;  // s, time of the pictures; between two steps of the world

/// A bur under spray cuts through a pillar and frees the cap on it. A mirror beside it is fogged by the mist.
const char* const kScene = R"({"tissue": {"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"union": [
    {"box": {"center_mm": [0, 0, -2], "size_mm": [8, 6, 2]}},
    {"cylinder": {"center_mm": [0, 0, 0], "radius_mm": 0.2, "height_mm": 3}},
    {"box": {"center_mm": [0, 0, 1.6], "size_mm": [2, 2, 1]}}]}}]},
  "tool": {"shape": "sphere", "diameter_mm": 1.0, "grit_um": 107}, "materials": {"dentin": {"grit": {"grinding_ratio": 5}}},
  "spindle": "air_turbine", "spray": {"flow_ml_per_min": 20},
  "mouth_mirror": {"translation_mm": [4, 3, 2], "normal": [-0.5, -0.6, 0.6], "diameter_mm": 6},
  "suction": {"position_mm": [-6, 3, 2]}, "heat": {},
  "parts": ["haptics", "render", "debris"]})";

struct WorldOf : testing::Test {
  TemporaryFolder folder;
  std::filesystem::path file = folder.path() / "session.h5";
  Scene scene = parse_scene(Json::parse(kScene, "scene.json"), folder.path() / "scene.json");
  render::Picture live, dry, warm;  // at kShown; dry: without debris and water; warm: temperatures

  static display::DisplayRig rig() { return desk(0.012, 0.009, 0.3, {0, -0.8, 0.6}); }

  static std::unique_ptr<PictureStage> stage_of(const World& world) {
    PictureStage::Options options;
    options.quality = render::kQualityLadder[2];
    display::DisplayRig seen = rig();
    seen.screen.pixels = {320, 240};
    seen.screen.layout = display::Layout::kMono;
    auto stage = std::make_unique<PictureStage>(seen, world.scene().servo, options);
    stage->surround(world.surroundings());
    return stage;
  }

  static render::Picture temperatures(PictureStage& stage, World& world, const haptics::TissueVolume& volume) {
    const glm::dvec4 plane = section_facing({0, 0, 0}, stage.rig().head.eye_center);
    for (const ViewBody& body : view_bodies(render::View::kTemperature, plane, 0, volume))
      stage.show_inside(body.mesh, body.bricks, volume.frame().origin);
    stage.show_as(render::View::kTemperature, plane);
    stage.draw(world);
    return stage.eye(0);
  }

  /// Runs and records the session, and draws it as it runs.
  WorldOf() {
    std::vector<haptics::HandPath::Row> rows;
    for (const auto& [t, x] : {std::pair{0.0, -1.2}, {1.6, 1.5}, {2.2, 1.5}})
      rows.push_back({t, {{x * kMillimetre, 0, 0.3e-3}, {1, 0, 0, 0}}, 1, dvec3(0)});
    const auto hand = haptics::make_scripted_hand({rows}, 1000, /*paced=*/false);
    SteppedSession session(scene, load_tissue(scene), hand->info());
    haptics::Carver& carver = session.carver();
    World world(scene);
    world.add_debris(carver.volume());
    world.add_heat(carver.volume(), hand->info().rate);
    WorldReader reader(world, session.event_logs());
    const auto stage = stage_of(world);
    TissueView view;
    SessionRecorder recorder(file, scene, hand->info(), carver.volume(), session.event_logs());
    while (session.advance(*hand)) {
      if (session.last().t != from_seconds(kShown)) continue;
      reader.read();
      stage->show(view.update(carver), carver.volume().frame().origin);
      stage->draw(world);
      live = stage->eye(0);
      stage->draw(world, {.debris = false});
      dry = stage->eye(0);
      warm = temperatures(*stage, world, carver.volume());
    }
    recorder.finish(carver.volume());
  }

  /// Draws the recording at kShown after it was at the times `before`, s.
  render::Picture recorded(const std::vector<double>& before, bool backwards = false) {
    SessionPlayer player(file);
    const auto stage = stage_of(player.world());
    const auto draw = [&](double t, bool back) {
      player.seek(t, back);
      stage->show(player.take_surface(), player.tissue().frame().origin);
      stage->draw(player.world());
    };
    for (const double t : before) draw(t, backwards);
    draw(kShown, false);
    return stage->eye(0);
  }
};

TEST_F(WorldOf, ASessionAndItsRecordingAtOneTimeAreTheSamePixels) {
  EXPECT_GT(compare(live, dry, 8).pixels, 300) << "chips and water are seen";
  EXPECT_EQ(compare(live, recorded({}), kRounding).pixels, 0) << "at once, as render --at does";
  SessionPlayer player(file);
  const auto stage = stage_of(player.world());
  player.seek(1);
  player.add_heat();
  EXPECT_EQ(player.world().tick().t, from_seconds(1));
  player.seek(kShown);
  stage->show(player.take_surface(), player.tissue().frame().origin);
  EXPECT_EQ(compare(warm, temperatures(*stage, player.world(), player.tissue()), kRounding).pixels, 0);
  EXPECT_GT(compare(warm, live, 8).pixels, 300);
  const Difference by_frames = compare(live, recorded({0.5, 0.51, 0.9, 1.7999}), kRounding);
  EXPECT_EQ(by_frames.pixels, 0) << "frame by frame, worst " << by_frames.worst;
}

TEST_F(WorldOf, AMomentLooksTheSameAfterPlayingBackwardsAndAfterAJump) {
  const render::Picture once = recorded({});
  EXPECT_EQ(compare(once, recorded({2.1, 0.2}), kRounding).pixels, 0);
  EXPECT_EQ(compare(once, recorded({2.1, 1.9}, /*backwards=*/true), kRounding).pixels, 0);
}

TEST_F(WorldOf, ThePictureOfARecordingHasTheLoosePieceTheFogOfTheMirrorAndTheWearOfTheBur) {
  SessionPlayer player(file);
  int pieces = 0;
  for (const session::SessionEvent& event : player.session().events())
    if (const auto piece = piece_of(event)) pieces += piece->radius > 0.5e-3;
  EXPECT_EQ(pieces, 1);
  player.seek(kShown);
  EXPECT_GT(player.world().mirror().fog, 0.2);
  const display::Hud shown = hud(player.world(), session::Language::kEnglish);
  EXPECT_EQ(shown.speed_krpm, player.world().readout().spindle / kKrpm);
  const double slower = 100 * (1 - 1 / (1 + player.world().readout().wear));
  ASSERT_GT(slower, 0.5);
  EXPECT_EQ(shown.tool, fmt::format("Sphere 1 mm, worn: {:.0f} % slower", slower));
}

}  // namespace
}  // namespace typodont::test
