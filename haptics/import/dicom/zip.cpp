#include "haptics/import/dicom/zip.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>

#include "engine/base/error.h"
#include "engine/base/input_file.h"

namespace typodont::haptics::importing {

namespace {

constexpr std::size_t kMaxEntries = 20000;
constexpr std::uint64_t kMaxBytes = 4000000000;  // bytes, largest total size of the unpacked files
// Largest compression ratio of deflate.
constexpr std::uint64_t kMaxRatio = 1032;
constexpr std::uint32_t kEndSign = 0x06054b50, kEntrySign = 0x02014b50, kLocalSign = 0x04034b50;

struct Entry {
  std::uint16_t flags = 0, method = 0;
  std::uint32_t crc = 0, packed = 0, size = 0, at = 0;
  bool folder = false;
};

template <class T>
T number(const std::string& bytes, std::size_t at) {
  T value = 0;
  std::memcpy(&value, &bytes[at], sizeof value);
  return value;
}

class Archive {
 public:
  explicit Archive(const std::filesystem::path& file)
      : name_(file.string()), size_(require_input(file, InputKind::kScan)), in_(file, std::ios::binary) {}

  std::vector<Entry> entries() {
    constexpr std::size_t kEnd = 22, kLongestComment = 65535, kEntry = 46;
    if (size_ < kEnd) fail("end", fmt::format("{} bytes", size_), "a ZIP archive");
    const std::size_t tail = static_cast<std::size_t>(std::min<std::uint64_t>(size_, kEnd + kLongestComment));
    const std::string end = bytes(size_ - tail, tail);
    std::size_t at = tail - kEnd;
    while (number<std::uint32_t>(end, at) != kEndSign) {
      if (at == 0) fail("end", "no list of its files", "a whole ZIP archive");
      --at;
    }
    const auto count = number<std::uint16_t>(end, at + 10);
    const auto length = number<std::uint32_t>(end, at + 12), start = number<std::uint32_t>(end, at + 16);
    if (count == 0xffff || start == 0xffffffff)
      fail("end", "an archive of the kind ZIP64", "at most 4 GB, 65534 files");
    if (count > kMaxEntries) fail("end", fmt::format("{} files", count), fmt::format("at most {}", kMaxEntries));
    if (start > size_ || length > size_ - start) fail("end", "a list of files beyond its end", "a whole ZIP archive");
    const std::string list = bytes(start, length);
    std::vector<Entry> all;
    std::uint64_t total = 0;
    for (std::size_t k = 0, p = 0; k < count; ++k) {
      const auto damaged = [&] { fail(fmt::format("file {}", k + 1), "a damaged entry", "a whole ZIP archive"); };
      if (p + kEntry > list.size() || number<std::uint32_t>(list, p) != kEntrySign) damaged();
      Entry e;
      e.flags = number<std::uint16_t>(list, p + 8);
      e.method = number<std::uint16_t>(list, p + 10);
      e.crc = number<std::uint32_t>(list, p + 16);
      e.packed = number<std::uint32_t>(list, p + 20);
      e.size = number<std::uint32_t>(list, p + 24);
      e.at = number<std::uint32_t>(list, p + 42);
      const std::size_t words = number<std::uint16_t>(list, p + 28);
      const std::size_t more = words + number<std::uint16_t>(list, p + 30) + number<std::uint16_t>(list, p + 32);
      if (p + kEntry + more > list.size()) damaged();
      e.folder = words > 0 && list[p + kEntry + words - 1] == '/';
      p += kEntry + more;
      if (e.packed > size_ || e.at > size_) damaged();
      if (e.size > kMaxRatio * (std::uint64_t{e.packed} + 1)) {
        fail(fmt::format("file {}", k + 1), fmt::format("{} bytes in {}", e.size, e.packed),
             "no more than deflate can pack");
      }
      total += e.size;
      if (total > kMaxBytes) fail("list", fmt::format("more than {} bytes unpacked", kMaxBytes), "fewer");
      if (e.flags & 1) fail(fmt::format("file {}", k + 1), "an encrypted file", "an archive without a password");
      if (e.method != 0 && e.method != 8)
        fail(fmt::format("file {}", k + 1), fmt::format("packing method {}", e.method), "stored or deflated files");
      all.push_back(e);
    }
    return all;
  }

  void unpack(const Entry& e, std::size_t number_of, const std::filesystem::path& to) {
    const auto damaged = [&](std::string_view found) {
      fail(fmt::format("file {}", number_of), found, fmt::format("{} bytes of an undamaged file", e.size));
    };
    constexpr std::size_t kLocal = 30, kPiece = 1 << 16;
    if (e.at + kLocal > size_) damaged("an entry beyond the end");
    const std::string local = bytes(e.at, kLocal);
    if (number<std::uint32_t>(local, 0) != kLocalSign) damaged("a damaged entry");
    const std::uint64_t from =
        std::uint64_t{e.at} + kLocal + number<std::uint16_t>(local, 26) + number<std::uint16_t>(local, 28);
    if (from > size_ || e.packed > size_ - from) damaged("an entry beyond the end");
    std::ofstream out(to, std::ios::binary);
    in_.clear();
    in_.seekg(static_cast<std::streamoff>(from));
    std::uint64_t left = e.packed, got = 0;
    uLong crc = crc32(0, nullptr, 0);
    std::vector<char> piece(kPiece), unpacked(kPiece);
    z_stream z{};
    if (e.method == 8 && inflateInit2(&z, -15) != Z_OK) throw RunFailure("zlib does not start");
    struct End {
      z_stream* z;
      ~End() {
        if (z) inflateEnd(z);
      }
    } const end{e.method == 8 ? &z : nullptr};
    const auto take = [&](const char* from_here, std::size_t n) {
      got += n;
      if (got > e.size) damaged("more bytes than it says");
      crc = crc32(crc, reinterpret_cast<const Bytef*>(from_here), static_cast<uInt>(n));
      out.write(from_here, static_cast<std::streamsize>(n));
    };
    int state = Z_OK;
    while (left > 0 && state == Z_OK) {
      const auto n = static_cast<std::size_t>(std::min<std::uint64_t>(left, kPiece));
      in_.read(piece.data(), static_cast<std::streamsize>(n));
      if (static_cast<std::size_t>(in_.gcount()) != n) damaged("the end of the archive");
      left -= n;
      if (e.method == 0) {
        take(piece.data(), n);
        continue;
      }
      z.next_in = reinterpret_cast<Bytef*>(piece.data());
      z.avail_in = static_cast<uInt>(n);
      do {
        z.next_out = reinterpret_cast<Bytef*>(unpacked.data());
        z.avail_out = kPiece;
        state = inflate(&z, Z_NO_FLUSH);
        if (state != Z_OK && state != Z_STREAM_END && state != Z_BUF_ERROR) damaged("damaged packed bytes");
        take(unpacked.data(), kPiece - z.avail_out);
        if (state == Z_BUF_ERROR) state = Z_OK;
      } while (state == Z_OK && z.avail_out == 0);
    }
    if (got != e.size || crc != e.crc) damaged(fmt::format("{} bytes, or others", got));
    if (!out.flush())
      throw Error(to.parent_path().string(), "", std::strerror(errno),
                  "room to unpack; TMPDIR names another folder for temporary files");
  }

 private:
  [[noreturn]] void fail(std::string_view place, std::string_view found, std::string_view expected) const {
    throw Error(name_, place, found, expected);
  }
  std::string bytes(std::uint64_t from, std::size_t count) {
    std::string b(count, '\0');
    in_.clear();
    in_.seekg(static_cast<std::streamoff>(from));
    in_.read(b.data(), static_cast<std::streamsize>(count));
    if (static_cast<std::size_t>(in_.gcount()) != count) fail("", "an unreadable file", "a ZIP archive");
    return b;
  }

  std::string name_;
  std::uint64_t size_;
  std::ifstream in_;
};

}  // namespace

bool is_zip(std::string_view first_bytes) {
  return first_bytes.starts_with("PK\3\4");
}

std::vector<std::filesystem::path> unzip(const std::filesystem::path& archive, const std::filesystem::path& folder) {
  Archive zip(archive);
  const std::vector<Entry> entries = zip.entries();
  std::vector<std::filesystem::path> files;
  for (std::size_t k = 0; k < entries.size(); ++k) {
    if (entries[k].folder || entries[k].size == 0) continue;
    files.push_back(folder / fmt::format("{:05}", k));
    zip.unpack(entries[k], k + 1, files.back());
  }
  return files;
}

}  // namespace typodont::haptics::importing
