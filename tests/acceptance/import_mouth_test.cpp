// Tests the import of several intraoral scans through the command line: the poses that the bite scan gives, the scene
// that the command writes, and which files it refuses.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "engine/base/units.h"
#include "engine/session/ticks_csv.h"
#include "tests/support/mouth_phantom.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

using test::bite_scan;
using test::moved;
using test::Ran;
using test::TissueMesh;
using test::upper_jaw;
using ::testing::HasSubstr;
using ::testing::Not;

class ImportMouth : public ::testing::Test {
 protected:
  Ran import(const std::string& files, const std::string& more = "", double voxel_mm = 0.25) {
    return folder_.run(fmt::format("import {} --preset arch --voxel-mm {} --band-mm 1 --out {} --json {}", files,
                                   voxel_mm, out_, more));
  }
  void expect_refused(const Ran& ran, const std::string& message) {
    expect_exit(ran, 2, message);
    EXPECT_FALSE(std::filesystem::exists(out_));
  }
  static std::string stl(const std::string& name, const TissueMesh& mesh) {
    return test::write_stl(name, mesh).string();
  }

  test::ProgramFolder folder_{TYPODONT_PROGRAM};
  const std::string out_ = folder_ / "mouth.json", volume_ = folder_ / "mouth.vdb";
  const std::string lower_ = stl("lower.stl", test::true_surface());
  // X_KW: pose of frame W (the lower jaw's file) in frame K (the upper jaw's file)
  const Pose X_KW_{dvec3(0.5, -0.4, 0.6) * kMillimetre, glm::angleAxis(0.015, glm::normalize(dvec3(1, -1, 2)))};
};

TEST_F(ImportMouth, TheBiteScanPlacesTheUpperJawAndTheSceneContainsBoth) {
  const std::string upper = stl("upper.stl", moved(upper_jaw(), X_KW_));
  const Pose X_BW{dvec3(-0.3, 0.4, -0.2) * kMillimetre, glm::angleAxis(0.01, dvec3(0, 0, 1))};
  const std::string bite = stl("bite.stl", moved(bite_scan(), X_BW));
  const Ran ran = expect_ok(import(lower_ + " " + upper, "--bite " + bite));
  const auto report = nlohmann::json::parse(ran.out);
  const auto& X = report.at("scans").at(1).at("X_WK");
  const auto p = X.at("translation_mm").get<std::vector<double>>();
  const auto q = X.at("quaternion_wxyz").get<std::vector<double>>();
  const Pose X_WK{dvec3(p[0], p[1], p[2]) * kMillimetre, glm::dquat(q[0], q[1], q[2], q[3])};
  double before = 0, after = 0;  // m, largest errors of the upper jaw's position
  for (const dvec3& vertex : upper_jaw().vertices) {
    before = std::max(before, glm::length(X_KW_ * vertex - vertex));
    after = std::max(after, glm::length(X_WK * (X_KW_ * vertex) - vertex));
  }
  EXPECT_GT(before, 0.8 * kMillimetre);
  EXPECT_LT(after, 0.1 * kMillimetre) << "measured: 0.079 mm";
  EXPECT_LT(report.at("scans").at(1).at("bite").at("residual_median_mm"), 0.03);
  EXPECT_LT(report.at("overlap_mm3"), 0.5);

  // The scene shows the highest point of the lower jaw where the rigs look, and the crowns of the upper jaw above it.
  const auto scene = nlohmann::json::parse(test::read_text(out_));
  EXPECT_EQ(scene.at("tissue").at("volume"), "mouth.vdb");
  const haptics::TissueVolume volume = haptics::TissueVolume::load(volume_);
  const auto tissue_at = [&](double above) {
    float distance = 0;
    Tissue tissue = Tissue::kAir;
    const dvec3 place = dvec3(6.8, 6, 20.2 + above) * kMillimetre;
    volume.copy(glm::ivec3(glm::round(volume.frame().to_voxels(place))), glm::ivec3(1), &distance, &tissue);
    return distance < 0 ? tissue : Tissue::kAir;
  };
  EXPECT_EQ(tissue_at(-0.6), Tissue::kEnamel);
  EXPECT_EQ(tissue_at(1.0), Tissue::kEnamel);
}

TEST_F(ImportMouth, WithoutABiteScanTheFilesAreInOneFrameAndTheOpposingJawIsMovedAway) {
  const std::string upper = stl("upper.stl", upper_jaw());
  const auto height = [&](const std::string& more) {
    const Ran ran = expect_ok(import(lower_ + " " + upper, more));
    const auto bounds = nlohmann::json::parse(ran.out).at("bounds_mm");
    return bounds.at(1).at(2).get<double>() - bounds.at(0).at(2).get<double>();
  };
  const double closed = height("");
  EXPECT_NEAR(height("--open-mm 8"), closed + 8, 0.05);
}

TEST_F(ImportMouth, TooSmallVoxelsAreRefusedBeforeTheFirstMeshIsFilled) {
  const Ran ran = import(lower_ + " " + stl("upper.stl", upper_jaw()), "--open-mm 8", 0.01);
  expect_refused(ran, "--voxel-mm: found 0.01");
  EXPECT_THAT(ran.err, Not(HasSubstr("memory are needed"))) << "the message before a mesh is filled";
}

TEST_F(ImportMouth, AToolBetweenTheOpenJawsFeelsAndCutsTheOpposingJaw) {
  expect_ok(import(lower_ + " " + stl("upper.stl", upper_jaw()), "--open-mm 8"));
  // The shank lies between the jaws and points towards -y. The head begins 3 mm above the highest point of the lower
  // jaw and rises into the opposing crown, first without and then with the pedal.
  const dvec3 top = dvec3(6.8, 6, 20.2);
  const auto row = [&](double t, double above, int pedal) {
    return fmt::format("{},{},{},{},0.7071068,0.7071068,0,0,{}\n", t, top.x, top.y, top.z + above, pedal);
  };
  folder_.write("hand.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n" + row(0, 3, 0) + row(0.2, 3, 0) + row(1.2, 8, 0) +
                                row(1.5, 8, 0) + row(1.6, 8, 1) + row(4, 9.5, 1));
  expect_ok(folder_.run(fmt::format("servo {} --hand {} --out {}", out_, folder_ / "hand.csv", folder_ / "t.csv")));
  double free = 0, deepest = 0, removed = 0;  // N, N, mm³
  for (const ServoTick& tick : session::read_ticks_csv(folder_ / "t.csv")) {
    const double t = to_seconds(tick.t), force = tick.f_T_W.z;
    if (t < 0.2) free = std::max(free, std::abs(force));
    if (t < 1.5) deepest = std::min(deepest, force);
    removed = total(tick.removed) / kCubicMillimetre;
  }
  EXPECT_LT(free, 1e-3);
  EXPECT_LT(deepest, -0.3) << "the opposing jaw pushes the hand downwards";
  EXPECT_GT(removed, 0.01);
  // The report counts the cut as damage.
  expect_ok(
      folder_.run(fmt::format("servo {} --hand {} --out {}", out_, folder_ / "hand.csv", folder_ / "session.h5")));
  const Ran scored = expect_ok(folder_.run("report {}/session.h5 --json --out {}/report.html"));
  double damage = 0;
  const auto score = nlohmann::json::parse(scored.out);
  for (const auto& item : score.at("items")) {
    if (item.at("name") == "protected_removed_mm3") damage = item.at("value");
  }
  EXPECT_NEAR(damage, removed, 1e-3);
}

TEST_F(ImportMouth, AVolumeThatBelongsToNoExerciseOfThisNameIsNotReplaced) {
  const std::string jaw = stl("jaw.stl", test::true_surface());
  ASSERT_EQ(folder_.run(fmt::format("import {} --preset arch --voxel-mm 0.4 --out {}", jaw, volume_)).status, 0);
  const std::string before = test::read_text(volume_);
  expect_refused(import(jaw), "does not belong to mouth.json");
  EXPECT_EQ(test::read_text(volume_), before);
}

TEST_F(ImportMouth, AnExerciseWhoseNameIsNotUtf8IsRefusedBecauseItCannotNameItsVolume) {
  expect_exit(folder_.run("import " + lower_ + " --preset arch --out " + (folder_ / "z\xe4hne.json")), 2, "not UTF-8");
}

TEST_F(ImportMouth, WhatTheBiteScanDoesNotConfirmIsRefused) {
  const std::string bite = stl("bite.stl", bite_scan());
  const std::string far = stl("upper.stl", moved(upper_jaw(), Pose{dvec3(0, 0, 10e-3), {}}));
  expect_refused(import(lower_ + " " + far, "--bite " + bite), "bite.stl on upper.stl");
  TissueMesh inward = bite_scan();
  for (glm::uvec3& t : inward.triangles) std::swap(t.y, t.z);
  const std::string upper = stl("upper.stl", upper_jaw());
  expect_refused(import(lower_ + " " + upper, "--bite " + stl("inward.stl", inward)), "inward.stl on lower.stl");
  expect_refused(import(lower_ + " " + folder_.write("scan.nrrd", "NRRD0004\n")), "only if all are meshes");
  expect_refused(folder_.run(fmt::format("import {} --bite {} --out {}", lower_, bite, out_)), "--preset arch");
}

}  // namespace
}  // namespace typodont
