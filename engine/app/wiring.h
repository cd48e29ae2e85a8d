// All channels between the threads of a session: event logs, which any thread may read, and channels with one writer
// and one reader. "Render thread": the thread that draws the trainee's picture. "User interface": the operator's
// window.
#pragma once

#include <array>
#include <atomic>
#include <vector>

#include "engine/app/event_logs.h"
#include "engine/app/tissue/paint_file.h"
#include "engine/base/latest.h"
#include "engine/base/ring.h"
#include "engine/render/renderer.h"
#include "haptics/patch_exchange.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// Changed mesh bricks. The carver thread meshes them; the renderer uploads them and then deletes the list.
using MeshBatch = std::vector<render::MeshUpdate>;

/// Settings that may change during a session. They change inputs and outputs of the servo. A recording does not contain
/// the settings, but its ticks contain the changed values, so a replay is exact.
struct SessionSettings {
  double speed_fraction = 1;  // 0..1, factor on the pedal's position, which sets the drill's speed
  bool backwards = false;     // true: the handpiece turns backwards; only for threaded tools
  double force_fraction = 1;  // 0..1, factor on the force applied to the hand
  /// Factor on each tissue's stiffness; only for sessions without recording.
  PerTissue stiffness = every_tissue(1);
  /// Delay of the force at the hand, ns; only for sessions that can delay forces.
  Nanos force_delay = 0;

  static constexpr PerTissue every_tissue(double fraction) {
    PerTissue all{};
    for (double& v : all) v = fraction;
    return all;
  }
  /// The stiffness (N/m) of each tissue multiplied by the factors in these settings, for Servo::set_stiffness().
  PerTissue stiffness_of(const MaterialTable& materials) const {
    PerTissue scaled{};
    for (std::size_t i = 0; i < scaled.size(); ++i) scaled[i] = stiffness[i] * materials[i].stiffness;
    return scaled;
  }
};

/// State of the recording, for the user interface.
struct RecordState {
  std::uint64_t ticks = 0, cuts = 0;
  bool complete = true;                   // true: no data was lost so far
  bool disk_low = false, failed = false;  // disk_low: the disk is nearly full; failed: recording has stopped
};

/// Latest sample of the headset's controller that moves the tool.
struct XrHandSample {
  Pose X_WT;
  double pedal = 0;      // 0..1, position of the trigger
  bool tracked = false;  // true: the headset can see the controller
  Nanos t = 0;
};

/// The user's commands about the tissue during a session.
enum class TissueCommand { kUndo, kRedo, kSave };

/// A part of an instructor's brush stroke.
struct BrushMove {
  PaintStroke stroke;
  bool begins = false;  // true: this part begins a new stroke
};

struct Wiring {
  explicit Wiring(const haptics::Carver& carver) : patch(carver) {}
  /// Frees the data that no thread has received.
  ~Wiring() {
    for (MeshBatch* batch = nullptr; bricks.pop(batch) || bricks_to_watch.pop(batch);) delete batch;
    for (haptics::TissueVolume* copy = nullptr; copies_to_watch.pop(copy);) delete copy;
  }
  Wiring(const Wiring&) = delete;
  Wiring& operator=(const Wiring&) = delete;

  // Events of all threads. Any thread may read them.
  EventLogs event_logs;
  // Carver thread → servo thread: newest copy of nearby tissue.
  haptics::PatchExchange patch;
  // User interface → carver thread: commands.
  Ring<TissueCommand> tissue_commands{64};
  // Carver thread → render thread: changed parts of the mesh.
  Ring<MeshBatch*> bricks{256};
  // Carver thread → user interface: changed parts of the tissue's mesh, if a headset shows the session and an operator
  // watches in a window.
  Ring<MeshBatch*> bricks_to_watch{256};
  // Carver thread → computing thread of LiveViews (live_views.h): requested copies of the tissue. The results go to the
  // user interface by a channel inside LiveViews.
  Ring<haptics::TissueVolume*> copies_to_watch{4};
  // Carver thread → planner thread of the expert (live_expert.h): copies of the tissue, if an expert (planned motion)
  // is the hand.
  Ring<haptics::TissueVolume*> copies_to_expert{2};
  // Render thread (window) → servo thread: sample of the hand, if the mouse is the hand.
  Latest<haptics::HandSample> pointer;
  // User interface → carver thread: moves of the brush with which an instructor paints tissue.
  Ring<BrushMove> paint_to_carver{1 << 10};
  // User interface → servo thread: settings that the user changed.
  Latest<SessionSettings> settings;
  // Recorder thread → user interface: state of the recording.
  Latest<RecordState> record_to_render;
  // Headset's thread → servo thread: samples of the controller, if the controller is the hand.
  Latest<XrHandSample> xr_hand;

  /// Computing thread of LiveViews → carver thread: request for a copy of the tissue.
  std::atomic<bool> copy_wanted{false};
  /// Planner thread of the expert → carver thread: request for a copy of the tissue.
  std::atomic<bool> expert_wants_copy{false};
  /// Carver thread → computing thread of LiveViews: number that increases whenever the tissue changes.
  std::atomic<std::uint64_t> tissue_version{0};
  std::atomic<std::uint32_t> saved{0},
      /// Saving thread → user interface: number of saves of the tissue that succeeded (`saved`) and that failed.
      not_saved{0};
  // Render thread → carver thread: tolerance of the mesh, voxels (picture/detail.h).
  std::atomic<float> tolerance{0.1f};
  std::array<std::atomic<bool>, 2>
      /// Render thread or headset's thread → carver thread: true if a picture shows the tissue; otherwise no surface is
      /// computed.
      tissue_in_sight{};
  /// Any thread → servo thread: zero force from the next tick on, then the end of the session.
  std::atomic<bool> emergency{false};
  // Render thread (window) → servo thread: index of the tool that the user chose by a key. Negative: none; the hand's
  // device determines the tool.
  std::atomic<std::int32_t> chosen_tool{-1};
  std::atomic<Nanos> session_zero{
      /// Servo thread → other threads: time of the machine's clock at which the session's time is zero, ns. 0: the
      /// session has not begun.
      0};
  std::atomic<bool> stop{false};  // any thread → all threads: end the session
  /// To the recorder and stream threads: all other threads have ended, so no more data will come.
  std::atomic<bool> nothing_more{false};
  std::atomic<bool> servo_ended{
      false};  // servo thread → render thread: the hand was disconnected, or its script has ended
};

}  // namespace typodont
