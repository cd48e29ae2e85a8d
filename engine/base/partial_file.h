// Writes a file completely or not at all, and never replaces a file that must be kept.
#pragma once

#include <atomic>
#include <filesystem>
#include <string_view>

#include "engine/base/file_kind.h"

namespace typodont {

/// The existing files that may be overwritten.
enum class Over {
  kNoInput,  // all existing files except an input of this process (input_file.h)
  // all files except inputs are allowed, and also inputs of this process: the command reads the file, changes it and
  // writes it back
  kItsInput
};

/// Every file that this program writes is written through this class. The content goes to a temporary file in the
/// same folder, which is renamed when it is complete. The class refuses to replace a file that this process has read,
/// a file of another kind, a write-protected file and a directory. A link to a regular file is followed; the file
/// keeps its mode and, as far as permitted, its owner and group. A device or FIFO is never replaced: the content is
/// copied into it. The temporary name is unpredictable and always new (O_EXCL, O_NOFOLLOW). The constructor first
/// removes temporary files of killed processes. Any thread may use an object, but only one thread at a time.
class PartialFile {
 public:
  /// `part` distinguishes several temporary files for one target. Throws Error, before anything is changed, if the file
  /// may not be written.
  explicit PartialFile(std::filesystem::path file, FileKind kind = FileKind::kText, Over over = Over::kNoInput,
                       std::string_view part = {});
  /// Removes the temporary file unless keep() was called.
  ~PartialFile();
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;

  /// The target as the caller named it.
  const std::filesystem::path& file() const noexcept { return file_; }
  /// The temporary file to write; it exists and is empty.
  const std::filesystem::path& path() const noexcept { return path_; }
  /// False if `file` is a device or FIFO; keep() then copies the content into it.
  bool makes_file() const noexcept { return stream_ < 0; }

  /// Syncs the temporary file and renames it to `file`, so that the content survives a power cut. Throws Error on
  /// failure.
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

/// Throws Error if a PartialFile with these arguments would throw. So the user gets the message before long work.
/// Leaves no file.
void require_output(const std::filesystem::path& file, FileKind kind, Over over = Over::kNoInput);

/// Removes all partially written files of this process. Call when the process ends. Safe in signal handlers.
void remove_partial_files() noexcept;

}  // namespace typodont
