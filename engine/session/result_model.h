// The final surface as triangles, for the report's rotatable view and for pictures without graphics card.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "engine/base/pose.h"
#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"

namespace typodont::session {

/// Tissue of each sample, which gives the colours of a cut face. Air where there never was tissue.
struct TissueLabels {
  VoxelFrame frame;            // sample (0,0,0) is at the frame's origin
  glm::ivec3 size{0};          // number of samples along each axis; 0: no labels
  std::vector<Tissue> tissue;  // tissue of each sample; z changes fastest
};

struct ResultModel {
  struct Vertex {
    glm::vec3 p_W{0};  // m, frame W, position of the vertex
    glm::vec3 n{0};    // unit normal, pointing out of the tissue
    Tissue tissue = Tissue::kAir;
    float off = 0;  // m, distance from the target shape; positive: tissue left, negative: too deep
  };
  std::vector<Vertex> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;  // indices in counter-clockwise order as seen from outside
  TissueLabels labels;                                  // tissue labels inside the model
};

/// Deviation from the ideal shape that is drawn in the strongest colour, m.
inline constexpr double kFullColor = 0.5e-3;

/// Orthographic view along `look_W`; `up_W` points upwards in the picture.
struct ModelView {
  dvec3 look_W{0, 0, -1}, up_W{0, 1, 0};
};

/// Oblique view from above, as in the report's first picture. `axis_W`: unit vector out of the opening.
ModelView angled_view(const dvec3& axis_W);

/// Draws the model: sRGB pixels, top row first. `ground`: grey, 0 to 255. `difference`: colours show deviations instead
/// of tissues.
std::vector<std::uint8_t> draw_model_pixels(const ResultModel& model, const ModelView& view, glm::ivec2 pixels,
                                            bool difference, const glm::vec3& ground);
/// Draws as draw_model_pixels(), on white, and returns a PNG.
std::vector<std::uint8_t> draw_model(const ResultModel& model, const ModelView& view, glm::ivec2 pixels,
                                     bool difference);

}  // namespace typodont::session
