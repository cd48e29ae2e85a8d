// A headset in a live session, on a thread of its own: a runtime is somebody else's program, and when it hangs or dies
// the rest of the session must still end in order, with zero force and a whole recording.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/app/scene.h"
#include "engine/app/wiring.h"
#include "engine/app/work_counts.h"
#include "engine/debris/debris.h"
#include "engine/display/display_rig.h"

namespace typodont {

class XrSession {
 public:
  struct Options {
    int tool_hand = -1;  // 0 left, 1 right: the controller that holds the tool; −1: something else does
    bool debris = false, record = false;
    bool touches = false;   // the trigger takes a pair of points for `calibrate register`
    dvec3 work_W{0, 0, 0};  // m: what recentring puts before the user
    ServoTick start;        // the tool before the first tick
  };
  /// Returns when the headset is awake and takes frames. Throws Error in one line where it is not there, asleep, or its
  /// runtime does not answer.
  XrSession(const display::DisplayRig& rig, const Scene& scene, const haptics::TissueVolume& tissue, Wiring& wiring,
            const Options& options);
  ~XrSession();
  XrSession(const XrSession&) = delete;
  XrSession& operator=(const XrSession&) = delete;

  // The session's own thread.
  /// The zero of recorded times.
  void start(Nanos began);
  /// Looks after the headset. False when the user ended the session; throws RunFailure when the runtime was lost or has
  /// not answered for the rig's stall_s.
  bool step();
  /// Ends the session with the runtime; gives a thread up that hangs in it.
  void stop();
  std::uint64_t frames() const;
  std::vector<std::string> explanations() const;
  /// Once it has stopped: where the mass of the chips went. Nothing: it had none, or hangs.
  std::optional<debris::DebrisLedger> debris() const;
  /// Once it has stopped: adds what its thread drew and moved. Nothing where it hangs.
  void add_work(WorkCounts& work) const;
  /// The tool's head, held by an arm, and a controller's tip at one place: in the arm's base H and the headset's space
  /// D.
  struct Touch {
    dvec3 p_H, p_D;  // m
  };
  std::vector<Touch> touches() const;

 private:
  struct Thread;
  std::shared_ptr<Thread> thread_;
  double stall_;  // s
};

/// As `calibrate register --pairs` reads them. Throws Error where the file cannot be written.
void write_touches(const std::filesystem::path& file, std::span<const XrSession::Touch> touches);

}  // namespace typodont
