// Tests the soft gum of a scene: a scripted hand feels it, a replay gives the same bits, the picture's bricks show it,
// and it can be cut and bleeds.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "engine/app/live/session.h"
#include "engine/app/picture/soft_gum_view.h"
#include "engine/app/recording/resume.h"
#include "engine/app/review/player.h"
#include "engine/app/scene.h"
#include "engine/app/stepped.h"
#include "engine/app/surroundings/surroundings.h"
#include "engine/app/task/damage.h"
#include "engine/session/ticks_csv.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

using namespace test;

/// A ball as a tooth with gum around its lower half.
class SoftGum : public testing::Test {
 protected:
  SoftGum() {
    folder.write(
        "ball.json",
        R"({"tissue": {"voxel_mm": 0.1, "solids": [{"tissue": "enamel", "solid": {"sphere": {"radius_mm": 3}}}]}, "tool": "round_012"})");
    load_tissue(read_scene(folder.path() / "ball.json")).save(folder.path() / "ball.vdb");
    soft = scene("soft", R"(, "soft": {})");
    rigid = scene("rigid", "");
    const SurroundingsShape shape(*read_scene(soft).surroundings);
    top = {0, 4.0e-3, 3e-3};
    while (shape.gum(top) > 0) top.z -= 5e-6;
  }
  std::string scene(const std::string& name, const std::string& key) const {
    return folder.write(
        name + ".json",
        R"({"tissue": {"volume": "ball.vdb"}, "surroundings": {"neighbours": [], "gum": {"margin_mm": [0, 0, -0.5],
            "thickness_mm": 1.2, "papilla_mm": 0, "length_mm": 12)" +
            key + R"(}}, "tools": [{"shape": "sphere", "diameter_mm": 1.2}, "probe_who_621"], "spindle_krpm": 300})");
  }
  /// A path down to `depth` mm in the gum, 2 s of rest, and up again.
  std::string path(double depth, double pedal) const {
    const auto row = [&](double t, double height, double drill) {
      return fmt::format("{},{},{},{},1,0,0,0,{}\n", t, 1e3 * top.x, 1e3 * top.y, 1e3 * top.z + 0.6 + height, drill);
    };
    return folder.write("path.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n" + row(0, 1.0, 0) + row(0.2, 0.5, pedal) +
                                        row(0.7, -depth, pedal) + row(2.7, -depth, pedal) + row(3.2, 1.5, 0) +
                                        row(5, 1.5, 0));
  }
  std::vector<ServoTick> ticks(const std::string& scene, double depth, double pedal) const {
    expect_ok(folder.run(
        fmt::format("servo {} --hand {} --out {} --no-timing", scene, path(depth, pedal), folder / "ticks.csv")));
    return session::read_ticks_csv(folder / "ticks.csv");
  }
  ProgramFolder folder{TYPODONT_PROGRAM};
  std::string soft, rigid;
  dvec3 top;  // m, a point of the gum's surface
};

/// Returns the depth (m) of the deepest drawn vertex below the gum's resting surface. Looks only at bricks that were
/// meshed again. If the gum is at rest, the result is the error of its mesh: about 0.03e-3 m, and up to 0.3e-3 m at a
/// sharp fold.
double deepest(const SoftGumView& view, const Surroundings& around, const SurroundingsShape& shape) {
  double most = 0;
  for (const SoftGumView::Brick& brick : view.bricks()) {
    if (brick.coarse || brick.version == 0) continue;
    const auto mesh = std::find_if(around.meshes.begin(), around.meshes.end(),
                                   [&](const SurroundingMesh& m) { return m.id == brick.mesh; });
    for (const render::Vertex& v : brick.now.vertices) {
      const dvec3 p = mesh->origin + dvec3(v.p);
      if (shape.tooth(p) > 0.1e-3) most = std::max(most, -shape.gum(p));
    }
  }
  return most;
}

/// Returns true if every brick of the view equals the original brick of the surroundings.
bool as_made(const SoftGumView& view, const Surroundings& around) {
  for (const SoftGumView::Brick& brick : view.bricks()) {
    if (brick.version == 0) continue;
    const auto mesh = std::find_if(around.meshes.begin(), around.meshes.end(),
                                   [&](const SurroundingMesh& m) { return m.id == brick.mesh; });
    const auto& bricks = brick.coarse ? mesh->coarse : mesh->bricks;
    const auto whole = std::find_if(bricks.begin(), bricks.end(),
                                    [&](const render::MeshUpdate& b) { return b.brick == brick.now.brick; });
    if (whole->indices != brick.now.indices) return false;
    for (std::size_t v = 0; v < whole->vertices.size(); ++v) {
      if (whole->vertices[v].p != brick.now.vertices[v].p) return false;
    }
  }
  return true;
}

TEST_F(SoftGum, IsFeltByAProbeAndLeavesTheServoOfARigidGumAlone) {
  const std::vector<ServoTick> felt = ticks(soft, 0.5, 0), air = ticks(rigid, 0.5, 0);
  ASSERT_EQ(felt.size(), air.size());
  double strongest = 0, last = 0;
  for (std::size_t i = 0; i < felt.size(); ++i) {
    ASSERT_EQ(air[i].f_T_W, dvec3(0)) << "a rigid gum is only drawn";
    const double force = glm::length(felt[i].f_T_W);
    ASSERT_LT(std::abs(force - last), 0.02) << i;
    strongest = std::max(strongest, force);
    last = force;
  }
  EXPECT_GT(strongest, 0.1);
  EXPECT_LT(strongest, 0.5 + 0.1) << "at most the coupling's 1 N/mm times the depth, and friction";
  EXPECT_EQ(last, 0);
  // The tissue relaxes while the hand rests.
  EXPECT_LT(glm::length(felt[2650].f_T_W), 0.98 * strongest);
  EXPECT_GT(glm::length(felt[2650].f_T_W), 0.2 * strongest);
}

TEST_F(SoftGum, ReplaysARecordedSessionBitForBit) {
  for (const double pedal : {0.0, 1.0}) {
    Ran ran = expect_ok(
        folder.run(fmt::format("servo {} --hand {} --out {}", soft, path(0.6, pedal), folder / "session.h5")));
    ran = folder.run("replay {}/session.h5 --check");
    EXPECT_EQ(ran.status, 0) << ran.out << ran.err;
  }
}

/// A hand that presses a probe into the gum and leaves, on a simulated clock.
class PressingHand : public haptics::HapticDevice {
 public:
  explicit PressingHand(const dvec3& top) : top_(top) { info_.rate = 1000; }
  const haptics::DeviceInfo& info() const noexcept override { return info_; }
  bool read(haptics::HandSample& sample) noexcept override {
    clock += 1'000'000;
    const double height = std::clamp(1e-3 - 4e-6 * ticks_, -0.6e-3, 1e-3);
    sample = {clock, {top_ + dvec3(0, 0, 0.25e-3 + height)}, 0, 1};
    return ++ticks_ <= 800;
  }
  void write(const dvec3&, const dvec3&) noexcept override {}
  std::uint32_t faults() const noexcept override { return 0; }
  static Nanos simulated() noexcept { return clock; }

 private:
  static inline Nanos clock = 0;
  dvec3 top_;
  haptics::DeviceInfo info_;
  int ticks_ = 0;
};

TEST_F(SoftGum, OfALiveSessionReachesEveryPictureOnTheServosTape) {
  const Scene with_gum = read_scene(soft);
  LiveSession session(with_gum, load_tissue(with_gum));
  PressingHand hand(top);
  session.serve(hand.info());
  ASSERT_TRUE(session.gum);
  Wiring& wiring = session.wiring;
  wiring.patch.offer(session.carver, top);
  ServoTurns servo(session, hand, PressingHand::simulated);
  std::map<std::uint32_t, float> seen, seen_in_headset;
  EventLog<ServoEvent>::Reader picture(wiring.event_logs.servo), headset(wiring.event_logs.servo);
  const auto read = [](EventLog<ServoEvent>::Reader& reader, std::map<std::uint32_t, float>& all) {
    for (ServoEvent event; reader.next(event);)
      if (const auto* const moves = std::get_if<GumMoves>(&event))
        for (std::uint32_t i = 0; i < moves->count; ++i) all[moves->points[i].point] = moves->points[i].inward;
  };
  while (servo.turn()) read(picture, seen);
  read(headset, seen_in_headset);
  EXPECT_EQ(seen_in_headset, seen);
  double deep = 0;
  for (const auto& [point, inward] : seen) {
    EXPECT_NEAR(inward, session.servo->soft()->inward(point), 30e-6) << point;
    deep = std::max<double>(deep, inward);
  }
  EXPECT_GT(deep, 0.15e-3);
  EXPECT_GT(seen.size(), 16u);
}

TEST_F(SoftGum, ARecordingShowsTheDentAndTheWoundAtAnyTimeForwardAndBackward) {
  expect_ok(folder.run(fmt::format("servo {} --hand {} --out {}", soft, path(0.8, 1), folder / "session.h5")));
  SessionPlayer player(std::filesystem::path(folder / "session.h5"));
  const SurroundingsShape shape(*player.scene().surroundings);
  const Surroundings& around = player.world().surroundings();
  const SoftGumView& gum = *player.world().gum();
  const auto at = [&](double t) {
    player.seek(t);
    return deepest(gum, around, shape);
  };
  EXPECT_LT(at(0.1), 0.05e-3);
  const double pressed = at(2.5), cut = at(4.9);
  EXPECT_GT(pressed, 0.2e-3);
  EXPECT_GT(cut, 0.1e-3);
  at(0.1);
  EXPECT_TRUE(as_made(gum, around));
  EXPECT_EQ(at(4.9), cut);
}

TEST_F(SoftGum, NamesMistakesInTheScene) {
  for (const auto& [key, expected] : {std::pair(R"({"modulus": 1})", "modulus"),
                                      std::pair(R"({"return_s": 0})", "return_s"), std::pair(R"(3)", "soft")}) {
    const std::string file = scene("wrong", fmt::format(R"(, "soft": {})", key));
    expect_exit(folder.run(fmt::format("servo {} --hand {} --out {}", file, path(0.1, 0), folder / "t.csv")), 2,
                expected);
  }
}

TEST_F(SoftGum, IsSeenWhereItIsPressedAndNowhereElseUntilItHasReturned) {
  const Scene with_gum = read_scene(soft);
  const Surroundings around = make_surroundings(with_gum.surroundings);
  const SurroundingsShape shape(*with_gum.surroundings);
  SteppedSession session(with_gum, load_tissue(with_gum), 1000);
  SoftGumView view(session.settings().soft, around);
  EventLog<ServoEvent>::Reader reader(session.event_logs().servo);
  Nanos t = 0;
  const auto hold = [&](double height, double seconds) {
    for (int i = 0; i < 1000 * seconds; ++i, t += 1'000'000) {
      session.tick({t, {top + dvec3(0, 0, 0.25e-3 + height)}, 0, 1});
    }
    for (ServoEvent event; reader.next(event);) view.apply(event);
    view.follow(t);
  };
  hold(3e-3, 0.1);
  EXPECT_EQ(view.version(), 0u) << "a gum at rest makes no brick";
  for (int i = 0; i < 100; ++i) hold(1e-3 - 15e-6 * i, 5e-3);
  hold(-0.5e-3, 0.5);
  EXPECT_GT(deepest(view, around, shape), 0.06e-3);
  EXPECT_FALSE(as_made(view, around));
  EXPECT_LT(deepest(view, around, shape), 0.6e-3);
  std::size_t changed = 0, fine = 0;
  for (const SoftGumView::Brick& brick : view.bricks()) {
    if (!brick.coarse) ++fine;
    if (brick.coarse || brick.version == 0) continue;
    ++changed;
    for (const render::Vertex& v : brick.now.vertices) {
      ASSERT_NEAR(glm::length(v.n), 1, 1e-4);
      ASSERT_EQ(v.shows, 0) << "a dent does not bleed";
    }
  }
  EXPECT_GT(changed, 0u);
  EXPECT_LT(changed, fine / 2);
  hold(3e-3, 6);
  const std::uint64_t version = view.version();
  hold(3e-3, 1);
  EXPECT_EQ(view.version(), version) << "the gum sleeps again";
  EXPECT_TRUE(as_made(view, around));
}

TEST_F(SoftGum, ADeepCutStaysAndBleedsToABoundWhileTheDamageCounts) {
  const Scene with_gum = read_scene(soft);
  const Surroundings around = make_surroundings(with_gum.surroundings);
  const SurroundingsShape shape(*with_gum.surroundings);
  SteppedSession session(with_gum, load_tissue(with_gum), 1000);
  haptics::SoftTissue& tissue = *session.servo().soft();
  SoftGumView view(session.settings().soft, around);
  EventLog<ServoEvent>::Reader reader(session.event_logs().servo);
  auto damage = damage_meter(with_gum);
  Nanos t = 0;
  for (int i = 0; i < 1500; ++i, t += 1'000'000) {
    const double height = i < 600 ? 1e-3 - 3e-6 * i : i < 1000 ? -0.8e-3 : std::min(-0.8e-3 + 10e-6 * (i - 1000), 3e-3);
    damage->add({&session.tick({t, {top + dvec3(0, 0, 0.6e-3 + height)}, i < 1000 ? 1.0 : 0.0, 0}), 1});
  }
  // The reported volume is what the rotating head swept in the resting gum. The head removed nearly all of this volume.
  double removed = 0;
  for (std::uint32_t i = 0; i < tissue.surface().points().size(); ++i) {
    removed += tissue.cut_depth(i) * tissue.surface().points()[i].area;
  }
  EXPECT_GT(removed, 0.05e-9);
  EXPECT_NEAR(damage->result().gum_volume / removed, 1, 0.5);
  ASSERT_FALSE(tissue.wounds().empty());
  const auto reddest = [&](Nanos at) {
    for (ServoEvent event; reader.next(event);) view.apply(event);
    view.follow(at);
    double most = 0;
    std::size_t red = 0;
    for (const SoftGumView::Brick& brick : view.bricks()) {
      if (brick.coarse) continue;
      for (const render::Vertex& v : brick.now.vertices) {
        most = std::max<double>(most, v.shows);
        if (v.shows > 0.1f) ++red;
      }
    }
    return std::pair(most, red);
  };
  const auto soon = reddest(t + 500'000'000), later = reddest(t + 10'000'000'000), end = reddest(t + 60'000'000'000),
             bound = reddest(t + 600'000'000'000);
  EXPECT_GT(soon.second, 0u);
  EXPECT_GT(later.second, 2 * soon.second) << "the patch grows";
  EXPECT_GT(end.first, 0.8);
  EXPECT_LE(end.second, bound.second);
  EXPECT_LT(10 * bound.second, 11 * end.second) << "up to its bound";
  EXPECT_GT(deepest(view, around, shape), 0.25e-3) << "the cut stays";
}

}  // namespace
}  // namespace typodont
