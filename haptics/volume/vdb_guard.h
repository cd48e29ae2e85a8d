// OpenVDB trusts its files: a damaged length costs gigabytes, a damaged tree the heap. Files are looked over first.
#pragma once

#include <filesystem>
#include <functional>

namespace typodont::haptics {

/// Appends a seal to a finished .vdb file: eight letters and the FNV-1a of all bytes before. OpenVDB, which finds its
/// grids by position, never sees it. Throws Error when the file cannot be written.
void seal_vdb(const std::filesystem::path& file);

/// Throws Error unless OpenVDB can be trusted with the file: its seal is unbroken; or, for a file from elsewhere, which
/// has none, every stated length lies within the file and `read` survives it in a process of its own.
void check_vdb(const std::filesystem::path& file, const std::function<void()>& read);

}  // namespace typodont::haptics
