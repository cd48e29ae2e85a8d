// Measures the latency of the whole program: from a motion of the hand to its effects, and from the command to the
// first tick and picture. Uses wall-clock time, because waiting times are part of the latency.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "audio/audio_output.h"
#include "audio/sound_file.h"
#include "engine/app/assets.h"
#include "engine/app/bench/parts.h"
#include "engine/app/bench/session_cost_rows.h"
#include "engine/app/picture/picture_stage.h"
#include "engine/app/picture/tissue_view.h"
#include "engine/app/recording/resume.h"
#include "engine/app/workbench.h"
#include "engine/base/json.h"
#include "engine/base/measure.h"
#include "engine/base/temporary_folder.h"
#include "engine/base/units.h"
#include "engine/session/session_file.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;
using namespace literals;

constexpr double kTouchTime = 0.4;  // s, time at which the hand moves quickly from the air onto the tissue
constexpr const char* kBaseline = "a tenth of a second, which people notice";

BenchRow row(std::string name, std::string knob, double seconds, const char* per) {
  return {.name = std::move(name),
          .knob = std::move(knob),
          .time_ns = seconds * 1e9,
          .per = per,
          .baseline = kBaseline,
          .ratio = seconds / 0.1};
}

/// Measures the time from a fast motion of the hand to its force and sound. The hand holds an explorer (dental probe)
/// above a block of tissue, moves it onto the block at kTouchTime and keeps it there. So the first sound after the
/// silence is the sound of the contact.
void step_rows(const TemporaryFolder& folder, std::vector<BenchRow>& rows) {
  const fs::path hand = folder.path() / "hand.csv", wav = folder.path() / "s.wav", session = folder.path() / "s.h5";
  std::ofstream(hand) << fmt::format(
      "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,2.8,1,0,0,0,0\n{0},0,0,2.8,1,0,0,0,0\n{1},0,0,2.0,1,0,0,0,0\n0.8,0,"
      "0,2.0,1,0,0,0,0\n",
      kTouchTime - 0.002, kTouchTime + 0.002);
  const fs::path file = folder.path() / "scene.json";
  // This scene is run without a picture. picture_rows() measures the delay of the picture separately.
  std::ofstream(file)
      << R"({"tissue": {"voxel_mm": 0.2, "solids": [{"tissue": "enamel", "solid": {"box": {"size_mm": [8, 8, 4]}}}]},
    "tool": "explorer", "parts": ["haptics", "sound", "record"]})";
  WorkbenchOptions options;
  options.hand = "script:" + hand.string();
  options.audio = "wav:" + wav.string();
  options.record = session;
  run_workbench(read_scene(file), options);

  const session::SessionReader reader(session);
  double moved = -1, felt = -1;
  dvec3 rest(0);
  for (const ServoTick& tick : reader.ticks()) {
    const double t = to_seconds(tick.t);
    if (tick.index == 0) rest = tick.X_WT.p;
    if (moved < 0 && glm::length(tick.X_WT.p - rest) > 0.3_mm) moved = t;
    if (felt < 0 && glm::length(tick.f_T_W) > 0.05) felt = t;
  }
  if (felt < 0) return;
  rows.push_back(row("hand to force", "step onto enamel, 1 kHz", std::max(felt - moved, 1e-3), "step"));
  // In a sound file, each sound has the time stamp of its tick. So the delay measured here is only that of the
  // synthesizer.
  const audio::Recording recording = audio::read_recording(wav);
  const std::vector<double> samples = recording.mono();
  for (std::size_t i = static_cast<std::size_t>(moved * recording.rate); i < samples.size(); ++i) {
    if (std::abs(samples[i]) < 2e-3) continue;
    const double heard = static_cast<double>(i) / recording.rate;
    rows.push_back(
        row("hand to sound, into a file", "step onto enamel", std::max(heard - moved, 1 / recording.rate), "step"));
    break;
  }
  // With a sound device, the session records a hundred times per second the time from a tick to its sound. The recorded
  // times are read below.
  const std::vector<audio::AudioDevice> devices = audio::audio_devices();
  const auto card =
      std::find_if(devices.begin(), devices.end(), [](const audio::AudioDevice& d) { return d.is_default; });
  if (card == devices.end()) return;
  options.audio = "portaudio:" + card->name;
  run_workbench(read_scene(file), options);
  const session::SessionReader played(session);
  const auto& streams = played.header().streams;
  for (std::size_t i = 0; i < streams.size(); ++i) {
    if (streams[i].name != "sound") continue;
    std::vector<double> seconds = played.streams()[i].columns.back();  // s, the last column of the stream: latency_s
    std::erase_if(seconds, [](double v) { return !std::isfinite(v); });
    if (seconds.empty()) continue;
    for (const auto& [name, q] : {std::pair{"median", 0.5}, {"99 %", 0.99}})
      rows.push_back(row(fmt::format("hand to sound, {}", name), fmt::format("{}, its own share included", card->name),
                         quantile(seconds, q), "tick"));
  }
}

/// Measures the time from a motion of the tool to the finished picture that shows this motion.
void picture_rows(bool quick, std::vector<BenchRow>& rows) {
  const Scene scene = read_scene(assets_folder() / "scenes/molar-caries.json");
  haptics::TissueVolume volume = load_tissue(scene);
  TissueView view;
  const auto bricks = view.update(volume);
  for (const render::Quality& quality : render::kQualityLadder) {
    display::DisplayRig rig = display::load_rig(assets_folder() / "rigs/window.json");
    PictureStage::Options options;
    options.quality = quality;
    PictureStage stage(rig, scene.servo, options);
    stage.show(bricks, volume.frame().origin);
    ServoTick tick;
    tick.X_WG.p = dvec3(6.8_mm, 5.5_mm, 19.0_mm);
    stage.draw(tick, {}, 0);
    std::vector<double> times;
    for (int i = 0; i < (quick ? 3 : 15); ++i) {
      const Nanos start = now();
      tick.X_WG.p.x += 1e-5;
      stage.draw(tick, {}, 1.0 / 60);
      times.push_back(to_seconds(now() - start));
    }
    rows.push_back(row("hand to finished picture, " + stage.device_name(),
                       fmt::format("{}, {}x{}, mono", quality.name, rig.screen.pixels.x, rig.screen.pixels.y),
                       quantile(times, 0.5), "step"));
  }
}

/// Times of a command, s: from its start until its output `file` exists, and until its end.
struct Took {
  double there = 1e9, end = 1e9;
};
Took time_of(const std::string& command, const fs::path& file) {
  std::error_code none;
  fs::remove(file, none);
  std::atomic<bool> ended{false};
  Nanos there = 0;
  const Nanos start = now();
  std::thread watch([&] {
    while (!ended && !fs::exists(file, none)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    there = now();
  });
  const bool done = std::system(command.c_str()) == 0;
  const Nanos end = now();
  ended = true;
  watch.join();
  if (!done) return {std::nan(""), std::nan("")};
  return {to_seconds(there - start), to_seconds(end - start)};
}

/// Measures the start-up time of each command. Each command is run twice: the first run fills the caches, and the
/// second run is measured.
void start_rows(const TemporaryFolder& folder, std::vector<BenchRow>& rows) {
  const fs::path hand = folder.path() / "still.csv", said = folder.path() / "said.json",
                 picture = folder.path() / "left.png";
  std::ofstream(hand) << "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,30,1,0,0,0,0\n9,0,0,30,1,0,0,0,0\n";
  const std::string program = fs::read_symlink("/proc/self/exe").string();
  const std::string scene = (assets_folder() / "scenes/molar-caries.json").string();
  const auto time = [&](const std::string& arguments) {
    return time_of(fmt::format("'{}' {} >'{}' 2>/dev/null", program, arguments, said.string()), picture);
  };
  const auto add = [&](const char* name, const char* knob, double seconds) {
    BenchRow r = row(name, knob, seconds < 1e9 ? seconds : BenchRow::kNone, "start");
    r.baseline = "two seconds";
    r.ratio = r.time_ns / 2e9;
    rows.push_back(r);
  };
  constexpr const char* kWarm = "molar, warm caches, best of 3";
  constexpr int kTimes = 3;
  double nothing = 1e9, tick = 1e9, frame = 1e9;
  Took pictures;
  const bool desktop = display::has_desktop();
  for (int i = 0; i < kTimes; ++i) {
    nothing = std::min(nothing, time("--version").end);
    // Reads a duration that the live session itself measured. `key` selects it: from the command to the first finished
    // tick, or from the command to the first frame on the screen.
    const auto live = [&](double seconds, const char* rig, const char* key) {
      if (!std::isfinite(time(fmt::format("run '{}' --hand script:{} --audio none: --seconds {} --json {}", scene,
                                          hand.string(), seconds, rig))
                             .end))
        return std::nan("");
      return Json::load(said)["start"][key].number();
    };
    tick = std::min(tick, live(0.5, "", "first_tick_s"));
    const std::string rig = fmt::format("--rig '{}'", (assets_folder() / "rigs/window.json").string());
    if (desktop) frame = std::min(frame, live(3, rig.c_str(), "first_frame_s"));
    const Took took = time(fmt::format("render '{}' --out '{}' --size 1280x1024", scene, folder.path().string()));
    pictures = {std::min(pictures.there, took.there), std::min(pictures.end, took.end)};
  }
  add("start and end of the command without work", kWarm, nothing);
  add("command to first tick", kWarm, tick);
  if (desktop) add("command to first picture in a window", kWarm, frame);
  add("command to first picture in a file", "molar, two eyes of 1280x1024, warm caches, best of 3", pictures.there);
  add("command to its end, with all pictures and a frame for its time",
      "molar, two eyes of 1280x1024, warm caches, best of 3", pictures.end);
}

}  // namespace

std::vector<BenchRow> bench_latency(const BenchRun& run) {
  const TemporaryFolder folder;
  std::vector<BenchRow> rows;
  start_rows(folder, rows);
  step_rows(folder, rows);
  picture_rows(run.quick, rows);
  session_cost_rows(run.quick, rows);
  return rows;
}

}  // namespace typodont
