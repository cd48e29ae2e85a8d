#version 460
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) in vec3 in_position;

void main() {
  vec4 p = vec4(in_position, 1.0);
  vec3 world = vec3(dot(object.world_row[0], p), dot(object.world_row[1], p), dot(object.world_row[2], p));
  vec3 q = (frame.light_from_world * vec4(world, 1.0)).xyz;
  gl_ClipDistance[0] = dot(frame.section, vec4(world, 1.0));
  gl_Position = vec4(2.0 * q.xy - 1.0, q.z, 1.0);
}
