// The kinds of file that the program writes. A kind is recognised by the file name's extension and by the first bytes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace typodont {

enum class FileKind {
  kText,   // plain text without a format
  kCache,  // a cache file of this program; may replace any file
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
  kDocument,  // PDF
  kLabels     // a tissue number for each voxel
};

/// Name of a kind in messages, for example "a session (.h5)".
std::string_view name_of(FileKind kind) noexcept;
/// File name extensions in lower case, with the dot; none for kText.
std::span<const std::string_view> endings_of(FileKind kind) noexcept;
/// Returns the kind among `kinds` to which the file name's extension belongs, in upper or lower case; kText if there is
/// no such kind.
FileKind kind_of_name(const std::filesystem::path& file, std::span<const FileKind> kinds);

/// True if a file of this kind may replace an existing file of `size` bytes that begins with `head` (up to 4 KiB): the
/// existing file is empty or of the same kind.
bool may_replace(FileKind kind, std::string_view head, std::uintmax_t size);

}  // namespace typodont
