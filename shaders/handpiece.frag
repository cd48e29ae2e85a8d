#version 460
#extension GL_EXT_multiview : require
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "lighting.glsl"
#include "metal.glsl"

layout(location = 0) in vec3 in_position;
layout(location = 1) in vec3 in_normal;
layout(location = 2) in vec3 in_around;
layout(location = 3) in vec3 in_color;
layout(location = 4) in vec4 in_look;
layout(location = 5) in vec3 in_grip;
layout(location = 0) out vec4 out_color;

const float kKnurlPitch = 0.9e-3;  // m, same value as in engine/render/handpiece_mesh.h
const float kKnurlSlope = 0.5;     // largest slope of the knurl's pyramids

void main() {
  // Dither as in tool.frag.
  float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
  if (noise < object.view.y) discard;
  vec3 eye = frame.eye[VIEW].xyz;
  if (object.view.z > 0.0) {
    // Leave out the part of the handpiece in the cone between the eye and the working point.
    vec3 sight = frame.tool_head.xyz - eye, q = in_position - eye;
    float t = dot(q, sight) / dot(sight, sight), miss = length(q - t * sight) / max(t, 1e-6);
    if (t < 1.0 && miss < object.view.z * (0.94 + 0.06 * noise)) discard;
  }
  vec3 n = normalize(in_normal), v = normalize(eye - in_position), groove = normalize(in_around - n * dot(n, in_around));
  float rough = in_look.x, brushed = in_look.y;
  // The knurl: two sets of grooves at ±45°. Where a pitch is smaller than two pixels, the grooves become roughness.
  vec2 place = in_grip.xy / kKnurlPitch;
  vec2 footprint = fwidth(place);
  if (in_grip.z > 0.0) {
    float seen = in_grip.z * (1.0 - smoothstep(0.2, 0.5, max(footprint.x, footprint.y)));
    vec2 phase = 2.0 * kPi * vec2(place.x + place.y, place.x - place.y);
    vec2 slope = kKnurlSlope * sin(phase);
    vec3 along = cross(n, groove);
    n = normalize(n + seen * (along * (slope.x + slope.y) + groove * (slope.x - slope.y)));
    groove = normalize(groove - n * dot(n, groove));
    rough = mix(rough, 0.6, in_grip.z * (1.0 - seen));
    brushed *= 1.0 - in_grip.z;
  }
  vec3 color;
  if (in_look.z > 0.5)
    color = brushed_metal(n, v, groove, brushed, rough, in_color);
  else
    color = shade(n, n, v, Look(in_color, rough, 0.0, 0.0, 0.0), vec2(1.0));
  out_color = vec4(tone_map(color + in_look.w * in_color), 1.0);
}
