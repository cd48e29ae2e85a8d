// An HDF5 file driver whose file survives a power cut. A flush writes its changes to a journal beside the file and
// syncs the journal. Then it writes the changes to the file and syncs the file. So at any moment either the file has
// the state of the last flush, or the journal contains all missing changes. (This is SQLite's write-ahead log with a
// checkpoint in every commit.)
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace typodont::session {

/// The journal of one file during its recording. Must outlive the HDF5 file. Recorder thread.
class Journal {
 public:
  /// `file` may have another name until start() is called.
  explicit Journal(const std::filesystem::path& file);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  /// Makes `access` (H5P_FILE_ACCESS) open its file with this driver. Returns false if HDF5 refuses.
  bool use(hid_t access);
  /// Starts the journal. Before this call, writes change the file directly. Afterwards the file changes only in
  /// commits; each HDF5 flush is one commit.
  void start() { started_ = true; }
  /// The reason why a commit or a write failed; empty if no commit or write failed.
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

/// Path of the journal, for example "s.h5.journal".
std::filesystem::path journal_of(const std::filesystem::path& file);
/// Writes the changes of a complete journal of `file` to `target` (`file` itself or a copy) and syncs the target.
/// Returns false if no journal exists, or only an unfinished one from a power cut; the file is then complete without
/// the journal.
bool apply_journal(const std::filesystem::path& file, const std::filesystem::path& target);
/// True if `file` has a complete journal.
bool has_journal(const std::filesystem::path& file);

}  // namespace typodont::session
