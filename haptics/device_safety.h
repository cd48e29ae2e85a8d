// What keeps motors from hurting a hand, as far as the program takes part in it: the emergency key, and zero force
// however the program ends. The limits on every force are the device's own matter (devices/safe_device.h).
#pragma once

#include <cstdint>
#include <string>

#include "haptics/haptic_device.h"

namespace typodont::haptics {

/// The emergency key, for every guarded hand. Any thread.
void emergency_stop_all() noexcept;
void clear_emergency_all() noexcept;

/// SafetyEvent bits in words, for reports: "watchdog, device fault".
std::string describe_safety(std::uint32_t events);

/// However the program ends, every arm gets zero force: exit, failed check, uncaught exception, fatal signal, Ctrl-C.
/// Only SIGKILL and a dead computer are left to the device's own watchdog.
/// Installs atexit() and handlers of SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, once.
/// Each sends zero to all guarded devices, then does what was installed before it. Handlers that others install later
/// should call release_all_devices() first.
void install_exit_guard();

/// Set-up time, any thread. At most eight; throws RunFailure beyond.
void guard_device(HapticDevice& device);
void unguard_device(HapticDevice& device) noexcept;

/// The end: zero force on every guarded device, and none ever again in this process, so that a servo thread that lives
/// a little longer changes nothing. Any thread, any signal handler, and the right thing for set_check_handler().
void release_all_devices() noexcept;
bool forces_forbidden() noexcept;

}  // namespace typodont::haptics
