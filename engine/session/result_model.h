// The final surface as triangles, for the report. The reader can rotate this surface, and pictures of it are drawn
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

/// Tissue labels on a grid, which give the cut face of a section its colours. The label is air where there was never
/// any tissue.
struct TissueLabels {
  VoxelFrame frame;            // position of the grid in frame W; sample (0,0,0) lies at the frame's origin
  glm::ivec3 size{0};          // number of samples per axis; 0 if there are no labels
  std::vector<Tissue> tissue;  // tissue label of each sample; z is the fastest index
};

struct ResultModel {
  struct Vertex {
    glm::vec3 p_W{0};  // m, frame W, position of the vertex
    glm::vec3 n{0};    // unit normal, pointing out of the tissue
    Tissue tissue = Tissue::kAir;
    float off = 0;  // m, distance from the ideal's surface; positive: too much tissue remains, negative: cut too deep
  };
  std::vector<Vertex> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;  // indices in counter-clockwise order as seen from outside
  TissueLabels labels;                                  // tissue labels inside the model
};

/// At this deviation from the ideal (target shape), in m, the difference map has its strongest colour.
inline constexpr double kFullColor = 0.5e-3;

/// An orthographic view in the direction `look_W`. `up_W` points upwards in the picture.
struct ModelView {
  dvec3 look_W{0, 0, -1}, up_W{0, 1, 0};
};

/// Returns an oblique view from above, as in the first picture of the report. `axis_W`: unit vector in frame W that
/// points out of the opening of the prepared cavity.
ModelView angled_view(const dvec3& axis_W);

/// Draws a picture with three bytes per pixel (sRGB), top row first. `ground` is the grey value of the background, 0 to
/// 255. If `difference` is true, colours show the deviations instead of the tissues.
std::vector<std::uint8_t> draw_model_pixels(const ResultModel& model, const ModelView& view, glm::ivec2 pixels,
                                            bool difference, const glm::vec3& ground);
/// Draws the same picture as draw_model_pixels() on a white background, and returns it as a PNG file.
std::vector<std::uint8_t> draw_model(const ResultModel& model, const ModelView& view, glm::ivec2 pixels,
                                     bool difference);

}  // namespace typodont::session
