#include "tests/support/emulation/live_board.h"

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "engine/base/realtime.h"
#include "engine/base/units.h"

namespace typodont::test {

namespace {

/// Returns the angles that put the tip of a serial arm at `tip` with the elbow up. Uses the law of cosines for the two
/// links.
dvec3 angles_for(const haptics::Arm& arm, const dvec3& tip) {
  const double upper = arm.geometry.upper, fore = arm.geometry.fore;
  const dvec3 p = tip + arm.geometry.origin;
  const double r = std::hypot(p.x, p.y), w = p.z - arm.geometry.base, d2 = r * r + w * w, d = std::sqrt(d2);
  const double phi = std::atan2(r, w);
  const double alpha = std::acos((upper * upper + d2 - fore * fore) / (2 * upper * d));
  const double beta = std::acos((fore * fore + d2 - upper * upper) / (2 * fore * d));
  return {std::atan2(p.y, p.x), phi - alpha, kPi - (phi + beta)};
}

}  // namespace

LiveBoard::LiveBoard(std::filesystem::path port, haptics::Arm arm)
    : port_(std::move(port)), arm_(arm), board_(time_, haptics::ArmProtocol::kText, arm, 1), wire_(board_.connect()) {
  const dvec3 rest = home();
  tip_ = [rest](double) { return rest; };
  board_.hand = [this](double t) { return angles_for(arm_, tip_(t - began_)); };
  plug_in();
}

LiveBoard::~LiveBoard() {
  if (thread_.joinable()) unplug();
}

dvec3 LiveBoard::home() const {
  return haptics::stylus_position(arm_, haptics::body_angles(arm_, arm_.home));
}

void LiveBoard::plug_in() {
  int master, slave;
  char name[128];
  if (::openpty(&master, &slave, name, nullptr, nullptr) != 0) std::abort();
  // While no program reads, the line is full after a second. Then the board drops its reports, as a real one does. If
  // it waited instead, its clock would stop for ever after a program has ended.
  ::fcntl(master, F_SETFL, ::fcntl(master, F_GETFL) | O_NONBLOCK);
  master_ = haptics::Descriptor(master);
  slave_ = haptics::Descriptor(slave);  // kept open, so that a program that closes it does not close the line
  std::error_code code;
  std::filesystem::remove(port_, code);
  std::filesystem::create_symlink(name, port_);
  board_.unplugged = false;
  began_ = to_seconds(time_.true_now());
  lines_ = 0;
  ending_ = false;
  thread_ = std::thread([this] { serve(); });
}

void LiveBoard::unplug() {
  ending_ = true;
  thread_.join();
  board_.unplugged = true;
  time_.advance(1'000'000);
  current_ = 0;
  std::error_code code;
  std::filesystem::remove(port_, code);
  slave_ = haptics::Descriptor();
  master_ = haptics::Descriptor();
}

void LiveBoard::hold(std::function<dvec3(double)> tip) {
  const std::lock_guard lock(mutex_);
  tip_ = std::move(tip);
  began_ = to_seconds(time_.true_now());
}

void LiveBoard::with(const std::function<void(EmulatedArm&)>& what) {
  const std::lock_guard lock(mutex_);
  what(board_);
}

void LiveBoard::serve() {
  enter_realtime({.priority = 82, .core = -1, .lock_memory = false});  // the firmware must not be late
  std::string in, out;
  Nanos real = now() - time_.true_now();
  while (!ending_) {
    char buffer[512];
    pollfd waiting{master_.get(), POLLIN, 0};
    while (::poll(&waiting, 1, 0) > 0 && (waiting.revents & POLLIN)) {
      const ssize_t n = ::read(master_.get(), buffer, sizeof buffer);
      if (n <= 0) break;
      in.append(buffer, static_cast<std::size_t>(n));
    }
    std::uint8_t report[256];
    int n = 0;
    {
      const std::lock_guard lock(mutex_);
      for (std::size_t end; (end = in.find('\n')) != std::string::npos; in.erase(0, end + 1)) {
        wire_->write({reinterpret_cast<const std::uint8_t*>(in.data()), end + 1});
        ++lines_;
      }
      n = wire_->read(report, 1'000'000);  // until the next simulated millisecond
      double most = 0;
      for (int i = 0; i < 3; ++i) most = std::max(most, std::abs(board_.amperes()[i]));
      current_ = most;
      now_ = to_seconds(time_.true_now());
      if (most > worst_) worst_ = most;
    }
    if (n > 0 && out.empty()) out.assign(report, report + n);
    // The rest of a report for which the line has no room is sent later.
    if (const ssize_t sent = ::write(master_.get(), out.data(), out.size()); sent > 0)
      out.erase(0, static_cast<std::size_t>(sent));
    // A delayed board does not catch up, because the hand would jump.
    real = std::max(real, now() - time_.true_now() - 2'000'000);
    sleep_until(real + time_.true_now());
  }
}

bool LiveBoard::wait_for(const std::function<bool()>& what, double seconds) const {
  for (const double end = time() + seconds; time() < end; ::usleep(300)) {
    if (what()) return true;
  }
  return what();
}

}  // namespace typodont::test
