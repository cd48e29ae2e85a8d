// `typodont run`: runs a live session.
#include <fmt/format.h>

#include <array>
#include <memory>
#include <nlohmann/json.hpp>

#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/app/commands/values.h"
#include "engine/app/operator/library.h"
#include "engine/app/operator/session_scores.h"
#include "engine/app/picture/hud.h"
#include "engine/app/recording/resume.h"
#include "engine/app/workbench.h"
#include "engine/base/log.h"
#include "engine/base/units.h"
#include "engine/contract/session_length.h"
#include "engine/render/quality.h"
#include "haptics/contact_method.h"
#include "haptics/device_safety.h"

namespace typodont {

namespace {

struct RunOptions {
  std::string scene, resume, model, language, quality = "auto";
  WorkbenchOptions workbench;
  bool json = false;
};

constexpr double kMilligram = 1e-6;  // kg

/// Converts masses to JSON, in mg: the water, and the solid particles of each tissue.
nlohmann::ordered_json load_json(const debris::Load& load) {
  nlohmann::ordered_json json = {{"water_mg", load.water / kMilligram}};
  json.update(by_tissue(load.solids, kMilligram, "_mg"));
  return json;
}

/// The mass balance (mg) of the chips as JSON. Null if the GPU moves the chips, because then only the GPU knows their
/// masses.
nlohmann::ordered_json debris_json(const DebrisBalance& balance) {
  const debris::DebrisLedger& ledger = balance.chips;
  nlohmann::ordered_json json = {{"born_mg", by_tissue(ledger.born, kMilligram)},
                                 {"in_the_air_mg", ledger.alive / kMilligram},
                                 {"decayed_mg", ledger.decayed / kMilligram},
                                 {"sucked_mg", ledger.sucked / kMilligram},
                                 {"no_room_mg", ledger.dropped / kMilligram},
                                 {"deposited_mg", ledger.deposited / kMilligram},
                                 {"events_lost", balance.events_lost}};
  if (const auto& s = balance.spray)
    json["spray"] = {{"sprayed", load_json(s->sprayed)},   {"flung", load_json(s->flung)},
                     {"in_the_air", load_json(s->in_air)}, {"deposited", load_json(s->deposited)},
                     {"sucked", load_json(s->sucked)},     {"left", load_json(s->left)},
                     {"no_room", load_json(s->dropped)}};
  if (const auto& f = balance.film)
    json["film"] = {{"deposited", load_json(f->deposited)}, {"on_surface", load_json(f->on_surface)},
                    {"sucked", load_json(f->sucked)},       {"run_off", load_json(f->run_off)},
                    {"dried_mg", f->dried / kMilligram},    {"flung", load_json(f->flung)}};
  return json;
}

void run(const RunOptions& options) {
  Scene scene = read_scene(options.scene);
  choose_model(scene, options.model);
  if (!options.resume.empty()) scene = with_resume(scene, options.resume);
  WorkbenchOptions workbench = options.workbench;
  if (options.quality != "auto") workbench.quality = options.quality;
  workbench.warnings = warning_levels(scene, workbench.trainee);
  const WorkbenchSummary s = run_workbench(scene, workbench);
  double removed = 0;
  for (const double v : s.removed) removed += v;
  if (options.json) {
    nlohmann::ordered_json json = {
        {"seconds", s.seconds},
        {"start", {{"first_tick_s", s.first_tick_s}, {"first_frame_s", s.first_frame_s}}},
        {"ticks", s.ticks},
        {"frames", s.frames},
        {"cuts", s.cuts},
        {"removed_mm3", removed / kCubicMillimetre},
        {"faults", s.faults},
        {"deadline_misses", s.deadline_misses},
        {"jitter_us", {{"p99_9", s.jitter_us_p999}, {"worst", s.worst_jitter_us}}},
        {"real_time",
         {{"fifo", s.loop.fifo},
          {"pinned", s.loop.pinned},
          {"memory_locked", s.loop.memory_locked},
          {"note", s.loop.words()}}},
        {"motor_heat", s.loop.worst_heat},
        {"safety", haptics::describe_safety(s.loop.safety)},
        {"tick_us", {{"p50", s.tick_us_median}, {"p99_9", s.tick_us_p999}, {"worst", s.worst_tick_us}}},
        {"explain", s.explanations}};
    for (const WorkCount& c : listed(s.work)) json["work"][c.name] = c.value;
    for (const haptics::MethodCount& m : haptics::method_counts())
      json["work"]["models"][m.name] = {{"models", m.models}, {"bodies", m.bodies}};
    json["work"]["cpu_s"] = s.work.cpu_seconds, json["work"]["servo_cpu_s"] = s.work.servo_cpu_seconds;
    if (s.debris) json["debris"] = debris_json(*s.debris);
    if (s.tracker) json["head_tracker"] = {{"samples", s.tracker->samples}, {"dropped", s.tracker->dropped}};
    fmt::print("{}\n", json.dump(2));
    return;
  }
  fmt::print("{:.2f} s, {} ticks, {} frames, {:.3f} mm³ removed in {} cuts\n", s.seconds, s.ticks, s.frames,
             removed / kCubicMillimetre, s.cuts);
  fmt::print("start: first tick {:.2f} s after the command", s.first_tick_s);
  if (s.first_frame_s > 0) fmt::print(", first frame {:.2f} s", s.first_frame_s);
  fmt::print("\nservo: median {:.1f} µs, 99.9 % {:.1f} µs, worst {:.1f} µs, {} deadlines missed, faults {}\n",
             s.tick_us_median, s.tick_us_p999, s.worst_tick_us, s.deadline_misses, s.faults);
  fmt::print("beat: 99.9 % within {:.1f} µs, worst {:.1f} µs off{}\n", s.jitter_us_p999, s.worst_jitter_us,
             s.loop.words().empty() ? "" : fmt::format("; {}", s.loop.words()));
  if (s.loop.safety) fmt::print("safety: {}\n", haptics::describe_safety(s.loop.safety));
  if (s.tracker) fmt::print("head: {} samples, {} packets dropped\n", s.tracker->samples, s.tracker->dropped);
}

}  // namespace

void add_run_command(cli::Command& app) {
  auto options = std::make_shared<RunOptions>();
  WorkbenchOptions& w = options->workbench;
  cli::Command* command = app.add_command("run", "Run a live session of a scene; on a desktop, the mouse is the hand");
  command->footer(
      "Z undoes the last stroke, Y redoes it; S saves the tissue.\n"
      "Example:\n  typodont run assets/scenes/molar-caries.json --record session.h5\n"
      "Example: typodont run assets/scenes/molar-caries.json --resume session.h5 --record second.h5");
  command->add_option("scene", options->scene, "scene file (JSON), or the name of one in assets/scenes")->required();
  command->add_option("--rig", w.rig,
                      "rig file (JSON), or the name of one in assets/rigs: where screen, mirror, eyes and device are");
  command->add_option("--magnify", w.magnify, "magnify the scene by this factor instead of the one in the rig",
                      cli::range(0.1, 100.0));
  std::vector<std::string> levels{"auto"};
  for (const render::Quality& level : render::kQualityLadder) levels.emplace_back(level.name);
  command->add_setting("--quality", options->quality,
                       "level of the picture's quality; auto: follows the time of a frame", cli::one_of(levels));
  command->add_option("--hand", w.hand, "script:HAND.csv, expert:, mouse:, spacemouse:, woodenhaptics:[PATH], …");
  command->add_option("--left-hand", w.left_hand, "a second hand, with the mouth mirror: the same addresses");
  command->add_option("--pedal", w.pedal, "auto, none, or a pedal's path or serial (typodont devices)");
  command->add_setting("--rate", w.rate, "servo rate, Hz, for hands that do not set it", cli::range(500.0, 10000.0));
  command->add_option("--audio", w.audio, "portaudio:[DEVICE], wav:FILE or none:");
  command->add_flag("--binaural", w.binaural,
                    "sound for headphones: two channels, from where the tool is relative to the head");
  command->add_option("--trainee", w.trainee, "the trainee's name, for the recording");
  command->add_option("--record", w.record, "record the session (.h5)", cli::writes({FileKind::kSession}));
  command->add_option("--stream", w.stream,
                      "stream the session to other programs: osc:[HOST:]PORT, ws:[HOST:]PORT; without a host, this "
                      "computer; can be repeated");
  command->add_setting("--stream-rate", w.stream_rate, "rate of the streamed states, Hz", cli::range(1.0, 1000.0));
  command->add_option("--language", options->language,
                      "language of the text over the picture: en, de or zh; otherwise the window's language");
  command->add_option("--monitor", w.monitor, "show the picture full screen on this monitor, 0 is the first",
                      cli::from_zero());
  command->add_option("--touches", w.touches,
                      "pairs for 'calibrate register': touch a headset controller's tip with the arm, pull the trigger",
                      cli::writes({FileKind::kTable}));
  command->add_option("--save", w.save, "save the tissue here at the end, and whenever S is pressed (.vdb)",
                      cli::writes({FileKind::kVolume}));
  command->add_option("--resume", options->resume,
                      "continue from a saved tissue (.vdb) or from a recorded session's end (.h5)");
  command->add_option("--model", options->model,
                      "contact model instead of the scene's, " + haptics::known_contact_methods() +
                          "; or ./FILE.so, a shared object with one");
  command->add_option("--seconds", w.seconds, "end after this number of seconds, at most a day",
                      cli::more_than_zero(kLongestSession));
  command->add_flag("--no-real-time", w.no_real_time,
                    "use a hand with motors although the system grants this program no real-time priority");
  command->add_flag("--explain", w.explain,
                    "list the active parts and why the others are inactive; at the end, list the work that was done, "
                    "GPU time by pass, and late frames");
  command->add_flag("--json", options->json, "print the summary as JSON");
  command->callback([options, command] {
    command->refuse_without({"--stream-rate"}, !options->workbench.stream.empty(), "--stream");
    options->workbench.language = hud_language(user_language(options->language));
    run(*options);
  });
}

}  // namespace typodont
