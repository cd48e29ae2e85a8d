// Writes the triangles of a picture to one file, so that another renderer can draw the same scene
// (tests/reference). Set-up time; throws Error.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "engine/base/pose.h"
#include "engine/render/look.h"
#include "engine/render/renderer.h"

namespace typodont {

/// Number of the tool's body in the file; all other numbers are those of the drawn meshes (render::MeshId).
inline constexpr std::uint8_t kToolBody = 255;

class ShownGeometry {
 public:
  explicit ShownGeometry(const MaterialTable& materials) : looks_(render::appearances_of(materials)) {}
  /// Adds the bricks of a body; `origin`: m, W. `body`: less than kToolBody.
  void add(render::MeshId body, std::span<const render::MeshUpdate> bricks, const dvec3& origin);
  /// Adds the tool at this pose, at rest (`blur` 0) or as the hull of a tool that rotates fast (`blur` 1).
  void add(const render::ToolMesh& tool, const Pose& X_WG, float blur);
  /// Writes a binary PLY completely or not at all: millimetres, frame W. docs/interface.md describes the properties.
  void write(const std::filesystem::path& file) const;

 private:
  struct Corner {
    glm::vec3 p{0}, n{0};  // p: mm, W
    std::uint8_t body = 0, tissue = 0, second = 0, under = 0;
    float share = 0;     // fraction of the second tissue
    float depth = 0;     // mm, depth of the lower tissue; 0: none was found
    glm::vec3 color{0};  // linear, of the first tissue over the lower tissue
  };
  void add_triangles(std::span<const std::uint32_t> indices, std::size_t first);

  std::array<render::Look, render::kMatterCount> looks_;
  std::vector<Corner> corners_;
  std::vector<std::uint32_t> indices_;
};

}  // namespace typodont
