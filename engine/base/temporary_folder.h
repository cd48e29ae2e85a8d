// Folders for temporary files.
#pragma once

#include <filesystem>

namespace typodont {

/// Folder for temporary files: $TMPDIR if it is a folder, else /tmp, /var/tmp or the current folder. Any thread.
std::filesystem::path temporary_place();

/// A new folder that only this user can access. Deleted with its content by the destructor. Any thread.
class TemporaryFolder {
 public:
  /// Creates the folder. Throws Error.
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace typodont
