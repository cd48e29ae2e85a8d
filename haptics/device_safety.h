// Protects the hand from the motors: emergency stop, and zero force whenever the program ends for any reason. The
// limits of the force are in devices/safe_device.h.
#pragma once

#include <cstdint>
#include <string>

#include "haptics/haptic_device.h"

namespace typodont::haptics {

/// Sets, or clears, the emergency stop of every guarded device. Any thread may call these functions.
void emergency_stop_all() noexcept;
void clear_emergency_all() noexcept;

/// Returns SafetyEvent bits as text for reports, for example "watchdog, device fault".
std::string describe_safety(std::uint32_t events);

/// Makes sure that every arm gets zero force when the program ends: exit, failed check, uncaught exception, fatal
/// signal, Ctrl-C. After SIGKILL or a failure of the computer, only the device's own watchdog can act. Installs
/// atexit() and handlers for SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGSEGV, SIGBUS, SIGFPE, SIGILL and SIGABRT, once. Each
/// handler sends zero force to all guarded devices and then calls the previous handler. A handler that is installed
/// later should call release_all_devices() first.
void install_exit_guard();

/// Adds a device to the guarded devices. Any thread may call it. Throws RunFailure if there are already eight.
void guard_device(HapticDevice& device);
void unguard_device(HapticDevice& device) noexcept;

/// Sends zero force to every guarded device and permits no further force in this process. So a servo thread that is
/// still running has no effect. May be called from any thread and any signal handler, and may be passed to
/// set_check_handler() (called if a check fails).
void release_all_devices() noexcept;
bool forces_forbidden() noexcept;

}  // namespace typodont::haptics
