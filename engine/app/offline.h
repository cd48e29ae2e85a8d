// A session without clock, threads and pictures: what `typodont servo` and the programs that use the library share.
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

/// A hand that moves by itself and always the same: HAND.csv, HAND.json (also after "script:"), replay:SESSION.h5. Not
/// paced by a clock. Throws Error.
std::unique_ptr<haptics::HapticDevice> open_offline_hand(const Scene& scene, const std::string& address, double rate);

/// Loads the scene's tissue. The servo is set up for this hand. Throws Error.
haptics::LockStep load_lock_step(const Scene& scene, const haptics::DeviceInfo& hand);

/// A session file (.h5) that appears when it is finished, or not at all.
class OfflineRecording {
 public:
  /// The same input makes the same bytes: no date is written. Throws Error.
  OfflineRecording(const std::filesystem::path& file, const Scene& scene, const haptics::DeviceInfo& hand,
                   const haptics::TissueVolume& tissue, const std::string& trainee = {});
  ~OfflineRecording();
  OfflineRecording(const OfflineRecording&) = delete;
  OfflineRecording& operator=(const OfflineRecording&) = delete;

  /// A tick with what it cut and the patch that was taken up before it; null: none.
  void add(const ServoTick& tick, const Cut* cut, const PatchUse* patch);
  void add(const LoosePiece& piece);
  void add(const StrokeEdit& edit);
  /// The hash of the tissue. Throws RunFailure where something is missing.
  std::uint64_t finish(const haptics::TissueVolume& tissue);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont
