// A headset through OpenXR. Render thread only; OpenXR's loader is opened only here. Order of calls:
//
// open()    loads loader, runtime and headset; Vulkan must then be created with device_options()
// begin()   creates the session, a swapchain with two layers, and the actions
// wake()    waits until the user wears the headset
// wait() → locate … record() … submit(), once per frame
// end()     before the device is destroyed
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

/// A controller as a tool: its origin is at the tool's tip, with the shank towards the hand.
struct HmdHand {
  bool tracked = false;
  Pose X_WT;
  Pose X_DT;                 // pose of the tool in the headset's space, as measured
  double pedal = 0;          // pedal position, 0..1; the controller's trigger is the pedal
  bool change_tool = false;  // true: the controller's button was pressed since the last frame
  bool mirror = false;       // true: the mirror button was pressed since the last frame
};

struct HmdFrame {
  bool draw = false;     // false: submit() must be called without a picture
  bool focused = false;  // true: this program receives the user's input
  Nanos shown_at = 0;    // predicted time of display on the program's clock; 0: unknown
  double period = 0;     // s, time between two frames of the headset
  std::array<EyeView, 2> eyes;
  Pose X_WH;                     // pose of the head (x right, y up, view −z)
  std::array<HmdHand, 2> hands;  // hands in the order left, right
};

/// Timing of a frame; it is known only some frames later.
struct HmdTiming {
  Nanos t = 0;  // ns, time at which the frame's poses were requested
  bool drawn = false;
  int missed = 0;             // number of display refreshes without a new picture
  double pose_to_submit = 0;  // s, time from the request of poses to submission
  // Time from submission to display, s; −1e9: unknown.
  double margin = -1e9;
  bool judged = false;        // true: the predicted head was compared with the measured one
  double position_error = 0;  // m, error of the predicted head position
  double angle_error = 0;     // rad, error of the predicted head orientation
  Pose X_WH;                  // predicted pose of the user's head in frame W
};

/// Vibration of a controller; amplitude 0 switches it off.
struct Vibration {
  double amplitude = 0;  // 0..1, strength of the vibration
  double frequency = 0;  // Hz, frequency of the vibration; 0: the runtime chooses
};

class Hmd {
 public:
  /// Opens the headset. Throws Error with a message of one line: no loader, runtime, headset or Vulkan.
  static std::unique_ptr<Hmd> open(const DisplayRig& rig, RuntimeGate& gate);
  virtual ~Hmd() = default;

  virtual gpu::DeviceOptions device_options() = 0;
  /// Creates the session. `work_W`: point that recentring brings in front of the user, m. Throws Error.
  virtual void begin(gpu::Device& device, const dvec3& work_W) = 0;
  /// Waits until the user wears the headset. Throws Error if the headset stays idle.
  virtual void wake() = 0;
  virtual void end() = 0;

  /// Handles events. Returns false if the session has ended; throws RunFailure if the headset is lost.
  virtual bool poll() = 0;
  /// Returns false while the runtime wants no frames; the caller must then sleep briefly and call poll() again.
  virtual bool running() const = 0;
  /// Waits for the next frame; returns it with the poses of head and hands.
  virtual HmdFrame wait() = 0;
  /// Image and layer with the depth of an eye; null: none. record() copies the pictures and depths of both eyes.
  struct Depth {
    const gpu::Image* image = nullptr;
    std::uint32_t layer = 0;
  };
  virtual void record(VkCommandBuffer commands, const gpu::Image& pictures, const std::array<Depth, 2>& depth) = 0;
  /// Call after the commands were submitted, or directly after wait() if nothing was drawn.
  virtual void submit(const HmdFrame& frame) = 0;
  virtual void vibrate(int hand, const Vibration& vibration) = 0;
  /// Requests the end of the session; poll() then returns false.
  virtual void request_exit() = 0;

  virtual ivec2 eye_pixels() const = 0;
  virtual bool wants_depth() const = 0;
  virtual bool see_through() const = 0;  // true: the room is visible where nothing is drawn
  /// Triangles that the lenses hide from each eye, for Renderer::set_hidden; nullopt: unchanged since the last call.
  virtual std::optional<std::vector<glm::vec3>> hidden() = 0;
  /// Returns the timings that became known since the last call.
  virtual std::vector<HmdTiming> timings() = 0;
  /// Features of the runtime that are used, and those that are not, as sentences for the user.
  virtual std::vector<std::string> explanations() const = 0;
};

}  // namespace typodont::display
