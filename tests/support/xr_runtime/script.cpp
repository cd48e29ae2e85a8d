#include "tests/support/xr_runtime/script.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

namespace typodont::test::xr {

namespace {

using nlohmann::json;

template <class T>
void take(const json& from, const char* key, T& to) {
  if (from.contains(key)) to = from.at(key).get<T>();
}
void take(const json& from, ScriptPose& to) {
  take(from, "p", to.p);
  take(from, "q", to.q);
}
void allow(const json& from, const std::set<std::string>& keys) {
  for (const auto& [key, unused] : from.items())
    if (!keys.contains(key)) throw std::runtime_error("unknown key " + key);
}

}  // namespace

const std::vector<std::string>& all_extensions() {
  static const std::vector<std::string> names{"XR_KHR_vulkan_enable2",      "XR_KHR_composition_layer_depth",
                                              "XR_KHR_visibility_mask",     "XR_KHR_convert_timespec_time",
                                              "XR_FB_display_refresh_rate", "XR_FB_passthrough"};
  return names;
}

Script read_script(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error("cannot be read");
  const json j = json::parse(in);
  allow(j, {"log",     "out",          "headset",       "asleep",    "paced",  "extensions", "blend_modes",
            "spaces",  "formats",      "refresh_rates", "view_size", "images", "period_ms",  "prediction_error_mm",
            "profile", "local_origin", "views",         "head",      "hands",  "events",     "capture",
            "mask"});
  Script s;
  s.extensions = all_extensions();
  take(j, "log", s.log);
  take(j, "out", s.out);
  take(j, "headset", s.headset);
  take(j, "asleep", s.asleep);
  take(j, "paced", s.paced);
  take(j, "extensions", s.extensions);
  take(j, "blend_modes", s.blend_modes);
  take(j, "spaces", s.spaces);
  take(j, "formats", s.formats);
  take(j, "refresh_rates", s.refresh_rates);
  take(j, "view_size", s.view_size);
  take(j, "images", s.images);
  take(j, "profile", s.profile);
  take(j, "capture", s.capture);
  take(j, "mask", s.mask);
  s.period = j.value("period_ms", 1000.0 / 90) * 1e-3;
  s.prediction_error = j.value("prediction_error_mm", 0.0) * 1e-3;
  if (j.contains("local_origin")) take(j["local_origin"], s.local_origin);
  if (j.contains("views"))
    for (std::size_t i = 0; i < 2; ++i) {
      take(j["views"].at(i), s.views[i].pose);
      take(j["views"].at(i), "fov", s.views[i].fov);
    }
  if (j.contains("head")) {
    s.head.clear();
    for (const json& key : j["head"]) {
      HeadKey& head = s.head.emplace_back();
      take(key, "frame", head.frame);
      take(key, head.pose);
    }
  }
  if (j.contains("hands")) {
    allow(j["hands"], {"left", "right"});
    for (std::size_t side = 0; side < 2; ++side)
      for (const json& key : j["hands"].value(side ? "right" : "left", json::array())) {
        HandKey& hand = s.hands[side].emplace_back();
        take(key, "frame", hand.frame);
        take(key, hand.pose);
        take(key, "trigger", hand.trigger);
        take(key, "tracked", hand.tracked);
        take(key, "buttons", hand.buttons);
      }
  }
  for (const json& item : j.value("events", json::array())) {
    allow(item,
          {"frame", "state", "event", "seconds", "call", "result", "p", "q", "pose_valid", "count", "vibrations"});
    ScriptEvent& event = s.events.emplace_back();
    take(item, "frame", event.frame);
    take(item, "state", event.state);
    take(item, "vibrations", event.vibrations);
    take(item, "event", event.event);
    take(item, "seconds", event.seconds);
    take(item, "call", event.call);
    take(item, "result", event.result);
    take(item, "pose_valid", event.pose_valid);
    take(item, "count", event.count);
    take(item, event.pose);
  }
  return s;
}

}  // namespace typodont::test::xr
