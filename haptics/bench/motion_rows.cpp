// Measures the time of a servo tick for every tool of the program and for several motions of the hand.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <vector>

#include "engine/base/units.h"
#include "haptics/bench.h"
#include "haptics/bench/rows.h"
#include "haptics/bench/timing.h"

namespace typodont::haptics {

namespace bench {

namespace {

constexpr std::string_view kBone = R"([{"tissue": "dentin", "solid": {"box": {"size_mm": [18, 18, 16]}}}])";
constexpr double kBoneTop = 8e-3;  // m, height of the block's top

/// A motion of a hand that oscillates while its tool is in a hole. `turn` is its largest angular speed and `way` its
/// largest linear speed.
struct Motion {
  const char* name;
  double turn, way;  // largest angular speed in rad/s, largest linear speed in m/s
};
constexpr Motion kMotions[] = {{"holds still", 0, 0},
                               {"turns at 1 rad/s", 1, 0},
                               {"turns at 20 rad/s", 20, 0},
                               {"goes at 0.5 m/s", 0, 0.5},
                               {"turns at 20 rad/s and goes at 0.5 m/s", 20, 0.5}};

/// A hand that first pushes the tool straight down and then oscillates. It rotates the tool about one axis
/// perpendicular to the shank, and moves the tool along another axis.
class MovingHand {
 public:
  MovingHand(const Tool& tool, const Motion& motion)
      : motion_(motion), from_(kBoneTop + tool.half() + 0.1e-3), down_(std::min(tool.length + 2e-3, 8e-3)) {}
  static constexpr double kDown = 0.4;  // s, duration of the push down at the start
  Pose next(double dt) {
    constexpr double kSwing = 6, kAside = 15;  // Hz, frequencies of the rotation and of the sideways motion
    t_ += dt;
    const double sunk = down_ * std::min(t_ / kDown, 1.0), t = std::max(t_ - kDown, 0.0);
    const double turn = motion_.turn / (2 * kPi * kSwing) * std::sin(2 * kPi * kSwing * t);
    const double aside = motion_.way / (2 * kPi * kAside) * std::sin(2 * kPi * kAside * t);
    return {{aside, 0.3 * aside, from_ - sunk}, glm::angleAxis(turn, glm::normalize(dvec3(0.8, 0.6, 0)))};
  }

 private:
  Motion motion_;
  double from_, down_;
  double t_ = 0;
};

}  // namespace

}  // namespace bench

std::vector<BenchRow> bench_motions(const MotionBenchOptions& options) {
  using namespace bench;
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(options.tools)) {
    const std::string name = entry.path().stem().string();
    const bool wanted =
        options.names.empty() || std::find(options.names.begin(), options.names.end(), name) != options.names.end();
    if (wanted && entry.path().extension() == ".json") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  const DenseTissue dense = tissue(kBone, options.voxel_mm);
  std::vector<BenchRow> rows;
  for (const std::filesystem::path& file : files) {
    ServoSettings settings;
    settings.tool = read_tool(Json::load(file));
    settings.spindle.free_speed = 300e3 / 60 * 2 * kPi;
    for (const Motion& motion : kMotions) {
      const std::vector<double> ticks = least_of([&] {
        Scene scene(dense, settings);
        MovingHand hand(settings.tool, motion);
        std::vector<double> run;
        const int sinking = static_cast<int>(MovingHand::kDown / settings.tick);
        for (int i = 0; i < sinking + options.ticks; ++i) {
          const double time = scene.tick(hand.next(settings.tick), 1);
          if (i >= sinking) run.push_back(time);
        }
        return run;
      });
      const std::string knob = fmt::format("{}, voxel {:g} mm", file.stem().string(), options.voxel_mm);
      for (const auto& [which, fraction] : {std::pair{"median", 0.5}, {"99 %", 0.99}, {"99.9 %", 0.999}}) {
        rows.push_back({fmt::format("a hand that {}, {}", motion.name, which), knob, BenchRow::kNone, "",
                        quantile(ticks, fraction), "tick"});
      }
    }
  }
  return rows;
}

}  // namespace typodont::haptics
