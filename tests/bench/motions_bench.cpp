// The servo's tick for every shipped tool and several motions of the hand, in a hole that the tool drilled.
#include <filesystem>

#include "engine/app/assets.h"
#include "tests/bench/haptic_scene.h"

namespace typodont::bench {

namespace {

constexpr std::string_view kBone = R"([{"tissue": "dentin", "solid": {"box": {"size_mm": [18, 18, 16]}}}])";
constexpr double kBoneTop = 8e-3;  // m

struct Motion {
  const char* name;
  double turn, way;  // largest angular speed in rad/s, largest speed in m/s
};
constexpr Motion kMotions[] = {{"holds still", 0, 0},
                               {"turns at 1 rad per s", 1, 0},
                               {"turns at 20 rad per s", 20, 0},
                               {"goes at 0.5 m per s", 0, 0.5},
                               {"turns at 20 rad per s and goes at 0.5 m per s", 20, 0.5}};

/// Pushes the tool straight down in 0.4 s; then turns it at 6 Hz about one axis and moves it at 15 Hz along another.
Pose hand(const haptics::Tool& tool, const Motion& motion, double t) {
  constexpr double kDown = 0.4, kTurn = 2 * kPi * 6, kAside = 2 * kPi * 15;
  const double sunk = std::min(tool.length + 2e-3, 8e-3) * std::min(t / kDown, 1.0);
  const double after = std::max(t - kDown, 0.0), turn = motion.turn / kTurn * std::sin(kTurn * after);
  const double aside = motion.way / kAside * std::sin(kAside * after);
  return {{aside, 0.3 * aside, kBoneTop + tool.half() + 0.1e-3 - sunk},
          glm::angleAxis(turn, glm::normalize(dvec3(0.8, 0.6, 0)))};
}

void run(benchmark::State& state, const std::filesystem::path& file, const Motion& motion) {
  haptics::ServoSettings settings;
  settings.tool = haptics::read_tool(Json::load(file));
  settings.spindle.free_speed = 300 * kKrpm;
  static const haptics::DenseTissue dense = tissue(kBone, 0.1);
  std::vector<double> times = least_of([&] {
    test::HapticBench scene = scene_of(haptics::TissueVolume(dense), settings);
    return servo_times(scene, 1, smoke() ? 500 : 1400,
                       [&](int i, const ServoTick&) { return hand(settings.tool, motion, settings.tick * i); });
  });
  times.erase(times.begin(), times.begin() + 400);
  set_times(state, times);
  require_time(quantile(times, 0.999) < 0.5e6, "a tick takes at most half of its period: " + file.stem().string());
}

}  // namespace

void add_cases() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(assets_folder() / "tools"))
    if (entry.path().extension() == ".json") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  if (smoke()) files.resize(3);
  for (const auto& file : files)
    for (const Motion& motion : kMotions)
      add(fmt::format("{}/{}", motion.name, file.stem().string()),
          [=](benchmark::State& state) { run(state, file, motion); });
}

}  // namespace typodont::bench
