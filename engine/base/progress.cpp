#include "engine/base/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "engine/base/log.h"

namespace typodont {

namespace {

constexpr Nanos kPatience = kNanosPerSecond;  // ns; no line is shown for work that is shorter than this

std::atomic<Progress*> g_on_terminal{nullptr};  // the work that an interrupt cancels

void interrupted(int) {
  Progress* const work = g_on_terminal.load();
  if (!work || work->cancelled()) end_now();  // a second interrupt ends the program at once
  work->cancel();
}

}  // namespace

Progress::Progress(std::string_view line) : line_(line), began_(now()), terminal_(isatty(STDERR_FILENO) != 0) {
  g_on_terminal = this;
  on_interrupt_.emplace(interrupted);
}

Progress::~Progress() {
  if (line_.empty()) return;
  on_interrupt_.reset();
  g_on_terminal = nullptr;
  if (terminal_ && shown_ >= 0) log::raw("\n");
}

void Progress::stage(const char* what, double from, double to) {
  from_ = from, to_ = to;
  what_.store(what, std::memory_order_relaxed);
  at(0);
}

void Progress::at(double fraction) {
  fraction_.store(from_ + std::clamp(fraction, 0.0, 1.0) * (to_ - from_), std::memory_order_relaxed);
  if (!line_.empty()) show();
  if (cancelled()) throw Cancelled();
}

void Progress::show() {
  const int percent = static_cast<int>(this->fraction() * 100.0);
  const int step = terminal_ ? percent : percent / 10 * 10;
  if (step == shown_ || now() - began_ < kPatience) return;
  shown_ = step;
  const double done = this->fraction(), passed = to_seconds(now() - began_);
  constexpr double kMin = 0.01;  // smallest finished fraction for which the time left is shown
  const std::string left = done > kMin && done < 1 ? fmt::format(", {:.0f} s left", passed * (1 - done) / done) : "";
  log::raw(terminal_ ? fmt::format("\r{}: {:3d} %{:14}", line_, step, left)
                     : fmt::format("{}: {} %{}\n", line_, step, left));
}

}  // namespace typodont
