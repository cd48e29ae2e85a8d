// The kinds of file that the program recognises. A kind is recognised by the file name's extension and by the first
// bytes of the file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace typodont {

enum class FileKind {
  kText,   // plain text of no known format
  kCache,  // a cache file of this program, which may replace a file of any kind
  kSession,
  kVolume,
  kPicture,
  kGreyPicture,
  kSound,
  kFilm,
  kPage,
  kDrawing,
  kJson,
  kTable,
  kPly,
  kStl,
  kObj,
  kDocument,  // a PDF document
  kLabels     // a volume with a tissue number for each voxel
};

/// Returns the name of a kind of file in messages, for example "a session (.h5)".
std::string_view name_of(FileKind kind) noexcept;
/// File name extensions of a kind, in lower case and with the dot. kText has none.
std::span<const std::string_view> endings_of(FileKind kind) noexcept;
/// Returns the kind among `kinds` that has the extension of this file name (in upper or lower case). Returns kText if
/// none of them has it.
FileKind kind_of_name(const std::filesystem::path& file, std::span<const FileKind> kinds);
/// Returns the kind among all kinds that has the extension of this file name, or kText if none of them has it.
FileKind kind_of_name(const std::filesystem::path& file);

/// Returns true if a file of this kind may replace an existing file. The existing file must be empty or of the same
/// kind. `head`: first bytes of the existing file (up to 4 KiB). `size`: its size in bytes.
bool may_replace(FileKind kind, std::string_view head, std::uintmax_t size);

}  // namespace typodont
