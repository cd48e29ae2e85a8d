// A headset through OpenXR: where its eyes are when the next picture will be shown, where that picture goes, and what
// the hands do. One thread owns it (the one that draws). OpenXR's loader is opened only here, only when asked.
//
//   open() ─ loader, runtime, headset: Vulkan must be made its way, device_options()
//   begin() ─ session, swapchain of two layers, actions      wake() ─ until the headset is worn
//   wait() → locate … record() … submit(), once a frame      end() ─ before the device goes
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/base/clock.h"
#include "engine/display/display_rig.h"
#include "engine/display/runtime_gate.h"
#include "engine/gpu/resources.h"

namespace typodont::display {

/// A controller, as the tool's hand: T at its tip, shank towards the hand.
struct HmdHand {
  bool tracked = false;
  Pose X_WT;
  Pose X_DT;                 // the same in the headset's space, as it was measured
  double pedal = 0;          // 0..1, the trigger
  bool change_tool = false;  // pressed since the last frame
  bool mirror = false;       // the same: the mouth mirror's button
};

struct HmdFrame {
  bool draw = false;     // a picture is wanted; else submit() without one
  bool focused = false;  // the hands are ours
  Nanos shown_at = 0;    // predicted, on the program's clock where the runtime can tell, else 0
  double period = 0;     // s
  std::array<EyeView, 2> eyes;
  Pose X_WH;                     // the head (x right, y up, looking along −z)
  std::array<HmdHand, 2> hands;  // left, right
};

/// What became of a frame, known some frames later.
struct HmdTiming {
  Nanos t = 0;  // when its poses were asked for
  bool drawn = false;
  int missed = 0;             // pictures of the display that went by since the frame before
  double pose_to_submit = 0;  // s from asking for the poses to handing the picture over
  double margin = -1e9;       // s left to the predicted display when handed over; −1e9: the runtime cannot tell
  bool judged = false;        // the prediction could be compared
  double position_error = 0;  // m of the head, predicted against looked back on
  double angle_error = 0;     // rad
  Pose X_WH;                  // the head as predicted
};

/// For the controller in the tool's hand; nothing while it is zero.
struct Vibration {
  double amplitude = 0;  // 0..1
  double frequency = 0;  // Hz; 0: the runtime's choice
};

class Hmd {
 public:
  /// Throws Error in one line: no loader, no runtime, no headset, or a runtime that cannot share Vulkan.
  static std::unique_ptr<Hmd> open(const DisplayRig& rig, RuntimeGate& gate);
  virtual ~Hmd() = default;

  virtual gpu::DeviceOptions device_options() = 0;
  /// Throws Error. `work`: the point that recentring puts before the user, m, W; what is worth looking at.
  virtual void begin(gpu::Device& device, const dvec3& work_W) = 0;
  /// Waits until the headset is worn and the runtime wants frames. Throws Error when it stays asleep.
  virtual void wake() = 0;
  virtual void end() = 0;

  /// Events, session states. False when the session is over: the user left it. Throws RunFailure when it was lost.
  virtual bool poll() = 0;
  /// Frames are wanted; else sleep a little and poll again.
  virtual bool running() const = 0;
  /// Waits for the runtime's next frame, begins it, and locates head and hands.
  virtual HmdFrame wait() = 0;
  /// Copies the eyes' pictures into the swapchain; `pictures` has two layers. depth: sources, or null images.
  struct Depth {
    const gpu::Image* image = nullptr;
    std::uint32_t layer = 0;
  };
  virtual void record(VkCommandBuffer commands, const gpu::Image& pictures, const std::array<Depth, 2>& depth) = 0;
  /// After the commands were submitted (frame.draw), or at once (not drawn).
  virtual void submit(const HmdFrame& frame) = 0;
  virtual void vibrate(int hand, const Vibration& vibration) = 0;
  /// Asks the runtime to end the session; poll() then comes to its end.
  virtual void request_exit() = 0;

  virtual ivec2 eye_pixels() const = 0;
  virtual bool wants_depth() const = 0;
  virtual bool see_through() const = 0;  // the room shows where nothing is drawn
  /// The hidden area of both eyes, for Renderer::set_hidden; nothing when it has not changed since the last call.
  virtual std::optional<std::vector<glm::vec3>> hidden() = 0;
  /// Timings that have become known since the last call.
  virtual std::vector<HmdTiming> timings() = 0;
  /// What is used and what is not, in words.
  virtual std::vector<std::string> explanations() const = 0;
};

}  // namespace typodont::display
