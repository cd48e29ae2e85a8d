// Files that are written completely or not at all, and never over one to keep.
#pragma once

#include <atomic>
#include <filesystem>
#include <string_view>

#include "engine/base/file_kind.h"

namespace typodont {

/// Which existing files may be overwritten.
enum class Over {
  kNoInput,  // all but inputs of this process (input_file.h)
  // also inputs: for commands that change a file
  kItsInput
};

/// All files are written through this: a temporary file in the same folder, renamed when complete. Refuses inputs,
/// other kinds, write-protected files and directories; follows links to regular files; keeps mode and, where permitted,
/// owner and group. Devices and FIFOs are copied into. The temporary name is unpredictable and new (O_EXCL,
/// O_NOFOLLOW); those of killed processes go first. Any thread, one at a time.
class PartialFile {
 public:
  /// `part`: for several temporary files of one target. Throws Error before any change.
  explicit PartialFile(std::filesystem::path file, FileKind kind = FileKind::kText, Over over = Over::kNoInput,
                       std::string_view part = {});
  /// Removes the temporary file without keep().
  ~PartialFile();
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;

  /// As stated by the caller.
  const std::filesystem::path& file() const noexcept { return file_; }
  /// The temporary file, empty, to be filled.
  const std::filesystem::path& path() const noexcept { return path_; }
  /// False: device or FIFO, which keep() copies into.
  bool makes_file() const noexcept { return stream_ < 0; }

  /// Synced, then renamed, so that it survives a power cut. Throws Error.
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

/// Throws what a PartialFile would, before long work. Leaves no file.
void require_output(const std::filesystem::path& file, FileKind kind, Over over = Over::kNoInput);

/// Of this process, at its end. Signal-safe.
void remove_partial_files() noexcept;

}  // namespace typodont
