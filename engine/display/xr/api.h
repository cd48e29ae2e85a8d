// Functions of OpenXR, found by name in a loader that is opened at run time.
#pragma once

#include <vulkan/vulkan.h>
#define XR_USE_GRAPHICS_API_VULKAN
#define XR_USE_TIMESPEC
#define XR_NO_PROTOTYPES
#include <ctime>
// vulkan.h and ctime must be included before openxr_platform.h
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include <set>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/pose.h"
#include "engine/display/runtime_gate.h"

namespace typodont::display::xr {

/// First list: core functions of OpenXR. Second list: functions of extensions; null if the extension is not enabled.
// clang-format off
#define TYPODONT_XR_CORE(_)                                                                                   \
  _(DestroyInstance) _(GetInstanceProperties) _(PollEvent) _(GetSystem) _(GetSystemProperties)                \
  _(EnumerateEnvironmentBlendModes) _(EnumerateViewConfigurations) _(EnumerateViewConfigurationViews)         \
  _(CreateSession) _(DestroySession) _(BeginSession) _(EndSession) _(RequestExitSession)                      \
  _(EnumerateReferenceSpaces) _(CreateReferenceSpace) _(CreateActionSpace) _(DestroySpace) _(LocateSpace)     \
  _(LocateViews) _(EnumerateSwapchainFormats) _(CreateSwapchain) _(DestroySwapchain)                          \
  _(EnumerateSwapchainImages) _(AcquireSwapchainImage) _(WaitSwapchainImage) _(ReleaseSwapchainImage)         \
  _(WaitFrame) _(BeginFrame) _(EndFrame) _(StringToPath) _(PathToString) _(CreateActionSet)                   \
  _(DestroyActionSet) _(CreateAction) _(SuggestInteractionProfileBindings) _(AttachSessionActionSets)         \
  _(SyncActions) _(GetActionStateBoolean) _(GetActionStateFloat) _(GetActionStatePose) _(ApplyHapticFeedback) \
  _(StopHapticFeedback) _(GetCurrentInteractionProfile)
// clang-format on
#define TYPODONT_XR_EXTENSIONS(_)                                              \
  _(GetVulkanGraphicsRequirements2KHR, XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME)   \
  _(CreateVulkanInstanceKHR, XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME)             \
  _(GetVulkanGraphicsDevice2KHR, XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME)         \
  _(CreateVulkanDeviceKHR, XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME)               \
  _(GetVisibilityMaskKHR, XR_KHR_VISIBILITY_MASK_EXTENSION_NAME)               \
  _(ConvertTimeToTimespecTimeKHR, XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME) \
  _(ConvertTimespecTimeToTimeKHR, XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME) \
  _(EnumerateDisplayRefreshRatesFB, XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME) \
  _(RequestDisplayRefreshRateFB, XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME)    \
  _(CreatePassthroughFB, XR_FB_PASSTHROUGH_EXTENSION_NAME)                     \
  _(DestroyPassthroughFB, XR_FB_PASSTHROUGH_EXTENSION_NAME)                    \
  _(CreatePassthroughLayerFB, XR_FB_PASSTHROUGH_EXTENSION_NAME)                \
  _(DestroyPassthroughLayerFB, XR_FB_PASSTHROUGH_EXTENSION_NAME)

std::string name_of(XrResult result);

/// An OpenXR instance. A RuntimeGate supervises every call.
class Api {
 public:
  /// Opens the loader. Throws Error with a message of one line.
  explicit Api(RuntimeGate& gate);
  ~Api();
  Api(const Api&) = delete;
  Api& operator=(const Api&) = delete;

  bool has(const char* extension) const { return enabled_.contains(extension); }
  const std::string& runtime() const { return runtime_; }
  XrInstance instance() const { return instance_; }

  /// Calls a function under supervision of the gate. Throws RunFailure with the function's name.
  template <class F, class... A>
  XrResult call(const char* name, F function, A... arguments) {
    const XrResult result = attempt(name, function, arguments...);
    if (XR_FAILED(result)) fail(name, result);
    return result;
  }
  /// Calls a function like call(), but never throws.
  template <class F, class... A>
  XrResult attempt(const char* name, F function, A... arguments) {
    gate_.enter(name);
    const XrResult result = function(arguments...);
    gate_.leave();
    return result;
  }
  /// Reads a list: first its length, then its content.
  template <class T, class F, class... A>
  std::vector<T> list(const char* name, F function, const T& empty, A... arguments) {
    std::uint32_t count = 0;
    call(name, function, arguments..., 0u, &count, static_cast<T*>(nullptr));
    std::vector<T> items(count, empty);
    if (count) call(name, function, arguments..., count, &count, items.data());
    items.resize(count);
    return items;
  }
  [[noreturn]] static void fail(const char* name, XrResult result);

#define TYPODONT_XR_MEMBER(name, ...) PFN_xr##name name = nullptr;
  TYPODONT_XR_CORE(TYPODONT_XR_MEMBER)
  TYPODONT_XR_EXTENSIONS(TYPODONT_XR_MEMBER)
#undef TYPODONT_XR_MEMBER

 private:
  RuntimeGate& gate_;
  XrInstance instance_ = XR_NULL_HANDLE;
  std::set<std::string> enabled_;
  std::string runtime_;
};

inline Pose pose_of(const XrPosef& x) {
  const dquat q(x.orientation.w, x.orientation.x, x.orientation.y, x.orientation.z);
  return {{x.position.x, x.position.y, x.position.z}, glm::normalize(q)};
}
inline XrPosef identity() {
  return {{0, 0, 0, 1}, {0, 0, 0}};
}

}  // namespace typodont::display::xr
