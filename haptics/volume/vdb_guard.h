// OpenVDB trusts its files: a damaged length costs gigabytes, a damaged tree the heap. Files are looked over first.
#pragma once

#include <filesystem>
#include <functional>

namespace typodont::haptics {

/// Appends a seal to a finished .vdb file: eight letters and the FNV-1a of all bytes before. OpenVDB, which finds its
/// grids by position, never sees it. Throws Error when the file cannot be written.
void seal_vdb(const std::filesystem::path& file);

/// A file that OpenVDB can be trusted with: `file` itself where its seal is unbroken, or, for one from elsewhere, which
/// has none, a sealed copy that `rewrite(file, copy)` made in a process of its own, where a damaged tree does no harm.
/// Throws Error where the seal is broken, a stated length lies beyond the file, that process fails (with its message)
/// or dies.
class TrustedVdb {
 public:
  using Rewrite = std::function<void(const std::filesystem::path& file, const std::filesystem::path& copy)>;
  TrustedVdb(const std::filesystem::path& file, const Rewrite& rewrite);
  ~TrustedVdb();
  TrustedVdb(const TrustedVdb&) = delete;
  TrustedVdb& operator=(const TrustedVdb&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  bool copy_ = false;  // removed at the end
};

}  // namespace typodont::haptics
