#version 460
#extension GL_EXT_multiview : require
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

// true: each particle is stored six times, once for each corner of two triangles. false: an instance is a triangle
// strip of four corners.
layout(constant_id = 6) const bool kCorners = false;

layout(location = 0) in vec4 in_particle;  // xyz: position, m, W; w: radius, m
layout(location = 1) in vec4 in_color;     // rgb: sRGB; a: opacity

layout(location = 0) out vec2 out_corner;
layout(location = 1) out vec4 out_color;

// Draws a quad that faces the eye and is at least about one pixel large. Smaller particles become transparent, because
// they would flicker otherwise.
void main() {
  int k = kCorners ? gl_VertexIndex % 6 : gl_VertexIndex;
  if (kCorners && k > 2) k = k == 3 ? 2 : k == 4 ? 1 : 3;
  vec2 corner = vec2(k & 1, k >> 1) * 2.0 - 1.0;
  vec3 to_eye = normalize(frame.eye[VIEW].xyz - in_particle.xyz);
  vec3 right = normalize(cross(frame.up.xyz + 1e-3 * frame.key.xyz, to_eye)), up = cross(to_eye, right);
  vec4 middle = frame.clip_from_world[VIEW] * vec4(in_particle.xyz, 1.0);
  // Size (m) of a pixel at the particle, computed from the first row of the projection.
  mat4 clip = frame.clip_from_world[VIEW];
  float least = 0.7 * frame.picture.x * middle.w / length(vec3(clip[0][0], clip[1][0], clip[2][0]));
  float radius = max(in_particle.w, least);
  float shown = min(in_particle.w * in_particle.w / (radius * radius) * 1.5, 1.0);
  gl_Position = frame.clip_from_world[VIEW] *
                vec4(in_particle.xyz + radius * (corner.x * right + corner.y * up), 1.0);
  gl_ClipDistance[0] = dot(frame.clip, vec4(in_particle.xyz, 1.0));
  out_corner = corner;
  out_color = vec4(pow(in_color.rgb, vec3(2.2)), in_color.a * shown);
}
