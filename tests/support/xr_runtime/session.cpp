// Sessions, spaces, frames. Mainly checks the order of calls.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "tests/support/xr_runtime/runtime.h"

namespace typodont::test::xr {

XrResult enter_session(const char* call, XrSession session, bool destroys) {
  if (const XrResult refused = enter(call)) return refused;
  Runtime& r = runtime();
  if (!r.session || reinterpret_cast<std::uintptr_t>(session) != 0x42)
    return violation(XR_ERROR_HANDLE_INVALID, "{}: no such session", call);
  if (r.session->lost && !destroys) return XR_ERROR_SESSION_LOST;
  return XR_SUCCESS;
}

namespace {

template <class Key>
std::pair<const Key*, double> between(const std::vector<Key>& keys, double frame, const Key** next) {
  const Key* last = &keys.front();
  for (const Key& key : keys) {
    if (key.frame > frame) {
      *next = &key;
      return {last, std::clamp((frame - last->frame) / (key.frame - last->frame), 0.0, 1.0)};
    }
    last = &key;
  }
  *next = last;
  return {last, 0.0};
}

XrPosef blend(const ScriptPose& a, const ScriptPose& b, double fraction) {
  std::array<double, 4> q{};
  double sign = 0, norm = 0;
  for (std::size_t i = 0; i < 4; ++i) sign += a.q[i] * b.q[i];
  for (std::size_t i = 0; i < 4; ++i) q[i] = (1 - fraction) * a.q[i] + (sign < 0 ? -fraction : fraction) * b.q[i];
  for (const double v : q) norm += v * v;
  norm = std::sqrt(norm);
  const auto mixed = [&](std::size_t i) { return static_cast<float>((1 - fraction) * a.p[i] + fraction * b.p[i]); };
  return {{static_cast<float>(q[1] / norm), static_cast<float>(q[2] / norm), static_cast<float>(q[3] / norm),
           static_cast<float>(q[0] / norm)},
          {mixed(0), mixed(1), mixed(2)}};
}

XrPosef head_at(XrTime time) {
  const Runtime& r = runtime();
  const HeadKey* next = nullptr;
  const auto [last, fraction] = between(r.script.head, frame_at(time), &next);
  XrPosef pose = blend(last->pose, next->pose, fraction);
  // A predicted pose has this error; a past pose is exact.
  if (r.session && time >= r.session->display_time) pose.position.x += static_cast<float>(r.script.prediction_error);
  return pose;
}

XRAPI_ATTR XrResult XRAPI_CALL create_session(XrInstance, const XrSessionCreateInfo* info, XrSession* session) {
  if (const XrResult refused = enter("xrCreateSession")) return refused;
  Runtime& r = runtime();
  if (!typed(info, XR_TYPE_SESSION_CREATE_INFO, "xrCreateSession", "info")) return XR_ERROR_VALIDATION_FAILURE;
  if (!r.requirements_asked)
    return violation(XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING, "xrCreateSession: requirements not asked");
  const auto* vulkan = static_cast<const XrGraphicsBindingVulkanKHR*>(info->next);
  if (!typed(vulkan, XR_TYPE_GRAPHICS_BINDING_VULKAN_KHR, "xrCreateSession", "graphics binding"))
    return XR_ERROR_GRAPHICS_DEVICE_INVALID;
  if (vulkan->instance != r.vk_instance || vulkan->physicalDevice != r.vk_physical || vulkan->device != r.vk_device)
    return violation(XR_ERROR_GRAPHICS_DEVICE_INVALID, "xrCreateSession: not the device made through the runtime");
  if (r.session) return XR_ERROR_LIMIT_REACHED;
  r.session = std::make_unique<Session>();
  Session& s = *r.session;
  s.device = vulkan->device;
  s.physical = vulkan->physicalDevice;
  s.queue_family = vulkan->queueFamilyIndex;
  vkGetDeviceQueue(s.device, vulkan->queueFamilyIndex, vulkan->queueIndex, &s.queue);
  const VkCommandPoolCreateInfo pool{.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                     .queueFamilyIndex = s.queue_family};
  if (vkCreateCommandPool(s.device, &pool, nullptr, &s.pool) != VK_SUCCESS) return XR_ERROR_RUNTIME_FAILURE;
  s.idle_polls = r.script.asleep ? -1 : 2;
  *session = reinterpret_cast<XrSession>(std::uintptr_t{0x42});
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL destroy_session(XrSession session) {
  if (const XrResult refused = enter_session("xrDestroySession", session, true)) return refused;
  Runtime& r = runtime();
  log("frames {} waited {} begun {} ended", r.session->waited, r.session->begun, r.session->ended);
  vkDeviceWaitIdle(r.session->device);
  destroy_swapchains();
  vkDestroyCommandPool(r.session->device, r.session->pool, nullptr);
  r.spaces.clear();
  r.session.reset();
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL begin_session(XrSession session, const XrSessionBeginInfo* info) {
  if (const XrResult refused = enter_session("xrBeginSession", session)) return refused;
  Session& s = *runtime().session;
  if (!typed(info, XR_TYPE_SESSION_BEGIN_INFO, "xrBeginSession", "info")) return XR_ERROR_VALIDATION_FAILURE;
  if (s.running) return violation(XR_ERROR_SESSION_RUNNING, "xrBeginSession: it runs");
  // A script may have changed the state between the event and this call: return an error, but do not log a violation.
  if (s.state != XR_SESSION_STATE_READY) {
    log("xrBeginSession: not ready");
    return XR_ERROR_SESSION_NOT_READY;
  }
  if (info->primaryViewConfigurationType != XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO)
    return violation(XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED, "xrBeginSession: not stereo");
  s.running = true;
  s.first_of_run = s.waited;
  s.begun = s.ended = s.waited;
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL end_session(XrSession session) {
  if (const XrResult refused = enter_session("xrEndSession", session)) return refused;
  Session& s = *runtime().session;
  if (!s.running) return violation(XR_ERROR_SESSION_NOT_RUNNING, "xrEndSession: it does not run");
  // the state changed in the meantime
  if (s.state == XR_SESSION_STATE_LOSS_PENDING) return XR_ERROR_SESSION_NOT_STOPPING;
  if (s.state != XR_SESSION_STATE_STOPPING)
    return violation(XR_ERROR_SESSION_NOT_STOPPING, "xrEndSession: not stopping");
  s.running = false;
  set_state(XR_SESSION_STATE_IDLE);
  if (s.exiting) set_state(XR_SESSION_STATE_EXITING);
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL request_exit(XrSession session) {
  if (const XrResult refused = enter_session("xrRequestExitSession", session)) return refused;
  Session& s = *runtime().session;
  if (!s.running) return violation(XR_ERROR_SESSION_NOT_RUNNING, "xrRequestExitSession: it does not run");
  s.exiting = true;
  if (s.state == XR_SESSION_STATE_FOCUSED) set_state(XR_SESSION_STATE_VISIBLE);
  if (s.state == XR_SESSION_STATE_VISIBLE) set_state(XR_SESSION_STATE_SYNCHRONIZED);
  if (s.state != XR_SESSION_STATE_STOPPING) set_state(XR_SESSION_STATE_STOPPING);
  return XR_SUCCESS;
}

// --- spaces

XRAPI_ATTR XrResult XRAPI_CALL reference_spaces(XrSession session, std::uint32_t capacity, std::uint32_t* count,
                                                XrReferenceSpaceType* types) {
  if (const XrResult refused = enter_session("xrEnumerateReferenceSpaces", session)) return refused;
  std::vector<XrReferenceSpaceType> all;
  for (const std::string& name : runtime().script.spaces)
    all.push_back(name == "view"    ? XR_REFERENCE_SPACE_TYPE_VIEW
                  : name == "stage" ? XR_REFERENCE_SPACE_TYPE_STAGE
                                    : XR_REFERENCE_SPACE_TYPE_LOCAL);
  return give(all, capacity, count, types, "xrEnumerateReferenceSpaces");
}

XRAPI_ATTR XrResult XRAPI_CALL create_reference_space(XrSession session, const XrReferenceSpaceCreateInfo* info,
                                                      XrSpace* space) {
  if (const XrResult refused = enter_session("xrCreateReferenceSpace", session)) return refused;
  if (!typed(info, XR_TYPE_REFERENCE_SPACE_CREATE_INFO, "xrCreateReferenceSpace", "info"))
    return XR_ERROR_VALIDATION_FAILURE;
  const std::string name = info->referenceSpaceType == XR_REFERENCE_SPACE_TYPE_VIEW    ? "view"
                           : info->referenceSpaceType == XR_REFERENCE_SPACE_TYPE_LOCAL ? "local"
                                                                                       : "stage";
  const auto& offered = runtime().script.spaces;
  if (std::find(offered.begin(), offered.end(), name) == offered.end())
    return violation(XR_ERROR_REFERENCE_SPACE_UNSUPPORTED, "xrCreateReferenceSpace: {} is not offered", name);
  if (!is_unit(info->poseInReferenceSpace.orientation))
    return violation(XR_ERROR_POSE_INVALID, "xrCreateReferenceSpace: pose");
  Runtime& r = runtime();
  *space = r.handle<XrSpace>();
  auto made = std::make_unique<Space>();
  made->kind = name == "view" ? Space::Kind::kView : name == "local" ? Space::Kind::kLocal : Space::Kind::kStage;
  made->pose = info->poseInReferenceSpace;
  r.spaces.emplace(*space, std::move(made));
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL destroy_space(XrSpace space) {
  if (const XrResult refused = enter("xrDestroySpace")) return refused;
  if (!runtime().spaces.erase(space)) return violation(XR_ERROR_HANDLE_INVALID, "xrDestroySpace");
  return XR_SUCCESS;
}

constexpr XrSpaceLocationFlags kLocated =
    XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT |
    XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT | XR_SPACE_LOCATION_POSITION_TRACKED_BIT;
constexpr XrTime kHistory = 400'000'000;  // ns of pose history; the specification requires at least 50 ms

XRAPI_ATTR XrResult XRAPI_CALL locate_space(XrSpace space, XrSpace base, XrTime time, XrSpaceLocation* location) {
  if (const XrResult refused = enter("xrLocateSpace")) return refused;
  Runtime& r = runtime();
  if (!r.session) return violation(XR_ERROR_HANDLE_INVALID, "xrLocateSpace: no session");
  if (r.session->lost) return XR_ERROR_SESSION_LOST;
  if (!typed(location, XR_TYPE_SPACE_LOCATION, "xrLocateSpace", "location")) return XR_ERROR_VALIDATION_FAILURE;
  const auto a = r.spaces.find(space), b = r.spaces.find(base);
  if (a == r.spaces.end() || b == r.spaces.end()) return violation(XR_ERROR_HANDLE_INVALID, "xrLocateSpace: space");
  if (time <= 0) return violation(XR_ERROR_TIME_INVALID, "xrLocateSpace: time {}", time);
  location->locationFlags = 0;
  XrPosef pose_a, pose_b;
  if (time < r.session->display_time - kHistory || r.session->unlocatable > 0 || !locate(*a->second, time, pose_a) ||
      !locate(*b->second, time, pose_b)) {
    // An invalid pose is filled with NaN, to detect its use.
    location->pose = {{NAN, NAN, NAN, NAN}, {NAN, NAN, NAN}};
    return XR_SUCCESS;
  }
  location->pose = multiply(invert(pose_b), pose_a);
  location->locationFlags = kLocated;
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL locate_views(XrSession session, const XrViewLocateInfo* info, XrViewState* state,
                                            std::uint32_t capacity, std::uint32_t* count, XrView* views) {
  if (const XrResult refused = enter_session("xrLocateViews", session)) return refused;
  Runtime& r = runtime();
  if (!typed(info, XR_TYPE_VIEW_LOCATE_INFO, "xrLocateViews", "info") ||
      !typed(state, XR_TYPE_VIEW_STATE, "xrLocateViews", "state"))
    return XR_ERROR_VALIDATION_FAILURE;
  if (info->displayTime <= 0) return violation(XR_ERROR_TIME_INVALID, "xrLocateViews: time {}", info->displayTime);
  const auto base = r.spaces.find(info->space);
  if (base == r.spaces.end()) return violation(XR_ERROR_HANDLE_INVALID, "xrLocateViews: space");
  *count = 2;
  if (capacity == 0) return XR_SUCCESS;
  if (capacity < 2) return violation(XR_ERROR_SIZE_INSUFFICIENT, "xrLocateViews: room for {}", capacity);
  XrPosef pose_b;
  const bool located = r.session->unlocatable <= 0 && locate(*base->second, info->displayTime, pose_b);
  state->viewStateFlags = located ? XR_VIEW_STATE_ORIENTATION_VALID_BIT | XR_VIEW_STATE_POSITION_VALID_BIT |
                                        XR_VIEW_STATE_ORIENTATION_TRACKED_BIT | XR_VIEW_STATE_POSITION_TRACKED_BIT
                                  : 0;
  for (std::size_t i = 0; i < 2; ++i) {
    if (!typed(views + i, XR_TYPE_VIEW, "xrLocateViews", "a view")) return XR_ERROR_VALIDATION_FAILURE;
    if (!located) {
      views[i].pose = {{NAN, NAN, NAN, NAN}, {NAN, NAN, NAN}};
      views[i].fov = {0, 0, 0, 0};
      continue;
    }
    const ScriptView& eye = r.script.views[i];
    views[i].pose = multiply(multiply(invert(pose_b), head_at(info->displayTime)), blend(eye.pose, eye.pose, 0));
    views[i].fov = {static_cast<float>(eye.fov[0]), static_cast<float>(eye.fov[1]), static_cast<float>(eye.fov[2]),
                    static_cast<float>(eye.fov[3])};
  }
  return XR_SUCCESS;
}

// --- frames

XRAPI_ATTR XrResult XRAPI_CALL wait_frame(XrSession session, const XrFrameWaitInfo*, XrFrameState* state) {
  if (const XrResult refused = enter_session("xrWaitFrame", session)) return refused;
  Runtime& r = runtime();
  Session& s = *r.session;
  if (!typed(state, XR_TYPE_FRAME_STATE, "xrWaitFrame", "state")) return XR_ERROR_VALIDATION_FAILURE;
  if (!s.running) return violation(XR_ERROR_SESSION_NOT_RUNNING, "xrWaitFrame: the session does not run");
  if (s.waited > s.begun) return violation(XR_ERROR_CALL_ORDER_INVALID, "xrWaitFrame: the last one was not begun");
  fire_events();
  if (s.lost) return XR_ERROR_SESSION_LOST;
  if (r.instance_lost) return XR_ERROR_INSTANCE_LOST;
  if (r.stall_call == "xrWaitFrame") (void)enter("xrWaitFrame");
  if (r.script.paced) {
    const XrTime due = s.last_wait + period(), t = time_now();
    if (t < due) std::this_thread::sleep_for(std::chrono::nanoseconds(due - t));
    if (s.last_wait > 0 && t > due) {
      const XrTime gone = (t - due) / period();
      s.skipped += static_cast<std::uint64_t>(gone);
      s.last_wait = due + gone * period();
    } else {
      s.last_wait = std::max(due, t);
    }
  }
  const XrTime before = s.display_time;
  s.display_time = r.script.paced ? s.last_wait + 2 * period() : std::max(time_now(), before) + period();
  ++s.waited;
  if (s.no_render > 0) --s.no_render;
  if (s.unlocatable > 0) --s.unlocatable;
  const bool shown = s.state == XR_SESSION_STATE_VISIBLE || s.state == XR_SESSION_STATE_FOCUSED;
  state->shouldRender = shown && s.no_render <= 0;
  state->predictedDisplayTime = s.display_time;
  state->predictedDisplayPeriod = period();
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL begin_frame(XrSession session, const XrFrameBeginInfo*) {
  if (const XrResult refused = enter_session("xrBeginFrame", session)) return refused;
  Session& s = *runtime().session;
  if (!s.running) return violation(XR_ERROR_SESSION_NOT_RUNNING, "xrBeginFrame: the session does not run");
  if (s.begun >= s.waited) return violation(XR_ERROR_CALL_ORDER_INVALID, "xrBeginFrame: no frame was waited for");
  const bool discarded = s.ended < s.begun;
  if (discarded) {
    violation(XR_SUCCESS, "xrBeginFrame: frame {} was never ended", s.begun);
    s.ended = s.begun;
  }
  s.begun = s.waited;
  s.begun_time[s.begun % 2] = s.display_time;
  return discarded ? XR_FRAME_DISCARDED : XR_SUCCESS;
}

bool check_fov(const XrFovf& fov) {
  return fov.angleLeft < fov.angleRight && fov.angleDown < fov.angleUp && std::abs(fov.angleLeft) < 1.5707f &&
         std::abs(fov.angleRight) < 1.5707f && std::abs(fov.angleUp) < 1.5707f && std::abs(fov.angleDown) < 1.5707f;
}

XrResult check_projection(const XrCompositionLayerProjection& layer) {
  Runtime& r = runtime();
  if (layer.viewCount != 2) return violation(XR_ERROR_VALIDATION_FAILURE, "layer: {} views", layer.viewCount);
  if (!r.spaces.contains(layer.space)) return violation(XR_ERROR_HANDLE_INVALID, "layer: space");
  for (std::uint32_t i = 0; i < 2; ++i) {
    const XrCompositionLayerProjectionView& view = layer.views[i];
    if (!typed(&view, XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW, "xrEndFrame", "a view"))
      return XR_ERROR_VALIDATION_FAILURE;
    if (!is_unit(view.pose.orientation)) return violation(XR_ERROR_POSE_INVALID, "layer: view {} pose", i);
    if (!check_fov(view.fov)) return violation(XR_ERROR_VALIDATION_FAILURE, "layer: view {} fov", i);
    if (!check_sub_image(view.subImage, false, "layer")) return XR_ERROR_LAYER_INVALID;
    for (const auto* next = static_cast<const XrBaseInStructure*>(view.next); next; next = next->next) {
      if (next->type != XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR)
        return violation(XR_ERROR_VALIDATION_FAILURE, "layer: view {} chains {}", i, static_cast<int>(next->type));
      const auto* depth = reinterpret_cast<const XrCompositionLayerDepthInfoKHR*>(next);
      if (!r.extensions.contains("XR_KHR_composition_layer_depth"))
        return violation(XR_ERROR_VALIDATION_FAILURE, "layer: depth without its extension");
      if (!check_sub_image(depth->subImage, true, "depth")) return XR_ERROR_LAYER_INVALID;
      if (depth->minDepth < 0 || depth->maxDepth > 1 || depth->minDepth >= depth->maxDepth || depth->nearZ <= 0 ||
          depth->nearZ == depth->farZ)
        return violation(XR_ERROR_VALIDATION_FAILURE, "depth: range");
      if (depth->subImage.imageRect.extent.width != view.subImage.imageRect.extent.width)
        return violation(XR_ERROR_VALIDATION_FAILURE, "depth: another size than the colour");
    }
  }
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL end_frame(XrSession session, const XrFrameEndInfo* info) {
  if (const XrResult refused = enter_session("xrEndFrame", session)) return refused;
  Runtime& r = runtime();
  Session& s = *r.session;
  if (!typed(info, XR_TYPE_FRAME_END_INFO, "xrEndFrame", "info")) return XR_ERROR_VALIDATION_FAILURE;
  if (!s.running) return violation(XR_ERROR_SESSION_NOT_RUNNING, "xrEndFrame: the session does not run");
  if (s.ended >= s.begun) return violation(XR_ERROR_CALL_ORDER_INVALID, "xrEndFrame: no frame was begun");
  const std::uint64_t frame = s.begun;
  s.ended = s.begun;
  if (info->displayTime != s.begun_time[frame % 2])
    return violation(XR_ERROR_TIME_INVALID, "xrEndFrame: frame {} shown at another time than predicted", frame);
  const std::string blend = info->environmentBlendMode == XR_ENVIRONMENT_BLEND_MODE_ALPHA_BLEND ? "alpha"
                            : info->environmentBlendMode == XR_ENVIRONMENT_BLEND_MODE_ADDITIVE  ? "additive"
                                                                                                : "opaque";
  const auto& modes = r.script.blend_modes;
  if (std::find(modes.begin(), modes.end(), blend) == modes.end())
    return violation(XR_ERROR_ENVIRONMENT_BLEND_MODE_UNSUPPORTED, "xrEndFrame: blend mode {}", blend);
  std::string shown;
  for (const auto& [handle, swapchain] : r.swapchains)
    if (!swapchain->acquired.empty())
      violation(XR_SUCCESS, "xrEndFrame: frame {} while an image of a swapchain is held", frame);
  for (std::uint32_t i = 0; i < info->layerCount; ++i) {
    const XrCompositionLayerBaseHeader* layer = info->layers[i];
    if (!layer) return violation(XR_ERROR_LAYER_INVALID, "xrEndFrame: a layer is null");
    if (layer->type == XR_TYPE_COMPOSITION_LAYER_PROJECTION) {
      const auto& projection = *reinterpret_cast<const XrCompositionLayerProjection*>(layer);
      if (const XrResult bad = check_projection(projection)) return bad;
      shown += fmt::format(" projection{}{}", projection.views[0].next ? "+depth" : "",
                           projection.layerFlags & XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT ? "+alpha" : "");
      capture(frame, projection);
    } else if (layer->type == XR_TYPE_COMPOSITION_LAYER_PASSTHROUGH_FB) {
      const auto& through = *reinterpret_cast<const XrCompositionLayerPassthroughFB*>(layer);
      if (through.space != XR_NULL_HANDLE ||
          !r.passthrough_layers.contains(reinterpret_cast<std::uint64_t>(through.layerHandle)))
        return violation(XR_ERROR_LAYER_INVALID, "xrEndFrame: passthrough layer");
      shown += " passthrough";
    } else {
      return violation(XR_ERROR_LAYER_INVALID, "xrEndFrame: layer of type {}", static_cast<int>(layer->type));
    }
  }
  log("frame {}{} {}", frame, shown.empty() ? " empty" : shown, blend);
  // The session's state advances while frames are submitted.
  if (s.state == XR_SESSION_STATE_READY)
    set_state(XR_SESSION_STATE_SYNCHRONIZED);
  else if (s.state == XR_SESSION_STATE_SYNCHRONIZED && frame == s.first_of_run + 2)
    set_state(XR_SESSION_STATE_VISIBLE);
  else if (s.state == XR_SESSION_STATE_VISIBLE && frame == s.first_of_run + 4)
    set_state(XR_SESSION_STATE_FOCUSED);
  return XR_SUCCESS;
}

// --- functions of extensions

XRAPI_ATTR XrResult XRAPI_CALL visibility_mask(XrSession session, XrViewConfigurationType, std::uint32_t view,
                                               XrVisibilityMaskTypeKHR type, XrVisibilityMaskKHR* mask) {
  if (const XrResult refused = enter_session("xrGetVisibilityMaskKHR", session)) return refused;
  Runtime& r = runtime();
  if (!r.extensions.contains("XR_KHR_visibility_mask"))
    return violation(XR_ERROR_FUNCTION_UNSUPPORTED, "xrGetVisibilityMaskKHR: not asked for");
  if (!typed(mask, XR_TYPE_VISIBILITY_MASK_KHR, "xrGetVisibilityMaskKHR", "mask")) return XR_ERROR_VALIDATION_FAILURE;
  if (view > 1 || type != XR_VISIBILITY_MASK_TYPE_HIDDEN_TRIANGLE_MESH_KHR) return XR_ERROR_VALIDATION_FAILURE;
  std::vector<XrVector2f> corners;
  std::vector<std::uint32_t> order;
  for (const auto& corner : r.script.mask) {
    order.push_back(static_cast<std::uint32_t>(order.size()));
    corners.push_back({static_cast<float>(corner[0]), static_cast<float>(corner[1])});
  }
  if (const XrResult bad =
          give(corners, mask->vertexCapacityInput, &mask->vertexCountOutput, mask->vertices, "xrGetVisibilityMaskKHR"))
    return bad;
  return give(order, mask->indexCapacityInput, &mask->indexCountOutput, mask->indices, "xrGetVisibilityMaskKHR");
}

XRAPI_ATTR XrResult XRAPI_CALL refresh_rates(XrSession session, std::uint32_t capacity, std::uint32_t* count,
                                             float* rates) {
  if (const XrResult refused = enter_session("xrEnumerateDisplayRefreshRatesFB", session)) return refused;
  std::vector<float> all;
  for (const double rate : runtime().script.refresh_rates) all.push_back(static_cast<float>(rate));
  return give(all, capacity, count, rates, "xrEnumerateDisplayRefreshRatesFB");
}
XRAPI_ATTR XrResult XRAPI_CALL request_refresh_rate(XrSession session, float rate) {
  if (const XrResult refused = enter_session("xrRequestDisplayRefreshRateFB", session)) return refused;
  const auto& rates = runtime().script.refresh_rates;
  if (std::none_of(rates.begin(), rates.end(), [&](double r) { return std::abs(r - rate) < 0.01; }))
    return violation(XR_ERROR_DISPLAY_REFRESH_RATE_UNSUPPORTED_FB, "xrRequestDisplayRefreshRateFB: {}", rate);
  log("refresh rate {}", rate);
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL create_passthrough(XrSession session, const XrPassthroughCreateInfoFB* info,
                                                  XrPassthroughFB* passthrough) {
  if (const XrResult refused = enter_session("xrCreatePassthroughFB", session)) return refused;
  if (!typed(info, XR_TYPE_PASSTHROUGH_CREATE_INFO_FB, "xrCreatePassthroughFB", "info"))
    return XR_ERROR_VALIDATION_FAILURE;
  *passthrough = runtime().handle<XrPassthroughFB>();
  runtime().passthroughs.insert(reinterpret_cast<std::uint64_t>(*passthrough));
  return XR_SUCCESS;
}
XRAPI_ATTR XrResult XRAPI_CALL destroy_passthrough(XrPassthroughFB passthrough) {
  runtime().passthroughs.erase(reinterpret_cast<std::uint64_t>(passthrough));
  return XR_SUCCESS;
}
XRAPI_ATTR XrResult XRAPI_CALL create_passthrough_layer(XrSession session, const XrPassthroughLayerCreateInfoFB* info,
                                                        XrPassthroughLayerFB* layer) {
  if (const XrResult refused = enter_session("xrCreatePassthroughLayerFB", session)) return refused;
  if (!typed(info, XR_TYPE_PASSTHROUGH_LAYER_CREATE_INFO_FB, "xrCreatePassthroughLayerFB", "info"))
    return XR_ERROR_VALIDATION_FAILURE;
  if (!runtime().passthroughs.contains(reinterpret_cast<std::uint64_t>(info->passthrough)))
    return violation(XR_ERROR_HANDLE_INVALID, "xrCreatePassthroughLayerFB: passthrough");
  *layer = runtime().handle<XrPassthroughLayerFB>();
  runtime().passthrough_layers.insert(reinterpret_cast<std::uint64_t>(*layer));
  return XR_SUCCESS;
}
XRAPI_ATTR XrResult XRAPI_CALL destroy_passthrough_layer(XrPassthroughLayerFB layer) {
  runtime().passthrough_layers.erase(reinterpret_cast<std::uint64_t>(layer));
  return XR_SUCCESS;
}

}  // namespace

bool locate(const Space& space, XrTime time, XrPosef& pose) {
  Runtime& r = runtime();
  switch (space.kind) {
    case Space::Kind::kStage:
      pose = space.pose;
      return true;
    case Space::Kind::kLocal:
      pose = multiply(r.local, space.pose);
      return true;
    case Space::Kind::kView:
      pose = multiply(head_at(time), space.pose);
      return true;
    case Space::Kind::kAction:
      break;
  }
  const auto& keys = r.script.hands[static_cast<std::size_t>(space.hand)];
  if (keys.empty() || r.session->state != XR_SESSION_STATE_FOCUSED) return false;
  const HandKey* next = nullptr;
  const auto [last, fraction] = between(keys, frame_at(time), &next);
  if (!last->tracked) return false;
  pose = multiply(blend(last->pose, next->pose, next->tracked ? fraction : 0), space.pose);
  return true;
}

const Functions& session_functions() {
  static const Functions table{
      {"xrCreateSession", plain(create_session)},
      {"xrDestroySession", plain(destroy_session)},
      {"xrBeginSession", plain(begin_session)},
      {"xrEndSession", plain(end_session)},
      {"xrRequestExitSession", plain(request_exit)},
      {"xrEnumerateReferenceSpaces", plain(reference_spaces)},
      {"xrCreateReferenceSpace", plain(create_reference_space)},
      {"xrDestroySpace", plain(destroy_space)},
      {"xrLocateSpace", plain(locate_space)},
      {"xrLocateViews", plain(locate_views)},
      {"xrWaitFrame", plain(wait_frame)},
      {"xrBeginFrame", plain(begin_frame)},
      {"xrEndFrame", plain(end_frame)},
      {"xrGetVisibilityMaskKHR", plain(visibility_mask)},
      {"xrEnumerateDisplayRefreshRatesFB", plain(refresh_rates)},
      {"xrRequestDisplayRefreshRateFB", plain(request_refresh_rate)},
      {"xrCreatePassthroughFB", plain(create_passthrough)},
      {"xrDestroyPassthroughFB", plain(destroy_passthrough)},
      {"xrCreatePassthroughLayerFB", plain(create_passthrough_layer)},
      {"xrDestroyPassthroughLayerFB", plain(destroy_passthrough_layer)},
  };
  return table;
}

}  // namespace typodont::test::xr
