// Keeps computed results in the cache (cache.h). One function describes the parts of a result, for writing and reading.
#pragma once

#include <algorithm>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <type_traits>
#include <vector>

#include "engine/base/cache.h"
#include "engine/base/clock.h"

namespace typodont::cache {

/// The values of a result, in the order of the calls. Writes them, or reads what the same calls wrote. Each function
/// returns false if a value cannot be written or read.
class Parts {
 public:
  /// `compressed`: for results in which most values are equal; has no effect on reading.
  static Parts writer(const std::filesystem::path& file, bool compressed);
  static Parts reader(const std::filesystem::path& file);

  template <class T>
  bool value(T& x) {
    static_assert(std::is_trivially_copyable_v<T>);
    return bytes(&x, sizeof x);
  }
  template <class T>
  bool values(std::vector<T>& all) {
    static_assert(std::is_trivially_copyable_v<T>);
    return resize(all) && bytes(all.data(), all.size() * sizeof(T));
  }
  template <class T>
  bool optional(std::optional<T>& maybe) {
    bool there = maybe.has_value();
    if (!value(there)) return false;
    if (there && !maybe) maybe.emplace();
    if (!there) maybe.reset();
    return !there || value(*maybe);
  }
  /// `each(element)`: writes or reads one element.
  template <class T, class Each>
  bool list(std::vector<T>& all, const Each& each) {
    return resize(all) && std::ranges::all_of(all, each);
  }
  /// False: not all of it could be written.
  bool close();

 private:
  Parts(const std::filesystem::path& file, const char* mode);
  bool bytes(void* data, std::size_t size);
  template <class T>
  bool resize(std::vector<T>& all) {
    std::size_t count = all.size();
    if (!value(count) || (reads_ && count > most_)) return false;
    all.resize(count);
    return true;
  }

  std::shared_ptr<void> file_;
  bool reads_;
  std::size_t most_ = 0;  // no list of the file has more elements
};

/// The cache of one kind of results.
struct Shelf {
  const char* folder;
  const char* suffix;   // of the files
  std::uintmax_t most;  // bytes, largest total size of the files
  Nanos worth = 0;      // results that are computed in less time are not stored
  bool compressed = false;
};

/// Reads the result with this key. `parts`: reads or writes all parts of the result; false: it could not. Without a
/// key, or without a complete file, calls `make`, which must compute all parts, and stores them.
void read_or_make(const Shelf& shelf, std::optional<std::uint64_t> key, const std::function<bool(Parts&)>& parts,
                  const std::function<void()>& make);

}  // namespace typodont::cache
