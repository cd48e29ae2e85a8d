#version 460
#extension GL_EXT_multiview : require
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "lighting.glsl"

layout(location = 0) in vec2 in_place;
layout(location = 1) in vec3 in_position;
layout(location = 0) out vec4 out_color;

// The reflected scene was drawn for this eye at the same pixel. Fog blurs it and adds a haze.
void main() {
  vec2 size = vec2(textureSize(reflection, 0).xy);
  vec2 at = gl_FragCoord.xy / size;
  if (frame.mirror.z < 1.0) {
    // A concave mirror magnifies the reflected scene about the middle of the glass.
    vec4 middle = frame.clip_from_world[VIEW] *
                  vec4(object.world_row[0].w, object.world_row[1].w, object.world_row[2].w, 1.0);
    vec2 center = 0.5 + 0.5 * middle.xy / middle.w;
    at = center + frame.mirror.z * (at - center);
  }
  float r = length(in_place), fog = clamp(frame.mirror.y, 0.0, 1.0);
  // Breath on the glass clears unevenly, and last in the middle.
  vec2 q = in_place * 3.0;
  float cloud = 0.5 + 0.25 * sin(q.x * 2.1 + 1.3 * sin(q.y * 1.7)) + 0.25 * sin(q.y * 2.7 + 1.1 * sin(q.x * 1.9));
  float veil = fog * mix(0.75 + 0.25 * cloud, 1.0, fog) * smoothstep(1.15, 0.2 + 0.6 * fog, r * (1.2 - 0.4 * fog));
  vec3 color = vec3(0.0);
  if (veil > 0.003) {
    float spread = 0.030 * veil;
    for (int i = 0; i < 16; ++i)
      color += texture(reflection, vec3(at + spread * disc(i, 16) * vec2(size.y / size.x, 1.0), VIEW)).rgb / 16.0;
  } else {
    color = texture(reflection, vec3(at, VIEW)).rgb;
  }
  // A front-coated mirror reflects nine tenths of the light; its ground edge is darker.
  color *= 0.92 * mix(0.55, 1.0, smoothstep(1.0, 0.985, r));
  vec3 breath = vec3(0.30, 0.33, 0.36) * (0.6 + 0.4 * max(dot(frame.up.xyz, vec3(object.world_row[0].z, object.world_row[1].z, object.world_row[2].z)), 0.0));
  color = mix(color, breath + 0.35 * color, 0.85 * veil);
  out_color = vec4(color, 1.0);
}
