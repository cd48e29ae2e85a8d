// A surface on the CPU, turned and picked by the user. Main thread.
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

/// Orthographic; m in the mesh's frame. Places: fractions from the top left.
class SurfacePicture {
 public:
  SurfacePicture() = default;
  /// `colors`: one colour per triangle, sRGB 0..255.
  SurfacePicture(haptics::TissueMesh mesh, std::vector<glm::vec3> colors);

  /// Along `look` (unit); `up` points up.
  void look_along(const dvec3& look, const dvec3& up);
  /// The same side as `other`.
  void look_like(const SurfacePicture& other);
  /// Dragged by fractions of the picture.
  void turn(const dvec2& by);
  void zoom(double factor);  // zooms; with a factor above 1, the surface appears larger

  /// Square; at() refers to it from now on.
  render::Picture draw(int pixels);
  /// Surface at `place` of the last picture; empty: none.
  std::optional<dvec3> at(const dvec2& place) const;
  /// Where the present view shows p.
  dvec2 place_of(const dvec3& p) const;

  /// In the same frame.
  void add(const haptics::TissueMesh& mesh, const std::vector<glm::vec3>& colors);
  const haptics::TissueMesh& mesh() const { return mesh_; }

 private:
  haptics::TissueMesh mesh_;
  std::vector<glm::vec3> colors_;
  dvec3 centre_{0};
  double extent_ = 1;  // m, width of the region that the picture shows
  dvec3 right_{1, 0, 0}, up_{0, 0, 1}, look_{0, 1, 0};
  int pixels_ = 0;
  std::vector<float> depth_;  // m from centre_ along look_, per pixel
  dvec3 drawn_right_{1, 0, 0}, drawn_up_{0, 0, 1}, drawn_look_{0, 1, 0};
  double drawn_extent_ = 1;
};

}  // namespace typodont
