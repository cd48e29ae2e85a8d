// A picture of a surface, drawn by the CPU. The user can turn the surface and pick points on it. Main thread only.
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

/// An orthographic picture of triangles. Positions are in m, in the frame of the mesh. A position in the picture is
/// given as fractions of its width and height, from the top left corner.
class SurfacePicture {
 public:
  SurfacePicture() = default;
  /// `colors`: one colour per triangle, sRGB 0..255.
  SurfacePicture(haptics::TissueMesh mesh, std::vector<glm::vec3> colors);

  /// Sets the view of a viewer who looks in the direction `look` (unit vector). `up`: direction that points up in the
  /// picture.
  void look_along(const dvec3& look, const dvec3& up);
  /// Copies the viewpoint of another picture, so that both show their surfaces from the same side.
  void look_like(const SurfacePicture& other);
  /// Turns the view as if the user dragged the surface. `by`: motion as fractions of the picture's width and height.
  void turn(const dvec2& by);
  void zoom(double factor);  // zooms; with a factor above 1, the surface appears larger

  /// Draws a square picture of the surface. After that, at() refers to this picture.
  render::Picture draw(int pixels);
  /// Returns the point of the surface that the last picture shows at `place`; empty if there is no surface.
  std::optional<dvec3> at(const dvec2& place) const;
  /// Returns the position in the picture at which the present view shows the point.
  dvec2 place_of(const dvec3& p) const;

  /// Adds the triangles of another mesh. Their positions are in the frame of this mesh.
  void add(const haptics::TissueMesh& mesh, const std::vector<glm::vec3>& colors);
  const haptics::TissueMesh& mesh() const { return mesh_; }

 private:
  haptics::TissueMesh mesh_;
  std::vector<glm::vec3> colors_;
  dvec3 centre_{0};
  double extent_ = 1;  // m, width of the region that the picture shows
  dvec3 right_{1, 0, 0}, up_{0, 0, 1}, look_{0, 1, 0};
  int pixels_ = 0;
  std::vector<float> depth_;  // m, for each pixel of the last picture: distance of the surface from centre_ along look_
  dvec3 drawn_right_{1, 0, 0}, drawn_up_{0, 0, 1}, drawn_look_{0, 1, 0};
  double drawn_extent_ = 1;
};

}  // namespace typodont
