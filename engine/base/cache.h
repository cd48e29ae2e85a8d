// Stores results in the user's cache folder for later runs. A file is used only if its hash is correct, because it may
// be damaged. Nothing throws: without a cached file, the result is computed again.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "engine/base/sha256.h"

namespace typodont::cache {

/// The cache folder: $TYPODONT_CACHE, else typodont/ in $XDG_CACHE_HOME or ~/.cache. Empty without these variables.
std::filesystem::path folder();
/// The subfolder `name` of the cache folder. Empty if there is no cache folder.
std::filesystem::path folder(const std::string& name);

/// Sha256::key() of the file's content. Empty: the file can't be read.
std::optional<std::uint64_t> hash_of(const std::filesystem::path& file);

/// Adds build_identity() to the key, because a different build may compute a different result.
void add_build(Sha256& key);

/// Adds path, size and time of change of the file to the key; much faster than hash_of(). False: no such file.
bool add_file(Sha256& key, const std::filesystem::path& file);

/// The undamaged file with this key. Empty: there is none, or `in` is empty. Deletes a damaged file.
std::filesystem::path find(const std::filesystem::path& in, std::uint64_t key, const std::string& suffix);

/// Calls `write` and stores its file completely or not at all. While the folder has more than `most` bytes, deletes the
/// least recently used files, but keeps one. False: nothing was stored, for example because `in` is empty.
bool keep(const std::filesystem::path& in, std::uint64_t key, const std::string& suffix, std::uintmax_t most,
          const std::function<void(const std::filesystem::path&)>& write);

}  // namespace typodont::cache
