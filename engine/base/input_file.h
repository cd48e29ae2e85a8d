// Checks and opens input files, and remembers which files were read.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>

namespace typodont {

/// Kinds of input files, each with a maximum size, max_input().
enum class InputKind { kJson, kTable, kSession, kVolume, kScan, kMesh, kSound, kPicture, kAny };

/// The kind's name for messages, e.g. "a JSON file".
std::string_view name_of(InputKind kind) noexcept;
/// Maximum size, bytes. Larger files are refused without reading them.
std::uintmax_t max_input(InputKind kind) noexcept;

/// After this call, files that are read are remembered and never overwritten. Only for the command line: the operator's
/// window and host programs read and write the same files repeatedly.
void remember_inputs() noexcept;

/// Checks that the file (or the target of the link) is a regular file of at most max_input(kind) bytes, without
/// opening it, and remembers it. Returns its size, bytes. Any thread. Throws Error.
std::uintmax_t require_input(const std::filesystem::path& file, InputKind kind);
/// Calls require_input() and reads all bytes of the file.
std::string read_input(const std::filesystem::path& file, InputKind kind);
/// Calls require_input() and opens the file as a binary stream.
std::ifstream open_input(const std::filesystem::path& file, InputKind kind);

/// Returns the remembered input (see remember_inputs()) that is the same file: same device, inode and time of creation.
/// Any thread.
std::optional<std::filesystem::path> input_that_is(const std::filesystem::path& file);

/// Reads a file line by line. A line has up to kLongest characters; its line end is removed.
class LineReader {
 public:
  static constexpr std::size_t kLongest = 65535;
  LineReader(const std::filesystem::path& file, InputKind kind) : file_(file), in_(open_input(file, kind)) {}
  /// Reads the next line. False: end of file. Throws Error if the line is too long.
  bool next(std::string& line);
  /// Number of the last line read, from 1.
  std::size_t number() const noexcept { return number_; }

 private:
  std::filesystem::path file_;
  std::ifstream in_;
  std::string buffer_ = std::string(kLongest + 1, '\0');
  std::size_t number_ = 0;
};

}  // namespace typodont
