// Shared libraries that are loaded when one of their functions is first used, so that a session loads only what it
// uses.
//
//   constinit LateLibrary sndfile{TYPODONT_SNDFILE};                // file and package, from typodont_late() in CMake
//   TYPODONT_LATE(sndfile, sf_open, sf_close)
//
// In this namespace, `sf_open(…)` now calls the function of the loaded library. The list may contain variables, too.
#pragma once

#include <atomic>
#include <mutex>
#include <string>
#include <vector>

namespace typodont {

class LateSymbol;

class LateLibrary {
 public:
  /// `file`: name for dlopen(). `package`: Debian's package with this file. `find`: returns the file's path if dlopen()
  /// cannot find it by its name.
  constexpr LateLibrary(const char* file, const char* package, std::string (*find)() = nullptr)
      : file_(file), package_(package), find_(find) {}
  LateLibrary(const LateLibrary&) = delete;
  LateLibrary& operator=(const LateLibrary&) = delete;

  /// Loads the library and finds all its declared functions, unless this was done before. The library stays loaded.
  /// Throws Error if it, or one of the functions, is missing. Any thread; not in real-time loops.
  void load();
  const char* file() const { return file_; }
  const char* package() const { return package_; }

  /// All libraries of this program that have declared functions, loaded or not.
  static std::vector<LateLibrary*> all();

 private:
  friend class LateSymbol;
  const char *file_, *package_;
  std::string (*find_)();
  std::mutex loading_;
  LateSymbol* symbols_ = nullptr;  // declared functions, the newest first
  LateLibrary* next_ = nullptr;    // next of all libraries
};

/// A function or variable of a late library.
class LateSymbol {
 public:
  LateSymbol(LateLibrary& library, const char* name);
  LateSymbol(const LateSymbol&) = delete;
  LateSymbol& operator=(const LateSymbol&) = delete;

 protected:
  void* address() const {
    void* const found = address_.load(std::memory_order_acquire);
    return found ? found : load();
  }

 private:
  friend class LateLibrary;
  void* load() const;
  LateLibrary& library_;
  const char* name_;
  LateSymbol* next_;
  std::atomic<void*> address_{nullptr};
};

/// Converts to the function or variable of type T. `late(a, b)` calls the function.
template <class T>
class Late : public LateSymbol {
 public:
  using LateSymbol::LateSymbol;
  operator T&() const { return *reinterpret_cast<T*>(address()); }  // NOLINT(google-explicit-constructor)
};

}  // namespace typodont

// Declares functions of a library under their own names. They hide the functions of the library's header.
#define TYPODONT_LATE(library, ...) TYPODONT_LATE_64(TYPODONT_LATE_EACH(library, __VA_ARGS__))
// Expands the list once more for each name: at least 64 names are possible.
#define TYPODONT_LATE_64(...) TYPODONT_LATE_16(TYPODONT_LATE_16(TYPODONT_LATE_16(TYPODONT_LATE_16(__VA_ARGS__))))
#define TYPODONT_LATE_16(...) TYPODONT_LATE_4(TYPODONT_LATE_4(TYPODONT_LATE_4(TYPODONT_LATE_4(__VA_ARGS__))))
#define TYPODONT_LATE_4(...) TYPODONT_LATE_1(TYPODONT_LATE_1(TYPODONT_LATE_1(TYPODONT_LATE_1(__VA_ARGS__))))
#define TYPODONT_LATE_1(...) __VA_ARGS__
#define TYPODONT_LATE_EACH(library, name, ...)                          \
  inline const ::typodont::Late<decltype(::name)> name{library, #name}; \
  __VA_OPT__(TYPODONT_LATE_AGAIN TYPODONT_LATE_NONE(library, __VA_ARGS__))
#define TYPODONT_LATE_NONE ()
#define TYPODONT_LATE_AGAIN() TYPODONT_LATE_EACH
