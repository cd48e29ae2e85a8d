#version 460
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) in vec2 in_atlas;
layout(location = 1) in vec4 in_color;
layout(location = 2) in vec4 in_box;
layout(location = 0) out vec4 out_color;

void main() {
  float alpha;
  if (in_box.w > 0.5) {
    // A box with round corners: distance to its edge in units of half its height.
    vec2 p = abs(in_box.xy) * vec2(in_box.z, 1.0);
    float corner = min(in_atlas.x, in_box.z);
    vec2 q = max(p - vec2(in_box.z, 1.0) + corner, 0.0);
    float d = length(q) - corner;
    alpha = clamp(0.5 - d / max(fwidth(d), 1e-6), 0.0, 1.0);
  } else {
    // Signed distance to the letter's edge: sharp at any size (Green 2007).
    float d = texture(font_atlas, in_atlas).r - 0.5;
    alpha = clamp(0.5 + d / max(fwidth(d), 1e-6), 0.0, 1.0);
  }
  alpha *= in_color.a;
  out_color = vec4(in_color.rgb * alpha, alpha);
}
