// Tests the commands for persons who build a bench: `rig plan`, `calibrate hand-eye` and `calibrate robot-world`, and
// the units of tables.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <string>

#include "calibration/statistics.h"
#include "engine/base/json.h"
#include "engine/base/units.h"
#include "engine/display/display_rig.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

using namespace test;
using calibration::Noise;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

class BenchCommands : public testing::Test {
 protected:
  Ran run(const std::string& arguments) const { return folder.run(arguments, "timeout 60"); }
  Ran refused(const std::string& arguments, const std::string& message, int status = 2) const {
    const Ran ran = run(arguments);
    EXPECT_EQ(ran.status, status) << arguments << "\n" << ran.err;
    EXPECT_THAT(ran.err, HasSubstr(message)) << arguments;
    return ran;
  }
  ProgramFolder folder{TYPODONT_PROGRAM};
};

// ---- rig plan

TEST_F(BenchCommands, ThePlanStatesThePositionOfEveryPartAndTheSizeOfTheWorkspace) {
  const Ran ran =
      expect_ok(run("rig plan --screen-mm 531 299 --mirror-deg 0 --picture-deg 20 --gaze-deg 52 --eye-mm 520 "
                    "--glass-mm 150 --arm touch --json"));
  const Json plan = Json::parse(ran.out, "plan");
  EXPECT_TRUE(plan["fits"].boolean());
  const dvec3 eye = plan["eye_center_mm"].vec3();
  EXPECT_NEAR(glm::length(eye), 520, 1e-2);
  EXPECT_NEAR(eye.z, 520 * std::sin(52 * kDegree), 1e-2);
  // The bench has a level mirror 150 mm above the work. Its panel is 300 mm above the work and tilted in the opposite
  // direction.
  const dvec3 ll = plan["panel_mm"]["lower_left"].vec3(), ul = plan["panel_mm"]["upper_left"].vec3();
  EXPECT_NEAR(0.5 * (ll.z + ul.z), 300, 1e-2);
  EXPECT_NEAR(ul.z - ll.z, -299 * std::sin(20 * kDegree), 1e-2);
  const dvec3 size = plan["workspace_mm"]["size"].vec3();
  EXPECT_LE(size.x, 160.001);
  EXPECT_LE(size.y, 70.001);
  EXPECT_GT(size.x * size.y * size.z, 0.9 * 160 * 70 * 120);
}

TEST_F(BenchCommands, TheDrawingIsOnePageOfSvgOrPdf) {
  ASSERT_EQ(run("rig plan --out " + folder / "bench.svg").status, 0);
  ASSERT_EQ(run("rig plan --out " + folder / "bench.pdf").status, 0);
  const std::string svg = read_text(folder / "bench.svg"), pdf = read_text(folder / "bench.pdf");
  EXPECT_THAT(svg, AllOf(StartsWith("<?xml"), HasSubstr("<svg"), HasSubstr("</svg>"), HasSubstr("841.88")));
  EXPECT_THAT(pdf, AllOf(StartsWith("%PDF-"), HasSubstr("/Count 1"), HasSubstr("%%EOF")));
  // The command may overwrite a drawing, but no other kind of file.
  EXPECT_EQ(run("rig plan --out " + folder / "bench.pdf").status, 0);
  folder.write("table.pdf", "a,b\n1,2\n");
  refused("rig plan --out " + folder / "table.pdf", "table.pdf");
  EXPECT_EQ(read_text(folder / "table.pdf"), "a,b\n1,2\n");
  refused("rig plan --out " + folder / "bench.doc", "a drawing (.svg) or a document (.pdf)");
}

TEST_F(BenchCommands, TheRigWrittenByAPlanCanBeRendered) {
  const std::string file = folder / "bench.json";
  ASSERT_EQ(run("rig plan --work-mm 10 20 30 --rig " + file).status, 0);
  const display::DisplayRig rig = display::load_rig(file);
  ASSERT_TRUE(rig.mirror);
  EXPECT_TRUE(display::sees(rig, rig.head));
  // The picture appears at the work.
  const display::Screen seen = reflect(*rig.mirror, rig.screen);
  EXPECT_LT(glm::length(0.5 * (seen.lower_right + seen.upper_left) - dvec3(0.01, 0.02, 0.03)), 2e-6);
  EXPECT_LT(glm::length(rig.X_WH.p - dvec3(0.01, 0.02, 0.03)), 2e-6);
}

TEST_F(BenchCommands, ACollidingBenchIsRefusedWithAReasonAndItsDrawingIsWritten) {
  refused("rig plan --mirror-deg 25 --picture-deg 40 --gaze-deg 50 --rig " + folder / "no.json" + " --out " +
              folder / "no.svg",
          "this bench does not fit: the panel stands between the eyes and the glass", 1);
  EXPECT_FALSE(std::filesystem::exists(folder / "no.json"));
  EXPECT_TRUE(std::filesystem::exists(folder / "no.svg"));
}

TEST_F(BenchCommands, ImpossibleDimensionsAreRefused) {
  refused("rig plan --screen-mm 5 300", "--screen-mm: found 5 300, expected width and height of 50 to 3000");
  refused("rig plan --arm-box-mm 100 100 0",
          "--arm-box-mm: found 100 100 0, expected width, depth and height of 10 to 3000");
  refused("rig plan --eye-mm nan", "--eye-mm");
  refused("rig plan --mirror-deg 90", "--mirror-deg");
  refused("rig plan --arm robot", "--arm");
  refused("rig", "");
}

// ---- hand-eye and robot-world

constexpr const char* kPoseColumns = "ax_mm,ay_mm,az_mm,aqw,aqx,aqy,aqz,bx_mm,by_mm,bz_mm,bqw,bqx,bqy,bqz\n";

dquat turn_by(const dvec3& v) {
  const double angle = glm::length(v);
  const dvec3 s = std::sin(0.5 * angle) / angle * v;
  return {std::cos(0.5 * angle), s.x, s.y, s.z};
}
std::string row(const Pose& a, const Pose& b, double unit = 1e3) {
  return fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", a.p.x * unit, a.p.y * unit, a.p.z * unit, a.R.w,
                     a.R.x, a.R.y, a.R.z, b.p.x * unit, b.p.y * unit, b.p.z * unit, b.R.w, b.R.x, b.R.y, b.R.z);
}
const Pose kX{{0.02, -0.01, 0.06}, glm::normalize(dquat(0.95, 0.15, 0.1, -0.25))};
const Pose kZ{{0.4, 0.3, 0.9}, glm::normalize(dquat(0.4, 0.8, 0.2, 0.4))};

/// Returns a table of poses. `tracker(arm)`: pose that the other sensor measures.
std::string poses(const std::function<Pose(const Pose&)>& tracker, int count = 24, double unit = 1e3) {
  Noise random(3);
  std::string text;
  for (int i = 0; i < count; ++i) {
    const Pose arm{random.in_box(dvec3(-0.08), dvec3(0.08)), turn_by(random.in_box(dvec3(-0.7), dvec3(0.7)))};
    Pose seen = tracker(arm);
    seen = {seen.p + random.normal3(1e-4), seen.R * turn_by(random.normal3(1e-3))};
    text += row(arm, seen, unit);
  }
  return text;
}
Pose marker_seen(const Pose& arm) {
  return inverse(kZ) * arm * kX;
}
Pose target_seen(const Pose& arm) {
  return inverse(kX) * inverse(arm) * kZ;
}

void expect_pose(const Json& json, const Pose& truth, double mm, double rad) {
  const auto q = json["rotation_wxyz"].numbers(4);
  EXPECT_LT(glm::length(json["translation_mm"].vec3() - truth.p * 1e3), mm);
  EXPECT_LT(rotation_angle(dquat(q[0], q[1], q[2], q[3]), truth.R), rad);
}

TEST_F(BenchCommands, RobotWorldFindsTrackerAndMarker) {
  folder.write("poses.csv", kPoseColumns + poses(marker_seen));
  const Ran ran =
      expect_ok(run("calibrate robot-world --poses " + folder / "poses.csv" + " --out " + folder / "rw.json"));
  EXPECT_THAT(ran.out, AllOf(HasSubstr("X_SM"), HasSubstr("X_HK"), HasSubstr("24 rows used")));
  const Json json = Json::load(folder / "rw.json");
  expect_pose(json["X_SM"], kX, 1, 2e-3);
  expect_pose(json["X_HK"], kZ, 3, 2e-3);
  EXPECT_NEAR(json["noise_mm"].number(), 0.1, 0.04);
  EXPECT_GT(json["X_SM_sigma_mm"].number(), 0.005);
  EXPECT_LT(json["X_SM_sigma_mm"].number(), 0.3);
  EXPECT_EQ(json["X_HK_covariance"].items().size(), 6u);
  EXPECT_EQ(json["residuals_mm"].items().size(), 24u);
}

TEST_F(BenchCommands, HandEyeFindsTheCameraOnTheStylusFromPosesAndFromMotions) {
  folder.write("poses.csv", kPoseColumns + poses(target_seen));
  const Ran ran = expect_ok(run("calibrate hand-eye --json --poses " + folder / "poses.csv"));
  const Json json = Json::parse(ran.out, "out");
  expect_pose(json["X_SK"], kX, 3, 2e-3);
  expect_pose(json["X_HM"], kZ, 3, 2e-3);
  folder.write("motions.csv", kPoseColumns + poses([](const Pose& motion) { return inverse(kX) * motion * kX; }));
  const Ran motions = expect_ok(run("calibrate hand-eye --motions --json --poses " + folder / "motions.csv"));
  expect_pose(Json::parse(motions.out, "out")["X_SK"], kX, 1, 2e-3);
  EXPECT_FALSE(Json::parse(motions.out, "out").has("X_HM"));
}

TEST_F(BenchCommands, DegenerateMotionAndTheWrongCommandAreRefusedWithTheReason) {
  Noise random(5);
  std::string one_axis = kPoseColumns;
  for (int i = 0; i < 12; ++i) {
    const Pose arm{random.in_box(dvec3(-0.08), dvec3(0.08)), turn_by(dvec3(0, 0, random.uniform(0.1, 1)))};
    one_axis += row(arm, marker_seen(arm));
  }
  folder.write("one_axis.csv", one_axis);
  refused("calibrate robot-world --poses " + folder / "one_axis.csv", "all turns are about one axis, (0.000, 0.000,",
          1);
  folder.write("poses.csv", kPoseColumns + poses(target_seen));
  refused("calibrate robot-world --poses " + folder / "poses.csv", "they do fit with every pose b inverted", 1);
}

TEST_F(BenchCommands, WrongPoseTablesNameFileLineAndColumn) {
  const std::string good = poses(marker_seen);
  folder.write("two.csv", kPoseColumns + poses(marker_seen, 2));
  refused("calibrate robot-world --poses " + folder / "two.csv", "two.csv: found 2 rows, expected at least 3");
  folder.write("none.csv", kPoseColumns);
  refused("calibrate hand-eye --poses " + folder / "none.csv", "none.csv: found 0 rows, expected at least 3");
  folder.write("long.csv", kPoseColumns + good + "50,60,70,2,0,0,0,50,60,70,1,0,0,0\n");
  refused("calibrate robot-world --poses " + folder / "long.csv",
          "long.csv: line 26, column aqw to aqz: found a quaternion of length 2, expected length 1, within 1 %");
  folder.write("cell.csv", kPoseColumns + good + "50,60,x,1,0,0,0,50,60,70,1,0,0,0\n");
  refused("calibrate robot-world --poses " + folder / "cell.csv", "cell.csv: line 26, column az_mm: found \"x\"");
  folder.write("column.csv", "ax_mm,ay_mm,az_mm\n1,2,3\n");
  refused("calibrate robot-world --poses " + folder / "column.csv", "column.csv: line 1: found no column \"aqw\"");
  refused("calibrate robot-world --poses " + folder / "nowhere.csv", "nowhere.csv");
}

// ---- units

TEST_F(BenchCommands, MetresUnderMillimetreNamesAreRefusedAndMetreNamesAreRead) {
  Noise random(7);
  std::string mm, m;
  for (int i = 0; i < 12; ++i) {
    const dvec3 h = random.in_box(dvec3(-0.08), dvec3(0.08)), d = kZ * h;
    mm += fmt::format("{},{},{},{},{},{}\n", h.x * 1e3, h.y * 1e3, h.z * 1e3, d.x * 1e3, d.y * 1e3, d.z * 1e3);
    m += fmt::format("{},{},{},{},{},{}\n", h.x, h.y, h.z, d.x, d.y, d.z);
  }
  const std::string mm_names = "hx_mm,hy_mm,hz_mm,dx_mm,dy_mm,dz_mm\n", m_names = "hx_m,hy_m,hz_m,dx_m,dy_m,dz_m\n";
  folder.write("mm.csv", mm_names + mm), folder.write("m.csv", m_names + m);
  folder.write("wrong.csv", mm_names + m), folder.write("other.csv", m_names + mm);
  const auto X = [&](const char* file) {
    const Ran ran = expect_ok(run(std::string("calibrate register --json --pairs ") + (folder / file)));
    return Json::parse(ran.out, file)["X_DH"]["translation_mm"].vec3();
  };
  EXPECT_LT(glm::length(X("mm.csv") - kZ.p * 1e3), 1e-6);
  EXPECT_LT(glm::length(X("m.csv") - kZ.p * 1e3), 1e-6);
  const Ran wrong = refused("calibrate register --pairs " + folder / "wrong.csv", "expected more than 3 mm");
  EXPECT_THAT(wrong.err, HasSubstr("columns hx_mm,hy_mm,hz_mm"));
  EXPECT_THAT(wrong.err, HasSubstr("name the columns hx_m,hy_m,hz_m where they are metres"));
  refused("calibrate register --pairs " + folder / "other.csv", "name the columns hx_mm,hy_mm,hz_mm");
  folder.write("mixed.csv", "hx_m,hy_m,hz_m,dx_mm,dy_m,dz_mm\n" + m);
  refused("calibrate register --pairs " + folder / "mixed.csv", "found column \"dx_mm\"");
  // The same for poses and streams.
  folder.write("poses.csv", kPoseColumns + poses(marker_seen, 24, 1));
  refused("calibrate robot-world --poses " + folder / "poses.csv", "name the columns ax_m,ay_m,az_m");
  std::string stream = "t_s,x_mm,y_mm,z_mm\n";
  for (int i = 0; i < 40; ++i) stream += fmt::format("{},{},0,0\n", 0.01 * i, 0.05 * std::sin(0.3 * i));
  folder.write("stream.csv", stream);
  refused(fmt::format("calibrate delay --a {0} --b {0}", folder / "stream.csv"), "name the columns x_m,y_m,z_m");
}

}  // namespace
}  // namespace typodont
