// Writes files completely or not at all, and never over a file that must be kept.
#pragma once

#include <atomic>
#include <filesystem>
#include <string_view>

#include "engine/base/file_kind.h"

namespace typodont {

/// Which existing files may be overwritten.
enum class Over {
  kNoInput,  // all files except inputs of this process (input_file.h)
  // all files, including inputs of this process; used by commands that change a file
  kItsInput
};

/// Writes a file: first a temporary file in the same folder, which keep() renames. Refuses to replace inputs, files of
/// another kind, write-protected files and directories.
/// Follows links to regular files; keep() copies into devices and FIFOs. Keeps mode and, where permitted, owner and
/// group. The temporary name is random and new (O_EXCL, O_NOFOLLOW). Any thread, one at a time.
class PartialFile {
 public:
  /// Checks the target and creates the temporary file. `part` distinguishes several temporary files of one target.
  /// Throws Error before any change.
  explicit PartialFile(std::filesystem::path file, FileKind kind = FileKind::kText, Over over = Over::kNoInput,
                       std::string_view part = {});
  /// Removes the temporary file if keep() was not called.
  ~PartialFile();
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;

  /// Path as the caller stated it.
  const std::filesystem::path& file() const noexcept { return file_; }
  /// Path of the temporary file, which is empty until the caller fills it.
  const std::filesystem::path& path() const noexcept { return path_; }
  /// False: the target is a device or a FIFO, into which keep() copies.
  bool makes_file() const noexcept { return stream_ < 0; }

  /// Writes the temporary file to disk and renames it, so that it survives a power cut. Throws Error.
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

/// Throws the Error that a PartialFile would throw; for a check before long work. Leaves no file.
void require_output(const std::filesystem::path& file, FileKind kind, Over over = Over::kNoInput);

/// Removes this process's temporary files when it ends. Signal-safe.
void remove_partial_files() noexcept;

}  // namespace typodont
