// What C++ fills and the shaders read: one declaration for both. Only vec4, ivec4 and mat4, so that no rule of layout
// can differ. Included by GLSL with GL_GOOGLE_include_directive.
#ifdef __cplusplus
#pragma once
#include <glm/glm.hpp>
namespace typodont::render::shared {
using glm::mat4;
using glm::vec4;
#endif

// set 0, binding 0
struct FrameData {
  mat4 clip_from_world[2];
  vec4 eye[2];            // xyz: m, W
  mat4 light_from_world;  // xy: 0..1 over the shadow map, z: 0..1 away from the lamp
  vec4 light_size;        // x: shadow map's width, m; y: its depth, m; z: one texel, m; w: 1 when there is a map
  vec4 key;               // xyz: unit, towards the lamp; w: strength
  vec4 up;                // xyz: unit; w: ambient strength
  vec4 window;            // xyz: unit, towards the window that gloss mirrors
  vec4 tool_head;         // xyz: head centre, m; w: radius, m; 0: no tool
  vec4 tool_end;          // xyz: far end of the shank, m; w: its radius, m
  vec4 tool_motion;       // x: angle, rad; y: 0 sharp .. 1 wholly blurred by spin
  vec4 background;        // x: 1 drawn, 0 black; w: its opacity
  vec4 picture;           // xy: a pixel of the picture in clip space
  vec4 clip;              // only what has dot(clip.xyz, p) + clip.w > 0 is drawn; 0 0 0 1: everything
  vec4 section;           // the same, for tissue only
  vec4 cursor;            // xyz: where the cursor's line begins, m; w: the radius of its ring, m; 0: no cursor
  vec4 cursor_down;       // xyz: unit, along its line
  vec4 mirror;            // x: the mouth mirror's radius, m; y: fog
  vec4 tissue_color[10];  // by contract/tissue.h: linear colour; w: translucency
  vec4 tissue_look[10];   // roughness, metal, wetness
};

// push constants
struct ObjectData {
  vec4 world_row[3];  // X_WM as a 3×4 matrix, by rows
  vec4 view;  // x: the eye drawn, where each eye has a pass of its own; 0 where one pass draws both; y: sieved away,
              // 0..1
};

#ifdef __cplusplus
}  // namespace typodont::render::shared
#endif
