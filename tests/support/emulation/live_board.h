// Emulates a serial WoodenHaptics board in real time behind a pseudo-terminal, for tests of the whole program. A thread
// runs the firmware of emulated_arm.h. All errors of that emulation can be injected.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "haptics/devices/fd_link.h"
#include "tests/support/emulation/emulated_arm.h"

namespace typodont::test {

class LiveBoard {
 public:
  /// `port`: path of a symbolic link to the terminal. So the board keeps its address when it is reconnected.
  LiveBoard(std::filesystem::path port, haptics::Arm arm);
  ~LiveBoard();
  LiveBoard(const LiveBoard&) = delete;
  LiveBoard& operator=(const LiveBoard&) = delete;

  void plug_in();
  void unplug();
  /// Moves the arm's tip. `tip`: position in frame H (m) as a function of the seconds from now, or from the connection.
  /// It must start at rest at home(). May be called from any thread.
  void hold(std::function<dvec3(double)> tip);
  dvec3 home() const;
  /// Calls `what` on the emulated board, between two of its milliseconds.
  void with(const std::function<void(EmulatedArm&)>& what);

  double current() const { return current_.load(); }     // A, the largest of the motors' currents
  std::uint64_t lines() const { return lines_.load(); }  // number of commands since it was connected
  /// Time in s on the board's own clock. The clock and the hand that holds the arm stop while this machine delays the
  /// board. Tests measure waiting times with it.
  double time() const { return now_.load(); }
  /// Waits until `what` returns true, but not longer than `seconds` on the board's clock. Returns false if the time is
  /// over.
  bool wait_for(const std::function<bool()>& what, double seconds = 60) const;
  void pass(double seconds) const {
    wait_for([] { return false; }, seconds);
  }
  /// Returns true if the motors are off.
  bool lets_go() const {
    return wait_for([this] { return current() == 0; });
  }
  /// Returns the largest current (A) since the last call.
  double take_worst() { return worst_.exchange(0); }

 private:
  void serve();

  std::filesystem::path port_;
  haptics::Arm arm_;
  std::mutex mutex_;
  SimTime time_;
  EmulatedArm board_;
  std::unique_ptr<haptics::Link> wire_;
  std::function<dvec3(double)> tip_;
  double began_ = 0;  // s of simulated time at which it was connected or last got a motion
  haptics::Descriptor master_, slave_;
  std::atomic<double> current_{0}, worst_{0}, now_{0};
  std::atomic<std::uint64_t> lines_{0};
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace typodont::test
