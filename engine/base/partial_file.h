// A file that appears whole or not at all, and never in place of one that must stay.
#pragma once

#include <atomic>
#include <filesystem>
#include <string_view>

#include "engine/base/file_kind.h"

namespace typodont {

/// What a file may be written over.
enum class Over {
  kNoInput,  // anything but an input of this process (input_file.h)
  kItsInput  // an input too: a file that is read, changed and written back
};

/// The one way in which this program writes files: first beside their place under a temporary name, then, whole, in
/// their place.
///
/// It refuses to replace a file that this process has read, a file of another kind, a file that may not be written,
/// and a directory. A link to a regular file is followed; the file keeps its mode and, as far as permitted, its owner
/// and group. A device or a FIFO is never replaced: what was written is copied into it.
///
/// The temporary name is unpredictable and made anew (O_EXCL, O_NOFOLLOW). What killed processes left of earlier
/// attempts is removed first. Any thread, one at a time.
class PartialFile {
 public:
  /// `part`: where several are written for one file. Throws Error where the file may not be written; nothing is
  /// touched then.
  explicit PartialFile(std::filesystem::path file, FileKind kind = FileKind::kText, Over over = Over::kNoInput,
                       std::string_view part = {});
  /// Removes it, unless it was kept.
  ~PartialFile();
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;

  /// As it was named.
  const std::filesystem::path& file() const noexcept { return file_; }
  /// To be written: there already, and empty.
  const std::filesystem::path& path() const noexcept { return path_; }
  /// It becomes a file; otherwise `file` is a device or a FIFO, which keep() writes to.
  bool makes_file() const noexcept { return stream_ < 0; }

  /// It takes the place of `file`, closed and whole, and outlasts a power cut from then on. Throws Error when it
  /// cannot.
  void keep();

 private:
  void check_target();
  void take_over_owner(int fd) const;
  void copy_into_stream();
  void forget() noexcept;

  std::filesystem::path file_, path_;
  std::filesystem::path target_;  // where `file` leads by links
  FileKind kind_;
  Over over_;
  int stream_ = -1;  // of a device or FIFO
  std::atomic<const char*>* listed_ = nullptr;
};

/// Throws Error where a PartialFile of these would: said before the work and not after it. Leaves nothing.
void require_output(const std::filesystem::path& file, FileKind kind, Over over = Over::kNoInput);

/// Removes all that are half written in this process. For its end: safe in signal handlers.
void remove_partial_files() noexcept;

}  // namespace typodont
