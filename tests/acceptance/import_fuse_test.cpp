// Tests `typodont fuse` through the command line with the synthetic jaw: its output files and report, and which input
// it refuses.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/fuse_phantom.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

using test::Ran;

/// Points of the crowns that a person recognises, mm in the CT.
const std::vector<dvec3> kLandmarks{{9.5, 12, 31}, {20, 12, 31}, {5.6, 12, 27}, {20, 8.1, 27}};

class FuseCommand : public ::testing::Test {
 protected:
  FuseCommand() { haptics::TissueVolume(test::ct()).save(ct_); }

  std::string write_pairs(const std::string& name, const std::vector<dvec3>& points_C, double scale = 1) {
    std::string text = "sx_mm,sy_mm,sz_mm,cx_mm,cy_mm,cz_mm\n";
    std::mt19937 random(9);
    std::normal_distribution<double> noise(0, 0.3);
    for (const dvec3& c : points_C) {
      const dvec3 s = scale * (inverse(X_CS_) * (c * kMillimetre)) / kMillimetre;
      text += fmt::format("{},{},{},{},{},{}\n", s.x + noise(random), s.y + noise(random), s.z + noise(random), c.x,
                          c.y, c.z);
    }
    return folder_.write(name, text);
  }
  Ran fuse(const std::string& scan, const std::string& pairs, const std::string& more = "") {
    return folder_.run(fmt::format("fuse {} {} --pairs {} --out {} {}", ct_, scan, pairs, out_, more));
  }
  void expect_refused(const Ran& ran, const std::string& message) {
    expect_exit(ran, 2, message);
    EXPECT_FALSE(std::filesystem::exists(out_));
  }

  test::ProgramFolder folder_{TYPODONT_PROGRAM};
  const std::string ct_ = folder_ / "jaw.vdb", out_ = folder_ / "fused.vdb";
  const Pose X_CS_{dvec3(0.02, -0.03, 0.05), glm::angleAxis(2.0, glm::normalize(dvec3(1, 2, -1)))};
};

TEST_F(FuseCommand, FusesFromFourClicksAndWritesNothingForInputThatGivesNoPose) {
  const std::string scan = test::write_stl("crowns.stl", test::scanned(X_CS_, 1)).string();
  const std::string pairs = write_pairs("pairs.csv", kLandmarks);

  expect_refused(fuse(scan, write_pairs("two.csv", {kLandmarks[0], kLandmarks[1]})),
                 "two.csv: found 2 pairs, expected three pairs of points or more, not on one line");
  expect_refused(fuse(scan, write_pairs("line.csv", {{9.5, 12, 31}, {14.5, 12, 31}, {20, 12, 31}, {25, 12, 31}})),
                 "on one line");
  expect_refused(fuse(scan, write_pairs("tenths.csv", kLandmarks, 10)), "check the units");
  expect_refused(fuse(scan, pairs, "--unit-mm 1000"), "--unit-mm");
  expect_refused(fuse(folder_.write("text.stl", "this is no mesh"), pairs), "text.stl");
  expect_refused(fuse(folder_ / "missing.stl", pairs), "missing.stl");
  // Clicks on the wrong teeth, 10 mm away.
  std::vector<dvec3> wrong = kLandmarks;
  const Pose X = X_CS_;
  std::string text = "sx_mm,sy_mm,sz_mm,cx_mm,cy_mm,cz_mm\n";
  for (const dvec3& c : wrong) {
    const dvec3 s = inverse(X) * (c * kMillimetre) / kMillimetre;
    text += fmt::format("{},{},{},{},{},{}\n", s.x, s.y, s.z, c.x + 5, c.y + 4, c.z - 3);
  }
  expect_refused(fuse(scan, folder_.write("wrong.csv", text)), "crowns.stl: fine registration: ");

  const Ran good = expect_ok(fuse(scan, pairs, "--voxel-mm 0.2 --json"));
  const auto report = nlohmann::json::parse(good.out);
  EXPECT_LT(report.at("registration").at("predicted_error_mm"), 0.03);
  EXPECT_LT(report.at("registration").at("residual_median_mm"), 0.03);
  // 345 mm² of the scan are crowns above the gum. The whole scan has 500 mm².
  EXPECT_NEAR(report.at("covered_area_mm2"), 345, 15);
  const haptics::TissueVolume fused = haptics::TissueVolume::load(out_);
  EXPECT_NEAR(fused.frame().voxel, 0.2e-3, 1e-9);
}

}  // namespace
}  // namespace typodont
