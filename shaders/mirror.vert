#version 460
#extension GL_EXT_multiview : require
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) out vec2 out_place;  // position in units of the glass's radius
layout(location = 1) out vec3 out_position;

// A disc as a triangle strip. Its corners, 0, 1, 95, 2, 94 … of a polygon with 96 corners, lie alternately on both
// sides.
void main() {
  int i = gl_VertexIndex, k = (i & 1) == 1 ? (i + 1) / 2 : (96 - i / 2) % 96;
  float a = 6.28318531 * float(k) / 96.0;
  out_place = vec2(cos(a), sin(a));
  vec4 p = vec4(out_place * frame.mirror.x, 0.0, 1.0);
  vec3 world = vec3(dot(object.world_row[0], p), dot(object.world_row[1], p), dot(object.world_row[2], p));
  out_position = world;
  gl_Position = frame.clip_from_world[VIEW] * vec4(world, 1.0);
}
