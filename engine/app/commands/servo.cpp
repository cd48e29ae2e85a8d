// `typodont servo`: runs servo and carver without pictures and sound, deterministically and as fast as possible.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/app/commands/values.h"
#include "engine/app/hands/expert_hand.h"
#include "engine/app/hands/implant_expert.h"
#include "engine/app/hands/live_expert.h"
#include "engine/app/picture/tissue_view.h"
#include "engine/app/recording.h"
#include "engine/app/session_start.h"
#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/base/measure.h"
#include "engine/base/progress.h"
#include "engine/base/units.h"
#include "engine/session/session_file.h"
#include "engine/session/ticks_csv.h"
#include "haptics/contact_method.h"
#include "haptics/scripted_hand.h"

namespace typodont {

namespace {

struct ServoOptions {
  std::string scene, hand, out, save, model;
  double rate = 1000, stall_ms = 0;
  bool json = false, no_timing = false;
};

/// Duration of the hand's path, s. Empty for the expert (planned hand), which ends the run itself.
std::optional<double> length_of(const ServoOptions& options, const Scene& scene) {
  const std::string& hand = options.hand;
  if (hand == "expert:") return std::nullopt;
  if (hand.starts_with("replay:")) {
    const session::SessionReader recorded(hand.substr(7));
    const std::uint64_t ticks = recorded.tick_count();
    return ticks == 0 ? 0 : to_seconds(recorded.ticks(ticks - 1, 1).front().t);
  }
  return haptics::length_of_scripted_hand(hand.starts_with("script:") ? hand.substr(7) : hand, tool_names(scene));
}

/// Throws Error if the disk lacks space for the output.
void check_room(const ServoOptions& options, double seconds) {
  constexpr double kBytesPerRow = 280;   // bytes, measured size of a row of the CSV table
  constexpr double kBytesPerTick = 240;  // bytes, size of a tick in a compressed session file
  // A message announces an output larger than this, bytes.
  constexpr double kWorthSaying = 500 << 20;
  const bool session = std::string_view(options.out).ends_with(".h5");
  const double bytes = seconds * options.rate * (session ? kBytesPerTick : kBytesPerRow);
  const std::filesystem::path folder = std::filesystem::absolute(options.out).parent_path();
  std::error_code code;
  const bool file = !std::filesystem::exists(options.out, code) || std::filesystem::is_regular_file(options.out, code);
  const auto space = std::filesystem::space(folder, code);
  if (!code && file && bytes > static_cast<double>(space.available)) {
    throw Error(options.out, "", fmt::format("{:.3g} GB of room", static_cast<double>(space.available) * 1e-9),
                fmt::format("about {:.3g} GB for {:.6g} s at {:g} Hz", bytes * 1e-9, seconds, options.rate));
  }
  if (bytes > kWorthSaying)
    log::info("{:.6g} s at {:g} Hz: about {:.3g} GB will be written", seconds, options.rate, bytes * 1e-9);
}

void run(const ServoOptions& options) {
  Scene scene = read_scene(options.scene);
  choose_model(scene, options.model);
  const bool asked = options.hand == "expert:";
  auto hand = asked ? make_unplanned_expert(scene, options.rate) : open_unpaced_hand(scene, options.hand, options.rate);
  const bool expert = asked && !hand;
  SteppedSession session = start_session(scene, expert ? ExpertHand::info_for(options.rate) : hand->info());
  if (expert) hand = std::make_unique<PlanningExpert>(scene, session.carver(), options.rate);

  session.stall_carver(options.stall_ms * 1e-3);
  if (options.no_timing) session.omit_times();
  const std::optional<double> length = length_of(options, scene);
  if (length) check_room(options, *length);
  if (!options.save.empty()) require_output(options.save, FileKind::kVolume);

  std::optional<SessionRecorder> recorder;
  std::optional<session::TicksCsvWriter> csv;
  if (constexpr std::array kKinds{FileKind::kSession}; kind_of_name(options.out, kKinds) == FileKind::kSession)
    recorder.emplace(options.out, scene, hand->info(), session.carver().volume(), session.event_logs());
  else
    csv.emplace(options.out);

  const auto* const planner = dynamic_cast<const PlanningExpert*>(hand.get());
  const auto* const surgeon = dynamic_cast<const ImplantExpert*>(hand.get());
  Progress progress(expert ? "expert" : "servo");
  std::uint64_t ticks = 0;
  std::uint32_t faults = 0;
  const ServoTick& last = session.last();
  EvenSample times;  // ns, computing times of the ticks
  // Largest force, N; lowest energy that the hand has given to the device (ServoTick::energy), J.
  double force_max = 0, energy_min = 0;
  while (session.advance(*hand)) {
    recorder ? recorder->turn() : csv->append({&last, 1});
    ++ticks;
    if (ticks % 256 == 0)
      progress.at(planner ? planner->done() : surgeon ? surgeon->done() : length ? to_seconds(last.t) / *length : 0);
    faults |= last.faults;
    times.add(static_cast<double>(last.cpu_time));
    force_max = std::max(force_max, glm::length(last.f_T_W));
    energy_min = std::min(energy_min, last.energy);
  }
  if (const std::string phase = surgeon ? surgeon->gave_up() : ""; !phase.empty())
    throw RunFailure(fmt::format("the expert could not do the phase \"{}\"", phase));
  haptics::TissueVolume& tissue = session.carver().volume();
  if (csv) csv->finish();
  const std::uint64_t field_hash = recorder ? recorder->finish(tissue) : tissue.hash();
  progress.at(1);
  if (!options.save.empty()) save_tissue(copy_of(session.carver()), options.save);

  const auto percentile = [&](double p) { return times.quantile(p) * 1e-3; };
  if (options.json) {
    const nlohmann::ordered_json json = {
        {"model", model_name(scene)},
        {"elements", session.carver().body().elements()},
        {"ticks", ticks},
        {"seconds", to_seconds(last.t)},
        {"cuts", last.cuts},
        {"loose_pieces", session.pieces()},
        {"removed_mm3", by_tissue(last.removed, kCubicMillimetre)},
        {"energy_mJ", last.energy * 1e3},
        {"faults", faults},
        {"tick_us", {{"p50", percentile(0.5)}, {"p99", percentile(0.99)}, {"p99_9", percentile(0.999)}}},
        {"tick_us_median", percentile(0.5)},
        {"tick_us_p999", percentile(0.999)},
        {"force_max_N", force_max},
        {"energy_min_J", energy_min},
        {"field_hash", fmt::format("{:016x}", field_hash)},
        {"out", options.out}};
    fmt::print("{}\n", json.dump(2));
  } else {
    fmt::print("{} ticks, {:.3f} s, {} cuts, {:.4f} mm³ removed\n", ticks, to_seconds(last.t), last.cuts,
               total(last.removed) / kCubicMillimetre);
    fmt::print("tick: median {:.2f} µs, 99 % {:.2f} µs, 99.9 % {:.2f} µs of thread CPU time\n", percentile(0.5),
               percentile(0.99), percentile(0.999));
    fmt::print("field {:016x}, faults {}\n", field_hash, faults);
    fmt::print("wrote {}\n", options.out);
  }
}

}  // namespace

void add_servo_command(cli::Command& app) {
  auto options = std::make_shared<ServoOptions>();
  cli::Command* command =
      app.add_command("servo", "Run only the haptic core with a scripted hand; equal input gives equal output bytes");
  command->footer(
      "Example:\n  typodont servo assets/scenes/molar-caries.json --hand hand.csv --out ticks.csv --rate 4000");
  command->add_option("scene", options->scene, "scene file (JSON), or the name of one in assets/scenes")->required();
  command
      ->add_option(
          "--hand", options->hand,
          "HAND.csv, a path; HAND.json, a simulated hand; replay:SESSION.h5; or expert:, a hand that knows the task")
      ->required();
  command
      ->add_option("--out", options->out, "ticks to write: .csv, or .h5 for a session",
                   cli::writes({FileKind::kTable, FileKind::kSession}))
      ->required();
  command->add_setting("--rate", options->rate, "servo rate, Hz", cli::range(10.0, 100000.0));
  command->add_option("--model", options->model,
                      "contact model instead of the scene's, " + haptics::known_contact_methods() +
                          "; or ./FILE.so, a shared object with one");
  command->add_option("--stall-carver-ms", options->stall_ms, "stall the carver for this time once a second",
                      cli::range(0.0, 500.0));
  command->add_option("--save", options->save, "save the tissue afterwards (.vdb)", cli::writes({FileKind::kVolume}));
  command->add_flag(
      "--no-timing", options->no_timing,
      "write 0 for tick_us, the one column that differs from run to run: equal runs are then equal bytes");
  command->add_flag("--json", options->json, "print the summary as JSON");
  command->callback([options] { run(*options); });
}

}  // namespace typodont
