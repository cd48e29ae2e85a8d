#include "engine/session/format/journal.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <new>
#include <random>
#include <span>

#include "engine/base/fnv.h"
#include "engine/base/sync.h"
#include "engine/session/format/hdf5_driver.h"

namespace typodont::session {

namespace {

// Beginning of a journal file. It is followed by the changes, each as offset, length (8 bytes each) and bytes.
constexpr std::array<char, 8> kMagic = {'T', 'Y', 'P', 'O', 'J', 'R', 'N', '2'};
struct Header {
  std::array<char, 8> magic = kMagic;
  std::array<char, 32> recording{};          // identity of the recording
  std::uint64_t old_length = 0, length = 0;  // bytes, the session file's size before and after the flush
  std::uint64_t bytes = 0;                   // size of all changes in the journal
  std::uint64_t checksum = 0;                // FNV-1a hash of all members above and of the changes
};
constexpr std::uint64_t kMaxSurplus = 64u << 20;   // bytes; a journal may be larger than the file by at most this
constexpr std::uint64_t kMaxHole = 1u << 20;       // bytes; largest growth of the file beyond the data in its journal
constexpr std::size_t kIdentityWithin = 1u << 20;  // bytes at a recording's beginning that contain its identity

bool write_all(int fd, const void* bytes, std::uint64_t size, std::uint64_t place) {
  const auto* from = static_cast<const char*>(bytes);
  while (size > 0) {
    const ssize_t n = ::pwrite(fd, from, size, static_cast<off_t>(place));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    from += n, size -= static_cast<std::uint64_t>(n), place += static_cast<std::uint64_t>(n);
  }
  return true;
}

std::uint64_t checksum_of(const Header& header, std::span<const std::byte> changes) {
  Fnv1a hash;
  hash.bytes(&header, offsetof(Header, checksum));
  hash.bytes(changes.data(), changes.size());
  return hash.value;
}

std::string random_digits() {
  std::random_device random;
  std::string digits;
  for (int i = 0; i < 4; ++i) digits += fmt::format("{:08x}", random());
  return digits;
}

}  // namespace

struct JournaledFile : DriverFile<JournaledFile, Journal> {
  static constexpr const char* kName = "typodont_journal";
  static constexpr unsigned long kFeatures = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA |
                                             H5FD_FEAT_DATA_SIEVE | H5FD_FEAT_AGGREGATE_SMALLDATA |
                                             H5FD_FEAT_SUPPORTS_SWMR_IO | H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
  int fd = -1;
  haddr_t end = 0;       // size of the file as HDF5 sees it
  haddr_t real_end = 0;  // size of the file on the disk, without uncommitted changes
  std::vector<Change> changes;

  bool commit() {
    if (changes.empty()) return true;
    try {
      if (!source->commit(fd, changes, real_end, end)) return false;
    } catch (const std::bad_alloc&) {
      errno = ENOMEM;
      return source->fail("its journal");
    }
    real_end = end;
    changes.clear();
    return true;
  }

  static H5FD_t* open(const char* name, unsigned flags, hid_t access, haddr_t most) {
    Journal* const journal = source_in(access);
    if (!journal || most == 0) return nullptr;
    const int open_flags = (flags & H5F_ACC_RDWR ? O_RDWR : O_RDONLY) | (flags & H5F_ACC_TRUNC ? O_TRUNC : 0) |
                           (flags & H5F_ACC_CREAT ? O_CREAT : 0) | (flags & H5F_ACC_EXCL ? O_EXCL : 0) | O_CLOEXEC;
    const int fd = ::open(name, open_flags, 0666);
    struct stat info {};
    if (fd < 0 || fstat(fd, &info) != 0) {
      if (fd >= 0) ::close(fd);
      return nullptr;
    }
    auto* file = new (std::nothrow) JournaledFile;
    if (!file) {
      ::close(fd);
      return nullptr;
    }
    file->fd = fd;
    file->source = journal;
    file->end = file->real_end = static_cast<haddr_t>(info.st_size);
    return &file->hdf5;
  }
  static herr_t close(H5FD_t* f) {
    JournaledFile& file = of(f);
    const bool whole = file.commit();
    if (whole && !file.source->needed_) file.source->remove();
    const bool closed = ::close(file.fd) == 0;
    delete &file;
    return whole && closed ? 0 : -1;
  }
  static haddr_t get_eof(const H5FD_t* f, H5FD_mem_t) { return of(f).end; }
  static herr_t read(H5FD_t* f, H5FD_mem_t, hid_t, haddr_t place, std::size_t size, void* bytes) {
    const JournaledFile& file = of(f);
    if (!read_all(file.fd, bytes, size, place)) return -1;
    overlay(file.changes, bytes, size, place);
    return 0;
  }
  static herr_t write(H5FD_t* f, H5FD_mem_t, hid_t, haddr_t place, std::size_t size, const void* bytes) {
    JournaledFile& file = of(f);
    file.end = std::max<haddr_t>(file.end, place + size);
    if (!file.source->started_) {
      if (!write_all(file.fd, bytes, size, place)) {
        file.source->fail("the file");
        return -1;
      }
      file.real_end = file.end;
      return 0;
    }
    const auto* from = static_cast<const std::byte*>(bytes);
    try {  // no exception may leave this function: HDF5 is in C
      if (!file.changes.empty() && file.changes.back().place + file.changes.back().bytes.size() == place) {
        file.changes.back().bytes.insert(file.changes.back().bytes.end(), from, from + size);
      } else {
        file.changes.push_back({place, {from, from + size}});
      }
    } catch (const std::bad_alloc&) {
      errno = ENOMEM;
      file.source->fail("the recorder");
      return -1;
    }
    return 0;
  }
  static herr_t flush(H5FD_t* f, hid_t, hbool_t) { return of(f).commit() ? 0 : -1; }
  static herr_t truncate(H5FD_t* f, hid_t, hbool_t) {
    JournaledFile& file = of(f);
    if (!file.commit()) return -1;
    if (file.end_of_addresses == file.end) return 0;
    if (ftruncate(file.fd, static_cast<off_t>(file.end_of_addresses)) != 0) return -1;
    file.end = file.real_end = file.source->length_ = file.end_of_addresses;
    return 0;
  }
  static int compare(const H5FD_t* a, const H5FD_t* b) {
    struct stat first {
    }, second{};
    fstat(of(a).fd, &first), fstat(of(b).fd, &second);
    if (first.st_dev != second.st_dev) return first.st_dev < second.st_dev ? -1 : 1;
    return first.st_ino == second.st_ino ? 0 : first.st_ino < second.st_ino ? -1 : 1;
  }
};

Journal::Journal(const std::filesystem::path& file) : path_(journal_of(file)), recording_(random_digits()) {}

Journal::~Journal() {
  if (fd_ >= 0) ::close(fd_);
}

bool Journal::use(hid_t access) {
  return JournaledFile::use(access, this);
}

bool Journal::fail(const char* what) {
  if (failure_.empty()) failure_ = fmt::format("{} ({})", std::strerror(errno), what);
  return false;
}

bool Journal::commit(int file, std::vector<Change>& changes, std::uint64_t old_end, std::uint64_t new_end) {
  if (fd_ < 0) {
    fd_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (fd_ < 0 || !sync_folder_of(path_)) return fail("its journal");
  }
  // Reserves disk space for the growth of the file, so that a full disk is detected before the file changes. Some file
  // systems do not support this.
  if (new_end > old_end &&
      fallocate(file, FALLOC_FL_KEEP_SIZE, static_cast<off_t>(old_end), static_cast<off_t>(new_end - old_end)) != 0 &&
      (errno == ENOSPC || errno == EDQUOT || errno == EFBIG))
    return fail("the file");

  std::vector<std::byte> all(sizeof(Header));
  const auto add = [&](const void* bytes, std::size_t size) {
    const auto* from = static_cast<const std::byte*>(bytes);
    all.insert(all.end(), from, from + size);
  };
  for (const Change& change : changes) {
    const std::uint64_t size = change.bytes.size();
    add(&change.place, sizeof change.place);
    add(&size, sizeof size);
    add(change.bytes.data(), size);
  }
  Header header;
  std::copy(recording_.begin(), recording_.end(), header.recording.begin());
  header.old_length = old_end, header.length = new_end;
  header.bytes = all.size() - sizeof(Header);
  header.checksum = checksum_of(header, std::span(all).subspan(sizeof(Header)));
  std::memcpy(all.data(), &header, sizeof header);
  if (!write_all(fd_, all.data(), all.size(), 0) || fdatasync(fd_) != 0) return fail("its journal");

  needed_ = true;
  for (const Change& change : changes)
    if (!write_all(file, change.bytes.data(), change.bytes.size(), change.place)) return fail("the file");
  if (fdatasync(file) != 0) return fail("the file");
  needed_ = false;
  length_ = new_end;
  return true;
}

void Journal::remove() {
  if (fd_ < 0) return;
  ::close(fd_);
  fd_ = -1;
  ::unlink(path_.c_str());
  sync_folder_of(path_);
}

std::filesystem::path journal_of(const std::filesystem::path& file) {
  std::filesystem::path journal = file;
  journal += ".journal";
  return journal;
}

namespace {

bool contains_identity(const FileBytes& file, const std::array<char, 32>& recording) {
  std::vector<char> head(std::min<std::uint64_t>(file.size(), kIdentityWithin));
  return file.read(head.data(), head.size(), 0) &&
         std::search(head.begin(), head.end(), recording.begin(), recording.end()) != head.end();
}

std::vector<Change> read_changes(int fd, const FileBytes& file) {
  Header header;
  struct stat info {};
  if (fstat(fd, &info) != 0 || !S_ISREG(info.st_mode) || !read_all(fd, &header, sizeof header, 0) ||
      header.magic != kMagic || header.bytes > file.size() + kMaxSurplus ||
      sizeof header + header.bytes > static_cast<std::uint64_t>(info.st_size) || file.size() < header.old_length ||
      file.size() > header.length || header.length - header.old_length > header.bytes + kMaxHole ||
      !contains_identity(file, header.recording))
    return {};
  std::vector<std::byte> all(header.bytes);
  if (!read_all(fd, all.data(), all.size(), sizeof header) || checksum_of(header, all) != header.checksum) return {};
  std::vector<Change> changes;
  for (std::span<const std::byte> rest = all; !rest.empty();) {
    std::array<std::uint64_t, 2> head{};  // offset and length of a change
    if (rest.size() < sizeof head) return {};
    std::memcpy(head.data(), rest.data(), sizeof head);
    rest = rest.subspan(sizeof head);
    if (head[1] > rest.size() || head[0] > header.length || head[1] > header.length - head[0]) return {};
    changes.push_back({head[0], {rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(head[1])}});
    rest = rest.subspan(head[1]);
  }
  return changes;
}

}  // namespace

std::vector<Change> journal_changes(const FileBytes& file) {
  const int fd = ::open(journal_of(file.file()).c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return {};
  std::vector<Change> changes = read_changes(fd, file);
  ::close(fd);
  return changes;
}

}  // namespace typodont::session
