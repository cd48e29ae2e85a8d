// All channels between the threads of a session: the tapes, which any thread may read, and channels with one thread
// that writes and one that reads. In the comments below, "render thread" is the thread that draws the trainee's
// picture, and "user interface" is the operator's window.
#pragma once

#include <array>
#include <atomic>
#include <vector>

#include "engine/app/tapes.h"
#include "engine/app/tissue/paint_file.h"
#include "engine/base/latest.h"
#include "engine/base/ring.h"
#include "engine/render/renderer.h"
#include "haptics/patch_exchange.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// A list of changed bricks (blocks of the tissue's mesh). The carver thread meshes the bricks. The renderer uploads
/// them and then deletes the list.
using MeshBatch = std::vector<render::MeshUpdate>;

/// Settings that may change during a session. They change the input and the output of the servo. A recording does not
/// contain the settings: its ticks contain the values that the settings have changed, so a replay is exact without
/// them.
struct SessionSettings {
  double speed_fraction = 1;  // 0..1, factor by which the pedal is multiplied; it limits the drill's speed
  bool backwards = false;     // true: the handpiece turns backwards; only for a tool with a thread
  double force_fraction = 1;  // 0..1, factor by which the force on the hand is multiplied
  /// factors by which the stiffness of each tissue is multiplied; used only in sessions without a recording
  PerTissue stiffness = every_tissue(1);
  /// ns, delay of the force at the hand; used only in sessions that can delay forces
  Nanos force_delay = 0;

  static constexpr PerTissue every_tissue(double fraction) {
    PerTissue all{};
    for (double& v : all) v = fraction;
    return all;
  }
  /// Returns the stiffness (N/m) of each tissue multiplied by the factors in these settings, for set_stiffness() of the
  /// servo.
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

/// The latest sample of the headset's controller that moves the tool.
struct XrHandSample {
  Pose X_WT;
  double pedal = 0;      // 0..1, position of the trigger
  bool tracked = false;  // true: the headset can see the controller
  Nanos t = 0;
};

/// Commands of the user that concern the tissue during a session.
enum class TissueCommand { kUndo, kRedo, kSave };

/// A part of an instructor's brush stroke.
struct BrushMove {
  PaintStroke stroke;
  bool begins = false;  // true: this part begins a new stroke
};

struct Wiring {
  explicit Wiring(const haptics::Carver& carver) : patch(carver) {}

  // What the threads did. Any thread may read.
  Tapes tapes;
  // From the carver thread to the servo thread: the newest snapshot of the tissue near the tool
  haptics::PatchExchange patch;
  // From the user interface to the carver thread: commands
  Ring<TissueCommand> tissue_commands{64};
  // From the carver thread to the render thread: the changed parts of the tissue's mesh
  Ring<MeshBatch*> bricks{256};
  // From the carver thread to the user interface: the changed parts of the tissue's mesh. Used if a headset shows the
  // session and an operator watches in a window.
  Ring<MeshBatch*> bricks_to_watch{256};
  // From the carver thread to the computing thread of LiveViews (live_views.h): copies of the tissue that the computing
  // thread has requested. The channel from the computing thread to the user interface is inside LiveViews.
  Ring<haptics::TissueVolume*> copies_to_watch{4};
  // From the carver thread to the planner thread of the expert (live_expert.h): copies of the tissue for planning. Used
  // if the hand is an expert.
  Ring<haptics::TissueVolume*> copies_to_expert{2};
  // From the render thread (window) to the servo thread: the pose of the hand that the mouse determines. Used if the
  // hand is the mouse.
  Latest<haptics::HandSample> pointer;
  // From the user interface to the carver thread: moves of the brush with which an instructor paints tissue
  Ring<BrushMove> paint_to_carver{1 << 10};
  // From the user interface to the servo thread: settings that the user changed
  Latest<SessionSettings> settings;
  // From the recorder thread to the user interface: state of the recording
  Latest<RecordState> record_to_render;
  // From the headset's thread to the servo thread: the controller's samples. Used if the controller is the hand.
  Latest<XrHandSample> xr_hand;

  /// request for a copy of the tissue, from the computing thread of LiveViews to the carver thread
  std::atomic<bool> copy_wanted{false};
  /// request for a copy of the tissue, from the planner thread of the expert to the carver thread
  std::atomic<bool> expert_wants_copy{false};
  /// From the carver thread to the computing thread of LiveViews: number that increases whenever the tissue changes
  std::atomic<std::uint64_t> tissue_version{0};
  std::atomic<std::uint32_t> saved{0},
      /// Number of successful and of failed saves of the tissue. The saving thread writes these numbers, and the user
      /// interface reads them.
      not_saved{0};
  // From the render thread to the carver thread: tolerance of the tissue's mesh, voxels (picture/detail.h)
  std::atomic<float> tolerance{0.1f};
  std::array<std::atomic<bool>, 2>
      /// from the render thread or the headset's thread to the carver thread: true if a picture shows the tissue;
      /// otherwise nothing is meshed
      tissue_in_sight{};
  /// From any thread to the servo thread: zero force from the next tick on, then the end of the session
  std::atomic<bool> emergency{false};
  // From the render thread (window) to the servo thread: index of the tool that the user chose by a key; negative: the
  // user chose none, so the hand's device determines the tool
  std::atomic<std::int32_t> chosen_tool{-1};
  std::atomic<Nanos> session_zero{
      /// from the servo thread to the other threads: ns, time of the machine's clock at which the session's time is
      /// zero; 0: the session has not begun
      0};
  std::atomic<bool> stop{false};  // From any thread to all threads: end the session
  /// To the recorder and the stream thread, set after all other threads have ended: no more data will come
  std::atomic<bool> nothing_more{false};
  std::atomic<bool> servo_ended{
      false};  // From the servo thread to the render thread: the hand was disconnected, or its script has ended
};

}  // namespace typodont
