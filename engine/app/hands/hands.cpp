#include "engine/app/hands/hands.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "engine/app/assets.h"
#include "engine/base/error.h"
#include "engine/base/realtime.h"
#include "engine/display/keys.h"
#include "haptics/device_safety.h"
#include "haptics/devices.h"

namespace typodont {

namespace {

constexpr Nanos kPublish = 100'000'000;  // ns, time between two reports of the servo loop's timing

const std::string& first_of(const std::string& asked, const std::string& rig) {
  return asked.empty() ? rig : asked;
}

}  // namespace

std::string hand_address(const HandChoice& choice, const display::DisplayRig* rig, const std::string& usual) {
  if (!choice.hand.empty()) {
    // The colon after the scheme of an address is optional: "mouse" means the same as "mouse:".
    for (const haptics::Driver& driver : haptics::drivers())
      if (choice.hand == driver.scheme) return choice.hand + ":";
    return choice.hand;
  }
  if (rig && !rig->hand.empty()) return rig->hand;
  if (usual.empty())
    throw Error("--hand", "", "nothing", "a hand, e.g. --hand script:HAND.csv: there is no window for the mouse");
  return usual;
}

Hands open_hands(const HandChoice& choice, const display::DisplayRig* rig, const WindowHands& window) {
  const display::DisplayRig none;
  const display::DisplayRig& from = rig ? *rig : none;
  haptics::HandOptions options;
  options.rate = choice.rate;
  options.assets = assets_folder();
  options.X_WH = from.X_WH;
  options.arm = from.arm;
  options.pedal_limit = from.pedal_limit;
  options.window = window;
  options.tools = choice.tools;
  const std::string& pedal = first_of(choice.pedal, from.pedal);
  options.pedal = pedal == "none" ? "" : pedal.empty() ? "auto" : pedal;
  Hands hands;
  hands.right = haptics::open_live_hand(choice.hand, options);

  const std::string& left = first_of(choice.left_hand, from.left_hand);
  if (!left.empty()) {
    if (left == choice.hand) throw Error("--left-hand", "", left, "another device than --hand");
    options.X_WH = from.left_X_WH;
    options.arm.reset();
    options.pedal.clear();
    hands.left = haptics::open_live_hand(left, options);
  }
  return hands;
}

void require_real_time(const Hands& hands) {
  for (haptics::HapticDevice* hand : {hands.right.get(), hands.left.get()}) {
    if (!hand || !hand->safety().gives_force) continue;
    const std::string refused = realtime_refusal();
    if (refused.empty()) return;
    throw Error(hand->info().address, "real time", refused,
                "real-time rights for a hand with motors (typodont doctor says how to get them), or --no-real-time to "
                "use it without");
  }
}

std::string in_words(const haptics::DeviceInfo& info) {
  return fmt::format("{} ({:g} Hz{}{})", info.model, info.rate,
                     info.force_limit > 0 && info.force_limit < 1e6 ? fmt::format(", up to {:g} N", info.force_limit)
                     : info.force_limit > 0                         ? ""
                                                                    : ", without force",
                     info.vibration_band > 0 ? fmt::format(", vibration up to {:g} Hz", info.vibration_band) : "");
}

void add_window_drivers() {
  const auto opened_by_the_window = [](const std::string& scheme, const char* needed) {
    return [scheme, needed](const std::string& rest, const haptics::HandOptions& options) {
      if (!options.window) throw Error("--hand", "", scheme + ":" + rest, needed);
      return haptics::add_pedal(options.window(scheme, rest), options.pedal);
    };
  };
  haptics::Driver mouse;
  mouse.scheme = "mouse";
  mouse.rest = "[STEP_MM]";
  mouse.about =
      "the mouse over the window: left button drills, wheel moves along the tool (by STEP_MM a notch), right tilts";
  mouse.hardware = false;
  mouse.open = opened_by_the_window("mouse", "a window rig for it to move in");
  mouse.find = [] {
    std::vector<haptics::FoundDevice> found;
    const char* desktop = std::getenv("WAYLAND_DISPLAY");
    if (!desktop) desktop = std::getenv("DISPLAY");
    if (desktop) found.push_back({"mouse:", "mouse", "the pointer over the window", "", desktop, 0, true, ""});
    return found;
  };
  haptics::add_driver(std::move(mouse));

  haptics::Driver xr;
  xr.scheme = "openxr";
  xr.rest = "right or left";
  xr.about = "a headset's controller: the trigger drills";
  xr.hardware = false;
  xr.open = opened_by_the_window("openxr", "a headset's rig, and a scene that names \"render\"");
  xr.find = [] {
    // Lists the files in which the OpenXR loader searches for the active runtime (OpenXR loader specification). Only
    // the common cases are covered.
    std::vector<std::filesystem::path> places;
    if (const char* file = std::getenv("XR_RUNTIME_JSON")) places.emplace_back(file);
    if (const char* home = std::getenv("XDG_CONFIG_HOME"))
      places.push_back(std::filesystem::path(home) / "openxr/1/active_runtime.json");
    else if (const char* user = std::getenv("HOME"))
      places.push_back(std::filesystem::path(user) / ".config/openxr/1/active_runtime.json");
    places.emplace_back("/etc/xdg/openxr/1/active_runtime.json");
    std::vector<haptics::FoundDevice> found;
    std::error_code code;
    for (const auto& place : places) {
      if (!std::filesystem::exists(place, code)) continue;
      found.push_back({"openxr:right", "headset's controller", "OpenXR runtime", "", place.string(), 0, true, ""});
      break;
    }
    return found;
  };
  haptics::add_driver(std::move(xr));

  haptics::Driver expert;
  expert.scheme = "expert";
  expert.about = "a hand that knows the task: it works, looks at the result, and goes on until the task is done";
  expert.hardware = false;
  expert.open = [](const std::string& rest, const haptics::HandOptions& options) {
    if (!rest.empty() || !options.window) throw Error("--hand", "", "expert:" + rest, "expert: of a session");
    return options.window("expert", rest);
  };
  haptics::add_driver(std::move(expert));
}

void LoopStatistics::tick(Nanos woke, Nanos done, const haptics::SafetyStatus& safety) noexcept {
  report_.timing.record(woke, done);
  report_.heat = safety.heat;
  report_.worst_heat = std::max(report_.worst_heat, safety.heat);
  report_.bearable_force = safety.bearable_force;
  report_.armed = safety.armed;
  report_.safety |= safety.events;
  if (done - published_ > kPublish) publish();
}

void LoopStatistics::publish() noexcept {
  published_ = report_.timing.last_woke;
  wiring_.event_logs.loop.write(report_);
}

display::UrgentKeys emergency_keys() {
  constexpr int kEnd = 'R';
  return {{' ', display::keys::kEscape, kEnd}, [](int key) { haptics::set_emergency_stop(key != kEnd); }};
}

void left_hand_thread(Wiring& wiring, haptics::HapticDevice& hand) {
  // The second hand's thread has lower priority than the servo thread.
  enter_realtime({.priority = 78, .core = -1, .lock_memory = false});
  haptics::HandSample sample;
  while (!wiring.stop.load(std::memory_order_relaxed) && hand.read(sample)) {
    // The arm reports positions only while it receives forces, so the program sends zero force.
    hand.write(dvec3(0), dvec3(0));
    const Nanos zero = wiring.session_zero.load(std::memory_order_relaxed);
    sample.t = zero != 0 ? now() - zero : -1;  // replaces the device's time with the time of the session
    wiring.event_logs.left.write(sample);
  }
  hand.write(dvec3(0), dvec3(0));
}

}  // namespace typodont
