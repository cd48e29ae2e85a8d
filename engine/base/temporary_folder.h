// For one task's intermediate files.
#pragma once

#include <filesystem>

namespace typodont {

/// $TMPDIR if it is a folder, else /tmp, /var/tmp or the current folder. Any thread.
std::filesystem::path temporary_place();

/// New, for this user only; deleted with its content. Any thread.
class TemporaryFolder {
 public:
  /// Throws Error.
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace typodont
