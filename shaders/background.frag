#version 460
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) in vec2 in_place;
layout(location = 0) out vec4 out_color;

// The background: a dark studio wall, or black. It is equal for both eyes, because it lies on the screen plane, where
// disparity is zero.
void main() {
  vec2 p = in_place - vec2(0.0, -0.15);
  vec3 color = mix(vec3(0.0045, 0.0050, 0.0060), vec3(0.036, 0.040, 0.047), exp(-1.1 * dot(p, p)));
  // Noise of half a step of an 8-bit colour hides the visible steps (banding).
  float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
  out_color = vec4((color + noise * 0.0016) * frame.background.x, frame.background.w);
}
