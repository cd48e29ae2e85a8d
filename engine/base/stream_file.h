// Recognises names of devices, FIFOs and open descriptors of this process, which are not regular files.
#pragma once

#include <filesystem>
#include <optional>

namespace typodont {

/// Descriptor number in names such as /dev/stdout, /proc/self/fd/1 or /dev/fd/63; otherwise empty.
std::optional<int> own_descriptor(std::filesystem::path file);

/// True for a device, a FIFO or an open descriptor. These are written to, never replaced.
bool is_stream(const std::filesystem::path& file);

}  // namespace typodont
