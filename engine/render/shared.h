// Data that C++ fills and shaders read, declared once for both. Contains only vec4, ivec4 and mat4, so that both
// languages use the same layout. Included in GLSL with GL_GOOGLE_include_directive.
#ifdef __cplusplus
#pragma once
#include <glm/glm.hpp>
namespace typodont::render::shared {
using glm::mat4;
using glm::vec4;
#endif

// uniform data of a frame: set 0, binding 0
struct FrameData {
  mat4 clip_from_world[2];
  vec4 eye[2];            // xyz: m, W
  mat4 light_from_world;  // xy: 0..1 over the shadow map; z: 0..1, increasing away from the lamp
  vec4 light_size;        // x: shadow map's width, m; y: its depth, m; z: one texel, m; w: 1 if there is a map
  vec4 key;               // xyz: unit, towards the lamp; w: strength
  vec4 up;                // xyz: unit; w: ambient strength
  vec4 window;            // xyz: unit, towards the window that glossy surfaces reflect
  vec4 tool_head;         // xyz: head centre, m; w: radius, m; 0: no tool
  vec4 tool_end;          // xyz: far end of the shank, m; w: its radius, m
  vec4 tool_motion;       // x: angle, rad; y: motion blur by the spindle, 0 .. 1
  vec4 background;        // x: 1: the gradient is drawn, 0: black; w: opacity of the background
  vec4 picture;           // xy: size of a pixel in clip space
  vec4 clip;              // clip plane: only points with dot(clip.xyz, p) + clip.w > 0 are drawn; 0 0 0 1: everything
  vec4 section;           // clip plane for tissue only, as `clip`
  vec4 cursor;            // xyz: start of the cursor's line, m; w: radius of its ring, m; 0: no cursor
  vec4 cursor_down;       // xyz: unit direction of the line
  vec4 mirror;            // x: the mouth mirror's radius, m; y: fog
  vec4 tissue_color[10];  // indexed by contract/tissue.h: linear colour; w: translucency
  vec4 tissue_look[10];   // roughness, metal, wetness
};

// push constants of an object
struct ObjectData {
  vec4 world_row[3];  // X_WM as a 3×4 matrix, by rows
  vec4 view;          // x: index of the eye if each eye has its own pass, otherwise 0; y: fraction of pixels left out
};

#ifdef __cplusplus
}  // namespace typodont::render::shared
#endif
