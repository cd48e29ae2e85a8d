// Checks which files may be read, and remembers those that were.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>

namespace typodont {

/// Each kind has its limit, largest_input().
enum class InputKind { kJson, kTable, kSession, kVolume, kScan, kMesh, kSound, kPicture, kAny };

/// For messages, for example "a JSON file".
std::string_view name_of(InputKind kind) noexcept;
/// bytes; larger files are refused unread.
std::uintmax_t largest_input(InputKind kind) noexcept;

/// From here, files that are read are remembered and never overwritten. For the command line only: window and hosts
/// read and write the same files repeatedly.
void remember_inputs() noexcept;

/// A regular file (links followed) up to largest_input(kind), then remembered. Others are refused unopened. Returns its
/// bytes. Any thread. Throws Error.
std::uintmax_t require_input(const std::filesystem::path& file, InputKind kind);
/// All bytes, after require_input().
std::string read_input(const std::filesystem::path& file, InputKind kind);
/// Binary stream, after require_input().
std::ifstream open_input(const std::filesystem::path& file, InputKind kind);

/// The remembered input that is this file: same device, inode and creation. Any thread.
std::optional<std::filesystem::path> input_that_is(const std::filesystem::path& file);

/// Up to kLongest characters a line, without its end.
class LineReader {
 public:
  static constexpr std::size_t kLongest = 65535;
  LineReader(const std::filesystem::path& file, InputKind kind) : file_(file), in_(open_input(file, kind)) {}
  /// False: end of file. Throws Error if too long.
  bool next(std::string& line);
  /// Of the last line, from 1.
  std::size_t number() const noexcept { return number_; }

 private:
  std::filesystem::path file_;
  std::ifstream in_;
  std::string buffer_ = std::string(kLongest + 1, '\0');
  std::size_t number_ = 0;
};

}  // namespace typodont
