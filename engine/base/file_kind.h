// What the files hold that the program writes: known by the ending of their name and by their first bytes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace typodont {

enum class FileKind {
  kText,   // of no format
  kCache,  // of this program alone, replaced whatever it is
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
  kLabels     // a tissue's number for each voxel
};

/// "a session (.h5)", for messages.
std::string_view name_of(FileKind kind) noexcept;
/// Endings of names, lower case, with their dot; none for kText.
std::span<const std::string_view> endings_of(FileKind kind) noexcept;
/// One of `kinds` by the ending of the name, upper or lower case; kText where it is that of none.
FileKind kind_of_name(const std::filesystem::path& file, std::span<const FileKind> kinds);

/// Whether an existing file of `size` bytes that begins with `head` (up to 4 KiB of it) may be replaced by one of this
/// kind: it is empty or of the same kind.
bool may_replace(FileKind kind, std::string_view head, std::uintmax_t size);

}  // namespace typodont
