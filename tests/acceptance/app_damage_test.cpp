// Tests damage that a bur does to the teeth and the gum around the working tooth: it is found, measured and scored.
#include <gtest/gtest.h>

#include "engine/app/recording/resume.h"
#include "engine/app/scene.h"
#include "engine/app/surroundings/surroundings.h"
#include "engine/app/task/damage.h"
#include "engine/base/units.h"
#include "engine/session/score.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

/// A ball as a tooth, and another one that touches it at x = 3 mm.
class Damage : public testing::Test {
 protected:
  Damage() {
    folder.write(
        "ball.json",
        R"({"tissue": {"voxel_mm": 0.1, "solids": [{"tissue": "enamel", "solid": {"sphere": {"radius_mm": 3}}}]}, "tool": "round_012"})");
    load_tissue(read_scene(folder.path() / "ball.json")).save(folder.path() / "ball.vdb");
    folder.write("scene.json", scene(R"("surroundings": {"neighbours": [{"contact_mm": [3, 0, 0]}]},)"));
  }
  static std::string scene(const std::string& surroundings) {
    return R"({"tissue": {"volume": "ball.vdb"}, )" + surroundings +
           R"("tools": [{"shape": "sphere", "diameter_mm": 1.6}, "probe_who_621"], "spindle_krpm": 300,
              "task": {"goal": "leave the neighbour alone", "ideal": {"remove": [{"sphere": {"center_mm": [0, 0, 3], "radius_mm": 1}}]}}})";
  }
  static ServoTick at(const dvec3& p_mm, double spindle = 1e4, std::uint32_t tool = 0) {
    ServoTick tick;
    tick.X_WT.p = tick.X_WG.p = p_mm * 1e-3;
    tick.spindle = spindle;
    tick.tool = tool;
    return tick;
  }
  test::ProgramFolder folder{TYPODONT_PROGRAM};
};

/// Returns the volume that two balls with radii r and R have in common. Their centres have the distance d.
double lens(double r, double R, double d) {
  const double s = r + R - d;
  return kPi * s * s * (d * d + 2 * d * r - 3 * r * r + 2 * d * R + 6 * r * R - 3 * R * R) / (12 * d);
}

TEST_F(Damage, ToANeighbourIsTheVolumeSweptByTheTurningHeadWithinAFewPercent) {
  auto meter = damage_meter(read_scene(folder.path() / "scene.json"));
  ASSERT_TRUE(meter);
  // The neighbour's middle is at x = 6 mm.
  for (double z = 5; z >= 3.3; z -= 0.02) meter->add({{at({6, 0, z})}});
  const session::DamageMeasures m = meter->result();
  EXPECT_TRUE(m.neighbours);
  EXPECT_FALSE(m.gum);
  EXPECT_NEAR(m.neighbour_volume * 1e9 / lens(0.8, 3.0, 3.3), 1, 0.12);
  ASSERT_EQ(m.touches.size(), 1u);
  EXPECT_DOUBLE_EQ(m.touches[0].volume, m.neighbour_volume);
}

TEST_F(Damage, IsZeroForAStoppedBurADistantBurAndAProbe) {
  auto meter = damage_meter(read_scene(folder.path() / "scene.json"));
  for (double z = 5; z >= 3.2; z -= 0.02) {
    meter->add({{at({6, 0, z}, 0)}});
    meter->add({{at({6, 0, z}, 1e4, 1)}});
    meter->add({{at({0, 0, z})}});
  }
  meter->add({{at({6, 0, 3.82})}});
  EXPECT_EQ(meter->result().neighbour_volume, 0);
  EXPECT_TRUE(meter->result().touches.empty());
}

TEST_F(Damage, DamageToTheGumIsTheSweptVolumeOutsideTheToothAndCostsPoints) {
  folder.write(
      "gum.json",
      scene(
          R"("surroundings": {"neighbours": [], "gum": {"margin_mm": [0, 0, -0.5], "thickness_mm": 1.2, "papilla_mm": 0, "length_mm": 12}},)"));
  const Scene with_gum = read_scene(folder.path() / "gum.json");
  const SurroundingsShape shape(*with_gum.surroundings);
  ASSERT_TRUE(shape.has_gum());
  // Counts the gum's volume in the head at this position again, on points that are twice as close as the cells of the
  // meter. Points in the tooth do not count.
  const dvec3 held = {0, 2.8e-3, -2.4e-3};
  const double radius = 0.8e-3, step = 0.05e-3;
  double expected = 0;
  for (double x = -radius; x < radius; x += step) {
    for (double y = -radius; y < radius; y += step) {
      for (double z = -radius; z < radius; z += step) {
        const dvec3 p(x, y, z);
        if (glm::length(p) < radius && shape.gum(held + p) < 0 && shape.tooth(held + p) > 0)
          expected += step * step * step;
      }
    }
  }
  ASSERT_GT(expected, 0.1e-9);
  auto meter = damage_meter(with_gum);
  meter->add({{at(held * 1e3, 0)}});       // the tool does not rotate
  meter->add({{at(held * 1e3, 1e4, 1)}});  // a probe
  EXPECT_EQ(meter->result().gum_volume, 0);
  meter->add({{at(held * 1e3)}});
  const session::DamageMeasures m = meter->result();
  EXPECT_TRUE(m.gum);
  EXPECT_NEAR(m.gum_volume / expected, 1, 0.15);
  EXPECT_EQ(m.neighbour_volume, 0);

  session::ScoreInput unharmed, harmed;
  unharmed.before[1] = harmed.before[1] = 100e-9;
  unharmed.after[1] = harmed.after[1] = 90e-9;  // an untouched tooth would earn nothing
  unharmed.damage = session::DamageMeasures{false, true, 0, 0, {}};
  harmed.damage = m;
  const session::Score sound = session::score(unharmed, session::default_rules(unharmed)),
                       hurt = session::score(harmed, session::default_rules(harmed));
  EXPECT_EQ(sound.full, hurt.full);
  EXPECT_LT(hurt.points, sound.points);
}

TEST_F(Damage, CostsPointsInTheReportOnlyIfTheSceneHasSurroundings) {
  folder.write("clear.csv",
               "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,5,1,0,0,0,1\n1,0,0,3.2,1,0,0,0,1\n2,0,0,5,1,0,0,0,1\n3,6,0,"
               "5,1,0,0,0,1\n4,6,0,4,1,0,0,0,1\n");
  folder.write("deep.csv",
               "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,5,1,0,0,0,1\n1,0,0,3.2,1,0,0,0,1\n2,0,0,5,1,0,0,0,1\n3,6,0,"
               "5,1,0,0,0,1\n4,6,0,3,1,0,0,0,1\n");
  folder.write("alone.json", scene(""));
  struct Judged {
    double points, removed;
  };
  const auto judged = [&](const std::string& scene, const std::string& hand) {
    EXPECT_EQ(folder.run("servo {}/" + scene + " --hand {}/" + hand + " --out {}/s.h5").status, 0);
    const test::Ran report = expect_ok(folder.run("report {}/s.h5 --out {}/r.html --json"));
    const Json json = Json::parse(report.out, "report");
    Judged j{json["points"].number(), -1};
    for (const Json& item : json["items"].items()) {
      if (item["name"].string() == "neighbour_removed_mm3") j.removed = item["value"].number();
    }
    return j;
  };
  const Judged clear = judged("scene.json", "clear.csv"), deep = judged("scene.json", "deep.csv"),
               alone = judged("alone.json", "deep.csv");
  EXPECT_EQ(clear.removed, 0);
  EXPECT_NEAR(deep.removed / lens(0.8, 3.0, 3.0), 1, 0.12);
  EXPECT_LT(deep.points, 0.9 * clear.points);
  EXPECT_EQ(alone.removed, -1);
}

}  // namespace
}  // namespace typodont
