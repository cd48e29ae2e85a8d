#include "engine/app/offline.h"

#include <optional>

#include "engine/app/haptic_loop.h"
#include "engine/app/recording/replay_hand.h"
#include "engine/app/recording/resume.h"
#include "engine/app/session_recorder.h"
#include "engine/base/error.h"
#include "engine/session/recorder.h"
#include "haptics/scripted_hand.h"

namespace typodont {

std::unique_ptr<haptics::HapticDevice> open_offline_hand(const Scene& scene, const std::string& address, double rate) {
  if (address.starts_with("replay:"))
    return open_replay_hand(session::SessionReader(address.substr(7)), rate, /*paced=*/false);
  const std::string file = address.starts_with("script:") ? address.substr(7) : address;
  return haptics::open_scripted_hand(file, rate, /*paced=*/false, tool_names(scene));
}

haptics::LockStep load_lock_step(const Scene& scene, const haptics::DeviceInfo& hand) {
  return lock_step_for(scene, load_tissue(scene), hand);
}

struct OfflineRecording::Impl {
  session::SessionWriter writer;
  TickNotes notes;
};

namespace {

session::SessionHeader header_of(const Scene& scene, const haptics::DeviceInfo& hand,
                                 const haptics::TissueVolume& tissue, const std::string& trainee) {
  session::SessionHeader header = session_header(scene, {}, hand, tissue, hand.rate);
  header.trainee = trainee;
  header.date.clear();
  return header;
}

session::WriterOptions whole_or_nothing() {
  session::WriterOptions options;
  options.whole_or_nothing = true;
  return options;
}

}  // namespace

OfflineRecording::OfflineRecording(const std::filesystem::path& file, const Scene& scene,
                                   const haptics::DeviceInfo& hand, const haptics::TissueVolume& tissue,
                                   const std::string& trainee)
    : impl_(new Impl{{file, header_of(scene, hand, tissue, trainee), whole_or_nothing()}, {scene, std::nullopt}}) {}
OfflineRecording::~OfflineRecording() = default;

void OfflineRecording::add(const ServoTick& tick, const Cut* cut, const PatchUse* patch) {
  if (patch) impl_->writer.append({patch, 1});
  if (cut) impl_->writer.append({cut, 1});
  impl_->writer.append({&tick, 1});
  impl_->notes.add(tick, impl_->writer);
}

void OfflineRecording::add(const LoosePiece& piece) {
  impl_->writer.append(event_of(piece));
}

void OfflineRecording::add(const StrokeEdit& edit) {
  impl_->writer.append(event_of(edit));
}

std::uint64_t OfflineRecording::finish(const haptics::TissueVolume& tissue) {
  const session::SessionResult result = session_result(tissue);
  if (!impl_->writer.finish(result)) throw RunFailure(impl_->writer.status().message);
  return result.field_hash;
}

}  // namespace typodont
