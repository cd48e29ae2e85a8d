// What was left, as triangles for the report: turned by its reader, and drawn from set views without any graphics card.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "engine/base/pose.h"
#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"

namespace typodont::session {

/// Tissue on a grid of samples, for the face that a cut through a solid shows; air where there never was tissue.
struct TissueLabels {
  VoxelFrame frame;            // sample (0,0,0) lies at its origin
  glm::ivec3 size{0};          // 0: none
  std::vector<Tissue> tissue;  // z runs fastest
};

struct ResultModel {
  struct Vertex {
    glm::vec3 p_W{0};  // m
    glm::vec3 n{0};    // unit, out of the tissue
    Tissue tissue = Tissue::kAir;
    float off = 0;  // m from the ideal's surface: above 0 too much is left, below 0 it was cut too deep
  };
  std::vector<Vertex> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;  // counter-clockwise seen from outside
  TissueLabels labels;                                  // inside it
};

/// Deviations of this much, and all beyond, have the full colour of the difference map. m
inline constexpr double kFullColor = 0.5e-3;

/// Where a picture is taken from: orthographic, looking along `look_W` with `up_W` upright in the picture.
struct ModelView {
  dvec3 look_W{0, 0, -1}, up_W{0, 1, 0};
};

/// From above at an angle, as the report's first picture is; `axis_W`: out of the opening.
ModelView angled_view(const dvec3& axis_W);

/// Three bytes a pixel, sRGB, top row first, on this ground (0 to 255). `difference`: the map of deviations instead of
/// the tissues' colours.
std::vector<std::uint8_t> draw_model_pixels(const ResultModel& model, const ModelView& view, glm::ivec2 pixels,
                                            bool difference, const glm::vec3& ground);
/// The same as a PNG picture on white.
std::vector<std::uint8_t> draw_model(const ResultModel& model, const ModelView& view, glm::ivec2 pixels,
                                     bool difference);

}  // namespace typodont::session
