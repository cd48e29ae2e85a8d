#version 460
#extension GL_EXT_multiview : require
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) in vec3 in_ray;
layout(location = 0) out vec4 out_color;

// A dark studio wall at infinity: a gradient of direction, so both eyes see the same thing there.
void main() {
  vec3 r = normalize(in_ray);
  vec3 middle = frame.glow.xyz;
  // Angle from the middle against the picture's own half height, so that every frustum has the same backdrop.
  float reach = length(frame.ray_y[0].xyz) / length(frame.ray_middle[0].xyz);
  vec3 off = r / dot(r, middle) - middle;
  float d = length(off + 0.25 * reach * frame.up.xyz) / (1.5 * reach);
  vec3 color = mix(vec3(0.0045, 0.0050, 0.0060), vec3(0.034, 0.038, 0.045), exp(-2.2 * d * d));
  // Half a step of noise hides the bands of 8 bits.
  float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
  out_color = vec4(color + noise * 0.0016, 1.0);
}
