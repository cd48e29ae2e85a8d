// Driver for Touch and Phantom (3D Systems). Loads libHD.so at run time, which calls a callback at 1 kHz. The callback
// reads the pose, and sends zero instead of a force older than two callbacks, as a watchdog.
#include <fmt/format.h>
#include <semaphore.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <glm/gtc/quaternion.hpp>
#include <mutex>
#include <thread>

#include "engine/base/clock.h"
#include "engine/base/error.h"
#include "engine/base/latest.h"
#include "engine/base/units.h"
#include "engine/contract/contact.h"
#include "haptics/devices.h"
#include "haptics/devices/fd_link.h"
#include "haptics/devices/vendor_library.h"

namespace typodont::haptics {

namespace {

constexpr std::initializer_list<const char*> kLibraries{"libHD.so", "libHD.so.3.4", "libHD.so.3"};

// Types and constants of the C interface of OpenHaptics.
using HHD = unsigned int;
struct HDErrorInfo {
  unsigned int code;
  int internal;
  HHD device;
};
using Callback = unsigned int (*)(void*);
enum : unsigned int {
  kInvalid = 0xFFFFFFFF,
  kButtons = 0x2000,
  kTransform = 0x2052,
  kJointAngles = 0x2100,
  kGimbalAngles = 0x2150,
  kModelType = 0x2501,
  kSerialNumber = 0x2504,
  kMaxStiffness = 0x2602,
  kMaxForce = 0x2603,
  kMaxContinuousForce = 0x2604,
  kCurrentForce = 0x2700,
  kForceOutput = 0x4000,
  kMaxForceClamping = 0x4001,
  kDone = 0,
  kContinue = 1,
};

struct Api {
  VendorLibrary library{kLibraries,
                        "3D Systems OpenHaptics and the driver of the Touch, from 3D Systems' support pages"};
  HHD (*init)(const char*);
  void (*disable_device)(HHD);
  void (*make_current)(HHD);
  void (*begin_frame)(HHD);
  void (*end_frame)(HHD);
  void (*get_doubles)(unsigned int, double*);
  void (*get_integers)(unsigned int, int*);
  const char* (*get_string)(unsigned int);
  void (*set_doubles)(unsigned int, const double*);
  void (*enable)(unsigned int);
  void (*disable)(unsigned int);
  HDErrorInfo (*get_error)();
  void (*start_scheduler)();
  void (*stop_scheduler)();
  unsigned long (*schedule)(Callback, void*, unsigned short);
  void (*unschedule)(unsigned long);

  Api() {
    library.get(init, "hdInitDevice");
    library.get(disable_device, "hdDisableDevice");
    library.get(make_current, "hdMakeCurrentDevice");
    library.get(begin_frame, "hdBeginFrame");
    library.get(end_frame, "hdEndFrame");
    library.get(get_doubles, "hdGetDoublev");
    library.get(get_integers, "hdGetIntegerv");
    library.get(get_string, "hdGetString");
    library.get(set_doubles, "hdSetDoublev");
    library.get(enable, "hdEnable");
    library.get(disable, "hdDisable");
    library.get(get_error, "hdGetError");
    library.get(start_scheduler, "hdStartScheduler");
    library.get(stop_scheduler, "hdStopScheduler");
    library.get(schedule, "hdScheduleAsynchronous");
    library.get(unschedule, "hdUnschedule");
  }
};

/// Opens a device by name; "": the default device. Returns kInvalid if it does not exist.
HHD init(const Api& api, const std::string& name) {
  const HHD device = api.init(name.empty() ? nullptr : name.c_str());
  return api.get_error().code == 0 ? device : kInvalid;
}

/// Returns the description of the current device.
DeviceInfo describe(const Api& api, const std::string& name) {
  const auto text = [&](unsigned int what) {
    const char* s = api.get_string(what);
    return std::string(s ? s : "");
  };
  const auto number = [&](unsigned int what) {
    double value = 0;
    api.get_doubles(what, &value);
    return value;
  };
  DeviceInfo info{"openhaptics:" + name,
                  text(kModelType),
                  text(kSerialNumber),
                  1000,
                  number(kMaxForce),
                  number(kMaxStiffness) * kNewtonPerMillimetre,
                  0,
                  number(kMaxContinuousForce)};
  if (!(info.force_limit > 0 && info.force_limit < 100)) info.force_limit = 3.3;  // N, peak force of the weakest model
  return info;
}

constexpr const char* kDefaultName = "Default Device";

FoundDevice found(const std::string& name) {
  return {"openhaptics:" + name, "force feedback", name, "", "libHD.so", 0, true, ""};
}
FoundDevice found(const std::string& name, const DeviceInfo& info) {
  FoundDevice device = found(name);
  device.model = info.model, device.serial = info.serial, device.force_limit = info.force_limit;
  return device;
}

VendorDevices& devices() {
  static VendorDevices all;
  return all;
}

/// The library's scheduler, which all arms share. The first arm starts it, the last one stops it.
class Scheduler {
 public:
  void join(const Api& api) {
    const std::lock_guard lock(mutex_);
    if (arms_++ == 0) api.start_scheduler();
  }
  void leave(const Api& api) {
    const std::lock_guard lock(mutex_);
    if (--arms_ == 0) api.stop_scheduler();
  }

 private:
  std::mutex mutex_;
  int arms_ = 0;
};
Scheduler& scheduler() {
  static Scheduler one;
  return one;
}

class OpenHapticsDevice : public HapticDevice {
 public:
  OpenHapticsDevice(const std::string& name) {
    device_ = init(api_, name);
    if (device_ == kInvalid) {
      throw Error("openhaptics:" + name, "", "the library finds no such device", "a device its own test program finds");
    }
    api_.make_current(device_);
    info_ = describe(api_, name);
    info_.vibration_band = 100;      // Hz, largest frequency the device renders; our low estimate
    info_.position_step = 0.055e-3;  // m, value of the Touch; Phantoms have a better resolution
    use_.is(found(name.empty() ? kDefaultName : name, info_));
    ::sem_init(&fresh_, 0, 0);
    api_.enable(kForceOutput);
    api_.enable(kMaxForceClamping);
    task_ = api_.schedule(&OpenHapticsDevice::on_schedule, this, 0xffff);
    scheduler().join(api_);
  }

  ~OpenHapticsDevice() override {
    ending_.store(true);
    api_.unschedule(task_);
    scheduler().leave(api_);
    // Waits until the callback of this arm has ended. That takes microseconds; the wait is limited, because the library
    // may hang.
    for (int i = 0; stepping_.load() && i < 100; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    api_.make_current(device_);
    api_.begin_frame(device_);
    const double zero[3] = {0, 0, 0};
    api_.set_doubles(kCurrentForce, zero);
    api_.end_frame(device_);
    api_.disable(kForceOutput);
    api_.disable_device(device_);
    ::sem_destroy(&fresh_);
  }

  const DeviceInfo& info() const noexcept override { return info_; }
  std::uint32_t faults() const noexcept override { return faults_; }
  std::span<const double> joints() const noexcept override { return samples_.front().joints; }

  bool read(HandSample& sample) noexcept override {
    timespec until{};
    ::clock_gettime(CLOCK_MONOTONIC, &until);
    until.tv_nsec += 100'000'000;
    if (until.tv_nsec >= kNanosPerSecond) until.tv_nsec -= kNanosPerSecond, ++until.tv_sec;
    do {
      if (::sem_clockwait(&fresh_, CLOCK_MONOTONIC, &until) != 0 && errno != EINTR) {
        faults_ = bits(Fault::kDeviceLost);
        return false;
      }
    } while (!samples_.fetch());
    faults_ = samples_.front().error ? bits(Fault::kBadInput) : 0;
    sample = samples_.front().hand;
    return true;
  }

  void write(const dvec3& f_T_W, const dvec3&) noexcept override {
    released_.store(false);
    forces_.publish(f_T_W);
  }
  // The scheduler's callback reads this flag within a millisecond and sends zero force.
  void release() noexcept override { released_.store(true); }

 private:
  struct Sample {
    HandSample hand;
    // Joint angles, rad: turret, thigh, shin, gimbal.
    std::array<double, 6> joints{};
    bool error = false;
  };

  static unsigned int on_schedule(void* self) {
    auto& device = *static_cast<OpenHapticsDevice*>(self);
    device.stepping_.store(true);
    const bool ending = device.ending_.load();
    if (!ending) device.step();
    device.stepping_.store(false);
    return ending ? kDone : kContinue;
  }

  void step() noexcept {
    api_.begin_frame(device_);
    double X[16] = {};  // pose as a matrix, column-major; positions in mm
    int buttons = 0;
    api_.get_doubles(kTransform, X);
    api_.get_integers(kButtons, &buttons);
    Sample& out = samples_.back();
    api_.get_doubles(kJointAngles, out.joints.data());
    api_.get_doubles(kGimbalAngles, out.joints.data() + 3);
    age_ = forces_.fetch() ? 0 : age_ + 1;
    dvec3 f(0);
    if (age_ <= 2 && !released_.load()) f = forces_.front();
    const double force[3] = {f.x, f.y, f.z};
    api_.set_doubles(kCurrentForce, force);
    api_.end_frame(device_);

    out.error = api_.get_error().code != 0;
    const glm::dmat3 R(X[0], X[1], X[2], X[4], X[5], X[6], X[8], X[9], X[10]);
    out.hand = {
        now(), {dvec3(X[12], X[13], X[14]) * kMillimetre, glm::normalize(glm::quat_cast(R))}, buttons & 1 ? 1.0 : 0.0};
    samples_.publish();
    ::sem_post(&fresh_);
  }

  VendorDevices::Use use_{devices()};
  Api api_;
  HHD device_ = kInvalid;
  DeviceInfo info_;
  unsigned long task_ = 0;
  sem_t fresh_{};
  std::uint32_t faults_ = 0;
  std::atomic<bool> ending_{false}, stepping_{false}, released_{true};
  Latest<Sample> samples_;  // passes samples from the scheduler to the servo
  Latest<dvec3> forces_;    // passes forces from the servo to the scheduler
  int age_ = 1000;          // callbacks since the last force; used by the scheduler's thread
};

/// Names of the devices that were set up with the vendor's program, which writes one file for each.
std::vector<std::string> configured_names() {
  const char* home = std::getenv("GTDD_HOME");
  const std::filesystem::path folder = std::filesystem::path(home ? home : "/usr/share/3DSystems") / "config";
  std::vector<std::string> names;
  std::error_code none;
  for (const auto& file : std::filesystem::directory_iterator(folder, none)) {
    if (file.path().extension() == ".config") names.push_back(file.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<FoundDevice> find() {
  if (!VendorLibrary::present(kLibraries)) return {};
  const Api api;
  const std::vector<std::string> names = configured_names();
  if (names.empty()) {
    FoundDevice none = found(kDefaultName);
    none.permitted = false;
    none.mend = "naming the device in 3D Systems' set-up program (Touch_Setup)";
    return {none};
  }
  std::vector<FoundDevice> plain;
  for (const std::string& name : names) plain.push_back(found(name));
  return devices().list(std::move(plain), [&](std::size_t i) {
    const HHD device = init(api, names[i]);
    if (device == kInvalid) {
      FoundDevice closed = found(names[i]);
      closed.permitted = false;
      closed.mend = fmt::format("turning it on, ending the program that holds it, or {}", kPermissionRemedy);
      return closed;
    }
    api.make_current(device);
    const FoundDevice open = found(names[i], describe(api, names[i]));
    api.disable_device(device);
    return open;
  });
}

std::unique_ptr<HapticDevice> open(const std::string& rest, const HandOptions&) {
  return std::make_unique<OpenHapticsDevice>(rest);
}

}  // namespace

extern const Driver openhaptics_driver;
const Driver openhaptics_driver{
    .scheme = "openhaptics",
    .rest = "[NAME]",
    .about = "3D Systems Touch and Phantom, by the name given in OpenHaptics' set-up",
    .open = open,
    .find = find,
};

}  // namespace typodont::haptics
