#version 460
#extension GL_EXT_multiview : require
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) in vec3 in_ray;
layout(location = 0) out vec4 out_color;

// A dark studio wall at infinity: a gradient of direction, so both eyes see the same thing there.
void main() {
  vec3 r = normalize(in_ray);
  vec3 middle = normalize(frame.ray_middle[0].xyz);
  float glow = smoothstep(0.90, 1.0, dot(r, middle));
  float up = dot(r, frame.up.xyz) - dot(middle, frame.up.xyz);
  vec3 color = mix(vec3(0.010, 0.011, 0.013), vec3(0.050, 0.055, 0.064), glow) * (1.0 + 0.7 * up);
  // Half a step of noise hides the bands of 8 bits.
  float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
  out_color = vec4(color + noise * 0.0016, 1.0);
}
