// Data that C++ fills and shaders read, declared once. Structs contain only vec4, ivec4, mat4, pairs of a vec3 and a
// number, and single numbers in structs without vectors; their memory layout is equal in both languages. Needs
// GL_GOOGLE_include_directive.
#ifdef __cplusplus
#pragma once
#include <glm/glm.hpp>
namespace typodont::render::shared {
using glm::ivec4;
using glm::mat4;
using glm::uint;
using glm::vec3;
using glm::vec4;
#endif

// Lamp and room. `typodont render` writes these values to frame.json for the reference pictures.
const float kLampHalfAngle = 0.12f;                // rad, half the angle that the lamp subtends at the tissue
const vec3 kLampColor = vec3(1.0, 0.975, 0.94);    // colour of the lamp's light, linear
const vec3 kRoomFloor = vec3(0.13, 0.12, 0.11);    // radiance of the room from below
const vec3 kRoomCeiling = vec3(0.44, 0.47, 0.52);  // radiance of the room from above
const vec3 kRoomWindow = vec3(0.45, 0.50, 0.58);   // radiance that the middle of the window adds

// Number of directions in which a surface can face in a LightGrid.
const int kLightDirections = 6;
// Nodes per side of the octahedral map (LightGrid::images). Neighbouring nodes are about 17° apart.
const int kImageSide = 11;

// Reflectance under saliva (index 1.33) at normal incidence: kFilmedLeast + kFilmedSlope × dry reflectance. Fits
// Fresnel's formula at both surfaces within 0.001 for indices 1.37 to 1.63.
const float kFilmedLeast = 0.0116f, kFilmedSlope = 0.32f;

// Colour scale of the view of temperature: blue, neutral at kBody, orange and red. Lightness falls monotonically to
// both sides, and no pair of colours differs only in red and green (after the scale vik, Crameri,
// doi:10.5281/zenodo.1243862).
const float kColdest = 10.0f, kBody = 37.0f, kHottest = 60.0f;  // °C
const float kPulpHarm = 5.5f, kBoneHarm = 10.0f;                // K above kBody
const vec3 kColdestColor = vec3(0.00, 0.07, 0.38), kColdColor = vec3(0.19, 0.51, 0.68),
           kBodyColor = vec3(0.93, 0.90, 0.88), kWarmColor = vec3(0.81, 0.54, 0.37),
           kHottestColor = vec3(0.35, 0.00, 0.03);  // sRGB

// Rays between bodies (body_rays.h).
const int kRayDepth = 64;    // largest number of nodes that wait while a ray searches the tree
const float kMissed = 1e9f;  // m, used instead of a distance if there is none
// Values of RayHit::met that are no triangle: the ray meets nothing; the ray meets the back of a triangle.
const int kNothing = -1, kBack = -2;

// Node of the tree of triangles. Its first child is the next node.
struct RayNode {
  vec3 lo;    // m, frame W, lower corner of the box
  int next;   // index of the second child; in a leaf, of the first triangle
  vec3 hi;    // m, frame W, upper corner
  int count;  // number of triangles in a leaf; 0 if the node has children
};
struct RaySurface {
  vec3 corner;   // m, frame W, first corner of the triangle
  int triangle;  // its index in the list that the tree was built from
  vec4 along;    // m, from the first to the second corner
  vec4 beside;   // m, from the first to the third corner
};
// The end of a ray.
struct RayHit {
  int met;         // index of the triangle, kNothing or kBack
  float distance;  // m, from the start of the ray; kMissed if it meets nothing
};
// Push constants of shaders/body_rays.comp.
struct RayPass {
  int starts, directions;  // number of each; each start has a ray in each direction
  int any;                 // 1: any triangle is sufficient, not only the first
};

// Rays and random walks of the light inside tissue (tissue_rays.h).
const int kSurfaceRays = 24;      // number of rays from each cell at a surface, which find the light of other surfaces
const int kLampRays = 6;          // number of rays from each cell to the lamp
const int kBlock = 8;             // cells along a block's edge; rays cross empty space in steps of whole blocks
const float kSearched = 0.3e-3f;  // m, distance up to which the surface at the end of a ray or walk is searched
const float kMinStep = 45e-6f;    // m, smallest step of rays and random walks
const float kLongestRay = 8e-3f;  // m, longest ray; farther away, the light of the LightGrid is used
const int kMaxSteps = 200;        // largest number of steps of a random walk; a walk rarely needs 30
// Number of directions and lengths from which a walk's steps are chosen, by the high bits of random numbers.
const int kStepTable = 2048, kStepShift = 21;
const float kMostWeight = 3.0f;  // largest weight of a walk
// Used for random numbers instead of the number of a walk or of its step.
const uint kRandomOfRays = 0xfffffffeu, kRandomOfWalks = 0xffffffffu;
// Used instead of the index of an element. kNone: there is no element; kFree: the ray leaves the box.
const int kNone = -1, kFree = -2;

// Push constants of a pass over elements (the pieces of surface that belong to cells).
struct LightPass {
  vec4 origin;       // position of cell (0, 0, 0), m, frame W; w: edge of a cell, m
  ivec4 size;        // number of cells per axis; w: number of walks from each element
  ivec4 blocks;      // number of blocks per axis; w: number of elements of the pass
  vec4 far_origin;   // LightGrid: cell (0, 0, 0) in its samples; w: samples per cell
  ivec4 far_size;    // LightGrid: number of samples per axis
  vec4 lamp;         // irradiance / π of a white surface that faces the lamp; w: limit of the stored distances, m
  vec4 toward_lamp;  // unit vector; w: half the angle that the lamp subtends, rad
};
// Light that arrives at an element, divided by π: from the lamp; from the lamp and from outside the box.
struct LightArrival {
  vec4 lamp, outer;
};
// An element for the passes.
struct LightElement {
  vec4 p;       // m, frame W, point of the surface
  vec4 n;       // unit normal of the surface at p
  vec4 albedo;  // probability that light survives one scattering, for each colour
  vec4 path;    // m, mean free paths; 0: opaque
  ivec4 cell;   // x: index of its cell
};

// Uniform data of a frame: set 0, binding 0.
struct FrameData {
  mat4 clip_from_world[2];
  vec4 eye[2];  // xyz: position of each eye, m, frame W
  // Maps frame W to the shadow map; xy: 0..1; z: 0..1, away from the lamp.
  mat4 light_from_world;
  /// Shadow map: width, depth, texel size, m; w: 1 if there is a map.
  vec4 light_size;
  vec4 key;           // unit vector to the lamp; w: strength of the lamp's light
  vec4 up;            // unit vector to the ceiling; w: strength of the room's light
  vec4 window;        // unit vector to the room's window, which surfaces reflect
  vec4 tool_head;     // centre of the tool's head, m, frame W; w: radius, m; 0: no tool
  vec4 tool_end;      // far end of the shank, m, frame W; w: radius, m
  vec4 tool_motion;   // x: angle of the spindle, rad; y: motion blur, 0..1
  vec4 background;    // x: 1 gradient, 0 black; w: opacity
  vec4 picture;       // xy: size of a pixel in clip space
  vec4 clip;          // points with dot(clip.xyz, p) + clip.w > 0 are drawn; 0 0 0 1: all
  vec4 section;       // tissue is drawn only where dot(section.xyz, p) + section.w > 0
  vec4 cursor;        // start of the cursor's line, m, frame W; w: radius of the ring, m; 0: no cursor
  vec4 cursor_down;   // xyz: unit direction of the cursor's line
  vec4 mirror;        // mouth mirror: radius, m; fog; 1 / magnification
  vec4 handpiece[4];  // handpiece's shadow: two ends of its head, two of its body, m, frame W; w: radius, m
  // x: half the lamp's width divided by its distance; y: soft border of the spot, m; zw: half size of the spot, m.
  vec4 lamp;
  vec4 lamp_middle;       // middle of the spot, m, frame W
  vec4 lamp_right;        // unit vector along the spot's width
  vec4 tissue_color[16];  // linear colours, indexed as contract/tissue.h and drawn_matter.h; w: translucency
  // x: roughness; y: dry reflectance at normal incidence (metal: 1); z: wetness; w: 1 if TissueLightGrid has its light.
  vec4 tissue_look[16];
  vec4 film_origin;          // water film: position of the first sample, m, frame W; w: samples per m
  vec4 film_size;            // water film: number of samples per axis
  vec4 temperature_origin;   // temperatures: position of the first sample, m, frame W; w: samples per m
  vec4 temperature_size;     // temperatures: number of samples per axis
  vec4 light_origin;         // LightGrid: position of the first sample, m, frame W; w: samples per m
  vec4 light_samples;        // LightGrid: number of samples per axis
  vec4 tissue_light_origin;  // TissueLightGrid: position of the first cell, m, frame W; w: cells per m
  vec4 tissue_light_cells;   // TissueLightGrid: number of cells per axis
};

// Push constants of an object.
struct ObjectData {
  vec4 world_row[3];  // X_WM as a 3×4 matrix, by rows
  // x: eye, if each eye has its own pass; y: fraction of the tool's pixels that are not drawn; z: radius at the working
  // point of the view cone in which the handpiece is not drawn, m.
  vec4 view;
};

#ifdef __cplusplus
}  // namespace typodont::render::shared
#endif
