#include "engine/app/live/sound_follower.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <limits>
#include <optional>
#include <string_view>

#include "engine/app/sound_link.h"
#include "engine/base/error.h"
#include "engine/base/json.h"
#include "engine/base/units.h"
#include "haptics/message_stream.h"

namespace typodont {

namespace {

constexpr Nanos kSoundPeriod = 10'000'000,
                kSilence =
                    5 * kNanosPerSecond;   // ns, longest wait for one message, and longest time without any message
constexpr Nanos kToCompare = 100'000'000;  // ns, time before the sound starts, to measure the shortest arrival delay
constexpr double kLongest = 1e6;           // s, longest session

haptics::MessageStream connect(const std::string& address) {
  std::string_view rest = address;
  unsigned port = 0;
  std::string host = "127.0.0.1";
  if (rest.starts_with("ws:")) rest.remove_prefix(3);
  if (const auto colon = rest.rfind(':'); colon != std::string_view::npos) {
    host = rest.substr(0, colon);
    rest.remove_prefix(colon + 1);
  }
  const auto read = std::from_chars(rest.data(), rest.data() + rest.size(), port);
  if (!address.starts_with("ws:") || read.ec != std::errc() || read.ptr != rest.data() + rest.size() || port == 0 ||
      port > 65535)
    throw Error("sound follow", "", address, "ws:[HOST:]PORT");
  return {host, static_cast<int>(port)};
}

SoundVoice read_voice(const Json& json) {
  SoundVoice voice{json["model"].string(), json["free_speed_krpm"].number(0, 1000) * kKrpm, {}, false};
  for (const Json& cuts : json["tools_cut"].items()) voice.tools_cut.push_back(cuts.boolean());
  return voice;
}

/// Reads from JSON those members of a tick on which the sound depends.
ServoTick read_tick(const Json& json, const std::vector<std::string>& tools) {
  constexpr double kFar = 1e6;
  const auto vec = [](const Json& numbers) {
    const std::vector<double> v = numbers.numbers(3);
    return glm::clamp(dvec3(v[0], v[1], v[2]), -kFar, kFar);
  };
  ServoTick tick;
  tick.index = static_cast<std::uint64_t>(json["tick"].integer(0));
  tick.t = from_seconds(json["t_s"].number(0, kLongest));
  tick.X_WG.p = vec(json["tool_mm"]) * kMillimetre;
  tick.f_T_W = vec(json["force_N"]);
  tick.n_C_W = vec(json["normal"]);
  tick.contact_area = json["contact_area_mm2"].number(0, kFar) * kSquareMillimetre;
  tick.spindle = json["spindle_krpm"].number(-1000, 1000) * kKrpm;
  tick.pedal = json["pedal"].number(0, 1);
  tick.tissue = tissue_named(json["tissue"].string()).value_or(Tissue::kAir);
  const Json removed = json["removed_mm3"];
  for (const std::string& name : removed.keys())
    if (const auto tissue = tissue_named(name))
      tick.removed[static_cast<std::size_t>(*tissue)] = removed[name].number(0, kFar * kFar) * kCubicMillimetre;
  const auto tool = std::ranges::find(tools, json["tool"].string());
  tick.tool = static_cast<std::uint32_t>(tool - tools.begin());
  return tick;
}

Nanos unix_now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

class Follower {
 public:
  explicit Follower(const FollowOptions& options) : options_(options), live_(!options.audio.starts_with("wav:")) {}

  /// Processes a message. False: the session has ended.
  bool take(const Json& message) {
    const std::string type = message["type"].string();
    if (type == "hello") {
      result_.scene = message["scene"].string();
      tools_.clear();
      for (const Json& tool : message["tools"].items()) tools_.push_back(tool.string());
      voice_ = read_voice(message["sound"]);
      unix_zero_ = message["clock"]["zero_unix_ns"].integer(0);
    } else if (type == "state" && voice_) {
      hear(read_tick(message, tools_));
      result_.lost = static_cast<std::uint64_t>(message["lost"].integer(0));
    }
    return type != "event" || message["kind"].string() != "end";
  }

  /// Computes the sound up to now. Call at least ten times per second.
  void advance() {
    if (!link_ || (live_ && last_ - first_ < kToCompare)) return;
    link_->advance(live_ ? session_now() : last_ - first_);
  }
  bool long_enough() const { return options_.seconds > 0 && to_seconds(last_ - first_) >= options_.seconds; }

  FollowedSound stop() {
    if (!link_) throw RunFailure(options_.address + ": no state arrived");
    link_->stop(live_ ? session_now() : last_ - first_);
    result_.seconds = to_seconds(last_ - first_);
    result_.delay = link_->latency() + options_.wait;
    result_.network = unix_zero_ > 0 ? to_seconds(fastest_ + (unix_now() - now()) - unix_zero_)
                                     : std::numeric_limits<double>::quiet_NaN();
    return result_;
  }

 private:
  void hear(const ServoTick& tick) {
    if (result_.states++ == 0) {
      first_ = tick.t;
      link_.emplace(options_.audio, *voice_, event_logs_, live_, /*binaural=*/false, live_ ? 0 : first_);
    } else if (tick.t <= last_) {
      return;
    }
    last_ = tick.t;
    fastest_ = std::min(fastest_, now() - tick.t);
    event_logs_.servo.write(tick);
  }
  Nanos session_now() const { return now() - fastest_ - from_seconds(options_.wait); }

  const FollowOptions& options_;
  const bool live_;  // true: a sound device; false: a file
  std::optional<SoundVoice> voice_;
  std::vector<std::string> tools_;
  EventLogs event_logs_;
  std::optional<SoundLink> link_;
  FollowedSound result_;
  Nanos first_ = 0, last_ = 0;  // ns, session times of the first and the last state
  Nanos fastest_ =
      std::numeric_limits<Nanos>::max();  // ns, smallest difference: a state's arrival (this clock) - its session time
  Nanos unix_zero_ = 0;                   // ns since 1970, start of the session on the other computer's clock
};

}  // namespace

FollowedSound follow_sound(const FollowOptions& options) {
  haptics::MessageStream socket = connect(options.address);
  Follower follower(options);
  for (Nanos heard = now(); !follower.long_enough();) {
    std::string_view text;
    const auto got = socket.receive(text, kSoundPeriod);
    if (got == haptics::MessageStream::Got::kMessage) {
      heard = now();
      if (!follower.take(Json::parse(text, options.address, Json::Lines::kUnknown))) break;
    }
    if (got == haptics::MessageStream::Got::kLost || now() - heard > kSilence)
      throw RunFailure(options.address + ": the connection was lost before the session's end");
    follower.advance();
  }
  return follower.stop();
}

}  // namespace typodont
