// Tests that the readers return data or throw an Error for any content of a file, and that the solvers accept any
// numbers.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>

#include "calibration/bench_simulator.h"
#include "calibration/calibration_files.h"
#include "calibration/camera_solver.h"
#include "calibration/rig_file.h"
#include "engine/base/error.h"
#include "tests/support/folder.h"

namespace typodont::calibration {
namespace {

TEST(CalibrationStress, MutatedFilesGiveDataOrAnError) {
  const test::Folder folder;
  SimulationOptions options;
  options.touches = 0.1;
  const SimulatedRoutine run = simulate_routine(options);
  write_captures(folder.path(), run.captures);
  RigFile rig = RigFile::create(folder / "rig.json");
  rig.set(run.bench);
  rig.save();
  std::ofstream(folder / "sightings.csv")
      << "picture,on,px,py,u,v,x_mm,y_mm,z_mm\n0,1,10,20,0.1,0.2,,,\n0,0,30,40,,,1,2,3\n";
  std::ofstream(folder / "poses.csv")
      << "ax_mm,ay_mm,az_mm,aqw,aqx,aqy,aqz,bx_m,by_m,bz_m,bqw,bqx,bqy,bqz\n"
         "1,2,50,1,0,0,0,0.1,0.2,0.3,0.6,0.8,0,0\n-1,2,50,0,1,0,0,0.1,0.2,0.3,0,0,0,1\n";
  const std::vector<std::pair<const char*, std::function<void(const std::filesystem::path&)>>> readers = {
      {"arm.csv", [](auto& f) { read_arm_captures(f); }},
      {"marks.csv", [](auto& f) { read_mark_captures(f); }},
      {"mirror.csv", [](auto& f) { read_touches(f); }},
      {"eyes.csv", [](auto& f) { read_eye_captures(f); }},
      {"register.csv", [](auto& f) { read_pair_captures(f); }},
      {"delay_a.csv", [](auto& f) { read_stream(f); }},
      {"register.csv", [](auto& f) { read_pairs(f); }},
      {"poses.csv", [](auto& f) { read_pose_pairs(f); }},
      {"drift.csv", [](auto& f) { read_points(f); }},
      {"rig.json", [](auto& f) { RigFile::load(f).captures_folder(); }},
      {"sightings.csv", [](auto& f) { read_sightings(f); }}};
  Noise random(1);
  const std::string spice = "\"{}[],:.-+eE0123456789nainf \n\r\t\0\xff#";
  int accepted = 0, refused = 0;
  for (const auto& [name, read] : readers) {
    const std::string original = test::read_text(folder / name).substr(0, 6000);
    for (int trial = 0; trial < 250; ++trial) {
      std::string text = original;
      const std::size_t changes = 1 + random.index(6);
      for (std::size_t i = 0; i < changes && !text.empty(); ++i) {
        const std::size_t at = random.index(text.size());
        switch (random.index(4)) {
          case 0:
            text[at] = spice[random.index(spice.size())];
            break;
          case 1:
            text.erase(at, 1 + random.index(40));
            break;
          case 2:
            text.insert(at, text.substr(random.index(text.size()), 20));
            break;
          default:
            text.resize(at);
            break;
        }
      }
      const auto file = folder / "mutant";
      std::ofstream(file, std::ios::binary) << text;
      try {
        read(file);
        ++accepted;
      } catch (const Error& e) {
        EXPECT_NE(std::string(e.what()).find("mutant"), std::string::npos) << name << ": " << e.what();
        ++refused;
      }
    }
  }
  EXPECT_GT(accepted, 50);
  EXPECT_GT(refused, 500);
}

TEST(CalibrationStress, RegistrationSurvivesAnyNumbers) {
  Noise random(2);
  for (int trial = 0; trial < 2000; ++trial) {
    const std::size_t count = 1 + random.index(12);
    std::vector<dvec3> h, d;
    for (std::size_t i = 0; i < count; ++i) {
      const auto wild = [&] {
        return random.normal() * std::pow(10.0, random.uniform(-30, 30)) * (random.index(5) ? 1 : 0);
      };
      h.emplace_back(wild(), wild(), wild()), d.emplace_back(wild(), wild(), wild());
      if (i > 0 && random.index(4) == 0) h.back() = h[random.index(i)];
      if (i > 0 && random.index(4) == 0) d.back() = h.back();
    }
    const RegistrationResult result = register_points(h, d);
    ASSERT_EQ(result.inliers.size() + result.outliers.size(), count);
    ASSERT_TRUE(is_finite(result.X_DH.p));
    ASSERT_NEAR(glm::length(result.X_DH.R), 1, 1e-9);
    for (const double c : result.covariance) ASSERT_TRUE(std::isfinite(c)) << trial;
  }
}

}  // namespace
}  // namespace typodont::calibration
