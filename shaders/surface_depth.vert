#version 460
#extension GL_EXT_multiview : require
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) in vec3 in_position;

// the same depth as in surface.vert
invariant gl_Position;

void main() {
  vec4 p = vec4(in_position, 1.0);
  vec3 world = vec3(dot(object.world_row[0], p), dot(object.world_row[1], p), dot(object.world_row[2], p));
  gl_Position = frame.clip_from_world[VIEW] * vec4(world, 1.0);
  gl_ClipDistance[0] = dot(frame.clip, vec4(world, 1.0));
  gl_ClipDistance[1] = dot(frame.section, vec4(world, 1.0));
}
