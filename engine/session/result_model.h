// The final surface as triangles for the report. The reader can rotate this surface, and pictures of it are drawn
// without a graphics card.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "engine/base/pose.h"
#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"

namespace typodont::session {

/// Tissue labels on a grid, for the cut face of a section; air where tissue never existed.
struct TissueLabels {
  VoxelFrame frame;            // sample (0,0,0) lies at the frame's origin
  glm::ivec3 size{0};          // number of samples; 0: no labels
  std::vector<Tissue> tissue;  // z is the fastest index
};

struct ResultModel {
  struct Vertex {
    glm::vec3 p_W{0};  // m
    glm::vec3 n{0};    // unit normal, pointing out of the tissue
    Tissue tissue = Tissue::kAir;
    float off = 0;  // m, distance from the ideal's surface; above 0: too much tissue remains, below 0: cut too deep
  };
  std::vector<Vertex> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;  // counter-clockwise as seen from outside
  TissueLabels labels;                                  // tissue inside the model
};

/// m, deviation at which the difference map reaches its full colour
inline constexpr double kFullColor = 0.5e-3;

/// An orthographic view along `look_W`; `up_W` points up in the picture.
struct ModelView {
  dvec3 look_W{0, 0, -1}, up_W{0, 1, 0};
};

/// An angled view from above, as in the report's first picture. `axis_W` points out of the opening.
ModelView angled_view(const dvec3& axis_W);

/// Draws three bytes per pixel, sRGB, top row first. `ground`: grey of the background, 0 to 255. `difference`: draws
/// the deviations instead of the tissues' colours.
std::vector<std::uint8_t> draw_model_pixels(const ResultModel& model, const ModelView& view, glm::ivec2 pixels,
                                            bool difference, const glm::vec3& ground);
/// Same as draw_model_pixels(), as a PNG picture on a white background.
std::vector<std::uint8_t> draw_model(const ResultModel& model, const ModelView& view, glm::ivec2 pixels,
                                     bool difference);

}  // namespace typodont::session
