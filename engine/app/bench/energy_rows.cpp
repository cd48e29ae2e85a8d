#include "engine/app/bench/energy_rows.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string>
#include <system_error>
#include <thread>

#include "engine/base/clock.h"
#include "engine/base/error.h"
#include "engine/base/json.h"
#include "engine/base/measure.h"
#include "engine/base/temporary_folder.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;

constexpr const char* kPowercap = "/sys/class/powercap";
constexpr double kMicrojoule = 1e-6;  // J
constexpr double kRate = 1000;        // Hz, rate of the servo

/// Reads a number from a file of sysfs. No value: the file does not exist, or this user may not read it.
std::optional<double> number_in(const fs::path& file) {
  std::ifstream in(file);
  double number = 0;
  if (!(in >> number)) return std::nullopt;
  return number;
}

/// CPU time, wall-clock time and energy that were used while a function ran.
struct Used {
  double cpu = 0;     // s
  double wall = 0;    // s
  double energy = 0;  // J, energy of the whole machine; NaN if the machine has no counters
};

template <class Work>
Used measure_used(Work&& work) {
  const auto before = read_package_energy(kPowercap);
  const double cpu = cpu_seconds(RUSAGE_CHILDREN);
  const Nanos start = now();
  work();
  Used used{cpu_seconds(RUSAGE_CHILDREN) - cpu, to_seconds(now() - start), std::nan("")};
  const auto after = read_package_energy(kPowercap);
  if (before && after) used.energy = energy_between(*before, *after);
  return used;
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

std::optional<PackageEnergy> read_package_energy(const fs::path& powercap) {
  std::error_code none;
  std::optional<PackageEnergy> sum;
  for (const auto& zone : fs::directory_iterator(powercap, none)) {
    // Selects the counters of whole processor packages, whose names have one colon (intel-rapl:0). Counters whose names
    // have two colons belong to parts of a package. They are not added, because the package's counter includes their
    // energy.
    const std::string name = zone.path().filename().string();
    if (!name.starts_with("intel-rapl:") || name.find(':') != name.rfind(':')) continue;
    const auto counted = number_in(zone.path() / "energy_uj"), range = number_in(zone.path() / "max_energy_range_uj");
    if (!counted || !range) return std::nullopt;
    if (!sum) sum.emplace();
    sum->counted += kMicrojoule * *counted;
    sum->range += kMicrojoule * *range;
  }
  return sum;
}

double energy_between(const PackageEnergy& before, const PackageEnergy& after) {
  const double energy = after.counted - before.counted;
  return energy < 0 ? energy + after.range : energy;
}

void energy_rows(bool quick, std::vector<BenchRow>& rows) {
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
  const auto watts = [&](const char* name, double power) {
    if (std::isfinite(power)) rows.push_back({.name = name, .knob = kKnob, .error = power, .error_unit = "W, package"});
  };
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
    watts(fmt::format("power, a session {}", name).c_str(), (to.energy - from.energy) / wall);
  }
  const Used idle = measure_used([&] { std::this_thread::sleep_for(std::chrono::duration<double>(lasting - brief)); });
  watts("power, the machine without a session", idle.energy / idle.wall);
}

}  // namespace typodont
