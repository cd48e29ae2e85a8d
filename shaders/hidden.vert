#version 460
#extension GL_EXT_multiview : require
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) in vec3 in_place;  // xy: clip space, z: index of the eye

void main() {
  gl_Position = int(in_place.z) == VIEW ? vec4(in_place.xy, 0.0, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
}
