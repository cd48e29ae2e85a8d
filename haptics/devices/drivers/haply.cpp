// Driver for Inverse3 (Haply) through its vendor's WebSocket service.
#include "haptics/devices/haply.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/base/error.h"
#include "engine/contract/contact.h"
#include "haptics/devices.h"
#include "haptics/devices/fd_link.h"
#include "haptics/devices/json_scan.h"
#include "haptics/devices/watchdog_process.h"
#include "haptics/devices/websocket.h"

namespace typodont::haptics {

namespace {

constexpr int kPort = 10001;
// ns without a state message after which zero force is sent, because the service sends a state only as an answer.
constexpr Nanos kWake = 10'000'000;
constexpr Nanos kLost = 100'000'000;

std::optional<dvec3> vector_of(const std::optional<JsonText>& json) {
  if (!json) return std::nullopt;
  dvec3 v;
  const char* const names[] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i) {
    const auto member = json->get(names[i]);
    const auto number = member ? member->number() : std::nullopt;
    if (!number) return std::nullopt;
    v[i] = *number;
  }
  return v;
}

class HaplyDevice : public HapticDevice {
 public:
  HaplyDevice(std::unique_ptr<Link> link, const std::string& host, DeviceInfo identity, Descriptor claimed)
      : claimed_(std::move(claimed)), socket_(std::move(link), host, "/"), info_(std::move(identity)) {
    info_.force_limit = 8;       // N, peak force that the manufacturer states (not verified)
    info_.continuous_force = 4;  // N, our low estimate, half of the peak force
    info_.max_stiffness = 3500;  // N/m, largest stiffness that the device can render (not verified)
    info_.vibration_band = 100;  // Hz, largest frequency the device renders; our low estimate
    const Nanos give_up = socket_.now() + kNanosPerSecond;
    while (state_.id[0] == 0) {
      std::string_view message;
      const auto got = socket_.receive(message, kWake);
      if (got == WebSocket::Got::kLost || socket_.now() > give_up) {
        throw Error(host, "", "a service without an Inverse3", "an Inverse3 that is on and calibrated");
      }
      if (got != WebSocket::Got::kMessage) continue;
      if (const auto state = parse_haply(message)) state_ = *state;
    }
    info_.serial = state_.id.data();
    zero_ = frame_for(dvec3(0));
    watchdog_process_.emplace(socket_.descriptor(), socket_.frame_of({zero_.text.data(), zero_.size}));
  }
  ~HaplyDevice() override { release(); }

  const DeviceInfo& info() const noexcept override { return info_; }
  std::uint32_t faults() const noexcept override { return faults_; }

  bool read(HandSample& sample) noexcept override {
    faults_ = 0;
    // ns, total waiting time; a pause of this process counts as at most 2 × kWake
    Nanos waited = 0;
    if (!started_) release();  // sends zero force; the service answers with the first state
    started_ = true;
    bool fresh = false, rubbish = false;
    Nanos t = socket_.now();
    for (int messages = 0;; ++messages) {
      std::string_view message;
      const Nanos before = t, early = std::max<Nanos>(spacing_.left(t), 0);
      if (fresh && early == 0 && messages > kMaxQueued) return hand_over(sample, t);
      const auto got = socket_.receive(message, fresh ? early : kWake);
      t = socket_.now();
      waited += std::clamp<Nanos>(t - before, 0, 2 * kWake);
      if (got == WebSocket::Got::kLost || waited > kLost) {
        faults_ |= bits(Fault::kDeviceLost);
        release();
        return false;
      }
      if (got == WebSocket::Got::kMessage) {
        const auto state = parse_haply(message);
        if (state && state->id == state_.id) {
          state_ = *state;
          fresh = true;
          continue;  // continues to read, because only the newest message is used
        }
        if (!state) faults_ |= bits(Fault::kBadInput);
        // Zero force is sent once per series of invalid messages; the service answers it with the next state.
        if (!rubbish) release();
        rubbish = !state;
        continue;
      }
      if (fresh && spacing_.left(t) > 0) continue;
      if (fresh) return hand_over(sample, t);
      faults_ |= bits(Fault::kBadInput);
      release();  // no message came: zero force makes the service answer with a state
    }
  }
  void write(const dvec3& f_T_W, const dvec3&) noexcept override {
    const Frame frame = frame_for(f_T_W);
    // The watchdog process must learn of a force before it is sent.
    watchdog_process_->note_write(f_T_W != dvec3(0), now());
    socket_.send({frame.text.data(), frame.size});
  }
  void release() noexcept override {
    socket_.send({zero_.text.data(), zero_.size});
    if (watchdog_process_) watchdog_process_->note_write(false, now());
  }

 private:
  bool hand_over(HandSample& sample, Nanos t) noexcept {
    spacing_.taken(t);
    sample = {t, {state_.position, state_.orientation}, state_.button ? 1.0 : 0.0};
    return true;
  }

  struct Frame {
    std::array<char, 256> text{};
    std::size_t size = 0;
  };
  Frame frame_for(const dvec3& f) const noexcept {
    Frame frame;
    const auto safe = [](double v) { return std::isfinite(v) ? std::clamp(v, -100.0, 100.0) : 0.0; };
    const auto end = fmt::format_to_n(
        frame.text.data(), frame.text.size(),
        R"({{"inverse3":[{{"device_id":"{}","commands":{{"set_cursor_force":{{"values":{{"x":{:.4f},"y":{:.4f},"z":{:.4f}}}}}}}}}]}})",
        state_.id.data(), safe(f.x), safe(f.y), safe(f.z));
    frame.size = std::min(end.size, frame.text.size());
    return frame;
  }

  Descriptor claimed_;  // prevents other programs from using this device
  WebSocket socket_;
  DeviceInfo info_;
  HaplyState state_;
  SampleSpacing spacing_{info_.rate};
  Frame zero_;
  // Child process that sends zero force if this process no longer can.
  std::optional<WatchdogProcess> watchdog_process_;
  std::uint32_t faults_ = 0;
  bool started_ = false;
};

std::unique_ptr<HapticDevice> open(const std::string& rest, const HandOptions&) {
  if (!rest.empty()) throw Error("haply:" + rest, "", rest, "nothing after the colon: the service has one address");
  const std::string service = fmt::format("127.0.0.1:{}", kPort);
  auto link = connect_tcp("127.0.0.1", kPort);
  return make_haply(std::move(link), service, {"haply:", "Haply Inverse3", ""}, claim("haply", service));
}

std::vector<FoundDevice> find() {
  try {
    connect_tcp("127.0.0.1", kPort);
  } catch (const Error&) {
    return {};
  }
  return {{"haply:", "force feedback", "Haply Inverse3 service", "", fmt::format("127.0.0.1:{}", kPort), 8, true, ""}};
}

}  // namespace

std::optional<HaplyState> parse_haply(std::string_view message) noexcept {
  const JsonText json(message);
  const auto arms = json.get("inverse3");
  const auto arm = arms ? arms->first() : std::nullopt;
  if (!arm) return std::nullopt;
  const auto id = arm->get("device_id");
  const auto id_text = id ? id->string() : std::nullopt;
  const auto state = arm->get("state");
  const auto position = state ? vector_of(state->get("cursor_position")) : std::nullopt;
  // The identifier is inserted into messages, so it must not contain quotes or escapes.
  HaplyState out;
  if (!id_text || id_text->empty() || id_text->size() >= out.id.size() ||
      id_text->find_first_of("\\\"") != std::string_view::npos || !position) {
    return std::nullopt;
  }
  std::copy(id_text->begin(), id_text->end(), out.id.begin());
  out.position = *position;

  const auto grips = json.get("wireless_verse_grip");
  const auto grip = grips ? grips->first() : std::nullopt;
  const auto grip_state = grip ? grip->get("state") : std::nullopt;
  if (grip_state) {
    const auto q = grip_state->get("orientation");
    const auto xyz = vector_of(q);
    const auto w = q ? q->get("w") : std::nullopt;
    const auto w_number = w ? w->number() : std::nullopt;
    if (xyz && w_number) {
      const dquat R(*w_number, xyz->x, xyz->y, xyz->z);
      const double length = glm::length(R);
      if (std::abs(length - 1) > 0.05) return std::nullopt;
      out.orientation = R / length;
    }
    if (const auto buttons = grip_state->get("buttons")) {
      const auto a = buttons->get("a");
      out.button = a && a->is("true");
    }
  }
  return out;
}

std::unique_ptr<HapticDevice> make_haply(std::unique_ptr<Link> link, const std::string& host, DeviceInfo identity,
                                         Descriptor claimed) {
  return std::make_unique<HaplyDevice>(std::move(link), host, std::move(identity), std::move(claimed));
}

extern const Driver haply_driver;
const Driver haply_driver{
    .scheme = "haply",
    .rest = "",
    .about = "Haply Inverse3 through its local service",
    .open = open,
    .find = find,
};

}  // namespace typodont::haptics
