// Input of the hands: actions, their bindings to common controllers, and vibration.
#pragma once

#include <array>
#include <string>

#include "engine/display/hmd.h"
#include "engine/display/xr/api.h"

namespace typodont::display::xr {

class Input {
 public:
  Input(Api& api, XrSession session);
  ~Input();
  Input(const Input&) = delete;
  Input& operator=(const Input&) = delete;

  struct Hand {
    bool tracked = false;
    Pose X_DA;  // pose of the controller's aim frame, whose −z points forward
    double pedal = 0;
    bool change_tool = false, mirror = false;
  };
  struct State {
    bool focused = false;
    bool recentre = false;
    std::array<Hand, 2> hands;  // hands in the order left, right
  };
  State read(XrSpace base, XrTime time);
  void vibrate(int hand, const Vibration& vibration, XrDuration duration);
  /// Names of the controllers in use. Call again after controllers have changed.
  std::string profiles();

 private:
  XrPath path(const std::string& text);
  XrAction action(const char* name, const char* title, XrActionType type);
  void suggest();
  bool pressed(XrAction action, XrPath hand);

  Api& api;
  XrSession session;
  XrActionSet set = XR_NULL_HANDLE;
  XrAction grip = XR_NULL_HANDLE, aim = XR_NULL_HANDLE, pedal = XR_NULL_HANDLE, change_tool = XR_NULL_HANDLE,
           mirror = XR_NULL_HANDLE, recentre = XR_NULL_HANDLE, vibration_ = XR_NULL_HANDLE;
  std::array<XrPath, 2> hands{};
  std::array<XrSpace, 2> aim_spaces{}, grip_spaces{};
  std::array<bool, 2> vibrates{};
};

}  // namespace typodont::display::xr
