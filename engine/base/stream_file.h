// Names that are no regular file: devices, FIFOs, open descriptors of this process.
#pragma once

#include <filesystem>
#include <optional>

namespace typodont {

/// For /dev/stdout, /proc/self/fd/1, /dev/fd/63; otherwise empty.
std::optional<int> own_descriptor(std::filesystem::path file);

/// Device, FIFO or open descriptor: written to, never replaced.
bool is_stream(const std::filesystem::path& file);

}  // namespace typodont
