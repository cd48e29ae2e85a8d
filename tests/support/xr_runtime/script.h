// The behaviour of the test runtime, which is read from the JSON file that TYPODONT_XR_SCRIPT names. Every omitted
// value has a default.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace typodont::test::xr {

struct ScriptPose {
  std::array<double, 3> p{0, 0, 0};     // m
  std::array<double, 4> q{1, 0, 0, 0};  // w, x, y, z
};

struct HeadKey {
  double frame = 0;
  ScriptPose pose;
};

struct HandKey {
  double frame = 0;
  ScriptPose pose;
  double trigger = 0;
  bool tracked = true;
  std::vector<std::string> buttons;  // last parts of the input paths of pressed buttons, e.g. "a/click"
};

struct ScriptView {
  ScriptPose pose;                                  // pose of the eye relative to the head
  std::array<double, 4> fov{-0.8, 0.8, 0.8, -0.8};  // left, right, up, down, rad
};

struct ScriptEvent {
  double frame = -1;            // the event occurs before the program waits for this frame
  std::int64_t vibrations = 0;  // the event occurs only after the program has sent this number of vibrations to a hand
  std::string state;            // the event occurs when the session has reached this state
  std::string event;
  double seconds = 0;
  std::string call;  // name of the call, for stall and fail
  std::int64_t result = 0;
  ScriptPose pose;
  bool pose_valid = true;
  std::int64_t count = 0;
};

struct Script {
  std::string log, out;  // a file and a folder
  bool headset = true, asleep = false, paced = false;
  std::vector<std::string> extensions;
  std::vector<std::string> blend_modes{"opaque"};
  std::vector<std::string> spaces{"view", "local", "stage"};
  std::vector<std::string> formats{"R8G8B8A8_SRGB", "B8G8R8A8_SRGB", "R8G8B8A8_UNORM", "D32_SFLOAT"};
  std::vector<double> refresh_rates{90};
  std::array<std::int64_t, 2> view_size{320, 256};
  std::int64_t images = 3;
  double period = 1.0 / 90;     // s
  double prediction_error = 0;  // m, error of the predicted head position for times in the future
  std::string profile = "/interaction_profiles/khr/simple_controller";
  ScriptPose local_origin;  // pose of LOCAL relative to STAGE
  std::array<ScriptView, 2> views{{{{{-0.032, 0, 0}, {1, 0, 0, 0}}}, {{{0.032, 0, 0}, {1, 0, 0, 0}}}}};
  std::vector<HeadKey> head{{0, {{0, 1.5, 0}, {1, 0, 0, 0}}}};
  std::array<std::vector<HandKey>, 2> hands;  // left, right
  std::vector<ScriptEvent> events;
  std::vector<std::int64_t> capture;        // numbers of the frames to capture
  std::vector<std::array<double, 2>> mask;  // triangles of the hidden area at z = −1, the same for both eyes
};

/// Throws std::runtime_error with a description of the error.
Script read_script(const std::string& file);
/// Returns all extensions that the runtime can offer.
const std::vector<std::string>& all_extensions();

}  // namespace typodont::test::xr
