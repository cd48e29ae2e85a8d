// Recognises file names that do not name a regular file: devices, FIFOs and file descriptors that this process has
// open.
#pragma once

#include <filesystem>
#include <optional>

namespace typodont {

/// Returns the number of the file descriptor if `file` names an open descriptor of this process (/dev/stdout,
/// /proc/self/fd/1, /dev/fd/63); otherwise no value.
std::optional<int> own_descriptor(std::filesystem::path file);

/// Returns true if `file` is a character device, a FIFO or an open descriptor. Such a file is written to and never
/// replaced.
bool is_stream(const std::filesystem::path& file);

}  // namespace typodont
