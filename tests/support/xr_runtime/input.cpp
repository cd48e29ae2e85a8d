// Actions: their bindings, the rules for them, and the scripted hands that provide their values.
#include <algorithm>
#include <cmath>

#include "tests/support/xr_runtime/runtime.h"

namespace typodont::test::xr {

namespace {

/// The input paths of a profile after /user/hand/SIDE/, from the specification.
struct Profile {
  std::set<std::string> both, left, right;
};

const std::map<std::string, Profile>& profiles() {
  const std::set<std::string> poses{"input/grip/pose", "input/aim/pose", "output/haptic"};
  const auto with = [&](std::set<std::string> more) {
    more.insert(poses.begin(), poses.end());
    return more;
  };
  static const std::map<std::string, Profile> table{
      {"/interaction_profiles/khr/simple_controller", {with({"input/select/click", "input/menu/click"}), {}, {}}},
      {"/interaction_profiles/oculus/touch_controller",
       {with({"input/squeeze/value", "input/trigger/value", "input/trigger/touch", "input/thumbstick",
              "input/thumbstick/x", "input/thumbstick/y", "input/thumbstick/click", "input/thumbstick/touch",
              "input/thumbrest/touch"}),
        {"input/x/click", "input/x/touch", "input/y/click", "input/y/touch", "input/menu/click"},
        {"input/a/click", "input/a/touch", "input/b/click", "input/b/touch", "input/system/click"}}},
      {"/interaction_profiles/valve/index_controller",
       {with({"input/system/click",  "input/system/touch",  "input/a/click",          "input/a/touch",
              "input/b/click",       "input/b/touch",       "input/squeeze/value",    "input/squeeze/force",
              "input/trigger/click", "input/trigger/value", "input/trigger/touch",    "input/thumbstick",
              "input/thumbstick/x",  "input/thumbstick/y",  "input/thumbstick/click", "input/thumbstick/touch",
              "input/trackpad",      "input/trackpad/x",    "input/trackpad/y",       "input/trackpad/force",
              "input/trackpad/touch"}),
        {},
        {}}},
      {"/interaction_profiles/htc/vive_controller",
       {with({"input/system/click", "input/squeeze/click", "input/menu/click", "input/trigger/click",
              "input/trigger/value", "input/trackpad", "input/trackpad/x", "input/trackpad/y", "input/trackpad/click",
              "input/trackpad/touch"}),
        {},
        {}}},
      {"/interaction_profiles/microsoft/motion_controller",
       {with({"input/menu/click", "input/squeeze/click", "input/trigger/value", "input/thumbstick",
              "input/thumbstick/x", "input/thumbstick/y", "input/thumbstick/click", "input/trackpad",
              "input/trackpad/x", "input/trackpad/y", "input/trackpad/click", "input/trackpad/touch"}),
        {},
        {}}},
  };
  return table;
}

constexpr const char* kHands[2] = {"/user/hand/left", "/user/hand/right"};

int side_of(const std::string& path) {
  return path.starts_with(kHands[0]) ? 0 : path.starts_with(kHands[1]) ? 1 : -1;
}

Action* find(XrAction handle, const char* call) {
  const auto found = runtime().actions.find(handle);
  if (found != runtime().actions.end()) return found->second.get();
  violation(XR_ERROR_HANDLE_INVALID, "{}: no such action", call);
  return nullptr;
}

bool good_name(const char* name) {
  const std::string s = name;
  return !s.empty() && s.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-_.") == std::string::npos;
}

XRAPI_ATTR XrResult XRAPI_CALL create_set(XrInstance, const XrActionSetCreateInfo* info, XrActionSet* set) {
  if (const XrResult refused = enter("xrCreateActionSet")) return refused;
  if (!typed(info, XR_TYPE_ACTION_SET_CREATE_INFO, "xrCreateActionSet", "info")) return XR_ERROR_VALIDATION_FAILURE;
  if (!good_name(info->actionSetName) || !info->localizedActionSetName[0])
    return violation(XR_ERROR_NAME_INVALID, "xrCreateActionSet: \"{}\"", info->actionSetName);
  *set = runtime().handle<XrActionSet>();
  runtime().sets[*set] = std::make_unique<ActionSet>(ActionSet{info->actionSetName, false});
  return XR_SUCCESS;
}
XRAPI_ATTR XrResult XRAPI_CALL destroy_set(XrActionSet set) {
  if (!runtime().sets.erase(set)) return violation(XR_ERROR_HANDLE_INVALID, "xrDestroyActionSet");
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL create_action(XrActionSet set, const XrActionCreateInfo* info, XrAction* action) {
  if (const XrResult refused = enter("xrCreateAction")) return refused;
  Runtime& r = runtime();
  if (!typed(info, XR_TYPE_ACTION_CREATE_INFO, "xrCreateAction", "info")) return XR_ERROR_VALIDATION_FAILURE;
  if (!r.sets.contains(set)) return violation(XR_ERROR_HANDLE_INVALID, "xrCreateAction: set");
  if (r.sets.at(set)->attached)
    return violation(XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, "xrCreateAction: its set is attached");
  if (!good_name(info->actionName) || !info->localizedActionName[0])
    return violation(XR_ERROR_NAME_INVALID, "xrCreateAction: \"{}\"", info->actionName);
  for (const auto& [handle, other] : r.actions)
    if (other->name == info->actionName) return violation(XR_ERROR_NAME_DUPLICATED, "xrCreateAction: {}", other->name);
  auto made = std::make_unique<Action>();
  made->name = info->actionName;
  made->type = info->actionType;
  made->set = set;
  for (std::uint32_t i = 0; i < info->countSubactionPaths; ++i) {
    if (side_of(path_text(info->subactionPaths[i])) < 0)
      return violation(XR_ERROR_PATH_UNSUPPORTED, "xrCreateAction: {}", path_text(info->subactionPaths[i]));
    made->subactions.push_back(info->subactionPaths[i]);
  }
  *action = r.handle<XrAction>();
  r.actions.emplace(*action, std::move(made));
  return XR_SUCCESS;
}

bool fits(XrActionType type, const std::string& component) {
  const bool pose = component.ends_with("/pose"), haptic = component.starts_with("output/");
  if (type == XR_ACTION_TYPE_POSE_INPUT) return pose;
  if (type == XR_ACTION_TYPE_VIBRATION_OUTPUT) return haptic;
  return !pose && !haptic;
}

XRAPI_ATTR XrResult XRAPI_CALL suggest(XrInstance, const XrInteractionProfileSuggestedBinding* info) {
  if (const XrResult refused = enter("xrSuggestInteractionProfileBindings")) return refused;
  Runtime& r = runtime();
  if (!typed(info, XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING, "xrSuggestInteractionProfileBindings", "info"))
    return XR_ERROR_VALIDATION_FAILURE;
  for (const auto& [handle, set] : r.sets)
    if (set->attached)
      return violation(XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, "xrSuggestInteractionProfileBindings: too late");
  const std::string name = path_text(info->interactionProfile);
  const auto profile = profiles().find(name);
  if (profile == profiles().end() || info->countSuggestedBindings == 0)
    return violation(XR_ERROR_PATH_UNSUPPORTED, "xrSuggestInteractionProfileBindings: {}", name);
  std::vector<XrActionSuggestedBinding> bindings(info->suggestedBindings,
                                                 info->suggestedBindings + info->countSuggestedBindings);
  for (const XrActionSuggestedBinding& b : bindings) {
    const std::string path = path_text(b.binding);
    const int side = side_of(path);
    const Action* action = find(b.action, "xrSuggestInteractionProfileBindings");
    if (!action || side < 0) return violation(XR_ERROR_PATH_UNSUPPORTED, "binding {}", path);
    const std::string component = path.substr(std::string(kHands[side]).size() + 1);
    const Profile& p = profile->second;
    if (!p.both.contains(component) && !(side ? p.right : p.left).contains(component))
      return violation(XR_ERROR_PATH_UNSUPPORTED, "binding {} does not exist in {}", path, name);
    if (!fits(action->type, component))
      return violation(XR_ERROR_PATH_UNSUPPORTED, "binding {} to {} of another type", path, action->name);
  }
  r.suggested[name] = std::move(bindings);
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL attach(XrSession session, const XrSessionActionSetsAttachInfo* info) {
  if (const XrResult refused = enter_session("xrAttachSessionActionSets", session)) return refused;
  if (!typed(info, XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO, "xrAttachSessionActionSets", "info"))
    return XR_ERROR_VALIDATION_FAILURE;
  for (std::uint32_t i = 0; i < info->countActionSets; ++i) {
    const auto set = runtime().sets.find(info->actionSets[i]);
    if (set == runtime().sets.end()) return violation(XR_ERROR_HANDLE_INVALID, "xrAttachSessionActionSets");
    if (set->second->attached)
      return violation(XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, "xrAttachSessionActionSets: twice");
    set->second->attached = true;
  }
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL action_space(XrSession session, const XrActionSpaceCreateInfo* info, XrSpace* space) {
  if (const XrResult refused = enter_session("xrCreateActionSpace", session)) return refused;
  Runtime& r = runtime();
  if (!typed(info, XR_TYPE_ACTION_SPACE_CREATE_INFO, "xrCreateActionSpace", "info")) return XR_ERROR_VALIDATION_FAILURE;
  const Action* action = find(info->action, "xrCreateActionSpace");
  if (!action) return XR_ERROR_HANDLE_INVALID;
  if (action->type != XR_ACTION_TYPE_POSE_INPUT)
    return violation(XR_ERROR_ACTION_TYPE_MISMATCH, "xrCreateActionSpace: {}", action->name);
  if (!is_unit(info->poseInActionSpace.orientation)) return violation(XR_ERROR_POSE_INVALID, "xrCreateActionSpace");
  const auto& subactions = action->subactions;
  if (info->subactionPath != XR_NULL_PATH &&
      std::find(subactions.begin(), subactions.end(), info->subactionPath) == subactions.end())
    return violation(XR_ERROR_PATH_UNSUPPORTED, "xrCreateActionSpace: {}", path_text(info->subactionPath));
  auto made = std::make_unique<Space>();
  made->kind = Space::Kind::kAction;
  made->pose = info->poseInActionSpace;
  made->hand = std::max(0, side_of(path_text(info->subactionPath)));
  made->aim = action->name.find("aim") != std::string::npos;
  made->action = info->action;
  *space = r.handle<XrSpace>();
  r.spaces.emplace(*space, std::move(made));
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL sync(XrSession session, const XrActionsSyncInfo* info) {
  if (const XrResult refused = enter_session("xrSyncActions", session)) return refused;
  Session& s = *runtime().session;
  if (!typed(info, XR_TYPE_ACTIONS_SYNC_INFO, "xrSyncActions", "info")) return XR_ERROR_VALIDATION_FAILURE;
  for (std::uint32_t i = 0; i < info->countActiveActionSets; ++i) {
    const auto set = runtime().sets.find(info->activeActionSets[i].actionSet);
    if (set == runtime().sets.end() || !set->second->attached)
      return violation(XR_ERROR_ACTIONSET_NOT_ATTACHED, "xrSyncActions");
  }
  s.synced = s.state == XR_SESSION_STATE_FOCUSED;
  return s.synced ? XR_SUCCESS : XR_SESSION_NOT_FOCUSED;
}

/// Returns the present state of the hand, or null if actions are not active.
const HandKey* hand_now(int side) {
  const Runtime& r = runtime();
  const auto& keys = r.script.hands[static_cast<std::size_t>(side)];
  if (!r.session->synced || keys.empty()) return nullptr;
  const HandKey* last = &keys.front();
  for (const HandKey& key : keys)
    if (key.frame <= r.session->script_frame()) last = &key;
  return last->tracked ? last : nullptr;
}

/// Sets `value` to the scripted value of an action for a hand. Returns false if no binding of the present profile
/// provides it.
bool value_of(XrAction action, int side, float& value) {
  const HandKey* key = hand_now(side);
  if (!key) return false;
  const auto bindings = runtime().suggested.find(runtime().script.profile);
  if (bindings == runtime().suggested.end()) return false;
  bool bound = false;
  value = 0;
  for (const XrActionSuggestedBinding& b : bindings->second) {
    const std::string path = path_text(b.binding);
    if (b.action != action || side_of(path) != side) continue;
    bound = true;
    const std::string component = path.substr(std::string(kHands[side]).size() + 7);  // after "/input/"
    const bool pressed = std::find(key->buttons.begin(), key->buttons.end(), component) != key->buttons.end();
    if (component == "trigger/value") value = std::max(value, static_cast<float>(key->trigger));
    if (component == "select/click") value = std::max(value, key->trigger > 0.5 ? 1.0f : 0.0f);
    if (pressed) value = 1;
  }
  return bound;
}

Action* fetch(XrSession session, const XrActionStateGetInfo* info, XrActionType type, const char* call,
              XrResult& result, int& side) {
  result = enter_session(call, session);
  if (result != XR_SUCCESS) return nullptr;
  result = XR_ERROR_VALIDATION_FAILURE;
  if (!typed(info, XR_TYPE_ACTION_STATE_GET_INFO, call, "info")) return nullptr;
  Action* action = find(info->action, call);
  if (!action) return nullptr;
  if (action->type != type) {
    result = violation(XR_ERROR_ACTION_TYPE_MISMATCH, "{}: {}", call, action->name);
    return nullptr;
  }
  if (!runtime().sets.at(action->set)->attached) {
    result = violation(XR_ERROR_ACTIONSET_NOT_ATTACHED, "{}: {}", call, action->name);
    return nullptr;
  }
  side = side_of(path_text(info->subactionPath));
  result = XR_SUCCESS;
  return action;
}

XRAPI_ATTR XrResult XRAPI_CALL state_bool(XrSession session, const XrActionStateGetInfo* info,
                                          XrActionStateBoolean* state) {
  XrResult result;
  int side = -1;
  Action* action = fetch(session, info, XR_ACTION_TYPE_BOOLEAN_INPUT, "xrGetActionStateBoolean", result, side);
  if (!action) return result;
  if (!typed(state, XR_TYPE_ACTION_STATE_BOOLEAN, "xrGetActionStateBoolean", "state"))
    return XR_ERROR_VALIDATION_FAILURE;
  bool active = false, on = false;
  for (const int hand : {0, 1}) {
    if (side >= 0 && side != hand) continue;
    float value = 0;
    if (!value_of(info->action, hand, value)) continue;
    active = true;
    on = on || value > 0.5f;
  }
  bool& last = action->last_bool[info->subactionPath];
  *state = {XR_TYPE_ACTION_STATE_BOOLEAN, nullptr, on, active && on != last, time_now(), active};
  last = on;
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL state_float(XrSession session, const XrActionStateGetInfo* info,
                                           XrActionStateFloat* state) {
  XrResult result;
  int side = -1;
  if (!fetch(session, info, XR_ACTION_TYPE_FLOAT_INPUT, "xrGetActionStateFloat", result, side)) return result;
  if (!typed(state, XR_TYPE_ACTION_STATE_FLOAT, "xrGetActionStateFloat", "state")) return XR_ERROR_VALIDATION_FAILURE;
  bool active = false;
  float most = 0;
  for (const int hand : {0, 1}) {
    if (side >= 0 && side != hand) continue;
    float value = 0;
    if (!value_of(info->action, hand, value)) continue;
    active = true;
    most = std::max(most, value);
  }
  *state = {XR_TYPE_ACTION_STATE_FLOAT, nullptr, most, XR_FALSE, time_now(), active};
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL state_pose(XrSession session, const XrActionStateGetInfo* info,
                                          XrActionStatePose* state) {
  XrResult result;
  int side = -1;
  if (!fetch(session, info, XR_ACTION_TYPE_POSE_INPUT, "xrGetActionStatePose", result, side)) return result;
  if (!typed(state, XR_TYPE_ACTION_STATE_POSE, "xrGetActionStatePose", "state")) return XR_ERROR_VALIDATION_FAILURE;
  state->isActive = side >= 0 && hand_now(side) != nullptr;
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL apply_haptics(XrSession session, const XrHapticActionInfo* info,
                                             const XrHapticBaseHeader* feedback) {
  if (const XrResult refused = enter_session("xrApplyHapticFeedback", session)) return refused;
  Runtime& r = runtime();
  if (!typed(info, XR_TYPE_HAPTIC_ACTION_INFO, "xrApplyHapticFeedback", "info")) return XR_ERROR_VALIDATION_FAILURE;
  const Action* action = find(info->action, "xrApplyHapticFeedback");
  if (!action) return XR_ERROR_HANDLE_INVALID;
  if (action->type != XR_ACTION_TYPE_VIBRATION_OUTPUT)
    return violation(XR_ERROR_ACTION_TYPE_MISMATCH, "xrApplyHapticFeedback: {}", action->name);
  const auto* v = reinterpret_cast<const XrHapticVibration*>(feedback);
  if (!typed(v, XR_TYPE_HAPTIC_VIBRATION, "xrApplyHapticFeedback", "vibration")) return XR_ERROR_VALIDATION_FAILURE;
  if (!(v->amplitude >= 0 && v->amplitude <= 1) || !(v->frequency >= 0 && v->frequency <= 1000) || v->duration <= 0)
    return violation(XR_ERROR_VALIDATION_FAILURE, "xrApplyHapticFeedback: {} at {} Hz for {} ns", v->amplitude,
                     v->frequency, v->duration);
  if (r.session->state != XR_SESSION_STATE_FOCUSED) return XR_SESSION_NOT_FOCUSED;
  ++r.haptics;
  log("vibration {} {:.3f} {:.1f}", path_text(info->subactionPath), v->amplitude, v->frequency);
  return XR_SUCCESS;
}
XRAPI_ATTR XrResult XRAPI_CALL stop_haptics(XrSession session, const XrHapticActionInfo* info) {
  if (const XrResult refused = enter_session("xrStopHapticFeedback", session)) return refused;
  if (!typed(info, XR_TYPE_HAPTIC_ACTION_INFO, "xrStopHapticFeedback", "info")) return XR_ERROR_VALIDATION_FAILURE;
  if (!find(info->action, "xrStopHapticFeedback")) return XR_ERROR_HANDLE_INVALID;
  if (runtime().session->state != XR_SESSION_STATE_FOCUSED) return XR_SESSION_NOT_FOCUSED;
  log("vibration {} stops", path_text(info->subactionPath));
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL current_profile(XrSession session, XrPath top, XrInteractionProfileState* state) {
  if (const XrResult refused = enter_session("xrGetCurrentInteractionProfile", session)) return refused;
  if (!typed(state, XR_TYPE_INTERACTION_PROFILE_STATE, "xrGetCurrentInteractionProfile", "state"))
    return XR_ERROR_VALIDATION_FAILURE;
  if (side_of(path_text(top)) < 0) return violation(XR_ERROR_PATH_UNSUPPORTED, "xrGetCurrentInteractionProfile");
  const auto& r = runtime();
  const bool there = !r.script.hands[static_cast<std::size_t>(side_of(path_text(top)))].empty() &&
                     r.suggested.contains(r.script.profile);
  state->interactionProfile = there ? path_number(r.script.profile) : XR_NULL_PATH;
  return XR_SUCCESS;
}

}  // namespace

const Functions& input_functions() {
  static const Functions table{
      {"xrCreateActionSet", plain(create_set)},
      {"xrDestroyActionSet", plain(destroy_set)},
      {"xrCreateAction", plain(create_action)},
      {"xrSuggestInteractionProfileBindings", plain(suggest)},
      {"xrAttachSessionActionSets", plain(attach)},
      {"xrCreateActionSpace", plain(action_space)},
      {"xrSyncActions", plain(sync)},
      {"xrGetActionStateBoolean", plain(state_bool)},
      {"xrGetActionStateFloat", plain(state_float)},
      {"xrGetActionStatePose", plain(state_pose)},
      {"xrApplyHapticFeedback", plain(apply_haptics)},
      {"xrStopHapticFeedback", plain(stop_haptics)},
      {"xrGetCurrentInteractionProfile", plain(current_profile)},
  };
  return table;
}

}  // namespace typodont::test::xr
