#include "engine/display/xr/api.h"

#include <fmt/format.h>
#include <openxr/openxr_reflection.h>

#include <cstdlib>
#include <cstring>

#include "engine/base/error.h"
#include "engine/base/late_library.h"

namespace typodont::display::xr {

namespace {

constexpr const char* kNeeded = XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME;
constexpr const char* kWelcome[] = {XR_KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME,
                                    XR_KHR_VISIBILITY_MASK_EXTENSION_NAME, XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME,
                                    XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME, XR_FB_PASSTHROUGH_EXTENSION_NAME};

constinit LateLibrary loader{"libopenxr_loader.so.1", "libopenxr-loader1"};
const Late<std::remove_pointer_t<PFN_xrGetInstanceProcAddr>> get_function{loader, "xrGetInstanceProcAddr"};

Error no_runtime(XrResult result) {
  const char* file = std::getenv("XR_RUNTIME_JSON");
  return Error("OpenXR", file ? file : "", fmt::format("no runtime that starts ({})", name_of(result)),
               "a headset's runtime, e.g. SteamVR or Monado, installed and running");
}

}  // namespace

std::string name_of(XrResult result) {
  switch (result) {
#define TYPODONT_XR_CASE(name, value) \
  case name:                          \
    return #name;
    XR_LIST_ENUM_XrResult(TYPODONT_XR_CASE)
#undef TYPODONT_XR_CASE
  }
  return fmt::format("XrResult {}", static_cast<int>(result));
}

void Api::fail(const char* name, XrResult result) {
  const bool lost = result == XR_ERROR_SESSION_LOST || result == XR_ERROR_INSTANCE_LOST;
  throw RunFailure(
      fmt::format("headset: {}: {} ({})", name, lost ? "the runtime went away" : "refused", name_of(result)));
}

Api::Api(RuntimeGate& gate) : gate_(gate) {
  setenv("XR_LOADER_DEBUG", "none", 0);  // the program itself reports loader errors, in one line
  const auto find = [&](const char* name, auto& function) {
    PFN_xrVoidFunction found = nullptr;
    function = nullptr;
    if (XR_SUCCEEDED(get_function(instance_, name, &found)))
      function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(found);
    return function != nullptr;
  };
  PFN_xrEnumerateInstanceExtensionProperties enumerate = nullptr;
  PFN_xrCreateInstance create = nullptr;
  if (!find("xrEnumerateInstanceExtensionProperties", enumerate) || !find("xrCreateInstance", create))
    throw Error("OpenXR", loader.file(), "not a loader", "OpenXR's, of the package libopenxr-loader1");

  std::uint32_t count = 0;
  XrResult result = attempt("xrEnumerateInstanceExtensionProperties", enumerate, nullptr, 0u, &count,
                            static_cast<XrExtensionProperties*>(nullptr));
  if (XR_FAILED(result)) throw no_runtime(result);
  std::vector<XrExtensionProperties> offered(count, {XR_TYPE_EXTENSION_PROPERTIES, nullptr, "", 0});
  result = attempt("xrEnumerateInstanceExtensionProperties", enumerate, nullptr, count, &count, offered.data());
  if (XR_FAILED(result)) throw no_runtime(result);
  const auto offers = [&](const char* name) {
    for (const XrExtensionProperties& e : offered)
      if (!std::strcmp(e.extensionName, name)) return true;
    return false;
  };
  if (!offers(kNeeded))
    throw Error("OpenXR", "the runtime", fmt::format("no {}", kNeeded), "a runtime that shares Vulkan");
  std::vector<const char*> names{kNeeded};
  for (const char* name : kWelcome)
    if (offers(name)) names.push_back(name);
  enabled_ = {names.begin(), names.end()};

  XrInstanceCreateInfo info{XR_TYPE_INSTANCE_CREATE_INFO};
  std::strncpy(info.applicationInfo.applicationName, "Typodont", XR_MAX_APPLICATION_NAME_SIZE - 1);
  std::strncpy(info.applicationInfo.engineName, "Typodont", XR_MAX_ENGINE_NAME_SIZE - 1);
  info.applicationInfo.apiVersion = XR_CURRENT_API_VERSION;
  info.enabledExtensionCount = static_cast<std::uint32_t>(names.size());
  info.enabledExtensionNames = names.data();
  result = attempt("xrCreateInstance", create, &info, &instance_);
  if (XR_FAILED(result)) throw no_runtime(result);

  std::string missing;
#define TYPODONT_XR_FIND(name) \
  if (!find("xr" #name, name)) missing = "xr" #name;
  TYPODONT_XR_CORE(TYPODONT_XR_FIND)
#undef TYPODONT_XR_FIND
  // Functions of an extension must only be called if it is enabled.
#define TYPODONT_XR_FIND(name, extension) \
  if (has(extension)) find("xr" #name, name);
  TYPODONT_XR_EXTENSIONS(TYPODONT_XR_FIND)
#undef TYPODONT_XR_FIND
  if (!missing.empty()) {
    if (DestroyInstance) attempt("xrDestroyInstance", DestroyInstance, instance_);
    throw Error("OpenXR", "the runtime", "no " + missing, "OpenXR 1.0");
  }
  XrInstanceProperties properties{XR_TYPE_INSTANCE_PROPERTIES};
  if (XR_SUCCEEDED(attempt("xrGetInstanceProperties", GetInstanceProperties, instance_, &properties)))
    runtime_ = fmt::format("{} {}.{}.{}", properties.runtimeName, XR_VERSION_MAJOR(properties.runtimeVersion),
                           XR_VERSION_MINOR(properties.runtimeVersion), XR_VERSION_PATCH(properties.runtimeVersion));
}

Api::~Api() {
  if (instance_) attempt("xrDestroyInstance", DestroyInstance, instance_);
}

}  // namespace typodont::display::xr
