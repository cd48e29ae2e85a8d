// Data that C++ fills and shaders read, declared once for both. It contains only vec4, ivec4 and mat4, for which both
// languages use the same layout. Included in GLSL with GL_GOOGLE_include_directive.
#ifdef __cplusplus
#pragma once
#include <glm/glm.hpp>
namespace typodont::render::shared {
using glm::mat4;
using glm::vec3;
using glm::vec4;
#endif

// Light of the lamp and the room. `typodont render` writes these values to frame.json for the reference pictures.
const float kLampHalfAngle = 0.12f;                // rad, half the angle that the lamp subtends at the tissue
const vec3 kLampColor = vec3(1.0, 0.975, 0.94);    // colour of the lamp's light, linear
const vec3 kRoomFloor = vec3(0.13, 0.12, 0.11);    // radiance of the room from below
const vec3 kRoomCeiling = vec3(0.44, 0.47, 0.52);  // radiance of the room from above
const vec3 kRoomWindow = vec3(0.45, 0.50, 0.58);   // additional radiance of the window's middle

// Grid of reflected light (LightGrid): number of directions in which a surface can face, for the light that it receives
const int kLightDirections = 6;
// Number of nodes along each side of the octahedral map in which a sample stores the light that surfaces mirror. So the
// light of about 17° is one node.
const int kImageSide = 11;

// Reflectance of tissue under a film of saliva (refractive index 1.33) at normal incidence: kFilmedLeast + kFilmedSlope
// × the reflectance of the dry tissue. The line fits Fresnel's reflectance of both surfaces of the film, for tissue
// with an index of 1.37 to 1.63; it differs by at most 0.001.
const float kFilmedLeast = 0.0116f, kFilmedSlope = 0.32f;

// uniform data of a frame: set 0, binding 0
struct FrameData {
  mat4 clip_from_world[2];
  vec4 eye[2];  // xyz: position of each eye, m, frame W
  // matrix from frame W to the shadow map; xy: 0..1 over the map; z: 0..1, increasing away from the lamp
  mat4 light_from_world;
  /// x: width of the shadow map, m; y: depth of the shadow map, m; z: size of a texel, m; w: 1 if there is a map
  vec4 light_size;
  vec4 key;           // xyz: unit vector towards the lamp; w: strength of the lamp's light
  vec4 up;            // xyz: unit vector towards the ceiling; w: strength of the room's light
  vec4 window;        // xyz: unit vector towards the window that glossy surfaces reflect
  vec4 tool_head;     // xyz: centre of the tool's head, m, frame W; w: its radius, m; 0: no tool
  vec4 tool_end;      // xyz: far end of the shank, m; w: its radius, m
  vec4 tool_motion;   // x: angle of the spindle, rad; y: motion blur of the tool by the spindle, 0 .. 1
  vec4 background;    // x: 1: the gradient is drawn, 0: black; w: opacity of the background
  vec4 picture;       // xy: size of a pixel of the picture in clip space
  vec4 clip;          // clip plane: only points with dot(clip.xyz, p) + clip.w > 0 are drawn; 0 0 0 1: everything
  vec4 section;       // clip plane for tissue only, in the same form as `clip`
  vec4 cursor;        // xyz: start of the cursor's line, m; w: radius of its ring, m; 0: no cursor
  vec4 cursor_down;   // xyz: unit direction of the cursor's line
  vec4 mirror;        // x: the mouth mirror's radius, m; y: fog; z: 1 divided by the magnification
  vec4 handpiece[4];  // round cones that cast the handpiece's shadow: head a, b, body a, b; xyz: m; w: radius, m
  // x: half the lamp's width divided by its distance; y: width of the spot's soft border, m; zw: half the spot's width
  // and height, m
  vec4 lamp;
  vec4 lamp_middle;       // xyz: middle of the lamp's spot, m, frame W
  vec4 lamp_right;        // xyz: unit vector along the width of the lamp's spot
  vec4 tissue_color[16];  // indexed by contract/tissue.h and drawn_matter.h: linear colour; w: translucency
  // optical properties of each tissue: x: roughness; y: reflectance of the dry surface at normal incidence, 1: metal;
  // z: wetness; w: 1 if the tissue's light is in the TissueLightGrid
  vec4 tissue_look[16];
  vec4 film_origin;          // the film's grid: xyz: position of the first sample, m, frame W; w: samples per m
  vec4 film_size;            // xyz: number of samples of the film's grid along each axis
  vec4 light_origin;         // the grid of LightGrid: xyz: position of the first sample, m, frame W; w: samples per m
  vec4 light_samples;        // xyz: number of samples of the LightGrid along each axis
  vec4 tissue_light_origin;  // the TissueLightGrid: xyz: position of the first cell, m, frame W; w: cells per m
  vec4 tissue_light_cells;   // xyz: number of cells of the TissueLightGrid along each axis
};

// push constants of an object
struct ObjectData {
  vec4 world_row[3];  // X_WM as a 3×4 matrix, by rows
  // x: index of the eye if each eye has its own pass, otherwise 0; y: fraction of pixels that are not drawn; z: radius
  // (m), at the working point, of the cone between an eye and the working point; a handpiece is not drawn in this cone
  vec4 view;
};

#ifdef __cplusplus
}  // namespace typodont::render::shared
#endif
