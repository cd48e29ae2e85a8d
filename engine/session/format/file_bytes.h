// The bytes of a file that is opened once. HDF5 reads them through a driver of its own, so that the name of the file is
// used only to open it.
#pragma once

#include <hdf5.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace typodont::session {

/// Bytes that replace those of a file from an offset on.
struct Change {
  std::uint64_t place;  // bytes
  std::vector<std::byte> bytes;
};

/// Reads `size` bytes at the offset `place`. Bytes beyond the end of the file are zeros, as HDF5 expects.
bool read_all(int fd, void* out, std::uint64_t size, std::uint64_t place) noexcept;
/// Copies the parts of the changes that lie in [place, place + size) to `out`. Later changes replace earlier ones.
void overlay(std::span<const Change> changes, void* out, std::uint64_t size, std::uint64_t place) noexcept;

class FileBytes {
 public:
  /// Opens the file. Throws Error if it is not a readable regular file of the size of a session.
  explicit FileBytes(const std::filesystem::path& file);
  ~FileBytes();
  FileBytes(const FileBytes&) = delete;
  FileBytes& operator=(const FileBytes&) = delete;

  const std::filesystem::path& file() const { return file_; }
  int fd() const { return fd_; }
  /// Size of the file when it was opened, or of the bytes in memory.
  std::uint64_t size() const { return size_; }
  /// Reads the whole file to memory, once. Afterwards every reader gets these bytes. Throws Error.
  std::span<const std::byte> in_memory();
  /// Zeros beyond the end. Later changes of the file are visible until in_memory() was called.
  bool read(void* out, std::uint64_t size, std::uint64_t place) const noexcept;
  /// Readers see the file with these changes; the file itself does not change.
  void show_with(std::vector<Change> changes);
  /// Readers see a file of at least this length.
  void lengthen(std::uint64_t length) { shown_size_ = std::max(shown_size_, length); }
  /// Writes what readers see to the file `out`, which exists. Throws Error.
  void write_to(const std::filesystem::path& out) const;

  /// Makes HDF5 read these bytes if it opens a file with the property list `access` (H5P_FILE_ACCESS). The bytes must
  /// exist longer than the HDF5 file is open.
  bool use(hid_t access) const;

 private:
  friend struct BytesDriver;
  std::filesystem::path file_;
  int fd_ = -1;
  std::uint64_t size_ = 0, shown_size_ = 0;
  bool loaded_ = false;
  std::vector<std::byte> bytes_;
  std::vector<Change> changes_;
};

}  // namespace typodont::session
