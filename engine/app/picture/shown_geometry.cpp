#include "engine/app/picture/shown_geometry.h"

#include <fmt/format.h>

#include <string>

#include "engine/base/json.h"
#include "engine/base/units.h"
#include "engine/render/drawn_matter.h"
#include "engine/render/srgb.h"

namespace typodont {

namespace {

template <class... Values>
void append(std::string& out, const Values&... values) {
  (out.append(reinterpret_cast<const char*>(&values), sizeof values), ...);
}

glm::vec3 millimetres(const dvec3& metres) {
  return glm::vec3(metres / kMillimetre);
}

}  // namespace

void ShownGeometry::add_triangles(std::span<const std::uint32_t> indices, std::size_t first) {
  for (const std::uint32_t i : indices) indices_.push_back(static_cast<std::uint32_t>(first + i));
}

void ShownGeometry::add(render::MeshId body, std::span<const render::MeshUpdate> bricks, const dvec3& origin) {
  origins_[static_cast<std::uint8_t>(body)] = millimetres(origin);
  for (const render::MeshUpdate& brick : bricks) {
    const std::size_t first = corners_.size();
    for (const render::Vertex& v : brick.vertices) {
      const render::Look& look = looks_[static_cast<std::size_t>(v.tissue[0])];
      const dvec3 beneath = render::linear_light(looks_[static_cast<std::size_t>(v.under)].color);
      const dvec3 own = render::painted_color(render::linear_light(look.color), v.paint);
      const dvec3 color = render::layered_color(own, look.translucency, beneath, v.shows);
      corners_.push_back({millimetres(origin + dvec3(v.p)), v.n, static_cast<std::uint8_t>(body),
                          static_cast<std::uint8_t>(v.tissue[0]), static_cast<std::uint8_t>(v.tissue[1]),
                          static_cast<std::uint8_t>(v.under), v.second, v.cut,
                          static_cast<float>(v.depth / kMillimetre), glm::vec3(color)});
    }
    add_triangles(brick.indices, first);
  }
}

void ShownGeometry::add(const render::ToolMesh& tool, const Pose& X_WG, float blur) {
  const std::size_t first = corners_.size();
  for (const render::ToolVertex& v : tool.vertices) {
    const glm::vec3 p = glm::mix(v.p, v.hull_p, blur * v.spins), n = glm::mix(v.n, v.hull_n, blur * v.spins);
    corners_.push_back({millimetres(X_WG * dvec3(p)), glm::normalize(glm::vec3(X_WG.R * dvec3(n))), kToolBody, 0, 0, 0,
                        0, 0, 0, glm::vec3(0)});
  }
  add_triangles(tool.indices, first);
}

void ShownGeometry::write(const std::filesystem::path& file) const {
  std::string labels;
  for (int t = 0; t < render::kMatterCount; ++t)
    labels += fmt::format("comment tissue {} {}\n", t, render::matter_name(t));
  for (const auto& [body, origin] : origins_)
    labels += fmt::format("comment origin {} {} {} {}\n", body, origin.x, origin.y, origin.z);
  std::string out = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment Typodont, millimetres, frame W\n{}element vertex {}\n"
      "property float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
      "property uchar body\nproperty uchar tissue\nproperty uchar second\nproperty uchar under\n"
      "property float share\nproperty float cut\nproperty float depth\n"
      "property float red\nproperty float green\nproperty float blue\n"
      "element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
      labels, corners_.size(), indices_.size() / 3);
  for (const Corner& c : corners_)
    append(out, c.p, c.n, c.body, c.tissue, c.second, c.under, c.fraction, c.cut, c.depth, c.color);
  for (std::size_t i = 0; i + 2 < indices_.size(); i += 3)
    append(out, std::uint8_t{3}, indices_[i], indices_[i + 1], indices_[i + 2]);
  write_file_atomically(file, out, FileKind::kPly);
}

}  // namespace typodont
