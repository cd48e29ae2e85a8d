// However the program ends, every arm gets zero force: exit, failed check, uncaught exception, fatal signal, Ctrl-C.
// Only SIGKILL and a dead computer are left to the device's own watchdog.
#pragma once

#include "haptics/haptic_device.h"

namespace typodont::haptics {

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
