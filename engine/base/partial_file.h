// A file that appears whole or not at all.
#pragma once

#include <filesystem>
#include <string_view>

namespace typodont {

/// Where a file is written until it is whole: beside its place, under a name that tells the process. What killed
/// processes left there of earlier attempts is removed first.
class PartialFile {
 public:
  /// `kind`: where several are written for one file. Throws Error where `file` is a directory.
  explicit PartialFile(std::filesystem::path file, std::string_view kind = {});
  /// Removes it, unless it was kept.
  ~PartialFile();
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;

  const std::filesystem::path& file() const noexcept { return file_; }
  /// To be written.
  const std::filesystem::path& path() const noexcept { return path_; }

  /// It takes the place of `file`, closed and whole, and outlasts a power cut from then on. Throws Error when it
  /// cannot.
  void keep();

 private:
  std::filesystem::path file_, path_;
};

}  // namespace typodont
