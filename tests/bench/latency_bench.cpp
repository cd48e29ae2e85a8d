// Latency of the whole program in wall-clock time: from a touch to its sound, from the hand to the picture, and from
// the command to the first tick and picture. Also the processor time of a live session.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <span>

#include "audio/sound_file.h"
#include "engine/app/assets.h"
#include "engine/app/picture/picture_stage.h"
#include "engine/app/picture/tissue_view.h"
#include "engine/app/picture/world.h"
#include "engine/app/recording/resume.h"
#include "engine/base/error.h"
#include "engine/base/json.h"
#include "engine/base/temporary_folder.h"
#include "engine/base/units.h"
#include "engine/session/session_file.h"
#include "tests/bench/bench.h"

namespace typodont::bench {

namespace {

namespace fs = std::filesystem;
using namespace literals;

/// A folder with two scenes and the motions of three hands: one moves quickly onto a block, one rests, one drills.
struct Folder {
  TemporaryFolder temporary;
  std::string operator/(const char* name) const { return (temporary.path() / name).string(); }
  Folder() {
    constexpr const char* kColumns = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n";
    std::ofstream(*this / "touch.csv") << kColumns
                                       << "0,0,0,2.8,1,0,0,0,0\n0.4,0,0,2.8,1,0,0,0,0\n0.42,0,0,1.8,1,0,0,0,0\n"
                                          "0.8,0,0,1.8,1,0,0,0,0\n";
    std::ofstream(*this / "rest.csv") << kColumns << "0,0,0,30,1,0,0,0,0\n30,0,0,30,1,0,0,0,0\n";
    std::ofstream drill(*this / "drill.csv");
    drill << kColumns;
    for (double t = 0; t <= 30; t += 0.02)
      drill << fmt::format("{:.3f},{:.4f},0,{:.4f},1,0,0,0,1\n", t, 1.5 * std::sin(t), 2.55 - 0.05 * t);
    std::ofstream(*this / "block.json")
        << R"({"tissue": {"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [8, 8, 4]}}}]},
        "tool": "round_012", "spindle": "air_turbine", "parts": ["haptics", "record"]})";
    std::ofstream(*this / "enamel.json")
        << R"({"tissue": {"voxel_mm": 0.2, "solids": [{"tissue": "enamel", "solid": {"box": {"size_mm": [8, 8, 4]}}}]},
        "tool": "explorer", "parts": ["haptics", "sound", "record"]})";
  }
};

/// Runs the program. Returns its wall time, s.
double run(const std::string& arguments, const std::string& out = "/dev/null") {
  const Nanos start = now();
  if (std::system(fmt::format("'{}' {} >'{}' 2>/dev/null", TYPODONT_PROGRAM, arguments, out).c_str()) != 0)
    throw RunFailure("the program failed: " + arguments);
  return to_seconds(now() - start);
}

/// From the touch of an explorer, which moves onto a block at 50 mm/s, to its sound in a file.
void touch(benchmark::State& state) {
  const Folder folder;
  run(fmt::format("run '{}' --hand 'script:{}' --audio 'wav:{}' --record '{}'", folder / "enamel.json",
                  folder / "touch.csv", folder / "s.wav", folder / "s.h5"));
  const session::SessionReader reader(folder / "s.h5");
  const std::vector<ServoTick> ticks = reader.ticks();
  const auto touched = std::ranges::find_if(ticks, [](const ServoTick& tick) { return tick.depth > 0; });
  require(touched != ticks.end(), "the explorer touches the block");
  if (touched == ticks.end()) return;
  const audio::Recording recording = audio::read_recording(folder / "s.wav");
  const std::vector<double> samples = recording.mono();
  auto i = static_cast<std::size_t>(to_seconds(touched->t) * recording.rate);
  while (i < samples.size() && std::abs(samples[i]) < 2e-3) ++i;
  require(i < samples.size(), "the touch is heard");
  set_time(state, 1e9 * std::max(static_cast<double>(i) / recording.rate - to_seconds(touched->t), 0.0));
}

/// From a motion of the tool to the finished picture that shows it.
void picture(benchmark::State& state, const render::Quality& quality) {
  const Scene scene = read_scene(assets_folder() / "scenes/molar-caries.json");
  haptics::TissueVolume volume = load_tissue(scene);
  TissueView view;
  const auto bricks = view.update(volume);
  PictureStage::Options options;
  options.quality = quality;
  PictureStage stage(display::load_rig(assets_folder() / "rigs/window.json"), scene.servo, options);
  stage.show(bricks, volume.frame().origin);
  ServoTick tick;
  tick.X_WG.p = dvec3(6.8_mm, 5.5_mm, 19.0_mm);
  World world(scene);
  world.place(tick);
  stage.draw(world, {.debris = false, .mirror = false});
  std::vector<double> times;
  for (int i = 0; i < (smoke() ? 2 : 15); ++i) {
    const Nanos start = now();
    tick.X_WG.p.x += 1e-5;
    world.place(tick);
    stage.draw(world, {.debris = false, .mirror = false});
    times.push_back(static_cast<double>(now() - start));
  }
  set_time(state, quantile(times, 0.5));
}

/// Start-up with warm caches: the best of three.
void start(benchmark::State& state) {
  const Folder folder;
  const std::string scene = (assets_folder() / "scenes/molar-caries.json").string();
  double tick = 1e9, nothing = 1e9, picture = 1e9;
  for (int i = 0; i < (smoke() ? 1 : 3); ++i) {
    nothing = std::min(nothing, run("--version"));
    run(fmt::format("run '{}' --hand 'script:{}' --audio none: --seconds 0.5 --json", scene, folder / "rest.csv"),
        folder / "said.json");
    tick = std::min(tick, Json::load(folder / "said.json")["start"]["first_tick_s"].number());
    if (!smoke())
      picture = std::min(picture, run(fmt::format("render '{}' --out '{}' --size 1280x1024", scene,
                                                  folder.temporary.path().string())));
  }
  state.counters["nothing_s"] = nothing;
  state.counters["first_tick_s"] = tick;
  if (!smoke()) state.counters["pictures_s"] = picture;
}

/// Processor time of a live session without a picture. A short session is subtracted from a long one, so that start and
/// end do not count.
void session(benchmark::State& state, const char* hand) {
  const Folder folder;
  const auto cpu = [&](double seconds) {
    const double before = cpu_seconds(RUSAGE_CHILDREN);
    run(fmt::format("run '{}' --hand 'script:{}' --audio none: --record '{}' --seconds {}", folder / "block.json",
                    folder / hand, folder / "s.h5", seconds));
    return cpu_seconds(RUSAGE_CHILDREN) - before;
  };
  const double brief = smoke() ? 0.5 : 2, lasting = smoke() ? 1 : 20, used = cpu(lasting) - cpu(brief);
  set_time(state, 1e9 * std::max(used, 0.0) / (1000 * (lasting - brief)));
  state.counters["core_percent"] = 100 * std::max(used, 0.0) / (lasting - brief);
}

}  // namespace

void add_cases() {
  add("touch to sound in a file", touch);
  add("command to", start);
  for (const render::Quality& quality :
       std::span(render::kQualityLadder).last(smoke() ? 1 : render::kQualityLadder.size()))
    add(fmt::format("hand to picture, 1280x720/{}", quality.name),
        [&quality](benchmark::State& state) { picture(state, quality); });
  add("live session, a tick of all threads/at rest", [](benchmark::State& state) { session(state, "rest.csv"); });
  add("live session, a tick of all threads/drilling", [](benchmark::State& state) { session(state, "drill.csv"); });
}

}  // namespace typodont::bench
