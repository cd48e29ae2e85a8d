// Writes and reads the values of a cached file (engine/base/cache.h), both in the same order.
#pragma once

#include <filesystem>
#include <fstream>

#include "engine/base/error.h"

namespace typodont::render {

/// Writes values to a file. `each_part(use)` calls use(address, bytes) for each value; if a
/// use() returns false, each_part() must stop and return false. Throws Error.
template <class EachPart>
void write_parts(const std::filesystem::path& file, EachPart&& each_part) {
  std::ofstream out(file, std::ios::binary);
  const auto put = [&](const auto* data, std::size_t bytes) {
    return static_cast<bool>(out.write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(bytes)));
  };
  if (!each_part(put) || !out.flush()) throw Error(file.string(), "", "not written", "a writable place");
}

/// Reads what write_parts() wrote. Returns false if `file` is empty, or a value cannot be read. The cache has already
/// checked the content.
template <class EachPart>
bool read_parts(const std::filesystem::path& file, EachPart&& each_part) {
  if (file.empty()) return false;
  std::ifstream in(file, std::ios::binary);
  return each_part([&](auto* data, std::size_t bytes) {
    return static_cast<bool>(in.read(reinterpret_cast<char*>(data), static_cast<std::streamsize>(bytes)));
  });
}

}  // namespace typodont::render
