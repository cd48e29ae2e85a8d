// Writes all triangles of a picture to one file, so that another renderer can draw the same scene (tests/reference).
// Not for the servo thread. Throws Error.
#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <vector>

#include "engine/base/pose.h"
#include "engine/render/look.h"
#include "engine/render/renderer.h"

namespace typodont {

/// Number that identifies the tool's triangles in the file. Other bodies are identified by their render::MeshId.
inline constexpr std::uint8_t kToolBody = 255;

class ShownGeometry {
 public:
  explicit ShownGeometry(const MaterialTable& materials) : looks_(render::appearances_of(materials)) {}
  /// Adds the bricks (mesh blocks) of a body. `origin`: m, frame W, origin of the body's own frame. `body`: number less
  /// than kToolBody.
  void add(render::MeshId body, std::span<const render::MeshUpdate> bricks, const dvec3& origin);
  /// Adds the tool at this pose. `blur`: 0 for a tool at rest, 1 for the hull of a tool that rotates fast.
  void add(const render::ToolMesh& tool, const Pose& X_WG, float blur);
  /// Writes a binary PLY file in millimetres, frame W (docs/interface.md describes its properties). The file is written
  /// completely or not at all.
  void write(const std::filesystem::path& file) const;

 private:
  struct Corner {
    glm::vec3 p{0}, n{0};  // p: mm, frame W, position; n: unit normal
    std::uint8_t body = 0, tissue = 0, second = 0, under = 0;
    // 0..1, fraction of the tissue `second` in the colour of this corner; the rest is the colour of the tissue `tissue`
    float fraction = 0;
    float cut = 0;       // 0..1, fraction of the surface around this corner that was made by cutting
    float depth = 0;     // mm, depth of a deeper tissue (`under`) below the surface; 0: there is no such tissue
    glm::vec3 color{0};  // linear RGB, colour of the surface tissue, through which the tissue below it is visible
  };
  void add_triangles(std::span<const std::uint32_t> indices, std::size_t first);

  std::array<render::Look, render::kMatterCount> looks_;
  std::vector<Corner> corners_;
  std::map<std::uint8_t, glm::vec3> origins_;  // mm, frame W, by body
  std::vector<std::uint32_t> indices_;
};

}  // namespace typodont
