// A surface drawn on the host, which can be turned, and in which points can be picked. Main thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "engine/base/pose.h"
#include "engine/render/picture.h"
#include "haptics/tissue_mesh.h"

namespace typodont {

using glm::dvec2;

/// An orthographic picture of triangles. Positions are in m, in the mesh's frame. A place in the picture is a pair of
/// fractions of its width and height, from the top left corner.
class SurfacePicture {
 public:
  SurfacePicture() = default;
  /// `colors`: sRGB 0..255, one per triangle.
  SurfacePicture(haptics::TissueMesh mesh, std::vector<glm::vec3> colors);

  /// Shows the surface as seen by a viewer who looks in the direction `look` (unit). `up`: direction that points up in
  /// the picture.
  void look_along(const dvec3& look, const dvec3& up);
  /// Takes over the other picture's view.
  void look_like(const SurfacePicture& other);
  /// Turns the view as if the user dragged the surface by this part of the picture's width and height.
  void turn(const dvec2& by);
  void zoom(double factor);  // more than 1: the surface appears larger

  /// Draws the surface, square. The next at() refers to this picture.
  render::Picture draw(int pixels);
  /// The point of the surface at a place of the last picture; nullopt beside the surface.
  std::optional<dvec3> at(const dvec2& place) const;
  /// The place of a point in the present view.
  dvec2 place_of(const dvec3& p) const;

  /// Adds triangles of another mesh in this one's frame.
  void add(const haptics::TissueMesh& mesh, const std::vector<glm::vec3>& colors);
  const haptics::TissueMesh& mesh() const { return mesh_; }

 private:
  haptics::TissueMesh mesh_;
  std::vector<glm::vec3> colors_;
  dvec3 centre_{0};
  double extent_ = 1;  // m, width of the picture
  dvec3 right_{1, 0, 0}, up_{0, 0, 1}, look_{0, 1, 0};
  int pixels_ = 0;
  std::vector<float> depth_;  // m along look_ from the centre, of the last picture
  dvec3 drawn_right_{1, 0, 0}, drawn_up_{0, 0, 1}, drawn_look_{0, 1, 0};
  double drawn_extent_ = 1;
};

}  // namespace typodont
