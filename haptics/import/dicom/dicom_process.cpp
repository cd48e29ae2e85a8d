#include "haptics/import/dicom/dicom_process.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "engine/base/error.h"
#include "engine/base/guarded_process.h"
#include "engine/base/temporary_folder.h"

namespace typodont::haptics::importing {

namespace {

/// A temporary file whose name is already deleted, so that it disappears with the object.
class Scratch {
 public:
  Scratch() {
    std::string pattern = (temporary_place() / "typodont_dicom_XXXXXX").string();
    fd_ = mkstemp(pattern.data());
    if (fd_ < 0) throw Error(pattern, "", std::strerror(errno), "a folder for temporary files");
    unlink(pattern.c_str());
  }
  ~Scratch() { close(fd_); }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  int fd() const { return fd_; }

  /// Returns false at the end of the file.
  bool read(void* to, std::size_t bytes) {
    char* p = static_cast<char*>(to);
    while (bytes > 0) {
      const ssize_t n = pread(fd_, p, bytes, at_);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) return false;
      p += n, at_ += n, bytes -= static_cast<std::size_t>(n);
    }
    return true;
  }
  void write(const std::string& text) {
    for (std::size_t done = 0; done < text.size();) {
      const ssize_t n = ::write(fd_, text.data() + done, text.size() - done);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) throw Error("temporary file", "", std::strerror(errno), "room; TMPDIR names another folder");
      done += static_cast<std::size_t>(n);
    }
  }
  std::string path() const { return fmt::format("/proc/{}/fd/{}", getpid(), fd_); }

 private:
  int fd_ = -1;
  off_t at_ = 0;
};

std::string reader_program() {
  return companion_program("TYPODONT_DICOM_READER", "typodont-dicom-reader", TYPODONT_DICOM_READER,
                           "the one that reads DICOM files")
      .string();
}

std::string list_of(std::span<const std::filesystem::path> files, std::size_t from) {
  std::string list;
  for (std::size_t k = 0; k < files.size(); ++k) {
    if (k >= from) list += std::filesystem::absolute(files[k]).string();
    list += '\0';
  }
  return list;
}

bool read_text(Scratch& in, std::string& text) {
  constexpr std::uint32_t kLongest = 500;
  std::uint32_t length = 0;
  if (!in.read(&length, sizeof length) || length > kLongest) return false;
  text.resize(length);
  return in.read(text.data(), length);
}

}  // namespace

std::vector<DicomHeader> read_dicom_headers(std::span<const std::filesystem::path> files) {
  constexpr std::size_t kMaxDeaths = 50;
  // Largest output per file: 4096 frames of about 150 bytes.
  constexpr std::uint64_t kOutputPerFile = 1 << 20;
  std::vector<DicomHeader> headers(files.size());
  std::size_t from = 0;
  for (std::size_t deaths = 0; from < files.size(); ++deaths) {
    if (deaths > kMaxDeaths) break;  // too many crashes: the remaining files keep DicomKind::kOther
    Scratch list, out;
    list.write(list_of(files, from));
    const int status = run_guarded(
        {reader_program(), "headers", list.path(), "0", std::to_string((64ull << 20) + kOutputPerFile * files.size())},
        out.fd());
    std::size_t current = from;
    bool sound = true;
    for (DicomRecord record{}; sound && out.read(&record, sizeof record) && record != DicomRecord::kEnd;) {
      DicomHeader& header = headers[current];
      switch (record) {
        case DicomRecord::kBegins: {
          std::uint32_t number = 0;
          sound = out.read(&number, sizeof number) && number < files.size() && number >= current;
          if (sound) current = number;
          break;
        }
        case DicomRecord::kFile:
          sound = out.read(&header.file, sizeof header.file);
          header.file.modality[sizeof header.file.modality - 1] = '\0';
          header.file.kernel[sizeof header.file.kernel - 1] = '\0';
          break;
        case DicomRecord::kFrame:
          header.frames.emplace_back();
          sound = out.read(&header.frames.back(), sizeof(DicomFrame));
          break;
        case DicomRecord::kReference:
          header.references.emplace_back();
          sound = read_text(out, header.references.back());
          break;
        case DicomRecord::kRefused:
          sound = read_text(out, header.malformed);
          break;
        default:
          sound = false;
      }
    }
    if (status == 0 && sound) return headers;
    headers[current] = {};
    headers[current].file.kind = DicomKind::kUnreadable;
    from = current + 1;
  }
  return headers;
}

void read_dicom_pixels(const std::string& name, std::span<const std::filesystem::path> files, std::uint64_t largest,
                       std::uint64_t total,
                       const std::function<void(const DicomPixels& pixels, std::vector<char>& bytes)>& take) {
  constexpr std::uint64_t kRecords = 1 << 20;
  Scratch list, out;
  list.write(list_of(files, 0));
  const int status = run_guarded({reader_program(), "pixels", list.path(), std::to_string(largest),
                                  std::to_string(total + kRecords + 64 * files.size())},
                                 out.fd());
  const auto fail = [&](std::size_t k, std::string_view found) {
    throw Error(name, fmt::format("image {} of {}", k + 1, files.size()), found, "an undamaged DICOM image");
  };
  std::size_t next = 0;
  std::uint32_t current = 0;
  for (DicomRecord record{}; out.read(&record, sizeof record) && record != DicomRecord::kEnd;) {
    if (record == DicomRecord::kBegins) {
      if (!out.read(&current, sizeof current)) break;
    } else if (record == DicomRecord::kRefused) {
      std::string why;
      if (!read_text(out, why)) break;
      fail(next, why);
    } else if (record == DicomRecord::kPixels) {
      DicomPixels pixels;
      if (!out.read(&pixels, sizeof pixels) || pixels.number != next || pixels.bytes > largest) break;
      std::vector<char> bytes(pixels.bytes);
      if (!out.read(bytes.data(), bytes.size())) break;
      take(pixels, bytes);
      ++next;
    } else {
      break;
    }
  }
  if (next == files.size()) return;
  fail(next, status == 0 ? "pixels of another size than its header says"
                         : "damaged pixels: the reader stopped, or took too much memory or time");
}

}  // namespace typodont::haptics::importing
