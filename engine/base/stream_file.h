// Recognises file names that are not regular files: devices, FIFOs and descriptors that this process has open.
#pragma once

#include <filesystem>
#include <optional>

namespace typodont {

/// Number of the descriptor if `file` leads to an open descriptor of this process (/dev/stdout, /proc/self/fd/1,
/// /dev/fd/63).
std::optional<int> own_descriptor(std::filesystem::path file);

/// True for a character device, a FIFO or an open descriptor, which are written to and never replaced.
bool is_stream(const std::filesystem::path& file);

}  // namespace typodont
