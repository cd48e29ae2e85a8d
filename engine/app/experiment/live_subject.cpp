#include "engine/app/experiment/live_subject.h"

#include <fmt/format.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>

#include "engine/app/picture/hud.h"
#include "engine/base/clock.h"
#include "engine/base/log.h"
#include "engine/display/keys.h"
#include "haptics/device_safety.h"

namespace typodont {

namespace {

constexpr double kFree = 0.3;  // s, time without contact before the next stimulus may begin

/// Reads answers from standard input without blocking.
class TypedAnswers {
 public:
  /// Discards text that the user typed before the question was shown. Text from a pipe is kept.
  void forget() {
    if (::isatty(STDIN_FILENO)) ::tcflush(STDIN_FILENO, TCIFLUSH), text_.clear();
  }
  std::optional<Answer> next() {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    char buffer[256];
    while (!ended_ && text_.find_first_of("12") == std::string::npos && ::poll(&input, 1, 0) > 0) {
      const ssize_t n = ::read(STDIN_FILENO, buffer, sizeof buffer);
      if (n > 0) text_.append(buffer, static_cast<std::size_t>(n));
      ended_ = n <= 0;
    }
    const std::size_t at = text_.find_first_of("12");
    if (at == std::string::npos) {
      text_.clear();
      return std::nullopt;
    }
    const Answer answer = text_[at] == '1' ? Answer::kFirst : Answer::kSecond;
    text_.erase(0, at + 1);
    return answer;
  }
  bool ended() const { return ended_ && text_.empty(); }

 private:
  std::string text_;
  bool ended_ = false;
};

}  // namespace

struct LiveSubject::Impl {
  Scene scene;
  Options options;
  // Scene with the contact model of the running session. The session
  // keeps a reference to this object, which must therefore outlive it.
  Scene shown;
  std::string model;  // name of the contact model of the session
  std::optional<Workbench> bench;
  TypedAnswers typed;

  Impl(const Scene& s, const Options& o) : scene(s), options(o) {
    scene.servo.cutting = false;
    options.workbench.steered = true;
    options.workbench.max_delay = options.max_delay;
  }

  /// Shows the message catalogue's text for `key` in the window, and prints it in English on the terminal.
  void say(std::string_view key, const std::string& value = {}) {
    bench->say(hud_text(options.workbench.language, key, value));
    log::info("{}", hud_text(session::Language::kEnglish, key, value));
  }

  void open(const std::string& wanted) {
    if (bench && model == wanted) return;
    if (bench) bench->stop(), bench.reset();
    Scene with_model = scene;
    choose_model(with_model, wanted);
    shown = std::move(with_model);
    model = wanted;
    haptics::set_emergency_stop(false);  // ends an emergency stop of the session before
    bench.emplace(shown, options.workbench);
    bench->start();
  }

  /// Waits until the tool has had no contact for the time kFree. False if the session has ended.
  bool wait_until_free() {
    Nanos since = now();
    bool told = false;
    for (;;) {
      if (!bench->step()) return false;
      const ServoTick tick = bench->status().tick;
      if (tick.depth > 0 || tick.f_T_W != dvec3(0)) {
        since = now();
        if (!told) say("lift");
        told = true;
      }
      if (to_seconds(now() - since) >= kFree && tick.index > 0) return true;
    }
  }

  bool show(const Stimulus& stimulus, std::string_view key, const std::string& trial) {
    open(stimulus.model);
    if (!wait_until_free()) return false;
    SessionSettings settings = bench->settings();
    settings.stiffness = SessionSettings::every_tissue(stimulus.stiffness_ratio);
    settings.force_fraction = stimulus.force_fraction;
    settings.force_delay = from_seconds(stimulus.delay);
    bench->set(settings);
    say(key, trial);
    const Nanos began = now();
    while (to_seconds(now() - began) < options.seconds)
      if (!bench->step()) return false;
    return true;
  }

  /// Shows the question in the window, and prints it in English on the terminal.
  void ask() {
    const auto question = [&](session::Language language) {
      return fmt::format("{}{}{}", words_of(options.question, language), kHudGap, hud_text(language, "answer"));
    };
    bench->say(question(options.workbench.language));
    log::info("{}", question(session::Language::kEnglish));
  }

  std::optional<Given> wait_for_answer() {
    typed.forget();
    const Nanos asked = now();
    while (bench->step()) {
      std::optional<Answer> answer = typed.next();
      for (const int key : bench->pressed()) {
        if (key == display::keys::kLeft) answer = Answer::kFirst;
        if (key == display::keys::kRight) answer = Answer::kSecond;
      }
      if (answer) return Given{*answer, to_seconds(now() - asked)};
      if (typed.ended() && !bench->stage()) {
        log::warn("standard input has ended, and there is no window: nobody can answer");
        return std::nullopt;
      }
    }
    return std::nullopt;
  }
};

LiveSubject::LiveSubject(const Scene& scene, const Options& options) : impl_(std::make_unique<Impl>(scene, options)) {}
LiveSubject::~LiveSubject() = default;

std::optional<LiveSubject::Given> LiveSubject::ask(const Trial& trial, const std::string& of) {
  constexpr std::array<std::string_view, 2> kTexts{"feel_first", "feel_second"};
  for (std::size_t i = 0; i < 2; ++i)
    if (!impl_->show(trial.stimuli[i], kTexts[i], of)) return std::nullopt;
  impl_->ask();
  return impl_->wait_for_answer();
}

void LiveSubject::stop() {
  if (impl_->bench) impl_->bench->stop(), impl_->bench.reset();
}

}  // namespace typodont
