#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <assimp/Importer.hpp>
#include <bit>
#include <cctype>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "haptics/import/import_scan.h"
#include "haptics/import/mesh.h"
#include "haptics/import/scan.h"

namespace typodont::haptics::importing {

namespace {

// Polygons as a file has them: corners at the same place may be several points.
struct Soup {
  std::vector<std::array<float, 3>> points;
  std::vector<std::vector<std::size_t>> faces;
};

std::string lower_extension(const std::filesystem::path& file) {
  std::string e = file.extension().string();
  std::transform(e.begin(), e.end(), e.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return e;
}

// PLY, text or binary. assimp's reader trusts counts and indices: broken files crash it or keep it busy for minutes.
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
        std::vector<std::size_t> face;
        for (const Property& p : part.properties) {
          std::size_t items = 1;
          if (p.list) {
            const double n = number(p.length, part, k);
            if (!(n >= 0 && n <= 255)) fail(part, k, fmt::format("a list of {:g}", n), "0 to 255 items");
            items = static_cast<std::size_t>(n);
          }
          for (std::size_t i = 0; i < items; ++i) {
            const double value = number(p.type, part, k);
            if (p.axis >= 0) point[static_cast<std::size_t>(p.axis)] = static_cast<float>(value);
            if (p.corners) face.push_back(value >= 0 && value < 1e15 ? static_cast<std::size_t>(value) : SIZE_MAX);
          }
        }
        if (part.name == "vertex") soup.points.push_back(point);
        if (part.name == "face") soup.faces.push_back(face);
      }
    }
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
    int axis = -1;
  };
  struct Part {
    std::string name;
    std::size_t count = 0;
    std::vector<Property> properties;
  };

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
      line.clear();
      int c = in_.get();
      for (; c != EOF && c != '\n' && line.size() < 4096; c = in_.get()) line += static_cast<char>(c);
      if (c == EOF) break;
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
        p.corners = parts_.back().name == "face" && p.list && (name == "vertex_indices" || name == "vertex_index");
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

Soup read_with_assimp(const std::filesystem::path& file) {
  if (lower_extension(file) == ".stl") {
    std::ifstream in(file, std::ios::binary);
    std::string head(5, '\0');
    in.read(head.data(), 5);
    std::uint32_t count = 0;
    in.seekg(80);
    in.read(reinterpret_cast<char*>(&count), sizeof count);
    if (head != "solid" && (!in || size_of_file(file) < 84 + 50ULL * count)) {
      throw Error(file.string(), "number of triangles at byte 80",
                  fmt::format("{} in {} bytes", in ? count : 0, size_of_file(file)), "50 bytes for each triangle");
    }
  }
  Assimp::Importer importer;
  const aiScene* scene =
      importer.ReadFile(file.string(), aiProcess_Triangulate | aiProcess_PreTransformVertices | aiProcess_SortByPType);
  if (!scene || scene->mNumMeshes == 0) {
    const std::string why = importer.GetErrorString();
    throw Error(file.string(), "mesh", why.empty() ? "no triangles" : why, "a readable STL, OBJ or glTF file");
  }
  Soup soup;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& part = *scene->mMeshes[m];
    if (!(part.mPrimitiveTypes & aiPrimitiveType_TRIANGLE)) continue;
    const std::size_t base = soup.points.size();
    for (unsigned i = 0; i < part.mNumVertices; ++i) {
      soup.points.push_back({part.mVertices[i].x, part.mVertices[i].y, part.mVertices[i].z});
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
  return soup;
}

}  // namespace

Mesh read_surface(const std::filesystem::path& file, double unit, std::size_t& collapsed) {
  if (size_of_file(file) == 0) throw Error(file.string(), "", "an empty file", "a mesh");
  const Soup soup = lower_extension(file) == ".ply" ? PlyReader(file).read() : read_with_assimp(file);
  Mesh mesh;
  // Corners at the same place are one point, whatever their normals and texture say.
  std::map<std::array<float, 3>, int> known;
  std::vector<int> index(soup.points.size());
  for (std::size_t i = 0; i < soup.points.size(); ++i) {
    const auto& p = soup.points[i];
    if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2])) {
      throw Error(file.string(), fmt::format("vertex {}", i), fmt::format("({}, {}, {})", p[0], p[1], p[2]),
                  "finite coordinates");
    }
    const auto [it, fresh] =
        known.try_emplace({p[0] + 0.0F, p[1] + 0.0F, p[2] + 0.0F}, static_cast<int>(mesh.points.size()));
    if (fresh) mesh.points.push_back(unit * dvec3(p[0], p[1], p[2]));
    index[i] = it->second;
  }
  for (const auto& face : soup.faces) {
    for (std::size_t k = 2; k < face.size(); ++k) {  // a fan
      const std::array<int, 3> c = {index[face[0]], index[face[k - 1]], index[face[k]]};
      if (c[0] != c[1] && c[1] != c[2] && c[2] != c[0])
        mesh.corners.push_back(c);
      else
        ++collapsed;
    }
  }
  if (mesh.corners.empty()) throw Error(file.string(), "mesh", "no triangles", "a surface");
  return mesh;
}

Mesh read_mesh(const std::filesystem::path& file, double unit) {
  std::size_t collapsed = 0;
  Mesh mesh = read_surface(file, unit, collapsed);
  std::map<std::pair<int, int>, int> edges;
  for (const auto& c : mesh.corners) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = c[k], b = c[(k + 1) % 3];
      ++edges[{std::min(a, b), std::max(a, b)}];
    }
  }
  std::size_t open = 0;
  dvec3 first(0);
  for (const auto& [edge, times] : edges) {
    if (times % 2 == 0) continue;
    if (open++ == 0) first = mesh.points[static_cast<std::size_t>(edge.first)] / unit;
  }
  if (open > 0) {
    throw Error(file.string(), fmt::format("edge at ({:g}, {:g}, {:g})", first.x, first.y, first.z),
                fmt::format("{} open edges of {}", open, edges.size()), "a closed surface");
  }
  return mesh;
}

namespace {

// Triangles of the shells that bound the body from outside, and of those that lie within it (a pulp chamber, say).
struct Shells {
  std::vector<Triangle> outer, inner;
};

Shells shells_of(const Mesh& mesh, const std::vector<Triangle>& triangles) {
  // Shells are what hangs together over shared points.
  std::vector<int> root(mesh.points.size());
  for (std::size_t i = 0; i < root.size(); ++i) root[i] = static_cast<int>(i);
  const auto find = [&](int i) {
    while (root[static_cast<std::size_t>(i)] != i) {
      root[static_cast<std::size_t>(i)] = root[static_cast<std::size_t>(root[static_cast<std::size_t>(i)])];
      i = root[static_cast<std::size_t>(i)];
    }
    return i;
  };
  for (const auto& c : mesh.corners) {
    root[static_cast<std::size_t>(find(c[1]))] = find(c[0]);
    root[static_cast<std::size_t>(find(c[2]))] = find(c[0]);
  }
  std::map<int, std::vector<std::size_t>> members;
  for (std::size_t t = 0; t < mesh.corners.size(); ++t) members[find(mesh.corners[t][0])].push_back(t);
  Shells shells;
  constexpr std::size_t kMost = 200;  // more are fragments rather than shells
  for (const auto& [shell, own] : members) {
    // Within the others when a ray from one of its points meets them an odd number of times.
    const dvec3 from = triangles[own.front()].a, along = glm::normalize(dvec3(0.5773, 0.2113, 0.7886));
    std::size_t crossings = 0;
    for (std::size_t t = 0; members.size() <= kMost && t < triangles.size(); ++t) {
      if (find(mesh.corners[t][0]) == shell) continue;
      // Moeller & Trumbore 1997.
      const Triangle& tri = triangles[t];
      const dvec3 e1 = tri.b - tri.a, e2 = tri.c - tri.a, h = glm::cross(along, e2);
      const double det = glm::dot(e1, h);
      if (std::abs(det) < 1e-300) continue;
      const dvec3 s = from - tri.a, q = glm::cross(s, e1);
      const double u = glm::dot(s, h) / det, v = glm::dot(along, q) / det;
      crossings += u >= 0 && v >= 0 && u + v <= 1 && glm::dot(e2, q) / det > 0;
    }
    auto& into = crossings % 2 ? shells.inner : shells.outer;
    for (const std::size_t t : own) into.push_back(triangles[t]);
  }
  return shells;
}

}  // namespace

Imported import_mesh(const std::filesystem::path& file, const ImportOptions& options) {
  const bool tooth = options.preset == ImportPreset::kTooth;
  if (!(options.mesh_unit > 0) || !std::isfinite(options.mesh_unit)) {
    throw Error("--unit-mm", "", fmt::format("{:g}", options.mesh_unit / kMillimetre),
                "millimetres per unit of the mesh, above 0");
  }
  const Mesh mesh = read_mesh(file, options.mesh_unit);
  dvec3 lo(1e300), hi(-1e300);
  for (const dvec3& p : mesh.points) {
    lo = glm::min(lo, p);
    hi = glm::max(hi, p);
  }
  const dvec3 extent = hi - lo;
  const double longest = std::max({extent.x, extent.y, extent.z});
  const double least = tooth ? 1e-3 : 3e-3, most = tooth ? 60e-3 : 0.6;
  if (!(longest >= least && longest <= most)) {
    throw Error(
        file.string(), "size",
        fmt::format("a body {:.4g} mm long at {:g} mm a unit", longest / kMillimetre, options.mesh_unit / kMillimetre),
        fmt::format("{} of {:g} to {:g} mm; say what its unit is (--unit-mm)", tooth ? "a tooth" : "a bone",
                    least / kMillimetre, most / kMillimetre));
  }
  const double voxel = options.voxel.value_or(0.1e-3);
  check_result_size(extent + 2 * options.band + 6 * voxel, voxel);

  Imported result;
  result.report.format = file.extension().string().substr(1);
  DenseTissue& out = result.tissue;
  out.band = options.band;
  const double margin = options.band + 2 * voxel;
  out.frame.voxel = voxel;
  out.frame.origin = voxel * glm::floor((lo - margin) / voxel);
  out.size = glm::ivec3(glm::ceil((hi + margin - out.frame.origin) / voxel)) + 1;
  std::vector<Triangle> triangles;
  for (const auto& c : mesh.corners) {
    const auto at = [&](std::size_t k) { return out.frame.to_voxels(mesh.points[static_cast<std::size_t>(c[k])]); };
    triangles.push_back({at(0), at(1), at(2)});
  }
  if (options.progress) options.progress(0.2);

  // A tooth by depth: enamel of `shell` on the crown, thinning out over its lowest 2.5 mm; a pulp chamber where the
  // surface is more than 3 mm away, or where the mesh has a hollow. Bone: a cortical shell.
  constexpr double kPulpDepth = 3e-3, kTaper = 2.5e-3, kCrownShare = 0.42;
  const double shell = options.shell.value_or(tooth ? 1.3e-3 : 1.5e-3);
  if (!(shell >= 0 && shell <= 0.5 * longest)) {
    throw Error("--shell-mm", "", fmt::format("{:g}", shell / kMillimetre),
                fmt::format("0 to {:.3g} mm", 0.5 * longest / kMillimetre));
  }
  const double deepest = std::max({options.band, shell + 2 * voxel, tooth ? kPulpDepth + 2 * voxel : 0.0});
  const Shells shells = shells_of(mesh, triangles);
  const DistanceField field = signed_distance(shells.outer, out.size, deepest / voxel);
  const Mask hollow = inside_of(shells.inner, out.size);
  if (options.progress) options.progress(0.8);

  // The crown lies at that end of the longest axis where the body is wider.
  const int axis = extent.x == longest ? 0 : extent.y == longest ? 1 : 2;
  double below = 0, above = 0;
  const double middle = 0.5 * (lo[axis] + hi[axis]);
  for (std::size_t i = 0; i < field.distance.v.size(); ++i) {
    if (field.distance.v[i] >= 0) continue;
    (out.frame.to_world(dvec3(field.distance.place(i)))[axis] > middle ? above : below) += 1;
  }
  if (above + below < 8) {
    throw Error(file.string(), "size", fmt::format("a body of {:.0f} voxels", above + below),
                "a body thicker than --voxel-mm");
  }
  const double crown_end = above >= below ? hi[axis] : lo[axis];
  const double margin_of_crown = crown_end + (above >= below ? -1 : 1) * kCrownShare * extent[axis];
  out.distance.resize(field.distance.v.size());
  out.tissue.assign(out.distance.size(), Tissue::kAir);
  for (std::size_t i = 0; i < out.distance.size(); ++i) {
    const double d = static_cast<double>(field.distance.v[i]) * voxel;
    out.distance[i] = static_cast<float>(std::clamp(d, -out.band, out.band));
    if (d > 2.5 * voxel) continue;
    const double depth = std::max(-d, 0.0);
    if (!tooth) {
      out.tissue[i] = depth < shell || shell == 0 ? Tissue::kCorticalBone : Tissue::kCancellousBone;
      continue;
    }
    const double up =
        (out.frame.to_world(dvec3(field.distance.place(i)))[axis] - margin_of_crown) * (above >= below ? 1 : -1);
    const double enamel = shell * std::clamp(up / kTaper, 0.0, 1.0);
    const bool pulp = shells.inner.empty() ? depth > kPulpDepth : hollow.v[i] != 0;
    out.tissue[i] = pulp ? Tissue::kPulp : depth < enamel ? Tissue::kEnamel : Tissue::kDentin;
  }
  Mask solid(out.size, 0), pulp(out.size, 0);
  for (std::size_t i = 0; i < out.distance.size(); ++i) {
    solid.v[i] = out.distance[i] <= 0;
    pulp.v[i] = solid.v[i] && out.tissue[i] == Tissue::kPulp;
  }
  result.report.bodies_kept = result.report.bodies_found = static_cast<int>(components(solid, true).voxels.size()) - 1;
  result.report.pulp_parts = static_cast<int>(components(pulp, true).voxels.size()) - 1;
  if (tooth)
    result.report.notes.push_back(shells.inner.empty()
                                      ? "tissues are told by depth below the surface; root canals are not"
                                      : "enamel is told by depth below the surface, pulp by the mesh's hollows");
  return result;
}

}  // namespace typodont::haptics::importing
