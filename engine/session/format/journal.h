// An HDF5 file driver whose file is whole after a power cut: what a flush changes is written to a journal beside the
// file and synced, then to the file and synced. At any moment either the file is as the last flush left it, or the
// journal holds all that is missing. (SQLite's write-ahead log with a checkpoint in every commit.)
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace typodont::session {

/// The journal of one file that is being written. Outlives the HDF5 file. Recorder thread.
class Journal {
 public:
  /// Of `file`, which may have another name until start().
  explicit Journal(const std::filesystem::path& file);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  /// Makes `access` (H5P_FILE_ACCESS) open its file with this driver. False when HDF5 refuses.
  bool use(hid_t access);
  /// Until now writes go to the file at once. From now on nothing of it changes but in commits, which HDF5's flushes
  /// are.
  void start() { started_ = true; }
  /// Why a commit or a write failed; empty: none did.
  const std::string& failure() const { return failure_; }

  struct Change {
    std::uint64_t place;  // in the file
    std::vector<std::byte> bytes;
  };

 private:
  friend struct JournaledFile;
  bool commit(int file, std::vector<Change>& changes, std::uint64_t old_end, std::uint64_t new_end);
  bool fail(const char* what);
  /// The file is whole without the journal.
  void remove();

  std::filesystem::path path_;
  int fd_ = -1;
  bool started_ = false, needed_ = false;  // needed: the file lacks a part of the last commit
  std::string failure_;
};

/// "s.h5.journal".
std::filesystem::path journal_of(const std::filesystem::path& file);
/// Brings what a whole journal of `file` holds into `target` (`file` itself or a copy of it) and syncs it. False when
/// there is no journal, or one that a power cut left unfinished: then the file is whole without it.
bool apply_journal(const std::filesystem::path& file, const std::filesystem::path& target);
/// Whether there is a whole one.
bool has_journal(const std::filesystem::path& file);

}  // namespace typodont::session
