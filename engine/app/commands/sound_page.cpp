#include "engine/app/commands/sound_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "audio/ar_fit.h"
#include "audio/compare.h"
#include "audio/drill_synth.h"
#include "audio/sound_file.h"
#include "engine/app/commands/command_line.h"
#include "engine/app/commands/sound_picture.h"
#include "engine/base/base64.h"
#include "engine/base/error.h"
#include "engine/base/input_file.h"
#include "engine/base/json.h"
#include "engine/base/markup.h"
#include "engine/base/temporary_folder.h"
#include "engine/base/units.h"

namespace typodont {

namespace {

std::vector<std::uint8_t> bytes_of(const std::filesystem::path& file) {
  const std::string text = read_input(file, InputKind::kAny);
  return {text.begin(), text.end()};
}

void write_wav(const std::filesystem::path& file, std::span<const double> x, double rate) {
  const std::vector<float> samples(x.begin(), x.end());
  audio::WavWriter wav(file, rate);
  wav.write(samples);
  wav.finish();
}

struct PageCommand {
  std::string recording, model, out;
  audio::FitOptions options;
  double seconds = 10, up_to = 16000;
};

/// Synthesizes the model's sound. `ratios`: spindle speeds at `times` (s), relative to the model's speed; empty:
/// constant speed.
std::vector<double> sound_of(const audio::ArModel& model, std::span<const double> times, std::span<const double> ratios,
                             double seconds) {
  audio::SoundModels models;
  models.idle = model;
  models.free_speed = model.spindle > 0 ? model.spindle : 100 * kKrpm;
  audio::DrillSynth synth(models, model.rate, 1);
  audio::SoundState state;
  state.spindle = models.free_speed;
  synth.push(state);
  constexpr double kEvery = 0.01;  // s, time between two states that the synthesizer receives
  std::size_t i = 0;
  std::vector<float> y(static_cast<std::size_t>(seconds * model.rate));
  const auto block = static_cast<std::size_t>(kEvery * model.rate);
  for (std::size_t at = 0; at < y.size(); at += block) {
    const double t = static_cast<double>(at) / model.rate;
    while (i + 1 < times.size() && times[i + 1] <= t) ++i;
    state.t = from_seconds(t);
    if (!ratios.empty()) state.spindle = models.free_speed * ratios[i];
    synth.push(state);
    synth.render(std::span(y).subspan(at, std::min(block, y.size() - at)));
  }
  return {y.begin(), y.end()};
}

// Length of the sound for the spectrum, s. With this length, noise hardly changes the spectrum.
constexpr double kMeasured = 30;

void run_page(const PageCommand& c) {
  if (!(c.seconds >= 0.1 && c.seconds <= 60)) throw Error("--seconds", "", fmt::to_string(c.seconds), "0.1 to 60");
  const audio::FitReport fit = audio::fit_recording(c.recording, c.options);
  const audio::ArModel model = c.model.empty() ? fit.model : audio::load_model(c.model);
  const audio::Recording recording = audio::read_recording(c.recording);
  const TemporaryFolder folder;
  const auto all = recording.mono(c.options.channel);
  const auto first = static_cast<std::size_t>(fit.from * recording.rate);
  const double seconds = std::min(c.seconds, fit.to - fit.from);
  const auto count = std::min(all.size() - first, static_cast<std::size_t>(seconds * recording.rate));
  write_wav(folder.path() / "recording.wav", std::span(all).subspan(first, count), recording.rate);
  write_wav(folder.path() / "model.wav", sound_of(model, fit.speed_times, fit.speed_ratio, seconds), model.rate);
  write_wav(folder.path() / "measured.wav", sound_of(model, {}, {}, kMeasured), model.rate);
  audio::CompareOptions options{.constant_speed = true};
  for (const audio::ModelLine& line : model.lines) options.lines.push_back(line.frequency);
  const audio::Comparison compared =
      audio::compare_sounds(folder.path() / "recording.wav", folder.path() / "measured.wav", options);

  std::string page =
      page_head(std::filesystem::path(c.recording).filename().string() + " and its model",
                "body{font:16px/1.5 system-ui,sans-serif;max-width:90rem;margin:2rem auto;padding:0 1rem;color:#1d2330;"
                "background:#fff}img{max-width:100%;height:auto}main{display:grid;"
                "grid-template-columns:repeat(auto-fit,minmax(24rem,1fr));gap:1rem}figure{margin:0}audio{width:100%}"
                "table{border-collapse:collapse;font-variant-numeric:tabular-nums}"
                "td,th{border:1px solid #c9ced8;padding:.25rem .6rem;text-align:right}th{text-align:left}");
  page += "<main>\n";
  const double up_to = std::min({c.up_to, recording.rate / 2, model.rate / 2});
  for (const auto& [name, title] : {std::pair{"recording", "Recording"}, {"model", "Model"}}) {
    const auto wav = folder.path() / (std::string(name) + ".wav"), png = folder.path() / (std::string(name) + ".png");
    render::write_png(png, picture_of_sound(wav, up_to, {900, 380}).picture);
    page += fmt::format(
        "<figure><figcaption>{0}</figcaption><audio controls src=\"data:audio/wav;base64,{1}\"></audio><img "
        "alt=\"Spectrogram of the {2}\" src=\"data:image/png;base64,{3}\"></figure>\n",
        title, base64(bytes_of(wav)), name, base64(bytes_of(png)));
  }
  page += "</main>\n<h2>Measured</h2>\n<table>\n";
  const auto row = [&](const char* name, const std::string& value) {
    page += fmt::format("<tr><th>{}</th><td>{}</td></tr>\n", name, escaped(value));
  };
  row("part of the recording", fmt::format("{:.2f} to {:.2f} s", fit.from, fit.to));
  row("model", fmt::format("{}, order {}, {} lines", model.name, model.order(), model.lines.size()));
  row("log-spectral distance at constant speed",
      fmt::format("{:.2f} dB to {:.0f} Hz", compared.distance_dB, compared.up_to));
  row("level of the model over the recording's", fmt::format("{:+.2f} dB", compared.level_difference_dB));
  for (const std::string& note : fit.notes) row("note", note);
  page += "</table>\n";
  if (!options.lines.empty()) {
    page +=
        "<h2>Lines</h2>\n<table>\n<tr><th>line, Hz</th><th>its amplitude varies in the recording by</th>"
        "<th>in the model by</th><th>model over recording</th></tr>\n";
    for (std::size_t i = 0; i < options.lines.size(); ++i) {
      const double own = compared.a.line_variation[i], models = compared.b.line_variation[i];
      page += fmt::format("<tr><td>{:.0f}</td><td>{:.0f} %</td><td>{:.0f} %</td><td>{:+.0f} %</td></tr>\n",
                          options.lines[i], 100 * own, 100 * models, own > 0 ? 100 * (models / own - 1) : 0.0);
    }
    page += "</table>\n";
  }
  page += "</body></html>\n";
  write_file_atomically(c.out, page, FileKind::kPage);
  fmt::print("{}: {:.2f} dB log-spectral distance to {:.0f} Hz\n", c.out, compared.distance_dB, compared.up_to);
}

}  // namespace

void add_sound_page_command(cli::Command& sound) {
  auto page = std::make_shared<PageCommand>();
  cli::Command* p = sound.add_command("page", "Write a page with a recording and its model side by side");
  p->add_option("recording", page->recording, "Recording (WAV, FLAC, OGG, AIFF)")->required();
  p->add_option("--out", page->out, "Page to write (.html)", cli::writes({FileKind::kPage}))->required();
  p->add_option("--model", page->model, "Model file (default: fitted to the recording)");
  p->add_setting("--seconds", page->seconds, "Longest part that is played");
  p->add_setting("--up-to-hz", page->up_to, "Highest frequency shown");
  p->add_flag("--steady", page->options.steady, "Use only the longest stretch of even loudness");
  p->add_option("--part", page->options.part, "Use only the longest run-up, idle, load or run-down");
  p->footer("The page is one file and fetches nothing.\nExample:\n  typodont sound page drill.wav --out drill.html");
  p->callback([page] { run_page(*page); });
}

}  // namespace typodont
