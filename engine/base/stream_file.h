// Names that lead to no file of their own: devices, FIFOs and what this process has open already.
#pragma once

#include <filesystem>
#include <optional>

namespace typodont {

/// Where `file` leads to an open descriptor of this process (/dev/stdout, /proc/self/fd/1, /dev/fd/63): its number.
std::optional<int> own_descriptor(std::filesystem::path file);

/// A character device, a FIFO or an open descriptor: it is written to and never replaced.
bool is_stream(const std::filesystem::path& file);

}  // namespace typodont
