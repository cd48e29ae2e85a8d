// All channels between threads. Each channel has one writer thread and one reader thread.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <vector>

#include "engine/app/tissue/paint_file.h"
#include "engine/app/tissue/stroke_book.h"
#include "engine/base/latest.h"
#include "engine/base/ring.h"
#include "engine/contract/contact.h"
#include "engine/contract/loop_timing.h"
#include "engine/contract/mouth_mirror.h"
#include "engine/contract/suction_tip.h"
#include "engine/display/hmd.h"
#include "engine/render/renderer.h"
#include "haptics/patch_exchange.h"
#include "haptics/servo.h"
#include "haptics/soft_law.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// Changed bricks. The carver meshes them; the renderer uploads them and deletes the batch.
using MeshBatch = std::vector<render::MeshUpdate>;

/// Settings that may change during a session. They act on the servo's input and on its output, so the ticks contain
/// their effect and a replay stays exact.
struct SessionSettings {
  double speed_fraction = 1;              // 0..1, factor on the pedal, which limits the drill's speed
  bool backwards = false;                 // the handpiece turns backwards; only for a tool with a thread
  double force_fraction = 1;              // 0..1, factor on the force that reaches the hand
  PerTissue stiffness = every_tissue(1);  // factors on the materials' stiffness; only in sessions without recording
  Nanos force_delay = 0;                  // ns, delay of the force at the hand; only in sessions that can delay forces

  static constexpr PerTissue every_tissue(double fraction) {
    PerTissue all{};
    for (double& v : all) v = fraction;
    return all;
  }
  /// N/m, stiffness of every tissue, for set_stiffness() of the servo.
  PerTissue stiffness_of(const MaterialTable& materials) const {
    PerTissue scaled{};
    for (std::size_t i = 0; i < scaled.size(); ++i) scaled[i] = stiffness[i] * materials[i].stiffness;
    return scaled;
  }
};

/// State of the recording.
struct RecordState {
  std::uint64_t ticks = 0, cuts = 0;
  bool complete = true;                   // no data was lost so far
  bool disk_low = false, failed = false;  // disk_low: the disk is nearly full; failed: recording has stopped
};

/// Latest sample of a headset's controller.
struct XrHandSample {
  Pose X_WT;
  double pedal = 0;      // 0..1
  bool tracked = false;  // the headset sees the controller
  Nanos t = 0;
};

/// The user's commands that concern the tissue during a session.
enum class TissueCommand { kUndo, kRedo, kSave };

/// A piece of an instructor's brush stroke.
struct BrushMove {
  PaintStroke stroke;
  bool begins = false;  // true: a new stroke begins with this piece
};

/// An undo or redo of a stroke. Its position between cuts and between patches makes a replay exact.
struct StrokeEdit {
  Nanos t = 0;
  bool redo = false;
  std::uint64_t cuts = 0;     // number of cuts applied to the tissue before the edit
  std::uint32_t patches = 0;  // number of patches created before the edit
};

/// Positions of the eyes in front of a screen, and the selected view.
struct SeenFrom {
  Nanos t = 0;
  dvec3 eye_W{0}, right_W{1, 0, 0};
  double ipd = 0;
  render::View view = render::View::kLook;
};

/// State of the handpiece's water and of the suction.
struct WaterSwitch {
  Nanos t = 0;
  bool spray = false, suction = false;
};

/// Timing of a frame on a screen.
struct PictureTiming {
  Nanos t = 0;        // ns, time of the frame's begin on the machine's clock
  double period = 0;  // s, time since the previous frame
  double record = 0;  // s, preparation and submission on the CPU
  double gpu = 0;     // s, GPU time by the GPU's clock, of the latest finished frame
  // s, estimated time from the hand's sample that the frame shows to the middle of the screen's next refresh
  double motion_to_photon = 0;
  double redrawn = 1;  // redrawn fraction of the picture
  int step = 0;        // level of quality, 0: best
};

struct Wiring {
  explicit Wiring(const haptics::Carver& carver) : patch(carver) {}

  // From SERVO to CARVER
  Ring<Cut> cuts_to_carver{1 << 14};
  Latest<ServoTick> tick_to_carver;
  // From CARVER to SERVO
  haptics::PatchExchange patch;
  // From SERVO to RENDER
  Latest<ServoTick> tick_to_render;
  Ring<Cut> cuts_to_debris{1 << 12};
  // From SERVO to RENDER, sixty times per second: points of the soft gum that moved, and its wounds; null if the gum is
  // rigid or if no window draws the gum
  std::unique_ptr<Ring<haptics::SoftMove>> gum_moves;
  std::unique_ptr<Ring<haptics::SoftWound>> gum_wounds;
  // From UI to CARVER, and the state of the tissue back to UI
  Ring<TissueCommand> tissue_commands{64};
  Latest<TissueState> tissue_to_render{{}};
  // From CARVER to RECORDER
  Ring<StrokeEdit> edits_to_recorder{1 << 10};
  Ring<LoosePiece> pieces_to_recorder{1 << 10};
  // From CARVER to RENDER
  Ring<LoosePiece> pieces_to_debris{1 << 10};
  // From CARVER to RENDER
  Ring<MeshBatch*> bricks{256};
  // From CARVER to UI, if a headset draws instead of RENDER and an operator watches
  Ring<MeshBatch*> bricks_to_watch{256};
  // From CARVER to WATCH (live_views.h): copies of the tissue on request; the channel from WATCH to UI is in LiveViews
  Ring<haptics::TissueVolume*> copies_to_watch{4};
  // From CARVER to EXPERT (live_expert.h): copies of the tissue for planning, if an expert is the hand
  Ring<haptics::TissueVolume*> copies_to_expert{2};
  // From RENDER (window) to SERVO, if the mouse is the hand
  Latest<haptics::HandSample> pointer;
  // From UI to CARVER, if an instructor paints
  Ring<BrushMove> paint_to_carver{1 << 10};
  // From UI to SERVO
  Latest<SessionSettings> settings;
  // From SERVO to UI, if an operator watches
  Ring<ServoTick> ticks_to_score{1 << 14};
  // From RECORDER to UI
  Latest<RecordState> record_to_render;
  // From HEADSET (which draws instead of RENDER) to SERVO, if a controller is the hand, and to RECORDER
  Latest<XrHandSample> xr_hand;
  Ring<display::HmdTiming> xr_frames_to_recorder{1 << 12};
  // From RENDER to RECORDER
  Ring<PictureTiming> pictures_to_recorder{1 << 12};
  // From SERVO to RECORDER
  Ring<ServoTick> ticks_to_recorder{1 << 15};
  Ring<Cut> cuts_to_recorder{1 << 14};
  Ring<PatchUse> patches_to_recorder{1 << 12};
  Latest<LoopReport> loop_to_recorder;
  // From SERVO to STREAM; null if the session is not published
  std::unique_ptr<Ring<ServoTick>> ticks_to_stream;
  // From SERVO to RENDER: timing of the loop, heat of the motors
  Latest<LoopReport> loop_to_render;
  // From RENDER to RECORDER, after each change
  Ring<SeenFrom> seen_to_recorder{1 << 10};
  // From LEFT HAND to RENDER, RECORDER
  Latest<MouthMirror> mouth_mirror;
  Latest<SuctionTip> suction_tip;  // pose of the suction tip; published instead of the mirror if the hand holds the tip
  // From RENDER to RECORDER, after each change
  Ring<WaterSwitch> water_to_recorder{64};
  Ring<haptics::HandSample> left_to_recorder{1 << 13};
  Latest<SeenFrom> head_to_sound;  // RENDER (a headset's thread) → application: the newest position of the eyes
  // From SERVO to AUDIO: this channel is a ring inside SoundLink

  std::atomic<bool> copy_wanted{false};          // From WATCH to CARVER
  std::atomic<bool> expert_wants_copy{false};    // From EXPERT to CARVER
  std::atomic<std::uint64_t> tissue_version{0};  // From CARVER to WATCH: changes whenever the tissue changes
  std::atomic<std::uint32_t> saved{0},
      not_saved{0};  // From CARVER (its saving thread) to UI: number of successful and failed saves of the tissue
  // From RENDER to CARVER: voxels, largest distance of triangles from the surface (detail.h)
  std::atomic<float> tolerance{0.1f};
  std::array<std::atomic<bool>, 2>
      tissue_in_sight{};  // RENDER, HEADSET → CARVER: a picture shows the tissue; otherwise nothing is meshed
  std::atomic<bool> emergency{false};  // any thread → SERVO: no force from the next tick on, and end of the session
  // From RENDER (window) to SERVO: tool chosen by key; negative: the hand's own choice
  std::atomic<std::int32_t> chosen_tool{-1};
  std::atomic<bool> held{
      false};  // From RENDER to SERVO: the emergency stop is active; the drill is off until its release
  std::atomic<std::uint32_t> newest_faults{0};  // From SERVO to RENDER
  std::atomic<Nanos> session_zero{
      0};  // From SERVO to LEFT HAND, RENDER, RECORDER: machine's clock (ns) at the session's zero; 0: not yet begun
  std::atomic<bool> stop{false};          // any thread → all: end the session
  std::atomic<bool> nothing_more{false};  // set after all others have ended → RECORDER: the rings contain all data
  std::atomic<bool> servo_ended{false};   // From SERVO to RENDER: the hand is disconnected or the script has ended
};

}  // namespace typodont
