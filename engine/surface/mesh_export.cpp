#include "engine/surface/mesh_export.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "engine/base/base64.h"
#include "engine/base/error.h"
#include "engine/base/json.h"
#include "engine/base/lower_case.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"

namespace typodont::surface {
namespace {

static_assert(std::endian::native == std::endian::little, "binary PLY and STL are written in the machine's order");

template <class... Values>
void append(std::string& out, const Values&... values) {
  (out.append(reinterpret_cast<const char*>(&values), sizeof values), ...);
}

glm::vec3 millimetres(const glm::vec3& position, const VoxelFrame& frame) {
  return glm::vec3(frame.to_world(glm::dvec3(position)) / kMillimetre);
}

glm::dvec3 color_of(const MaterialTable& materials, const WholeMesh::Vertex& v) {
  const glm::dvec4 paint(v.paint);
  return glm::mix(materials[static_cast<std::size_t>(v.tissue)].color, glm::dvec3(paint), paint.w);
}

std::array<std::uint8_t, 3> rgb(const MaterialTable& materials, const WholeMesh::Vertex& v) {
  const glm::dvec3 color = color_of(materials, v);
  auto byte = [](double c) { return static_cast<std::uint8_t>(std::lround(255 * std::clamp(c, 0.0, 1.0))); };
  return {byte(color.x), byte(color.y), byte(color.z)};
}

std::string ply(const WholeMesh& mesh, const VoxelFrame& frame, const MaterialTable& materials) {
  std::string labels;
  for (int t = 0; t < kTissueCount; ++t) {
    labels += fmt::format("comment tissue {} {}\n", t, name_of(static_cast<Tissue>(t)));
  }
  std::string out = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment Typodont, millimetres\n{}element vertex {}\nproperty float x\n"
      "property float y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar tissue\n"
      "element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
      labels, mesh.vertices.size(), mesh.triangles.size());
  out.reserve(out.size() + 28 * mesh.vertices.size() + 13 * mesh.triangles.size());
  for (const auto& v : mesh.vertices)
    append(out, millimetres(v.position, frame), v.normal, rgb(materials, v), v.tissue);
  for (const auto& triangle : mesh.triangles) append(out, std::uint8_t{3}, triangle);
  return out;
}

std::string stl(const WholeMesh& mesh, const VoxelFrame& frame) {
  std::string out(80, ' ');
  const std::string title = "Typodont, millimetres";
  out.replace(0, title.size(), title);
  append(out, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const auto& triangle : mesh.triangles) {
    glm::vec3 p[3];
    for (int i = 0; i < 3; ++i)
      p[i] = millimetres(mesh.vertices[triangle[static_cast<std::size_t>(i)]].position, frame);
    const glm::vec3 n = glm::cross(p[1] - p[0], p[2] - p[0]);
    const float length = glm::length(n);
    append(out, length > 0 ? n / length : glm::vec3(0), p, std::uint16_t{0});
  }
  return out;
}

std::string obj(const WholeMesh& mesh, const VoxelFrame& frame, const MaterialTable& materials) {
  std::string out = "# Typodont, millimetres; vertex colours after the coordinates\n";
  for (const auto& v : mesh.vertices) {
    const glm::vec3 p = millimetres(v.position, frame);
    const glm::dvec3 c = color_of(materials, v);
    out += fmt::format("v {} {} {} {:.4g} {:.4g} {:.4g}\n", p.x, p.y, p.z, c.x, c.y, c.z);
  }
  for (const auto& v : mesh.vertices) {
    out += fmt::format("vn {:.5f} {:.5f} {:.5f}\n", v.normal.x, v.normal.y, v.normal.z);
  }
  for (const auto& t : mesh.triangles) {
    out += fmt::format("f {0}//{0} {1}//{1} {2}//{2}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  }
  return out;
}

/// A glTF file: its JSON without the location of the buffer, and the buffer.
struct Gltf {
  nlohmann::ordered_json json;
  std::string buffer;
};

Gltf gltf(const WholeMesh& mesh, const VoxelFrame& frame, const MaterialTable& materials) {
  // codes of component types and buffer targets in glTF 2.0
  constexpr int kByte = 5121, kUint32 = 5125, kFloat = 5126, kVertices = 34962, kIndices = 34963;
  Gltf made;
  std::string& buffer = made.buffer;
  buffer.reserve(28 * mesh.vertices.size() + 12 * mesh.triangles.size());
  glm::vec3 lo(std::numeric_limits<float>::max()), hi(-lo);
  for (const auto& v : mesh.vertices) {
    const glm::vec3 p(frame.to_world(glm::dvec3(v.position)));
    lo = glm::min(lo, p), hi = glm::max(hi, p);
    append(buffer, p);
  }
  const std::size_t normals = buffer.size();
  for (const auto& v : mesh.vertices) append(buffer, v.normal);
  const std::size_t colours = buffer.size();
  for (const auto& v : mesh.vertices) {
    const auto [r, g, b] = rgb(materials, v);
    append(buffer, std::array<std::uint8_t, 4>{r, g, b, 255});
  }
  const std::size_t indices = buffer.size();
  for (const auto& triangle : mesh.triangles) append(buffer, triangle);

  nlohmann::ordered_json& j = made.json;
  j["asset"] = {{"version", "2.0"}, {"generator", "Typodont"}};
  j["scene"] = 0;
  j["scenes"] = {{{"nodes", {0}}}};
  j["nodes"] = {{{"mesh", 0}}};
  j["meshes"] = {
      {{"primitives", {{{"attributes", {{"POSITION", 0}, {"NORMAL", 1}, {"COLOR_0", 2}}}, {"indices", 3}}}}}};
  const auto view = [&](std::size_t from, std::size_t to, int target) {
    j["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", from}, {"byteLength", to - from}, {"target", target}});
  };
  view(0, normals, kVertices), view(normals, colours, kVertices), view(colours, indices, kVertices);
  view(indices, buffer.size(), kIndices);
  const std::size_t n = mesh.vertices.size();
  j["accessors"] = {
      {{"bufferView", 0},
       {"componentType", kFloat},
       {"count", n},
       {"type", "VEC3"},
       {"min", {lo.x, lo.y, lo.z}},
       {"max", {hi.x, hi.y, hi.z}}},
      {{"bufferView", 1}, {"componentType", kFloat}, {"count", n}, {"type", "VEC3"}},
      {{"bufferView", 2}, {"componentType", kByte}, {"normalized", true}, {"count", n}, {"type", "VEC4"}},
      {{"bufferView", 3}, {"componentType", kUint32}, {"count", 3 * mesh.triangles.size()}, {"type", "SCALAR"}}};
  j["buffers"] = {{{"byteLength", buffer.size()}}};
  return made;
}

/// Returns a .glb file: a header and two chunks, whose lengths are multiples of 4.
std::string glb(const Gltf& gltf) {
  constexpr std::uint32_t kVersion = 2, kJson = 0x4e4f534a, kBinary = 0x004e4942;
  std::string json = gltf.json.dump();
  json.resize((json.size() + 3) / 4 * 4, ' ');
  std::string out = "glTF";
  append(out, kVersion, static_cast<std::uint32_t>(12 + 8 + json.size() + 8 + gltf.buffer.size()));
  append(out, static_cast<std::uint32_t>(json.size()), kJson);
  out += json;
  append(out, static_cast<std::uint32_t>(gltf.buffer.size()), kBinary);
  return out + gltf.buffer;
}

std::string gltf_text(Gltf gltf) {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(gltf.buffer.data());
  gltf.json["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64({bytes, gltf.buffer.size()});
  return gltf.json.dump(1) + "\n";
}

}  // namespace

WholeMesh weld(const SurfaceMesher& mesher) {
  constexpr std::uint32_t kNone = 0xffffffff;
  // for each brick: indices of its points in the file
  std::map<glm::ivec3, std::vector<std::uint32_t>, LessByAxes> number;
  WholeMesh whole;
  std::vector<std::uint32_t> joined;
  for (const glm::ivec3& key : mesher.keys()) {
    const BrickMesh& mesh = *mesher.find(key);
    joined.clear();
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      const int o = mesh.owner[i];
      std::vector<std::uint32_t>& points = number[key - glm::ivec3(o & 1, o >> 1 & 1, o >> 2)];
      if (points.size() <= mesh.point[i]) points.resize(mesh.point[i] + std::size_t{1}, kNone);
      std::uint32_t& n = points[mesh.point[i]];
      const SurfaceVertex& v = mesh.vertices[i];
      if (n == kNone) {
        n = static_cast<std::uint32_t>(whole.vertices.size());
        whole.vertices.push_back({v.position, glm::vec3(0), v.tissue[v.second > 127], {}});
      }
      whole.vertices[n].normal += v.normal;
      joined.push_back(n);
    }
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
      whole.triangles.push_back({joined[mesh.indices[i]], joined[mesh.indices[i + 1]], joined[mesh.indices[i + 2]]});
    }
  }
  for (auto& v : whole.vertices) {
    const float length = glm::length(v.normal);
    v.normal = length > 1e-6f ? v.normal / length : glm::vec3(0, 0, 1);
  }
  return whole;
}

void require_mesh_format(const std::filesystem::path& file) {
  constexpr std::array kKinds{FileKind::kPly, FileKind::kStl, FileKind::kObj};
  if (kind_of_name(file, kKinds) == FileKind::kText)
    throw Error(file.string(), "extension", "\"" + file.extension().string() + "\"", ".ply, .stl, .obj, .glb or .gltf");
}

void write_mesh(const std::filesystem::path& file, const WholeMesh& mesh, const VoxelFrame& frame,
                const MaterialTable& materials, Over over) {
  require_mesh_format(file);
  const std::string format = lower_case(file.extension().string());
  if (format == ".ply") {
    write_file_atomically(file, ply(mesh, frame, materials), FileKind::kPly, over);
  } else if (format == ".stl") {
    write_file_atomically(file, stl(mesh, frame), FileKind::kStl, over);
  } else if (format == ".obj") {
    write_file_atomically(file, obj(mesh, frame, materials), FileKind::kObj, over);
  } else {
    Gltf made = gltf(mesh, frame, materials);
    // .glb files have 32-bit lengths.
    constexpr std::size_t kMost = 0xf0000000;
    if (made.buffer.size() > kMost)
      throw Error(file.string(), "", fmt::format("{} bytes of triangles", made.buffer.size()),
                  fmt::format("at most {} bytes in a glTF file; a .ply file has no such limit", kMost));
    write_file_atomically(file, format == ".glb" ? glb(made) : gltf_text(std::move(made)), FileKind::kObj, over);
  }
}

}  // namespace typodont::surface
