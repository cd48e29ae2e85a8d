// Helpers for all functions of the C interface: they lock the handle, catch exceptions, and store the reason of a
// failure.
#pragma once

#include <concepts>
#include <cstddef>
#include <memory>
#include <mutex>
#include <new>
#include <string>

#include "engine/base/error.h"
#include "engine/base/pose.h"
#include "engine/bindings/c/handles.h"
#include "engine/bindings/c/typodont.h"
#include "engine/contract/contact.h"

namespace typodont::bindings {

// The objects to which handles refer.
struct SceneObject;
struct HandObject;
struct CoreObject;
struct ServoObject;
struct SessionObject;
struct SynthObject;

template <class Handle>
struct ObjectOf;
// clang-format off
template <> struct ObjectOf<typodont_scene> { using Type = SceneObject; static constexpr Kind kKind = Kind::kScene; };
template <> struct ObjectOf<typodont_hand> { using Type = HandObject; static constexpr Kind kKind = Kind::kHand; };
template <> struct ObjectOf<typodont_core> { using Type = CoreObject; static constexpr Kind kKind = Kind::kCore; };
template <> struct ObjectOf<typodont_servo> { using Type = ServoObject; static constexpr Kind kKind = Kind::kServo; };
template <> struct ObjectOf<typodont_session> { using Type = SessionObject; static constexpr Kind kKind = Kind::kSession; };
// clang-format on

/// Stores the address of a text, which typodont_error() then returns, so the text must exist until the program ends.
/// Returns `result`. Real-time safe.
typodont_result fail(typodont_result result, const char* literal) noexcept;
/// Like fail(), but stores a copy of the text. Allocates.
typodont_result fail_with_copy(typodont_result result, const char* text) noexcept;
/// To be called in a catch block: stores the exception's text, and returns its result code. Allocates.
typodont_result fail_by_exception() noexcept;

/// Runs `body`, which returns a result code or nothing, and converts exceptions to result codes.
template <class Body>
typodont_result guarded(Body&& body) noexcept {
  try {
    if constexpr (std::same_as<decltype(body()), void>) {
      body();
      return TYPODONT_OK;
    } else {
      return body();
    }
  } catch (...) {
    return fail_by_exception();
  }
}

/// Locks a handle for this thread until the end of the scope, and gives access to its object.
template <class Handle>
class HandleLock {
 public:
  using Object = typename ObjectOf<Handle>::Type;
  explicit HandleLock(const Handle* handle) noexcept : taken_(handle, ObjectOf<Handle>::kKind), handle_(handle) {}

  explicit operator bool() const noexcept { return taken_.found() == Found::kHeld; }
  Object& operator*() const noexcept { return *static_cast<Object*>(taken_.object()); }
  Object* operator->() const noexcept { return static_cast<Object*>(taken_.object()); }
  /// Makes the handle invalid and returns its object.
  std::unique_ptr<Object> drop() noexcept { return std::unique_ptr<Object>(static_cast<Object*>(taken_.drop())); }
  typodont_result why() const noexcept {
    return taken_.found() == Found::kBusy
               ? fail(TYPODONT_BUSY, "another thread is using this handle")
               : fail(TYPODONT_BAD_HANDLE,
                      handle_ ? "a handle that was freed, or is of another kind" : "NULL as a handle");
  }

 private:
  HeldHandle taken_;
  const Handle* handle_;
};

/// Locks the handle and calls `body` with its object.
template <class Handle, class Body>
typodont_result with(Handle* handle, Body&& body) noexcept {
  const HandleLock<Handle> held(handle);
  if (!held) return held.why();
  return guarded([&] { return body(*held); });
}

/// Creates a handle for an object. Throws std::bad_alloc if the table of handles is full.
template <class Handle>
Handle* make_handle(std::unique_ptr<typename ObjectOf<Handle>::Type> object) {
  void* const handle = new_handle(ObjectOf<Handle>::kKind, object.get());
  if (!handle) throw std::bad_alloc();
  (void)object.release();
  return static_cast<Handle*>(handle);
}

template <class Handle>
typodont_result free_handle(Handle* handle) noexcept {
  if (!handle) return TYPODONT_OK;
  HandleLock<Handle> held(handle);
  if (!held) return held.why();
  return guarded([&] { held.drop().reset(); });
}

/// A lock that allows only one thread at a time to use HDF5.
class SessionFiles {
 public:
  SessionFiles() : lock_(mutex()) {}

 private:
  static std::recursive_mutex& mutex();
  std::lock_guard<std::recursive_mutex> lock_;
};

/// Throws an Error with `text` if `holds` is false.
inline void require(bool holds, const char* text) {
  if (!holds) throw Error(text);
}

// Upper limit for the size of any struct of the C interface, also in later versions, bytes.
constexpr std::uint32_t kMaxStruct = 4096;
/// True if a struct of the host has an allowed size; the host may use another version. `first`: size in the first
/// release.
constexpr bool sized(std::uint32_t struct_size, std::size_t first) {
  return struct_size >= first && struct_size <= kMaxStruct && struct_size % 8 == 0;
}
constexpr const char* kBadSize = "struct_size is not that of the struct";

/// Element i of an array of structs. `stride`: bytes between the beginnings of two elements.
template <class T>
T& element(T* array, std::size_t i, std::uint32_t stride) {
  using Byte = std::conditional_t<std::is_const_v<T>, const char, char>;
  return *reinterpret_cast<T*>(reinterpret_cast<Byte*>(array) + i * stride);
}

inline dvec3 to_vec(const double* v) {
  return {v[0], v[1], v[2]};
}
inline void put(const dvec3& from, double* to) {
  to[0] = from.x, to[1] = from.y, to[2] = from.z;
}
inline Pose to_pose(const typodont_pose& X) {
  return {to_vec(X.p), dquat(X.q[0], X.q[1], X.q[2], X.q[3])};
}
inline void put(const Pose& X, typodont_pose& out) {
  put(X.p, out.p);
  out.q[0] = X.R.w, out.q[1] = X.R.x, out.q[2] = X.R.y, out.q[3] = X.R.z;
}
static_assert(kTissueCount <= TYPODONT_TISSUES);
inline void put(const PerTissue& from, double* to) {
  for (std::size_t i = 0; i < TYPODONT_TISSUES; ++i) to[i] = i < from.size() ? from[i] : 0;
}
/// Copies all members of a tick except struct_size, which the host sets.
void put(const ServoTick& from, typodont_tick& out) noexcept;
void put(const Cut& from, typodont_cut& out) noexcept;

}  // namespace typodont::bindings
