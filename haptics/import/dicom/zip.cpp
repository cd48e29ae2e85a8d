#include "haptics/import/dicom/zip.h"

#include <fmt/format.h>
#include <unzip.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <memory>
#include <string>

#include "engine/base/error.h"
#include "engine/base/input_file.h"
#include "engine/base/late_library.h"

namespace typodont::haptics::importing {

namespace {

constinit LateLibrary minizip{TYPODONT_LATE_MINIZIP};
TYPODONT_LATE(minizip, unzOpen64, unzClose, unzGoToFirstFile, unzGoToNextFile, unzGetCurrentFileInfo64,
              unzOpenCurrentFile, unzReadCurrentFile, unzCloseCurrentFile)

constexpr std::size_t kMaxEntries = 20000;
constexpr std::uint64_t kMaxBytes = 4000000000;  // bytes, largest total size of the unpacked files
constexpr std::uint64_t kMaxRatio = 1032;        // largest compression ratio of deflate

class Archive {
 public:
  explicit Archive(const std::filesystem::path& file) : name_(file.string()) {
    require_input(file, InputKind::kScan);
    zip_.reset(unzOpen64(file.c_str()));
    if (!zip_) fail("end", "no list of its files", "a whole ZIP archive");
  }

  /// Calls use(place, info, is_folder) for each entry of the list; `place` names it in messages.
  template <class Use>
  void each(const Use& use) {
    std::size_t number = 0;
    int state = unzGoToFirstFile(zip_.get());
    for (; state == UNZ_OK; state = unzGoToNextFile(zip_.get())) {
      const std::string place = fmt::format("file {}", ++number);
      if (number > kMaxEntries) fail("list", fmt::format("more than {} files", kMaxEntries), "fewer");
      unz_file_info64 info;
      std::array<char, 65537> name{};
      if (unzGetCurrentFileInfo64(zip_.get(), &info, name.data(), name.size(), nullptr, 0, nullptr, 0) != UNZ_OK)
        fail(place, "a damaged entry", "a whole ZIP archive");
      use(place, info, info.size_filename > 0 && name[info.size_filename - 1] == '/');
    }
    if (state != UNZ_END_OF_LIST_OF_FILE)
      fail(fmt::format("file {}", number + 1), "a damaged entry", "a whole ZIP archive");
  }

  void check() {
    std::uint64_t total = 0;
    each([&](const std::string& place, const unz_file_info64& info, bool) {
      if (info.uncompressed_size / kMaxRatio > info.compressed_size + 1)
        fail(place, fmt::format("{} bytes in {}", info.uncompressed_size, info.compressed_size),
             "no more than deflate can pack");
      total += info.uncompressed_size;
      if (total > kMaxBytes) fail("list", fmt::format("more than {} bytes unpacked", kMaxBytes), "fewer");
      if (info.flag & 1) fail(place, "an encrypted file", "an archive without a password");
      if (info.compression_method != 0 && info.compression_method != 8)
        fail(place, fmt::format("packing method {}", info.compression_method), "stored or deflated files");
    });
  }

  /// Unpacks the entry at which each() is.
  void unpack(const std::string& place, std::uint64_t size, const std::filesystem::path& to) {
    std::ofstream out(to, std::ios::binary);
    std::array<char, 1 << 16> piece;
    std::uint64_t got = 0;
    int n = unzOpenCurrentFile(zip_.get());
    while (n >= 0 && (n = unzReadCurrentFile(zip_.get(), piece.data(), piece.size())) > 0) {
      got += static_cast<std::uint64_t>(n);
      out.write(piece.data(), n);
    }
    if (n < 0 || unzCloseCurrentFile(zip_.get()) != UNZ_OK || got != size)
      fail(place, fmt::format("{} bytes, or others", got), fmt::format("{} bytes of an undamaged file", size));
    if (!out.flush())
      throw Error(to.parent_path().string(), "", std::strerror(errno),
                  "room to unpack; TMPDIR names another folder for temporary files");
  }

 private:
  [[noreturn]] void fail(std::string_view place, std::string_view found, std::string_view expected) const {
    throw Error(name_, place, found, expected);
  }
  struct Close {
    void operator()(void* zip) const { unzClose(zip); }
  };

  std::string name_;
  std::unique_ptr<void, Close> zip_;
};

}  // namespace

bool is_zip(std::string_view first_bytes) {
  return first_bytes.starts_with("PK\3\4");
}

std::vector<std::filesystem::path> unzip(const std::filesystem::path& archive, const std::filesystem::path& folder) {
  Archive zip(archive);
  zip.check();
  std::vector<std::filesystem::path> files;
  zip.each([&](const std::string& place, const unz_file_info64& info, bool is_folder) {
    if (is_folder || info.uncompressed_size == 0) return;
    files.push_back(folder / fmt::format("{:05}", files.size()));
    zip.unpack(place, info.uncompressed_size, files.back());
  });
  return files;
}

}  // namespace typodont::haptics::importing
