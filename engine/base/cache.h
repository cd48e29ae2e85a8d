// Stores results in files in the user's cache folder, so that later runs of the program need not compute them again. A
// cache file may be damaged or deleted at any time. So a file is used only if its hash proves that its content is
// unchanged. No function throws. If a result cannot be stored, the next run computes it again.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "engine/base/fnv.h"

namespace typodont::cache {

/// Returns the path of the cache folder: $TYPODONT_CACHE if this variable is set, else the folder typodont/ in
/// $XDG_CACHE_HOME or in ~/.cache. The path is empty if none of these variables is set.
std::filesystem::path folder();
/// Returns the path of the folder `name` in the cache folder. The path is empty if there is no cache folder.
std::filesystem::path folder(const std::string& name);

/// Returns the hash of a file's content; no value if the file cannot be read.
std::optional<std::uint64_t> hash_of(const std::filesystem::path& file);

/// Adds the hash of the program's sources (build_identity.h) to a key, because other sources may compute another result
/// from the same input.
void add_build(Fnv1a& key);

/// Adds the path, the size and the time of the last change of a file to a key. This is much faster than the hash of a
/// large file's content. Returns false if there is no such file.
bool add_file(Fnv1a& key, const std::filesystem::path& file);

/// Returns the path of the cached file for this key, or an empty path if there is no valid file or `in` is empty. The
/// content of the file is checked, and a damaged file is removed.
std::filesystem::path find(const std::filesystem::path& in, std::uint64_t key, const std::string& suffix);

/// Stores the file that `write` writes, completely or not at all. Then removes the least recently used files until all
/// files together have at most `most` bytes, or until only one file is left. Returns false if nothing was stored, also
/// if `in` is empty.
bool keep(const std::filesystem::path& in, std::uint64_t key, const std::string& suffix, std::uintmax_t most,
          const std::function<void(const std::filesystem::path&)>& write);

}  // namespace typodont::cache
