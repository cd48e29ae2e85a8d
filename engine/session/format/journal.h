// An HDF5 file driver whose file survives a power cut. A flush writes its changes to a journal beside the file and
// syncs it, and then writes them to the file and syncs that. So at any moment either the file is as the last flush left
// it, or the journal contains everything that is missing. (This is SQLite's write-ahead log with a checkpoint in every
// commit.)
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace typodont::session {

/// The journal of one file that is being written. Must outlive the HDF5 file. Recorder thread.
class Journal {
 public:
  /// `file` may have another name until start().
  explicit Journal(const std::filesystem::path& file);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  /// Makes `access` (H5P_FILE_ACCESS) open its file with this driver. False if HDF5 refuses.
  bool use(hid_t access);
  /// Before this call, writes go directly to the file. After it, the file changes only in commits; each HDF5 flush is
  /// one commit.
  void start() { started_ = true; }
  /// The reason why a commit or a write failed; empty: none failed.
  const std::string& failure() const { return failure_; }

  struct Change {
    std::uint64_t place;  // offset in the file
    std::vector<std::byte> bytes;
  };

 private:
  friend struct JournaledFile;
  bool commit(int file, std::vector<Change>& changes, std::uint64_t old_end, std::uint64_t new_end);
  bool fail(const char* what);
  /// Removes the journal, because the file is complete without it.
  void remove();

  std::filesystem::path path_;
  int fd_ = -1;
  bool started_ = false, needed_ = false;  // needed_: the file lacks a part of the last commit
  std::string failure_;
};

/// "s.h5.journal".
std::filesystem::path journal_of(const std::filesystem::path& file);
/// Writes the changes of a complete journal of `file` to `target` (`file` itself or a copy) and syncs it. False if
/// there is no journal, or only an unfinished one from a power cut: then the file is complete without it.
bool apply_journal(const std::filesystem::path& file, const std::filesystem::path& target);
/// True if there is a complete journal.
bool has_journal(const std::filesystem::path& file);

}  // namespace typodont::session
