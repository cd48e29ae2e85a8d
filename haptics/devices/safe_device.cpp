#include "haptics/devices/safe_device.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <utility>

#include "engine/base/realtime.h"
#include "engine/contract/contact.h"
#include "haptics/device_safety.h"

namespace typodont::haptics {

namespace {

// Longest plausible time between two samples, s; a longer time is a clock jump or a stopped loop.
constexpr double kLongestGap = 0.1;
constexpr double kNoise = 5e-4;             // m, largest noise of the position of a resting hand
constexpr Nanos kWatchdogRest = 1'000'000;  // ns, interval of the watchdog's checks while no force is applied
constexpr double kPedalReleased = 0.05;

std::atomic<bool> all_stopped{false};

}  // namespace

SafeDevice::Options SafeDevice::options_for(const DeviceInfo& info) {
  Options options;
  options.limits.force = info.force_limit;
  options.limits.torque = info.torque_limit;
  options.limits.continuous = info.continuous_force;
  options.limits.silence = std::max({options.limits.silence, 1.8 / info.rate, info.silence});
  return options;
}

SafeDevice::SafeDevice(std::unique_ptr<HapticDevice> device, Options options)
    : device_(std::move(device)), options_(std::move(options)), info_(device_->info()) {
  if (!options_.clock) options_.clock = [] { return now(); };
  info_.force_limit = std::min(info_.force_limit, options_.limits.force);
  info_.torque_limit = std::min(info_.torque_limit, options_.limits.torque);
  gives_force_ = info_.force_limit > 0;
  if (gives_force_) {
    guard_device(*device_);
    install_exit_guard();
    if (options_.watchdog_thread) {
      watchdog_ = std::thread([this] {
        // Higher priority than the servo; the thread mostly sleeps.
        enter_realtime({.priority = 85, .core = -1, .lock_memory = false});
        while (!ending_.load()) {
          const Nanos t = options_.clock(), wake = watch(t);
          // If the clock jumps, the sleep must not become longer.
          const Nanos rest = std::clamp<Nanos>(wake - options_.clock(), 0, wake - t);
          std::this_thread::sleep_for(std::chrono::nanoseconds(rest));
        }
      });
    }
  }
}

SafeDevice::~SafeDevice() {
  ending_.store(true);
  if (watchdog_.joinable()) watchdog_.join();
  if (gives_force_) {
    device_->release();
    unguard_device(*device_);
  }
}

SafetyStatus SafeDevice::safety() noexcept {
  return {gives_force_, armed_, thermal_.heat, gives_force_ ? thermal_.allowed(options_.limits) : 0, take_events()};
}

void SafeDevice::release() noexcept {
  force_out_.store(false);
  device_->release();
}

void SafeDevice::send_zero() noexcept {
  last_f_ = last_tau_ = dvec3(0);
  release();
}

void SafeDevice::disarm(SafetyEvent event) noexcept {
  note(event);
  armed_ = false;
  gain_ = 0;
  free_for_ = 0;
  pedal_locked_ = true;
}

void SafeDevice::trip(SafetyEvent event) noexcept {
  disarm(event);
  if (gives_force_) send_zero();
}

Nanos SafeDevice::watch(Nanos t) noexcept {
  // Repeats zero force, because the servo may have sent a force after the watchdog's zero.
  if (tripped_.load()) {
    device_->release();
    return t + kWatchdogRest;
  }
  if (!force_out_.load()) return t + kWatchdogRest;
  const Nanos deadline = last_write_.load() + from_seconds(options_.limits.silence);
  // If the last write lies in the future, the clock was set back; this counts as a missing write.
  if (t < deadline && deadline - t <= 2 * from_seconds(options_.limits.silence)) return deadline;
  tripped_.store(true);
  note(SafetyEvent::kWatchdog);
  device_->release();
  return t + kWatchdogRest;
}

void SafeDevice::notice_delay(Nanos t) noexcept {
  if (!gives_force_) return;
  const Nanos since = t - last_write_.load();
  const bool missed = force_out_.load() && (since < 0 || since > from_seconds(options_.limits.silence));
  if (tripped_.exchange(false) || missed) disarm(SafetyEvent::kWatchdog);
}

bool SafeDevice::read(HandSample& sample) noexcept {
  faults_ = 0;
  HandSample raw;
  const bool alive = device_->read(raw);
  const Nanos t = options_.clock(), away = t - wrote_;
  const bool late = wrote_ != 0 && (tripped_.load() || away < 0 || away > from_seconds(options_.limits.silence));
  notice_delay(t);
  if (!alive) {
    trip(SafetyEvent::kDeviceLost);
    faults_ |= typodont::bits(Fault::kDeviceLost);
    return false;
  }
  if (gives_force_ && late) faults_ |= typodont::bits(Fault::kLetGo);  // the watchdog has already sent zero force
  const double norm2 = glm::dot(raw.X_WT.R, raw.X_WT.R);
  const bool sound = is_finite(raw.X_WT.p) && std::abs(norm2 - 1) < 1e-3 && std::isfinite(raw.pedal);
  if (!read_once_) {
    if (sound) last_ = raw, read_once_ = true;
    dt_ = 1 / info_.rate;
  } else {
    const double elapsed = to_seconds(raw.t - last_.t);
    dt_ = std::clamp(elapsed, 0.0, kLongestGap);
    if (!(elapsed > 0 && elapsed < kLongestGap)) {
      trip(SafetyEvent::kClock);
      faults_ |= typodont::bits(Fault::kBadInput);
    }
  }
  if (!sound) {
    trip(SafetyEvent::kNotFinite);
    faults_ |= typodont::bits(Fault::kBadInput);
    raw.X_WT = last_.X_WT;  // the last known pose of the hand
    raw.pedal = 0;
  } else if (glm::length(raw.X_WT.p - last_.X_WT.p) > options_.limits.speed * std::max(dt_, 1 / info_.rate) + kNoise) {
    trip(SafetyEvent::kJump);
    faults_ |= typodont::bits(Fault::kBadInput);
  }
  const std::uint32_t theirs = device_->faults();
  if (theirs & (typodont::bits(Fault::kBadInput) | typodont::bits(Fault::kDeviceLost))) trip(SafetyEvent::kDeviceFault);
  faults_ |= theirs;
  last_ = raw;
  gate_pedal(raw, dt_);
  sample = raw;
  return true;
}

void SafeDevice::gate_pedal(HandSample& sample, double dt) noexcept {
  const bool pressed = sample.pedal >= kPedalReleased;
  if (!pressed) {
    pedal_locked_ = false;
    pedal_held_ = 0;
  } else if ((pedal_held_ += dt) > options_.limits.pedal_time && !pedal_locked_) {
    pedal_locked_ = true;
    note(SafetyEvent::kPedalStuck);
  }
  if (all_stopped.load()) pedal_locked_ = true;
  if (pedal_locked_ || (gives_force_ && !armed_)) sample.pedal = 0;
}

void SafeDevice::send(const dvec3& f, const dvec3& tau) noexcept {
  // Stores the time first: if the thread is stopped during the write, the watchdog knows of the force.
  last_write_.store(options_.clock());
  force_out_.store(true);
  device_->write(f, tau);
  // The watchdog may have sent zero force just before this force was sent, so zero force is sent again.
  if (tripped_.load() || forces_forbidden()) device_->release();
}

void SafeDevice::write(const dvec3& f_T_W, const dvec3& tau_T_W) noexcept {
  if (!gives_force_) return;
  const SafetyLimits& limits = options_.limits;

  const Nanos t = options_.clock();
  wrote_ = t;
  notice_delay(t);
  if (!is_finite(f_T_W) || !is_finite(tau_T_W)) {
    trip(SafetyEvent::kNotFinite);
    faults_ |= typodont::bits(Fault::kBadInput);
    return;
  }

  if (forces_forbidden()) return send_zero();

  // Arms the motors after the required time without contact.
  const bool stop = all_stopped.load();
  if (stop) note(SafetyEvent::kEmergency);
  if (!armed_) {
    const bool free =
        !touching_ && glm::length(f_T_W) < limits.free_force && glm::length(tau_T_W) < limits.free_force * 0.1;
    // s, time that counts as free of contact; at most two sample periods, because a longer dt_ has missing samples
    const double seen = std::min(dt_, 2 / info_.rate);
    free_for_ = free && faults_ == 0 ? free_for_ + seen : 0;
    armed_ = free_for_ >= limits.free_time && !stop;
    thermal_.add(0, dt_, limits);
    send_zero();
    return;
  }
  if (stop) return trip(SafetyEvent::kEmergency);
  gain_ = std::min(1.0, gain_ + dt_ / limits.ramp_in);

  // Each limit only reduces the force, so their order does not matter.
  dvec3 f = f_T_W;
  dvec3 tau = tau_T_W;
  if (glm::length(f) > limits.force || glm::length(tau) > limits.torque) {
    if (glm::length(f) > limits.force) {
      note(SafetyEvent::kForceLimit);
      faults_ |= typodont::bits(Fault::kForceLimit);
    }
    f = clip_length(f, limits.force);
    tau = clip_length(tau, limits.torque);
  }
  const double bearable = thermal_.allowed(limits);
  if (glm::length(f) > bearable) {
    note(SafetyEvent::kThermal);
    faults_ |= typodont::bits(Fault::kForceLimit);
    f = clip_length(f, bearable);
  }
  f *= gain_;
  tau *= gain_;
  // Duration for the slew limit, s; at most 5 ms, so that a late tick causes no force step.
  const double dt = std::min(dt_, 5e-3);
  const dvec3 slewed = limit_slew(last_f_, f, limits.slew * dt);
  if (slewed != f && glm::length(slewed - f) > 1e-9) {
    note(SafetyEvent::kSlewLimit);
    faults_ |= typodont::bits(Fault::kSlewLimit);
  }
  last_f_ = slewed;
  last_tau_ = limit_slew(last_tau_, tau, limits.torque_slew * dt);
  thermal_.add(glm::length(last_f_), dt_, limits);
  send(last_f_, last_tau_);
}

void set_emergency_stop(bool on) noexcept {
  all_stopped.store(on);
}

bool emergency_stopped() noexcept {
  return all_stopped.load(std::memory_order_relaxed);
}

std::string describe_safety(std::uint32_t events) {
  std::string text;
  for (const auto& [event, name] : kSafetyEventNames) {
    if (!(events & bits(event))) continue;
    if (!text.empty()) text += ", ";
    text += name;
  }
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

}  // namespace typodont::haptics
