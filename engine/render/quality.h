// Levels of quality, from the best picture to one that software rendering draws in time.
#pragma once

#include <array>
#include <string_view>

namespace typodont::render {

struct Quality {
  std::string_view name = "high";
  int samples = 4;        // number of samples per pixel
  int shadow_map = 2048;  // texels per side; 0: no shadow, occlusion or handpiece
  int shadow_taps = 16;
  int occlusion_taps = 16;
  bool light_per_vertex = false;  // computes shadow and occlusion per vertex instead of per pixel
  double scale = 1.0;             // drawn width divided by shown width; below 1, pictures are stretched
  // Largest error of the surface, drawn pixels (engine/app/picture/detail.h).
  double surface_error = 0.4;
  double handpiece_side = 0.5e-3;  // m, side of the handpiece's triangles
  // Light inside tissue (tissue_light.h). Computed once, with the quality level of the first frame. A live session with
  // a graphics card uses the values of the best level.
  double light_cell = 0.3e-3;  // m, edge of a cell
  int light_walks = 64;        // number of random walks from each cell
  // Light between bodies (light_scene.h). true: light that wet tissue mirrors is computed at each sample near it.
  bool tissue_mirrors = false;
};

/// The quality levels, best first.
inline constexpr std::array<Quality, 7> kQualityLadder{{
    {"high", 4, 2048, 16, 16, false, 1.0, 0.4, 0.5e-3, 0.15e-3, 192, true},
    {"medium", 4, 1024, 8, 8, true, 1.0, 0.4, 0.7e-3},
    {"low", 1, 1024, 8, 8, true, 1.0, 1.0, 1.5e-3},
    {"fast", 1, 512, 6, 6, true, 0.6, 1.25, 2.5e-3},
    {"fastest", 1, 512, 4, 4, true, 0.4, 1.25, 3e-3},
    {"coarse", 1, 512, 2, 2, true, 0.3, 1.5, 4e-3},
    {"bare", 1, 0, 0, 0, true, 0.3, 1.5, 4e-3},
}};

}  // namespace typodont::render
