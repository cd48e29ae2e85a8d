// A headset in a live session, on its own thread. The runtime is foreign code; if it hangs or dies, the remaining
// session must still end properly, with zero force and a complete recording.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/app/picture/debris_view.h"
#include "engine/app/scene.h"
#include "engine/app/wiring.h"
#include "engine/app/work_counts.h"
#include "engine/display/display_rig.h"

namespace typodont {

class XrSession {
 public:
  struct Options {
    int tool_hand = -1;  // 0 left, 1 right: the controller that holds the tool; −1: another device holds it
    bool debris = false, record = false;
    bool touches = false;   // the user's trigger takes a pair of points for `calibrate register`
    dvec3 work_W{0, 0, 0};  // m: the point that recentring places in front of the user
    ServoTick start;        // state of the tool before the first tick
  };
  /// Opens the headset. Returns when it is awake and accepts frames. Throws Error in one line if the headset is
  /// missing or asleep, or if its runtime does not answer.
  XrSession(const display::DisplayRig& rig, const Scene& scene, const haptics::TissueVolume& tissue, Wiring& wiring,
            const Options& options);
  ~XrSession();
  XrSession(const XrSession&) = delete;
  XrSession& operator=(const XrSession&) = delete;

  // Functions for the session's own thread.
  /// Starts to record the frames' times, if this is enabled in the options. `began`: time of the session's start.
  void start(Nanos began);
  /// Supervises the headset. Returns false if the user ended the session. Throws RunFailure if the runtime was lost
  /// or has not answered for the rig's stall_s.
  bool step();
  /// Ends the session with the runtime. If the headset's thread hangs in the runtime, abandons the thread.
  void stop();
  std::uint64_t frames() const;
  std::vector<std::string> explanations() const;
  /// Returns the balance of the chips' mass. Call this function after stop(). Empty if there were no chips or the
  /// thread hangs.
  std::optional<DebrisBalance> debris() const;
  /// Adds the work of the headset's thread to `work`. Call this function after stop(). Does nothing if the thread
  /// hangs.
  void add_work(WorkCounts& work) const;
  /// One physical point, measured in two frames: as the head of the tool that an arm holds (p_H, in the frame H of the
  /// arm's base) and as the tip of the controller (p_D, in the headset's space D).
  struct Touch {
    dvec3 p_H, p_D;  // m
  };
  std::vector<Touch> touches() const;

 private:
  struct Thread;
  std::shared_ptr<Thread> thread_;
  double stall_;  // s without an answer of the runtime after which the session ends
};

/// Writes the file for `calibrate register --pairs`. Throws Error if the file cannot be written.
void write_touches(const std::filesystem::path& file, std::span<const XrSession::Touch> touches);

}  // namespace typodont
