#version 460
// Composes the pictures of two eyes into one screen. Bytes are copied unchanged if the sizes are equal. Conditions
// known in advance are constants, because a software renderer executes every branch for every pixel.
layout(set = 0, binding = 0) uniform sampler2DArray eyes;
layout(push_constant) uniform Push {
  // xy: upper left corner of the eye's region, pixels of the target; z: index of the drawn layer, or parity of the
  // first row if rows alternate; w: index of the last layer
  ivec4 place;
};
layout(constant_id = 0) const int kMix = 0;  // a value of Mix in engine/display/compose/places.h
layout(constant_id = 1) const bool kFits = true;  // true: source and target have the same size
layout(constant_id = 2) const bool kWarped = false;
// A bent panel or mirror (Warp in engine/display/display_rig.h): places in the left and the right eye's picture
layout(set = 0, binding = 2) readonly buffer Warp { vec2 places[]; };
layout(location = 0) in vec2 in_place;
layout(location = 0) out vec4 out_color;

const int kOneEye = 0, kRows = 1, kAnaglyph = 2;

const int kWarpSide = 33;
vec2 warped(int eye) {
  vec2 grid = in_place * float(kWarpSide - 1);
  ivec2 cell = min(ivec2(grid), ivec2(kWarpSide - 2));
  vec2 on = grid - vec2(cell);
  int first = (eye * kWarpSide + cell.y) * kWarpSide + cell.x;
  return mix(mix(places[first], places[first + 1], on.x),
             mix(places[first + kWarpSide], places[first + kWarpSide + 1], on.x), on.y);
}

vec3 eye(int layer, ivec2 pixel) {
  if (kWarped) return textureLod(eyes, vec3(warped(layer), layer), 0.0).rgb;
  if (kFits) return texelFetch(eyes, ivec3(pixel, layer), 0).rgb;
  return textureLod(eyes, vec3(in_place, layer), 0.0).rgb;
}

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy) - place.xy;
  vec3 color;
  if (kMix == kOneEye) {
    color = eye(place.z, p);
  } else if (kMix == kRows) {
    color = eye(min((p.y + place.z) & 1, place.w), p);
  } else {
    color = vec3(eye(0, p).r, eye(place.w, p).gb);
  }
  out_color = vec4(color, 1.0);
}
