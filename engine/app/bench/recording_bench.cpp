// Measures the cost of recording: processor time and bytes per tick, for each compression level.
#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "engine/app/bench/parts.h"
#include "engine/app/haptic_loop.h"
#include "engine/app/recording/resume.h"
#include "engine/base/units.h"
#include "engine/session/recorder.h"

namespace typodont {

namespace {

constexpr std::string_view kScene = R"({
  "tissue": {"voxel_mm": 0.2, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [10, 10, 4]}}}]},
  "tool": "round_012", "spindle_krpm": 300, "parts": ["haptics"]})";

struct Drilling {
  std::vector<ServoTick> ticks;
  std::vector<Cut> cuts;
};

/// Simulates a hand that drills in circles with a tremor (tenths of a millimetre, 8 to 11 Hz).
Drilling drill(int ticks) {
  const Scene scene = parse_scene(Json::parse(kScene, "bench"), {});
  HapticLoop loop(scene, load_tissue(scene), 1000);
  Drilling done;
  haptics::HandSample hand;
  for (int i = 0; i < ticks; ++i) {
    const double t = 1e-3 * i;
    hand.t = from_seconds(t);
    hand.X_WT.p = dvec3(3e-3 * std::sin(0.4 * t) + 1e-4 * std::sin(2 * kPi * 8.3 * t),
                        3e-3 * std::cos(0.53 * t) + 1e-4 * std::sin(2 * kPi * 9.7 * t),
                        2.4e-3 + 1e-4 * std::sin(2 * kPi * 11 * t));
    hand.pedal = 1;
    ServoTick tick;
    Cut cut;
    if (loop.tick(hand, tick, cut)) done.cuts.push_back(cut);
    done.ticks.push_back(tick);
  }
  return done;
}

}  // namespace

std::vector<BenchRow> bench_recording(const BenchRun& run) {
  const Drilling done = drill(run.quick ? 5'000 : 60'000);
  const auto file = std::filesystem::temp_directory_path() / fmt::format("typodont_bench_{}.h5", now());
  const auto count = static_cast<double>(done.ticks.size());
  const double plain = sizeof(ServoTick) + sizeof(Cut) * static_cast<double>(done.cuts.size()) / count;
  std::vector<BenchRow> rows;
  for (const int deflate : {1, 3, 6, 9}) {
    session::WriterOptions options;
    options.deflate = deflate;
    session::SessionHeader header;
    header.scene_json = kScene;
    header.tools = {"round_012"};
    const Nanos start = thread_cpu_time();
    {
      session::SessionWriter writer(file, header, options);
      // Number of ticks that are appended together. The recorder also appends many ticks together, twice per second.
      constexpr std::size_t kPiece = 500;
      std::size_t cut = 0;
      for (std::size_t i = 0; i < done.ticks.size(); i += kPiece) {
        const std::size_t n = std::min(kPiece, done.ticks.size() - i), first = cut;
        while (cut < done.cuts.size() && done.cuts[cut].t <= done.ticks[i + n - 1].t) ++cut;
        writer.append(std::span(done.cuts).subspan(first, cut - first));
        writer.append(std::span(done.ticks).subspan(i, n));
        writer.flush();
      }
      writer.finish({});
    }
    const double time = static_cast<double>(thread_cpu_time() - start) / count;
    const double bytes = static_cast<double>(std::filesystem::file_size(file)) / count;
    std::filesystem::remove(file);
    rows.push_back({.name = "tick with its cut",
                    .knob = fmt::format("deflate {}, {:.0f} bytes", deflate, bytes),
                    .error = bytes / plain,
                    .error_unit = "of its size in memory",
                    .time_ns = time,
                    .per = "tick",
                    .baseline = "the millisecond it lasts",
                    .ratio = time / 1e6});
  }
  return rows;
}

}  // namespace typodont
