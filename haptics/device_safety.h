// Emergency stop, and zero force whenever the program ends. Force limits are in devices/safe_device.h.
#pragma once

#include <cstdint>
#include <string>

#include "haptics/haptic_device.h"

namespace typodont::haptics {

/// Emergency stop: all sessions of this process give no force and stop the drill from the next tick on, and all devices
/// get zero force. After it is switched off, the force of a hand returns once its tool touches nothing. Any thread.
void set_emergency_stop(bool on) noexcept;
bool emergency_stopped() noexcept;

/// Names of the SafetyEvent bits for messages, for example "watchdog, device fault".
std::string describe_safety(std::uint32_t events);

/// Sends zero force at exit, failed check, uncaught exception, fatal signal or Ctrl-C. Its signal handlers then call
/// the earlier handlers; handlers installed later should first call release_all_devices(). After SIGKILL, only the
/// watchdog process of some drivers (watchdog_process.h) and the device's own watchdog help.
void install_exit_guard();

/// Adds a device that gets zero force when the program ends. Any thread. Throws RunFailure for more than eight devices.
void guard_device(HapticDevice& device);
void unguard_device(HapticDevice& device) noexcept;

/// Sends zero force to all guarded devices, and blocks all later forces of this process, also of a running servo
/// thread. Any thread or signal handler; also suitable for set_check_handler().
void release_all_devices() noexcept;
bool forces_forbidden() noexcept;

}  // namespace typodont::haptics
