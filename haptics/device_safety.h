// Protects the hand from the motors: emergency key, and zero force however the program ends. The limits of each force
// are in devices/safe_device.h.
#pragma once

#include <cstdint>
#include <string>

#include "haptics/haptic_device.h"

namespace typodont::haptics {

/// Sets and clears the emergency stop of every guarded device. Any thread.
void emergency_stop_all() noexcept;
void clear_emergency_all() noexcept;

/// SafetyEvent bits in words, for reports: "watchdog, device fault".
std::string describe_safety(std::uint32_t events);

/// Sends zero force to every arm however the program ends: exit, failed check, uncaught exception, fatal signal,
/// Ctrl-C. Only after SIGKILL or a dead computer must the device's own watchdog act.
/// Installs atexit() and handlers of SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, once.
/// Each handler sends zero to all guarded devices, then calls the previous handler. Handlers that are installed later
/// should call release_all_devices() first.
void install_exit_guard();

/// Adds a device to the guarded devices. Set-up time, any thread. Throws RunFailure for more than eight.
void guard_device(HapticDevice& device);
void unguard_device(HapticDevice& device) noexcept;

/// Sends zero force to every guarded device and forbids any further force in this process, so that a servo thread that
/// still runs has no effect. Any thread, any signal handler; also suitable for set_check_handler().
void release_all_devices() noexcept;
bool forces_forbidden() noexcept;

}  // namespace typodont::haptics
