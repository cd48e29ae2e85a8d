// A file driver for HDF5 with which a file survives a power cut. A flush first writes all changes to a journal beside
// the file, and then to the file; it syncs both.
// So at any moment, either the file has the state of the last flush, or the journal contains all missing changes.
// (SQLite's write-ahead log works in the same way if a checkpoint follows every commit.)
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/session/format/file_bytes.h"

namespace typodont::session {

/// The journal of one recording. It must outlive the open HDF5 file. Recorder thread only.
class Journal {
 public:
  /// `file` is the final path of the session file; until start(), the session file may have another name.
  explicit Journal(const std::filesystem::path& file);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  /// Makes HDF5 use this driver for files that are opened with the property list `access` (H5P_FILE_ACCESS). False if
  /// HDF5 refuses.
  bool use(hid_t access);
  /// Starts the journal. Before this call, writes change the file directly. Afterwards, the file changes only when HDF5
  /// flushes it, and each flush is one commit.
  void start() { started_ = true; }
  /// Why a commit or write failed; empty: none failed.
  const std::string& failure() const { return failure_; }
  /// 32 random hexadecimal digits. The recorder writes them to the beginning of the session file before start(), and
  /// the journal contains them too, so that the journal cannot be applied to another recording.
  const std::string& recording() const { return recording_; }
  /// Length of the session file after the last flush.
  std::uint64_t length() const { return length_; }

 private:
  friend struct JournaledFile;
  bool commit(int file, std::vector<Change>& changes, std::uint64_t old_end, std::uint64_t new_end);
  bool fail(const char* what);
  /// Removes the journal file, after the session file is complete.
  void remove();

  std::filesystem::path path_;
  std::string recording_;
  int fd_ = -1;
  std::uint64_t length_ = 0;
  bool started_ = false, needed_ = false;  // needed_: the file still lacks changes of the last commit
  std::string failure_;
};

/// The path of the journal of `file`, for example "s.h5.journal".
std::filesystem::path journal_of(const std::filesystem::path& file);
/// The changes of a flush that a power cut interrupted. Returns nothing if there is no journal, if it is incomplete, or
/// if it belongs to another file: with another identity, or a length that this file cannot have had. The changes need
/// at most 64 MiB more memory than the file's size, and lie inside the file's length after the flush.
std::vector<Change> journal_changes(const FileBytes& file);

}  // namespace typodont::session
