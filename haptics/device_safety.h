// Emergency stop, and zero force however the program ends. Force limits: devices/safe_device.h.
#pragma once

#include <cstdint>
#include <string>

#include "haptics/haptic_device.h"

namespace typodont::haptics {

/// From its next tick on, every live session of this process gives no force and stops its drill, and every device with
/// motors gets zero at its next write. After the end, the force returns to a hand that is free of contact. Any thread.
void set_emergency_stop(bool on) noexcept;
bool emergency_stopped() noexcept;

/// For example "watchdog, device fault".
std::string describe_safety(std::uint32_t events);

/// Zero force at exit, failed check, uncaught exception, fatal signal or Ctrl-C, by atexit() and handlers for SIGINT,
/// SIGTERM, SIGHUP, SIGQUIT, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, which then call the earlier handler. Later
/// handlers of the program should first call release_all_devices(). After SIGKILL or a failure of the computer, only
/// the device's watchdog helps.
void install_exit_guard();

/// Gets zero force when the program ends. Any thread. Throws RunFailure beyond eight.
void guard_device(HapticDevice& device);
void unguard_device(HapticDevice& device) noexcept;

/// Zero force to all guarded devices, and no force of this process after it, not even from a running servo thread. Any
/// thread or signal handler; also for set_check_handler().
void release_all_devices() noexcept;
bool forces_forbidden() noexcept;

}  // namespace typodont::haptics
