// A folder for intermediate files of one task.
#pragma once

#include <filesystem>

namespace typodont {

/// A new folder that only this user can read; it is deleted with its content when the object is destroyed. Any thread.
class TemporaryFolder {
 public:
  /// Throws Error if the folder cannot be created.
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace typodont
