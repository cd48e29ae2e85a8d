#version 460
#extension GL_EXT_multiview : require
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "lighting.glsl"
#include "metal.glsl"
#include "filtered.glsl"
#include "handpiece.glsl"

layout(location = 0) centroid in vec3 in_position;
layout(location = 1) centroid in vec3 in_normal;
layout(location = 2) centroid in vec3 in_around;
layout(location = 3) centroid in vec3 in_color;
layout(location = 4) centroid in vec4 in_look;
layout(location = 5) centroid in vec3 in_grip;
layout(location = 0) out vec4 out_color;

const float kKnurlPitch = 0.9e-3;  // m, same value as in engine/render/handpiece_mesh.h
const float kKnurlSlope = 0.5;     // largest slope of the knurl's pyramids

void main() {
  // Dither pattern, as in tool.frag. Pixels are discarded only after the derivatives (fwidth) below, which need the
  // neighbouring pixels.
  float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
  bool left_out = noise < object.view.y;
  float rim = 1.0;
  vec3 eye = frame.eye[VIEW].xyz;
  if (object.view.z > 0.0) {
    // Does not draw the part of the handpiece that lies in the cone between the eye and the working point.
    vec3 sight = frame.tool_head.xyz - eye, q = in_position - eye;
    float t = dot(q, sight) / dot(sight, sight), miss = length(q - t * sight) / max(t, 1e-6);
    float edge = miss / object.view.z;
    if (t < 1.0 && edge < 0.97) left_out = true;
    if (t < 1.0) rim = mix(0.45, 1.0, smoothstep(0.97, 1.03, edge));  // a thin dark edge, as of a cut
  }
  vec3 color = in_color;
  if (kPerPixel) {
    vec3 n = normalize(in_normal), v = normalize(eye - in_position), groove = normalize(in_around - n * dot(n, in_around));
    // The knurl: two sets of grooves at ±45°. Where a pitch is smaller than two pixels, the grooves become roughness.
    vec2 place = in_grip.xy / kKnurlPitch, footprint = fwidth(place);
    float seen = in_grip.z * (1.0 - smoothstep(0.2, 0.5, max(footprint.x, footprint.y)));
    vec2 phase = 2.0 * kPi * vec2(place.x + place.y, place.x - place.y);
    vec2 slope = kKnurlSlope * sin(phase);
    vec3 along = cross(n, groove);
    n = normalize(n + seen * (along * (slope.x + slope.y) + groove * (slope.x - slope.y)));
    groove = normalize(groove - n * dot(n, groove));
    float rough = mix(in_look.x, 0.6, in_grip.z * (1.0 - seen));
    float widened = filtered_width(0.0, n);
    if (left_out) discard;
    color = handpiece_light(in_position, n, v, groove, rough, widened, vec4(in_look.x, in_look.y * (1.0 - in_grip.z), in_look.zw), in_color);
  } else if (left_out) {
    discard;
  }
  out_color = vec4(tone_map(rim * color), 1.0);
}
