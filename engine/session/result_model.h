// Final surface as triangles: rotatable in the report, and drawn without graphics card.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "engine/base/pose.h"
#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"

namespace typodont::session {

/// Colours of a cut face. Air where there never was tissue.
struct TissueLabels {
  VoxelFrame frame;            // sample (0,0,0) is at its origin
  glm::ivec3 size{0};          // per axis; 0: no labels
  std::vector<Tissue> tissue;  // z is fastest
};

struct ResultModel {
  struct Vertex {
    glm::vec3 p_W{0};  // m, frame W, position of the vertex
    glm::vec3 n{0};    // unit normal, pointing out of the tissue
    Tissue tissue = Tissue::kAir;
    float off = 0;  // m from the ideal: positive too much left, negative too deep
  };
  std::vector<Vertex> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;  // indices in counter-clockwise order as seen from outside
  TissueLabels labels;                                  // tissue labels inside the model
};

/// m off the ideal, at the strongest colour
inline constexpr double kFullColor = 0.5e-3;

/// Orthographic along `look_W`, `up_W` upwards.
struct ModelView {
  dvec3 look_W{0, 0, -1}, up_W{0, 1, 0};
};

/// From above, as the report's first picture. `axis_W`: unit vector out of the opening.
ModelView angled_view(const dvec3& axis_W);

/// sRGB, top row first. `ground`: grey, 0 to 255. `difference`: deviations instead of tissues.
std::vector<std::uint8_t> draw_model_pixels(const ResultModel& model, const ModelView& view, glm::ivec2 pixels,
                                            bool difference, const glm::vec3& ground);
/// As draw_model_pixels() on white, as PNG.
std::vector<std::uint8_t> draw_model(const ResultModel& model, const ModelView& view, glm::ivec2 pixels,
                                     bool difference);

}  // namespace typodont::session
