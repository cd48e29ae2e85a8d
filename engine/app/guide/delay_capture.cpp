#include "engine/app/guide/delay_capture.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include "engine/app/assets.h"
#include "engine/app/scene.h"
#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/base/units.h"
#include "engine/display/head_tracker.h"
#include "haptics/devices.h"

namespace typodont {

namespace {

using calibration::DelayResult;
using calibration::Stream;
using namespace std::chrono_literals;

/// Records the samples of one device with their arrival times, on its own thread.
class Recording {
 public:
  virtual ~Recording() { stop(); }
  /// Reads the first sample, which starts the device's own clock. wake() is called for all devices before the recording
  /// begins, so that their start-up does not count as delay.
  virtual void wake() {}
  virtual void begin() = 0;
  bool ended() const { return ended_; }
  Stream so_far() const {
    const std::lock_guard lock(mutex_);
    return stream_;
  }

 protected:
  void start(std::function<void()> follow) {
    thread_ = std::thread([this, follow = std::move(follow)] {
      follow();
      ended_ = true;
    });
  }
  void stop() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }
  bool stopping() const { return stop_; }
  void add(Nanos t, const dvec3& p) {
    const std::lock_guard lock(mutex_);
    const double seconds = to_seconds(t - zero());
    if (stream_.t.empty() || seconds > stream_.t.back()) stream_.t.push_back(seconds), stream_.p.push_back(p);
  }
  /// Start time of the run, common to both devices, ns.
  static Nanos zero() {
    static const Nanos began = now();
    return began;
  }

 private:
  mutable std::mutex mutex_;
  Stream stream_;
  std::atomic<bool> stop_{false}, ended_{false};
  std::thread thread_;
};

class HandRecording : public Recording {
 public:
  HandRecording(const std::string& address, const std::string& pedal) {
    zero();
    haptics::HandOptions options;
    options.pedal = pedal == "none" ? "" : pedal;
    options.assets = assets_folder();
    device_ = haptics::open_hand(address, options);
  }
  ~HandRecording() override { stop(); }

  void wake() override {
    haptics::HandSample first;
    awake_ = device_->read(first);
  }
  void begin() override {
    start([this] {
      haptics::HandSample sample;
      while (awake_ && !stopping() && device_->read(sample)) {
        device_->write(dvec3(0), dvec3(0));
        add(now(), sample.X_WT.p);
      }
      device_->release();
    });
  }

 private:
  std::unique_ptr<haptics::HapticDevice> device_;
  bool awake_ = false;  // true after the first sample has arrived
};

class TrackerRecording : public Recording {
 public:
  explicit TrackerRecording(const display::TrackerAddress& address) {
    zero();
    socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_in at{};
    at.sin_family = AF_INET, at.sin_port = htons(address.port);
    std::memcpy(&at.sin_addr, address.host.data(), 4);
    if (socket_ < 0 || ::bind(socket_, reinterpret_cast<const sockaddr*>(&at), sizeof at) != 0) {
      const std::string why = std::strerror(errno);
      if (socket_ >= 0) ::close(socket_);
      throw Error("--with", "", fmt::format("opentrack port {}: {}", address.port, why),
                  "a port that is free on this machine");
    }
  }
  ~TrackerRecording() override {
    stop();
    ::close(socket_);
  }

  void begin() override {
    start([this] {
      std::array<std::byte, 64> packet;
      while (!stopping()) {
        pollfd watch{socket_, POLLIN, 0};
        if (::poll(&watch, 1, 50) <= 0) continue;
        const ssize_t n = ::recv(socket_, packet.data(), packet.size(), 0);
        const Nanos t = now();
        if (n <= 0) continue;
        if (const auto head = display::parse_opentrack(std::span(packet).first(static_cast<std::size_t>(n))))
          add(t, head->translation);
      }
    });
  }

 private:
  int socket_ = -1;
};

std::unique_ptr<Recording> open(const std::string& address, const std::string& pedal) {
  if (address.starts_with("opentrack:")) {
    const auto tracker = display::parse_tracker_address(address);
    if (!tracker) throw Error("--with", "", address, "opentrack:PORT or opentrack:ADDRESS:PORT");
    return std::make_unique<TrackerRecording>(*tracker);
  }
  return std::make_unique<HandRecording>(address, pedal);
}

}  // namespace

DelayCapture capture_delay(const DelayCaptureOptions& options) {
  const auto a = open(options.hand, options.pedal), b = open(options.with, "none");
  a->wake(), b->wake();
  a->begin(), b->begin();
  fmt::print("Hold both together and move them to and fro, unevenly, as fast as is comfortable.\n");
  std::fflush(stdout);
  DelayCapture capture;
  bool any = false;
  const Nanos began = now();
  for (Nanos next = began + from_seconds(4);; next += from_seconds(2)) {
    const Nanos end = began + from_seconds(options.seconds);
    while (now() < std::min(next, end) && !(a->ended() || b->ended())) std::this_thread::sleep_for(20ms);
    const bool over = now() >= end || a->ended() || b->ended();
    capture.a = a->so_far(), capture.b = b->so_far();
    std::string missing;
    try {
      capture.result = calibration::estimate_delay(capture.a, capture.b);
      any = true;
      const DelayResult& r = capture.result;
      fmt::print("{:.0f} s: {}\n", to_seconds(now() - began),
                 r.ambiguous ? r.reason
                             : fmt::format("{:.3f} ± {:.3f} ms{}", r.delay * 1e3, r.sigma * 1e3,
                                           r.rich ? ", known to 0.1 ms" : ""));
      std::fflush(stdout);
      if (r.rich && !r.ambiguous) return capture;
    } catch (const Error& e) {
      missing = e.what();
      fmt::print("{:.0f} s: {}\n", to_seconds(now() - began), missing);
      std::fflush(stdout);
    }
    if (!over) continue;
    if (!any || !missing.empty()) throw RunFailure("delay: " + missing);
    return capture;
  }
}

}  // namespace typodont
