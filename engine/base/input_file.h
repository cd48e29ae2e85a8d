// Files that the program reads: the one place that says what may be read, and that remembers what was.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>

namespace typodont {

/// What an input file is meant to hold. Each kind has a largest size, see largest_input().
enum class InputKind { kJson, kTable, kSession, kVolume, kScan, kMesh, kSound, kPicture, kAny };

/// "a JSON file", for messages.
std::string_view name_of(InputKind kind) noexcept;
/// Bytes. A larger file of this kind is refused before it is read.
std::uintmax_t largest_input(InputKind kind) noexcept;

/// From now on this process remembers what it reads, so that it writes over none of it. For commands; not for a window
/// or a library's user, who read and write the same files again and again on purpose.
void remember_inputs() noexcept;

/// Checks that `file` is a regular file (links are followed) of at most largest_input(kind) bytes, and remembers it as
/// an input. A directory, device, FIFO, socket or terminal is refused without being opened. Returns the
/// size in bytes. Any thread. Throws Error.
std::uintmax_t require_input(const std::filesystem::path& file, InputKind kind);
/// The same, and all its bytes.
std::string read_input(const std::filesystem::path& file, InputKind kind);
/// The same, and a binary stream at its beginning.
std::ifstream open_input(const std::filesystem::path& file, InputKind kind);

/// The remembered input that `file` is, under whatever name; nothing where it is none. Two names are one file
/// when device, inode and time of creation are the same. Any thread.
std::optional<std::filesystem::path> input_that_is(const std::filesystem::path& file);

/// Lines of a text file, each at most kLongest characters long, without the line end.
class LineReader {
 public:
  static constexpr std::size_t kLongest = 65535;
  LineReader(const std::filesystem::path& file, InputKind kind) : file_(file), in_(open_input(file, kind)) {}
  /// False at the end. Throws Error for a longer line, which is no line of a table.
  bool next(std::string& line);
  /// Of the newest line, from 1.
  std::size_t number() const noexcept { return number_; }

 private:
  std::filesystem::path file_;
  std::ifstream in_;
  std::string buffer_ = std::string(kLongest + 1, '\0');
  std::size_t number_ = 0;
};

}  // namespace typodont
