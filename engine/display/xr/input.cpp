#include "engine/display/xr/input.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace typodont::display::xr {

namespace {

struct Binding {
  const char* what;  // name of the action in the headset's runtime
  const char* left;  // path after the prefix /user/hand/left/; null: no binding
  const char* right;
};

struct Profile {
  const char* path;
  std::array<Binding, 4> buttons;
};

// Component paths are from the specification's "Interaction Profile Paths".
constexpr std::array<Profile, 5> kProfiles{{
    {"/interaction_profiles/khr/simple_controller",
     {{{"pedal", "input/select/click", "input/select/click"},
       {"change_tool", nullptr, "input/menu/click"},
       {"mirror", nullptr, nullptr},
       {"recentre", "input/menu/click", nullptr}}}},
    {"/interaction_profiles/oculus/touch_controller",
     {{{"pedal", "input/trigger/value", "input/trigger/value"},
       {"change_tool", "input/x/click", "input/a/click"},
       {"mirror", "input/y/click", "input/b/click"},
       {"recentre", "input/menu/click", "input/thumbstick/click"}}}},
    {"/interaction_profiles/valve/index_controller",
     {{{"pedal", "input/trigger/value", "input/trigger/value"},
       {"change_tool", "input/a/click", "input/a/click"},
       {"mirror", "input/b/click", "input/b/click"},
       {"recentre", "input/thumbstick/click", "input/thumbstick/click"}}}},
    {"/interaction_profiles/htc/vive_controller",
     {{{"pedal", "input/trigger/value", "input/trigger/value"},
       {"change_tool", "input/squeeze/click", "input/squeeze/click"},
       {"mirror", "input/trackpad/click", "input/trackpad/click"},
       {"recentre", "input/menu/click", "input/menu/click"}}}},
    {"/interaction_profiles/microsoft/motion_controller",
     {{{"pedal", "input/trigger/value", "input/trigger/value"},
       {"change_tool", "input/squeeze/click", "input/squeeze/click"},
       {"mirror", "input/trackpad/click", "input/trackpad/click"},
       {"recentre", "input/menu/click", "input/menu/click"}}}},
}};

constexpr std::array<const char*, 2> kHands{"/user/hand/left", "/user/hand/right"};

constexpr XrSpaceLocationFlags kValid = XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT;
constexpr XrSpaceLocationFlags kTracked =
    kValid | XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT | XR_SPACE_LOCATION_POSITION_TRACKED_BIT;

}  // namespace

Input::Input(Api& a, XrSession s) : api(a), session(s) {
  XrActionSetCreateInfo set_info{XR_TYPE_ACTION_SET_CREATE_INFO};
  std::strcpy(set_info.actionSetName, "bench");
  std::strcpy(set_info.localizedActionSetName, "Drilling bench");
  api.call("xrCreateActionSet", api.CreateActionSet, api.instance(), &set_info, &set);
  for (std::size_t i = 0; i < 2; ++i) hands[i] = path(kHands[i]);
  grip = action("grip", "Hand", XR_ACTION_TYPE_POSE_INPUT);
  aim = action("aim", "Tool", XR_ACTION_TYPE_POSE_INPUT);
  pedal = action("pedal", "Foot pedal", XR_ACTION_TYPE_FLOAT_INPUT);
  change_tool = action("change_tool", "Change the tool", XR_ACTION_TYPE_BOOLEAN_INPUT);
  mirror = action("mirror", "Mouth mirror", XR_ACTION_TYPE_BOOLEAN_INPUT);
  recentre = action("recentre", "Put the work before me", XR_ACTION_TYPE_BOOLEAN_INPUT);
  vibration_ = action("vibration", "Feel of the drill", XR_ACTION_TYPE_VIBRATION_OUTPUT);
  suggest();
  const XrSessionActionSetsAttachInfo attach{XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO, nullptr, 1, &set};
  api.call("xrAttachSessionActionSets", api.AttachSessionActionSets, session, &attach);
  for (std::size_t i = 0; i < 2; ++i) {
    for (const auto& [pose, space] : {std::pair{aim, &aim_spaces[i]}, std::pair{grip, &grip_spaces[i]}}) {
      const XrActionSpaceCreateInfo info{XR_TYPE_ACTION_SPACE_CREATE_INFO, nullptr, pose, hands[i], identity()};
      api.call("xrCreateActionSpace", api.CreateActionSpace, session, &info, space);
    }
  }
}

Input::~Input() {
  for (const auto* spaces : {&aim_spaces, &grip_spaces})
    for (XrSpace space : *spaces)
      if (space) api.attempt("xrDestroySpace", api.DestroySpace, space);
  // this call also destroys the actions of the set
  if (set) api.attempt("xrDestroyActionSet", api.DestroyActionSet, set);
}

XrPath Input::path(const std::string& text) {
  XrPath path = XR_NULL_PATH;
  api.call("xrStringToPath", api.StringToPath, api.instance(), text.c_str(), &path);
  return path;
}

XrAction Input::action(const char* name, const char* title, XrActionType type) {
  XrActionCreateInfo info{XR_TYPE_ACTION_CREATE_INFO};
  std::strcpy(info.actionName, name);
  std::strcpy(info.localizedActionName, title);
  info.actionType = type;
  info.countSubactionPaths = 2;
  info.subactionPaths = hands.data();
  XrAction made = XR_NULL_HANDLE;
  api.call("xrCreateAction", api.CreateAction, set, &info, &made);
  return made;
}

void Input::suggest() {
  for (const Profile& profile : kProfiles) {
    std::vector<XrActionSuggestedBinding> bindings;
    for (std::size_t side = 0; side < 2; ++side) {
      const auto bind = [&](XrAction what, const char* component) {
        if (component) bindings.push_back({what, path(fmt::format("{}/{}", kHands[side], component))});
      };
      bind(grip, "input/grip/pose");
      bind(aim, "input/aim/pose");
      bind(vibration_, "output/haptic");
      const std::array<XrAction, 4> order{pedal, change_tool, mirror, recentre};
      for (std::size_t i = 0; i < order.size(); ++i)
        bind(order[i], side ? profile.buttons[i].right : profile.buttons[i].left);
    }
    const XrInteractionProfileSuggestedBinding info{XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING, nullptr,
                                                    path(profile.path), static_cast<std::uint32_t>(bindings.size()),
                                                    bindings.data()};
    // Runtimes may reject controllers that they do not know.
    const XrResult result = api.attempt("xrSuggestInteractionProfileBindings", api.SuggestInteractionProfileBindings,
                                        api.instance(), &info);
    if (XR_FAILED(result) && result != XR_ERROR_PATH_UNSUPPORTED)
      Api::fail("xrSuggestInteractionProfileBindings", result);
  }
}

bool Input::pressed(XrAction what, XrPath hand) {
  const XrActionStateGetInfo info{XR_TYPE_ACTION_STATE_GET_INFO, nullptr, what, hand};
  XrActionStateBoolean state{XR_TYPE_ACTION_STATE_BOOLEAN};
  api.call("xrGetActionStateBoolean", api.GetActionStateBoolean, session, &info, &state);
  return state.isActive && state.changedSinceLastSync && state.currentState;
}

Input::State Input::read(XrSpace base, XrTime time) {
  State out;
  const XrActiveActionSet active{set, XR_NULL_PATH};
  const XrActionsSyncInfo sync{XR_TYPE_ACTIONS_SYNC_INFO, nullptr, 1, &active};
  out.focused = api.call("xrSyncActions", api.SyncActions, session, &sync) == XR_SUCCESS;
  if (!out.focused) return out;  // another program receives the input of the controllers
  for (std::size_t i = 0; i < 2; ++i) {
    Hand& hand = out.hands[i];
    const XrActionStateGetInfo pedal_info{XR_TYPE_ACTION_STATE_GET_INFO, nullptr, pedal, hands[i]};
    XrActionStateFloat value{XR_TYPE_ACTION_STATE_FLOAT};
    api.call("xrGetActionStateFloat", api.GetActionStateFloat, session, &pedal_info, &value);
    const double pull = value.isActive && std::isfinite(value.currentState) ? value.currentState : 0.0;
    hand.pedal = std::clamp(pull, 0.0, 1.0);
    hand.change_tool = pressed(change_tool, hands[i]);
    hand.mirror = pressed(mirror, hands[i]);
    out.recentre = pressed(recentre, hands[i]) || out.recentre;
    // Uses the aim pose, or else the grip pose.
    for (const auto& [what, space] : {std::pair{aim, aim_spaces[i]}, std::pair{grip, grip_spaces[i]}}) {
      const XrActionStateGetInfo info{XR_TYPE_ACTION_STATE_GET_INFO, nullptr, what, hands[i]};
      XrActionStatePose state{XR_TYPE_ACTION_STATE_POSE};
      api.call("xrGetActionStatePose", api.GetActionStatePose, session, &info, &state);
      if (!state.isActive) continue;
      XrSpaceLocation location{XR_TYPE_SPACE_LOCATION};
      api.call("xrLocateSpace", api.LocateSpace, space, base, time, &location);
      // Poses that are valid but not tracked must not move a drill.
      if ((location.locationFlags & kTracked) != kTracked) continue;
      hand.tracked = true;
      hand.X_DA = pose_of(location.pose);
      break;
    }
    if (!hand.tracked) hand.pedal = 0;
  }
  return out;
}

void Input::vibrate(int hand, const Vibration& vibration, XrDuration duration) {
  const auto i = static_cast<std::size_t>(hand);
  const XrHapticActionInfo info{XR_TYPE_HAPTIC_ACTION_INFO, nullptr, vibration_, hands[i]};
  const bool on = vibration.amplitude > 0;
  if (on) {
    XrHapticVibration pulse{XR_TYPE_HAPTIC_VIBRATION};
    pulse.duration = duration;
    pulse.frequency = static_cast<float>(vibration.frequency);
    pulse.amplitude = static_cast<float>(std::min(vibration.amplitude, 1.0));
    api.call("xrApplyHapticFeedback", api.ApplyHapticFeedback, session, &info,
             reinterpret_cast<const XrHapticBaseHeader*>(&pulse));
  } else if (vibrates[i]) {
    api.call("xrStopHapticFeedback", api.StopHapticFeedback, session, &info);
  }
  vibrates[i] = on;
}

std::string Input::profiles() {
  std::string text;
  for (std::size_t i = 0; i < 2; ++i) {
    XrInteractionProfileState state{XR_TYPE_INTERACTION_PROFILE_STATE};
    const XrResult result =
        api.attempt("xrGetCurrentInteractionProfile", api.GetCurrentInteractionProfile, session, hands[i], &state);
    if (XR_FAILED(result) || state.interactionProfile == XR_NULL_PATH) continue;
    char name[XR_MAX_PATH_LENGTH] = "";
    std::uint32_t length = 0;
    api.call("xrPathToString", api.PathToString, api.instance(), state.interactionProfile,
             static_cast<std::uint32_t>(sizeof name), &length, static_cast<char*>(name));
    constexpr std::string_view kPrefix = "/interaction_profiles/";
    std::string_view short_name = name;
    if (short_name.starts_with(kPrefix)) short_name.remove_prefix(kPrefix.size());
    text += fmt::format("{}{} hand {}", text.empty() ? "" : ", ", i ? "right" : "left", short_name);
  }
  return text;
}

}  // namespace typodont::display::xr
