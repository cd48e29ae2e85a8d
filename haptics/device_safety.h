// Protects the hand from the motors: emergency stop, and zero force whenever the program ends for any reason. The
// limits of the force are in devices/safe_device.h.
#pragma once

#include <cstdint>
#include <string>

#include "haptics/haptic_device.h"

namespace typodont::haptics {

/// Begins the emergency stop of every guarded device. clear_emergency_all() ends the emergency stop. Both functions may
/// be called from any thread.
void emergency_stop_all() noexcept;
void clear_emergency_all() noexcept;

/// Returns SafetyEvent bits as text for reports, for example "watchdog, device fault".
std::string describe_safety(std::uint32_t events);

/// Makes sure that every arm gets zero force when the program ends: by exit, failed check, uncaught exception, fatal
/// signal or Ctrl-C. (After SIGKILL or a failure of the computer, only the device's own watchdog can do this.) Installs
/// once a function for atexit() and handlers for SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGSEGV, SIGBUS, SIGFPE, SIGILL and
/// SIGABRT. Each handler sends zero force to all guarded devices, then calls the handler that was installed before it.
/// A handler that the program installs later should call release_all_devices() first.
void install_exit_guard();

/// Adds a device to the guarded devices, which get zero force when the program ends. For any thread. Throws RunFailure
/// if there are already eight guarded devices.
void guard_device(HapticDevice& device);
void unguard_device(HapticDevice& device) noexcept;

/// Sends zero force to every guarded device, and blocks all later forces of this process. So a servo thread that still
/// runs has no effect on the devices. For any thread and any signal handler. May also be passed to set_check_handler(),
/// which is called after a failed check.
void release_all_devices() noexcept;
bool forces_forbidden() noexcept;

}  // namespace typodont::haptics
