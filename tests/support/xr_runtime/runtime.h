// An OpenXR runtime for tests, without headset and compositor. It checks every rule of the specification that a program
// can violate, and logs violations. The real loader loads it through XR_RUNTIME_JSON. A script sets its behaviour
// (TYPODONT_XR_SCRIPT, see README.md). Only one instance and one session can exist at a time.
#pragma once

#include <fmt/format.h>
#include <vulkan/vulkan.h>
#define XR_USE_GRAPHICS_API_VULKAN
#define XR_USE_TIMESPEC
#define XR_NO_PROTOTYPES
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include <array>
#include <deque>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "tests/support/xr_runtime/script.h"

namespace typodont::test::xr {

struct Swapchain {
  XrSwapchainCreateInfo info{};
  std::vector<VkImage> images;
  std::vector<VkDeviceMemory> memory;
  bool depth = false;
  std::deque<std::uint32_t> acquired;  // oldest first
  bool waited = false;                 // the program has waited for the oldest one
  std::uint32_t next = 0;
  int last_released = -1;
  std::uint64_t released_in = 0;  // number of the frame
};

struct Space {
  enum class Kind { kView, kLocal, kStage, kAction } kind = Kind::kLocal;
  XrPosef pose{{0, 0, 0, 1}, {0, 0, 0}};
  int hand = 0;      // side, for an action space
  bool aim = false;  // the aim pose, otherwise the grip pose
  XrAction action = XR_NULL_HANDLE;
};

struct Action {
  std::string name;
  XrActionType type{};
  std::vector<XrPath> subactions;
  XrActionSet set = XR_NULL_HANDLE;
  std::map<XrPath, bool> last_bool;
};

struct ActionSet {
  std::string name;
  bool attached = false;
};

/// State of one session.
struct Session {
  VkDevice device = VK_NULL_HANDLE;
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VkQueue queue = VK_NULL_HANDLE;
  std::uint32_t queue_family = 0;
  VkCommandPool pool = VK_NULL_HANDLE;
  XrSessionState state = XR_SESSION_STATE_UNKNOWN;
  bool running = false;
  bool lost = false;
  bool exiting = false;                            // true: the state EXITING follows STOPPING
  std::int64_t idle_polls = -1;                    // number of polls until the state READY follows; −1: never
  std::uint64_t waited = 0, begun = 0, ended = 0;  // numbers of frames
  std::uint64_t first_of_run = 0;                  // value of `waited` when the session began to run
  XrTime display_time = 0;
  std::array<XrTime, 2> begun_time{};
  std::set<std::size_t> fired;  // indices of the script's events that have occurred
  // remaining numbers of frames without rendering, and without a located head
  std::int64_t no_render = 0, unlocatable = 0;
  bool synced = false;  // actions were synchronised since the session got the focus
  XrTime last_wait = 0;
  std::uint64_t skipped = 0;  // frames that were skipped because the program was busy
  double script_frame() const { return static_cast<double>(waited + skipped); }
};

struct Runtime {
  Script script;
  bool instance = false, system = false, instance_lost = false, requirements_asked = false;
  std::set<std::string> extensions;
  std::vector<std::string> paths{""};
  std::map<std::string, XrPath> path_numbers;
  std::unique_ptr<Session> session;
  std::map<XrSwapchain, std::unique_ptr<Swapchain>> swapchains;
  std::map<XrSpace, std::unique_ptr<Space>> spaces;
  std::map<XrAction, std::unique_ptr<Action>> actions;
  std::map<XrActionSet, std::unique_ptr<ActionSet>> sets;
  std::map<std::string, std::vector<XrActionSuggestedBinding>> suggested;  // by interaction profile
  std::set<std::uint64_t> passthroughs, passthrough_layers;
  std::deque<XrEventDataBuffer> events;
  VkInstance vk_instance = VK_NULL_HANDLE;
  VkPhysicalDevice vk_physical = VK_NULL_HANDLE;
  VkDevice vk_device = VK_NULL_HANDLE;
  XrPosef local{{0, 0, 0, 1}, {0, 0, 0}};  // pose of LOCAL relative to STAGE
  std::uint64_t next_handle = 0x1000;
  std::uint64_t haptics = 0;
  std::string stall_call, failing_call;
  double stall_seconds = 0;
  XrResult failing_result = XR_SUCCESS;

  template <class H>
  H handle() {
    return reinterpret_cast<H>(next_handle += 8);
  }
};

Runtime& runtime();

void log_line(const std::string& line);
template <class... A>
void log(fmt::format_string<A...> format, A&&... a) {
  log_line(fmt::format(format, std::forward<A>(a)...));
}
/// Logs a violated rule. A test fails if the log has such a line.
template <class... A>
XrResult violation(XrResult result, fmt::format_string<A...> format, A&&... a) {
  log_line("violation: " + fmt::format(format, std::forward<A>(a)...));
  return result;
}

/// Every function of the API calls this first. It checks the instance, and applies the script's stalls and failures.
XrResult enter(const char* call, bool needs_instance = true);
/// As enter(), for functions that need a session.
XrResult enter_session(const char* call, XrSession session, bool destroys = false);

template <class T>
bool typed(const T* data, XrStructureType type, const char* call, const char* what) {
  if (data && data->type == type) return true;
  violation(XR_ERROR_VALIDATION_FAILURE, "{}: {} {}", call, what, data ? "has another type" : "is null");
  return false;
}
/// Writes a list as OpenXR functions do (two-call idiom): the first call gets the length, the second call gets the
/// elements.
template <class T, class From>
XrResult give(const std::vector<From>& from, std::uint32_t capacity, std::uint32_t* count, T* to, const char* call) {
  if (!count) return violation(XR_ERROR_VALIDATION_FAILURE, "{}: no place for the count", call);
  *count = static_cast<std::uint32_t>(from.size());
  if (capacity == 0) return XR_SUCCESS;
  if (capacity < from.size())
    return violation(XR_ERROR_SIZE_INSUFFICIENT, "{}: capacity {} < {}", call, capacity, from.size());
  if (!to) return violation(XR_ERROR_VALIDATION_FAILURE, "{}: no array", call);
  for (std::size_t i = 0; i < from.size(); ++i) to[i] = from[i];
  return XR_SUCCESS;
}

XrTime time_now();
XrDuration period();
/// Returns the number of frames between the start and this time, with fraction.
double frame_at(XrTime time);

void set_state(XrSessionState state);
/// Triggers the script's events that are due in this frame or state.
void fire_events();
std::string path_text(XrPath path);
XrPath path_number(const std::string& text);

/// Functions of the API by name.
using Functions = std::map<std::string, PFN_xrVoidFunction>;
template <class F>
PFN_xrVoidFunction plain(F f) {
  return reinterpret_cast<PFN_xrVoidFunction>(f);
}
const Functions& session_functions();
const Functions& swapchain_functions();
const Functions& input_functions();

/// Writes the picture of a projection layer as PNG (and its depth as floats) if the script requests this frame.
void capture(std::uint64_t frame, const XrCompositionLayerProjection& layer);
/// Checks the picture of one view. `depth`: true if it belongs to the depth layer.
bool check_sub_image(const XrSwapchainSubImage& image, bool depth, const char* what);
bool is_unit(const XrQuaternionf& q);
XrPosef multiply(const XrPosef& a, const XrPosef& b);
XrPosef invert(const XrPosef& a);
/// Sets `pose` to the pose of a space in the stage at this time. Returns false if the space is not located.
bool locate(const Space& space, XrTime time, XrPosef& pose);
void destroy_swapchains();

}  // namespace typodont::test::xr
