// A folder for the intermediate files of one task.
#pragma once

#include <filesystem>

namespace typodont {

/// A new folder that only this user can read. The destructor deletes the folder and its content. Any thread.
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
