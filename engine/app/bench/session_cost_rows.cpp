#include "engine/app/bench/session_cost_rows.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string>

#include "engine/base/clock.h"
#include "engine/base/error.h"
#include "engine/base/json.h"
#include "engine/base/measure.h"
#include "engine/base/temporary_folder.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;

constexpr double kRate = 1000;  // Hz, rate of the servo

/// Times that were used while a function ran.
struct Used {
  double cpu = 0;   // s, of child processes
  double wall = 0;  // s
};

template <class Work>
Used measure_used(Work&& work) {
  const double cpu = cpu_seconds(RUSAGE_CHILDREN);
  const Nanos start = now();
  work();
  return {cpu_seconds(RUSAGE_CHILDREN) - cpu, to_seconds(now() - start)};
}

/// Writes two motions of a hand to files. `rest`: the hand rests above a block of tissue. `drill`: the hand presses a
/// bur into this block and moves it to and fro for `seconds`.
void write_hands(const fs::path& rest, const fs::path& drill, double seconds) {
  std::ofstream(rest) << fmt::format("t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,6,1,0,0,0,0\n{},0,0,6,1,0,0,0,0\n",
                                     seconds);
  std::ofstream out(drill);
  out << "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n";
  // kStep: s, time between two lines of the file; kSink: mm/s, downward speed of the hand
  constexpr double kStep = 0.02, kSink = 0.05;
  for (double t = 0; t <= seconds; t += kStep) {
    out << fmt::format("{:.3f},{:.4f},0,{:.4f},1,0,0,0,1\n", t, 1.5 * std::sin(t), 2.55 - kSink * t);
  }
}

}  // namespace

void session_cost_rows(bool quick, std::vector<BenchRow>& rows) {
  // Measures a long session and a short session, and subtracts the results of the short one. So the rows do not include
  // the start and the end of the program.
  const double brief = 2, lasting = quick ? 4 : 22;  // s
  const TemporaryFolder folder;
  const fs::path scene = folder.path() / "scene.json", rest = folder.path() / "rest.csv",
                 drill = folder.path() / "drill.csv";
  std::ofstream(scene)
      << R"({"tissue": {"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [6, 6, 4]}}}]},
    "tool": "round_012", "spindle": "air_turbine", "parts": ["haptics"]})";
  write_hands(rest, drill, lasting + 1);
  const fs::path said = folder.path() / "said.json";
  const std::string program = fs::read_symlink("/proc/self/exe").string();
  const auto session = [&](const fs::path& hand, double seconds) {
    bool ran = false;
    const Used used = measure_used([&] {
      ran =
          std::system(fmt::format("'{}' run '{}' --hand script:{} --audio none: --seconds {} --json >'{}' 2>/dev/null",
                                  program, scene.string(), hand.string(), seconds, said.string())
                          .c_str()) == 0;
    });
    if (!ran) throw RunFailure("a session of the bench failed: " + scene.string());
    return used;
  };
  constexpr const char* kKnob = "block of 0.1 mm voxels, 1 kHz, no picture";
  for (const auto& [name, hand] : {std::pair{"at rest", rest}, {"drilling, round 1.2 mm", drill}}) {
    const Used from = session(hand, brief), to = session(hand, lasting);
    const double cpu = to.cpu - from.cpu, wall = to.wall - from.wall;
    rows.push_back({.name = fmt::format("core-seconds, a session {}", name),
                    .knob = kKnob,
                    .error = 60 * cpu / wall,
                    .error_unit = "core-seconds per minute",
                    .time_ns = 1e9 * cpu / (kRate * wall),
                    .per = "tick",
                    .baseline = "one core",
                    .ratio = cpu / wall,
                    .size = Json::load(said)["removed_mm3"].number(),
                    .size_unit = "mm³ removed"});
  }
}

}  // namespace typodont
