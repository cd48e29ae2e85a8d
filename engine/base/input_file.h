// Input files: the one place that checks which files may be read, and that remembers the files that were read.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>

namespace typodont {

/// The content that an input file should have. largest_input() gives the size limit of each kind.
enum class InputKind { kJson, kTable, kSession, kVolume, kScan, kMesh, kSound, kPicture, kAny };

/// Name of a kind in messages, for example "a JSON file".
std::string_view name_of(InputKind kind) noexcept;
/// Size limit in bytes. A larger file of this kind is refused before it is read.
std::uintmax_t largest_input(InputKind kind) noexcept;

/// From now on this process remembers the files that it reads, so that it overwrites none of them. For commands only:
/// the window and users of the library read and write the same files repeatedly on purpose.
void remember_inputs() noexcept;

/// Checks that `file` is a regular file (links are followed) of at most largest_input(kind) bytes, and remembers it as
/// an input. A directory, device, FIFO, socket or terminal is refused without being opened. Returns the
/// size in bytes. Any thread. Throws Error.
std::uintmax_t require_input(const std::filesystem::path& file, InputKind kind);
/// Same as require_input(), but returns all bytes of the file.
std::string read_input(const std::filesystem::path& file, InputKind kind);
/// Same as require_input(), but returns a binary stream at the file's beginning.
std::ifstream open_input(const std::filesystem::path& file, InputKind kind);

/// Returns the remembered input that is the same file as `file`, even under another name. No value if there is no such
/// input. Two names are the same file if device, inode and time of creation are equal. Any thread.
std::optional<std::filesystem::path> input_that_is(const std::filesystem::path& file);

/// Reads a text file line by line. A line has at most kLongest characters, without its line end.
class LineReader {
 public:
  static constexpr std::size_t kLongest = 65535;
  LineReader(const std::filesystem::path& file, InputKind kind) : file_(file), in_(open_input(file, kind)) {}
  /// Reads the next line. Returns false at the end of the file. Throws Error if a line is too long.
  bool next(std::string& line);
  /// Number of the latest line, counted from 1.
  std::size_t number() const noexcept { return number_; }

 private:
  std::filesystem::path file_;
  std::ifstream in_;
  std::string buffer_ = std::string(kLongest + 1, '\0');
  std::size_t number_ = 0;
};

}  // namespace typodont
