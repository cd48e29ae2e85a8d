// A serial WoodenHaptics board in real time behind a pseudo terminal, for the whole program: the emulated firmware of
// emulated_arm.h on a thread, with everything that can go wrong with it.
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
  /// `port`: a link that will point to the terminal, so that the board keeps its address when it is plugged in again.
  LiveBoard(std::filesystem::path port, haptics::Arm arm);
  ~LiveBoard();
  LiveBoard(const LiveBoard&) = delete;
  LiveBoard& operator=(const LiveBoard&) = delete;

  void plug_in();
  void unplug();
  /// The arm's tip, m in H, by seconds from now on (or since it was plugged in); at first it must rest at home(). Any
  /// thread.
  void hold(std::function<dvec3(double)> tip);
  dvec3 home() const;
  /// Does something to the emulated board, between two of its milliseconds.
  void with(const std::function<void(EmulatedArm&)>& what);

  double current() const { return current_.load(); }     // A, the largest of the motors'
  std::uint64_t lines() const { return lines_.load(); }  // commands that came since it was plugged in
  /// s, of the board's own clock: it stands still while this machine keeps the board waiting, and so does the hand that
  /// holds the arm. What a test waits for it counts in these.
  double time() const { return now_.load(); }
  /// Waits until that has come to be, at most so long by the board's clock; false: it did not.
  bool wait_for(const std::function<bool()>& what, double seconds = 60) const;
  void pass(double seconds) const {
    wait_for([] { return false; }, seconds);
  }
  /// Whether the motors are let go, sooner or later. The firmware lets go by itself only where it is told to
  /// (EmulatedArm::watchdog).
  bool lets_go() const {
    return wait_for([this] { return current() == 0; });
  }
  /// The largest current seen since the last call, A.
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
  double began_ = 0;  // s, of the simulated time: when it was plugged in or last told how to move
  haptics::Descriptor master_, slave_;
  std::atomic<double> current_{0}, worst_{0}, now_{0};
  std::atomic<std::uint64_t> lines_{0};
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace typodont::test
