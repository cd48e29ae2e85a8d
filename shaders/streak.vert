#version 460
#extension GL_EXT_multiview : require
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

// A droplet in flight, drawn as a short streak. Each streak is stored six times, once for each corner of two triangles.
layout(location = 0) in vec4 in_head;   // xyz: position, m, W; w: radius, m
layout(location = 1) in vec4 in_color;  // rgb: sRGB; a: opacity
layout(location = 2) in vec3 in_way;    // m, W, vector from the streak's beginning to its head

layout(location = 0) out vec2 out_corner;
layout(location = 1) out vec4 out_color;

void main() {
  int k = gl_VertexIndex % 6;
  if (k > 2) k = k == 3 ? 2 : k == 4 ? 1 : 3;
  vec2 corner = vec2(k & 1, k >> 1) * 2.0 - 1.0;
  vec3 to_eye = normalize(frame.eye[VIEW].xyz - in_head.xyz);
  vec3 side = cross(in_way, to_eye);
  side = dot(side, side) > 1e-16 ? normalize(side) : normalize(cross(frame.up.xyz + 1e-3 * frame.key.xyz, to_eye));
  vec3 along = cross(to_eye, side);
  vec4 middle = frame.clip_from_world[VIEW] * vec4(in_head.xyz, 1.0);
  mat4 clip = frame.clip_from_world[VIEW];
  // A streak is drawn at least about one pixel wide. A thinner streak becomes transparent instead.
  float least = 0.7 * frame.picture.x * middle.w / length(vec3(clip[0][0], clip[1][0], clip[2][0]));
  float radius = max(in_head.w, least);
  vec3 p = in_head.xyz - (corner.y < 0.0 ? in_way : vec3(0.0)) + radius * (corner.x * side + corner.y * along);
  gl_Position = frame.clip_from_world[VIEW] * vec4(p, 1.0);
  gl_ClipDistance[0] = dot(frame.clip, vec4(p, 1.0));
  out_corner = corner;
  out_color = vec4(pow(in_color.rgb, vec3(2.2)), in_color.a * min(in_head.w / radius * 1.5, 1.0));
}
