#include <assimp/cfileio.h>
#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <unordered_map>

#include "engine/base/error.h"
#include "engine/base/late_library.h"
#include "engine/base/lower_case.h"
#include "engine/base/temporary_folder.h"
#include "engine/base/units.h"
#include "haptics/import/dicom/zip.h"
#include "haptics/import/mesh.h"
#include "haptics/import/mesh_repair.h"
#include "haptics/import/scan.h"

namespace typodont::haptics::importing {

namespace {

constinit LateLibrary assimp{TYPODONT_LATE_ASSIMP};
TYPODONT_LATE(assimp, aiGetErrorString, aiImportFileEx, aiImportFileFromMemory, aiReleaseImport)

// A mesh as it is in the file; equal corners may be separate points.
struct Soup {
  std::vector<std::array<float, 3>> points;
  std::vector<std::vector<std::size_t>> faces;
  std::vector<Color> colors;  // may be empty
};

std::uint8_t color_byte(double fraction) {
  return static_cast<std::uint8_t>(std::clamp(fraction, 0.0, 1.0) * 255 + 0.5);
}

// Reads PLY as text or binary. assimp does not check counts and indices of PLY.
class PlyReader {
 public:
  explicit PlyReader(const std::filesystem::path& file)
      : file_(file), bytes_(size_of_file(file)), in_(file, std::ios::binary) {}

  Soup read() {
    read_header();
    Soup soup;
    for (const Part& part : parts_) {
      for (std::size_t k = 0; k < part.count; ++k) {
        std::array<float, 3> point{};
        Color color{};
        bool colored = false;
        std::vector<std::size_t> face;
        for (const Property& p : part.properties) {
          std::size_t items = 1;
          if (p.list) {
            const double n = number(p.length, part, k);
            const double max_items = part.name == "tristrips" ? static_cast<double>(bytes_) : 255;
            if (!(n >= 0 && n <= max_items))
              fail(part, k, fmt::format("a list of {:g}", n), fmt::format("0 to {:g} items", max_items));
            items = static_cast<std::size_t>(n);
          }
          for (std::size_t i = 0; i < items; ++i) {
            const double value = number(p.type, part, k);
            if (p.axis >= 0) point[static_cast<std::size_t>(p.axis)] = static_cast<float>(value);
            if (p.color >= 0) {
              const bool bytes = p.type == Element::kUint8;
              color[static_cast<std::size_t>(p.color)] = color_byte(bytes ? value / 255 : value);
              colored = true;
            }
            if (!p.corners) continue;
            if (part.name == "tristrips" && value == -1) {
              add_strip(face, soup);
              face.clear();
            } else {
              face.push_back(value >= 0 && value < 1e15 ? static_cast<std::size_t>(value) : SIZE_MAX);
            }
          }
        }
        if (part.name == "vertex") soup.points.push_back(point);
        if (colored) soup.colors.push_back(color);
        if (part.name == "face") soup.faces.push_back(face);
        if (part.name == "tristrips") add_strip(face, soup);
      }
    }
    if (soup.colors.size() != soup.points.size()) soup.colors.clear();
    for (std::size_t f = 0; f < soup.faces.size(); ++f) {
      for (const std::size_t i : soup.faces[f]) {
        if (i < soup.points.size()) continue;
        throw Error(file_.string(), fmt::format("face {}", f), "the index of a vertex that is not there",
                    fmt::format("0 to {}", soup.points.size() - 1));
      }
    }
    return soup;
  }

 private:
  struct Property {
    Element type{}, length{};
    bool list = false, corners = false;
    int axis = -1, color = -1;
  };
  struct Part {
    std::string name;
    std::size_t count = 0;
    std::vector<Property> properties;
  };

  /// Adds a strip's triangles; every second one is reversed.
  static void add_strip(const std::vector<std::size_t>& strip, Soup& soup) {
    for (std::size_t k = 2; k < strip.size(); ++k)
      soup.faces.push_back({strip[k - 2 + k % 2], strip[k - 1 - k % 2], strip[k]});
  }

  [[noreturn]] void fail(const Part& part, std::size_t k, std::string_view found, std::string_view expected) const {
    throw Error(file_.string(), fmt::format("{} {}", part.name, k), found, expected);
  }

  double number(Element type, const Part& part, std::size_t k) {
    if (text_) {
      double value = 0;
      if (!(in_ >> value)) fail(part, k, in_.eof() ? "the end of the file" : "no number", "a number");
      return value;
    }
    std::vector<char> raw(bytes_of(type));
    if (!in_.read(raw.data(), static_cast<std::streamsize>(raw.size())))
      fail(part, k, "the end of the file", "a number");
    return static_cast<double>(decode(raw, 1, type, swap_)[0]);
  }

  void read_header() {
    static const std::map<std::string, Element> kTypes = {
        {"char", Element::kInt8},     {"uchar", Element::kUint8},   {"short", Element::kInt16},
        {"ushort", Element::kUint16}, {"int", Element::kInt32},     {"uint", Element::kUint32},
        {"float", Element::kFloat},   {"double", Element::kDouble}, {"int8", Element::kInt8},
        {"uint8", Element::kUint8},   {"int16", Element::kInt16},   {"uint16", Element::kUint16},
        {"int32", Element::kInt32},   {"uint32", Element::kUint32}, {"float32", Element::kFloat},
        {"float64", Element::kDouble}};
    std::string line;
    for (int n = 1; n <= 200; ++n) {
      if (read_line(in_, line, 4096) == EOF) break;
      if (!line.empty() && line.back() == '\r') line.pop_back();
      const auto bad = [&](std::string_view expected) {
        throw Error(file_.string(), fmt::format("line {}", n), excerpt(line), expected);
      };
      std::istringstream words(line);
      std::string word, name, type, item;
      words >> word;
      if (n == 1) {
        if (word != "ply") bad("ply");
      } else if (word == "end_header") {
        return;
      } else if (word == "format") {
        words >> name;
        if (name != "ascii" && name != "binary_little_endian" && name != "binary_big_endian")
          bad("ascii, binary_little_endian or binary_big_endian");
        text_ = name == "ascii";
        swap_ = (name == "binary_big_endian") == (std::endian::native == std::endian::little);
      } else if (word == "element") {
        long long count = -1;
        if (!(words >> name >> count) || count < 0 || static_cast<std::uintmax_t>(count) > bytes_)
          bad("element NAME COUNT, no more than the file can hold");
        parts_.push_back({name, static_cast<std::size_t>(count), {}});
      } else if (word == "property") {
        Property p;
        words >> type;
        p.list = type == "list";
        if (p.list) {
          words >> item >> type;
          if (!kTypes.contains(item)) bad("property list TYPE TYPE NAME");
          p.length = kTypes.at(item);
        }
        if (!kTypes.contains(type) || !(words >> name) || parts_.empty()) bad("property TYPE NAME, below an element");
        p.type = kTypes.at(type);
        if (parts_.back().name == "vertex" && name.size() == 1 && name[0] >= 'x' && name[0] <= 'z')
          p.axis = name[0] - 'x';
        for (int k = 0; k < 3; ++k) {
          if (parts_.back().name == "vertex" && !p.list &&
              name == std::array{"red", "green", "blue"}[static_cast<std::size_t>(k)])
            p.color = k;
        }
        p.corners = (parts_.back().name == "face" || parts_.back().name == "tristrips") && p.list &&
                    (name == "vertex_indices" || name == "vertex_index");
        parts_.back().properties.push_back(p);
      } else if (word != "comment" && word != "obj_info") {
        bad("format, comment, element, property or end_header");
      }
    }
    throw Error(file_.string(), "header", "no end_header", "a PLY header");
  }

  std::filesystem::path file_;
  std::uintmax_t bytes_;
  std::ifstream in_;
  std::vector<Part> parts_;
  bool text_ = true, swap_ = false;
};

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);  // byte order mark
  return text;
}

std::string percent_decoded(std::string_view uri) {
  std::string name;
  for (std::size_t k = 0; k < uri.size(); ++k) {
    unsigned byte = 0;
    const bool coded = uri[k] == '%' && k + 2 < uri.size() &&
                       std::from_chars(&uri[k + 1], &uri[k + 1] + 2, byte, 16).ptr == &uri[k + 1] + 2;
    name += coded ? static_cast<char>(byte) : uri[k];
    k += coded ? 2 : 0;
  }
  return name;
}

std::FILE* stream_of(aiFile* file) {
  return reinterpret_cast<std::FILE*>(file->UserData);
}

/// Opens, for reading, a file to which a mesh file refers. Its name may be percent-encoded ("tooth%201.bin"). nullptr:
/// there is no such file.
aiFile* open_named(aiFileIO*, const char* name, const char*) {
  std::FILE* stream = std::fopen(name, "rb");
  if (!stream) stream = std::fopen(percent_decoded(name).c_str(), "rb");
  if (!stream) return nullptr;
  return new aiFile{
      .ReadProc = [](aiFile* f, char* to, size_t size,
                     size_t count) { return std::fread(to, size, count, stream_of(f)); },
      .WriteProc = [](aiFile*, const char*, size_t, size_t) { return size_t{0}; },
      .TellProc = [](aiFile* f) { return static_cast<size_t>(std::ftell(stream_of(f))); },
      .FileSizeProc =
          [](aiFile* f) {
            const long at = std::ftell(stream_of(f));
            std::fseek(stream_of(f), 0, SEEK_END);
            const long size = std::ftell(stream_of(f));
            std::fseek(stream_of(f), at, SEEK_SET);
            return static_cast<size_t>(size);
          },
      .SeekProc =
          [](aiFile* f, size_t to, aiOrigin from) {
            const int origin = from == aiOrigin_SET ? SEEK_SET : from == aiOrigin_CUR ? SEEK_CUR : SEEK_END;
            return std::fseek(stream_of(f), static_cast<long>(to), origin) == 0 ? aiReturn_SUCCESS : aiReturn_FAILURE;
          },
      .FlushProc = [](aiFile*) {},
      .UserData = reinterpret_cast<char*>(stream)};
}

void close_named(aiFileIO*, aiFile* file) {
  std::fclose(stream_of(file));
  delete file;
}

/// Throws Error if glTF requires an extension that assimp ignores.
void check_gltf_extensions(const std::filesystem::path& file, bool binary) {
  std::string text = text_of(file);
  if (binary) {
    std::uint32_t length = 0;  // length of the JSON text behind the 20-byte header
    if (text.size() < 20) return;
    std::memcpy(&length, &text[12], sizeof length);
    text = text.substr(20, length);
  }
  const auto json = nlohmann::json::parse(text, nullptr, false);
  const auto required = json.is_object() ? json.find("extensionsRequired") : json.end();
  if (required == json.end() || !required->is_array()) return;
  for (const auto& extension : *required) {
    const std::string name = extension.is_string() ? extension.get<std::string>() : extension.dump();
    // These extensions change only materials and lights.
    if (name.starts_with("KHR_materials_") || name == "KHR_texture_transform" || name == "KHR_lights_punctual")
      continue;
    throw Error(file.string(), "extensionsRequired", name, "a glTF file without compressed or quantized triangles");
  }
}

/// Returns the millimetres per unit that a 3MF file states.
double unit_of_3mf(const std::filesystem::path& file) {
  const TemporaryFolder folder;
  for (const auto& part : unzip(file, folder.path())) {
    const std::string text = text_of(part);
    const std::size_t model = text.find("<model"), end = text.find('>', model), unit = text.find(" unit=", model);
    if (model == std::string::npos || unit >= end) continue;
    const std::size_t from = unit + 7, to = text.find_first_of("\"'", from);
    const std::string name = text.substr(from, std::min(to, text.size()) - from);
    const auto factor = millimetres_per(name);
    if (!factor)
      throw Error(file.string(), "unit", excerpt(name), "micron, millimeter, centimeter, inch, foot or meter");
    return *factor;
  }
  return 1;
}

/// Rewrites STL or OBJ text as assimp can read it; nullopt: binary, or nothing to change.
std::optional<std::string> plain_text(const std::filesystem::path& file, const std::string& extension) {
  if (extension == ".obj") {
    std::string text = text_of(file), plain;
    for (std::size_t from = 0; from < text.size();) {
      const std::size_t end = std::min(text.find('\n', from), text.size());
      plain.append(text, from, std::min(text.find('#', from), end) - from);
      plain += '\n';
      from = end + 1;
    }
    return plain;
  }
  if (extension != ".stl") return std::nullopt;
  const std::uintmax_t size = size_of_file(file);
  std::ifstream in(file, std::ios::binary);
  std::uint32_t count = 0;
  in.seekg(80);
  in.read(reinterpret_cast<char*>(&count), sizeof count);
  if (in && size >= 84 + 50ULL * count && !(count == 0 && size > 84)) return std::nullopt;
  std::string text = lower_case(text_of(file));
  if (text.substr(0, 80).find("solid") == text.find_first_not_of(" \t\r\n") && text.find("facet") != std::string::npos)
    return text.substr(text.find("solid"));
  throw Error(file.string(), "number of triangles at byte 80", fmt::format("{} in {} bytes", in ? count : 0, size),
              "50 bytes for each triangle");
}

Soup read_with_assimp(const std::filesystem::path& file) {
  const std::string extension = lower_case(file.extension().string());
  if (extension == ".gltf" || extension == ".glb") check_gltf_extensions(file, extension == ".glb");
  // unit_of_3mf() also finds damaged archives, which would make assimp abort.
  const auto unit = static_cast<float>(extension == ".3mf" ? unit_of_3mf(file) : 1);
  static std::mutex one_at_a_time;  // assimp has one error text for all threads
  const std::lock_guard lock(one_at_a_time);
  aiFileIO files{.OpenProc = open_named, .CloseProc = close_named, .UserData = nullptr};
  constexpr unsigned kSteps = aiProcess_Triangulate | aiProcess_PreTransformVertices | aiProcess_SortByPType;
  const auto text = plain_text(file, extension);
  const std::unique_ptr<const aiScene, void (*)(const aiScene*)> scene(
      text ? aiImportFileFromMemory(text->data(), static_cast<unsigned>(text->size()), kSteps, extension.c_str() + 1)
           : aiImportFileEx(file.c_str(), kSteps, &files),
      aiReleaseImport);
  if (!scene || scene->mNumMeshes == 0) {
    const std::string why = scene ? "" : aiGetErrorString();
    throw Error(file.string(), "mesh", why.empty() ? "no triangles" : why, "a readable STL, OBJ, glTF or 3MF file");
  }
  Soup soup;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& part = *scene->mMeshes[m];
    if (!(part.mPrimitiveTypes & aiPrimitiveType_TRIANGLE)) continue;
    const std::size_t base = soup.points.size();
    for (unsigned i = 0; i < part.mNumVertices; ++i) {
      soup.points.push_back({unit * part.mVertices[i].x, unit * part.mVertices[i].y, unit * part.mVertices[i].z});
      if (part.mColors[0]) {
        const aiColor4D& c = part.mColors[0][i];
        soup.colors.push_back({color_byte(c.r), color_byte(c.g), color_byte(c.b)});
      }
    }
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      std::vector<std::size_t> face;
      for (unsigned k = 0; k < part.mFaces[f].mNumIndices; ++k) {
        if (part.mFaces[f].mIndices[k] >= part.mNumVertices) {
          throw Error(file.string(), fmt::format("face {}", f), "the index of a vertex that is not there",
                      fmt::format("below {}", part.mNumVertices));
        }
        face.push_back(base + part.mFaces[f].mIndices[k]);
      }
      soup.faces.push_back(face);
    }
  }
  if (soup.colors.size() != soup.points.size()) soup.colors.clear();
  return soup;
}

/// Merges points that are within a small distance.
class Welder {
 public:
  Welder(double tolerance, Mesh& mesh) : tolerance_(tolerance), cell_(16 * tolerance), mesh_(mesh) {}

  /// Returns the index of the point. `moved`: it was merged with a point at another position.
  int add(const glm::dvec3& p, bool& moved) {
    const Cell lo = cell_of(p - tolerance_), hi = cell_of(p + tolerance_);
    for (std::int64_t x = lo[0]; x <= hi[0]; ++x) {
      for (std::int64_t y = lo[1]; y <= hi[1]; ++y) {
        for (std::int64_t z = lo[2]; z <= hi[2]; ++z) {
          const auto [first, last] = cells_.equal_range({x, y, z});
          for (auto it = first; it != last; ++it) {
            const glm::dvec3 off = mesh_.point(it->second) - p;
            if (glm::dot(off, off) > tolerance_ * tolerance_) continue;
            moved = off != glm::dvec3(0);
            return it->second;
          }
        }
      }
    }
    const int number = static_cast<int>(mesh_.points.size());
    mesh_.points.push_back(p);
    cells_.emplace(cell_of(p), number);
    moved = false;
    return number;
  }

 private:
  using Cell = std::array<std::int64_t, 3>;
  struct Hash {
    std::size_t operator()(const Cell& c) const {
      std::uint64_t h = 0;
      for (const std::int64_t k : c) h = (h ^ static_cast<std::uint64_t>(k)) * 0x9E3779B97F4A7C15U, h ^= h >> 29;
      return h;
    }
  };
  Cell cell_of(const glm::dvec3& p) const {
    Cell c;
    for (int a = 0; a < 3; ++a) c[static_cast<std::size_t>(a)] = static_cast<std::int64_t>(std::floor(p[a] / cell_));
    return c;
  }

  double tolerance_, cell_;
  Mesh& mesh_;
  std::unordered_multimap<Cell, int, Hash> cells_;
};

}  // namespace

Mesh read_surface(const std::filesystem::path& file, double unit, MeshRepairs& repairs) {
  if (size_of_file(file) == 0) throw Error(file.string(), "", "an empty file", "a mesh");
  const Soup soup = lower_case(file.extension().string()) == ".ply" ? PlyReader(file).read() : read_with_assimp(file);
  Mesh mesh;
  glm::dvec3 lo(1e300), hi(-1e300);
  for (std::size_t i = 0; i < soup.points.size(); ++i) {
    const auto& p = soup.points[i];
    if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2])) {
      throw Error(file.string(), fmt::format("vertex {}", i), fmt::format("({}, {}, {})", p[0], p[1], p[2]),
                  "finite coordinates");
    }
    lo = glm::min(lo, glm::dvec3(p[0], p[1], p[2]));
    hi = glm::max(hi, glm::dvec3(p[0], p[1], p[2]));
  }
  const double diagonal = soup.points.empty() ? 0 : unit * glm::length(hi - lo);
  if (!(diagonal > 0 && diagonal < 1e6)) throw Error(file.string(), "mesh", "no triangles", "a surface");
  // Equal corners become one point, even if their normals or texture coordinates differ.
  Welder welder(std::min(kWeldShare * diagonal, kWeldMost), mesh);
  std::vector<int> index(soup.points.size());
  for (std::size_t i = 0; i < soup.points.size(); ++i) {
    const auto& p = soup.points[i];
    bool moved = false;
    const std::size_t before = mesh.points.size();
    index[i] = welder.add(unit * glm::dvec3(p[0], p[1], p[2]), moved);
    repairs.welded += moved;
    if (moved) repairs.places.push_back(mesh.point(index[i]));
    if (mesh.points.size() > before && !soup.colors.empty()) mesh.colors.push_back(soup.colors[i]);
  }
  for (const auto& face : soup.faces) {
    for (std::size_t k = 2; k < face.size(); ++k) {  // divides the polygon into a fan of triangles
      const std::array<int, 3> c = {index[face[0]], index[face[k - 1]], index[face[k]]};
      if (c[0] != c[1] && c[1] != c[2] && c[2] != c[0])
        mesh.corners.push_back(c);
      else
        ++repairs.collapsed;
    }
  }
  if (mesh.corners.empty()) throw Error(file.string(), "mesh", "no triangles", "a surface");
  return mesh;
}

Mesh read_mesh(const std::filesystem::path& file, double unit, MeshRepairs& repairs) {
  // Longest border of a small hole, m; the hole is then about 2 mm wide.
  constexpr double kSmallHole = 6e-3;
  Mesh mesh = read_surface(file, unit, repairs);
  drop_copies(mesh, repairs);
  orient(mesh, repairs);
  close_holes(mesh, kSmallHole, repairs);
  std::size_t open = 0;
  double longest = 0;
  glm::dvec3 at(0);
  const std::vector<Border> left = borders(mesh);
  for (const Border& border : left) {
    open += border.points.size();
    if (border.length <= longest) continue;
    longest = border.length;
    at = mesh.point(border.points[0]) / unit;
  }
  if (open > 0) {
    throw Error(file.string(), fmt::format("edge at ({:g}, {:g}, {:g})", at.x, at.y, at.z),
                fmt::format("{} open edges around {} holes, the largest with a border of {:.3g} mm", open, left.size(),
                            longest / kMillimetre),
                fmt::format("a closed surface, or holes with a border of at most {:g} mm; an intraoral scan: --preset "
                            "arch",
                            kSmallHole / kMillimetre));
  }
  turn_shells(mesh, repairs);
  return mesh;
}

}  // namespace typodont::haptics::importing
