// Driver for omega, sigma, lambda (Force Dimension) and Falcon (Novint). Loads libdhd or libdrd at run time.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <glm/gtc/quaternion.hpp>

#include "engine/base/clock.h"
#include "engine/base/error.h"
#include "engine/base/realtime.h"
#include "engine/contract/contact.h"
#include "haptics/devices.h"
#include "haptics/devices/fd_link.h"
#include "haptics/devices/vendor_library.h"

namespace typodont::haptics {

namespace {

constexpr std::initializer_list<const char*> kLibraries{"libdrd.so.3", "libdhd.so.3"};

struct Api {
  VendorLibrary library{kLibraries, "Force Dimension's SDK 3, from forcedimension.com"};
  int (*count)();
  int (*open)(char);
  int (*open_serial)(int);
  int (*close)(char);
  int (*enable_force)(unsigned char, char);
  int (*position)(double*, double*, double*, char);
  int (*frame)(double[3][3], char);
  unsigned int (*buttons)(char);
  int (*set_force)(double, double, double, double, double, double, char);
  int (*watchdog)(unsigned char, char);
  const char* (*name)(char);
  int (*serial)(unsigned short*, char);
  int (*joint_angles)(double*, char);
  bool (*has_wrist)(char);
  const char* (*last_error)();

  Api() {
    library.get(count, "dhdGetDeviceCount");
    library.get(open, "dhdOpenID");
    library.get(close, "dhdClose");
    library.get(enable_force, "dhdEnableForce");
    library.get(position, "dhdGetPosition");
    library.get(frame, "dhdGetOrientationFrame");
    library.get(buttons, "dhdGetButtonMask");
    library.get(set_force, "dhdSetForceAndTorque");
    library.find(watchdog, "dhdSetWatchdog");
    library.find(name, "dhdGetSystemName");
    library.find(serial, "dhdGetSerialNumber");
    library.find(joint_angles, "dhdGetJointAngles");
    library.find(has_wrist, "dhdHasWrist");
    library.find(open_serial, "dhdOpenSerial");
    library.find(last_error, "dhdErrorGetLastStr");
  }
};

constexpr int kMost = 16;  // largest device index; larger numbers are serial numbers

/// Recommended force and stiffness of a model, found by a word in its reported name.
struct Known {
  const char* word;
  double force, stiffness, torque;
};
constexpr Known kKnown[] = {{"sigma", 12, 4000, 0.4},
                            {"lambda", 12, 8000, 0},
                            {"omega", 12, 5000, 0},
                            {"delta", 12, 4000, 0},
                            {"Falcon", 8, 3000, 0}};

/// Returns the description of the open device `id`.
DeviceInfo describe(const Api& api, char id, const std::string& address, double rate) {
  const char* name = api.name ? api.name(id) : nullptr;
  DeviceInfo info{address, name ? name : "Force Dimension", "", rate, 8, 3000, 0, 0};
  for (const Known& k : kKnown) {
    if (info.model.find(k.word) == std::string::npos) continue;
    info.force_limit = k.force, info.max_stiffness = k.stiffness, info.torque_limit = k.torque;
    break;
  }
  unsigned short serial = 0;
  if (api.serial && api.serial(&serial, id) >= 0) info.serial = std::to_string(serial);
  return info;
}

FoundDevice found(int number) {
  return {fmt::format("forcedimension:{}", number), "force feedback", "Force Dimension", "", "libdhd", 0, true, ""};
}
FoundDevice found(int number, const DeviceInfo& info) {
  FoundDevice device = found(number);
  device.model = info.model, device.serial = info.serial, device.force_limit = info.force_limit;
  return device;
}
/// Reason of the last failure, if the library states one.
std::string refusal(const Api& api) {
  const char* said = api.last_error ? api.last_error() : nullptr;
  return said && *said ? said : "it does not open";
}

VendorDevices& devices() {
  static VendorDevices all;
  return all;
}

class ForceDimensionDevice : public HapticDevice {
 public:
  ForceDimensionDevice(const std::string& address, int which, double rate) : period_(from_seconds(1 / rate)) {
    int opened = -1;
    if (which < kMost) {
      opened = api_.open(static_cast<char>(which));
    } else if (api_.open_serial) {
      opened = api_.open_serial(which);
    }
    if (opened < 0) {
      throw Error(address, "", fmt::format("{} devices, and this one: {}", api_.count(), refusal(api_)),
                  "a device that is on, free and yours to open; see: typodont devices");
    }
    id_ = static_cast<char>(opened);
    info_ = describe(api_, id_, address, rate);
    if (which < kMost) use_.is(found(which, info_));
    info_.vibration_band = 250;     // Hz, largest frequency that the device renders; a low estimate
    info_.position_step = 0.01e-3;  // m, the manufacturer's value for the omega (not verified)
    // The controller's watchdog counts steps of 125 µs (not verified): 16 steps are 2 ms; 0 would disable it.
    if (api_.watchdog) api_.watchdog(16, id_);
    wrist_ = api_.has_wrist && api_.has_wrist(id_);
    send(dvec3(0), dvec3(0));
    api_.enable_force(1, id_);
  }
  ~ForceDimensionDevice() override {
    send(dvec3(0), dvec3(0));
    api_.enable_force(0, id_);
    api_.close(id_);
  }

  const DeviceInfo& info() const noexcept override { return info_; }
  std::uint32_t faults() const noexcept override { return faults_; }
  std::span<const double> joints() const noexcept override { return {joints_.data(), joint_count_}; }

  bool read(HandSample& sample) noexcept override {
    const Nanos entered = now();
    due_ = due_ == 0 || entered - due_ > 10 * period_ ? entered + period_ : due_ + period_;
    sleep_until(due_);
    faults_ = 0;
    dvec3 p(0);
    double R[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    // A negative result means failure; a small positive result means that the value has not changed.
    bool ok = api_.position(&p.x, &p.y, &p.z, id_) >= 0;
    ok = api_.frame(R, id_) >= 0 && ok;
    if (!ok) {
      if (failing_since_ == 0) failing_since_ = now();
      faults_ = bits(Fault::kBadInput);
      send(dvec3(0), dvec3(0));
      if (now() - failing_since_ > 100'000'000) {
        faults_ = bits(Fault::kDeviceLost);
        return false;
      }
      sample = last_;
      sample.t = now();
      return true;
    }
    failing_since_ = 0;
    joint_count_ = 0;
    if (api_.joint_angles && api_.joint_angles(joints_.data(), id_) >= 0) joint_count_ = wrist_ ? 6 : 3;
    const glm::dmat3 columns(R[0][0], R[1][0], R[2][0], R[0][1], R[1][1], R[2][1], R[0][2], R[1][2], R[2][2]);
    sample = {now(), {p, glm::normalize(glm::quat_cast(columns))}, api_.buttons(id_) & 1 ? 1.0 : 0.0};
    last_ = sample;
    return true;
  }
  void write(const dvec3& f, const dvec3& tau) noexcept override { send(f, tau); }
  void release() noexcept override { send(dvec3(0), dvec3(0)); }

 private:
  void send(const dvec3& f, const dvec3& tau) noexcept { api_.set_force(f.x, f.y, f.z, tau.x, tau.y, tau.z, id_); }

  VendorDevices::Use use_{devices()};
  Api api_;
  DeviceInfo info_;
  char id_ = 0;
  Nanos period_, due_ = 0, failing_since_ = 0;
  HandSample last_;
  // Joint angles, rad, as many as DHD_MAX_DOF; only those of base and wrist are used.
  std::array<double, 8> joints_{};
  std::size_t joint_count_ = 0;
  bool wrist_ = false;
  std::uint32_t faults_ = 0;
};

std::vector<FoundDevice> find() {
  if (!VendorLibrary::present(kLibraries)) return {};
  const Api api;
  std::vector<FoundDevice> plain;
  for (int i = 0; i < std::clamp(api.count(), 0, kMost); ++i) plain.push_back(found(i));
  return devices().list(std::move(plain), [&](std::size_t i) {
    const int number = static_cast<int>(i), id = api.open(static_cast<char>(number));
    if (id < 0) {
      FoundDevice closed = found(number);
      closed.permitted = false;
      closed.mend = fmt::format("turning it on, ending the program that holds it, or {} (the library says: {})",
                                kPermissionRemedy, refusal(api));
      return closed;
    }
    const FoundDevice open = found(number, describe(api, static_cast<char>(id), "", 0));
    api.close(static_cast<char>(id));
    return open;
  });
}

std::unique_ptr<HapticDevice> open(const std::string& rest, const HandOptions& options) {
  const std::string address = "forcedimension:" + rest;
  int which = 0;
  if (!rest.empty()) {
    const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), which);
    if (error != std::errc() || end != rest.data() + rest.size() || which < 0) {
      throw Error(address, "", rest, "a number from 0 to 15, or a serial");
    }
  }
  return std::make_unique<ForceDimensionDevice>(address, which, std::clamp(options.rate, 500.0, 8000.0));
}

}  // namespace

extern const Driver forcedimension_driver;
const Driver forcedimension_driver{
    .scheme = "forcedimension",
    .rest = "[NUMBER or SERIAL]",
    .about = "Force Dimension omega, sigma, lambda, delta and Falcon",
    .open = open,
    .find = find,
};

}  // namespace typodont::haptics
