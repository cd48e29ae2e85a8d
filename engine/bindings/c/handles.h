// The handles of the C interface: numbers in the guise of pointers. A table knows which of them live; a handle is never
// dereferenced, so that one that was freed, forged or mixed up is an error and not a crash.
#pragma once

#include <cstdint>

namespace typodont::bindings {

enum class Kind : std::uint8_t { kScene = 1, kHand, kCore, kServo, kSession, kSynth };

enum class Found { kHeld, kBadHandle, kBusy };

/// Any thread; noexcept; never allocates: the handle's object for this thread alone, until put_back().
Found take(const void* handle, Kind kind, void*& object) noexcept;
void put_back(const void* handle) noexcept;

/// Any thread, set-up. Null where 4096 handles live.
void* new_handle(Kind kind, void* object);
/// Of a handle that was taken: from now on it is a bad one.
void drop(const void* handle) noexcept;

}  // namespace typodont::bindings
