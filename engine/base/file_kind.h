// Kinds of files, recognised by file extension and first bytes.
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
  kCache,  // file of this program's cache; may replace any file
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
  kLabels     // segmentation: a tissue number for each voxel
};

/// The kind's name for messages, e.g. "a session (.h5)".
std::string_view name_of(FileKind kind) noexcept;
/// File extensions of the kind, in lower case with the dot. kText has none.
std::span<const std::string_view> endings_of(FileKind kind) noexcept;
/// The first of `kinds` that has the file's extension, in upper or lower case; kText if none has it.
FileKind kind_of_name(const std::filesystem::path& file, std::span<const FileKind> kinds);
/// The kind that has the file's extension; kText: none has it.
FileKind kind_of_name(const std::filesystem::path& file);

/// True if a file of this kind may replace an existing file, which must be empty or of the same kind. `head`: the first
/// bytes of the existing file, up to 4 KiB; `size`: its size in bytes.
bool may_replace(FileKind kind, std::string_view head, std::uintmax_t size);

}  // namespace typodont
