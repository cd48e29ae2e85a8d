#include "engine/base/file_kind.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "engine/base/lower_case.h"

namespace typodont {

namespace {

using namespace std::string_view_literals;

struct KindOfFile {
  std::string_view name;
  std::array<std::string_view, 3> endings;
  std::size_t endings_count;
};
constexpr std::array<KindOfFile, 17> kKinds{
    {{"a text file", {}, 0},
     {"a file of the cache", {}, 0},
     {"a session (.h5)", {".h5"}, 1},
     {"a tissue volume (.vdb)", {".vdb"}, 1},
     {"a picture (.png)", {".png"}, 1},
     {"a grey picture (.pgm)", {".pgm"}, 1},
     {"a sound file (.wav)", {".wav"}, 1},
     {"a film (.mp4)", {".mp4"}, 1},
     {"a page (.html)", {".html", ".htm"}, 2},
     {"a drawing (.svg)", {".svg"}, 1},
     {"a JSON file (.json)", {".json"}, 1},
     {"a table (.csv)", {".csv"}, 1},
     {"a mesh (.ply)", {".ply"}, 1},
     {"a mesh (.stl)", {".stl"}, 1},
     {"a mesh (.obj, .glb, .gltf)", {".obj", ".glb", ".gltf"}, 3},
     {"a document (.pdf)", {".pdf"}, 1},
     {"a volume of samples (.nrrd, .nii, .dcm)", {".nrrd", ".nii", ".dcm"}, 3}}};

const KindOfFile& entry(FileKind kind) noexcept {
  return kKinds[static_cast<std::size_t>(kind)];
}

std::string_view without_space(std::string_view text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);  // skips the byte order mark
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.front()))) text.remove_prefix(1);
  return text;
}

bool is_json(std::string_view head) {
  const std::string_view text = without_space(head);
  return text.starts_with("{") || text.starts_with("[");
}

/// True for text: no PDF, and no control characters as in binary files.
bool is_text(std::string_view head) {
  if (head.starts_with("%PDF-")) return false;
  return std::none_of(head.begin(), head.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte < 0x20 && std::string_view("\t\n\r\f").find(c) == std::string_view::npos;
  });
}

/// True for text that is neither JSON, nor a web page, nor a mesh.
bool is_plain_text(std::string_view head) {
  return is_text(head) && !is_json(head) && !without_space(head).starts_with("<") && !head.starts_with("ply") &&
         !head.starts_with("solid");
}

/// True for a DICOM segmentation, found by its SOP class UID. Other DICOM files, such as scans, may not be overwritten.
bool is_dicom_segmentation(std::string_view head) {
  // kMagic: offset of the letters "DICM", bytes; kMeta: number of first bytes that are searched for the class UID
  constexpr std::size_t kMagic = 128, kMeta = 400;
  return head.size() > kMagic + 4 && head.substr(kMagic, 4) == "DICM" &&
         head.substr(0, kMeta).find("1.2.840.10008.5.1.4.1.1.66.4"sv) != std::string_view::npos;
}

bool holds(FileKind kind, std::string_view head, std::uintmax_t size) {
  const std::string start = lower_case(std::string(without_space(head.substr(0, 64))));
  switch (kind) {
    case FileKind::kText:
      return is_text(head);
    case FileKind::kCache:
      return true;
    case FileKind::kSession:
      return head.starts_with("\x89HDF\r\n\x1a\n");
    case FileKind::kVolume:
      return head.starts_with(" BDV\0\0\0\0"sv);
    case FileKind::kPicture:
      return head.starts_with("\x89PNG\r\n\x1a\n");
    case FileKind::kGreyPicture:
      return head.starts_with("P5");
    case FileKind::kSound:
      return head.starts_with("RIFF");
    case FileKind::kFilm:
      return head.size() >= 8 && head.substr(4, 4) == "ftyp";
    case FileKind::kPage:
      return start.starts_with("<!doctype html") || start.starts_with("<html");
    case FileKind::kDrawing:
      return start.starts_with("<svg") || start.starts_with("<?xml");
    case FileKind::kJson:
      return is_json(head);
    case FileKind::kTable:
      return is_plain_text(head);
    case FileKind::kPly:
      return head.starts_with("ply");
    case FileKind::kStl: {
      std::uint32_t triangles = 0;
      if (head.size() >= 84) std::memcpy(&triangles, head.data() + 80, sizeof triangles);
      return head.starts_with("solid") || size == 84 + std::uintmax_t{50} * triangles;
    }
    case FileKind::kObj:
      // An OBJ file, a binary glTF file, or a JSON glTF file that begins with "asset", as this program writes it.
      return is_plain_text(head) || head.starts_with("glTF") ||
             (is_json(head) && without_space(without_space(head).substr(1)).starts_with("\"asset\""));
    case FileKind::kDocument:
      return head.starts_with("%PDF-");
    case FileKind::kLabels:
      return head.starts_with("NRRD000") || (head.size() >= 348 && head.substr(344, 4) == "n+1\0"sv) ||
             is_dicom_segmentation(head);
  }
  return false;
}

}  // namespace

std::string_view name_of(FileKind kind) noexcept {
  return entry(kind).name;
}

std::span<const std::string_view> endings_of(FileKind kind) noexcept {
  return {entry(kind).endings.data(), entry(kind).endings_count};
}

FileKind kind_of_name(const std::filesystem::path& file, std::span<const FileKind> kinds) {
  const std::string ending = lower_case(file.extension().string());
  for (const FileKind kind : kinds) {
    const auto endings = endings_of(kind);
    if (std::find(endings.begin(), endings.end(), ending) != endings.end()) return kind;
  }
  return FileKind::kText;
}

FileKind kind_of_name(const std::filesystem::path& file) {
  std::array<FileKind, kKinds.size()> all;
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<FileKind>(i);
  return kind_of_name(file, all);
}

bool may_replace(FileKind kind, std::string_view head, std::uintmax_t size) {
  return size == 0 || holds(kind, head, size);
}

}  // namespace typodont
