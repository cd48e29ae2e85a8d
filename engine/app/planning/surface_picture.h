// Draws a surface on the CPU. The user rotates it and picks points on it. One thread at a time may use an object;
// copies share only the surface, which does not change.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "engine/base/pose.h"
#include "engine/render/picture.h"
#include "haptics/tissue_mesh.h"

namespace typodont {

using glm::dvec2;

/// An orthographic view. Positions in m, in the mesh's frame. Places in the picture are fractions from the top left
/// corner.
class SurfacePicture {
 public:
  SurfacePicture() = default;
  /// `colors`: colour of each triangle, sRGB, 0 to 255.
  SurfacePicture(haptics::TissueMesh mesh, std::vector<glm::vec3> colors);

  /// Looks along `look` (unit); `up` points up in the picture.
  void look_along(const dvec3& look, const dvec3& up);
  /// Takes over the direction of view of `other`.
  void look_like(const SurfacePicture& other);
  /// Turns the surface. `by`: motion of the mouse, as a fraction of the picture's side.
  void turn(const dvec2& by);
  void zoom(double factor);  // zooms; with a factor above 1, the surface appears larger

  /// Draws a square picture, to which at() then refers.
  render::Picture draw(int pixels);
  /// Lets at() refer to the picture that `drawn`, a copy of this object, has drawn.
  void take(SurfacePicture&& drawn) { drawn_ = std::move(drawn.drawn_); }
  /// Point of the surface at `place` in the latest picture, if any.
  std::optional<dvec3> at(const dvec2& place) const;
  /// Place of the point p in the current view, as a fraction of width and height.
  dvec2 place_of(const dvec3& p) const;

  /// Adds a mesh in the same frame.
  void add(const haptics::TissueMesh& mesh, const std::vector<glm::vec3>& colors);

 private:
  struct Surface {
    haptics::TissueMesh mesh;
    std::vector<glm::vec3> colors;
  };
  struct Drawn {
    int pixels = 0;
    std::vector<float> depth;  // m, depth of each pixel from the centre, along `look`
    dvec3 centre{0}, right{1, 0, 0}, up{0, 0, 1}, look{0, 1, 0};
    double extent = 1;
  };

  std::shared_ptr<const Surface> surface_ = std::make_shared<const Surface>();
  dvec3 centre_{0};
  double extent_ = 1;  // m, width of the region that the picture shows
  dvec3 right_{1, 0, 0}, up_{0, 0, 1}, look_{0, 1, 0};
  Drawn drawn_;
};

}  // namespace typodont
