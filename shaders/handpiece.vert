#version 460
#extension GL_EXT_multiview : require
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "lighting.glsl"
#include "metal.glsl"
#include "handpiece.glsl"

layout(location = 0) in vec3 in_position;
layout(location = 1) in vec3 in_normal;
layout(location = 2) in vec3 in_middle;  // m, point on the part's path
layout(location = 3) in vec3 in_around;  // unit direction around the part
layout(location = 4) in vec3 in_color;
layout(location = 5) in vec4 in_look;  // x: roughness; y: brushed; z: metal; w: glow
layout(location = 6) in vec3 in_grip;  // x, y: m, position along the path and around the part; z: depth of the knurl

layout(location = 0) centroid out vec3 out_position;
layout(location = 1) centroid out vec3 out_normal;
layout(location = 2) centroid out vec3 out_around;
layout(location = 3) centroid out vec3 out_color;
layout(location = 4) centroid out vec4 out_look;
layout(location = 5) centroid out vec3 out_grip;

vec3 in_world(vec4 p) {
  return vec3(dot(object.world_row[0], p), dot(object.world_row[1], p), dot(object.world_row[2], p));
}

void main() {
  // Parts are drawn at least 1.5 pixels thick, as in tool.vert.
  mat4 clip = frame.clip_from_world[VIEW];
  vec3 middle = in_world(vec4(in_middle, 1.0)), offset = in_world(vec4(in_position - in_middle, 0.0));
  float least = 0.75 * frame.picture.x * (clip * vec4(middle, 1.0)).w / length(vec3(clip[0][0], clip[1][0], clip[2][0]));
  float radius = length(offset);
  if (radius > 0.0) offset *= max(least / radius, 1.0);
  out_position = middle + offset;
  gl_Position = clip * vec4(out_position, 1.0);
  gl_ClipDistance[0] = dot(frame.clip, vec4(out_position, 1.0));
  out_normal = in_world(vec4(in_normal, 0.0));
  out_around = in_world(vec4(in_around, 0.0));
  out_color = in_color;
  if (!kPerPixel) {
    vec3 n = normalize(out_normal), v = normalize(frame.eye[VIEW].xyz - out_position);
    vec3 groove = normalize(out_around - n * dot(n, out_around));
    out_color = handpiece_light(out_position, n, v, groove, mix(in_look.x, 0.6, in_grip.z), 0.0, in_look, in_color);
  }
  out_look = in_look;
  out_grip = in_grip;
}
