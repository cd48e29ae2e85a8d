// Kinds of file, recognised by extension and first bytes.
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
  kCache,  // of this program's cache; may replace any kind
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
  kLabels     // a tissue number per voxel
};

/// For messages, for example "a session (.h5)".
std::string_view name_of(FileKind kind) noexcept;
/// In lower case with the dot. kText has none.
std::span<const std::string_view> endings_of(FileKind kind) noexcept;
/// By the extension in any case; kText if none of `kinds` has it.
FileKind kind_of_name(const std::filesystem::path& file, std::span<const FileKind> kinds);
/// Among all kinds.
FileKind kind_of_name(const std::filesystem::path& file);

/// Over an empty file or one of the same kind. `head`: its first bytes, up to 4 KiB; `size`: bytes.
bool may_replace(FileKind kind, std::string_view head, std::uintmax_t size);

}  // namespace typodont
