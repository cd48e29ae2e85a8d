// Runs a session without clock, threads and pictures. Used by `typodont servo` and by programs that use the library.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "engine/app/scene.h"
#include "engine/app/wiring.h"
#include "haptics/haptic_device.h"
#include "haptics/lockstep.h"

namespace typodont {

/// Opens a hand whose motion is equal in every run: HAND.csv or HAND.json (also after "script:"), or replay:SESSION.h5.
/// The hand does not wait for the real time of its samples. Throws Error.
std::unique_ptr<haptics::HapticDevice> open_offline_hand(const Scene& scene, const std::string& address, double rate);

/// Loads the scene's tissue. Sets up servo and carver (which updates the tissue) for this hand. Throws Error.
haptics::LockStep load_lock_step(const Scene& scene, const haptics::DeviceInfo& hand);

/// Writes a session file (.h5). The file exists only after finish() has succeeded.
class OfflineRecording {
 public:
  /// Creates the recording. The same input gives the same bytes, because no date is written. Throws Error.
  OfflineRecording(const std::filesystem::path& file, const Scene& scene, const haptics::DeviceInfo& hand,
                   const haptics::TissueVolume& tissue, const std::string& trainee = {});
  ~OfflineRecording();
  OfflineRecording(const OfflineRecording&) = delete;
  OfflineRecording& operator=(const OfflineRecording&) = delete;

  /// Adds a tick. `cut`: its cut, or null. `patch`: the new copy of the tissue that the tick uses, or null.
  void add(const ServoTick& tick, const Cut* cut, const PatchUse* patch);
  void add(const LoosePiece& piece);
  void add(const StrokeEdit& edit);
  /// Completes the file and returns the hash of the tissue. Throws RunFailure if the file cannot be completed.
  std::uint64_t finish(const haptics::TissueVolume& tissue);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont
