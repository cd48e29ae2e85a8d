#version 460
// Two eyes into one screen. Bytes go through unchanged where the sizes fit, so each layout decodes back exactly.
layout(set = 0, binding = 0) uniform sampler2DArray eyes;
layout(push_constant) uniform Push {
  ivec4 place;  // xy: target pixels, z: layout as in display_rig.h (8: one layer to all of the target), w: first row or layer
};
layout(location = 0) out vec4 out_color;

const int kMono = 0, kSideBySide = 1, kTopBottom = 2, kRowInterleaved = 3, kAnaglyph = 4, kTwoOutputs = 5,
          kFrameSequential = 6;

vec3 eye(int layer, ivec2 pixel, ivec2 size) {
  ivec3 have = textureSize(eyes, 0);
  layer = min(layer, have.z - 1);
  if (have.xy == size) return texelFetch(eyes, ivec3(pixel, layer), 0).rgb;
  return texture(eyes, vec3((vec2(pixel) + 0.5) / vec2(size), layer)).rgb;
}

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy), size = place.xy;
  vec3 color;
  if (place.z == kSideBySide || place.z == kTwoOutputs) {
    int half_width = size.x / 2;
    color = eye(p.x < half_width ? 0 : 1, ivec2(p.x % half_width, p.y), ivec2(half_width, size.y));
  } else if (place.z == kTopBottom || place.z == kFrameSequential) {
    int half_height = size.y / 2;
    color = eye(p.y < half_height ? 0 : 1, ivec2(p.x, p.y % half_height), ivec2(size.x, half_height));
  } else if (place.z == kRowInterleaved) {
    color = eye((p.y + place.w) & 1, p, size);
  } else if (place.z == kAnaglyph) {
    color = vec3(eye(0, p, size).r, eye(1, p, size).gb);
  } else if (place.z == kMono) {
    color = eye(0, p, size);
  } else {
    color = eye(place.w, p, size);
  }
  out_color = vec4(color, 1.0);
}
