// Opens input files. These functions check which files may be read, and remember the files that were read.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>

namespace typodont {

/// The kind of content that an input file should have. largest_input() gives the size limit of each kind.
enum class InputKind { kJson, kTable, kSession, kVolume, kScan, kMesh, kSound, kPicture, kAny };

/// Returns the name of a kind of input in messages, for example "a JSON file".
std::string_view name_of(InputKind kind) noexcept;
/// Returns the size limit of a kind of input, in bytes. A larger file is refused before it is read.
std::uintmax_t largest_input(InputKind kind) noexcept;

/// After this call, the process remembers the files that it reads, and refuses to overwrite them. Only runs from the
/// command line call this function. The window and host programs do not call it, because they read and write the same
/// files repeatedly.
void remember_inputs() noexcept;

/// Checks that `file` is a regular file (links are followed) of at most largest_input(kind) bytes, and remembers it as
/// an input. A directory, device, FIFO, socket or terminal is refused without opening it. Returns the file's size in
/// bytes. Any thread. Throws Error.
std::uintmax_t require_input(const std::filesystem::path& file, InputKind kind);
/// Checks the file as require_input() does, and returns all its bytes.
std::string read_input(const std::filesystem::path& file, InputKind kind);
/// Checks the file as require_input() does, and returns a binary stream at the file's beginning.
std::ifstream open_input(const std::filesystem::path& file, InputKind kind);

/// Returns the remembered input that is the same file as `file`, or no value if there is none. Two names mean the same
/// file if device, inode and time of creation are equal. Any thread.
std::optional<std::filesystem::path> input_that_is(const std::filesystem::path& file);

/// Reads a text file line by line. A line may have up to kLongest characters, without its line end.
class LineReader {
 public:
  static constexpr std::size_t kLongest = 65535;
  LineReader(const std::filesystem::path& file, InputKind kind) : file_(file), in_(open_input(file, kind)) {}
  /// Reads the next line. Returns false at the end of the file. Throws Error if a line is too long.
  bool next(std::string& line);
  /// Returns the number of the line that next() returned last, counted from 1.
  std::size_t number() const noexcept { return number_; }

 private:
  std::filesystem::path file_;
  std::ifstream in_;
  std::string buffer_ = std::string(kLongest + 1, '\0');
  std::size_t number_ = 0;
};

}  // namespace typodont
