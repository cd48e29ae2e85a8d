// Simulates a session of eight hours: tissue is drilled, filled again and probed, with a recording and with undo data
// for every stroke. Measures the quantities that must not grow with the session's duration: memory, the cost of a tick,
// open files, threads, and bytes per tick.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "engine/app/bench/parts.h"
#include "engine/app/haptic_loop.h"
#include "engine/app/recording/resume.h"
#include "engine/base/log.h"
#include "engine/base/measure.h"
#include "engine/base/units.h"
#include "engine/session/recorder.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;
using namespace literals;

constexpr std::string_view kScene = R"({
  "tissue": {"voxel_mm": 0.1, "solids": [
    {"tissue": "dentin", "solid": {"box": {"center_mm": [0, 0, -3], "size_mm": [12, 12, 6]}}},
    {"tissue": "enamel", "solid": {"box": {"center_mm": [0, 0, -0.5], "size_mm": [12, 12, 1]}}}]},
  "tools": ["round_012", "condenser_composite", "explorer"], "spindle_krpm": 300, "parts": ["haptics"]})";
constexpr double kRate = 1000, kCycle = 60;  // kRate: Hz, rate of the servo; kCycle: s, duration of a work cycle

/// Returns the hand's pose at the time `t`. In each cycle of one minute the hand drills a pit, fills the pit, probes
/// it, and rests. Then it moves to the next of 25 positions, so it returns to each position after 25 minutes.
haptics::HandSample hand_at(double t) {
  const double in_cycle = std::fmod(t, kCycle);
  const auto cycle = static_cast<int>(t / kCycle);
  const dvec3 place(2.0_mm * (cycle % 5 - 2), 2.0_mm * (cycle / 5 % 5 - 2), 0);
  constexpr double kAway = 4e-3;
  const auto way = [](double from, double to, double fraction) {
    return from + (to - from) * std::clamp(fraction, 0.0, 1.0);
  };
  const auto visit = [&](double begin, double end, double high,
                         double low) {  // the height first moves from `high` to `low`, and at the end up again
    const double down = way(way(kAway, high, in_cycle - begin), low, (in_cycle - begin - 1) / (end - begin - 2));
    return way(down, kAway, in_cycle - (end - 1));
  };
  haptics::HandSample hand;
  hand.t = from_seconds(t);
  double z = kAway;
  if (in_cycle < 8) {
    hand.tool = 0, hand.pedal = in_cycle > 1 && in_cycle < 7;
    z = visit(0, 8, 0.7_mm, -0.6_mm);
  } else if (in_cycle < 12) {
    hand.tool = 1, hand.pedal = in_cycle > 9 && in_cycle < 11;
    // Fills the pit. The tip of the instrument lies 1.5 mm below the origin of the instrument's frame. So the origin is
    // held 1.5 mm above the surface; then the tip is at the surface.
    z = visit(8, 12, 1.5_mm, 1.6_mm);
  } else {
    hand.tool = 2;
    z = visit(12, 18, 0.2_mm, 0.0_mm);
  }
  hand.X_WT.p = place + dvec3(0.4_mm * std::cos(3 * t), 0.4_mm * std::sin(3 * t), z);
  return hand;
}

double resident_megabytes() {
  std::ifstream in("/proc/self/statm");
  double size = 0, resident = 0;
  in >> size >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / 1e6;
}

double entries(const char* folder) {
  return static_cast<double>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

}  // namespace

std::vector<BenchRow> bench_length(const BenchRun& run) {
  const double unit = run.quick ? 60 : 3600;  // s, unit of time; a row is added after 1, 2, 4 and 8 units
  constexpr int kLast = 8;
  const fs::path file = fs::temp_directory_path() / fmt::format("typodont_length_{}.h5", ::getpid());
  const Scene scene = parse_scene(Json::parse(kScene, "bench"), {});
  HapticLoop loop(scene, load_tissue(scene), kRate);
  session::SessionHeader header;
  header.scene_json = kScene;
  session::SessionWriter writer(file, header, {});

  std::vector<BenchRow> rows;
  EvenSample ticks, whole;
  ServoTick tick;
  Cut cut;
  std::uint64_t count = 0, recorded = 0;
  double recording = 0;  // ns, time spent on recording since the last row
  for (int mark = 1; mark <= kLast; ++mark) {
    for (const auto end = static_cast<std::uint64_t>(mark * unit * kRate); count < end; ++count) {
      const haptics::HandSample hand = hand_at(static_cast<double>(count) / kRate);
      const Nanos start = thread_cpu_time();
      const bool did_cut = loop.tick(hand, tick, cut);
      whole.add(static_cast<double>(thread_cpu_time() - start));
      ticks.add(static_cast<double>(tick.cpu_time));
      const Nanos ticked = thread_cpu_time();
      if (loop.fresh_patch()) writer.append({loop.fresh_patch(), 1});
      if (did_cut) writer.append({&cut, 1});
      writer.append({&tick, 1});
      if (count % 1000 == 0) writer.flush();  // writes once per second, so a crash loses at most one second of data
      recording += static_cast<double>(thread_cpu_time() - ticked);
      (void)loop.carver().take_pieces();
    }
    // adds rows to the table only after 1, 2, 4, 8, … units of time (minutes or hours)
    if ((mark & (mark - 1)) != 0) continue;
    writer.flush();
    const std::string knob = fmt::format("after {} {}{}", mark, run.quick ? "minute" : "hour", mark > 1 ? "s" : "");
    const auto row = [&](std::string name, double error, const char* error_unit, double time = BenchRow::kNone) {
      rows.push_back({.name = std::move(name),
                      .knob = knob,
                      .error = error,
                      .error_unit = error_unit,
                      .time_ns = time,
                      .per = std::isfinite(time) ? "tick" : "",
                      .size = mark * unit / 3600,
                      .size_unit = "hours of session"});
    };
    const std::size_t first = rows.size();
    const auto strokes = loop.carver().volume().strokes();
    row("servo, 99 %", BenchRow::kNone, "", ticks.quantile(0.99));
    row("servo and carver, 99 %", BenchRow::kNone, "", whole.quantile(0.99));
    row("recorder, mean", BenchRow::kNone, "", recording / static_cast<double>(count - recorded));
    row("memory of the process", resident_megabytes(), "MB");
    row("kept for undo", static_cast<double>(strokes.bytes) / 1e6, "MB");
    row("strokes that can be undone", static_cast<double>(strokes.done), "strokes");
    row("cuts and fillings made", static_cast<double>(loop.carver().cuts()), "cuts");
    row("recording", static_cast<double>(fs::file_size(file)) / static_cast<double>(count), "bytes a tick");
    row("open files", entries("/proc/self/fd"), "files");
    row("threads", entries("/proc/self/task"), "threads");
    // prints the rows now, because the next rows are measured hours later
    for (std::size_t i = first; i < rows.size(); ++i) {
      const BenchRow& r = rows[i];
      log::info("{}, {}: {}", r.name, knob,
                std::isfinite(r.time_ns) ? fmt::format("{:.3g} us", r.time_ns * 1e-3)
                                         : fmt::format("{:.6g} {}", r.error, r.error_unit));
    }
    ticks = whole = EvenSample();
    recording = 0, recorded = count;
  }
  writer.finish({});
  fs::remove(file);
  return rows;
}

}  // namespace typodont
