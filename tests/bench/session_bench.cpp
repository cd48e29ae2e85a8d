// What a session costs beside its ticks: recording, undo, and bodies of growing size.
#include <malloc.h>

#include <filesystem>
#include <memory>

#include "engine/app/assets.h"
#include "engine/app/picture/tissue_view.h"
#include "engine/app/recording/resume.h"
#include "engine/app/stepped.h"
#include "engine/app/task/warnings.h"
#include "engine/base/json.h"
#include "engine/base/temporary_folder.h"
#include "engine/base/units.h"
#include "engine/session/recorder.h"
#include "tests/bench/bench.h"

namespace typodont::bench {

namespace {

namespace fs = std::filesystem;
constexpr std::string_view kScene = R"({
  "tissue": {"voxel_mm": 0.2, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [10, 10, 4]}}}]},
  "tool": "round_012", "spindle_krpm": 300, "parts": ["haptics"]})";

/// Records a hand that drills in circles and trembles. Time and bytes are those of a tick with its cut.
void record(benchmark::State& state, int deflate) {
  const Scene scene = parse_scene(Json::parse(kScene, "bench"), {});
  SteppedSession session(scene, load_tissue(scene), 1000);
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "s.h5";
  session::SessionHeader header;
  header.scene_json = kScene;
  header.tools = {"round_012"};
  session::WriterOptions options;
  options.deflate = deflate;
  const int count = smoke() ? 2000 : 60'000;
  double ns = 0;
  {
    session::SessionWriter writer(file, header, options);
    std::vector<ServoTick> ticks;
    std::vector<Cut> cuts;
    const auto timed = [&](auto&& work) {
      const Nanos start = thread_cpu_time();
      work();
      ns += static_cast<double>(thread_cpu_time() - start) / count;
    };
    for (int i = 0; i < count; ++i) {
      const double t = 1e-3 * i;
      haptics::HandSample hand;
      hand.t = from_seconds(t), hand.pedal = 1;
      hand.X_WT.p = dvec3(3e-3 * std::sin(0.4 * t) + 1e-4 * std::sin(2 * kPi * 8.3 * t),
                          3e-3 * std::cos(0.53 * t) + 1e-4 * std::sin(2 * kPi * 9.7 * t),
                          2.4e-3 + 1e-4 * std::sin(2 * kPi * 11 * t));
      ticks.push_back(session.tick(hand));
      if (session.cut()) cuts.push_back(*session.cut());
      if (ticks.size() < 500) continue;  // the recorder, too, writes twice per second
      timed([&] {
        writer.append(cuts);
        writer.append(ticks);
        writer.flush();
      });
      ticks.clear(), cuts.clear();
    }
    timed([&] { writer.finish({}); });
  }
  set_time(state, ns);
  state.counters["bytes"] = static_cast<double>(fs::file_size(file)) / count;
}

/// Warnings of a second of session at 1 kHz. The bur is deep in the tooth, just too far from pulp and neighbour for a
/// warning, where a query takes most time.
void warn(benchmark::State& state) {
  const Scene scene = read_scene("class-2-cavity");
  session::WarningLevels levels;
  for (const WarningRule& rule : warning_rules(scene)) levels[rule.item] = 0;
  WarningMeter meter(scene, load_tissue(scene), levels);
  const SurroundingsShape around(*scene.surroundings);
  const double radius = haptics::tool_set(scene.servo)[1].radius();
  double slowest = 0;
  for (double x = 0; x < 14; x += smoke() ? 7 : 0.5)
    for (double z = 14; z < 20; z += smoke() ? 3 : 0.5) {
      ServoTick tick;
      tick.tool = 1;
      tick.X_WG.p = dvec3(x, 6, z) * kMillimetre;
      tick.spindle = 300 * kKrpm;
      tick.contact_area = 1e-8;
      if (around.neighbour(tick.X_WG.p) < radius) continue;
      slowest = std::max(slowest, batch_ns(5, smoke() ? 1 : 20, [&](int) {
                           for (int i = 0; i < 1000; ++i) meter.add(tick);
                           for (int i = 0; i < 10; ++i) meter.evaluate(tick, 0);
                         }));
    }
  set_time(state, slowest);
  require_time(slowest < 1e7, "the warnings take at most 1 % of a core");
}

/// A stroke of 16 passes through the block: preparing its undo in the pause after it, undo and redo.
void undo(benchmark::State& state, const std::string& tool) {
  const Scene scene = parse_scene(Json::parse(fmt::format(R"({{"tissue": {{"voxel_mm": {}, "solids": [
          {{"tissue": "dentin", "solid": {{"box": {{"center_mm": [0, 0, -3.5], "size_mm": [12, 10, 3]}}}}}},
          {{"tissue": "enamel", "solid": {{"box": {{"center_mm": [0, 0, -1], "size_mm": [12, 10, 2]}}}}}}]}},
          "tool": "{}", "parts": ["haptics"]}})",
                                                          smoke() ? 0.2 : 0.05, tool),
                                              "bench"),
                                  {});
  haptics::Carver carver(load_tissue(scene), haptics::tool_set(scene.servo));
  std::vector<double> prepared, undone, redone;
  Nanos t = 0;
  for (int repeat = 0; repeat < (smoke() ? 1 : 5); ++repeat) {
    t += kNanosPerSecond;
    for (int pass = 0; pass < 16; ++pass)
      for (double x = -6e-3; x < 6e-3; x += 0.1e-3) {
        Cut cut;
        cut.index = carver.cuts() + 1, cut.t = t += 1'000'000;
        cut.X_WA.p = {x, 0.4 * scene.servo.tool.diameter * (pass - 8), -0.1e-3 * repeat};
        cut.X_WB.p = cut.X_WA.p + dvec3(0.1e-3, 0, 0);
        carver.apply(cut);
      }
    const auto timed = [&](std::vector<double>& times, auto&& work) {
      const Nanos start = thread_cpu_time();
      work();
      times.push_back(static_cast<double>(thread_cpu_time() - start));
    };
    timed(prepared, [&] { carver.rest(t + kNanosPerSecond); });
    timed(undone, [&] { carver.undo(); });
    timed(redone, [&] { carver.redo(); });
    state.counters["kept_kB"] = static_cast<double>(carver.volume().strokes().bytes) / 1024;
    carver.undo();  // the next stroke cuts the same tissue
  }
  set_time(state, quantile(undone, 0.5));
  state.counters["prepare_ns"] = quantile(prepared, 0.5);
  state.counters["redo_ns"] = quantile(redone, 0.5);
}

double allocated_bytes() {
  const auto info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd);
}

struct Body {
  const char* name;
  std::string solids;
  double voxel_mm;
  dvec3 top;  // m, where the drill enters
  double surface_mm2;
};

Body ball(const char* name, double radius_mm) {
  return {name,
          fmt::format(R"([{{"tissue": "dentin", "solid": {{"sphere": {{"radius_mm": {}}}}}}}])", radius_mm),
          0.1,
          {0, 0, radius_mm * 1e-3},
          4 * kPi * radius_mm * radius_mm};
}
Body hip() {
  return {"hip",
          R"([{"tissue": "cortical_bone", "solid": {"difference": [{"sphere": {"radius_mm": 33}},
              {"sphere": {"radius_mm": 26}}]}}, {"tissue": "cortical_bone", "solid": {"sphere": {"radius_mm": 24}}},
              {"tissue": "cancellous_bone", "solid": {"sphere": {"radius_mm": 21.5}}}])",
          0.1,
          {0, 0, 33e-3},
          4 * kPi * (33. * 33 + 26. * 26 + 24. * 24)};
}

/// Drills a body. The times of servo, carver and changed mesh must not depend on its size; memory follows its surface.
void size(benchmark::State& state, const Body& body) {
  const Scene scene = parse_scene(
      Json::parse(fmt::format(R"({{"tissue": {{"voxel_mm": {}, "band_mm": 1, "solids": {}}}, "tool": "round_012",
                                   "spindle_krpm": 300, "parts": ["haptics"]}})",
                              body.voxel_mm, body.solids),
                  "bench"),
      {});
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "body.vdb";
  load_tissue(scene).save(file);
  const double before = allocated_bytes();
  haptics::TissueVolume tissue = haptics::TissueVolume::load(file);
  state.counters["bytes_per_voxel2"] =
      (allocated_bytes() - before) / (body.surface_mm2 / (body.voxel_mm * body.voxel_mm));
  TissueView view;
  state.counters["whole_mesh_ns"] = measure(1, [&] { (void)view.update(tissue); }).median;
  SteppedSession session(scene, std::move(tissue), 1000);
  std::vector<double> servo, carver, frames;
  for (int i = 0; i < (smoke() ? 100 : 1500); ++i) {
    haptics::HandSample hand;
    hand.t = from_seconds(1e-3 * i), hand.pedal = 1;
    hand.X_WT.p = body.top + dvec3(1e-3 * std::sin(6e-3 * i), 0, 0.6e-3 - std::min(0.3e-6 * i, 0.3e-3));
    const Nanos start = thread_cpu_time();
    const ServoTick& tick = session.tick(hand);
    servo.push_back(static_cast<double>(tick.cpu_time));
    carver.push_back(static_cast<double>(thread_cpu_time() - start - tick.cpu_time));
    if (i % 16 == 0) frames.push_back(measure(1, [&] { (void)view.update(session.carver().volume()); }).median);
  }
  set_times(state, servo);
  state.counters["carver_ns"] = quantile(carver, 0.5);
  state.counters["changed_mesh_ns"] = quantile(frames, 0.5);
}

}  // namespace

void add_cases() {
  for (const int deflate : {1, 3, 6, 9})
    add(fmt::format("record a tick with its cut/deflate {}", deflate),
        [=](benchmark::State& state) { record(state, deflate); });
  for (const char* const tool : {"round_012", "cylinder_012", "flame_018", "round_040"})
    add(fmt::format("undo a stroke of 16 passes, voxel 0.05 mm/{}", tool),
        [=](benchmark::State& state) { undo(state, tool); });
  add("warnings of a second", warn);
  std::vector<Body> bodies{ball("ball of 6 mm", 3), ball("ball of 12 mm", 6)};
  if (!smoke()) bodies.insert(bodies.end(), {ball("ball of 24 mm", 12), ball("ball of 36 mm", 18), hip()});
  for (const Body& body : bodies)
    add(fmt::format("drill/{}", body.name), [=](benchmark::State& state) { size(state, body); });
}

}  // namespace typodont::bench
