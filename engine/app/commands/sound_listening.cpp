#include "engine/app/commands/sound_listening.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <random>

#include "audio/ar_fit.h"
#include "audio/compare.h"
#include "audio/drill_synth.h"
#include "audio/sound_file.h"
#include "engine/app/commands/command_line.h"
#include "engine/app/experiment/abx.h"
#include "engine/app/sound_picture.h"
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

/// Synthesizes the sound of a model. `ratios`: speeds of the spindle at `times` (s), divided by the speed of the model.
/// Empty: the speed is constant.
std::vector<double> sound_of(const audio::ArModel& model, std::span<const double> times, std::span<const double> ratios,
                             double seconds) {
  audio::SoundModels models;
  models.idle = model;
  models.free_speed = model.spindle > 0 ? model.spindle : 100 * kKrpm;
  audio::DrillSynth synth(models, model.rate, 1);
  audio::SoundState state;
  state.spindle = models.free_speed;
  synth.push(state);
  constexpr double kEvery = 0.01;  // s, time between two states of the drill that are passed to the synthesizer
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

// s, duration of the model's sound that is measured. It is long, so that the random noise of the model hardly changes
// the measured spectrum.
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

struct AbxCommand {
  std::vector<std::string> sounds;
  std::string out, key, answers;
  int trials = 16;
  double excerpt = 1.5;  // s, duration of an excerpt that the listener hears
  std::uint64_t seed = 0;
};

/// Cuts a part out of a sound. All parts get the same loudness, and a fade at both ends prevents clicks.
std::vector<double> excerpt_of(std::span<const double> x, double rate, double from, double seconds) {
  constexpr double kLoudness = 0.1;  // root mean square of the samples after scaling; full scale is 1
  constexpr double kFade = 0.02;     // s, duration of the fade-in and of the fade-out of an excerpt
  const auto first = static_cast<std::size_t>(from * rate), count = static_cast<std::size_t>(seconds * rate);
  std::vector<double> y(x.begin() + static_cast<std::ptrdiff_t>(first),
                        x.begin() + static_cast<std::ptrdiff_t>(std::min(x.size(), first + count)));
  const double power = std::inner_product(y.begin(), y.end(), y.begin(), 0.0) / static_cast<double>(y.size());
  for (std::size_t i = 0; i < y.size(); ++i) {
    const double from_end = static_cast<double>(std::min(i, y.size() - 1 - i)) / (kFade * rate);
    y[i] *= kLoudness / std::sqrt(power + 1e-12) * std::min(1.0, from_end);
  }
  return y;
}

void make_abx(const AbxCommand& c) {
  if (c.trials < 1 || c.trials > 100) throw Error("--trials", "", fmt::to_string(c.trials), "1 to 100");
  if (!(c.excerpt >= 0.2 && c.excerpt <= 20)) throw Error("--excerpt", "", fmt::to_string(c.excerpt), "0.2 to 20 s");
  const std::uint64_t seed = c.seed != 0 ? c.seed : std::random_device{}();
  std::vector<std::vector<double>> whole;
  std::vector<double> rates;
  for (const std::string& file : c.sounds) {
    const audio::Recording sound = audio::read_recording(file);
    whole.push_back(sound.mono());
    rates.push_back(sound.rate);
    if (static_cast<double>(sound.length()) < c.excerpt * sound.rate)
      throw Error(file, "", fmt::format("{:.2f} s", static_cast<double>(sound.length()) / sound.rate),
                  fmt::format("at least {} s, or a shorter --excerpt", c.excerpt));
  }
  const AbxKey key = abx_key(c.sounds[0], c.sounds[1], c.trials, seed);
  std::mt19937_64 random(seed ^ 0xabc);
  const TemporaryFolder folder;
  std::vector<std::vector<std::uint8_t>> sounds;
  const auto add = [&](std::size_t which) {
    const double last = static_cast<double>(whole[which].size()) / rates[which] - c.excerpt;
    const double from = std::max(0.0, last) * static_cast<double>(random() >> 11) * 0x1p-53;
    const auto file = folder.path() / "part.wav";
    write_wav(file, excerpt_of(whole[which], rates[which], from, c.excerpt), rates[which]);
    sounds.push_back(bytes_of(file));
    std::filesystem::remove(file);
  };
  add(0);
  add(1);
  for (const bool b : key.x_is_b) add(b ? 1 : 0);
  write_file_atomically(c.key, to_json(key), FileKind::kJson);
  write_file_atomically(c.out, abx_page(key, sounds), FileKind::kPage);
  fmt::print("{}: {} trials; keep {} away from the listener\n", c.out, c.trials, c.key);
}

void run_abx(const AbxCommand& c) {
  if (!c.answers.empty()) {
    if (c.key.empty()) throw Error("--key", "", "nothing", "the key that was written with the page");
    const AbxKey key = load_abx_key(c.key);
    const AbxResult result = judge(key, load_abx_answers(c.answers, key.x_is_b.size()));
    fmt::print("{} of {} right, {:.0f} % ({:.0f} to {:.0f} %); by chance with a probability of {:.3g}\n", result.right,
               result.trials, 100 * result.fraction.value, 100 * result.fraction.low, 100 * result.fraction.high,
               result.chance);
    return;
  }
  if (c.sounds.size() != 2) throw Error("sounds", "", fmt::to_string(c.sounds.size()), "two sound files, or --answers");
  if (c.out.empty() || c.key.empty()) throw Error(c.out.empty() ? "--out" : "--key", "", "nothing", "a file to write");
  make_abx(c);
}

}  // namespace

void add_sound_page_command(cli::Command& sound) {
  auto page = std::make_shared<PageCommand>();
  cli::Command* p = sound.add_command("page", "Write a page with a recording and its model side by side");
  p->add_option("recording", page->recording, "Recording (WAV, FLAC, OGG, AIFF)")->required();
  p->add_option("--out", page->out, "Page to write (.html)")->required()->check(cli::writes({FileKind::kPage}));
  p->add_option("--model", page->model, "Model file (default: fitted to the recording)");
  p->add_option("--seconds", page->seconds, "Longest part that is played")->show_default();
  p->add_option("--up-to-hz", page->up_to, "Highest frequency shown")->show_default();
  p->add_flag("--steady", page->options.steady, "Use only the longest stretch of even loudness");
  p->add_option("--part", page->options.part, "Use only the longest run-up, idle, load or run-down");
  p->footer("The page is one file and fetches nothing.\nExample:\n  typodont sound page drill.wav --out drill.html");
  p->callback([page] { run_page(*page); });
}

void add_sound_abx_command(cli::Command& sound) {
  auto abx = std::make_shared<AbxCommand>();
  cli::Command* a = sound.add_command("abx", "Blind listening: can a person tell two sounds apart?");
  a->add_option("sounds", abx->sounds, "Two sound files, A and B");
  a->add_option("--out", abx->out, "Page for the listener to write (.html)")->check(cli::writes({FileKind::kPage}));
  a->add_option("--key", abx->key, "Key (.json): written with the page, read with --answers");
  a->add_option("--answers", abx->answers, "The listener's answers: prints how many are right");
  a->add_option("--trials", abx->trials, "Number of trials")->show_default();
  a->add_option("--excerpt", abx->excerpt, "Length of each sound, s")->show_default();
  a->add_option("--seed", abx->seed, "Seed of the random order (default: another one each time)");
  a->footer(
      "The page is one file and fetches nothing; which sound each X is stands only in the key.\n"
      "Example:\n  typodont sound abx drill.wav model.wav --out abx.html --key key.json\n"
      "  typodont sound abx --key key.json --answers answers.txt");
  a->callback([abx] { run_abx(*abx); });
}

}  // namespace typodont
