// The data that every pass uses: descriptor set 0 with the types of engine/render/shared.h.
#extension GL_GOOGLE_include_directive : require
#include "engine/render/shared.h"

layout(set = 0, binding = 0) uniform FrameBlock { FrameData frame; };
layout(set = 0, binding = 1) uniform sampler2DShadow shadow_map;
layout(set = 0, binding = 2) uniform sampler2D shadow_depth;
layout(set = 0, binding = 3) uniform sampler2DArray reflection;
layout(set = 0, binding = 5) uniform sampler3D light_grid;
layout(set = 0, binding = 6) uniform sampler3D tissue_light;
layout(set = 0, binding = 7) uniform sampler3D mirrored_images;

layout(push_constant) uniform Push { ObjectData object; };
// Index of the eye that is drawn.
#define VIEW (gl_ViewIndex + int(object.view.x))

layout(constant_id = 0) const int kShadowTaps = 16;
layout(constant_id = 1) const int kOcclusionTaps = 16;
layout(constant_id = 2) const bool kLightPerVertex = false;
layout(constant_id = 3) const int kView = 0;        // a value of View in renderer.h: look, section, x-ray, difference,
                                     // temperature
// true: the tissue is drawn as glass, which is denser at grazing angles
layout(constant_id = 4) const bool kGlass = false;
layout(constant_id = 7) const bool kHandpieceShadow = false;
// true: light from the room and from other surfaces comes from a grid; false: it is estimated from the shape nearby
layout(constant_id = 10) const bool kLightGrid = false;
layout(constant_id = 8) const bool kSpot = false;  // true: the lamp spot's border lies on the tissue
// Content of the drawn bricks (BrickKind in passes/bricks.h). The shader is compiled without the code for other
// content.
layout(constant_id = 5) const int kHolds = 15;
const int kHoldsPairs = 1, kHoldsDecay = 2, kHoldsEnamel = 4, kHoldsGum = 8, kHoldsBacks = 16,
          kHoldsMetal = 32;
