#version 460
#extension GL_EXT_multiview : require
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "lighting.glsl"

layout(location = 0) in vec3 in_position;
layout(location = 1) in vec4 in_normal;
layout(location = 2) in vec4 in_color;
layout(location = 3) in vec3 in_look;
layout(location = 4) in vec2 in_light;
layout(location = 0) out vec4 out_color;

void main() {
  vec3 n = normalize(in_normal.xyz);
  vec3 v = normalize(frame.eye[VIEW].xyz - in_position);
  Look look = Look(in_color.rgb, in_look.x, in_color.a, in_look.y, in_look.z);
  vec2 light = kLightPerVertex ? in_light : visibility(in_position, n);
  out_color = vec4(tone_map(shade(in_position, n, v, look, light, in_normal.w)), 1.0);
}
