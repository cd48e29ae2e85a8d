#version 460
#extension GL_EXT_multiview : require
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "lighting.glsl"

layout(location = 0) centroid in vec3 in_position;
layout(location = 1) centroid in vec4 in_normal;
layout(location = 2) centroid in vec3 in_light;
layout(location = 3) flat in uint in_pair;
layout(location = 4) centroid in vec3 in_mesh_position;
layout(location = 0) out vec4 out_color;

const uint kCaries = 3u, kPulp = 4u;

float hash(vec3 p) {
  p = fract(p * vec3(0.1031, 0.1030, 0.0973));
  p += dot(p, p.yxz + 33.33);
  return fract((p.x + p.y) * p.z);
}
float noise(vec3 p) {
  vec3 i = floor(p), f = fract(p);
  f = f * f * (3.0 - 2.0 * f);
  return mix(mix(mix(hash(i), hash(i + vec3(1, 0, 0)), f.x), mix(hash(i + vec3(0, 1, 0)), hash(i + vec3(1, 1, 0)), f.x), f.y),
             mix(mix(hash(i + vec3(0, 0, 1)), hash(i + vec3(1, 0, 1)), f.x), mix(hash(i + vec3(0, 1, 1)), hash(i + vec3(1, 1, 1)), f.x), f.y), f.z);
}

void main() {
  vec3 n = normalize(in_normal.xyz);
  vec3 v = normalize(frame.eye[VIEW].xyz - in_position);
  uint a = in_pair & 255u, b = in_pair >> 8;
  // Sharp to the pixel between sound tissues; decay has no edge.
  float soft = a == kCaries || b == kCaries || b == kPulp ? 0.35 : 0.0;
  float width = max(fwidth(in_light.z), soft) + 1e-5;
  float share = a == b ? 0.0 : clamp((in_light.z - 0.5) / width + 0.5, 0.0, 1.0);
  vec4 color = mix(frame.tissue_color[a], frame.tissue_color[b], share);
  vec4 look = mix(frame.tissue_look[a], frame.tissue_look[b], share);
  if (a == kCaries || b == kCaries) {
    // Decay is never even: darker and lighter by its softness.
    float decay = a == kCaries ? 1.0 - share : share;
    float grain = 0.65 * noise(in_mesh_position * 2600.0) + 0.35 * noise(in_mesh_position * 9000.0);
    color.rgb *= mix(1.0, mix(0.35, 1.55, grain), decay);
  }
  vec2 light = kLightPerVertex ? in_light.xy : visibility(in_position, n);
  out_color = vec4(tone_map(shade(n, v, Look(color.rgb, look.x, color.a, look.y, look.z), light, in_normal.w)), 1.0);
}
