// A headset in a live session, on its own thread. The headset's runtime is software of other vendors. If it hangs or
// crashes, the session must still end properly: with zero force and a complete recording.
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
#include "engine/session/session_data.h"
#include "engine/session/strings.h"

namespace typodont {

class XrSession {
 public:
  struct Options {
    int tool_hand = -1;  // controller holding the tool: 0 left, 1 right; −1: another device
    bool debris = false;
    std::string quality;    // quality level's name; empty: chosen from the frames' drawing times
    bool touches = false;   // true: the trigger captures pairs of points for `calibrate register`
    dvec3 work_W{0, 0, 0};  // m, frame W: the point that recentring puts in front of the user
    ServoTick start;        // state of the tool before the first tick
    bool force_in_hud = true;
    session::WarningLevels warnings;                           // levels of the warnings; empty: none
    session::Language language = session::Language::kEnglish;  // language of the text over the picture
  };
  /// Opens the headset, and returns when it is awake and accepts frames. Throws Error with one line of text if the
  /// headset is missing or asleep, or if its runtime does not answer.
  XrSession(const display::DisplayRig& rig, const Scene& scene, const haptics::TissueVolume& tissue, Wiring& wiring,
            const Options& options);
  ~XrSession();
  XrSession(const XrSession&) = delete;
  XrSession& operator=(const XrSession&) = delete;

  // The thread that runs the session calls step() and the next functions. step() returns false if the user has ended
  // the session. It throws RunFailure if the runtime is lost or has not answered for `stall_s` (rig file).
  bool step();
  /// Sets a line of text over the picture.
  void say(std::string notice);
  /// Ends the session with the runtime. If the headset's thread hangs in a call of the runtime, the thread is
  /// abandoned.
  void stop();
  std::uint64_t frames() const;
  std::vector<std::string> explanations() const;
  /// Text about the quality level and what would improve the picture; empty: the level is good and did not change.
  std::string quality_notice() const;
  /// GPU times and late frames since the first tick, as lines of text. Call after stop(). Empty if the thread hangs.
  std::vector<std::string> report() const;
  /// The mass balance of the chips. Call after stop(). Empty if there were no chips or if the thread hangs.
  std::optional<DebrisBalance> debris() const;
  /// Adds the counters of the headset's thread to `work`. Call after stop(). Does nothing if the thread hangs.
  void add_work(WorkCounts& work) const;
  /// One physical point, measured in two frames: with the head of the tool that an arm holds (p_H), and with the tip of
  /// the controller (p_D).
  struct Touch {
    dvec3 p_H, p_D;  // m, position of the point: p_H in frame H of the arm's base, p_D in frame D of the headset
  };
  std::vector<Touch> touches() const;

 private:
  struct Thread;
  std::shared_ptr<Thread> thread_;
  double stall_;  // s, time without an answer of the runtime after which the session ends
};

/// Writes the captured pairs of points to a file for `calibrate register --pairs`. Throws Error if it cannot be
/// written.
void write_touches(const std::filesystem::path& file, std::span<const XrSession::Touch> touches);

}  // namespace typodont
