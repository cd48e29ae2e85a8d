// A headset through OpenXR: the poses of the eyes at the time of display, the output of the pictures, and hand input.
// Only the render thread uses it. OpenXR's loader is opened only here, and only on request. Order of calls:
//
//   open()    loads loader, runtime and headset; Vulkan must then be created with device_options()
//   begin()   creates the session, a swapchain with two layers, and the actions
//   wake()    waits until the user wears the headset
//   wait() → locate … record() … submit(), once per frame
//   end()     before the device is destroyed
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

/// A controller that moves the tool. The tool's origin is at the controller's tip; the shank points towards the hand.
struct HmdHand {
  bool tracked = false;
  Pose X_WT;
  Pose X_DT;                 // pose of the tool in the headset's space, as measured
  double pedal = 0;          // pedal position, 0..1; the controller's trigger is the pedal
  bool change_tool = false;  // true if the controller's button was pressed since the last frame
  bool mirror = false;       // true if the button for the mouth mirror was pressed since the last frame
};

struct HmdFrame {
  bool draw = false;     // true if a picture is needed; otherwise call submit() without a picture
  bool focused = false;  // true if this program, and no other program, receives the input of the controllers
  Nanos shown_at = 0;    // predicted time of display on the program's clock; 0: unknown
  double period = 0;     // s, time between two frames of the headset
  std::array<EyeView, 2> eyes;
  Pose X_WH;                     // pose of the head (x right, y up, looking along −z)
  std::array<HmdHand, 2> hands;  // hands in the order left, right
};

/// Timing of a frame; it becomes known some frames later.
struct HmdTiming {
  Nanos t = 0;  // ns, time at which the frame's poses were requested
  bool drawn = false;
  int missed = 0;             // number of refreshes of the display without a new picture since the previous frame
  double pose_to_submit = 0;  // s, time from the request for poses to the submission of the picture
  // s, time from the submission of the picture until the predicted time of its display; −1e9: unknown
  double margin = -1e9;
  bool judged = false;        // true if the predicted pose of the head was compared with the measured one
  double position_error = 0;  // m, error of the predicted head position
  double angle_error = 0;     // rad, error of the predicted head orientation
  Pose X_WH;                  // predicted pose of the user's head in frame W
};

/// Vibration of the controller in the tool's hand. An amplitude of zero switches it off.
struct Vibration {
  double amplitude = 0;  // 0..1, strength of the vibration
  double frequency = 0;  // Hz, frequency of the vibration; 0: the runtime chooses
};

class Hmd {
 public:
  /// Opens loader, runtime and headset. Throws Error with a message of one line if there is no loader, no runtime or
  /// no headset, or if the runtime does not support Vulkan.
  static std::unique_ptr<Hmd> open(const DisplayRig& rig, RuntimeGate& gate);
  virtual ~Hmd() = default;

  virtual gpu::DeviceOptions device_options() = 0;
  /// Creates the session. Throws Error. `work_W`: m, frame W; recentring moves this point in front of the user.
  virtual void begin(gpu::Device& device, const dvec3& work_W) = 0;
  /// Waits until the user wears the headset and the runtime requests frames. Throws Error if the headset stays idle.
  virtual void wake() = 0;
  virtual void end() = 0;

  /// Processes events and session states. Returns false if the session ended normally. Throws RunFailure if the
  /// session was lost.
  virtual bool poll() = 0;
  /// Returns true if the runtime requests frames. If false, the caller sleeps briefly and polls again.
  virtual bool running() const = 0;
  /// Waits for the runtime's next frame, begins it, and locates the head and the hands.
  virtual HmdFrame wait() = 0;
  /// The depth of one eye's picture: an image and the layer in it. If the image is null, no depth is copied. record()
  /// copies the pictures and the depths of both eyes to the swapchain.
  struct Depth {
    const gpu::Image* image = nullptr;
    std::uint32_t layer = 0;
  };
  virtual void record(VkCommandBuffer commands, const gpu::Image& pictures, const std::array<Depth, 2>& depth) = 0;
  /// Passes the frame to the runtime. Call this function after the commands were submitted (if frame.draw is true), or
  /// directly after wait() if nothing is drawn.
  virtual void submit(const HmdFrame& frame) = 0;
  virtual void vibrate(int hand, const Vibration& vibration) = 0;
  /// Asks the runtime to end the session. poll() then returns false after some calls.
  virtual void request_exit() = 0;

  virtual ivec2 eye_pixels() const = 0;
  virtual bool wants_depth() const = 0;
  virtual bool see_through() const = 0;  // true: the room is visible where nothing is drawn
  /// Returns the triangles of the areas that each eye cannot see, for Renderer::set_hidden; no value if the triangles
  /// have not changed since the last call.
  virtual std::optional<std::vector<glm::vec3>> hidden() = 0;
  /// Returns the timings that became known since the last call.
  virtual std::vector<HmdTiming> timings() = 0;
  /// Describes which features of the headset are used, and which are not.
  virtual std::vector<std::string> explanations() const = 0;
};

}  // namespace typodont::display
