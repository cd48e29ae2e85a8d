#include "engine/session/format/file_bytes.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <functional>
#include <new>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/input_file.h"
#include "engine/session/format/hdf5_driver.h"

namespace typodont::session {

bool read_all(int fd, void* out, std::uint64_t size, std::uint64_t place) noexcept {
  auto* to = static_cast<char*>(out);
  while (size > 0) {
    const ssize_t n = ::pread(fd, to, size, static_cast<off_t>(place));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return false;
    if (n == 0) {
      std::memset(to, 0, size);
      return true;
    }
    to += n, size -= static_cast<std::uint64_t>(n), place += static_cast<std::uint64_t>(n);
  }
  return true;
}

void overlay(std::span<const Change> changes, void* out, std::uint64_t size, std::uint64_t place) noexcept {
  for (const Change& change : changes) {
    const std::uint64_t begin = std::max(place, change.place);
    const std::uint64_t end = std::min(place + size, change.place + change.bytes.size());
    if (begin < end)
      std::memcpy(static_cast<std::byte*>(out) + (begin - place), change.bytes.data() + (begin - change.place),
                  end - begin);
  }
}

FileBytes::FileBytes(const std::filesystem::path& file) : file_(file) {
  require_input(file, InputKind::kSession);
  fd_ = ::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (fd_ < 0) throw Error(file.string(), "", std::strerror(errno), "a readable file");
  struct stat info {};
  if (::fstat(fd_, &info) != 0 || !S_ISREG(info.st_mode) ||
      static_cast<std::uint64_t>(info.st_size) > max_input(InputKind::kSession)) {
    ::close(fd_);
    throw Error(file.string(), "", "a file that is replaced while it is opened", "a session (.h5)");
  }
  size_ = shown_size_ = static_cast<std::uint64_t>(info.st_size);
}

FileBytes::~FileBytes() {
  ::close(fd_);
}

std::span<const std::byte> FileBytes::in_memory() {
  if (loaded_) return bytes_;
  bytes_.resize(size_);
  if (!read_all(fd_, bytes_.data(), size_, 0))
    throw Error(file_.string(), "", std::strerror(errno), "a file that can be read to its end");
  loaded_ = true;
  return bytes_;
}

bool FileBytes::read(void* out, std::uint64_t size, std::uint64_t place) const noexcept {
  if (loaded_) {
    const std::uint64_t there = place < size_ ? std::min(size, size_ - place) : 0;
    if (there > 0) std::memcpy(out, bytes_.data() + place, there);
    std::memset(static_cast<std::byte*>(out) + there, 0, size - there);
  } else if (!read_all(fd_, out, size, place)) {
    return false;
  }
  overlay(changes_, out, size, place);
  return true;
}

void FileBytes::show_with(std::vector<Change> changes) {
  changes_ = std::move(changes);
  for (const Change& change : changes_) lengthen(change.place + change.bytes.size());
}

void FileBytes::write_to(const std::filesystem::path& out) const {
  std::ofstream file(out, std::ios::binary);
  std::vector<char> piece(1 << 20);
  for (std::uint64_t at = 0; at < shown_size_; at += piece.size()) {
    const std::uint64_t size = std::min<std::uint64_t>(piece.size(), shown_size_ - at);
    if (!read(piece.data(), size, at)) throw Error(file_.string(), "", std::strerror(errno), "a readable file");
    file.write(piece.data(), static_cast<std::streamsize>(size));
  }
  if (!file.flush()) throw Error(out.string(), "", std::strerror(errno ? errno : EIO), "a writable file");
}

struct BytesDriver : DriverFile<BytesDriver, const FileBytes> {
  static constexpr const char* kName = "typodont_bytes";
  static constexpr unsigned long kFeatures = H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
                                             H5FD_FEAT_SUPPORTS_SWMR_IO | H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;

  static H5FD_t* open(const char*, unsigned flags, hid_t access, haddr_t) {
    const FileBytes* const bytes = source_in(access);
    if (!bytes || flags & H5F_ACC_RDWR) return nullptr;
    auto* file = new (std::nothrow) BytesDriver;
    if (!file) return nullptr;
    file->source = bytes;
    return &file->hdf5;
  }
  static herr_t close(H5FD_t* f) {
    delete &of(f);
    return 0;
  }
  static haddr_t get_eof(const H5FD_t* f, H5FD_mem_t) { return of(f).source->shown_size_; }
  static herr_t read(H5FD_t* f, H5FD_mem_t, hid_t, haddr_t place, std::size_t size, void* out) {
    return of(f).source->read(out, size, place) ? 0 : -1;
  }
  static herr_t write(H5FD_t*, H5FD_mem_t, hid_t, haddr_t, std::size_t, const void*) { return -1; }
  // Two readers of one file never share a handle, because one of them may close it first.
  static int compare(const H5FD_t* a, const H5FD_t* b) {
    return a == b ? 0 : std::less<const H5FD_t*>()(a, b) ? -1 : 1;
  }
};

bool FileBytes::use(hid_t access) const {
  return BytesDriver::use(access, this);
}

}  // namespace typodont::session
