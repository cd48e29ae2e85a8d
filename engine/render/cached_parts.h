// Writes values to a cached file (engine/base/cache.h), and reads them from it in the same order.
#pragma once

#include <filesystem>
#include <fstream>

#include "engine/base/error.h"

namespace typodont::render {

/// Writes values to a file. `each_part(use)` calls use(address, size in bytes) for the memory of each value, until a
/// call returns false; it returns false if a call did. Throws Error.
template <class EachPart>
void write_parts(const std::filesystem::path& file, EachPart&& each_part) {
  std::ofstream out(file, std::ios::binary);
  const auto put = [&](const auto* data, std::size_t bytes) {
    return static_cast<bool>(out.write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(bytes)));
  };
  if (!each_part(put) || !out.flush()) throw Error(file.string(), "", "not written", "a writable place");
}

/// Reads the values that write_parts() has written. Returns false if `file` is empty, or if a value cannot be read. The
/// cache has checked the file's content.
template <class EachPart>
bool read_parts(const std::filesystem::path& file, EachPart&& each_part) {
  if (file.empty()) return false;
  std::ifstream in(file, std::ios::binary);
  return each_part([&](auto* data, std::size_t bytes) {
    return static_cast<bool>(in.read(reinterpret_cast<char*>(data), static_cast<std::streamsize>(bytes)));
  });
}

}  // namespace typodont::render
