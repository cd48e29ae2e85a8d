// `typodont sound`: fits a model to a recording, synthesizes sound, compares two sounds.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "audio/ar_fit.h"
#include "audio/binaural.h"
#include "audio/compare.h"
#include "audio/contact_track.h"
#include "audio/drill_synth.h"
#include "audio/sound_file.h"
#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/app/commands/sound_page.h"
#include "engine/app/commands/sound_picture.h"
#include "engine/app/commands/values.h"
#include "engine/app/live/sound_follower.h"
#include "engine/base/error.h"
#include "engine/base/json.h"
#include "engine/base/log.h"
#include "engine/base/progress.h"
#include "engine/base/units.h"

namespace typodont {

namespace {

using nlohmann::ordered_json;

void check_range(const char* option, double value, double low, double high) {
  if (value >= low && value <= high) return;  // this comparison is false for NaN
  throw Error(option, "", fmt::format("{}", value), fmt::format("{} to {}", low, high));
}

struct FitCommand {
  std::string input, out, spectrum, speed;
  audio::FitOptions options;
  double spindle_krpm = 0;
  bool json = false, no_trim = false, no_lines = false;
};

void run_fit(FitCommand c) {
  check_range("--spindle-krpm", c.spindle_krpm, 0, 1000);
  check_range("--from", c.options.from, 0, 1e5);
  check_range("--to", c.options.to, 0, 1e5);
  check_range("--rate", c.options.rate, 0, 1e6);
  c.options.spindle = c.spindle_krpm * kKrpm;
  c.options.trim = !c.no_trim;
  c.options.lines = !c.no_lines;
  const auto report = audio::fit_recording(c.input, c.options);
  const audio::ArModel& model = report.model;
  if (!c.spectrum.empty()) {
    std::string text = "frequency_Hz,recording_dB,model_dB\n";
    for (std::size_t i = 0; i < report.frequencies.size(); ++i) {
      text += fmt::format("{:.3f},{:.3f},{:.3f}\n", report.frequencies[i], report.recording_dB[i], report.model_dB[i]);
    }
    write_file_atomically(c.spectrum, text, FileKind::kTable);
  }
  if (!c.speed.empty()) {
    if (report.speed_ratio.empty()) throw Error(c.input, "--speed", "no steady line", "a line that shows the speed");
    if (model.spindle == 0) throw Error(c.input, "--speed", "no harmonic series", "--spindle-krpm");
    std::string text = "t_s,spindle_krpm\n";
    for (std::size_t i = 0; i < report.speed_ratio.size(); ++i)
      text += fmt::format("{:.6f},{:.6f}\n", report.speed_times[i], report.speed_ratio[i] * model.spindle / kKrpm);
    write_file_atomically(c.speed, text, FileKind::kTable);
  }
  write_file_atomically(c.out, audio::to_json(model), FileKind::kJson);
  if (report.distance_dB > 1) {
    log::info("{:.2f} dB from the recording: a higher --order or a lower --rate comes closer", report.distance_dB);
  }
  if (c.json) {
    ordered_json j;
    j["model"] = c.out;
    j["method"] = model.method;
    j["order"] = model.order();
    j["rate_Hz"] = model.rate;
    j["gain"] = model.gain;
    j["residual_variance"] = model.gain * model.gain;
    j["power_dB"] = 10 * std::log10(audio::power_of(model));
    j["level_dB"] = report.level_dB;
    j["log_spectral_distance_dB"] = report.distance_dB;
    j["unsmoothed_distance_dB"] = report.unsmoothed_distance_dB;
    j["itakura_saito"] = report.itakura_saito;
    j["up_to_Hz"] = report.up_to;
    j["largest_reflection"] = report.max_reflection;
    j["stable"] = report.max_reflection < 1;
    j["condition"] = report.condition;
    j["filter"] = report.form;
    j["sufficient_order"] = audio::sufficient_order(model);
    j["spindle_krpm"] = model.spindle / kKrpm;
    j["spindle_estimated"] = model.spindle_estimated;
    j["lines"] = ordered_json::array();
    for (const audio::ModelLine& line : model.lines) {
      j["lines"].push_back({{"frequency_Hz", line.frequency},
                            {"level_dB", 20 * std::log10(line.amplitude)},
                            {"amplitude_variation", line.amplitude_noise.deviation()},
                            {"frequency_deviation_Hz", line.frequency_noise.deviation()}});
    }
    j["duration_s"] = report.duration;
    j["from_s"] = report.from;
    j["to_s"] = report.to;
    j["parts"] = ordered_json::array();
    for (const audio::SoundPart& part : report.parts) {
      j["parts"].push_back(
          {{"part", audio::name_of(part.part)}, {"from_s", part.from}, {"to_s", part.to}, {"level_dB", part.level_dB}});
    }
    if (const auto& held = report.held_out) {
      j["held_out"] = {{"from_s", held->from},
                       {"to_s", held->to},
                       {"log_spectral_distance_dB", held->distance_dB},
                       {"chance_dB", held->chance_dB},
                       {"line_variation", held->line_variation}};
    }
    j["hum_Hz"] = report.hum;
    j["notes"] = report.notes;
    fmt::print("{}\n", j.dump(2, ' ', false, ordered_json::error_handler_t::replace));
    return;
  }
  fmt::print("{}: {} model of order {} at {:.0f} Hz\n", c.out, model.method, model.order(), model.rate);
  fmt::print("  fitted to       {:.3f} to {:.3f} s of {:.3f} s, level {:.1f} dB re full scale\n", report.from,
             report.to, report.duration, report.level_dB);
  for (const auto& note : report.notes) fmt::print("                  {}\n", note);
  fmt::print("  residual        standard deviation {:.4g}, {:.1f} dB under the sound\n", model.gain,
             10 * std::log10(audio::power_of(model)) - 20 * std::log10(model.gain));
  fmt::print("  spectrum        {:.2f} dB log-spectral distance, Itakura-Saito {:.3f}, to {:.0f} Hz\n",
             report.distance_dB, report.itakura_saito, report.up_to);
  fmt::print("  stability       largest |k| {:.5f}; condition {:.3g}: runs as {} filter\n", report.max_reflection,
             report.condition, report.form);
  fmt::print("  enough          order {} by the Bayesian criterion\n", audio::sufficient_order(model));
  for (const audio::ModelLine& line : model.lines) {
    fmt::print("  line            {:.1f} Hz, amplitude {:.1f} dB, varies by {:.0f} % and {:.1f} Hz\n", line.frequency,
               20 * std::log10(line.amplitude), 100 * line.amplitude_noise.deviation(),
               line.frequency_noise.deviation());
  }
  if (const auto& held = report.held_out) {
    fmt::print("  held out        {:.2f} to {:.2f} s: {:.2f} dB from the model, {:.2f} dB of it by chance\n",
               held->from, held->to, held->distance_dB, held->chance_dB);
    for (std::size_t i = 0; i < model.lines.size(); ++i) {
      fmt::print(
          "                  line {:.1f} Hz with the noise in its band varies by {:.0f} %, {:.0f} % in the fitted "
          "part\n",
          model.lines[i].frequency, 100 * held->line_variation[i], 100 * report.line_variation[i]);
    }
  }
  if (model.spindle > 0) {
    fmt::print("  spindle         {:.1f} krpm{}\n", model.spindle / kKrpm,
               model.spindle_estimated ? ", estimated from the lines: say --spindle-krpm if you know it" : "");
  } else {
    fmt::print("  spindle         not known: no harmonic series found\n");
  }
}

/// Converts "RIGHT,UP,AHEAD" (cm from the point between the eyes) to the angles at the ears.
audio::EarAngles angles_of(const std::string& text) {
  const std::vector<double> cm = numbers(text, "--binaural", 3, 3, "RIGHT,UP,AHEAD in cm, for example 10,-20,30");
  for (const double v : cm) check_range("--binaural", v, -1000, 1000);
  return audio::ear_angles(dvec3(cm[0], cm[1], -cm[2]) * 0.01, dvec3(0), dvec3(1, 0, 0));
}

struct SynthCommand {
  std::string model, out, contact;
  double seconds = 0, rate = 0, spindle_krpm = 0;
  std::uint64_t seed = 1;
  std::string binaural;
  bool json = false, wide = false;
};

void run_synth(const SynthCommand& c) {
  constexpr double kLongest = 36000;  // s, largest duration of a sound file
  if (c.seconds == 0 && c.contact.empty()) throw Error("--seconds", "", "nothing", "a length, or --contact");
  if (c.seconds != 0) check_range("--seconds", c.seconds, 1e-3, kLongest);
  if (c.rate != 0) check_range("--rate", c.rate, 8000, 384000);
  check_range("--spindle-krpm", c.spindle_krpm, 0, 1000);
  audio::SoundModels models = audio::load_sound_models(c.model);
  audio::ContactTrack track;
  if (!c.contact.empty()) track = audio::read_contact_track(c.contact);

  // Source of the reference speed (speed at which the model sounds like the recording): model, option, contact, none.
  std::string reference = "model";
  if (c.spindle_krpm > 0) {
    models.free_speed = c.spindle_krpm * kKrpm;
    reference = "option";
  } else if (track.has_spindle && track.fastest > 0) {
    // If the speeds in the file of --contact differ much from the recorded drill's speed, they belong to another type
    // of drill. In this case, the model's sound is used for the highest speed in the file.
    const bool told = models.free_speed > 0 && !models.idle.spindle_estimated;
    const bool beyond = track.fastest > 4.0 / 3 * models.free_speed;
    const bool far_below = track.fastest < models.free_speed / 3 && !told;
    if (beyond || far_below) {
      if (models.free_speed > 0) {
        log::info(
            "{}: runs at {:.1f} krpm, the recorded drill at {:.1f}{}: its sound is used for the highest speed here "
            "(--spindle-krpm changes this)",
            c.contact, track.fastest / kKrpm, models.free_speed / kKrpm, told ? "" : " (estimated)");
      }
      models.free_speed = track.fastest;
      reference = "contact";
    }
  }
  if (models.free_speed == 0) {
    // The recorded drill's speed is unknown, so the program assumes 100 krpm.
    models.free_speed = 100 * kKrpm;
    reference = "none";
  }

  if (c.contact.empty()) {
    audio::SoundState idle;
    idle.spindle = models.free_speed;
    idle.pedal = 1;
    track.states.push_back(idle);
    track.has_spindle = true;
    // If the track begins later than 0 s, a copy of its first state begins at 0 s.
  } else if (track.states.front().t > 0) {
    track.states.insert(track.states.begin(), track.states.front());
    track.states.front().t = 0;
  }
  const double rate = c.rate > 0 ? c.rate : models.idle.rate;
  const double seconds = c.seconds > 0 ? c.seconds : std::max(track.end, 1e-3);
  if (seconds > kLongest)
    throw Error(c.contact, "t_s", fmt::format("{} s", seconds), fmt::format("at most {} s, or --seconds", kLongest));
  const auto total = static_cast<std::size_t>(std::llround(seconds * rate));
  audio::DrillSynth synth(models, rate, c.seed);
  std::optional<audio::Binaural> ears;
  if (!c.binaural.empty()) {
    ears.emplace(rate);
    ears->turn(angles_of(c.binaural));
  }
  audio::WavWriter wav(c.out, rate, c.wide ? audio::SampleFormat::kFloat32 : audio::SampleFormat::kPcm16, ears ? 2 : 1);
  double power = 0, peak = 0;
  // Number of states of the drill (speed, force, tissue) from which the sound is made.
  std::size_t states = 0;
  {
    std::optional<Progress> progress;
    if (seconds > 300) progress.emplace("sound");
    std::vector<float> buffer(4096), stereo(2 * buffer.size());
    audio::VoicedTrack voiced(track, models.free_speed);
    std::optional<audio::SoundState> state = voiced.next();
    for (std::size_t done = 0; done < total;) {
      const std::size_t count = std::min(buffer.size(), total - done);
      const double until = static_cast<double>(done + count) / rate;
      for (; state && to_seconds(state->t) <= until; state = voiced.next()) {
        synth.push(*state);
        ++states;
      }
      const std::span<float> part(buffer.data(), count);
      synth.render(part);
      if (ears) {
        const std::span<float> both(stereo.data(), 2 * count);
        ears->render(part, both);
        wav.write(both);
      } else {
        wav.write(part);
      }
      for (const float v : part) {
        power += static_cast<double>(v) * static_cast<double>(v);
        peak = std::max(peak, std::abs(static_cast<double>(v)));
      }
      done += count;
      if (progress) progress->at(static_cast<double>(done) / static_cast<double>(total));
    }
  }
  wav.finish();
  const double rms_dB = 10 * std::log10(power / static_cast<double>(total) + 1e-30);
  if (c.json) {
    ordered_json j;
    j["out"] = c.out;
    j["voice"] = models.name;
    j["seconds"] = static_cast<double>(total) / rate;
    j["samples"] = total;
    j["rate_Hz"] = rate;
    j["seed"] = c.seed;
    j["order"] = models.idle.order();
    j["level_dB"] = rms_dB;
    j["peak_dB"] = 20 * std::log10(peak + 1e-15);
    j["free_speed_krpm"] = models.free_speed / kKrpm;
    j["free_speed_from"] = reference;
    j["states"] = states;
    fmt::print("{}\n", j.dump(2, ' ', false, ordered_json::error_handler_t::replace));
    return;
  }
  fmt::print("{}: {:.3f} s at {:.0f} Hz of {} (order {}), level {:.1f} dB, peak {:.1f} dB re full scale\n", c.out,
             static_cast<double>(total) / rate, rate, models.name, models.idle.order(), rms_dB,
             20 * std::log10(peak + 1e-15));
}

struct CompareCommand {
  std::string a, b;
  audio::CompareOptions options;
  double at_most = 0;
  bool json = false;
};

ordered_json as_json(const audio::SoundMeasure& m) {
  return {{"duration_s", m.duration},  {"rate_Hz", m.rate},
          {"level_dB", m.level_dB},    {"peak_dB", m.peak_dB},
          {"centroid_Hz", m.centroid}, {"rotor_Hz", m.rotor},
          {"tones_Hz", m.tones},       {"tone_variation", m.tone_variation}};
}

void run_compare(const CompareCommand& c) {
  check_range("--up-to-hz", c.options.up_to, 200, 200000);
  const auto r = audio::compare_sounds(c.a, c.b, c.options);
  if (c.json) {
    ordered_json j;
    j["log_spectral_distance_dB"] = r.distance_dB;
    j["shape_distance_dB"] = r.shape_distance_dB;
    j["itakura_saito"] = r.itakura_saito;
    j["level_difference_dB"] = r.level_difference_dB;
    j["tone_ratio"] = r.tone_ratio;
    j["up_to_Hz"] = r.up_to;
    j["a"] = as_json(r.a);
    j["b"] = as_json(r.b);
    fmt::print("{}\n", j.dump(2));
  } else {
    fmt::print("log-spectral distance  {:8.2f} dB to {:.0f} Hz ({:.2f} dB at equal level)\n", r.distance_dB, r.up_to,
               r.shape_distance_dB);
    fmt::print("Itakura-Saito          {:8.3f}\n", r.itakura_saito);
    fmt::print("level                  {:8.2f} dB louder\n", r.level_difference_dB);
    if (r.tone_ratio > 0) fmt::print("strongest tone         {:8.4f} times\n", r.tone_ratio);
    for (const auto& [name, m] : {std::pair{&c.a, &r.a}, std::pair{&c.b, &r.b}}) {
      fmt::print(
          "{}: {:.2f} s at {:.0f} Hz, level {:.1f} dB, peak {:.1f} dB, centroid {:.0f} Hz, tones {:.0f} Hz, whose "
          "amplitudes vary by {:.2f}\n",
          *name, m->duration, m->rate, m->level_dB, m->peak_dB, m->centroid, fmt::join(m->tones, " "),
          fmt::join(m->tone_variation, " "));
    }
  }
  if (c.at_most > 0 && !(r.distance_dB <= c.at_most)) {
    throw RunFailure(fmt::format("{} and {} are {:.2f} dB apart, more than {} dB", c.a, c.b, r.distance_dB, c.at_most));
  }
}

struct PictureCommand {
  std::string input, out;
  double up_to = 12000;
  bool json = false;
};

void run_picture(const PictureCommand& c) {
  check_range("--up-to-hz", c.up_to, 200, 200000);
  const SoundPicture made = picture_of_sound(c.input, c.up_to, {1200, 420});
  render::write_png(c.out, made.picture);
  if (!c.json) {
    fmt::print("{}: {:.2f} s, 0 to {:.0f} Hz\n", c.out, made.seconds, made.to);
    return;
  }
  ordered_json j;
  j["picture"] = c.out;
  j["seconds"] = made.seconds;
  j["up_to_Hz"] = made.to;
  j["plot_px"] = {made.plot_lo.x, made.plot_lo.y, made.plot_size.x, made.plot_size.y};
  fmt::print("{}\n", j.dump(2, ' ', false, ordered_json::error_handler_t::replace));
}

struct FollowCommand {
  FollowOptions options;
  double wait_ms = 20;
  bool json = false;
};

void run_follow(FollowCommand& c) {
  check_range("--wait-ms", c.wait_ms, 0, 1000);
  if (c.options.audio.empty()) c.options.audio = "portaudio:";
  c.options.wait = c.wait_ms * 1e-3;
  const FollowedSound r = follow_sound(c.options);
  if (c.json) {
    fmt::print("{}\n", ordered_json{{"scene", r.scene},
                                    {"seconds", r.seconds},
                                    {"states", r.states},
                                    {"lost_ticks", r.lost},
                                    {"delay_ms", r.delay * 1e3},
                                    {"network_ms", r.network * 1e3}}
                           .dump(2, ' ', false, ordered_json::error_handler_t::replace));
    return;
  }
  fmt::print("{}: {:.1f} s, {} states, {} ticks lost\n", r.scene, r.seconds, r.states, r.lost);
  if (std::isfinite(r.delay)) fmt::print("delay: {:.0f} ms from the arrival of a state to its sound\n", r.delay * 1e3);
  if (std::isfinite(r.network))
    fmt::print("network: {:.1f} ms from a tick to its arrival, if the clocks of both computers agree\n",
               r.network * 1e3);
}

}  // namespace

void add_sound_command(cli::Command& app) {
  cli::Command* sound = app.add_command("sound", "Drill sound: models from recordings, sound from models");
  sound->expect_commands(1, 1);
  sound->footer(
      "Example:\n  typodont sound fit drill.wav --out drill.json\n"
      "  typodont sound synth drill.json --seconds 5 --out model.wav\n"
      "  typodont sound compare drill.wav model.wav");

  auto fit = std::make_shared<FitCommand>();
  cli::Command* f = sound->add_command("fit", "Fit an autoregressive model to a recording");
  f->add_option("input", fit->input, "Recording (WAV, FLAC, OGG, AIFF)")->required();
  f->add_option("--out", fit->out, "Model file to write (.json)", cli::writes({FileKind::kJson}))->required();
  f->add_setting("--order", fit->options.order, "Poles: a number, or aic or bic to let the criterion choose");
  f->add_setting("--max-order", fit->options.max_order, "The highest order a criterion may choose");
  f->add_setting("--method", fit->options.method, "burg, yule-walker or modified-covariance");
  f->add_setting("--window", fit->options.window, "none, hann, hamming or blackman");
  f->add_option("--rate", fit->options.rate, "Rate of the model in Hz; the recording is resampled (default: its own)");
  f->add_option("--channel", fit->options.channel, "Channel, from 0 (default: the mean of all)", cli::from_zero());
  f->add_option("--from", fit->options.from, "Start in the recording, s");
  f->add_option("--to", fit->options.to, "End in the recording, s");
  f->add_flag("--steady", fit->options.steady, "Fit only the longest stretch of even loudness");
  f->add_option("--part", fit->options.part, "Fit only the longest run-up, idle, load or run-down");
  f->add_flag("--no-trim", fit->no_trim, "Keep silence at both ends");
  f->add_flag("--no-lines", fit->no_lines, "Model steady lines as noise, too, not as sinusoids");
  f->add_setting("--hum", fit->options.hum, "Mains hum to remove: auto, off, 50 or 60");
  f->add_option("--spindle-krpm", fit->spindle_krpm, "Speed of the drill in the recording (default: estimated)");
  f->add_option("--name", fit->options.name, "Name of the model");
  f->add_option("--source", fit->options.source, "Where the recording comes from");
  f->add_option("--licence", fit->options.licence, "The recording's licence");
  f->add_option("--hold-out", fit->options.hold_out, "Fraction at the end to compare with, and not to fit");
  f->add_option("--speed", fit->speed, "CSV of the spindle's speed over time to write (a contact file)",
                cli::writes({FileKind::kTable}));
  f->add_option("--spectrum", fit->spectrum, "CSV of both spectra to write", cli::writes({FileKind::kTable}));
  f->add_flag("--json", fit->json, "Print the report as JSON");
  f->footer(
      "Refuses, with the reason, what cannot be fitted: silence, clipping, a pure tone, too few samples.\n"
      "Example:\n  typodont sound fit drill.wav --out drill.json --order 300 --steady");
  f->callback([fit] { run_fit(*fit); });

  auto synth = std::make_shared<SynthCommand>();
  cli::Command* s = sound->add_command("synth", "Make sound from a model or a voice");
  s->add_option("model", synth->model, "Model or voice file")->required();
  s->add_option("--seconds", synth->seconds, "Length (default: that of the contact file)");
  s->add_option("--out", synth->out, "WAV file to write", cli::writes({FileKind::kSound}))->required();
  s->add_option("--contact", synth->contact, "What the hand does: a contact file, or ticks of typodont servo");
  s->add_option("--rate", synth->rate, "Rate of the WAV file in Hz (default: the model's)");
  s->add_setting("--seed", synth->seed, "Seed of the noise: same seed, same bytes");
  s->add_option("--spindle-krpm", synth->spindle_krpm, "Speed at which the model sounds as recorded");
  s->add_option("--binaural", synth->binaural,
                "Two channels for headphones: the drill at RIGHT,UP,AHEAD of the eyes in cm");
  s->add_flag("--float", synth->wide, "32-bit float samples instead of 16-bit");
  s->add_flag("--json", synth->json, "Print what was made as JSON");
  s->footer(
      "A contact file is a CSV with t_s and any of spindle_krpm, pedal (0..1), force_N, contact_area_mm2,\n"
      "removal_mm3_per_s, tissue (enamel, dentin, caries ...), slip_mm_per_s, suction (0..1), spray (0..1),\n"
      "cutting (0: a hand instrument). Values between rows are interpolated. Without spindle_krpm the speed falls with "
      "the force.\n"
      "Example:\n  printf 't_s,spindle_krpm,force_N,contact_area_mm2,tissue\\n0,300,0,0,air\\n1,300,0,0,enamel\\n"
      "1.1,250,1.5,0.8,enamel\\n3,250,1.5,0.8,enamel\\n' > contact.csv\n"
      "  typodont sound synth assets/sounds/air_turbine.json --contact contact.csv --out drill.wav");
  s->callback([synth] { run_synth(*synth); });

  auto compare = std::make_shared<CompareCommand>();
  cli::Command* p = sound->add_command("compare", "Compare two sounds: spectra, level, tones");
  p->add_option("a", compare->a, "Sound file")->required();
  p->add_option("b", compare->b, "Sound file")->required();
  p->add_setting("--up-to-hz", compare->options.up_to, "Highest frequency compared");
  p->add_flag("--constant-speed", compare->options.constant_speed,
              "Remove changes of the spindle's speed first, measured on a steady line");
  p->add_option("--at-most-db", compare->at_most, "Exit with 1 when the log-spectral distance is larger");
  p->add_flag("--json", compare->json, "Print the comparison as JSON");
  p->footer("Example:\n  typodont sound compare recording.wav model.wav --at-most-db 1");
  p->callback([compare] { run_compare(*compare); });

  auto picture = std::make_shared<PictureCommand>();
  cli::Command* d = sound->add_command("picture", "Draw a sound: its spectrum over time");
  d->add_option("input", picture->input, "Sound file (WAV, FLAC, OGG, AIFF)")->required();
  d->add_option("--out", picture->out, "Picture to write (.png)", cli::writes({FileKind::kPicture}))->required();
  d->add_setting("--up-to-hz", picture->up_to, "Highest frequency shown");
  d->add_flag("--json", picture->json, "Print where in the picture the plot lies as JSON");
  d->footer("Example:\n  typodont sound picture demo/drill.wav --out drill.png");
  d->callback([picture] { run_picture(*picture); });

  auto follow = std::make_shared<FollowCommand>();
  cli::Command* w = sound->add_command("follow", "Play the sound of a session that runs on another computer");
  w->add_option("address", follow->options.address, "ws:[HOST:]PORT, as of run --stream")->required();
  w->add_option("--audio", follow->options.audio, "portaudio:[DEVICE] (default) or wav:FILE");
  w->add_setting("--wait-ms", follow->wait_ms, "How long a sound device waits for late states");
  w->add_option("--seconds", follow->options.seconds, "Length (default: to the session's end)");
  w->add_flag("--json", follow->json, "Print what was heard, and the delay, as JSON");
  w->footer(
      "Example:\n  typodont run molar-caries --stream ws:0.0.0.0:9001 --stream-rate 1000\n"
      "  typodont sound follow ws:192.168.0.5:9001");
  w->callback([follow] { run_follow(*follow); });

  add_sound_page_command(*sound);
}

}  // namespace typodont
