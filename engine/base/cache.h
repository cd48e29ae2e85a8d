// Cache files in the user's cache folder: results that can be recomputed are kept between runs. A file may be damaged
// or deleted at any time. It is used only if its content is unchanged, bit for bit. No function throws: a result that
// cannot be cached is recomputed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "engine/base/fnv.h"

namespace typodont::cache {

/// The cache folder: $TYPODONT_CACHE, else typodont/ in $XDG_CACHE_HOME or ~/.cache. Empty path if none of these
/// variables is set.
std::filesystem::path folder();

/// Hash of a file's content; no value if the file cannot be read.
std::optional<std::uint64_t> hash_of(const std::filesystem::path& file);

/// Adds this build's identity to a key, because another build may compute another result from the same input.
void add_program(Fnv1a& key);

/// Returns the path of the cached file for this key after a check of its content, and removes a damaged file. Returns
/// an empty path if there is no valid file.
std::filesystem::path find(const std::filesystem::path& in, std::uint64_t key, const std::string& suffix);

/// Stores the file that `write` writes, completely or not at all. Then removes the files that were not used for the
/// longest time until the folder holds at most `most` bytes. Returns false if nothing was stored.
bool keep(const std::filesystem::path& in, std::uint64_t key, const std::string& suffix, std::uintmax_t most,
          const std::function<void(const std::filesystem::path&)>& write);

}  // namespace typodont::cache
