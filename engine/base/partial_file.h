// Writes a file completely or not at all, and never replaces a file that must be kept.
#pragma once

#include <atomic>
#include <filesystem>
#include <string_view>

#include "engine/base/file_kind.h"

namespace typodont {

/// States which existing files may be overwritten.
enum class Over {
  kNoInput,  // any file except an input of this process (input_file.h)
  // any file, even one that this process has read; for commands that read a file, change its content and write it back
  kItsInput
};

/// Writes one file. All files of this program are written through this class. The content goes to a temporary file in
/// the same folder, which is renamed when it is complete. The class refuses to replace a file that this process has
/// read, a file of another kind, a write-protected file and a directory. A link to a regular file is followed. The file
/// keeps its mode and, as far as permitted, its owner and group. A device or FIFO is never replaced; the content is
/// copied into it. The temporary name is unpredictable and always new (O_EXCL, O_NOFOLLOW). The constructor first
/// removes temporary files of killed processes. Any thread may use an object, but only one thread at a time.
class PartialFile {
 public:
  /// Prepares to write `file`. `part` distinguishes several temporary files for one target. Throws Error, before
  /// anything is changed, if the file may not be written.
  explicit PartialFile(std::filesystem::path file, FileKind kind = FileKind::kText, Over over = Over::kNoInput,
                       std::string_view part = {});
  /// Removes the temporary file unless keep() was called.
  ~PartialFile();
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;

  /// Returns the path of the file as the caller stated it.
  const std::filesystem::path& file() const noexcept { return file_; }
  /// Returns the path of the temporary file, which exists and is empty. The caller writes the content into this file.
  const std::filesystem::path& path() const noexcept { return path_; }
  /// Returns false if `file` is a device or FIFO. Then keep() copies the content into it instead of renaming the
  /// temporary file.
  bool makes_file() const noexcept { return stream_ < 0; }

  /// Syncs the temporary file to the disk and renames it to `file`, so that the content survives a power cut. Throws
  /// Error on failure.
  void keep();

 private:
  void check_target();
  void take_over_owner(int fd) const;
  void copy_into_stream();
  void forget() noexcept;

  std::filesystem::path file_, path_;
  std::filesystem::path target_;  // path of `file` with links resolved
  FileKind kind_;
  Over over_;
  int stream_ = -1;  // descriptor of a device or FIFO
  std::atomic<const char*>* listed_ = nullptr;
};

/// Throws the Error that a PartialFile with these arguments would throw. Commands call this function before long work,
/// so that the user gets the message early. It leaves no file.
void require_output(const std::filesystem::path& file, FileKind kind, Over over = Over::kNoInput);

/// Removes all partially written files of this process. Call when the process ends. Signal handlers may call this
/// function.
void remove_partial_files() noexcept;

}  // namespace typodont
