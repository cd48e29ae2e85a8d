// How much a frame may cost: the ladder from the best look down to what a processor without a GPU draws in time.
#pragma once

#include <array>
#include <string_view>

namespace typodont::render {

struct Quality {
  std::string_view name = "high";
  int samples = 4;        // per pixel
  int shadow_map = 2048;  // texels; 0: no shadow, no ambient occlusion
  int shadow_taps = 16;
  int occlusion_taps = 16;
  bool light_per_vertex = false;  // shadow and occlusion looked up at corners instead of pixels
  double scale = 1.0;             // of the picture's width and height drawn, before it is stretched to its size
  double surface_error = 0.4;     // pixels drawn that triangles may lie off the surface (engine/app/picture/detail.h)
};

/// Best first.
inline constexpr std::array<Quality, 7> kQualityLadder{{
    {"high", 4, 2048, 16, 16, false, 1.0, 0.4},
    {"medium", 4, 1024, 8, 8, true, 1.0, 0.4},
    {"low", 1, 1024, 8, 8, true, 1.0, 1.0},
    {"fast", 1, 512, 6, 6, true, 0.6, 1.25},
    {"fastest", 1, 512, 4, 4, true, 0.4, 1.25},
    {"coarse", 1, 512, 2, 2, true, 0.3, 1.5},
    {"bare", 1, 0, 0, 0, true, 0.3, 1.5},
}};

}  // namespace typodont::render
