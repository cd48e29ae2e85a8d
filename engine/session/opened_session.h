// A session file that is opened only once, so that the verified bytes are the bytes that are read.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>

namespace typodont::session {

class FileBytes;

/// A session file, opened once by its name. Readers and signature checks use only this descriptor, so a file that gets
/// the same name later is never read. Copies share the descriptor.
class OpenedSession {
 public:
  /// Throws Error if the file cannot be opened. Its content is not checked.
  OpenedSession(const std::filesystem::path& file);

  const std::filesystem::path& file() const;
  /// All bytes of the file, read at the first call. From then on all readers get these bytes, even if the file changes.
  /// Throws Error.
  std::span<const std::byte> bytes() const;

 private:
  friend class SessionReader;
  friend bool repair_session(const std::filesystem::path& file);
  std::shared_ptr<FileBytes> bytes_;
};

}  // namespace typodont::session
