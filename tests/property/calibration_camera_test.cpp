// Tests of calibration of panel and mirror with a camera, with simulated pictures.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "calibration/bench_simulator.h"
#include "calibration/camera_solver.h"
#include "calibration/statistics.h"
#include "engine/base/error.h"

namespace typodont::calibration {
namespace {

struct Studio {
  CameraIntrinsics camera{1450, 1440, 955, 545, {-0.12, 0.08, 0.0006, -0.0004, -0.02}};
  RigGeometry truth;
  Panel drawn;
  std::vector<Sighting> sightings;

  explicit Studio(std::uint64_t seed, double pixel_sigma, double touch_sigma, int pictures = 14) {
    SimulationOptions options;
    options.seed = seed;
    BenchSimulator bench(options);
    truth = bench.truth();
    drawn = bench.drawings().rig.panel;
    Noise random(seed + 70);
    // A printed board below the panel. Its corners are touched with the stylus.
    std::vector<dvec3> board, touched;
    for (int i = 0; i < 24; ++i) {
      board.push_back(truth.panel.at(0.5, 0.5) +
                      dvec3(0.03 * (i % 6 - 2.5), -0.10 + 0.002 * (i / 6), 0.03 * (i / 6 - 1.5)));
      touched.push_back(board.back() + random.normal3(touch_sigma));
    }
    const dvec3 middle = truth.panel.at(0.5, 0.5);
    const dvec3 front = glm::normalize(
        glm::cross(truth.panel.lower_right - truth.panel.lower_left, truth.panel.upper_left - truth.panel.lower_left));
    for (int picture = 0; picture < pictures; ++picture) {
      const dvec3 from = middle + front * random.uniform(0.4, 0.55) + random.in_box(dvec3(-0.22), dvec3(0.22));
      const dvec3 aim = middle + random.in_box(dvec3(-0.05), dvec3(0.05)) + dvec3(0, -0.06, 0);
      const dvec3 z = glm::normalize(aim - from),
                  x = glm::normalize(glm::cross(z, dvec3(random.uniform(-0.3, 0.3), 1, random.uniform(-0.3, 0.3))));
      const Pose X_WK{from, glm::quat_cast(glm::dmat3(x, glm::cross(z, x), z))};
      const auto see = [&](Sighting s, const dvec3& p) {
        if ((inverse(X_WK) * p).z < 0.1) return;
        const Pixel pixel = project(camera, X_WK, p);
        s.picture = picture;
        s.px = pixel.x + random.normal(pixel_sigma), s.py = pixel.y + random.normal(pixel_sigma);
        if (s.px > 0 && s.py > 0 && s.px < 1919 && s.py < 1079) sightings.push_back(s);
      };
      for (int i = 0; i < 54; ++i) {
        const PanelPoint c{0.1 + 0.1 * (i % 9), 0.15 + 0.14 * (i / 9)};
        see({0, SeenOn::kPanel, c, {}, 0, 0}, truth.panel.at(c.u, c.v));
        see({0, SeenOn::kPanelInMirror, c, {}, 0, 0}, truth.appears(c.u, c.v, truth.eyes.center));
      }
      for (int i = 0; i < 24; ++i)
        see({0, SeenOn::kTouchedPoint, {}, touched[static_cast<std::size_t>(i)], 0, 0},
            board[static_cast<std::size_t>(i)]);
    }
  }
};

TEST(CameraLaws, ExactCornersRecoverPanelMirrorAndLens) {
  const Studio studio(1, 0, 0);
  const CameraResult result = solve_camera(studio.sightings, 1920, 1080, studio.drawn);
  ASSERT_EQ(result.not_determined, "");
  EXPECT_LT(glm::length(result.panel.lower_left - studio.truth.panel.lower_left), 1e-8);
  EXPECT_LT(glm::length(result.panel.upper_left - studio.truth.panel.upper_left), 1e-8);
  EXPECT_NEAR(result.camera.fx, studio.camera.fx, 1e-3);
  EXPECT_NEAR(result.camera.distortion[0], studio.camera.distortion[0], 1e-5);
  ASSERT_TRUE(result.mirror.has_value());
  EXPECT_NEAR(std::abs(glm::dot(result.mirror->normal, studio.truth.mirror->normal)), 1, 1e-12);
  EXPECT_LT(result.rms_px, 1e-5);
}

TEST(CameraLaws, ErrorsAgreeWithTheReportedUncertainty) {
  double squares = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Studio studio(seed, 0.1, 2e-4);
    const CameraResult result = solve_camera(studio.sightings, 1920, 1080, studio.drawn);
    ASSERT_EQ(result.not_determined, "") << seed;
    const dvec3 e = result.panel.at(0.5, 0.5) - studio.truth.panel.at(0.5, 0.5);
    for (int axis = 0; axis < 3; ++axis) squares += std::pow(e[axis] / result.centre_sigma[axis], 2), ++count;
    const double width = glm::length(studio.truth.panel.lower_right - studio.truth.panel.lower_left);
    squares += std::pow((result.width - width) / result.width_sigma, 2), ++count;
    squares += std::pow((result.camera.fx - studio.camera.fx) / result.camera_sigma.fx, 2), ++count;
    EXPECT_LT(result.centre_sigma.y, 2e-4);
    EXPECT_NEAR(result.rms_px, 0.1, 0.01);
  }
  EXPECT_NEAR(squares / count, 1, 3.5 * std::sqrt(2.0 / count));
}

TEST(CameraLaws, WrongCornersDoNotMoveThePanel) {
  Studio studio(2, 0.1, 2e-4);
  Noise random(9);
  for (std::size_t i = 0; i < studio.sightings.size(); i += 25) studio.sightings[i].px += random.uniform(5, 40);
  const CameraResult result = solve_camera(studio.sightings, 1920, 1080, studio.drawn);
  ASSERT_EQ(result.not_determined, "");
  EXPECT_LT(glm::length(result.panel.at(0.5, 0.5) - studio.truth.panel.at(0.5, 0.5)), 6e-4);
  EXPECT_GE(result.outliers, static_cast<int>(studio.sightings.size() / 25) - 2);
}

TEST(CameraLaws, MissingSightingsAreReported) {
  Studio studio(3, 0.1, 2e-4);
  std::vector<Sighting> untied = studio.sightings;
  std::erase_if(untied, [](const Sighting& s) { return s.on == SeenOn::kTouchedPoint; });
  EXPECT_NE(solve_camera(untied, 1920, 1080, studio.drawn).not_determined.find("touched"), std::string::npos);
  std::vector<Sighting> apart = studio.sightings;
  std::erase_if(apart, [](const Sighting& s) { return (s.on == SeenOn::kTouchedPoint) == (s.picture % 2 == 0); });
  EXPECT_NE(solve_camera(apart, 1920, 1080, studio.drawn).not_determined.find("together"), std::string::npos);
  std::erase_if(studio.sightings, [](const Sighting& s) { return s.on == SeenOn::kPanel; });
  EXPECT_THROW(solve_camera(studio.sightings, 1920, 1080, studio.drawn), Error);
}

#ifdef TYPODONT_CAMERA
// Writes a picture of the board as a pinhole camera takes it. Each pixel is the mean of 5×5 rays.
void render(const std::filesystem::path& file, const BoardPicture& board, const RigGeometry& rig, bool in_mirror,
            const CameraIntrinsics& camera, const Pose& X_WK) {
  const dvec3 corner = in_mirror ? rig.appears(0, 0, rig.eyes.center) : rig.panel.at(0, 0);
  const dvec3 u = (in_mirror ? rig.appears(1, 0, rig.eyes.center) : rig.panel.at(1, 0)) - corner,
              v = (in_mirror ? rig.appears(0, 1, rig.eyes.center) : rig.panel.at(0, 1)) - corner;
  const dvec3 n = glm::cross(u, v);
  std::string bytes = "P5\n640 480\n255\n";
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      double sum = 0;
      for (int k = 0; k < 25; ++k) {
        const dvec3 ray = X_WK.rotate(dvec3((x - 0.4 + 0.2 * (k % 5) - camera.cx) / camera.fx,
                                            (y - 0.4 + 0.2 * (k / 5) - camera.cy) / camera.fy, 1));
        const dvec3 hit = X_WK.p + ray * (glm::dot(n, corner - X_WK.p) / glm::dot(n, ray)) - corner;
        const double a = glm::dot(hit, u) / glm::dot(u, u), b = glm::dot(hit, v) / glm::dot(v, v);
        const int column = static_cast<int>(std::floor(a * board.width)),
                  row = static_cast<int>(std::floor((1 - b) * board.height));
        const bool inside = column >= 0 && row >= 0 && column < board.width && row < board.height;
        sum += inside ? board.grey[static_cast<std::size_t>(row) * static_cast<std::size_t>(board.width) +
                                   static_cast<std::size_t>(column)]
                      : 90;
      }
      bytes += static_cast<char>(static_cast<unsigned char>(20 + sum / 25 * 0.8));
    }
  }
  std::ofstream(file, std::ios::binary) << bytes;
}

TEST(BoardDetection, CornersAreFoundToATenthOfAPixelDirectUpsideDownAndInTheMirror) {
  const BoardPicture board = draw_board(9, 6, 1920, 1080);
  const RigGeometry rig = BenchSimulator({}).truth();
  const CameraIntrinsics camera{620, 620, 319.5, 239.5, {}};
  const auto file = std::filesystem::temp_directory_path() / ("board-" + std::to_string(getpid()) + ".pgm");
  for (const bool in_mirror : {false, true}) {
    for (const double roll : {0.1, 3.0}) {
      // The camera is in front of the panel or of its mirror image, and looks at its middle.
      const dvec3 middle = in_mirror ? rig.appears(0.5, 0.5, rig.eyes.center) : rig.panel.at(0.5, 0.5);
      dvec3 front = glm::normalize(
          glm::cross(rig.panel.lower_right - rig.panel.lower_left, rig.panel.upper_left - rig.panel.lower_left));
      if (in_mirror) front -= 2 * glm::dot(front, rig.mirror->normal) * rig.mirror->normal;
      const dvec3 from = middle + 0.45 * front + dvec3(0.08, 0.05, 0.02);
      const dvec3 z = glm::normalize(middle - from), x0 = glm::normalize(glm::cross(z, dvec3(0.1, 1, 0.2))),
                  y0 = glm::cross(z, x0);
      const dvec3 x = std::cos(roll) * x0 + std::sin(roll) * y0;
      const Pose X_WK{from, glm::quat_cast(glm::dmat3(x, glm::cross(z, x), z))};
      render(file, board, rig, in_mirror, camera, X_WK);
      const std::vector<Pixel> found = find_board(file, 9, 6, in_mirror);
      ASSERT_EQ(found.size(), board.corners.size()) << in_mirror << " " << roll;
      for (std::size_t i = 0; i < found.size(); ++i) {
        const PanelPoint& c = board.corners[i];
        const Pixel truth =
            project(camera, X_WK, in_mirror ? rig.appears(c.u, c.v, rig.eyes.center) : rig.panel.at(c.u, c.v));
        EXPECT_NEAR(found[i].x, truth.x, 0.1) << in_mirror << " " << roll << " corner " << i;
        EXPECT_NEAR(found[i].y, truth.y, 0.1) << in_mirror << " " << roll << " corner " << i;
      }
    }
  }
  std::filesystem::remove(file);
}
#endif

}  // namespace
}  // namespace typodont::calibration
