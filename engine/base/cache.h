// Results in the user's cache folder for later runs. Files may be damaged or deleted at any time, so one is used only
// if its hash fits. Nothing throws; what cannot be stored is computed again.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "engine/base/sha256.h"

namespace typodont::cache {

/// $TYPODONT_CACHE, else typodont/ in $XDG_CACHE_HOME or ~/.cache; empty without these variables.
std::filesystem::path folder();
/// `name` in the cache folder; empty without one.
std::filesystem::path folder(const std::string& name);

/// Sha256::key() of the content; empty if unreadable.
std::optional<std::uint64_t> hash_of(const std::filesystem::path& file);

/// Other sources (build_identity.h) may compute another result.
void add_build(Sha256& key);

/// Path, size and time of change, much faster than a large file's hash. False: no such file.
bool add_file(Sha256& key, const std::filesystem::path& file);

/// The checked file of this key; empty without one, or if `in` is empty. Removes a damaged one.
std::filesystem::path find(const std::filesystem::path& in, std::uint64_t key, const std::string& suffix);

/// Stores what `write` writes, completely or not at all. Then removes the least recently used beyond `most` bytes, but
/// keeps one. False: nothing stored, also if `in` is empty.
bool keep(const std::filesystem::path& in, std::uint64_t key, const std::string& suffix, std::uintmax_t most,
          const std::function<void(const std::filesystem::path&)>& write);

}  // namespace typodont::cache
