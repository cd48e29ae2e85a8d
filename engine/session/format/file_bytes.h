// The bytes of a file that is opened only once. HDF5 reads them through this program's own driver, so the file's name
// is not used again.
#pragma once

#include <hdf5.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace typodont::session {

/// New bytes for a part of a file.
struct Change {
  std::uint64_t place;  // offset in the file, bytes
  std::vector<std::byte> bytes;
};

/// Reads `size` bytes at the offset `place`. Bytes beyond the end of the file are zeros, as HDF5 expects.
bool read_all(int fd, void* out, std::uint64_t size, std::uint64_t place) noexcept;
/// Copies the parts of the changes that are in [place, place + size) to `out`. Later changes replace earlier ones.
void overlay(std::span<const Change> changes, void* out, std::uint64_t size, std::uint64_t place) noexcept;

class FileBytes {
 public:
  /// Opens the file. Throws Error unless it is a readable regular file of at most the size allowed for sessions.
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
  /// Reads bytes; beyond the end of the file they are zeros. Changes of the file remain visible until in_memory() was
  /// called.
  bool read(void* out, std::uint64_t size, std::uint64_t place) const noexcept;
  /// From now on, readers see the file with these changes; the file itself does not change.
  void show_with(std::vector<Change> changes);
  /// From now on, readers see at least this length.
  void lengthen(std::uint64_t length) { shown_size_ = std::max(shown_size_, length); }
  /// Overwrites the file `out` with the bytes that read() returns: this file's bytes with all changes. Throws Error.
  void write_to(const std::filesystem::path& out) const;

  /// Makes HDF5 read these bytes if it opens a file with the property list `access` (H5P_FILE_ACCESS). This object must
  /// outlive the open HDF5 file.
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
