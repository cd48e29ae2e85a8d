// Instance, system, Vulkan and events: the functions that work without a session.
#include "tests/support/xr_runtime/runtime.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <mutex>
#include <thread>

#include "tests/support/xr_runtime/loader_interface.h"

namespace typodont::test::xr {

namespace {

constexpr XrSystemId kSystem = 42;

Runtime& slot() {
  static Runtime* r = new Runtime;  // never destroyed, because a thread may hang in a call
  return *r;
}

XrPosef pose_of(const ScriptPose& s) {
  return {
      {static_cast<float>(s.q[1]), static_cast<float>(s.q[2]), static_cast<float>(s.q[3]), static_cast<float>(s.q[0])},
      {static_cast<float>(s.p[0]), static_cast<float>(s.p[1]), static_cast<float>(s.p[2])}};
}

}  // namespace

Runtime& runtime() {
  return slot();
}

void log_line(const std::string& line) {
  static std::mutex mutex;
  const std::lock_guard lock(mutex);
  const std::string& file = runtime().script.log;
  if (file.empty()) return;
  std::ofstream(file, std::ios::app) << line << '\n';
}

XrTime time_now() {
  const auto since = std::chrono::steady_clock::now().time_since_epoch();
  constexpr XrTime kOffset = 5'000'000'000;  // offset of the runtime's clock, which differs from every other clock
  return std::chrono::duration_cast<std::chrono::nanoseconds>(since).count() + kOffset;
}

XrDuration period() {
  return static_cast<XrDuration>(runtime().script.period * 1e9);
}

double frame_at(XrTime time) {
  const Session* s = runtime().session.get();
  if (!s || s->waited == 0) return 0;
  // Time follows the number of frames, not their duration, so that a script has the same effect on every machine.
  return s->script_frame() +
         static_cast<double>(time - s->display_time) / static_cast<double>(std::max<XrDuration>(period(), 1));
}

XrResult enter(const char* call, bool needs_instance) {
  Runtime& r = runtime();
  if (needs_instance && !r.instance) return violation(XR_ERROR_HANDLE_INVALID, "{}: no instance", call);
  if (r.stall_call == call) {
    r.stall_call.clear();
    log("stalls in {}", call);
    std::this_thread::sleep_for(std::chrono::duration<double>(r.stall_seconds));
  }
  if (r.failing_call == call) {
    r.failing_call.clear();
    log("fails in {}", call);
    return r.failing_result;
  }
  if (r.instance_lost && std::strncmp(call, "xrDestroy", 9) != 0) return XR_ERROR_INSTANCE_LOST;
  return XR_SUCCESS;
}

std::string path_text(XrPath path) {
  const auto& paths = runtime().paths;
  return path > 0 && path < paths.size() ? paths[path] : "";
}

XrPath path_number(const std::string& text) {
  Runtime& r = runtime();
  const auto [at, fresh] = r.path_numbers.emplace(text, r.paths.size());
  if (fresh) r.paths.push_back(text);
  return at->second;
}

bool is_unit(const XrQuaternionf& q) {
  return std::abs(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w - 1) < 0.02f;
}

XrPosef multiply(const XrPosef& a, const XrPosef& b) {
  const auto turn = [](const XrQuaternionf& q, const XrVector3f& v) {
    const float tx = 2 * (q.y * v.z - q.z * v.y), ty = 2 * (q.z * v.x - q.x * v.z), tz = 2 * (q.x * v.y - q.y * v.x);
    return XrVector3f{v.x + q.w * tx + q.y * tz - q.z * ty, v.y + q.w * ty + q.z * tx - q.x * tz,
                      v.z + q.w * tz + q.x * ty - q.y * tx};
  };
  const XrQuaternionf &p = a.orientation, &q = b.orientation;
  const XrVector3f v = turn(p, b.position);
  return {{p.w * q.x + p.x * q.w + p.y * q.z - p.z * q.y, p.w * q.y - p.x * q.z + p.y * q.w + p.z * q.x,
           p.w * q.z + p.x * q.y - p.y * q.x + p.z * q.w, p.w * q.w - p.x * q.x - p.y * q.y - p.z * q.z},
          {a.position.x + v.x, a.position.y + v.y, a.position.z + v.z}};
}

XrPosef invert(const XrPosef& a) {
  const XrQuaternionf q{-a.orientation.x, -a.orientation.y, -a.orientation.z, a.orientation.w};
  const XrPosef back = multiply({q, {0, 0, 0}}, {{0, 0, 0, 1}, a.position});
  return {q, {-back.position.x, -back.position.y, -back.position.z}};
}

namespace {

template <class T>
T& push_event(XrStructureType type) {
  static_assert(sizeof(T) <= sizeof(XrEventDataBuffer));
  XrEventDataBuffer& buffer = runtime().events.emplace_back();
  std::memset(&buffer, 0, sizeof buffer);
  buffer.type = type;
  return reinterpret_cast<T&>(buffer);
}

const char* state_name(XrSessionState state) {
  constexpr std::array<const char*, 9> kNames{"UNKNOWN", "IDLE",     "READY",        "SYNCHRONIZED", "VISIBLE",
                                              "FOCUSED", "STOPPING", "LOSS_PENDING", "EXITING"};
  return kNames[static_cast<std::size_t>(state)];
}

XrSession session_handle() {
  return reinterpret_cast<XrSession>(std::uintptr_t{0x42});
}

/// Ends the states in order, as a compositor does: focused, visible, synchronized, stopping.
void stop_session(Session& s) {
  if (s.state == XR_SESSION_STATE_FOCUSED) set_state(XR_SESSION_STATE_VISIBLE);
  if (s.state == XR_SESSION_STATE_VISIBLE) set_state(XR_SESSION_STATE_SYNCHRONIZED);
  if (s.running && s.state != XR_SESSION_STATE_STOPPING) set_state(XR_SESSION_STATE_STOPPING);
}

void fire(const ScriptEvent& e) {
  Runtime& r = runtime();
  Session& s = *r.session;
  log("event {} in {} at frame {}", e.event, state_name(s.state), s.waited);
  if (e.event == "unfocus") {
    if (s.state == XR_SESSION_STATE_FOCUSED) set_state(XR_SESSION_STATE_VISIBLE);
  } else if (e.event == "hide") {
    if (s.state == XR_SESSION_STATE_FOCUSED) set_state(XR_SESSION_STATE_VISIBLE);
    if (s.state == XR_SESSION_STATE_VISIBLE) set_state(XR_SESSION_STATE_SYNCHRONIZED);
  } else if (e.event == "show") {
    if (s.state == XR_SESSION_STATE_SYNCHRONIZED) set_state(XR_SESSION_STATE_VISIBLE);
  } else if (e.event == "focus") {
    if (s.state == XR_SESSION_STATE_SYNCHRONIZED) set_state(XR_SESSION_STATE_VISIBLE);
    if (s.state == XR_SESSION_STATE_VISIBLE) set_state(XR_SESSION_STATE_FOCUSED);
  } else if (e.event == "stop") {
    s.idle_polls = e.count > 0 ? e.count : -1;
    if (s.running) stop_session(s);
  } else if (e.event == "exit") {
    s.exiting = true;
    if (s.running) {
      stop_session(s);
    } else {
      if (s.state == XR_SESSION_STATE_READY) set_state(XR_SESSION_STATE_IDLE);
      set_state(XR_SESSION_STATE_EXITING);
    }
  } else if (e.event == "loss_pending") {
    set_state(XR_SESSION_STATE_LOSS_PENDING);
  } else if (e.event == "session_lost") {
    s.lost = true;
  } else if (e.event == "instance_loss_pending") {
    push_event<XrEventDataInstanceLossPending>(XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING).lossTime = time_now();
  } else if (e.event == "instance_lost") {
    r.instance_lost = true;
  } else if (e.event == "stall") {
    r.stall_call = e.call.empty() ? "xrWaitFrame" : e.call;
    r.stall_seconds = e.seconds;
  } else if (e.event == "fail") {
    r.failing_call = e.call;
    r.failing_result = e.result ? static_cast<XrResult>(e.result) : XR_ERROR_RUNTIME_FAILURE;
  } else if (e.event == "recenter") {
    // Pose of the new origin relative to the old one.
    const XrPosef step = pose_of(e.pose);
    r.local = multiply(r.local, step);
    auto& change =
        push_event<XrEventDataReferenceSpaceChangePending>(XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING);
    change.session = session_handle();
    change.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_LOCAL;
    change.changeTime = s.display_time;
    change.poseValid = e.pose_valid;
    change.poseInPreviousSpace = step;
  } else if (e.event == "mask") {
    auto& change = push_event<XrEventDataVisibilityMaskChangedKHR>(XR_TYPE_EVENT_DATA_VISIBILITY_MASK_CHANGED_KHR);
    change.session = session_handle();
    change.viewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
    for (auto& corner : r.script.mask) corner = {0.9 * corner[0], 0.9 * corner[1]};
  } else if (e.event == "profile") {
    push_event<XrEventDataInteractionProfileChanged>(XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED).session =
        session_handle();
  } else if (e.event == "events_lost") {
    push_event<XrEventDataEventsLost>(XR_TYPE_EVENT_DATA_EVENTS_LOST).lostEventCount = 7;
  } else if (e.event == "refresh") {
    auto& change =
        push_event<XrEventDataDisplayRefreshRateChangedFB>(XR_TYPE_EVENT_DATA_DISPLAY_REFRESH_RATE_CHANGED_FB);
    change.fromDisplayRefreshRate = 90;
    change.toDisplayRefreshRate = 72;
  } else if (e.event == "unknown") {
    push_event<XrEventDataBaseHeader>(static_cast<XrStructureType>(1'000'999'001));
  } else if (e.event == "no_render") {
    s.no_render = std::max<std::int64_t>(e.count, 1);
  } else if (e.event == "unlocatable") {
    s.unlocatable = std::max<std::int64_t>(e.count, 1);
  } else {
    violation(XR_SUCCESS, "the script's event {} is unknown", e.event);
  }
}

}  // namespace

void set_state(XrSessionState state) {
  Session& s = *runtime().session;
  s.state = state;
  if (state != XR_SESSION_STATE_FOCUSED) s.synced = false;
  auto& event = push_event<XrEventDataSessionStateChanged>(XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED);
  event.session = session_handle();
  event.state = state;
  event.time = time_now();
  log("state {}", state_name(state));
}

void fire_events() {
  Runtime& r = runtime();
  if (!r.session) return;
  for (std::size_t i = 0; i < r.script.events.size(); ++i) {
    const ScriptEvent& e = r.script.events[i];
    Session& s = *r.session;
    if (s.fired.contains(i)) continue;
    const bool felt = static_cast<std::int64_t>(r.haptics) >= e.vibrations;
    const bool due =
        e.state.empty() ? e.frame >= 0 && s.script_frame() >= e.frame && felt : e.state == state_name(s.state);
    if (!due) continue;
    s.fired.insert(i);
    fire(e);
  }
}

namespace {

XRAPI_ATTR XrResult XRAPI_CALL enumerate_extensions(const char* layer, std::uint32_t capacity, std::uint32_t* count,
                                                    XrExtensionProperties* properties) {
  if (layer) return XR_ERROR_API_LAYER_NOT_PRESENT;
  const auto& names = runtime().script.extensions;
  *count = static_cast<std::uint32_t>(names.size());
  if (capacity == 0) return XR_SUCCESS;
  if (capacity < names.size()) return XR_ERROR_SIZE_INSUFFICIENT;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!typed(properties + i, XR_TYPE_EXTENSION_PROPERTIES, "xrEnumerateInstanceExtensionProperties", "properties"))
      return XR_ERROR_VALIDATION_FAILURE;
    std::snprintf(properties[i].extensionName, sizeof properties[i].extensionName, "%s", names[i].c_str());
    properties[i].extensionVersion = 1;
  }
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL create_instance(const XrInstanceCreateInfo* info, XrInstance* instance) {
  Runtime& r = runtime();
  if (!typed(info, XR_TYPE_INSTANCE_CREATE_INFO, "xrCreateInstance", "info")) return XR_ERROR_VALIDATION_FAILURE;
  if (r.instance) return XR_ERROR_LIMIT_REACHED;
  if (!info->applicationInfo.applicationName[0]) return violation(XR_ERROR_NAME_INVALID, "xrCreateInstance: no name");
  if (XR_VERSION_MAJOR(info->applicationInfo.apiVersion) != 1) return XR_ERROR_API_VERSION_UNSUPPORTED;
  r.extensions.clear();
  for (std::uint32_t i = 0; i < info->enabledExtensionCount; ++i) {
    const std::string name = info->enabledExtensionNames[i];
    if (std::find(r.script.extensions.begin(), r.script.extensions.end(), name) == r.script.extensions.end())
      return violation(XR_ERROR_EXTENSION_NOT_PRESENT, "xrCreateInstance: {} is not offered", name);
    r.extensions.insert(name);
  }
  const Script script = r.script;
  const auto extensions = r.extensions;
  r = Runtime{};
  r.script = script;
  r.extensions = extensions;
  r.local = pose_of(script.local_origin);
  r.instance = true;
  for (const ScriptEvent& e : script.events) {  // without a session, only failures of calls are possible
    if (e.state != "CREATED") continue;
    (e.event == "stall" ? r.stall_call : r.failing_call) = e.call;
    r.stall_seconds = e.seconds;
    r.failing_result = e.result ? static_cast<XrResult>(e.result) : XR_ERROR_RUNTIME_FAILURE;
  }
  *instance = reinterpret_cast<XrInstance>(std::uintptr_t{0x41});
  log("instance with {}", fmt::join(extensions, " "));
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL destroy_instance(XrInstance) {
  if (const XrResult refused = enter("xrDestroyInstance")) return refused;
  Runtime& r = runtime();
  if (r.session) violation(XR_SUCCESS, "xrDestroyInstance: the session still lives");
  log("end: {} haptic commands", r.haptics);
  r.session.reset();
  r.instance = false;
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL instance_properties(XrInstance, XrInstanceProperties* properties) {
  if (const XrResult refused = enter("xrGetInstanceProperties")) return refused;
  if (!typed(properties, XR_TYPE_INSTANCE_PROPERTIES, "xrGetInstanceProperties", "properties"))
    return XR_ERROR_VALIDATION_FAILURE;
  properties->runtimeVersion = XR_MAKE_VERSION(1, 2, 3);
  std::snprintf(properties->runtimeName, sizeof properties->runtimeName, "Typodont's test runtime");
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL poll_event(XrInstance, XrEventDataBuffer* buffer) {
  if (const XrResult refused = enter("xrPollEvent")) return refused;
  Runtime& r = runtime();
  if (!typed(buffer, XR_TYPE_EVENT_DATA_BUFFER, "xrPollEvent", "buffer")) return XR_ERROR_VALIDATION_FAILURE;
  if (r.session) {
    Session& s = *r.session;
    if (r.events.empty() && s.state == XR_SESSION_STATE_UNKNOWN) set_state(XR_SESSION_STATE_IDLE);
    if (r.events.empty()) fire_events();
    // Acts as if the user put on the headset, but only after the program has seen that there are no other events.
    if (r.events.empty() && s.state == XR_SESSION_STATE_IDLE && !s.exiting && s.idle_polls > 0 && --s.idle_polls == 0)
      set_state(XR_SESSION_STATE_READY);
  }
  if (r.events.empty()) return r.instance_lost ? XR_ERROR_INSTANCE_LOST : XR_EVENT_UNAVAILABLE;
  *buffer = r.events.front();
  r.events.pop_front();
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL get_system(XrInstance, const XrSystemGetInfo* info, XrSystemId* id) {
  if (const XrResult refused = enter("xrGetSystem")) return refused;
  if (!typed(info, XR_TYPE_SYSTEM_GET_INFO, "xrGetSystem", "info")) return XR_ERROR_VALIDATION_FAILURE;
  if (info->formFactor != XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY) return XR_ERROR_FORM_FACTOR_UNSUPPORTED;
  if (!runtime().script.headset) return XR_ERROR_FORM_FACTOR_UNAVAILABLE;
  runtime().system = true;
  *id = kSystem;
  return XR_SUCCESS;
}

XrResult check_system(XrSystemId id, const char* call) {
  if (const XrResult refused = enter(call)) return refused;
  if (id != kSystem || !runtime().system) return violation(XR_ERROR_SYSTEM_INVALID, "{}: system {}", call, id);
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL system_properties(XrInstance, XrSystemId id, XrSystemProperties* properties) {
  if (const XrResult refused = check_system(id, "xrGetSystemProperties")) return refused;
  if (!typed(properties, XR_TYPE_SYSTEM_PROPERTIES, "xrGetSystemProperties", "properties"))
    return XR_ERROR_VALIDATION_FAILURE;
  properties->systemId = id;
  properties->vendorId = 7;
  std::snprintf(properties->systemName, sizeof properties->systemName, "scripted headset");
  properties->graphicsProperties = {4096, 4096, 16};
  properties->trackingProperties = {XR_TRUE, XR_TRUE};
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL view_configurations(XrInstance, XrSystemId id, std::uint32_t capacity,
                                                   std::uint32_t* count, XrViewConfigurationType* types) {
  if (const XrResult refused = check_system(id, "xrEnumerateViewConfigurations")) return refused;
  const std::vector<XrViewConfigurationType> all{XR_VIEW_CONFIGURATION_TYPE_PRIMARY_MONO,
                                                 XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO};
  return give(all, capacity, count, types, "xrEnumerateViewConfigurations");
}

XRAPI_ATTR XrResult XRAPI_CALL view_configuration_views(XrInstance, XrSystemId id, XrViewConfigurationType type,
                                                        std::uint32_t capacity, std::uint32_t* count,
                                                        XrViewConfigurationView* views) {
  if (const XrResult refused = check_system(id, "xrEnumerateViewConfigurationViews")) return refused;
  if (type != XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO) return XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED;
  for (std::uint32_t i = 0; i < capacity; ++i)
    if (!typed(views + i, XR_TYPE_VIEW_CONFIGURATION_VIEW, "xrEnumerateViewConfigurationViews", "a view"))
      return XR_ERROR_VALIDATION_FAILURE;
  const auto w = static_cast<std::uint32_t>(runtime().script.view_size[0]),
             h = static_cast<std::uint32_t>(runtime().script.view_size[1]);
  return give(
      std::vector<XrViewConfigurationView>(2, {XR_TYPE_VIEW_CONFIGURATION_VIEW, nullptr, w, 2 * w, h, 2 * h, 1, 4}),
      capacity, count, views, "xrEnumerateViewConfigurationViews");
}

XRAPI_ATTR XrResult XRAPI_CALL blend_modes(XrInstance, XrSystemId id, XrViewConfigurationType, std::uint32_t capacity,
                                           std::uint32_t* count, XrEnvironmentBlendMode* modes) {
  if (const XrResult refused = check_system(id, "xrEnumerateEnvironmentBlendModes")) return refused;
  std::vector<XrEnvironmentBlendMode> all;
  for (const std::string& name : runtime().script.blend_modes)
    all.push_back(name == "alpha"      ? XR_ENVIRONMENT_BLEND_MODE_ALPHA_BLEND
                  : name == "additive" ? XR_ENVIRONMENT_BLEND_MODE_ADDITIVE
                                       : XR_ENVIRONMENT_BLEND_MODE_OPAQUE);
  return give(all, capacity, count, modes, "xrEnumerateEnvironmentBlendModes");
}

// --- Vulkan

bool has(const char* extension, const char* call) {
  if (runtime().extensions.contains(extension)) return true;
  violation(XR_ERROR_FUNCTION_UNSUPPORTED, "{}: {} was not asked for", call, extension);
  return false;
}

XRAPI_ATTR XrResult XRAPI_CALL graphics_requirements(XrInstance, XrSystemId id,
                                                     XrGraphicsRequirementsVulkanKHR* requirements) {
  if (const XrResult refused = check_system(id, "xrGetVulkanGraphicsRequirements2KHR")) return refused;
  if (!has("XR_KHR_vulkan_enable2", "xrGetVulkanGraphicsRequirements2KHR")) return XR_ERROR_FUNCTION_UNSUPPORTED;
  if (!typed(requirements, XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN_KHR, "xrGetVulkanGraphicsRequirements2KHR", "data"))
    return XR_ERROR_VALIDATION_FAILURE;
  requirements->minApiVersionSupported = XR_MAKE_VERSION(1, 0, 0);
  // This is the highest version that was tested. It is information for the program and not a limit.
  requirements->maxApiVersionSupported = XR_MAKE_VERSION(1, 2, 0);
  runtime().requirements_asked = true;
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL create_vulkan_instance(XrInstance, const XrVulkanInstanceCreateInfoKHR* info,
                                                      VkInstance* instance, VkResult* result) {
  if (const XrResult refused = enter("xrCreateVulkanInstanceKHR")) return refused;
  if (!typed(info, XR_TYPE_VULKAN_INSTANCE_CREATE_INFO_KHR, "xrCreateVulkanInstanceKHR", "info"))
    return XR_ERROR_VALIDATION_FAILURE;
  if (!runtime().requirements_asked)
    return violation(XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING, "xrCreateVulkanInstanceKHR: requirements not asked");
  // Adds the runtime's own extensions to the program's, as real runtimes do.
  VkInstanceCreateInfo mine = *info->vulkanCreateInfo;
  std::vector<const char*> names(mine.ppEnabledExtensionNames,
                                 mine.ppEnabledExtensionNames + mine.enabledExtensionCount);
  names.push_back("VK_KHR_external_memory_capabilities");
  mine.enabledExtensionCount = static_cast<std::uint32_t>(names.size());
  mine.ppEnabledExtensionNames = names.data();
  const auto create =
      reinterpret_cast<PFN_vkCreateInstance>(info->pfnGetInstanceProcAddr(VK_NULL_HANDLE, "vkCreateInstance"));
  *result = create(&mine, info->vulkanAllocator, instance);
  runtime().vk_instance = *result == VK_SUCCESS ? *instance : VK_NULL_HANDLE;
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL graphics_device(XrInstance, const XrVulkanGraphicsDeviceGetInfoKHR* info,
                                               VkPhysicalDevice* physical) {
  if (const XrResult refused = enter("xrGetVulkanGraphicsDevice2KHR")) return refused;
  if (!typed(info, XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR, "xrGetVulkanGraphicsDevice2KHR", "info"))
    return XR_ERROR_VALIDATION_FAILURE;
  if (info->vulkanInstance != runtime().vk_instance)
    return violation(XR_ERROR_VALIDATION_FAILURE, "xrGetVulkanGraphicsDevice2KHR: another Vulkan instance");
  std::uint32_t count = 1;
  if (vkEnumeratePhysicalDevices(info->vulkanInstance, &count, physical) < 0 || count == 0)
    return XR_ERROR_RUNTIME_FAILURE;
  runtime().vk_physical = *physical;
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL create_vulkan_device(XrInstance, const XrVulkanDeviceCreateInfoKHR* info,
                                                    VkDevice* device, VkResult* result) {
  if (const XrResult refused = enter("xrCreateVulkanDeviceKHR")) return refused;
  if (!typed(info, XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR, "xrCreateVulkanDeviceKHR", "info"))
    return XR_ERROR_VALIDATION_FAILURE;
  if (info->vulkanPhysicalDevice != runtime().vk_physical || !runtime().vk_physical)
    return violation(XR_ERROR_VALIDATION_FAILURE, "xrCreateVulkanDeviceKHR: not the runtime's physical device");
  const auto create =
      reinterpret_cast<PFN_vkCreateDevice>(info->pfnGetInstanceProcAddr(runtime().vk_instance, "vkCreateDevice"));
  *result = create(info->vulkanPhysicalDevice, info->vulkanCreateInfo, info->vulkanAllocator, device);
  runtime().vk_device = *result == VK_SUCCESS ? *device : VK_NULL_HANDLE;
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL time_to_timespec(XrInstance, XrTime time, timespec* out) {
  if (!has("XR_KHR_convert_timespec_time", "xrConvertTimeToTimespecTimeKHR")) return XR_ERROR_FUNCTION_UNSUPPORTED;
  if (time <= 0) return violation(XR_ERROR_TIME_INVALID, "xrConvertTimeToTimespecTimeKHR: time {}", time);
  const XrTime monotonic = time - 5'000'000'000;
  *out = {monotonic / 1'000'000'000, monotonic % 1'000'000'000};
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL timespec_to_time(XrInstance, const timespec* in, XrTime* time) {
  if (!has("XR_KHR_convert_timespec_time", "xrConvertTimespecTimeToTimeKHR")) return XR_ERROR_FUNCTION_UNSUPPORTED;
  *time = XrTime{in->tv_sec} * 1'000'000'000 + in->tv_nsec + 5'000'000'000;
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL string_to_path(XrInstance, const char* text, XrPath* path) {
  if (const XrResult refused = enter("xrStringToPath")) return refused;
  const std::string s = text ? text : "";
  const bool good = s.size() > 1 && s[0] == '/' && s.back() != '/' && s.find("//") == std::string::npos &&
                    s.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-_./") == std::string::npos;
  if (!good) return violation(XR_ERROR_PATH_FORMAT_INVALID, "xrStringToPath: \"{}\"", s);
  *path = path_number(s);
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL path_to_string(XrInstance, XrPath path, std::uint32_t capacity, std::uint32_t* count,
                                              char* buffer) {
  const std::string text = path_text(path);
  if (text.empty()) return violation(XR_ERROR_PATH_INVALID, "xrPathToString: {}", path);
  *count = static_cast<std::uint32_t>(text.size() + 1);
  if (capacity == 0) return XR_SUCCESS;
  if (capacity < *count) return XR_ERROR_SIZE_INSUFFICIENT;
  std::memcpy(buffer, text.c_str(), text.size() + 1);
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL get_instance_proc_addr(XrInstance, const char* name, PFN_xrVoidFunction* function);

const Functions& instance_functions() {
  static const Functions table{
      {"xrGetInstanceProcAddr", plain(get_instance_proc_addr)},
      {"xrEnumerateInstanceExtensionProperties", plain(enumerate_extensions)},
      {"xrCreateInstance", plain(create_instance)},
      {"xrDestroyInstance", plain(destroy_instance)},
      {"xrGetInstanceProperties", plain(instance_properties)},
      {"xrPollEvent", plain(poll_event)},
      {"xrGetSystem", plain(get_system)},
      {"xrGetSystemProperties", plain(system_properties)},
      {"xrEnumerateViewConfigurations", plain(view_configurations)},
      {"xrEnumerateViewConfigurationViews", plain(view_configuration_views)},
      {"xrEnumerateEnvironmentBlendModes", plain(blend_modes)},
      {"xrGetVulkanGraphicsRequirements2KHR", plain(graphics_requirements)},
      {"xrCreateVulkanInstanceKHR", plain(create_vulkan_instance)},
      {"xrGetVulkanGraphicsDevice2KHR", plain(graphics_device)},
      {"xrCreateVulkanDeviceKHR", plain(create_vulkan_device)},
      {"xrConvertTimeToTimespecTimeKHR", plain(time_to_timespec)},
      {"xrConvertTimespecTimeToTimeKHR", plain(timespec_to_time)},
      {"xrStringToPath", plain(string_to_path)},
      {"xrPathToString", plain(path_to_string)},
  };
  return table;
}

XRAPI_ATTR XrResult XRAPI_CALL get_instance_proc_addr(XrInstance, const char* name, PFN_xrVoidFunction* function) {
  *function = nullptr;
  for (const Functions* functions :
       {&instance_functions(), &session_functions(), &swapchain_functions(), &input_functions()}) {
    if (const auto found = functions->find(name); found != functions->end()) *function = found->second;
  }
  return *function ? XR_SUCCESS : XR_ERROR_FUNCTION_UNSUPPORTED;
}

}  // namespace

}  // namespace typodont::test::xr

extern "C" __attribute__((visibility("default"))) XrResult xrNegotiateLoaderRuntimeInterface(
    const typodont::test::xr::LoaderInfo* loader, typodont::test::xr::RuntimeRequest* request) {
  using namespace typodont::test::xr;
  if (!loader || !request || loader->type != kLoaderInfo || request->type != kRuntimeRequest ||
      loader->min_interface > kInterfaceVersion || loader->max_interface < kInterfaceVersion)
    return XR_ERROR_INITIALIZATION_FAILED;
  const char* file = std::getenv("TYPODONT_XR_SCRIPT");
  try {
    runtime().script = file ? read_script(file) : Script{};
    if (!file) runtime().script.extensions = all_extensions();
  } catch (const std::exception& e) {
    fmt::print(stderr, "test runtime: {}: {}\n", file, e.what());
    return XR_ERROR_INITIALIZATION_FAILED;
  }
  request->interface = kInterfaceVersion;
  request->api = XR_CURRENT_API_VERSION;
  request->get_instance_proc_addr = get_instance_proc_addr;
  return XR_SUCCESS;
}
