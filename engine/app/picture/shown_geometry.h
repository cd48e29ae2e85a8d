// Writes all triangles of a picture to a file, for another renderer (tests/reference). Not for the servo thread. Throws
// Error.
#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <vector>

#include "engine/base/pose.h"
#include "engine/render/look.h"
#include "engine/render/renderer.h"

namespace typodont {

/// Number that stands for the tool in the field "body" of the file; other bodies have their render::MeshId.
inline constexpr std::uint8_t kToolBody = 255;

class ShownGeometry {
 public:
  explicit ShownGeometry(const MaterialTable& materials) : looks_(render::appearances_of(materials)) {}
  /// Adds a body. `origin`: origin of its frame, m, frame W. `body`: less than kToolBody.
  void add(render::MeshId body, std::span<const render::MeshUpdate> bricks, const dvec3& origin);
  /// Adds the tool. `blur`: 0 shows the tool at rest, 1 the hull of its fast rotation.
  void add(const render::ToolMesh& tool, const Pose& X_WG, float blur);
  /// Writes a binary PLY file in mm, frame W (docs/interface.md), completely or not at all.
  void write(const std::filesystem::path& file) const;

 private:
  struct Corner {
    glm::vec3 p{0}, n{0};  // p: mm, frame W, position; n: unit normal
    std::uint8_t body = 0, tissue = 0, second = 0, under = 0;
    // Fraction of the tissue `second` at this corner, 0 to 1; the rest is `tissue`.
    float fraction = 0;
    float cut = 0;       // fraction of cut surface around the corner, 0 to 1
    float depth = 0;     // mm, depth of tissue `under` below the surface; 0: none
    glm::vec3 color{0};  // linear RGB of the surface, mixed with the tissue `under` that shines through
  };
  void add_triangles(std::span<const std::uint32_t> indices, std::size_t first);

  std::array<render::Look, render::kMatterCount> looks_;
  std::vector<Corner> corners_;
  std::map<std::uint8_t, glm::vec3> origins_;  // mm, frame W, origin of each body
  std::vector<std::uint32_t> indices_;
};

}  // namespace typodont
