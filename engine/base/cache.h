// What can be made again, kept between runs so that it need not be: files in the user's cache folder, any of which may
// be damaged or gone at any time. None is used unless its content is what was kept, bit for bit. Never throws: what
// cannot be kept is made again.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "engine/base/fnv.h"

namespace typodont::cache {

/// $TYPODONT_CACHE, else typodont/ in $XDG_CACHE_HOME or ~/.cache. Empty: there is no place for one.
std::filesystem::path folder();

/// Of a file's content; nothing where it cannot be read.
std::optional<std::uint64_t> hash_of(const std::filesystem::path& file);

/// Says which program this is: another build may make another thing of the same input.
void add_program(Fnv1a& key);

/// The file kept for this key, its content checked; what is there instead, or damaged, is removed. Empty: there is
/// none.
std::filesystem::path find(const std::filesystem::path& in, std::uint64_t key, const std::string& suffix);

/// Keeps what `write` writes to the file it is given, whole or not at all, and removes those that were used longest ago
/// while all in the folder take more than `most` bytes. False where nothing is kept.
bool keep(const std::filesystem::path& in, std::uint64_t key, const std::string& suffix, std::uintmax_t most,
          const std::function<void(const std::filesystem::path&)>& write);

}  // namespace typodont::cache
