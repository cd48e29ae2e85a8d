// Every channel between threads, on one page. Each is written by one thread and read by one other.
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
#include "engine/display/hmd.h"
#include "engine/render/renderer.h"
#include "haptics/patch_exchange.h"
#include "haptics/servo.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// Bricks that changed, made by the carver, uploaded by the renderer. The reader deletes it.
using MeshBatch = std::vector<render::MeshUpdate>;

/// What may be changed while a session runs. It acts on what the servo is given and on what leaves it, so the ticks say
/// what was in force and a replay stays exact.
struct SessionSettings {
  double speed_share = 1;                 // 0..1, of the pedal: how fast the drill may turn
  bool backwards = false;                 // the handpiece runs backwards, with a tool that has a thread
  double force_share = 1;                 // 0..1, of the force that reaches the hand
  PerTissue stiffness = every_tissue(1);  // of the materials' own; only where not recorded
  Nanos force_delay = 0;  // ns that the force reaches the hand late; only where the session delays forces

  static constexpr PerTissue every_tissue(double share) {
    PerTissue all{};
    for (double& v : all) v = share;
    return all;
  }
  /// N/m, what set_stiffness() of the servo takes.
  PerTissue stiffness_of(const MaterialTable& materials) const {
    PerTissue scaled{};
    for (std::size_t i = 0; i < scaled.size(); ++i) scaled[i] = stiffness[i] * materials[i].stiffness;
    return scaled;
  }
};

/// How the recording fares, in passing.
struct RecordState {
  std::uint64_t ticks = 0, cuts = 0;
  bool complete = true;                   // nothing was lost so far
  bool disk_low = false, failed = false;  // gaps are near; nothing more is recorded
};

/// A headset's controller, newest.
struct XrHandSample {
  Pose X_WT;
  double pedal = 0;      // 0..1
  bool tracked = false;  // seen by the headset
  Nanos t = 0;
};

/// What a user asks of the tissue while a session runs.
enum class TissueCommand { kUndo, kRedo, kSave };

/// A piece of a brush stroke, as an instructor paints.
struct BrushMove {
  PaintStroke stroke;
  bool begins = false;  // the brush was set down
};

/// A stroke taken back or brought again, between two cuts and between two patches: with these a replay is exact.
struct StrokeEdit {
  Nanos t = 0;
  bool redo = false;
  std::uint64_t cuts = 0;     // in the tissue when it happened
  std::uint32_t patches = 0;  // cut out before it
};

/// The eyes before a screen, and how the scene is shown.
struct SeenFrom {
  Nanos t = 0;
  dvec3 eye_W{0}, right_W{1, 0, 0};
  double ipd = 0;
  render::View view = render::View::kLook;
};

/// A frame of a picture on a screen, and what it cost.
struct PictureTiming {
  Nanos t = 0;                  // when it was begun, on the machine's clock
  double period = 0;            // s since the frame before
  double record = 0;            // s: preparing it and handing it over
  double gpu = 0;               // s: drawing it, by the GPU's own clock; of the newest frame that is done
  double motion_to_photon = 0;  // s, estimated: from the hand's sample shown to the middle of the screen's next picture
  double redrawn = 1;           // share of the picture that was drawn anew
  int step = 0;                 // of the quality ladder, 0: best
};

struct Wiring {
  explicit Wiring(const haptics::Carver& carver) : patch(carver) {}

  // SERVO → CARVER
  Ring<Cut> cuts_to_carver{1 << 14};
  Latest<ServoTick> tick_to_carver;
  // CARVER → SERVO
  haptics::PatchExchange patch;
  // SERVO → RENDER
  Latest<ServoTick> tick_to_render;
  Ring<Cut> cuts_to_debris{1 << 12};
  // UI → CARVER → UI
  Ring<TissueCommand> tissue_commands{64};
  Latest<TissueState> tissue_to_render{{}};
  // CARVER → RECORDER
  Ring<StrokeEdit> edits_to_recorder{1 << 10};
  Ring<LoosePiece> pieces_to_recorder{1 << 10};
  // CARVER → RENDER
  Ring<LoosePiece> pieces_to_debris{1 << 10};
  // CARVER → RENDER
  Ring<MeshBatch*> bricks{256};
  // CARVER → UI, where a headset draws in RENDER's place and an operator watches
  Ring<MeshBatch*> bricks_to_watch{256};
  // CARVER → WATCH (live_views.h): copies of the tissue, as they are asked for; WATCH → UI is inside LiveViews
  Ring<haptics::TissueVolume*> copies_to_watch{4};
  // CARVER → EXPERT (live_expert.h): copies of the tissue to plan from, where an expert is the hand
  Ring<haptics::TissueVolume*> copies_to_expert{2};
  // RENDER (window) → SERVO, where the mouse is the hand
  Latest<haptics::HandSample> pointer;
  // UI → CARVER, where an instructor paints
  Ring<BrushMove> paint_to_carver{1 << 10};
  // UI → SERVO
  Latest<SessionSettings> settings;
  // SERVO → UI, where an operator watches
  Ring<ServoTick> ticks_to_score{1 << 14};
  // RECORDER → UI
  Latest<RecordState> record_to_render;
  // HEADSET (which draws in RENDER's place) → SERVO, where a controller is the hand; → RECORDER
  Latest<XrHandSample> xr_hand;
  Ring<display::HmdTiming> xr_frames_to_recorder{1 << 12};
  // RENDER → RECORDER
  Ring<PictureTiming> pictures_to_recorder{1 << 12};
  // SERVO → RECORDER
  Ring<ServoTick> ticks_to_recorder{1 << 15};
  Ring<Cut> cuts_to_recorder{1 << 14};
  Ring<PatchUse> patches_to_recorder{1 << 12};
  Latest<LoopReport> loop_to_recorder;
  // SERVO → STREAM; null where nobody is told of the session
  std::unique_ptr<Ring<ServoTick>> ticks_to_stream;
  // SERVO → RENDER: how the loop fares, how warm the motors are
  Latest<LoopReport> loop_to_render;
  // RENDER → RECORDER, whenever it changed
  Ring<SeenFrom> seen_to_recorder{1 << 10};
  // LEFT HAND → RENDER, RECORDER
  Latest<MouthMirror> mouth_mirror;
  Ring<haptics::HandSample> left_to_recorder{1 << 13};
  // SERVO → AUDIO: inside SoundLink (a ring of what the ear needs)

  std::atomic<bool> copy_wanted{false};          // WATCH → CARVER
  std::atomic<bool> expert_wants_copy{false};    // EXPERT → CARVER
  std::atomic<std::uint64_t> tissue_version{0};  // CARVER → WATCH: changes with the tissue
  std::atomic<std::uint32_t> saved{0},
      not_saved{0};  // CARVER (a thread of its for that) → UI: times the tissue was, and could not be
  std::atomic<float> tolerance{0.1f};  // RENDER → CARVER: voxels that triangles may lie off the surface (detail.h)
  std::array<std::atomic<bool>, 2>
      tissue_in_sight{};               // RENDER, HEADSET → CARVER: of either of Eyes; else none is meshed
  std::atomic<bool> emergency{false};  // any thread → SERVO: no force from the next tick on, and the session's end
  std::atomic<std::int32_t> chosen_tool{-1};    // RENDER (window) → SERVO: by key; negative: the hand's own choice
  std::atomic<bool> held{false};                // RENDER → SERVO: the emergency key; no drill until it is let go on
  std::atomic<std::uint32_t> newest_faults{0};  // SERVO → RENDER
  std::atomic<Nanos> session_zero{
      0};  // SERVO → LEFT HAND, RENDER, RECORDER: the clock's time at the session's zero; 0: not yet begun
  std::atomic<bool> stop{false};          // any thread → all: end the session
  std::atomic<bool> nothing_more{false};  // all others have ended → RECORDER: what is in the rings is the rest
  std::atomic<bool> servo_ended{false};   // SERVO → RENDER: the hand is gone or the script has ended
};

}  // namespace typodont
